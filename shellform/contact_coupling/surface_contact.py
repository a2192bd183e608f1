# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contact of a sheet with a moving closed surface of triangles: what explicit steps are given.

The sheet meets the surface at its nodes (contact/solver/surface_correction.py).
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from contact.body.flesh_bed import Flesh
from contact.body.segments import Body
from contact.body.surface_motion import SurfaceMotion
from contact.solver.surface_correction import SurfaceCorrection
from contact.solver.union_correction import UnionCorrection
from contact.solver.velocity_correction import VelocityCorrection


def correction_of(
    surface: SurfaceMotion,
    body: Any,
    nodes: int,
    friction: Any,
    offset: float,
    fixed: np.ndarray,
    recovery: float,
    smooth: bool,
    samples: int | str,
    flesh_stiffness: float | None,
    shapes: Sequence[str],
    flesh: Flesh | None,
    areal_mass: float,
) -> Any:
    """The correction for a contact as described, see `Contact`.

    Raises
    ------
    ValueError for what surfaces of triangles do not know: samples inside cells, flesh between two
    parts only, and shapes beside flesh; for shapes without a body that has them
    """
    if samples not in ("nodes", 0):
        raise ValueError(
            f"a surface of triangles is met at nodes, not at {samples} samples a cell: leave "
            "`samples` out"
        )
    if flesh_stiffness is not None:
        raise ValueError(
            "a surface of triangles has no flesh between its parts alone, as of "
            f"{flesh_stiffness} Pa/m: leave `flesh_stiffness` out, or give `flesh`"
        )
    owner = body if isinstance(body, Body) else None
    how: dict[str, Any] = {"fixed": fixed, "recovery": recovery, "smooth": smooth}
    if flesh is not None:
        if shapes:
            raise ValueError(
                f"the shapes of {', '.join(shapes)} are met as hard ones, and the surface has "
                "flesh: leave `shapes` or `flesh` out"
            )
        # its kernels are loaded for flesh only
        from contact.solver.surface_flesh import SurfaceFleshCorrection

        return SurfaceFleshCorrection(
            surface, nodes, owner, friction, offset, **how, flesh=flesh, areal_mass=areal_mass
        )
    skin = SurfaceCorrection(surface, nodes, owner, friction, offset, **how)
    if not shapes:
        return skin
    if owner is None:
        raise ValueError(
            f"the shapes of {', '.join(shapes)} are those of a body: give it, as "
            "Contact(body, surface=surface, shapes=...)"
        )
    hard = VelocityCorrection(owner, nodes, friction, offset, fixed=fixed, recovery=recovery)
    return UnionCorrection(hard, skin, shapes)
