# SPDX-License-Identifier: LGPL-3.0-or-later
"""The smooth surface that contact meets: triangles raised to where their normals tell.

A triangle has the unit normals n_i at its vertices v_i (placed.py). Of a point x is sought

    x = p(b) + z N(b),  p = sum_i b_i v_i,  N = sum_i b_i n_i,  sum_i b_i = 1,

which has x in the triangle of the corners v_i + z n_i: a cubic in z. N is continuous over the
edges, and so are b and z: no jumps where the nearest triangle changes. The surface is raised over p
along N by

    s(b) = sum_{i<j} b_i b_j (a_ij + a_ji + (a_ij - a_ji) (b_i - b_j)) / (1 + |N|),
    a_ij = (v_i - v_j) . n_i,

along an edge the cubic of the slopes that the normals tell at its ends. It is exact on spheres and
along circles, where v_i - v_j = R (n_i - n_j). The distance of x is then g = z |N| - s and its
normal N/|N|: the same from both sides of an edge, exact on a sphere, and elsewhere of second order
in the size of triangles.
"""

from typing import Any

import numpy as np

from contact.kernel import kernel

from .closest import face_normal, on_triangle, pseudo_normal
from .placed import know_normal

WALKS = 12  # triangles looked at
OUTSIDE = 1e-10  # of a weight, below zero
MOST = 3.0  # flat distances that the place found may be away
NEWTON = 1e-8  # m
TOUCHING = 1e-7  # m: below it the direction to the closest point has no digits left


@kernel(makes_arrays=False)
def _place(v, normals, corners, t, x0, x1, x2):
    """z [m], weights b1, b2 of x in the prism of triangle t; the sign of its height over t.

    Not numbers where there are none.
    """
    i, j, k = corners[t, 0], corners[t, 1], corners[t, 2]
    q0, q1, q2 = x0 - v[i, 0], x1 - v[i, 1], x2 - v[i, 2]
    m0, m1, m2 = normals[i, 0], normals[i, 1], normals[i, 2]
    a0, a1, a2 = v[j, 0] - v[i, 0], v[j, 1] - v[i, 1], v[j, 2] - v[i, 2]
    c0, c1, c2 = v[k, 0] - v[i, 0], v[k, 1] - v[i, 1], v[k, 2] - v[i, 2]
    d0, d1, d2 = normals[j, 0] - m0, normals[j, 1] - m1, normals[j, 2] - m2
    e0, e1, e2 = normals[k, 0] - m0, normals[k, 1] - m1, normals[k, 2] - m2
    # normal of the raised triangle: f + z g + z^2 h
    f0, f1, f2 = a1 * c2 - a2 * c1, a2 * c0 - a0 * c2, a0 * c1 - a1 * c0
    g0 = a1 * e2 - a2 * e1 + d1 * c2 - d2 * c1
    g1 = a2 * e0 - a0 * e2 + d2 * c0 - d0 * c2
    g2 = a0 * e1 - a1 * e0 + d0 * c1 - d1 * c0
    h0, h1, h2 = d1 * e2 - d2 * e1, d2 * e0 - d0 * e2, d0 * e1 - d1 * e0
    p0 = f0 * q0 + f1 * q1 + f2 * q2
    p1 = g0 * q0 + g1 * q1 + g2 * q2 - (f0 * m0 + f1 * m1 + f2 * m2)
    p2 = h0 * q0 + h1 * q1 + h2 * q2 - (g0 * m0 + g1 * m1 + g2 * m2)
    p3 = -(h0 * m0 + h1 * m1 + h2 * m2)
    # begun on the side of the triangle that x is on: the cubic has other roots, on the other side
    z = (
        3.0
        * p0
        / (f0 * (3.0 * m0 + d0 + e0) + f1 * (3.0 * m1 + d1 + e1) + f2 * (3.0 * m2 + d2 + e2))
    )
    for _ in range(20):
        slope = p1 + z * (2.0 * p2 + 3.0 * z * p3)
        change = (p0 + z * (p1 + z * (p2 + z * p3))) / slope
        z -= change
        if abs(change) < NEWTON:  # its square over a radius of curvature is left
            break
    f0, f1, f2 = f0 + z * (g0 + z * h0), f1 + z * (g1 + z * h1), f2 + z * (g2 + z * h2)
    a0, a1, a2 = a0 + z * d0, a1 + z * d1, a2 + z * d2
    c0, c1, c2 = c0 + z * e0, c1 + z * e1, c2 + z * e2
    q0, q1, q2 = q0 - z * m0, q1 - z * m1, q2 - z * m2
    size = f0 * f0 + f1 * f1 + f2 * f2
    b1 = f0 * (q1 * c2 - q2 * c1) + f1 * (q2 * c0 - q0 * c2) + f2 * (q0 * c1 - q1 * c0)
    b2 = f0 * (a1 * q2 - a2 * q1) + f1 * (a2 * q0 - a0 * q2) + f2 * (a0 * q1 - a1 * q0)
    return z, b1 / size, b2 / size, p0


@kernel(makes_arrays=False)
def know_three(mesh: Any, placed: Any, t: int) -> None:
    """Fill the normals of the corners of triangle t that are not known."""
    corners, known = mesh.triangles, placed.known
    # asked here: a call that hands over all arrays costs more than the rest
    if not (known[corners[t, 0]] and known[corners[t, 1]] and known[corners[t, 2]]):
        for k in range(3):
            know_normal(mesh, placed, corners[t, k])


