# SPDX-License-Identifier: LGPL-3.0-or-later
"""What bounds the step of one node: a supporting plane for every segment it may reach.

Everything is seen from the moving body (segment_motion.py): a point that stays with the body makes
the step `drift`, one that makes `step` moves by step - drift relative to it, straight in the body's
axes.

A segment, also one grown by the offset, is convex: a plane that touches it where the path first
meets it has the start on one side and the whole segment on the other. A step that ends on the
near side can neither end inside nor have passed through, at any speed, and the velocity towards the
body is reduced, never reversed: kinetic energy relative to the body cannot grow. The path goes
straight to the first body met, from there on to where that body's plane lets it, and so on.

For a short step the plane at the closest point to the start does as well: only a layer of thickness
step^2 / (2 R) above the surface differs. A point in contact is of this kind and costs one
closest point.
"""

from typing import Any

import numpy as np

from contact.geometry.shape import foot_and_normal, least_distance
from contact.kernel import kernel

from .segment_motion import drift_of, turned_by

LONG_STEP = 1e-3  # of the smallest radius of curvature: the layer is half a millionth of it
MAX_ADVANCES = 60
HYSTERESIS = 0.05  # of the depth


# one record per plane found for a node
PLANE = np.dtype(
    [
        ("owner", np.int64),  # segment
        ("normal", float, 3),  # unit, out of the segment, at t + dt
        ("drift", float, 3),  # of the material point at the start [m]
        ("bound", float),  # admissible steps have normal . step >= bound [m]
        ("depth", float),  # of the start below the offset surface [m], negative outside
        ("push", float),  # correction along the normal [m]
        ("friction", float, 3),  # correction by friction [m]
    ]
)


@kernel(makes_arrays=False)
def first_contact(
    segment: Any,
    y0: float,
    y1: float,
    y2: float,
    p0: float,
    p1: float,
    p2: float,
    offset: float,
    foot: tuple,
) -> tuple[float, int, float, float, float, float]:
    """Where the path y + tau p, 0 <= tau <= 1, first comes to the offset surface.

    The distance to a convex set is convex along a line, so Newton from outside never passes the
    place. foot : what `foot_and_normal` gives for y. Returns tau (2: not met), evaluations, unit
    normal, height of y over the plane there.
    """
    tau = 0.0
    near = 1e-12 * segment.inner_radius
    for evaluated in range(MAX_ADVANCES):
        if evaluated > 0:
            foot = foot_and_normal(segment, y0 + tau * p0, y1 + tau * p1, y2 + tau * p2)
        d, x0, x1, x2, n0, n1, n2 = foot
        slope = n0 * p0 + n1 * p1 + n2 * p2
        if d - offset <= near or (slope < 0.0 and evaluated == MAX_ADVANCES - 1):
            over = n0 * (y0 - x0) + n1 * (y1 - x1) + n2 * (y2 - x2) - offset
            return tau, evaluated, n0, n1, n2, over
        if slope >= 0.0:
            break
        tau -= (d - offset) / slope
        if tau >= 1.0:
            break
    return 2.0, evaluated, 0.0, 0.0, 0.0, 0.0


@kernel(makes_arrays=False)
def set_plane(
    plane: Any,
    owner: int,
    segment: Any,
    n0: float,
    n1: float,
    n2: float,
    height: float,
    depth: float,
    u0: float,
    u1: float,
    u2: float,
) -> None:
    """Fill one record from a normal in the segment's axes and the height above the start."""
    axes = segment.end_axes
    plane.owner, plane.depth, plane.push = owner, depth, 0.0
    plane.drift[0], plane.drift[1], plane.drift[2] = u0, u1, u2
    plane.bound = height
    for k in range(3):
        plane.normal[k] = n0 * axes[0, k] + n1 * axes[1, k] + n2 * axes[2, k]
        plane.bound += plane.normal[k] * plane.drift[k]
        plane.friction[k] = 0.0


@kernel(makes_arrays=False)
def _length_of_path(work):
    """No less than how far from the start the rest of the path may lead [m]."""
    step, at = work.step, work.at
    length = np.sqrt(step[0] * step[0] + step[1] * step[1] + step[2] * step[2])
    if work.tau > 0.0:
        length += np.sqrt(at[0] * at[0] + at[1] * at[1] + at[2] * at[2])
    return length


@kernel(makes_arrays=False)
def _has_plane(planes, count, b):
    """Whether segment b is among the owners of the first planes."""
    listed = False
    for k in range(count):
        listed = listed or planes[k].owner == b
    return listed


