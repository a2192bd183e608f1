# SPDX-License-Identifier: LGPL-3.0-or-later
"""Broad phase: which segments a node cannot meet for a while, as most cloth is near one or none.

Measured is how far a node is from every segment. Those beyond a margin are `far`, and need not be
asked again before the node and the body together have gone as far as the nearest of them was away,
the node's clearance: a surface moves by no more than |shift| + |turn| r in a step, r its bounding
radius, see segment_motion.py. What is left out could not have changed the step: the plane of its
closest point, carried along, would lie behind it.

Positions are compared with the place of the measurement, so a node may be moved by anybody in
between; after a pose that does not follow the last one everything is measured anew.
"""

from typing import Any

import numpy as np

from contact.geometry.shape import foot_and_normal, least_distance
from contact.kernel import kernel

from .segment_motion import turned_by
from .step_record import ALLOWED, FAR

STEPS = 12  # that a measurement should last
LEAST = 1e-3  # margin in smallest inner radii
KEPT = 0.99  # of a distance, for turns of up to MOST_TURN a step: 1 - turn^2
MOST_TURN = 0.1  # radians a step, above which nothing is left out


@kernel(makes_arrays=False)
def surface_motion(segments: np.ndarray, offset: float) -> tuple[float, float]:
    """Bound [m] on the way of any surface point in this step, smallest inner radius [m] of all."""
    most, thinnest, turned = 0.0, np.inf, 0.0
    for b in range(len(segments)):
        segment = segments[b]
        shift = turning = 0.0
        for k in range(3):
            shift += segment.shift[k] * segment.shift[k]
            for j in range(3):
                turning += segment.turn[k, j] * segment.turn[k, j]
        turning = np.sqrt(turning)
        most = max(most, np.sqrt(shift) + turning * (segment.bounding_radius + offset))
        thinnest, turned = min(thinnest, segment.inner_radius), max(turned, turning)
    return (most if turned <= MOST_TURN else np.inf), thinnest


@kernel(makes_arrays=False)
def clearance_left(x: np.ndarray, i: int, path: float, motion: float, look: np.ndarray) -> float:
    """What is left [m] of the clearance of node i for its step, the body's motion taken off.

    look : (5, n), see `LOOK`
    """
    d0, d1, d2 = x[i, 0] - look[0, i], x[i, 1] - look[1, i], x[i, 2] - look[2, i]
    return look[3, i] - np.sqrt(d0 * d0 + d1 * d1 + d2 * d2) - (path - look[4, i]) - motion


@kernel(makes_arrays=False)
def mark_away(
    x: np.ndarray,
    v: np.ndarray,
    mass: np.ndarray,
    dt: float,
    path: float,
    motion: float,
    fixed: np.ndarray,
    sets: np.ndarray,
    look: np.ndarray,
    frame: np.ndarray,
    shift: np.ndarray,
    away: np.ndarray,
) -> None:
    """Fill away (n,) float: >= 0 for nodes whose step cannot come near a segment, as most cannot.

    frame, shift (3,) : of the frame in which looks are, see `STEP`

    Nodes that are not finite get a number that is not. Loops without branches, with few arrays and
    strides that the compiler knows, which run in vector registers.
    """
    place, speed = x.reshape(x.size), v.reshape(v.size)
    p0, p1, p2, clearance, since = look[0], look[1], look[2], look[3], look[4]
    allowed, far = sets[ALLOWED], sets[FAR]
    o0, o1, o2, s0, s1, s2 = frame[0], frame[1], frame[2], shift[0], shift[1], shift[2]
    for i in range(len(away)):
        d0, d1 = place[3 * i] - o0 - p0[i], place[3 * i + 1] - o1 - p1[i]
        d2 = place[3 * i + 2] - o2 - p2[i]
        away[i] = np.sqrt(d0 * d0 + d1 * d1 + d2 * d2)
    for i in range(len(away)):
        u0, u1 = dt * speed[3 * i] - s0, dt * speed[3 * i + 1] - s1
        u2 = dt * speed[3 * i + 2] - s2
        reach = np.sqrt(u0 * u0 + u1 * u1 + u2 * u2)
        away[i] = clearance[i] - away[i] - (path - since[i]) - motion - reach
    for i in range(len(away)):
        left = away[i]
        kept = left if (allowed[i] & ~far[i]) == 0 else -1.0
        kept = 0.0 if fixed[i] & (left - left == 0.0) else kept
        away[i] = kept if (mass[i] > 0.0) & (mass[i] < np.inf) else -1.0


@kernel(makes_arrays=False)
def measure(
    x: np.ndarray,
    i: int,
    path: float,
    margin: float,
    segments: np.ndarray,
    offset: float,
    sets: np.ndarray,
    look: np.ndarray,
) -> int:
    """Measure how far node i is from the segments that it can touch; fills its look.

    Others are not far: it may be able to touch them later. Returns closest points evaluated.
    """
    x0, x1, x2, allowed = x[i, 0], x[i, 1], x[i, 2], sets[ALLOWED, i]
    evaluated, near, clearance = 0, ~allowed, np.inf
    for b in range(len(segments)):
        segment = segments[b]
        if not (allowed >> segment.bit) & 1:
            continue
        q0, q1, q2 = x0 - segment.centre[0], x1 - segment.centre[1], x2 - segment.centre[2]
        gap = np.sqrt(q0 * q0 + q1 * q1 + q2 * q2) - segment.bounding_radius - offset
        if KEPT * gap <= margin:
            y0, y1, y2 = turned_by(segment.axes, q0, q1, q2)
            gap = max(gap, least_distance(segment, y0, y1, y2) - offset)
            if KEPT * gap <= margin:
                gap = foot_and_normal(segment, y0, y1, y2)[0] - offset
                evaluated += 1
        if KEPT * gap <= margin:
            near |= np.int64(1) << segment.bit
        else:
            clearance = min(clearance, KEPT * gap - segment.roundoff)
    if clearance == np.inf:  # all are near: measure again some time
        clearance = 2.0 * margin
    look[0, i], look[1, i], look[2, i] = x0, x1, x2
    look[3, i], look[4, i] = clearance, path
    sets[FAR, i] = ~near
    return evaluated


@kernel(makes_arrays=False)
def may_meet(
    x: np.ndarray,
    i: int,
    reach: float,
    work: Any,
    segments: np.ndarray,
    sets: np.ndarray,
    look: np.ndarray,
) -> bool:
    """Whether a step of node i of length `reach` [m] can come near a segment; measures if needed.

    `work.clearance` is set.
    """
    left = clearance_left(x, i, work.path, work.motion, look)
    if left < reach and work.motion < np.inf:
        margin = max(STEPS * (reach + work.motion), LEAST * work.thinnest)
        work.evaluated += measure(x, i, work.path, margin, segments, work.offset, sets, look)
        left = clearance_left(x, i, work.path, work.motion, look)
    if left < reach:
        sets[FAR, i] = 0
    work.clearance = left
    return (sets[ALLOWED, i] & ~sets[FAR, i]) != 0
