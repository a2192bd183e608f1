# SPDX-License-Identifier: LGPL-3.0-or-later
"""How the segments move over one step, as the contact loop needs it.

From t to t + dt a body takes the material point that coincides with x at t to x + drift,
drift = shift + turn @ (x - centre), from the two poses alone: drift / dt is the velocity of the
surface, v_c + omega x r at mid-step with an error of second order, and a point that sticks stays
where it is on the body for any number of steps.
"""

from typing import Any

import numpy as np

from contact.body.pose_check import first_jump
from contact.body.segment_sets import bits_of, moving_together
from contact.body.segments import Body
from contact.geometry.shape import SHAPE_FIELDS, set_shapes
from contact.kernel import kernel

# one record per segment: its shape, and its motion over the step, see `set_motion`
SEGMENT = np.dtype(
    [
        *SHAPE_FIELDS,
        ("bit", np.int64),  # number of its bit in sets of segments
        ("moving_together", np.int64),  # set of the segments that move as one with this
        ("centre", float, 3),  # at t [m]
        ("end_centre", float, 3),  # at t + dt [m]
        ("axes", float, (3, 3)),  # rows, at t
        ("end_axes", float, (3, 3)),  # at t + dt
        ("shift", float, 3),  # of the centre over the step [m]
        ("turn", float, (3, 3)),  # drift = shift + turn @ (x - centre)
        ("reach", float),  # bounding radius, offset and shift [m]
        ("contraction", float),  # |x - centre| contraction > reach + |step|: out of reach
        ("roundoff", float),  # of a distance [m]
    ]
)


def segment_records(body: Body) -> np.ndarray:
    """Records (m,) SEGMENT of a body, without its motion."""
    records = np.zeros(len(body.shapes), SEGMENT)
    set_shapes(body.shapes, records)
    records["bit"] = bits_of(body.carriers)
    records["moving_together"] = moving_together(body.carriers)
    return records


@kernel(makes_arrays=False)
def set_motion(
    start: np.ndarray,
    start_axes: np.ndarray,
    end: np.ndarray,
    end_axes: np.ndarray,
    offset: float,
    segments: np.ndarray,
) -> None:
    """Fill `segments` (m,) from centres (m, 3) and axes (m, 3, 3) at t and t + dt.

    offset : float, distance from the skin at which cloth is held [m]
    """
    for b in range(len(segments)):
        segment = segments[b]
        turning = moving = place = 0.0
        for k in range(3):
            segment.centre[k] = start[b, k]
            segment.end_centre[k] = end[b, k]
            segment.shift[k] = end[b, k] - start[b, k]
            moving += (end[b, k] - start[b, k]) ** 2
            place += start[b, k] ** 2
            for j in range(3):
                segment.axes[k, j] = start_axes[b, k, j]
                segment.end_axes[k, j] = end_axes[b, k, j]
                # A1^T A0 - 1 with A1^T A1 = 1: exactly zero for a body that does not turn
                entry = 0.0
                for i in range(3):
                    entry += end_axes[b, i, k] * (start_axes[b, i, j] - end_axes[b, i, j])
                segment.turn[k, j] = entry
                turning += entry * entry
        longest = segment.bounding_radius
        segment.reach = longest + offset + np.sqrt(moving)
        segment.contraction = max(0.0, 1.0 - np.sqrt(turning))
        segment.roundoff = 1e-14 * (longest + np.sqrt(place))


@kernel(makes_arrays=False)
def move_segments(
    centres: np.ndarray,
    axes: np.ndarray,
    velocities: np.ndarray,
    spins: np.ndarray,
    end_centres: np.ndarray,
    end_axes: np.ndarray,
    end_velocities: np.ndarray,
    end_spins: np.ndarray,
    extents: np.ndarray,
    dt: float,
    offset: float,
    segments: np.ndarray,
) -> tuple[int, float]:
    """`set_motion` and `first_jump` in one call: from two poses, see there."""
    set_motion(centres, axes, end_centres, end_axes, offset, segments)
    return first_jump(
        centres, axes, velocities, spins, end_centres, end_axes, end_velocities, end_spins,
        extents, dt,
    )  # fmt: skip


@kernel(makes_arrays=False)
def in_reach(x: np.ndarray, length: float, segments: np.ndarray, allowed: int) -> bool:
    """Whether a step of some length [m] from x can come near any segment it can touch."""
    for b in range(len(segments)):
        segment = segments[b]
        if not (allowed >> segment.bit) & 1:
            continue
        q0, q1, q2 = x[0] - segment.centre[0], x[1] - segment.centre[1], x[2] - segment.centre[2]
        limit = segment.reach + length
        near = segment.contraction * segment.contraction
        if (q0 * q0 + q1 * q1 + q2 * q2) * near <= limit * limit:
            return True
    return False


@kernel(makes_arrays=False)
def turned_by(matrix: np.ndarray, q0: float, q1: float, q2: float) -> tuple[float, float, float]:
    """Product of a matrix (3, 3) and a vector, in scalars."""
    return (
        matrix[0, 0] * q0 + matrix[0, 1] * q1 + matrix[0, 2] * q2,
        matrix[1, 0] * q0 + matrix[1, 1] * q1 + matrix[1, 2] * q2,
        matrix[2, 0] * q0 + matrix[2, 1] * q1 + matrix[2, 2] * q2,
    )


@kernel(makes_arrays=False)
def drift_of(segment: Any, q0: float, q1: float, q2: float) -> tuple[float, float, float]:
    """Way of the material point at centre + q over the step, in scalars [m]."""
    u0, u1, u2 = turned_by(segment.turn, q0, q1, q2)
    return u0 + segment.shift[0], u1 + segment.shift[1], u2 + segment.shift[2]