@kernel(makes_arrays=False)
def find_planes(
    x: np.ndarray, allowed: int, far: int, work: Any, segments: np.ndarray, planes: np.ndarray
) -> int:
    """Add planes of the segments that the next leg of the path may reach and that have none yet.

    The leg goes from x + at, at the fraction tau of the step, to x + step at its end. All segments
    are added for which it is short. If there are none, the one is added that the leg meets first,
    and `at` moves there.

    Parameters
    ----------
    x : (3,) float, node at t [m]
    allowed : int, set of the segments that the node can touch
    far : int, set of the segments that a step as long as `work.clearance` cannot reach
    work : STEP; at, tau, step : the leg; count : planes there already
    segments : (m,) SEGMENT; planes : (m,) PLANE, filled

    Returns
    -------
    planes there now; `work.at` and `work.tau` are where the next leg begins
    """
    at, step, tau, offset = work.at, work.step, work.tau, work.offset
    reach = _length_of_path(work)
    if reach <= work.clearance:
        allowed &= ~far
    known = count = work.count
    soonest, rest = 2.0, 1.0 - tau
    for b in range(len(segments)):
        segment = segments[b]
        if not (allowed >> segment.bit) & 1:
            continue
        q0, q1, q2 = x[0] - segment.centre[0], x[1] - segment.centre[1], x[2] - segment.centre[2]
        limit = segment.reach + reach
        near = segment.contraction * segment.contraction
        if (q0 * q0 + q1 * q1 + q2 * q2) * near > limit * limit:
            continue
        if _has_plane(planes, count, b):
            continue
        # drift of the material point; start x, begin of the leg and leg as the body sees them
        u0, u1, u2 = drift_of(segment, q0, q1, q2)
        x0, x1, x2 = turned_by(segment.axes, q0, q1, q2)
        y0, y1, y2 = x0, x1, x2
        if tau > 0.0:
            p0, p1, p2 = at[0] - tau * u0, at[1] - tau * u1, at[2] - tau * u2
            p0, p1, p2 = turned_by(segment.end_axes, p0, p1, p2)
            y0, y1, y2 = x0 + p0, x1 + p1, x2 + p2
        p0, p1, p2 = step[0] - at[0], step[1] - at[1], step[2] - at[2]
        p0, p1, p2 = p0 - rest * u0, p1 - rest * u1, p2 - rest * u2
        way = np.sqrt(p0 * p0 + p1 * p1 + p2 * p2)
        if least_distance(segment, y0, y1, y2) > offset + way:
            continue
        foot = foot_and_normal(segment, y0, y1, y2)
        distance, _, _, _, n0, n1, n2 = foot
        work.evaluated += 1
        gap = distance - offset
        if gap > way:
            continue
        long = gap > segment.roundoff and way > LONG_STEP * segment.curvature_radius
        if long and count > known:
            continue  # first see where the planes found lead
        if long:
            p0, p1, p2 = turned_by(segment.end_axes, p0, p1, p2)
            met, more, n0, n1, n2, gap = first_contact(
                segment, y0, y1, y2, p0, p1, p2, offset, foot
            )
            work.evaluated += more
            if met >= soonest:
                continue
            soonest = met
        height = min(-gap, work.recovery)
        if tau > 0.0:
            height += n0 * (y0 - x0) + n1 * (y1 - x1) + n2 * (y2 - x2)
            if height > 0.0:  # the start is behind this plane: take one that has it in front
                distance, _, _, _, n0, n1, n2 = foot_and_normal(segment, x0, x1, x2)
                work.evaluated += 1
                height = min(offset - distance, 0.0)
        set_plane(planes[count], b, segment, n0, n1, n2, height, -gap, u0, u1, u2)
        count += not long
    if count == known and soonest <= 1.0:
        for k in range(3):
            at[k] += soonest * (step[k] - at[k])
        work.tau += soonest * rest
        count += 1
    return count


@kernel(makes_arrays=False)
def _is_outside(x, k, work, segments, count, planes):
    """Whether the foot of plane k, on the offset surface at t + dt, is in no other segment."""
    plane = planes[k]
    f0 = x[0] + plane.drift[0] + plane.depth * plane.normal[0]
    f1 = x[1] + plane.drift[1] + plane.depth * plane.normal[1]
    f2 = x[2] + plane.drift[2] + plane.depth * plane.normal[2]
    outside = True
    for j in range(count):
        if j == k:
            continue
        segment = segments[planes[j].owner]
        y0, y1, y2 = turned_by(
            segment.end_axes,
            f0 - segment.centre[0] - segment.shift[0],
            f1 - segment.centre[1] - segment.shift[1],
            f2 - segment.centre[2] - segment.shift[2],
        )
        distance = foot_and_normal(segment, y0, y1, y2)[0]
        outside = outside and distance > work.offset - 1e3 * segment.roundoff
    return outside


@kernel(makes_arrays=False)
def keep_one_exit(
    x: np.ndarray, last: int, work: Any, segments: np.ndarray, count: int, planes: np.ndarray
) -> int:
    """For a node that starts deep inside several segments, keep the plane of one way out.

    The way out of one segment may lead into another; those are not on the surface of the body as a
    whole. Among the others the shortest is kept, that of segment `last` unless another is shorter
    by HYSTERESIS. If there is none, the way out is an intersection curve: all planes stay.

    Returns
    -------
    planes left of the first `count`
    """
    best, shortest = -1, np.inf
    for k in range(count):
        plane = planes[k]
        if plane.depth <= work.recovery:
            continue
        outside = _is_outside(x, k, work, segments, count, planes)
        length = plane.depth * (1.0 - HYSTERESIS if plane.owner == last else 1.0)
        if outside and length < shortest:
            best, shortest = k, length
    if best < 0:
        return count
    left = 0
    for k in range(count):
        if k == best or planes[k].depth <= work.recovery:
            planes[left] = planes[k]
            left += 1
    return left
