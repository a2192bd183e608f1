# SPDX-License-Identifier: LGPL-3.0-or-later
"""What of a closed surface of triangles never changes: neighbours, rings, and the tree of boxes.

The tree is a complete binary one. Node k has the children 2 k + 1 and 2 k + 2; the j-th of the L
leaves holds the triangles order[j n // L] to before order[(j + 1) n // L]. Each level splits every
group in halves along its longest axis; that is done once, afterwards boxes are refitted
(placed.py). The order only decides how fast queries are, not what they find.

Numbers have no sign: kernels then need not ask of every one whether it counts from the end.
"""

from typing import NamedTuple

import numpy as np

LEAF = 4  # triangles a leaf, at most


class Mesh(NamedTuple):
    """A closed surface of nt triangles and nv vertices without its places.

    triangles : (nt, 3) int; order : (nt,) int, the triangles as the leaves hold them
    neighbours : (nt, 3) int, triangle across the edge from corner k to corner k + 1
    ring_start (nv + 1,), ring (3 nt,), ring_ends (3 nt, 2) int : the triangles around each vertex,
        counterclockwise, and their other two corners
    leaves : (1,) int, number L of leaves; leaf_start (L + 1,) int, of the triangles in their order
    in_order : (nt, 3) int, triangles[order]
    sets (nt,), box_sets (2 L - 1,) int : of what each triangle, and each box, is a part; queries
        may ask for some of these only
    """

    triangles: np.ndarray
    order: np.ndarray
    neighbours: np.ndarray
    ring_start: np.ndarray
    ring: np.ndarray
    ring_ends: np.ndarray
    leaves: np.ndarray
    leaf_start: np.ndarray
    in_order: np.ndarray
    sets: np.ndarray
    box_sets: np.ndarray


def mesh_of(triangles: np.ndarray, vertices: np.ndarray, sets: np.ndarray | None = None) -> Mesh:
    """Topology of closed triangles (nt, 3) int, its tree for vertices (nv, 3) placed so [m].

    sets : (nt,) int or None, bits of what the triangles belong to
    """
    count = len(vertices)
    ends = triangles, np.roll(triangles, -1, axis=1)
    forward, backward = (ends[0] * count + ends[1]).ravel(), (ends[1] * count + ends[0]).ravel()
    found = np.argsort(forward, kind="stable")
    across = found[np.searchsorted(forward, backward, sorter=found)]
    neighbours = np.ascontiguousarray((across // 3).reshape(-1, 3))
    ring_start, ring, ring_ends = _rings(np.asarray(triangles, np.int64), neighbours, count)
    levels = max(0, int(np.ceil(np.log2(max(1.0, len(triangles) / LEAF)))))
    order = _halved(vertices[triangles].mean(axis=1), levels)
    triangles = np.ascontiguousarray(triangles, np.int64)
    sets = np.ones(len(triangles), np.int64) if sets is None else np.array(sets, np.int64)
    starts = np.arange((1 << levels) + 1) * len(order) >> levels
    rows = [np.bitwise_or.reduceat(sets[order], starts[:-1])]
    while len(rows[0]) > 1:
        rows.insert(0, rows[0][::2] | rows[0][1::2])
    return Mesh(
        _small(triangles), _small(order), _small(neighbours), ring_start.astype(np.uint64),
        _small(ring), _small(ring_ends), np.array([1 << levels]), starts.astype(np.uint64),
        _small(triangles[order]), sets, np.concatenate(rows),
    )  # fmt: skip


def _small(whole):
    """Whole numbers of half the size: what contact reads of a mesh comes from memory."""
    return np.ascontiguousarray(whole, np.uint32)


def _rings(triangles, neighbours, count):
    """Starts (count + 1,), triangles (3 nt,) and their other corners (3 nt, 2) around vertices.

    A corner is 3 t + k. The next one counterclockwise is in the triangle across the edge that ends
    in corner k; where two surfaces meet in a vertex their rings come one after the other.
    """
    corners = triangles.ravel()
    by_vertex = np.argsort(corners, kind="stable")
    starts = np.concatenate([[0], np.cumsum(np.bincount(corners, minlength=count))])
    # across the edge from corner k + 2 to corner k; there the vertex is the one that has it
    across = np.roll(neighbours, 1, axis=1).ravel()
    place = (triangles[across] == corners[:, None]).argmax(axis=1)
    following = 3 * across + place
    order, done = np.empty_like(corners), np.zeros(len(corners), bool)
    left, begun = np.flatnonzero(np.diff(starts)), starts[:-1].copy()
    at = by_vertex[begun[left]]
    while len(left):
        order[begun[left]], done[at] = at, True
        begun[left] += 1
        more = begun[left] < starts[left + 1]
        left, at = left[more], following[at[more]]
        for k in np.flatnonzero(done[at]):  # a ring is closed, and the vertex has another
            own = by_vertex[starts[left[k]] : starts[left[k] + 1]]
            at[k] = own[~done[own]][0]
    t, k = order // 3, order % 3
    ends = np.column_stack([triangles[t, (k + 1) % 3], triangles[t, (k + 2) % 3]])
    return starts.astype(np.int64), t, np.ascontiguousarray(ends)


def _halved(centres, levels):
    """Order (nt,) in which every group of a level is split along its longest axis."""
    order, n = np.arange(len(centres)), len(centres)
    for level in range(levels):
        starts = np.arange(1 << level) * n >> level
        placed = centres[order]
        spread = np.maximum.reduceat(placed, starts) - np.minimum.reduceat(placed, starts)
        group = np.repeat(np.arange(1 << level), np.diff([*starts, n]))
        key = placed[np.arange(n), spread.argmax(axis=1)[group]]
        order = order[np.lexsort((key, group))]
    return order.astype(np.int64)
