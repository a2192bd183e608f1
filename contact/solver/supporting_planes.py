# SPDX-License-Identifier: LGPL-3.0-or-later
"""What bounds the step of one point: a supporting plane for every ellipsoid it may reach.

Everything is seen from the moving body (travel.py): a point that stays with the body makes the step
`drift`, one that makes `step` moves by step - drift relative to it, straight in the body's axes.

An ellipsoid, also one grown by the offset, is convex: a plane that touches it where the path first
meets it has the start on one side and the whole ellipsoid on the other. A step that ends on the
near side can neither end inside nor have passed through, at any speed, and the velocity towards the
body is reduced, never reversed: kinetic energy relative to the body cannot grow. The path goes
straight to the first body met, from there on to where that body's plane lets it, and so on.

For a short step the plane at the closest point to the start does as well: only a layer of thickness
step^2 / (2 R) above the surface differs. A point in contact is of this kind and costs one
closest point.
"""

import numpy as np
from numba import njit

from contact.geometry.ellipsoid import foot_and_normal

from .segment_motion import turned_by

LONG_STEP = 1e-3  # of the smallest radius of curvature: the layer is half a millionth of it
MAX_ADVANCES = 60
HYSTERESIS = 0.05  # of the depth


# one record per plane found for a point
PLANE = np.dtype(
    [
        ("owner", np.int64),  # segment
        ("normal", float, 3),  # unit, out of the segment, at t + dt
        ("drift", float, 3),  # of the material point at the start [m]
        ("bound", float),  # admissible steps have normal . step >= bound [m]
        ("depth", float),  # of the start below the offset surface [m], negative outside
        ("push", float),  # correction along the normal [m]
        ("rub", float, 3),  # correction by friction [m]
    ]
)


@njit(cache=True, error_model="numpy")
def _entry(y0, y1, y2, p0, p1, p2, r0, r1, r2, offset):
    """Where the path y + tau p, 0 <= tau <= 1, first comes to the offset surface.

    The distance to a convex set is convex along a line, so Newton from outside never passes the
    entry. Returns tau (2: not met), evaluations, unit normal, height of y over the plane there.
    """
    tau = 0.0
    near = 1e-12 * min(r0, r1, r2)
    for evaluated in range(1, MAX_ADVANCES + 1):
        d, x0, x1, x2, n0, n1, n2 = foot_and_normal(
            y0 + tau * p0, y1 + tau * p1, y2 + tau * p2, r0, r1, r2
        )
        slope = n0 * p0 + n1 * p1 + n2 * p2
        if d - offset <= near or (slope < 0.0 and evaluated == MAX_ADVANCES):
            over = n0 * (y0 - x0) + n1 * (y1 - x1) + n2 * (y2 - x2) - offset
            return tau, evaluated, n0, n1, n2, over
        if slope >= 0.0:
            break
        tau -= (d - offset) / slope
        if tau >= 1.0:
            break
    return 2.0, evaluated, 0.0, 0.0, 0.0, 0.0


@njit(cache=True, error_model="numpy")
def set_plane(plane, owner, body, n0, n1, n2, height, depth, u0, u1, u2):
    """Fill one record from a normal in the body's axes and the height above the start."""
    axes = body.end_axes
    plane.owner, plane.depth, plane.push = owner, depth, 0.0
    plane.drift[0], plane.drift[1], plane.drift[2] = u0, u1, u2
    plane.bound = height
    for k in range(3):
        plane.normal[k] = n0 * axes[0, k] + n1 * axes[1, k] + n2 * axes[2, k]
        plane.bound += plane.normal[k] * plane.drift[k]
        plane.rub[k] = 0.0


