# SPDX-License-Identifier: LGPL-3.0-or-later
"""Closest point of a closed surface of triangles, and on which side of it a point is.

A query goes down the tree of boxes, the nearer child first, and leaves out boxes farther than the
best triangle so far. Any triangle may be tried first: a good guess makes it quick, and the answer
is the same, as of equal distances the triangle of the lowest number wins.

The side is that of the plane through the closest point with the pseudo-normal: of the triangle, the
sum of two normals on an edge, at a vertex the sum of all weighted by the angles of their triangles
there (J. A. Baerentzen and H. Aanaes, IEEE Trans. Vis. Comput. Graph. 11, 243, 2005).
"""

from typing import Any

import numpy as np

from contact.kernel import kernel

STACK = 64  # more than the depth of any tree
FACE = 0  # where a closest point lies: 1 + k on the edge from corner k, 4 + k in corner k
SLACK = 1.0 + 1e-14  # of the square of a distance to a box: its roundoff


@kernel(makes_arrays=False)
def on_triangle(
    v: np.ndarray, corners: np.ndarray, t: int, x0: float, x1: float, x2: float
) -> tuple[float, float, float, int]:
    """Square of the distance [m^2] of x to triangle t, weights of its second and third corner at
    the closest point, and where that lies (C. Ericson, Real-Time Collision Detection, 5.1.5)."""
    i, j, k = corners[t, 0], corners[t, 1], corners[t, 2]
    o0, o1, o2 = v[i, 0], v[i, 1], v[i, 2]
    a0, a1, a2 = v[j, 0] - o0, v[j, 1] - o1, v[j, 2] - o2
    c0, c1, c2 = v[k, 0] - o0, v[k, 1] - o1, v[k, 2] - o2
    p0, p1, p2 = x0 - o0, x1 - o1, x2 - o2
    d1 = a0 * p0 + a1 * p1 + a2 * p2
    d2 = c0 * p0 + c1 * p1 + c2 * p2
    aa, ac = a0 * a0 + a1 * a1 + a2 * a2, a0 * c0 + a1 * c1 + a2 * c2
    cc = c0 * c0 + c1 * c1 + c2 * c2
    d3, d4, d5, d6 = d1 - aa, d2 - ac, d1 - ac, d2 - cc
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    u, w, where = 0.0, 0.0, FACE
    if d1 <= 0.0 and d2 <= 0.0:
        where = 4
    elif d3 >= 0.0 and d4 <= d3:
        u, where = 1.0, 5
    elif d6 >= 0.0 and d5 <= d6:
        w, where = 1.0, 6
    elif vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        u, where = d1 / (d1 - d3), 1
    elif vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        w, where = d2 / (d2 - d6), 3
    elif va <= 0.0 and d4 - d3 >= 0.0 and d5 - d6 >= 0.0:
        w = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        u, where = 1.0 - w, 2
    else:
        total = 1.0 / (va + vb + vc)
        u, w = vb * total, vc * total
    e0, e1, e2 = p0 - u * a0 - w * c0, p1 - u * a1 - w * c1, p2 - u * a2 - w * c2
    return e0 * e0 + e1 * e1 + e2 * e2, u, w, where


@kernel(makes_arrays=False)
def _to_box(boxes, k, grown, x0, x1, x2):
    """Square of the distance of x to a box that is grown to all sides [m^2]."""
    d0 = max(0.0, boxes[k, 0] - x0 - grown, x0 - boxes[k, 3] - grown)
    d1 = max(0.0, boxes[k, 1] - x1 - grown, x1 - boxes[k, 4] - grown)
    d2 = max(0.0, boxes[k, 2] - x2 - grown, x2 - boxes[k, 5] - grown)
    return d0 * d0 + d1 * d1 + d2 * d2


