# SPDX-License-Identifier: LGPL-3.0-or-later
"""How many edges of a sheet pass through its triangles: by signs of volumes."""

import numpy as np

from contact.kernel import kernel

from .broad_phase import boxes_meet, sort_into_grid


@kernel(makes_arrays=False)
def volume(x: np.ndarray, a: int, b: int, c: int, d: int) -> float:
    """Six times the signed volume of the tetrahedron abcd."""
    out = 0.0
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        area = (x[b, i] - x[a, i]) * (x[c, j] - x[a, j]) - (x[b, j] - x[a, j]) * (x[c, i] - x[a, i])
        out += area * (x[d, k] - x[a, k])
    return out


@kernel(makes_arrays=False)
def passes_through(x: np.ndarray, p: int, q: int, a: int, b: int, c: int) -> bool:
    """Whether the edge pq passes through the triangle abc."""
    one, other = volume(x, a, b, c, p), volume(x, a, b, c, q)
    if one * other >= 0.0:
        return False
    u, v, w = volume(x, p, q, a, b), volume(x, p, q, b, c), volume(x, p, q, c, a)
    return (u > 0.0 and v > 0.0 and w > 0.0) or (u < 0.0 and v < 0.0 and w < 0.0)


@kernel
def count_intersections(
    x: np.ndarray, triangles: np.ndarray, edges: np.ndarray, sides: np.ndarray, owns: np.ndarray
) -> int:
    """Pairs of an edge and a triangle without a common node that pass through each other.

    x : (n, 3) [m]; the others : see Features
    """
    box, cell, counts, order, begin = sort_into_grid(x, triangles, 0.0)
    found = 0
    for at in range(len(triangles)):
        f = order[at]
        for i in range(max(0, cell[f, 0] - 1), min(counts[0], cell[f, 0] + 2)):
            for j in range(max(0, cell[f, 1] - 1), min(counts[1], cell[f, 1] + 2)):
                row = (i * counts[1] + j) * counts[2]
                start = begin[row + max(0, cell[f, 2] - 1)]
                stop = begin[row + min(counts[2], cell[f, 2] + 2)]
                for other in range(start, stop):
                    g = order[other]
                    if f == g or not boxes_meet(box, f, g):
                        continue
                    a, b, c = triangles[g, 0], triangles[g, 1], triangles[g, 2]
                    for k in range(3):
                        p, q = triangles[f, k], triangles[f, (k + 1) % 3]
                        if not owns[f, 3 + k] or p == a or p == b or p == c:
                            continue
                        if q == a or q == b or q == c:
                            continue
                        found += passes_through(x, p, q, a, b, c)
    return found