@kernel(makes_arrays=False)
def _normal(m, corners, t, b1, b2):
    """N/|N| and |N| at a place of triangle t, from known normals of vertices (nv, 3)."""
    i, j, k, b0 = corners[t, 0], corners[t, 1], corners[t, 2], 1.0 - b1 - b2
    n0 = b0 * m[i, 0] + b1 * m[j, 0] + b2 * m[k, 0]
    n1 = b0 * m[i, 1] + b1 * m[j, 1] + b2 * m[k, 1]
    n2 = b0 * m[i, 2] + b1 * m[j, 2] + b2 * m[k, 2]
    size = np.sqrt(n0 * n0 + n1 * n1 + n2 * n2)
    return n0 / size, n1 / size, n2 / size, size


@kernel(makes_arrays=False)
def normal_at(
    mesh: Any, placed: Any, t: int, b1: float, b2: float
) -> tuple[float, float, float, float]:
    """Unit normal of the smooth surface over a place of triangle t, and |N|."""
    know_three(mesh, placed, t)
    return _normal(placed.normals, mesh.triangles, t, b1, b2)


@kernel(makes_arrays=False)
def _slopes(v, m, i, j):
    """a_ij and a_ji [m]."""
    w0, w1, w2 = v[i, 0] - v[j, 0], v[i, 1] - v[j, 1], v[i, 2] - v[j, 2]
    one = w0 * m[i, 0] + w1 * m[i, 1] + w2 * m[i, 2]
    return one, -(w0 * m[j, 0] + w1 * m[j, 1] + w2 * m[j, 2])


@kernel(makes_arrays=False)
def _raised(v, m, corners, t, b1, b2, size):
    """s [m] at a place of triangle t with |N| = size."""
    i, j, k, b0 = corners[t, 0], corners[t, 1], corners[t, 2], 1.0 - b1 - b2
    one, other = _slopes(v, m, i, j)
    total = b0 * b1 * (one + other + (one - other) * (b0 - b1))
    one, other = _slopes(v, m, j, k)
    total += b1 * b2 * (one + other + (one - other) * (b1 - b2))
    one, other = _slopes(v, m, k, i)
    total += b2 * b0 * (one + other + (one - other) * (b2 - b0))
    return total / (1.0 + size)


@kernel(makes_arrays=False)
def most_raised(mesh: Any, placed: Any) -> float:
    """About the greatest s [m] anywhere, rather more than less."""
    most = 0.0
    for t in range(len(mesh.triangles)):
        know_three(mesh, placed, t)
        for k in range(3):
            i, j = mesh.triangles[t, k], mesh.triangles[t, (k + 1) % 3]
            one, other = _slopes(placed.vertices, placed.normals, i, j)
            most = max(most, one / 3.0, other / 3.0)
    return most


@kernel(makes_arrays=False)
def smooth_gap(
    mesh: Any, placed: Any, t: int, square: float, x0: float, x1: float, x2: float
) -> tuple[int, float, float, float, float, float, float]:
    """Distance of x to the smooth surface, where t is the closest triangle at sqrt(square) [m].

    Returns the triangle it is over, or -1 where there is none; b1, b2; distance [m]; unit normal.
    """
    v, corners = placed.vertices, mesh.triangles
    limit = MOST * np.sqrt(square) + TOUCHING
    came_from, side = -1, 0.0
    for _ in range(WALKS):
        know_three(mesh, placed, t)
        z, b1, b2, above = _place(v, placed.normals, corners, t, x0, x1, x2)
        if side == 0.0:
            side = 1.0 if above > 0.0 else -1.0
        # what is above its closest triangle is outside
        if not -TOUCHING <= side * z <= limit:
            return -1, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        b0 = 1.0 - b1 - b2
        edge, least = -1, -OUTSIDE
        for k, b in ((1, b0), (2, b1), (0, b2)):  # edge k is across from corner k + 2
            if b < least and mesh.neighbours[t, k] != came_from:
                edge, least = k, b
        if edge < 0:
            if min(b0, b1, b2) < -1e-6:  # between two prisms that each say the other
                return -1, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
            n0, n1, n2, size = _normal(placed.normals, corners, t, b1, b2)
            gap = z * size - _raised(v, placed.normals, corners, t, b1, b2, size)
            return t, b1, b2, gap, n0, n1, n2
        came_from, t = t, mesh.neighbours[t, edge]
    return -1, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0


@kernel(makes_arrays=False)
def flat_gap(
    mesh: Any, placed: Any, t: int, x0: float, x1: float, x2: float
) -> tuple[float, float, float, float, float, float]:
    """Weights b1, b2 of the closest point of x, which lies in t; signed distance [m]; normal."""
    v, corners = placed.vertices, mesh.triangles
    square, u, w, where = on_triangle(v, corners, t, x0, x1, x2)
    n0, n1, n2 = pseudo_normal(mesh, v, t, where)
    i, j, k, first = corners[t, 0], corners[t, 1], corners[t, 2], 1.0 - u - w
    d0 = x0 - (first * v[i, 0] + u * v[j, 0] + w * v[k, 0])
    d1 = x1 - (first * v[i, 1] + u * v[j, 1] + w * v[k, 1])
    d2 = x2 - (first * v[i, 2] + u * v[j, 2] + w * v[k, 2])
    distance = np.sqrt(square)
    if n0 * d0 + n1 * d1 + n2 * d2 < 0.0:
        distance = -distance
    if where > 0 and abs(distance) > TOUCHING:
        return u, w, distance, d0 / distance, d1 / distance, d2 / distance
    size = np.sqrt(n0 * n0 + n1 * n1 + n2 * n2)
    if not size > 0.0:
        n0, n1, n2, size = face_normal(v, corners, t)
        size = 1.0
    return u, w, distance, n0 / size, n1 / size, n2 / size