@njit(cache=True, error_model="numpy")
def find_planes(
    x, at, tau, step, travel, allowed, far, left, offset, recover, count, planes
):  # fmt: skip
    """Add planes of the ellipsoids that the next leg of the path may reach and that have none yet.

    The leg goes from x + at, at the fraction tau of the step, to x + step at its end. All
    ellipsoids are added for which it is short. If there are none, the one is added that the leg
    meets first, and `at` moves there.

    Parameters
    ----------
    x : (3,) float, point at t [m]
    at : (3,) float [m], tau : float, begin of the leg
    step : (3,) float, end of the leg [m]
    travel : (m,) TRAVEL; offset : float, of the surface that is met [m]
    allowed : int, segments that the point can touch, see travel.py
    far : int, segments that a step of up to `left` [m] cannot reach, see clearance.py
    recover : float, way out of a body allowed in one step to a point that starts inside [m]
    count : int, planes there already; planes : (m,) PLANE, filled

    Returns
    -------
    planes there now, tau where the next leg begins, closest points evaluated
    """
    reach = np.sqrt(step[0] * step[0] + step[1] * step[1] + step[2] * step[2])
    if tau > 0.0:
        reach += np.sqrt(at[0] * at[0] + at[1] * at[1] + at[2] * at[2])
    if reach <= left:
        allowed &= ~far
    evaluated, known, soonest, rest = 0, count, 2.0, 1.0 - tau
    for b in range(len(travel)):
        body = travel[b]
        if not (allowed >> body.bit) & 1:
            continue
        q0, q1, q2 = x[0] - body.centre[0], x[1] - body.centre[1], x[2] - body.centre[2]
        limit = body.far + reach
        if (q0 * q0 + q1 * q1 + q2 * q2) * (body.near * body.near) > limit * limit:
            continue
        listed = False
        for k in range(count):
            listed = listed or planes[k].owner == b
        if listed:
            continue
        # drift of the material point; start x, begin of the leg and leg as the body sees them
        u0, u1, u2 = turned_by(body.turn, q0, q1, q2)
        u0, u1, u2 = u0 + body.shift[0], u1 + body.shift[1], u2 + body.shift[2]
        x0, x1, x2 = turned_by(body.axes, q0, q1, q2)
        y0, y1, y2 = x0, x1, x2
        if tau > 0.0:
            p0, p1, p2 = at[0] - tau * u0, at[1] - tau * u1, at[2] - tau * u2
            p0, p1, p2 = turned_by(body.end_axes, p0, p1, p2)
            y0, y1, y2 = x0 + p0, x1 + p1, x2 + p2
        p0, p1, p2 = step[0] - at[0], step[1] - at[1], step[2] - at[2]
        p0, p1, p2 = p0 - rest * u0, p1 - rest * u1, p2 - rest * u2
        way = np.sqrt(p0 * p0 + p1 * p1 + p2 * p2)
        r0, r1, r2 = body.radii[0], body.radii[1], body.radii[2]
        # |y / r| - 1 in shortest radii is never more than the distance
        size = np.sqrt((y0 / r0) ** 2 + (y1 / r1) ** 2 + (y2 / r2) ** 2)
        if (size - 1.0) * body.shortest > offset + way:
            continue
        distance, _, _, _, n0, n1, n2 = foot_and_normal(y0, y1, y2, r0, r1, r2)
        evaluated += 1
        gap = distance - offset
        if gap > way:
            continue
        long = gap > body.slack and way > LONG_STEP * body.sharpest
        if long and count > known:
            continue  # first see where the planes found lead
        if long:
            p0, p1, p2 = turned_by(body.end_axes, p0, p1, p2)
            met, more, n0, n1, n2, gap = _entry(y0, y1, y2, p0, p1, p2, r0, r1, r2, offset)
            evaluated += more
            if met >= soonest:
                continue
            soonest = met
        height = min(-gap, recover)
        if tau > 0.0:
            height += n0 * (y0 - x0) + n1 * (y1 - x1) + n2 * (y2 - x2)
            if height > 0.0:  # the start is behind this plane: take one that has it in front
                distance, _, _, _, n0, n1, n2 = foot_and_normal(x0, x1, x2, r0, r1, r2)
                evaluated += 1
                height = min(offset - distance, 0.0)
        set_plane(planes[count], b, body, n0, n1, n2, height, -gap, u0, u1, u2)
        count += not long
    if count == known and soonest <= 1.0:
        for k in range(3):
            at[k] += soonest * (step[k] - at[k])
        tau += soonest * rest
        count += 1
    return count, tau, evaluated


@njit(cache=True, error_model="numpy")
def keep_one_exit(x, travel, offset, recover, last, count, planes):
    """For a point that starts deep inside several bodies, keep the plane of one way out.

    The way out of one body may lead into another; those are not on the surface of the body as a
    whole. Among the others the shortest is kept, that of segment `last` unless another is shorter
    by HYSTERESIS. If there is none, the way out is an intersection curve: all planes stay.

    Returns
    -------
    planes left
    """
    best, shortest = -1, np.inf
    for k in range(count):
        plane = planes[k]
        if plane.depth <= recover:
            continue
        # foot on the offset surface, at t + dt
        f0 = x[0] + plane.drift[0] + plane.depth * plane.normal[0]
        f1 = x[1] + plane.drift[1] + plane.depth * plane.normal[1]
        f2 = x[2] + plane.drift[2] + plane.depth * plane.normal[2]
        outside = True
        for j in range(count):
            if j == k:
                continue
            body = travel[planes[j].owner]
            y0, y1, y2 = turned_by(
                body.end_axes,
                f0 - body.centre[0] - body.shift[0],
                f1 - body.centre[1] - body.shift[1],
                f2 - body.centre[2] - body.shift[2],
            )
            distance = foot_and_normal(y0, y1, y2, body.radii[0], body.radii[1], body.radii[2])[0]
            outside = outside and distance > offset - 1e3 * body.slack
        length = plane.depth * (1.0 - HYSTERESIS if plane.owner == last else 1.0)
        if outside and length < shortest:
            best, shortest = k, length
    if best < 0:
        return count
    left = 0
    for k in range(count):
        if k == best or planes[k].depth <= recover:
            planes[left] = planes[k]
            left += 1
    return left
