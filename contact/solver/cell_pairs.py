# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pairs of an edge of the cells and a segment thinner than that edge is long: Eq. 15.

Nodes alone do not keep a rod out that passes between them. What lies between nodes is the edge, and
a straight rod cannot come through a sheet without crossing one: of every edge the point nearest to
the segment is met too, wherever it is (nearest_on_cell.py). With the plane that touches the segment
at its foot the whole edge is on the near side, as both are convex.

Most edges are far off. Those within a `skin` of a segment are listed, and the list holds until
nodes and body together have gone that far.
"""

import numpy as np

from contact.geometry.shape import foot_and_normal, least_distance
from contact.kernel import kernel

from .nearest_on_cell import nearest_on_edge
from .segment_motion import drift_of, turned_by
from .supporting_planes import first_contact

LONG = 0.1  # of radius and offset: for a longer way the path of the point is followed

# one record for each pair that may push in a step
PAIR = np.dtype(
    [
        ("nodes", np.int64, 2),
        ("weights", float, 2),  # of the nodes in the point that is met
        ("owner", np.int64),  # segment
        ("x", float, 3),  # the point at t [m]
        ("normal", float, 3),  # unit, out of the segment, at t + dt
        ("drift", float, 3),  # of the segment's material there, over the step [m]
        ("bound", float),  # admissible steps of the point have normal . step >= bound [m]
        ("depth", float),  # of the start below the offset surface [m], negative outside
        ("mass", float),  # with which it meets the segment [kg], see pair_impulses.py
        ("push", float),  # normal impulse [N s]
        ("friction", float, 3),  # [N s]
    ],
    align=True,
)


@kernel
def farthest(x: np.ndarray, place: np.ndarray) -> float:
    """Greatest distance [m] of points x (n, 3) from their places (n, 3)."""
    most = 0.0
    for i in range(len(x)):
        d0, d1, d2 = x[i, 0] - place[i, 0], x[i, 1] - place[i, 1], x[i, 2] - place[i, 2]
        most = max(most, d0 * d0 + d1 * d1 + d2 * d2)
    return np.sqrt(most)


@kernel
def _arm(x, segment):
    """From the centre of a segment to x (3,), in scalars."""
    return x[0] - segment.centre[0], x[1] - segment.centre[1], x[2] - segment.centre[2]


@kernel
def list_near(
    x: np.ndarray,
    edges: np.ndarray,
    lengths: np.ndarray,
    segments: np.ndarray,
    offset: float,
    skin: float,
    listed: np.ndarray,
) -> int:
    """Fill `listed` (k, 2) with edge and segment of all pairs within `skin` [m].

    Parameters
    ----------
    x : (n, 3), nodes at t [m]; edges : (e, 2) int, nodes
    lengths : (e,), at rest [m]: a segment at least as thick, offsets included, is left to nodes
    segments : (m,) SEGMENT; offset : [m]

    Returns
    -------
    How many there are; those that `listed` has no place for are counted only
    """
    count, middle = 0, np.empty(3)
    for e in range(len(edges)):
        half = 0.0
        for c in range(3):
            middle[c] = 0.5 * (x[edges[e, 0], c] + x[edges[e, 1], c])
            half += (middle[c] - x[edges[e, 0], c]) ** 2
        within = np.sqrt(half) + offset + skin
        for b in range(len(segments)):
            segment = segments[b]
            if 2.0 * (segment.inner_radius + offset) >= lengths[e]:
                continue
            q0, q1, q2 = _arm(middle, segment)
            far = segment.bounding_radius + within
            if q0 * q0 + q1 * q1 + q2 * q2 > far * far:
                continue
            y0, y1, y2 = turned_by(segment.axes, q0, q1, q2)
            if least_distance(segment, y0, y1, y2) > within:
                continue
            if count < len(listed):
                listed[count, 0], listed[count, 1] = e, b
            count += 1
    return count


@kernel
def _in_axes(segment, x, y):
    """Put a point x (3,) [m] at t into the axes of a segment."""
    q0, q1, q2 = _arm(x, segment)
    y[0], y[1], y[2] = turned_by(segment.axes, q0, q1, q2)


@kernel
def find_pairs(
    x: np.ndarray,
    v: np.ndarray,
    allowed: np.ndarray,
    edges: np.ndarray,
    listed: np.ndarray,
    segments: np.ndarray,
    dt: float,
    offset: float,
    recovery: float,
    pairs: np.ndarray,
) -> int:
    """Fill `pairs` (k,) PAIR with those of `listed` (k, 2) that can meet in a step of dt [s].

    Parameters
    ----------
    x, v : (n, 3), positions at t [m] and velocities [m/s]; allowed : (n,) int, sets of segments
    edges : (e, 2) int; segments : (m,) SEGMENT
    offset : [m]; recovery : way out in one step for a point that starts inside [m]

    Returns
    -------
    pairs filled
    """
    count = 0
    a, d, y, p = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    for k in range(len(listed)):
        e, b = listed[k, 0], listed[k, 1]
        i, j = edges[e, 0], edges[e, 1]
        segment = segments[b]
        if not (allowed[i] & allowed[j]) >> segment.bit & 1:
            continue
        _in_axes(segment, x[i], a)
        _in_axes(segment, x[j], d)
        for c in range(3):
            d[c] -= a[c]
        tau = nearest_on_edge(segment, a, d)
        if tau < 0.0:
            continue
        pair = pairs[count]
        pair.nodes[0], pair.nodes[1] = i, j
        pair.weights[0], pair.weights[1], pair.owner = 1.0 - tau, tau, b
        for c in range(3):
            y[c] = a[c] + tau * d[c]
            pair.x[c] = (1.0 - tau) * x[i, c] + tau * x[j, c]
        q0, q1, q2 = _arm(pair.x, segment)
        u0, u1, u2 = drift_of(segment, q0, q1, q2)
        pair.drift[0], pair.drift[1], pair.drift[2] = u0, u1, u2
        way = 0.0
        for c in range(3):
            p[c] = dt * ((1.0 - tau) * v[i, c] + tau * v[j, c]) - pair.drift[c]
            way += p[c] * p[c]
        way = np.sqrt(way)
        foot = foot_and_normal(segment, y[0], y[1], y[2])
        gap, n0, n1, n2 = foot[0] - offset, foot[4], foot[5], foot[6]
        if gap > way:
            continue
        if gap > segment.roundoff and way > LONG * (segment.inner_radius + offset):
            p0, p1, p2 = turned_by(segment.end_axes, p[0], p[1], p[2])
            met, _, n0, n1, n2, gap = first_contact(
                segment, y[0], y[1], y[2], p0, p1, p2, offset, foot
            )
            if met > 1.0:
                continue
        pair.depth, pair.push = -gap, 0.0
        pair.bound = min(-gap, recovery)
        for c in range(3):
            axes = segment.end_axes
            pair.normal[c] = n0 * axes[0, c] + n1 * axes[1, c] + n2 * axes[2, c]
            pair.bound += pair.normal[c] * pair.drift[c]
            pair.friction[c] = 0.0
        count += 1
    return count
