# SPDX-License-Identifier: LGPL-3.0-or-later
"""Corners, edges and triangles of a sheet, and which pairs of them can touch.

The least distance of two triangles is that of a corner to a triangle, or of two edges at insides of
both. A corner or an edge that triangles share is met with one of them, its owner, the first: what
lies nearest to a corner or an edge of another triangle is as near to the owner of that.
"""

from typing import NamedTuple

import numpy as np


class Features(NamedTuple):
    """Triangles with their edges; nodes are given by their places in the arrays of a run.

    triangles : (m, 3) int, nodes; edges : (e, 2) int, nodes
    sides : (m, 3) int, edge from corner k to corner k + 1
    owns : (m, 6) bool, whether a triangle is the first with its corner k, and with its side k
    piece : (n,) int, which connected piece of the sheet a node belongs to
    numbers, places : (n,) int, of places and of nodes: keys of pairs are made of numbers
    """

    triangles: np.ndarray
    edges: np.ndarray
    sides: np.ndarray
    owns: np.ndarray
    piece: np.ndarray
    numbers: np.ndarray
    places: np.ndarray


def features(triangles: np.ndarray, numbers: np.ndarray) -> Features:
    """Features of triangles (m, 3) int, given by numbers of nodes.

    numbers : (n,) int, the node at every place of the arrays; what is first, and all keys, do not
        depend on them
    """
    # only here: most sheets do not meet themselves
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    triangles = np.ascontiguousarray(triangles, np.int64)
    m, n = len(triangles), len(numbers)
    ends = np.sort(np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=-1), axis=-1)
    edges, first_side, sides = np.unique(
        ends.reshape(-1, 2), axis=0, return_index=True, return_inverse=True
    )
    _, first_corner = np.unique(triangles.ravel(), return_index=True)
    owns = np.zeros((2, m * 3), bool)
    owns[0, first_corner], owns[1, first_side] = True, True
    owns = owns.reshape(2, m, 3).transpose(1, 0, 2).reshape(m, 6)
    graph = coo_matrix((np.ones(len(edges)), edges.T), shape=(n, n))
    piece = connected_components(graph, directed=False)[1].astype(np.int64)
    sides = np.ascontiguousarray(sides.reshape(m, 3), np.int64)
    places = np.empty(n, np.int64)
    places[numbers] = np.arange(n)
    numbers = np.ascontiguousarray(numbers, np.int64)
    return Features(
        places[triangles], places[edges], sides, np.ascontiguousarray(owns), piece[numbers],
        numbers, places,
    )  # fmt: skip
