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
speed, so that it is not thrown. Of several segments those press of whose beds the node has most
(bed_push.py). Where two press it from opposite sides, what they press alike is flesh on flesh and
not booked (soft_contact.py); they are beds that hold it flat.
"""

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from contact.geometry.shape import foot_and_normal, least_distance
from contact.kernel import kernel

from .bed_push import bed_kernel
from .broad_phase import mark_away, may_meet
from .correction_step import begin_step, end_step, forget
from .node_contact import book_planes
from .segment_motion import drift_of, turned_by
from .soft_contact import opposed
from .step_record import ALLOWED, FAR, SEGMENT_TOUCHED
from .supporting_planes import set_plane


@kernel(makes_arrays=False)
def _candidates(x, i, sets, work, segments, planes):
    """Planes of all segments that a step of node i may end below; their number, or 0."""
    count, free, below = 0, work.free, False
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
        below = below or plane.bound > 0.0
        count += 1
    return count if below else 0


@cache
def flesh_kernel(kinetic_coefficient: Callable) -> Any:
    """Kernel correct(x, v, old, mass, dt, ..., *books) of a law of friction, on flesh.

    Arguments as of `correction_kernel` (correction_step.py), without node and guards, and over (0,)
    int, flesh (m,) BED, sides (n,) SIDE and the areal mass [kg/m^2].
    """
    press_planes = bed_kernel(kinetic_coefficient)

    @kernel(makes_arrays=False)
    def on_bed(x, v, mass, work, side, count, segments, planes, over, flesh, compliance, book):
        """Correct a node on the beds of `count` planes; the segment that presses most, or -1."""
        pressing = press_planes(count, mass, work, side, planes, over, flesh, compliance)
        work.count, work.soft = pressing, 0
        if pressing == 2 and opposed(planes, 2, segments, False) != 0:
            work.count, work.soft = 0, 2
            work.beds = flesh[planes[0].owner].stiffness + flesh[planes[1].owner].stiffness
            work.pinched += 1
            work.pinch_depth = max(work.pinch_depth, side.depth)
        segment = book_planes(x, v, mass, work, segments, planes, book)
        if segment >= 0:
            work.active += 1
            work.sticking += work.stick
        return segment

    @kernel(makes_arrays=False)
    def correct(
        x, v, old, mass, dt, fixed, sets, look, away, step, segments, planes, over, flesh,
        sides, areal, beds, impulse, book, window, window_book,
    ):  # fmt: skip
        work, compliance = step[0], dt * dt / areal
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
                    if count > 0:
                        segment = on_bed(
                            x[i], v[i], mass[i], work, side, count, segments, planes, over, flesh,
                            compliance, book,
                        )  # fmt: skip
                        if len(beds):
                            beds[i] = work.beds
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
