# SPDX-License-Identifier: LGPL-3.0-or-later
"""The point of a cell, or of an edge of one, that is nearest to a segment of the body: Eq. 15.

The signed distance to a convex body is convex, and so it is along a straight edge. Its slope

    d'(tau) = n . (b - a),   n the normal at the foot of a + tau (b - a),

never falls; where it changes its sign is the nearest point, found between bounds by false position
(Illinois: an end that stays twice counts half). An edge has it at an end where the slope does not
change: that end is a node, which is met by itself.

Everything is in the axes of the segment.
"""

from typing import Any

import numpy as np

from contact.geometry.shape import foot_and_normal
from contact.kernel import kernel

FLAT = 1e-9  # slope of the distance below which an edge is parallel to the surface
CLOSE = 1e-8  # of the edge: error of the place
ROUNDS = 60  # fewer than 15 are needed but where the edge goes through a centre line


@kernel
def _slope(segment, a, d, tau):
    """Slope of the distance at a + tau d, d of any length [m]."""
    _, _, _, _, n0, n1, n2 = foot_and_normal(
        segment, a[0] + tau * d[0], a[1] + tau * d[1], a[2] + tau * d[2]
    )
    return n0 * d[0] + n1 * d[1] + n2 * d[2]


@kernel
def nearest_on_edge(segment: Any, a: np.ndarray, d: np.ndarray) -> float:
    """Fraction tau, 0 < tau < 1, at which a + tau d (3,) is nearest to the segment [m].

    -1 where the nearest point is an end, or all of the edge is as near.
    """
    flat = FLAT * np.sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2])
    low, high = 0.0, 1.0
    falling, rising = _slope(segment, a, d, 0.0), _slope(segment, a, d, 1.0)
    if falling >= -flat or rising <= flat:
        return -1.0
    tau, side = 0.5, 0
    for _ in range(ROUNDS):
        tau = (low * rising - high * falling) / (rising - falling)
        if high - low < CLOSE:
            break
        slope = _slope(segment, a, d, tau)
        if abs(slope) <= 1e-3 * flat:
            break
        if slope < 0.0:
            low, falling = tau, slope
            rising *= 0.5 if side < 0 else 1.0
            side = -1
        else:
            high, rising = tau, slope
            falling *= 0.5 if side > 0 else 1.0
            side = 1
    return tau
