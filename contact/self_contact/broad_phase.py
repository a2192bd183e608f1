# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pairs of a corner and a triangle, and of two edges, whose boxes come closer than a reach.

Triangles are sorted into a grid of cells as wide as the largest of their boxes, so that those near
lie in one of 27 cells. A pair has a key:

    p m + f                          corner p, triangle f of m
    n m + e k + f, e < f             edges e and f of k, n being the number of nodes

which is the same on any number of ranks. Pairs that share a node are left out.
"""

import numpy as np

from contact.kernel import kernel

from .closest_points import closest


@kernel
def sort_into_grid(
    x: np.ndarray, triangles: np.ndarray, reach: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Boxes of triangles (m, 3) of points x (n, 3), half a reach wider, and the grid of cells.

    Returns boxes (m, 6), low ends first; the cell (m, 3) of each; counts of cells (3,); triangles
    in the order of their cells (m,); where each cell begins in it
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
    return box, cell, counts, order, begin


@kernel(makes_arrays=False)
def boxes_meet(box: np.ndarray, a: int, b: int) -> bool:
    """Whether two boxes overlap."""
    for c in range(3):
        if box[a, c] > box[b, 3 + c] or box[b, c] > box[a, 3 + c]:
            return False
    return True


@kernel(makes_arrays=False)
def point_in_box(x: np.ndarray, p: int, box: np.ndarray, f: int, more: float) -> bool:
    """Whether a point lies in a box made wider."""
    for c in range(3):
        if x[p, c] < box[f, c] - more or x[p, c] > box[f, 3 + c] + more:
            return False
    return True


@kernel(makes_arrays=False)
def edges_near(x: np.ndarray, a: int, b: int, c: int, d: int, reach: float) -> bool:
    """Whether the boxes of edges ab and cd come closer than a reach."""
    for k in range(3):
        if min(x[a, k], x[b, k]) > max(x[c, k], x[d, k]) + reach:
            return False
        if min(x[c, k], x[d, k]) > max(x[a, k], x[b, k]) + reach:
            return False
    return True


@kernel
def list_pairs(
    x: np.ndarray,
    triangles: np.ndarray,
    edges: np.ndarray,
    sides: np.ndarray,
    owns: np.ndarray,
    numbers: np.ndarray,
    group: np.ndarray,
    wanted: np.ndarray,
    reach: float,
    keys: np.ndarray,
) -> int:
    """Fill keys (k,) with those of pairs nearer than a reach [m], in no order.

    x : (n, 3) [m]; triangles to numbers : see Features; group : (m,) int, of triangles
    wanted : (g, g) bool, symmetric, groups whose pairs are asked for

    Returns how many there are, more than k where they do not fit.
    """
    box, cell, counts, order, begin = sort_into_grid(x, triangles, reach)
    m, k, found = len(triangles), len(edges), 0
    corners = len(x) * m
    busy = np.zeros(len(wanted), np.bool_)
    for i in range(len(wanted)):
        busy[i] = wanted[i].any()
    for at in range(m):
        f = order[at]
        if not busy[group[f]]:
            continue
        for i in range(max(0, cell[f, 0] - 1), min(counts[0], cell[f, 0] + 2)):
            for j in range(max(0, cell[f, 1] - 1), min(counts[1], cell[f, 1] + 2)):
                row = (i * counts[1] + j) * counts[2]
                start = begin[row + max(0, cell[f, 2] - 1)]
                stop = begin[row + min(counts[2], cell[f, 2] + 2)]
                for other in range(max(start, at + 1), stop):
                    g = order[other]
                    if not wanted[group[f], group[g]] or not boxes_meet(box, f, g):
                        continue
                    for turn in range(2):
                        a, b = (f, g) if turn == 0 else (g, f)
                        for c in range(3):
                            p = triangles[a, c]
                            if not owns[a, c] or not point_in_box(x, p, box, b, 0.5 * reach):
                                continue
                            t0, t1, t2 = triangles[b, 0], triangles[b, 1], triangles[b, 2]
                            if p != t0 and p != t1 and p != t2:
                                if found < len(keys):
                                    keys[found] = numbers[p] * m + b
                                found += 1
                    for c in range(3):
                        if not owns[f, 3 + c]:
                            continue
                        p, q = triangles[f, c], triangles[f, (c + 1) % 3]
                        for d in range(3):
                            if not owns[g, 3 + d]:
                                continue
                            s, t = triangles[g, d], triangles[g, (d + 1) % 3]
                            if p == s or p == t or q == s or q == t:
                                continue
                            if edges_near(x, p, q, s, t, reach):
                                one, two = sides[f, c], sides[g, d]
                                if found < len(keys):
                                    keys[found] = corners + min(one, two) * k + max(one, two)
                                found += 1
    return found


@kernel
def keep_near(
    x: np.ndarray,
    triangles: np.ndarray,
    edges: np.ndarray,
    sides: np.ndarray,
    owns: np.ndarray,
    places: np.ndarray,
    reach: float,
    keys: np.ndarray,
    distance: np.ndarray,
) -> int:
    """Keep those of the keys (k,) whose pairs are nearer than a reach [m], with their distances.

    x : (n, 3) [m]; triangles to places : see Features. Returns how many they are; they come first.
    """
    nodes, w, r = np.empty(4, np.int64), np.empty(4), np.empty(3)
    corners, kept = len(x) * len(triangles), 0
    for k in range(len(keys)):
        d, _ = closest(x, keys[k], corners, triangles, edges, sides, owns, places, nodes, w, r)
        if d < reach:
            keys[kept], distance[kept] = keys[k], d
            kept += 1
    return kept
