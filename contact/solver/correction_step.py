# SPDX-License-Identifier: LGPL-3.0-or-later
"""One step of contact for all nodes: from those that meet nothing to those in a crease.

Most nodes are far from the body: one pass over plain arrays tells them (broad_phase.py). Of the
others nearly all meet one segment or none (one_segment.py), the rest may meet several
(node_contact.py). Nodes are booked in their order, whatever their kind.
"""

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from contact.kernel import kernel

from .broad_phase import mark_away, may_meet, surface_motion
from .node_contact import node_kernel
from .one_segment import MANY, one_segment_kernel
from .step_record import ALLOWED, FAR, PENETRATED, SEGMENT_TOUCHED


@kernel(makes_arrays=False)
def begin_step(dt: float, work: Any, segments: np.ndarray) -> None:
    """Settings of a step of dt [s], bounds on the motion of the body; counts are set to zero."""
    work.dt, work.recovery = dt, work.recovery_speed * dt
    work.motion, work.thinnest = surface_motion(segments, work.offset)
    work.evaluated, work.active, work.sticking, work.pinched = 0, 0, 0, 0
    work.max_depth = work.pinch_depth = 0.0


@kernel(makes_arrays=False)
def end_step(work: Any, look: np.ndarray) -> None:
    """Add the motion of the body to its way; where it has no bound all is measured anew."""
    if work.motion < np.inf:
        work.path += work.motion
        return
    work.path = 0.0
    look[3] = -1.0
    look[4] = 0.0


@kernel(makes_arrays=False)
def forget(away: np.ndarray, sets: np.ndarray) -> None:
    """Nodes that are away touch nothing and lie in nothing."""
    for i in range(len(away)):
        sets[SEGMENT_TOUCHED, i] = -1 if away[i] >= 0.0 else sets[SEGMENT_TOUCHED, i]
    for i in range(len(away)):
        sets[PENETRATED, i] = 0 if away[i] >= 0.0 else sets[PENETRATED, i]


@cache
def correction_kernel(kinetic_coefficient: Callable) -> Any:
    """Kernel correct(x, v, old, mass, dt, ..., *books) of a law of friction.

    One step of contact for all nodes, see VelocityCorrection; 0, or the number + 1 of a node that
    is not finite.

    fixed (n,), sets (SETS, n), look (LOOK, n), guards (n, GUARDS, GUARD) : what nodes keep, see
    step_record.py; away (n,), gaps (m,), planes (2 m,), node (1,) : work
    beds (n,), filled, or (0,) if nobody asked : see `bed_stiffness` in soft_contact.py
    books : impulse (n, 3) and table (m, BOOKED) of this step, filled, and those of the window,
    added to.
    """
    correct_node = node_kernel(kinetic_coefficient)
    meet_one = one_segment_kernel(kinetic_coefficient)

    @kernel(makes_arrays=False)
    def correct_any(x, v, old, mass, i, sets, node, work, segments, planes, book, impulse, window):
        """Node i, which several segments may hold; the segment that pushes most, or -1."""
        for c in range(3):
            work.kick[c] = v[i, c] - old[i, c]
        work.beds = 0.0
        node.allowed, node.far = sets[ALLOWED, i], sets[FAR, i]
        node.segment, node.penetrated = sets[SEGMENT_TOUCHED, i], sets[PENETRATED, i]
        segment, depth, pinch = correct_node(
            x[i], v[i], mass[i], node, work, segments, planes, book
        )
        sets[PENETRATED, i] = node.penetrated
        work.max_depth = max(work.max_depth, depth)
        work.pinch_depth = max(work.pinch_depth, pinch)
        if segment >= 0:
            for c in range(3):
                v[i, c] += work.change[c]
                impulse[i, c] = mass[i] * work.change[c]
                window[i, c] += impulse[i, c]
        return segment

    @kernel(makes_arrays=False)
    def correct(
        x, v, old, mass, dt, fixed, sets, look, guards, away, gaps, node, step, segments, planes,
        beds, impulse, book, window, window_book,
    ):  # fmt: skip
        work = step[0]
        begin_step(dt, work, segments)
        book[:] = 0.0
        impulse[:] = 0.0
        beds[:] = 0.0
        mark_away(
            x, v, mass, dt, work.path, work.motion, fixed, sets, look, work.frame, work.shift, away
        )
        forget(away, sets)
        for i in range(len(x)):
            if away[i] >= 0.0:
                continue
            total = x[i, 0] + x[i, 1] + x[i, 2] + v[i, 0] + v[i, 1] + v[i, 2]
            if not (np.isfinite(total) and 0.0 < mass[i] < np.inf):
                return i + 1
            reach = dt * np.sqrt(v[i, 0] ** 2 + v[i, 1] ** 2 + v[i, 2] ** 2)
            if fixed[i] or not may_meet(x, i, reach, work, segments, sets, look):
                sets[SEGMENT_TOUCHED, i], sets[PENETRATED, i] = -1, 0
                continue
            segment = MANY
            if sets[PENETRATED, i] == 0:
                segment = meet_one(
                    x, v, old, mass, i, sets, guards, work, segments, gaps, book, impulse, window
                )
            if segment == MANY:
                segment = correct_any(
                    x, v, old, mass, i, sets, node[0], work, segments, planes, book, impulse, window
                )
                if len(beds):
                    beds[i] = work.beds
            sets[SEGMENT_TOUCHED, i] = segment
        window_book += book
        end_step(work, look)
        return 0

    return correct
