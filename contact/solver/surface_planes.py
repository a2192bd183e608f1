# SPDX-License-Identifier: LGPL-3.0-or-later
"""Planes that bound the step of a node over a moving closed surface of triangles, Eq. 15.

A plane n . step >= bound stands over a triangle, which carries it along. One of a place found at
the start has the normal that the surface has there at the end of the step.

Where two parts of the skin pass through each other, there is no place for a node between them.
Their planes together would be a wedge of hard walls, which resists any pull along it. Flesh gives
way: such a node is squeezed, and only the part that it touched last keeps it on its near side.
"""

from typing import Any

import numpy as np

from contact.geometry.triangle_mesh.carried import drift, turned_with
from contact.geometry.triangle_mesh.smooth import flat_gap, normal_at, smooth_gap
from contact.kernel import kernel

PLANES = 8  # of a node, at most
INSIDE = 1e-9  # m: ends less deep than this are no reason for another plane
OPPOSED = -0.8  # cosine between normals of two parts that close on a node that lies in both


@kernel(makes_arrays=False)
def gap_at(
    mesh: Any,
    placed: Any,
    smooth: bool,
    asked: int,
    t: int,
    square: float,
    x0: float,
    x1: float,
    x2: float,
) -> tuple[int, float, float, float, float, float, float, bool]:
    """Distance of x to the surface with the closest triangle t at sqrt(square) [m].

    asked : sets of triangles that count.

    Returns triangle, b1, b2, distance [m], unit normal (3), whether the normal is a smooth one.
    """
    if smooth:
        over, b1, b2, gap, n0, n1, n2 = smooth_gap(mesh, placed, t, square, x0, x1, x2)
        if over >= 0 and mesh.sets[over] & asked:
            return over, b1, b2, gap, n0, n1, n2, True
    b1, b2, gap, n0, n1, n2 = flat_gap(mesh, placed, t, x0, x1, x2)
    return t, b1, b2, gap, n0, n1, n2, False


@kernel(makes_arrays=False)
def add_plane(
    x: np.ndarray,
    t: int,
    n0: float,
    n1: float,
    n2: float,
    u0: float,
    u1: float,
    u2: float,
    height: float,
    depth: float,
    owner: int,
    work: Any,
    planes: np.ndarray,
    over: np.ndarray,
) -> None:
    """Add the plane n . (step - drift) >= height over triangle t."""
    k = work.count
    plane = planes[k]
    plane.owner, plane.depth, plane.push = owner, depth, 0.0
    plane.normal[0], plane.normal[1], plane.normal[2] = n0, n1, n2
    plane.drift[0], plane.drift[1], plane.drift[2] = u0, u1, u2
    plane.bound = height + n0 * u0 + n1 * u1 + n2 * u2
    for c in range(3):
        plane.friction[c] = 0.0
    over[k] = t
    work.count = k + 1


@kernel(makes_arrays=False)
def add_carried(
    x: np.ndarray,
    found: tuple,
    mesh: Any,
    start: Any,
    end: Any,
    owners: np.ndarray,
    work: Any,
    planes: np.ndarray,
    over: np.ndarray,
) -> float:
    """Add the plane at a place found at the start, as the surface carries it; its depth [m].

    found : see `gap_at`
    """
    t, w1, w2, distance, n0, n1, n2, rounded = found
    corners, before, after = mesh.triangles, start.vertices, end.vertices
    u0, u1, u2 = drift(before, after, corners, t, x[0], x[1], x[2])
    if rounded:
        n0, n1, n2, _ = normal_at(mesh, end, t, w1, w2)
    else:
        n0, n1, n2 = turned_with(before, after, corners, t, n0, n1, n2)
    depth = work.offset - distance
    height = min(depth, work.recovery)
    add_plane(x, t, n0, n1, n2, u0, u1, u2, height, depth, owners[t], work, planes, over)
    return depth


@kernel(makes_arrays=False)
def _cosine(p, q):
    return p[0] * q[0] + p[1] * q[1] + p[2] * q[2]


@kernel(makes_arrays=False)
def hold(k: int, work: Any, planes: np.ndarray, over: np.ndarray) -> None:
    """Leave plane k alone, which lets the node go no deeper and moves it out later."""
    p, q = planes[0], planes[k]
    p.owner, p.depth, over[0] = q.owner, q.depth, over[k]
    p.bound = q.bound - max(0.0, min(q.depth, work.recovery))
    for c in range(3):
        p.normal[c], p.drift[c] = q.normal[c], q.drift[c]
    work.count = 1


@kernel(makes_arrays=False)
def squeezed(last: int, work: Any, planes: np.ndarray, over: np.ndarray) -> bool:
    """Whether a node lies inside both parts of the first two planes; then one of them is left.

    Both sides of one thin part look alike: parts are told by their owners.

    last : owner touched in the last step, whose plane stays; else the first, which is nearer
    """
    p, q = planes[0], planes[1]
    opposed = p.owner != q.owner and _cosine(p.normal, q.normal) < OPPOSED
    if not opposed or min(p.depth, q.depth) <= INSIDE:
        return False
    hold(1 if q.owner == last and p.owner != last else 0, work, planes, over)
    return True
