# SPDX-License-Identifier: LGPL-3.0-or-later
"""A closed surface of triangles in one place: vertices, boxes of the tree, smooth normals.

Boxes are refitted from the leaves up. Several placings may share them: a box holds its triangles
wherever no vertex is farther from where it was than the box is grown for.

Normals of vertices are found when they are first asked for: with the edges e_k from the vertex to
its neighbours in turn,

    n = sum_k (e_k/|e_k|^2) x (e_k+1/|e_k+1|^2),

which is exact where all these vertices lie on a sphere (N. Max, J. Graphics Tools 4(2), 1999).
"""

from typing import Any, NamedTuple

import numpy as np

from contact.kernel import kernel

from .topology import Mesh

TINY = 1e-40  # m^2: edges of no length count for nothing


class Placed(NamedTuple):
    """vertices (nv, 3) [m]; boxes (2 L - 1, 6), lower and upper corners [m], and how far they are
    to be grown (1,) [m]; normals (nv, 3) of vertices, those that are known (nv,) bool."""

    vertices: np.ndarray
    boxes: np.ndarray
    grown: np.ndarray
    normals: np.ndarray
    known: np.ndarray


def new_placed(mesh: Mesh, count: int, boxes: np.ndarray | None = None) -> Placed:
    """Arrays for `count` vertices, without any places; boxes : those of another, to be shared."""
    if boxes is None:
        boxes = np.zeros((2 * int(mesh.leaves[0]) - 1, 6))
    known = np.zeros(count, np.bool_)
    return Placed(np.zeros((count, 3)), boxes, np.zeros(1), np.zeros((count, 3)), known)


@kernel(makes_arrays=False)
def refit(mesh: Any, placed: Any) -> None:
    """Boxes of the tree from the vertices, not grown; normals are forgotten."""
    boxes, v, corners = placed.boxes, placed.vertices, mesh.in_order
    starts, leaves = mesh.leaf_start, mesh.leaves[0]
    for j in range(leaves):
        low0 = low1 = low2 = np.inf
        high0 = high1 = high2 = -np.inf
        for place in range(starts[j], starts[j + 1]):
            for a in range(3):
                i = corners[place, a]
                v0, v1, v2 = v[i, 0], v[i, 1], v[i, 2]
                low0, high0 = v0 if v0 < low0 else low0, v0 if v0 > high0 else high0
                low1, high1 = v1 if v1 < low1 else low1, v1 if v1 > high1 else high1
                low2, high2 = v2 if v2 < low2 else low2, v2 if v2 > high2 else high2
        k = leaves - 1 + j
        boxes[k, 0], boxes[k, 1], boxes[k, 2] = low0, low1, low2
        boxes[k, 3], boxes[k, 4], boxes[k, 5] = high0, high1, high2
    for k in range(leaves - 2, -1, -1):
        for c in range(3):
            boxes[k, c] = min(boxes[2 * k + 1, c], boxes[2 * k + 2, c])
            boxes[k, 3 + c] = max(boxes[2 * k + 1, 3 + c], boxes[2 * k + 2, 3 + c])
    placed.grown[0] = 0.0
    for i in range(len(placed.known)):
        placed.known[i] = False


@kernel(makes_arrays=False)
def greatest_move(before: np.ndarray, after: np.ndarray, shift: np.ndarray) -> tuple[float, float]:
    """Greatest way [m] of any vertex (nv, 3), not a number where one has none, and a bound of it
    as seen from a frame that goes by `shift` (3,) [m], filled: the middle of all ways."""
    most, low0, low1, low2 = 0.0, np.inf, np.inf, np.inf
    high0 = high1 = high2 = -np.inf
    for i in range(len(before)):
        d0 = after[i, 0] - before[i, 0]
        d1 = after[i, 1] - before[i, 1]
        d2 = after[i, 2] - before[i, 2]
        square = d0 * d0 + d1 * d1 + d2 * d2
        if not square <= most:
            most = square
        low0, high0 = d0 if d0 < low0 else low0, d0 if d0 > high0 else high0
        low1, high1 = d1 if d1 < low1 else low1, d1 if d1 > high1 else high1
        low2, high2 = d2 if d2 < low2 else low2, d2 if d2 > high2 else high2
    shift[0], shift[1], shift[2] = (
        0.5 * (low0 + high0), 0.5 * (low1 + high1), 0.5 * (low2 + high2)
    )  # fmt: skip
    a0, a1, a2 = high0 - low0, high1 - low1, high2 - low2
    return np.sqrt(most), 0.5 * np.sqrt(a0 * a0 + a1 * a1 + a2 * a2)


@kernel(makes_arrays=False)
def know_normal(mesh: Any, placed: Any, i: int) -> None:
    """Fill the unit normal of vertex i, if it is not known."""
    if placed.known[i]:
        return
    v, ends = placed.vertices, mesh.ring_ends
    o0, o1, o2 = v[i, 0], v[i, 1], v[i, 2]
    n0 = n1 = n2 = 0.0
    last, c0, c1, c2 = -1, 0.0, 0.0, 0.0
    for place in range(mesh.ring_start[i], mesh.ring_start[i + 1]):
        a0, a1, a2, p = c0, c1, c2, ends[place, 0]
        if p != last:
            a0, a1, a2 = v[p, 0] - o0, v[p, 1] - o1, v[p, 2] - o2
            scale = 1.0 / max(a0 * a0 + a1 * a1 + a2 * a2, TINY)
            a0, a1, a2 = scale * a0, scale * a1, scale * a2
        q = ends[place, 1]
        c0, c1, c2, last = v[q, 0] - o0, v[q, 1] - o1, v[q, 2] - o2, q
        scale = 1.0 / max(c0 * c0 + c1 * c1 + c2 * c2, TINY)
        c0, c1, c2 = scale * c0, scale * c1, scale * c2
        n0, n1, n2 = n0 + a1 * c2 - a2 * c1, n1 + a2 * c0 - a0 * c2, n2 + a0 * c1 - a1 * c0
    size = np.sqrt(n0 * n0 + n1 * n1 + n2 * n2)
    scale = 1.0 / size if size > 0.0 else 0.0
    placed.normals[i, 0], placed.normals[i, 1] = scale * n0, scale * n1
    placed.normals[i, 2], placed.known[i] = scale * n2, True
