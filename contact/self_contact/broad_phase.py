# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pairs of a corner and a triangle, and of two edges, that come closer than a reach.

A list is made for pairs of groups of triangles (trust_region.py), one after another: of both groups
those corners, edges and triangles whose boxes meet the box of the other group, swept along the
longest side of the sheet. What a list costs goes with the pairs of groups that ask for it. Whether
boxes meet cannot be foreseen by a processor, so loops over boxes have no branches.

All boxes stand in one table: corners, then edges, then triangles. A pair has a key:

    p m + f                          corner p, triangle f of m
    n m + e k + f, e < f             edges e and f of k, n being the number of nodes

which is the same on any number of ranks. Pairs that share a node are left out.
"""

from typing import Any, NamedTuple

import numpy as np

from contact.kernel import kernel

from .closest_points import closest
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
    found.append(np.full(1, -1))
    return Members(*found)


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
def set_group_boxes(box: np.ndarray, members: Any, whole: np.ndarray) -> int:
    """Fill boxes whole (g, 6) of the triangles of groups; the longest side of all together."""
    for k in range(len(whole)):
        for c in range(3):
            whole[k, c], whole[k, 3 + c] = np.inf, -np.inf
            for at in range(members.first_triangle[k], members.first_triangle[k + 1]):
                f = members.triangles[at]
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


@kernel(makes_arrays=False)
def along(x: np.ndarray, i: int) -> tuple[float, float, float, float]:
    """Places of a point along the four space diagonals, times the root of 3."""
    a, b, c = x[i, 0], x[i, 1], x[i, 2]
    return a + b + c, a + b - c, a - b + c, b + c - a


@kernel(makes_arrays=False)
def overlap(a: float, b: float, c: float, d: float, far: float) -> bool:
    """Whether the intervals ab and cd come closer than `far`, without a branch."""
    return (min(a, b) <= max(c, d) + far) & (min(c, d) <= max(a, b) + far)


@kernel(makes_arrays=False)
def edges_near(x: np.ndarray, a: int, b: int, c: int, d: int, reach: float) -> bool:
    """Whether edges ab and cd share no node and come closer than a reach along space diagonals."""
    far = 1.7320508075688772 * reach
    a0, a1, a2, a3 = along(x, a)
    b0, b1, b2, b3 = along(x, b)
    c0, c1, c2, c3 = along(x, c)
    d0, d1, d2, d3 = along(x, d)
    near = overlap(a0, b0, c0, d0, far) & overlap(a1, b1, c1, d1, far)
    near &= overlap(a2, b2, c2, d2, far) & overlap(a3, b3, c3, d3, far)
    return near & (a != c) & (a != d) & (b != c) & (b != d)


@kernel(makes_arrays=False)
def between(p: float, a: float, b: float, c: float, far: float) -> bool:
    """Whether p lies among a, b and c, or no farther outside than `far`, without a branch."""
    return (p <= max(a, b, c) + far) & (p >= min(a, b, c) - far)


@kernel(makes_arrays=False)
def point_near(x: np.ndarray, p: int, a: int, b: int, c: int, reach: float) -> bool:
    """The same of point p and triangle abc."""
    far = 1.7320508075688772 * reach
    p0, p1, p2, p3 = along(x, p)
    a0, a1, a2, a3 = along(x, a)
    b0, b1, b2, b3 = along(x, b)
    c0, c1, c2, c3 = along(x, c)
    near = between(p0, a0, b0, c0, far) & between(p1, a1, b1, c1, far)
    near &= between(p2, a2, b2, c2, far) & between(p3, a3, b3, c3, far)
    return near & (p != a) & (p != b) & (p != c)


@kernel(makes_arrays=False)
def keep(
    x: np.ndarray,
    key: int,
    of_groups: int,
    features: Any,
    reach: float,
    work: Any,
    found: int,
    keys: np.ndarray,
    distance: np.ndarray,
    of: np.ndarray,
) -> int:
    """Note a pair if it is nearer than a reach [m]; the number of pairs found so far.

    features, work : what `closest` takes after the key, and arrays that it fills
    """
    triangles, edges, sides, owns, places = features
    nodes, w, r = work[0], work[1], work[2]
    corners = len(x) * len(triangles)
    d, _ = closest(x, key, corners, triangles, edges, sides, owns, places, nodes, w, r)
    if not d < reach:
        return found
    if found < len(keys):
        keys[found], distance[found], of[found] = key, d, of_groups
    return found + 1


@kernel(makes_arrays=False)
def sweep(
    x: np.ndarray,
    axis: int,
    one: np.ndarray,
    box_one: np.ndarray,
    ones: int,
    two: np.ndarray,
    box_two: np.ndarray,
    twos: int,
    size: float,
    pair: int,
    single: bool,
    numbers: np.ndarray,
    features: Any,
    reach: float,
    work: Any,
    found: int,
    keys: np.ndarray,
    distance: np.ndarray,
    of: np.ndarray,
) -> int:
    """Pairs of `ones` corners and `twos` triangles, or of edges, picked from two groups.

    one, two : places in the table of boxes, in their order along the axis, with their boxes
    size : float, longest box of the second [m]; single : whether both are edges of one group
    """
    triangles, edges = features[0], features[1]
    n, k, m = len(x), len(edges), len(triangles)
    near, first = work[3], 0
    for at in range(ones):
        a, count = one[at], 0
        high, low = box_one[at, 3 + axis], box_one[at, axis] - size
        # loaded once: the compiler cannot know that what is filled below is none of these
        l0, l1, l2 = box_one[at, 0], box_one[at, 1], box_one[at, 2]
        h0, h1, h2 = box_one[at, 3], box_one[at, 4], box_one[at, 5]
        while first < twos and box_two[first, axis] < low:
            first += 1
        for other in range(at + 1 if single else first, twos):
            if box_two[other, axis] > high:
                break
            near[count] = two[other]
            meets = (l0 <= box_two[other, 3]) & (box_two[other, 0] <= h0)
            meets &= (l1 <= box_two[other, 4]) & (box_two[other, 1] <= h1)
            count += meets & (l2 <= box_two[other, 5]) & (box_two[other, 2] <= h2)
        left = 0
        for other in range(count):
            b = near[other] - n
            if a < n:
                f = near[left] = b - k
                p, q, r = triangles[f, 0], triangles[f, 1], triangles[f, 2]
                left += point_near(x, a, p, q, r, reach)
            else:
                near[left] = b
                p, q, r = edges[a - n, 0], edges[a - n, 1], edges[b, 0]
                left += edges_near(x, p, q, r, edges[b, 1], reach)
        for other in range(left):
            f = near[other]
            key = numbers[min(a, n - 1)] * m + f
            if a >= n:
                key = n * m + min(a - n, f) * k + max(a - n, f)
            found = keep(x, key, pair, features, reach, work, found, keys, distance, of)
    return found


@kernel
def list_pairs(
    x: np.ndarray,
    triangles: np.ndarray,
    edges: np.ndarray,
    sides: np.ndarray,
    owns: np.ndarray,
    numbers: np.ndarray,
    places: np.ndarray,
    members: Any,
    wanted: np.ndarray,
    reach: float,
    keys: np.ndarray,
    distance: np.ndarray,
    of: np.ndarray,
) -> int:
    """Fill keys, distance, of (k,) with pairs nearer than a reach [m], in no order.

    x : (n, 3) [m]; triangles to places : see Features; members : Members
    wanted : (g, g) bool, symmetric, groups whose pairs are asked for
    of : int, the groups k and h that a pair belongs to, as k g + h

    Returns how many there are, more than k where they do not fit.
    """
    groups, found, most = len(wanted), 0, max(len(edges), len(triangles))
    features = (triangles, edges, sides, owns, places)
    near = np.empty(most, np.int64)
    work = (np.empty(4, np.int64), np.empty(4), np.empty(3), near)
    box, whole = np.empty((len(x) + len(edges) + len(triangles), 6)), np.empty((groups, 6))
    one, two = np.empty(most, np.int64), np.empty(most, np.int64)
    box_one, box_two = np.empty((most, 6)), np.empty((most, 6))
    set_boxes(x, triangles, edges, 0.5 * reach, box)
    axis = set_group_boxes(box, members, whole)
    near_sorted = members.axis[0] == axis
    members.axis[0] = axis
    sort_along(box, members.corners, members.first_corner, axis, near_sorted)
    sort_along(box, members.edges, members.first_edge, axis, near_sorted)
    sort_along(box, members.triangles, members.first_triangle, axis, near_sorted)
    for k in range(groups):
        for h in range(k + 1):
            if not (wanted[k, h] and meet(whole, k, whole, h)):
                continue
            for turn in range(3):
                g, i = (h, k) if turn == 1 else (k, h)
                if turn == 1 and k == h:
                    continue
                if turn < 2:
                    ones, _ = pick(
                        members.corners, members.first_corner[g], members.first_corner[g + 1],
                        box, whole, i, axis, one, box_one,
                    )  # fmt: skip
                    twos, size = pick(
                        members.triangles, members.first_triangle[i], members.first_triangle[i + 1],
                        box, whole, g, axis, two, box_two,
                    )  # fmt: skip
                else:
                    ones, _ = pick(
                        members.edges, members.first_edge[g], members.first_edge[g + 1],
                        box, whole, i, axis, one, box_one,
                    )  # fmt: skip
                    twos, size = pick(
                        members.edges, members.first_edge[i], members.first_edge[i + 1],
                        box, whole, g, axis, two, box_two,
                    )  # fmt: skip
                found = sweep(
                    x, axis, one, box_one, ones, two, box_two, twos, size, k * groups + h,
                    k == h and turn == 2, numbers, features, reach, work, found, keys, distance, of,
                )  # fmt: skip
    return found
