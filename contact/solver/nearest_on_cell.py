# SPDX-License-Identifier: LGPL-3.0-or-later
"""The point of a cell, or of an edge of one, that is nearest to a segment of the body: Eq. 15.

The signed distance to a convex body is convex, and so it is along a straight edge. Its slope

    d'(tau) = n . (b - a),   n the normal at the foot of a + tau (b - a),

never falls; where it changes its sign is the nearest point, found between bounds by false position
(Illinois: an end that stays twice counts half). An edge has it at an end where the slope does not
change: that end is a node, which is met by itself.

In a cell of four nodes, x(a, b) bilinear, the same is done twice: along a for each b, and along b
with the slope of the least distance, n . dx/db. Distance is convex where a cell is plane; in a
twisted cell what is found is a nearest point nearby. Three nodes are four with the last one twice.

Everything is in the axes of the segment.
"""

from typing import Any

import numpy as np

from contact.geometry.shape import foot_and_normal
from contact.kernel import kernel

FLAT = 1e-9  # slope of the distance below which an edge is parallel to the surface
CLOSE = 1e-8  # of the edge: error of the place
BORDER = 1e-6  # of the cell, along which nearest points are those of the edge
ROUNDS = 60  # fewer than 15 are needed but where the edge goes through a centre line


@kernel
def _slope(segment, a, d, tau):
    """Slope of the distance at a + tau d, d of any length [m]."""
    _, _, _, _, n0, n1, n2 = foot_and_normal(
        segment, a[0] + tau * d[0], a[1] + tau * d[1], a[2] + tau * d[2]
    )
    return n0 * d[0] + n1 * d[1] + n2 * d[2]


@kernel
def _narrowed(low, high, falling, rising, side, tau, slope):
    """Bounds, slopes at them and the side that was moved last, after a look at tau."""
    if slope < 0.0:
        return tau, high, slope, rising * (0.5 if side < 0 else 1.0), -1
    return low, tau, falling * (0.5 if side > 0 else 1.0), slope, 1


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
        low, high, falling, rising, side = _narrowed(low, high, falling, rising, side, tau, slope)
    return tau


@kernel
def _slope_across(segment, x, b, line, way):
    """Nearest point of the line of constant b: its a, and the slope of the distance along b [m].

    x : (4, 3), the cell [m]; line, way : (3,), scratch
    """
    for c in range(3):
        line[c] = (1.0 - b) * x[0, c] + b * x[3, c]
        way[c] = (1.0 - b) * x[1, c] + b * x[2, c] - line[c]
    a = nearest_on_edge(segment, line, way)
    if a < 0.0:
        a = 1.0 if _slope(segment, line, way, 0.0) + _slope(segment, line, way, 1.0) < 0.0 else 0.0
    for c in range(3):
        line[c] += a * way[c]
        way[c] = (1.0 - a) * (x[3, c] - x[0, c]) + a * (x[2, c] - x[1, c])
    return a, _slope(segment, line, way, 0.0)


@kernel
def nearest_in_cell(
    segment: Any, x: np.ndarray, line: np.ndarray, way: np.ndarray
) -> tuple[float, float]:
    """Where inside a cell x (4, 3) [m] it is nearest to the segment: a and b, each from 0 to 1.

    x(a, b) = (1-a)(1-b) x_0 + a(1-b) x_1 + ab x_2 + (1-a)b x_3. line, way : (3,), scratch

    (-1, -1) where the nearest point is on an edge.
    """
    flat = 0.0
    for c in range(3):
        flat = max(flat, abs(x[3, c] - x[0, c]), abs(x[2, c] - x[1, c]))
    flat *= FLAT
    # short of 1, where the line of three nodes is a point
    low, high, side, a, b = 0.0, 1.0 - BORDER, 0, 0.0, 0.5
    _, falling = _slope_across(segment, x, 0.0, line, way)
    if falling >= -flat:
        return -1.0, -1.0
    _, rising = _slope_across(segment, x, high, line, way)
    if rising <= flat:
        return -1.0, -1.0
    for _ in range(ROUNDS):
        b = (low * rising - high * falling) / (rising - falling)
        a, slope = _slope_across(segment, x, b, line, way)
        if high - low < CLOSE or abs(slope) <= flat:
            break
        low, high, falling, rising, side = _narrowed(low, high, falling, rising, side, b, slope)
    if a <= 0.0 or a >= 1.0:
        return -1.0, -1.0
    return a, b
