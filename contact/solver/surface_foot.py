# SPDX-License-Identifier: LGPL-3.0-or-later
"""Where a point stands over a surface of triangles, as implicit steps ask for it.

`world` is a SurfaceWorld (surface_obstacle.py).
"""

from typing import Any

import numpy as np

from contact.geometry.triangle_mesh.carried import drift
from contact.geometry.triangle_mesh.closest import closest, closest_facing
from contact.kernel import kernel

from .surface_planes import gap_at


@kernel(makes_arrays=False)
def clear(x: np.ndarray, i: int, offset: float, path: float, world: Any) -> float:
    """What is left [m] between node i at x and contact where the surface has gone `path` [m]."""
    look, gone = world.look[i], 0.0
    for c in range(3):
        gone += (x[c] - look[c]) ** 2
    return look[3] - offset - np.sqrt(gone) - (path - look[4])


@kernel(makes_arrays=False)
def foot(x0: float, x1: float, x2: float, guess: int, placed: Any, world: Any) -> tuple:
    """Triangle below x on a surface placed so; distance [m], normal (3), flat distance [m]."""
    mesh = world.mesh
    t, square = closest(mesh, placed, x0, x1, x2, -1, guess, world.stack, world.bounds)
    found = gap_at(mesh, placed, world.smooth[0], -1, t, square, x0, x1, x2)
    return np.int64(found[0]), found[3], found[4], found[5], found[6], np.sqrt(square)


@kernel(makes_arrays=False)
def foot_facing(
    x0: float,
    x1: float,
    x2: float,
    n0: float,
    n1: float,
    n2: float,
    cosine: float,
    limit: float,
    world: Any,
) -> tuple:
    """The same at the end of a step of what faces another way, see `closest_facing`; -1: none."""
    mesh, end = world.mesh, world.end
    t, square = closest_facing(
        mesh, end, x0, x1, x2, -1, n0, n1, n2, cosine, limit, world.stack, world.bounds
    )
    if t < 0:
        return np.int64(-1), 0.0, 0.0, 0.0, 0.0
    found = gap_at(mesh, end, world.smooth[0], -1, t, square, x0, x1, x2)
    return np.int64(found[0]), found[3], found[4], found[5], found[6]


@kernel(makes_arrays=False)
def way_of(x: np.ndarray, t: int, world: Any) -> tuple[float, float, float]:
    """Way of the point x over the step as triangle t takes it."""
    before, after, corners = world.start.vertices, world.end.vertices, world.mesh.triangles
    return drift(before, after, corners, t, x[0], x[1], x[2])
