# SPDX-License-Identifier: LGPL-3.0-or-later
"""A shirt made ready for dressing: which of its openings are neck, hem and cuffs. z is up.

The neck is the highest opening, the hem the lowest, a cuff or armhole on each side between them, y
to the wearer's left.
"""

from __future__ import annotations

import numpy as np

from meshes.surface import Surface
from meshes.topology import segments_of_line
from meshes.validity import MeshError

from .placing import openings
from .prepare import outward


def prepare_shirt(surface: Surface) -> Surface:
    """The shirt facing outward, with the edges 'neck', 'hem', 'left_cuff' and 'right_cuff'.

    Parameters
    ----------
    surface : Surface about a standing wearer, with a warp; x forward, y to the left, z up [m]

    Raises
    ------
    MeshError : for a faulty mesh, several pieces, other openings than these four
    """
    surface, _ = outward(surface, "at neck, hem and cuffs")
    large = openings(surface)
    middles = np.array([surface.points[loop].mean(axis=0) for loop in large])
    if len(large) != 4:
        places = ", ".join(str(np.round(m, 2).tolist()) for m in middles)
        raise MeshError(
            f"{surface.source}: what hangs on the shoulders has four openings, neck, hem and two "
            f"for the arms, and this has {len(large)}, about {places} m: sew what is open, or give "
            'hangs = "waist" under [garment].'
        )
    order = np.argsort(middles[:, 2])
    sides = sorted(order[1:3], key=lambda k: middles[k, 1])
    if not middles[sides[0], 1] < 0.0 < middles[sides[1], 1]:
        raise MeshError(
            f"{surface.source}: the openings for the arms, about y = {middles[sides[0], 1]:.2f} "
            f"and {middles[sides[1], 1]:.2f} m, are not left and right of the body: place its "
            "panels so that y is to the wearer's left."
        )
    named = {"neck": order[3], "hem": order[0], "right_cuff": sides[0], "left_cuff": sides[1]}
    seams = {k: v for k, v in surface.edges.items() if not k.startswith("boundary_")}
    lines = {name: segments_of_line(np.append(large[k], large[k][0])) for name, k in named.items()}
    return surface.replace(edges={**seams, **lines})