@kernel(makes_arrays=False)
def _faces_away(v, corners, t, n0, n1, n2, cosine):
    """Whether the normal of triangle t makes an angle with n of a cosine below `cosine`."""
    i, j, k = corners[t, 0], corners[t, 1], corners[t, 2]
    a0, a1, a2 = v[j, 0] - v[i, 0], v[j, 1] - v[i, 1], v[j, 2] - v[i, 2]
    c0, c1, c2 = v[k, 0] - v[i, 0], v[k, 1] - v[i, 1], v[k, 2] - v[i, 2]
    m0, m1, m2 = a1 * c2 - a2 * c1, a2 * c0 - a0 * c2, a0 * c1 - a1 * c0
    along = m0 * n0 + m1 * n1 + m2 * n2
    return along < cosine * np.sqrt(m0 * m0 + m1 * m1 + m2 * m2)


@kernel(makes_arrays=False)
def _walk(
    mesh, placed, x0, x1, x2, asked, best, least, n0, n1, n2, cosine, stack, bounds
):  # fmt: skip
    """Closest triangle that counts, and the square of its distance, if below `least`; else `best`.

    Of any direction for a cosine above 1, otherwise as of `closest_facing`.
    """
    v, boxes, corners, grown = placed.vertices, placed.boxes, mesh.in_order, placed.grown[0]
    starts, leaves = mesh.leaf_start, mesh.leaves[0]
    depth, k, bound = 0, 0, _to_box(boxes, 0, grown, x0, x1, x2)
    while True:
        if bound <= least * SLACK and mesh.box_sets[k] & asked:
            if k < leaves - 1:
                left, right = 2 * k + 1, 2 * k + 2
                near, far = (
                    _to_box(boxes, left, grown, x0, x1, x2),
                    _to_box(boxes, right, grown, x0, x1, x2),
                )
                if far < near:
                    left, right, near, far = right, left, far, near
                stack[depth], bounds[depth] = right, far
                depth += 1
                k, bound = left, near
                continue
            j = k - (leaves - 1)
            for place in range(starts[j], starts[j + 1]):
                if cosine <= 1.0 and not _faces_away(v, corners, place, n0, n1, n2, cosine):
                    continue
                square = on_triangle(v, corners, place, x0, x1, x2)[0]
                if square <= least:
                    t = mesh.order[place]
                    if (square < least or t < best or best < 0) and mesh.sets[t] & asked:
                        best, least = t, square
        if depth == 0:
            return best, least
        depth -= 1
        k, bound = stack[depth], bounds[depth]


@kernel(makes_arrays=False)
def closest(
    mesh: Any,
    placed: Any,
    x0: float,
    x1: float,
    x2: float,
    asked: int,
    guess: int,
    stack: np.ndarray,
    bounds: np.ndarray,
) -> tuple[int, float]:
    """Closest triangle of x and the square of its distance [m^2]; -1 where none is asked for.

    asked : int, sets of triangles that count, see `Mesh`; -1: all
    guess : triangle to be tried first, or -1; stack (STACK,) int, bounds (STACK,) : scratch
    """
    best, least = -1, np.inf
    if guess >= 0 and mesh.sets[guess] & asked:
        best = guess
        least = on_triangle(placed.vertices, mesh.triangles, guess, x0, x1, x2)[0]
    return _walk(
        mesh, placed, x0, x1, x2, asked, best, least, 0.0, 0.0, 0.0, 2.0, stack, bounds
    )  # fmt: skip


@kernel(makes_arrays=False)
def face_normal(v: np.ndarray, corners: np.ndarray, t: int) -> tuple[float, float, float, float]:
    """Unit normal of triangle t, zero for one without area, and twice its area [m^2]."""
    i, j, k = corners[t, 0], corners[t, 1], corners[t, 2]
    a0, a1, a2 = v[j, 0] - v[i, 0], v[j, 1] - v[i, 1], v[j, 2] - v[i, 2]
    c0, c1, c2 = v[k, 0] - v[i, 0], v[k, 1] - v[i, 1], v[k, 2] - v[i, 2]
    n0, n1, n2 = a1 * c2 - a2 * c1, a2 * c0 - a0 * c2, a0 * c1 - a1 * c0
    size = np.sqrt(n0 * n0 + n1 * n1 + n2 * n2)
    scale = 1.0 / size if size > 0.0 else 0.0
    return scale * n0, scale * n1, scale * n2, size


