# SPDX-License-Identifier: LGPL-3.0-or-later
"""How the ellipsoids move over one step, as the contact loop needs it.

From t to t + dt a body takes the material point that coincides with x at t to x + drift,
drift = shift + turn @ (x - centre), from the two poses alone: drift / dt is the velocity of the
surface, v_c + omega x r at mid-step with an error of second order, and a point that sticks stays
where it is on the body for any number of steps.

Sets of segments are whole numbers. Of a body of up to 62 segments bit b stands for segment b; of a
larger one a bit stands for all segments on one carrier, or for all from the 63rd on (`bits_of`).
"""

import numpy as np
from numba import njit

# one record per ellipsoid: its motion over the step, see `set_travel`
TRAVEL = np.dtype(
    [
        ("centre", float, 3),  # at t [m]
        ("axes", float, (3, 3)),  # rows, at t
        ("end_axes", float, (3, 3)),  # at t + dt
        ("shift", float, 3),  # of the centre over the step [m]
        ("turn", float, (3, 3)),  # drift = shift + turn @ (x - centre)
        ("radii", float, 3),  # [m]
        ("shortest", float),  # of the radii
        ("sharpest", float),  # smallest radius of curvature [m]
        ("far", float),  # |x - centre| near > far + |step|: out of reach
        ("near", float),
        ("slack", float),  # roundoff of a distance [m]
        ("bit", np.int64),  # number of its bit in sets
        ("mates", np.int64),  # set of the ellipsoids that move as one with this
    ]
)


@njit(cache=True, error_model="numpy")
def set_travel(start, start_axes, end, end_axes, radii, offset, travel):
    """Fill `travel` (m,) from centres (m, 3) and axes (m, 3, 3) at t and t + dt."""
    for b in range(len(travel)):
        body = travel[b]
        turning = moving = place = 0.0
        for k in range(3):
            body.centre[k] = start[b, k]
            body.shift[k] = end[b, k] - start[b, k]
            body.radii[k] = radii[b, k]
            moving += (end[b, k] - start[b, k]) ** 2
            place += start[b, k] ** 2
            for j in range(3):
                body.axes[k, j] = start_axes[b, k, j]
                body.end_axes[k, j] = end_axes[b, k, j]
                # A1^T A0 - 1 with A1^T A1 = 1: exactly zero for a body that does not turn
                entry = 0.0
                for i in range(3):
                    entry += end_axes[b, i, k] * (start_axes[b, i, j] - end_axes[b, i, j])
                body.turn[k, j] = entry
                turning += entry * entry
        longest = max(radii[b, 0], radii[b, 1], radii[b, 2])
        body.shortest = min(radii[b, 0], radii[b, 1], radii[b, 2])
        body.sharpest = body.shortest * body.shortest / longest
        body.far = longest + offset + np.sqrt(moving)
        body.near = max(0.0, 1.0 - np.sqrt(turning))
        body.slack = 1e-14 * (longest + np.sqrt(place))


@njit(cache=True, error_model="numpy")
def in_reach(x, reach, travel, allowed):
    """Whether a step of length `reach` [m] from x can come near any ellipsoid it can touch."""
    for b in range(len(travel)):
        body = travel[b]
        if not (allowed >> body.bit) & 1:
            continue
        q0, q1, q2 = x[0] - body.centre[0], x[1] - body.centre[1], x[2] - body.centre[2]
        limit = body.far + reach
        if (q0 * q0 + q1 * q1 + q2 * q2) * (body.near * body.near) <= limit * limit:
            return True
    return False


@njit(cache=True, error_model="numpy")
def turned_by(matrix, q0, q1, q2):
    """Product of a matrix (3, 3) and a vector, in scalars."""
    return (
        matrix[0, 0] * q0 + matrix[0, 1] * q1 + matrix[0, 2] * q2,
        matrix[1, 0] * q0 + matrix[1, 1] * q1 + matrix[1, 2] * q2,
        matrix[2, 0] * q0 + matrix[2, 1] * q1 + matrix[2, 2] * q2,
    )
