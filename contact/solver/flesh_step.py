# SPDX-License-Identifier: LGPL-3.0-or-later
"""One step of contact with a body whose flesh gives way, Eqs. 15 and 16 with a bed in series.

The bed (contact/body/flesh_bed.py) has no mass, so it presses with what the cloth presses. With the
free step s_f, the way u of the surface, the depth d of the start and the areal mass rho of the
cloth, a push s along the normal n leaves the depth

    d' = d + n . (u - s_f) - s,     s = dt^2 p(d')/rho,

p piecewise linear: solved in closed form, stable at any stiffness, a hard body for k -> infinity.
As p is that of the end, k (d' - d)^2/2 more is lost a step than by the bed. Friction has the cone
of that push, as on a hard body.

Skin that meets a node which is inside already, as in dressing, comes out with it at the recovery
speed, so that it is not thrown. Of several segments on one side of a node that one presses in which
it lies deepest at the end, or two in which it then lies alike (bed_push.py). In a crease, between
sides more than a right angle apart, a node is met as by node_contact.py, by segments smaller by the
depth that it has come to, which follows the pressure in a time of LAG: no flesh gives way into
other flesh there, and cloth is not drawn in.
"""

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from contact.geometry.shape import foot_and_normal, least_distance
from contact.kernel import kernel

from .bed_push import bed_kernel, touch_side
from .broad_phase import mark_away, may_meet
from .correction_step import begin_step, end_step, forget
from .node_contact import book_planes, node_kernel
from .segment_motion import drift_of, turned_by
from .step_record import ALLOWED, FAR, PENETRATED, SEGMENT_TOUCHED
from .supporting_planes import set_plane

LAG = 5e-3  # s


@kernel(makes_arrays=False)
def _candidates(x, i, sets, work, segments, planes):
    """Planes of all segments that the free step of node i ends below; their number."""
    count, free = 0, work.free
    allowed = sets[ALLOWED, i] & ~sets[FAR, i]
    for b in range(len(segments)):
        segment = segments[b]
        if not (allowed >> segment.bit) & 1:
            continue
        q0, q1, q2 = (
            x[i, 0] - segment.centre[0],
            x[i, 1] - segment.centre[1],
            x[i, 2] - segment.centre[2],
        )
        u0, u1, u2 = drift_of(segment, q0, q1, q2)
        y0, y1, y2 = turned_by(segment.axes, q0, q1, q2)
        way = np.sqrt((free[0] - u0) ** 2 + (free[1] - u1) ** 2 + (free[2] - u2) ** 2)
        if least_distance(segment, y0, y1, y2) > work.offset + way:
            continue
        distance, _, _, _, n0, n1, n2 = foot_and_normal(segment, y0, y1, y2)
        work.evaluated += 1
        depth = work.offset - distance
        if depth <= -way:
            continue
        plane = planes[count]
        set_plane(plane, b, segment, n0, n1, n2, 0.0, depth, u0, u1, u2)
        plane.bound = depth
        for c in range(3):
            plane.bound += plane.normal[c] * (plane.drift[c] - free[c])
        if plane.bound > 0.0:
            count += 1
    return count


@kernel(makes_arrays=False)
def _deepest(count, planes):
    """Number of the deepest plane; -1 where two are more than a right angle apart: a crease."""
    first = 0
    for k in range(count):
        if planes[k].bound > planes[first].bound:
            first = k
        for j in range(k):
            n, m = planes[k].normal, planes[j].normal
            if n[0] * m[0] + n[1] * m[1] + n[2] * m[2] < 0.0:
                return -1
    return first


@kernel(makes_arrays=False)
def _bring_forward(k, j, planes):
    """Exchange planes k and j."""
    p, q = planes[k], planes[j]
    p.owner, q.owner = q.owner, p.owner
    p.depth, q.depth = q.depth, p.depth
    p.bound, q.bound = q.bound, p.bound
    for c in range(3):
        p.normal[c], q.normal[c] = q.normal[c], p.normal[c]
        p.drift[c], q.drift[c] = q.drift[c], p.drift[c]


@kernel(makes_arrays=False)
def _deeper(count, planes):
    """Plane in which the push of plane 0 leaves a node deepest, and deeper than in 0; else 0."""
    p, found, most = planes[0], 0, 1e-12
    for k in range(1, count):
        n, m = p.normal, planes[k].normal
        g = n[0] * m[0] + n[1] * m[1] + n[2] * m[2]
        deeper = planes[k].bound - p.bound + (1.0 - g) * p.push
        if deeper > most:
            found, most = k, deeper
    return found