@kernel(makes_arrays=False)
def _at_vertex(mesh, v, i):
    """Sum of normals around vertex i, by the angles of their triangles there."""
    s0 = s1 = s2 = 0.0
    for place in range(mesh.ring_start[i], mesh.ring_start[i + 1]):
        t, p, q = mesh.ring[place], mesh.ring_ends[place, 0], mesh.ring_ends[place, 1]
        a0, a1, a2 = v[p, 0] - v[i, 0], v[p, 1] - v[i, 1], v[p, 2] - v[i, 2]
        c0, c1, c2 = v[q, 0] - v[i, 0], v[q, 1] - v[i, 1], v[q, 2] - v[i, 2]
        n0, n1, n2, size = face_normal(v, mesh.triangles, t)
        angle = np.arctan2(size, a0 * c0 + a1 * c1 + a2 * c2)
        s0, s1, s2 = s0 + angle * n0, s1 + angle * n1, s2 + angle * n2
    return s0, s1, s2


@kernel(makes_arrays=False)
def closest_facing(
    mesh: Any,
    placed: Any,
    x0: float,
    x1: float,
    x2: float,
    asked: int,
    n0: float,
    n1: float,
    n2: float,
    cosine: float,
    limit: float,
    stack: np.ndarray,
    bounds: np.ndarray,
) -> tuple[int, float]:
    """Closest of the triangles that face another way, and the square of its distance [m^2].

    Counted are those within `limit` [m] whose normal makes an angle with n of a cosine below
    `cosine`; -1 where there is none. asked, stack, bounds : see `closest`
    """
    return _walk(
        mesh, placed, x0, x1, x2, asked, -1, limit * limit, n0, n1, n2, cosine, stack, bounds
    )  # fmt: skip


@kernel(makes_arrays=False)
def pseudo_normal(mesh: Any, v: np.ndarray, t: int, where: int) -> tuple[float, float, float]:
    """Pseudo-normal, of no unit length, at a point of triangle t that lies `where`."""
    n0, n1, n2, _ = face_normal(v, mesh.triangles, t)
    if where >= 4:
        return _at_vertex(mesh, v, mesh.triangles[t, where - 4])
    if where > 0:
        m0, m1, m2, _ = face_normal(v, mesh.triangles, mesh.neighbours[t, where - 1])
        return n0 + m0, n1 + m1, n2 + m2
    return n0, n1, n2


@kernel
def signed_distances(
    mesh: Any, placed: Any, points: np.ndarray, out: np.ndarray, found: np.ndarray
) -> None:
    """Fill distances out (n,) [m] of points (n, 3), negative inside, and triangles found (n,)."""
    stack, bounds = np.empty(STACK, np.int64), np.empty(STACK)
    v, corners = placed.vertices, mesh.triangles
    for i in range(len(points)):
        x0, x1, x2 = points[i, 0], points[i, 1], points[i, 2]
        t, square = closest(mesh, placed, x0, x1, x2, -1, -1, stack, bounds)
        _, u, w, where = on_triangle(v, corners, t, x0, x1, x2)
        n0, n1, n2 = pseudo_normal(mesh, v, t, where)
        above = 0.0
        for c, x, n in ((0, x0, n0), (1, x1, n1), (2, x2, n2)):
            foot = (1.0 - u - w) * v[corners[t, 0], c]
            foot += u * v[corners[t, 1], c] + w * v[corners[t, 2], c]
            above += n * (x - foot)
        out[i], found[i] = np.sqrt(square) if above >= 0.0 else -np.sqrt(square), t
