# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pairs of a corner and a triangle, and of two edges, that come closer than a reach.

A list is made for pairs of groups of triangles (trust_region.py), one after another: of both groups
those corners, edges and triangles whose boxes meet the box of the other group, swept along the
longest side of the sheet (boxes.py). What a list costs goes with the pairs of groups that ask for
it. A pair has a key:

    p m + f                          corner p, triangle f of m
    n m + e k + f, e < f             edges e and f of k, n being the number of nodes

which is the same on any number of ranks. Pairs that share a node are left out.
"""

from typing import Any

import numpy as np

from contact.kernel import kernel

from .boxes import meet, pick, set_boxes, set_group_boxes, sort_along
from .closest_points import closest


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

    x : (n, 3) [m]; triangles to places : see Features; members : the arrays of Members
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
    points, first_point, sides_of, first_side, faces, first_face, last_axis = members
    axis = set_group_boxes(box, faces, first_face, whole)
    near_sorted = last_axis[0] == axis
    last_axis[0] = axis
    sort_along(box, points, first_point, axis, near_sorted)
    sort_along(box, sides_of, first_side, axis, near_sorted)
    sort_along(box, faces, first_face, axis, near_sorted)
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
                        points, first_point[g], first_point[g + 1],
                        box, whole, i, axis, one, box_one,
                    )  # fmt: skip
                    twos, size = pick(
                        faces, first_face[i], first_face[i + 1],
                        box, whole, g, axis, two, box_two,
                    )  # fmt: skip
                else:
                    ones, _ = pick(
                        sides_of, first_side[g], first_side[g + 1],
                        box, whole, i, axis, one, box_one,
                    )  # fmt: skip
                    twos, size = pick(
                        sides_of, first_side[i], first_side[i + 1],
                        box, whole, g, axis, two, box_two,
                    )  # fmt: skip
                found = sweep(
                    x, axis, one, box_one, ones, two, box_two, twos, size, k * groups + h,
                    k == h and turn == 2, numbers, features, reach, work, found, keys, distance, of,
                )  # fmt: skip
    return found
