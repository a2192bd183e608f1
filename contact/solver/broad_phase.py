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

STEPS = 12  # that a measurement should last
LEAST = 1e-3  # margin in smallest inner radii
KEPT = 0.99  # of a distance, for turns of up to MOST_TURN a step: 1 - turn^2
MOST_TURN = 0.1  # radians a step, above which nothing is left out


@kernel
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


@kernel
def clearance_left(x: np.ndarray, path: float, motion: float, node: Any) -> float:
    """What is left [m] of the clearance of a node for its step, the body's motion taken off."""
    d0, d1, d2 = x[0] - node.place[0], x[1] - node.place[1], x[2] - node.place[2]
    return node.clearance - np.sqrt(d0 * d0 + d1 * d1 + d2 * d2) - (path - node.path) - motion


@kernel
def measure(
    x: np.ndarray, path: float, margin: float, segments: np.ndarray, offset: float, node: Any
) -> int:
    """Measure how far a node is from the segments that it can touch; fills its record.

    Others are not far: it may be able to touch them later. Returns closest points evaluated.
    """
    evaluated, near, clearance = 0, ~node.allowed, np.inf
    for b in range(len(segments)):
        segment = segments[b]
        if not (node.allowed >> segment.bit) & 1:
            continue
        q0, q1, q2 = x[0] - segment.centre[0], x[1] - segment.centre[1], x[2] - segment.centre[2]
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
    node.place[0], node.place[1], node.place[2] = x[0], x[1], x[2]
    node.far, node.clearance, node.path = ~near, clearance, path
    return evaluated
