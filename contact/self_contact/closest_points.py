# SPDX-License-Identifier: LGPL-3.0-or-later
"""Closest points of a point and a triangle, and of two edges.

By the regions of Voronoi (Ericson, Real-Time Collision Detection, 2005, 5.1.5 and 5.1.9). Weights
of corners that do not count are exactly zero.
"""

import numpy as np

from contact.kernel import kernel

INSIDE = 1e-9  # weights below are taken for those of an edge or a corner


@kernel(makes_arrays=False)
def dot(a: np.ndarray, i: int, j: int, k: int, m: int) -> float:
    """(a_j - a_i) . (a_m - a_k) of points a (n, 3)."""
    return (
        (a[j, 0] - a[i, 0]) * (a[m, 0] - a[k, 0])
        + (a[j, 1] - a[i, 1]) * (a[m, 1] - a[k, 1])
        + (a[j, 2] - a[i, 2]) * (a[m, 2] - a[k, 2])
    )


@kernel(makes_arrays=False)
def on_triangle(x: np.ndarray, p: int, a: int, b: int, c: int) -> tuple[float, float, float]:
    """Weights of a, b, c at the point of their triangle that is closest to p; x (n, 3)."""
    d1, d2 = dot(x, a, b, a, p), dot(x, a, c, a, p)
    if d1 <= 0.0 and d2 <= 0.0:
        return 1.0, 0.0, 0.0
    d3, d4 = dot(x, a, b, b, p), dot(x, a, c, b, p)
    if d3 >= 0.0 and d4 <= d3:
        return 0.0, 1.0, 0.0
    vc = d1 * d4 - d3 * d2
    if vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        v = d1 / (d1 - d3)
        return 1.0 - v, v, 0.0
    d5, d6 = dot(x, a, b, c, p), dot(x, a, c, c, p)
    if d6 >= 0.0 and d5 <= d6:
        return 0.0, 0.0, 1.0
    vb = d5 * d2 - d1 * d6
    if vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        w = d2 / (d2 - d6)
        return 1.0 - w, 0.0, w
    va = d3 * d6 - d5 * d4
    if va <= 0.0 and d4 - d3 >= 0.0 and d5 - d6 >= 0.0:
        w = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        return 0.0, 1.0 - w, w
    size = va + vb + vc
    return 1.0 - vb / size - vc / size, vb / size, vc / size


@kernel(makes_arrays=False)
def on_edges(x: np.ndarray, a: int, b: int, c: int, d: int) -> tuple[float, float]:
    """Parts s, t of the way from a to b and from c to d at their closest points; x (n, 3)."""
    aa, cc, ac = dot(x, a, b, a, b), dot(x, c, d, c, d), dot(x, a, b, c, d)
    ar, cr = dot(x, a, b, c, a), dot(x, c, d, c, a)
    size = aa * cc - ac * ac
    s = 0.0
    if size > 1e-10 * aa * cc:
        s = min(1.0, max(0.0, (ac * cr - ar * cc) / size))
    t = (ac * s + cr) / cc
    if t < 0.0:
        t, s = 0.0, min(1.0, max(0.0, -ar / aa))
    elif t > 1.0:
        t, s = 1.0, min(1.0, max(0.0, (ac - ar) / aa))
    return s, t


@kernel(makes_arrays=False)
def apart(x: np.ndarray, nodes: np.ndarray, w: np.ndarray, r: np.ndarray) -> float:
    """Fill r (3,) with sum_a w_a x_a of the nodes (4,); its length."""
    size = 0.0
    for c in range(3):
        r[c] = 0.0
        for a in range(4):
            r[c] += w[a] * x[nodes[a], c]
        size += r[c] * r[c]
    return np.sqrt(size)


@kernel(makes_arrays=False)
def closest(
    x: np.ndarray,
    key: int,
    corners: int,
    triangles: np.ndarray,
    edges: np.ndarray,
    sides: np.ndarray,
    owns: np.ndarray,
    places: np.ndarray,
    nodes: np.ndarray,
    w: np.ndarray,
    r: np.ndarray,
) -> tuple[float, bool]:
    """Distance of a pair, and whether the pair is the one that has to keep it.

    key : see broad_phase.py; corners : int, keys below are of a corner and a triangle
    nodes, w, r : (4,), (4,), (3,), filled: nodes, weights and the way between the closest points
    """
    if key < corners:
        m = len(triangles)
        p, f = places[key // m], key % m
        a, b, c = triangles[f, 0], triangles[f, 1], triangles[f, 2]
        nodes[0], nodes[1], nodes[2], nodes[3] = p, a, b, c
        wa, wb, wc = on_triangle(x, p, a, b, c)
        w[0], w[1], w[2], w[3] = 1.0, -wa, -wb, -wc
        zeros, last, other = 0, 0, 0
        for k in range(3):
            if -w[1 + k] < INSIDE:
                zeros, last = zeros + 1, k
            else:
                other = k
        keeps = True
        if zeros == 1:
            keeps = owns[f, 3 + (last + 1) % 3]
        elif zeros == 2:
            keeps = owns[f, other]
        return apart(x, nodes, w, r), keeps
    number, count = key - corners, len(edges)
    e, f = number // count, number % count
    nodes[0], nodes[1], nodes[2], nodes[3] = edges[e, 0], edges[e, 1], edges[f, 0], edges[f, 1]
    s, t = on_edges(x, nodes[0], nodes[1], nodes[2], nodes[3])
    w[0], w[1], w[2], w[3] = 1.0 - s, s, t - 1.0, -t
    inside = INSIDE < s < 1.0 - INSIDE and INSIDE < t < 1.0 - INSIDE
    return apart(x, nodes, w, r), inside
