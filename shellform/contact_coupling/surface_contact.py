# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contact of a sheet with a moving closed surface of triangles: what explicit steps are given.

The sheet meets the surface at its nodes (contact/solver/surface_correction.py).
"""

from typing import Any

import numpy as np

from contact.body.segments import Body
from contact.body.surface_motion import SurfaceMotion
from contact.solver.surface_correction import SurfaceCorrection


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
) -> SurfaceCorrection:
    """The correction for a contact as described, see `Contact`.

    Raises
    ------
    ValueError for what surfaces of triangles do not know: samples inside cells, and soft flesh
    """
    if samples not in ("nodes", 0):
        raise ValueError(
            f"a surface of triangles is met at nodes, not at {samples} samples a cell: leave "
            "`samples` out"
        )
    if flesh_stiffness is not None:
        raise ValueError(
            f"a surface of triangles knows no soft flesh between its parts, as of "
            f"{flesh_stiffness} Pa/m: leave `flesh_stiffness` out"
        )
    return SurfaceCorrection(
        surface,
        nodes,
        body if isinstance(body, Body) else None,
        friction,
        offset,
        fixed=fixed,
        recovery=recovery,
        smooth=smooth,
    )
