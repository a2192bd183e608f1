# SPDX-License-Identifier: LGPL-3.0-or-later
"""Boxes of corners, edges and triangles, sorted within groups: what pairs are looked for by.

All boxes stand in one table: corners, then edges, then triangles. Members of a group are kept in
their order along the longest side of the whole sheet, from one list to the next. Whether boxes meet
cannot be foreseen by a processor, so loops over boxes have no branches.
"""

from typing import NamedTuple

import numpy as np

from contact.kernel import kernel

from .features import Features


class Members(NamedTuple):
    """Places in the table of boxes of what groups consist of, group after group.

    corners, edges, triangles : int, in the order of their boxes along an axis, which lists keep up
    first_corner, first_edge, first_triangle : (groups + 1,) int, where each group begins
    axis : (1,) int
    """

    corners: np.ndarray
    first_corner: np.ndarray
    edges: np.ndarray
    first_edge: np.ndarray
    triangles: np.ndarray
    first_triangle: np.ndarray
    axis: np.ndarray


def members_of(f: Features, group: np.ndarray) -> Members:
    """Members of groups: corners and edges are in that of their owner; group : (m,) int."""
    n, owner = len(f.numbers), np.arange(len(f.triangles))[:, None]
    whole = np.broadcast_to(owner, (len(owner), 3))
    corner, side = (whole[f.owns[:, part]] for part in (slice(3), slice(3, 6)))
    found: list[np.ndarray] = []
    for place, of in (
        (f.triangles[f.owns[:, :3]], group[corner]),
        (n + f.sides[f.owns[:, 3:]], group[side]),
        (n + len(f.edges) + owner[:, 0], group),
    ):
        order = np.argsort(of, kind="stable")
        begins = np.searchsorted(of[order], np.arange(group.max() + 2))
        found += [np.ascontiguousarray(place[order], np.int64), begins.astype(np.int64)]
    corners, first_corner, edges, first_edge, triangles, first_triangle = found
    return Members(
        corners, first_corner, edges, first_edge, triangles, first_triangle, np.full(1, -1)
    )


@kernel(makes_arrays=False)
def box_of(x: np.ndarray, nodes: np.ndarray, margin: float, box: np.ndarray) -> None:
    """Fill box (6,) of some nodes, low ends first, made wider by a margin."""
    for c in range(3):
        box[c] = box[3 + c] = x[nodes[0], c]
        for k in range(1, len(nodes)):
            box[c], box[3 + c] = min(box[c], x[nodes[k], c]), max(box[3 + c], x[nodes[k], c])
        box[c], box[3 + c] = box[c] - margin, box[3 + c] + margin


@kernel(makes_arrays=False)
def set_boxes(
    x: np.ndarray, triangles: np.ndarray, edges: np.ndarray, margin: float, box: np.ndarray
) -> None:
    """Fill box (n + k + m, 6) of all corners, edges and triangles, made wider by a margin."""
    n, k = len(x), len(edges)
    for i in range(n):
        for c in range(3):
            box[i, c], box[i, 3 + c] = x[i, c] - margin, x[i, c] + margin
    for e in range(k):
        box_of(x, edges[e], margin, box[n + e])
    for f in range(len(triangles)):
        box_of(x, triangles[f], margin, box[n + k + f])


@kernel(makes_arrays=False)
def set_group_boxes(
    box: np.ndarray, members: np.ndarray, first: np.ndarray, whole: np.ndarray
) -> int:
    """Fill boxes whole (g, 6) of the triangles of groups; the longest side of all together."""
    for k in range(len(whole)):
        for c in range(3):
            whole[k, c], whole[k, 3 + c] = np.inf, -np.inf
            for at in range(first[k], first[k + 1]):
                f = members[at]
                whole[k, c] = min(whole[k, c], box[f, c])
                whole[k, 3 + c] = max(whole[k, 3 + c], box[f, 3 + c])
    axis, longest = 0, -1.0
    for c in range(3):
        low, high = np.inf, -np.inf
        for k in range(len(whole)):
            low, high = min(low, whole[k, c]), max(high, whole[k, 3 + c])
        if high - low > longest:
            axis, longest = c, high - low
    return axis


@kernel(makes_arrays=False)
def sort_along(
    box: np.ndarray, members: np.ndarray, first: np.ndarray, axis: int, near: bool
) -> None:
    """Sort members of each group by the low ends of their boxes (Shell's sort).

    near : whether they are nearly so already
    """
    for k in range(len(first) - 1):
        begin, end, gap = first[k], first[k + 1], 1
        while not near and 3 * gap + 1 < end - begin:
            gap = 3 * gap + 1
        while gap > 0:
            for at in range(begin + gap, end):
                f, to = members[at], at
                while to >= begin + gap and box[members[to - gap], axis] > box[f, axis]:
                    members[to] = members[to - gap]
                    to -= gap
                members[to] = f
            gap //= 3


@kernel(makes_arrays=False)
def meet(box: np.ndarray, a: int, other: np.ndarray, b: int) -> bool:
    """Whether box a of a table and box b of another overlap, without a branch."""
    meets = (box[a, 0] <= other[b, 3]) & (other[b, 0] <= box[a, 3])
    meets &= (box[a, 1] <= other[b, 4]) & (other[b, 1] <= box[a, 4])
    return meets & (box[a, 2] <= other[b, 5]) & (other[b, 2] <= box[a, 5])


@kernel(makes_arrays=False)
def pick(
    members: np.ndarray,
    begin: int,
    end: int,
    box: np.ndarray,
    whole: np.ndarray,
    other: int,
    axis: int,
    picked: np.ndarray,
    boxes: np.ndarray,
) -> tuple[int, float]:
    """Fill picked (n,), and boxes (n, 6), with members that meet another group, in their order.

    Returns their number, and the longest of their boxes along the axis.
    """
    count, size = 0, 0.0
    for at in range(begin, end):
        f = members[at]
        picked[count] = f
        count += meet(box, f, whole, other)
    for at in range(count):
        f = picked[at]
        size = max(size, box[f, 3 + axis] - box[f, axis])
        for c in range(6):
            boxes[at, c] = box[f, c]
    return count, size
