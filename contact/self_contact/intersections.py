# SPDX-License-Identifier: LGPL-3.0-or-later
"""How many edges of a sheet pass through its triangles: by signs of volumes."""

import numpy as np

from contact.kernel import kernel

from .boxes import meet


@kernel
def sort_into_grid(
    x: np.ndarray, triangles: np.ndarray, reach: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Boxes of triangles (m, 3) of points x (n, 3), half a reach wider, and the grid of cells.

    Returns boxes (m, 6), low ends first, and cells (m, 3) of the triangles, in the order of these
    cells; counts of cells (3,); that order (m,); where each cell begins in it
    """
    m = len(triangles)
    box, cell, counts = np.empty((m, 6)), np.empty((m, 3), np.int64), np.empty(3, np.int64)
    size, low, high = 0.0, np.full(3, np.inf), np.full(3, -np.inf)
    for f in range(m):
        for c in range(3):
            one = x[triangles[f, 0], c]
            two, three = x[triangles[f, 1], c], x[triangles[f, 2], c]
            box[f, c] = min(one, two, three) - 0.5 * reach
            box[f, 3 + c] = max(one, two, three) + 0.5 * reach
            size = max(size, box[f, 3 + c] - box[f, c])
            middle = 0.5 * (box[f, c] + box[f, 3 + c])
            low[c], high[c] = min(low[c], middle), max(high[c], middle)
    while True:  # wider cells where the sheet fills few of them
        total = 1.0
        for c in range(3):
            total *= np.floor((high[c] - low[c]) / size) + 1.0
        if total <= 16.0 * m + 64.0:
            break
        size *= 1.3
    for c in range(3):
        counts[c] = int((high[c] - low[c]) / size) + 1
    begin = np.zeros(counts[0] * counts[1] * counts[2] + 1, np.int64)
    for f in range(m):
        for c in range(3):
            middle = 0.5 * (box[f, c] + box[f, 3 + c])
            cell[f, c] = min(counts[c] - 1, int((middle - low[c]) / size))
        begin[(cell[f, 0] * counts[1] + cell[f, 1]) * counts[2] + cell[f, 2] + 1] += 1
    for k in range(1, len(begin)):
        begin[k] += begin[k - 1]
    order, filled = np.empty(m, np.int64), begin.copy()
    for f in range(m):
        k = (cell[f, 0] * counts[1] + cell[f, 1]) * counts[2] + cell[f, 2]
        order[filled[k]] = f
        filled[k] += 1
    sorted_box, sorted_cell = np.empty((m, 6)), np.empty((m, 3), np.int64)
    for at in range(m):
        for c in range(6):
            sorted_box[at, c] = box[order[at], c]
        for c in range(3):
            sorted_cell[at, c] = cell[order[at], c]
    return sorted_box, sorted_cell, counts, order, begin


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
        for i in range(max(0, cell[at, 0] - 1), min(counts[0], cell[at, 0] + 2)):
            for j in range(max(0, cell[at, 1] - 1), min(counts[1], cell[at, 1] + 2)):
                row = (i * counts[1] + j) * counts[2]
                start = begin[row + max(0, cell[at, 2] - 1)]
                stop = begin[row + min(counts[2], cell[at, 2] + 2)]
                for other in range(start, stop):
                    if at == other or not meet(box, at, box, other):
                        continue
                    g = order[other]
                    a, b, c = triangles[g, 0], triangles[g, 1], triangles[g, 2]
                    for k in range(3):
                        p, q = triangles[f, k], triangles[f, (k + 1) % 3]
                        if not owns[f, 3 + k] or p == a or p == b or p == c:
                            continue
                        if q == a or q == b or q == c:
                            continue
                        found += passes_through(x, p, q, a, b, c)
    return found
