# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pairs of a piece of the sheet, an edge or a cell, and a segment that can pass between its nodes.

Nodes alone do not keep a rod out that passes between them (thin_segments.py). What lies between
nodes is the edge, and a straight rod cannot come through a sheet without crossing one; what lies
between edges is the inside of a cell, where the end of a rod or a ball comes through. Of every
piece the point nearest to the segment is met too (Eq. 15, nearest_on_cell.py). With the plane that
touches the segment at its foot the whole of a plane piece is on the near side, as both are convex.

The inside of a cell is met only where it is nearer to the segment than all its edges: a rod that
lies across a cell leaves it to them.

Most pieces are far off. Those within a `skin` of a segment are listed, and the list holds until
nodes and body together have gone that far.
"""

import numpy as np

from contact.geometry.shape import foot_and_normal, least_distance
from contact.kernel import kernel

from .nearest_on_cell import nearest_in_cell, nearest_on_edge
from .segment_motion import drift_of, turned_by
from .supporting_planes import first_contact

CORNERS = 4  # nodes of a piece at most
NEARER = 1e-3  # of radius and offset, by which the inside of a cell is nearer than its edges
LONG = 0.1  # of radius and offset: for a longer way the path of the point is followed

# one record for each pair that may push in a step
PAIR = np.dtype(
    [
        ("nodes", np.int64, CORNERS),
        ("weights", float, CORNERS),  # of the nodes in the point that is met
        ("owner", np.int64),  # segment
        ("x", float, 3),  # the point at t [m]
        ("normal", float, 3),  # unit, out of the segment, at t + dt
        ("drift", float, 3),  # of the segment's material there, over the step [m]
        ("bound", float),  # admissible steps of the point have normal . step >= bound [m]
        ("depth", float),  # of the start below the offset surface [m], negative outside
        ("lacks", float),  # normal velocity that it needs more [m/s]
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
def corners_of(piece: np.ndarray) -> int:
    """Nodes of a piece (4,) int: those before the first -1."""
    count = 0
    while count < CORNERS and piece[count] >= 0:
        count += 1
    return count


@kernel
def list_near(
    x: np.ndarray,
    pieces: np.ndarray,
    widths: np.ndarray,
    segments: np.ndarray,
    offset: float,
    skin: float,
    listed: np.ndarray,
) -> int:
    """Fill `listed` (k, 2) with piece and segment of all pairs within `skin` [m].

    Parameters
    ----------
    x : (n, 3), nodes at t [m]; pieces : (e, 4) int, nodes, then -1
    widths : (e,) [m]: a segment at least as thick, offsets included, is left to nodes
    segments : (m,) SEGMENT; offset : [m]

    Returns
    -------
    How many there are; those that `listed` has no place for are counted only
    """
    count, middle = 0, np.empty(3)
    for e in range(len(pieces)):
        corners, half = corners_of(pieces[e]), 0.0
        for c in range(3):
            middle[c] = 0.0
            for a in range(corners):
                middle[c] += x[pieces[e, a], c] / corners
        for a in range(corners):
            square = 0.0
            for c in range(3):
                square += (middle[c] - x[pieces[e, a], c]) ** 2
            half = max(half, square)
        within = np.sqrt(half) + offset + skin
        for b in range(len(segments)):
            segment = segments[b]
            if 2.0 * (segment.inner_radius + offset) >= widths[e]:
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
def _distance(segment, y):
    return foot_and_normal(segment, y[0], y[1], y[2])[0]


@kernel
def _nearest(segment, corners, y, offset, weights, line, way):
    """Weights (4,) of the point of a piece that is nearest; False where that is a node or an edge.

    y : (4, 3), nodes of the piece in the segment's axes [m]; line, way : (3,), scratch
    """
    weights[:] = 0.0
    if corners == 2:
        for c in range(3):
            way[c] = y[1, c] - y[0, c]
        tau = nearest_on_edge(segment, y[0], way)
        weights[0], weights[1] = 1.0 - tau, tau
        return tau >= 0.0
    for k in range(corners, CORNERS):
        y[k] = y[corners - 1]
    a, b = nearest_in_cell(segment, y, line, way)
    if a < 0.0:
        return False
    inside = (1.0 - a) * (1.0 - b), a * (1.0 - b), a * b, (1.0 - a) * b
    line[:] = 0.0
    for k in range(CORNERS):
        weights[min(k, corners - 1)] += inside[k]
        for c in range(3):
            line[c] += inside[k] * y[k, c]
    least = _distance(segment, line) + NEARER * (segment.inner_radius + offset)
    for k in range(corners):
        for c in range(3):
            way[c] = y[(k + 1) % corners, c] - y[k, c]
        tau = max(0.0, nearest_on_edge(segment, y[k], way))
        for c in range(3):
            way[c] = y[k, c] + tau * way[c]
        if _distance(segment, way) < least:
            return False
    return True


@kernel
def find_pairs(
    x: np.ndarray,
    v: np.ndarray,
    allowed: np.ndarray,
    pieces: np.ndarray,
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
    pieces : (e, 4) int, see `list_near`; segments : (m,) SEGMENT
    offset : [m]; recovery : way out in one step for a point that starts inside [m]

    Returns
    -------
    pairs filled
    """
    count = 0
    local, y, p = np.empty((CORNERS, 3)), np.empty(3), np.empty(3)
    weights, line, along = np.empty(CORNERS), np.empty(3), np.empty(3)
    for k in range(len(listed)):
        piece, b = pieces[listed[k, 0]], listed[k, 1]
        corners, segment, touchable = corners_of(piece), segments[b], -1
        for a in range(corners):
            touchable &= allowed[piece[a]]
            _in_axes(segment, x[piece[a]], local[a])
        if not touchable >> segment.bit & 1:
            continue
        if not _nearest(segment, corners, local, offset, weights, line, along):
            continue
        pair = pairs[count]
        pair.owner = b
        y[:], pair.x[:], p[:] = 0.0, 0.0, 0.0
        for a in range(CORNERS):
            # places without a node repeat the first, at no weight
            i, w = piece[a] if a < corners else piece[0], weights[a]
            pair.nodes[a], pair.weights[a] = i, w
            for c in range(3):
                pair.x[c] += w * x[i, c]
                p[c] += w * dt * v[i, c]
        _in_axes(segment, pair.x, y)
        q0, q1, q2 = _arm(pair.x, segment)
        u0, u1, u2 = drift_of(segment, q0, q1, q2)
        pair.drift[0], pair.drift[1], pair.drift[2] = u0, u1, u2
        far = 0.0
        for c in range(3):
            p[c] -= pair.drift[c]
            far += p[c] * p[c]
        far = np.sqrt(far)
        foot = foot_and_normal(segment, y[0], y[1], y[2])
        gap, n0, n1, n2 = foot[0] - offset, foot[4], foot[5], foot[6]
        if gap > far:
            continue
        if gap > segment.roundoff and far > LONG * (segment.inner_radius + offset):
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