@cache
def flesh_kernel(kinetic_coefficient: Callable) -> Any:
    """Kernel correct(x, v, old, mass, dt, ..., *books) of a law of friction, on flesh.

    Arguments as of `correction_kernel` (correction_step.py) and flesh (m,) BED, sides (n,) SIDE and
    the areal mass [kg/m^2].
    """
    press_planes = bed_kernel(kinetic_coefficient)
    correct_node = node_kernel(kinetic_coefficient)

    @kernel(makes_arrays=False)
    def on_bed(x, v, mass, work, side, count, segments, planes, flesh, compliance, book):
        """Correct a node on the bed of plane 0, the deepest of count; its segment, or -1."""
        same = False
        for k in range(count):
            same = same or planes[k].owner == side.owner
        owner = planes[0].owner
        touch_side(side, owner, planes[0].depth, same, work.recovery)
        was = side.depth, side.slip, side.relaxing
        bed = flesh[owner]
        work.count, work.soft = 1, 0
        stick = press_planes(1, mass, work, side, planes, bed, compliance)
        if count > 1 and planes[0].push > 0.0:
            other = _deeper(count, planes)
            if other > 0:
                _bring_forward(other, 1, planes)
                side.depth, side.slip, side.relaxing = was
                work.count = 2
                stick = press_planes(2, mass, work, side, planes, bed, compliance)
        segment = book_planes(x, v, mass, work, segments, planes, book)
        if segment >= 0:
            work.active += 1
            work.sticking += stick
        return segment

    @kernel(makes_arrays=False)
    def in_crease(x, v, mass, work, node, side, segments, planes, flesh, compliance, book):
        """Correct a node between several segments; the one that pushes most, or -1."""
        offset, depth = work.offset, side.depth if side.owner >= 0 else 0.0
        work.offset = offset - depth
        segment, _, _ = correct_node(x, v, mass, node, work, segments, planes, book)
        work.offset = offset
        if segment < 0:
            return -1
        pressure = 0.0
        for k in range(work.count + work.soft):
            pressure += planes[k].push / compliance
        wanted = pressure / flesh[segment].stiffness
        side.owner, side.slip, side.relaxing, side.recess = segment, 0.0, 0.0, 0.0
        side.depth = depth + (wanted - depth) * min(1.0, work.dt / LAG)
        return segment

    @kernel(makes_arrays=False)
    def correct(
        x, v, old, mass, dt, fixed, sets, look, away, node, step, segments, planes, flesh, sides,
        areal, beds, impulse, book, window, window_book,
    ):  # fmt: skip
        work, one, compliance = step[0], node[0], dt * dt / areal
        begin_step(dt, work, segments)
        book[:] = 0.0
        impulse[:] = 0.0
        beds[:] = 0.0
        mark_away(
            x, v, mass, dt, work.path, work.motion, fixed, sets, look, work.frame, work.shift, away
        )
        forget(away, sets)
        for i in range(len(x)):
            segment, side = -1, sides[i]
            if away[i] < 0.0:
                total = x[i, 0] + x[i, 1] + x[i, 2] + v[i, 0] + v[i, 1] + v[i, 2]
                if not (np.isfinite(total) and 0.0 < mass[i] < np.inf):
                    return i + 1
                reach = dt * np.sqrt(v[i, 0] ** 2 + v[i, 1] ** 2 + v[i, 2] ** 2)
                if not fixed[i] and may_meet(x, i, reach, work, segments, sets, look):
                    for c in range(3):
                        work.free[c], work.kick[c] = dt * v[i, c], v[i, c] - old[i, c]
                    work.beds = 0.0
                    count = _candidates(x, i, sets, work, segments, planes)
                    first = _deepest(count, planes)
                    one.penetrated = sets[PENETRATED, i]
                    if first < 0 or one.penetrated != 0:
                        one.allowed, one.far = sets[ALLOWED, i], sets[FAR, i]
                        one.segment = sets[SEGMENT_TOUCHED, i]
                        segment = in_crease(
                            x[i], v[i], mass[i], work, one, side, segments, planes, flesh,
                            compliance, book,
                        )  # fmt: skip
                        if len(beds):
                            beds[i] = work.beds
                    elif count > 0:
                        _bring_forward(first, 0, planes)
                        segment = on_bed(
                            x[i], v[i], mass[i], work, side, count, segments, planes, flesh,
                            compliance, book,
                        )  # fmt: skip
                    sets[PENETRATED, i] = one.penetrated
                else:
                    sets[PENETRATED, i] = 0
            sets[SEGMENT_TOUCHED, i] = segment
            if segment < 0:
                side.owner = -1
                continue
            for c in range(3):
                v[i, c] += work.change[c]
                impulse[i, c] = mass[i] * work.change[c]
                window[i, c] += impulse[i, c]
        window_book += book
        end_step(work, look)
        return 0

    return correct
