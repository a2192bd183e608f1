# SPDX-License-Identifier: LGPL-3.0-or-later
"""Friction of one node on all planes that push it, Eq. 16 with several segments.

Friction works on the slip that is left: planes share it by their push, so a groove of two equal
sides holds with the sum of both. Friction on one plane may press the node against another: normals
and friction are repeated in turn.
"""

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from contact.kernel import kernel

from .friction import cone_kernel
from .nearest_step import PINCHED, nearest_step

PASSES = 12  # of friction where several segments hold a node


@cache
def friction_kernel(kinetic_coefficient: Callable) -> Any:
    """Kernel apply_friction(mass, work, planes) of a law of friction.

    `work` (STEP) holds the planes (`count` of hard segments, after them `soft` ones whose pushes
    are in `free`) and the step; `step`, `pushing` and `stick` are updated, the planes get their
    corrections by friction.
    """
    transmitted = cone_kernel(kinetic_coefficient)

    @kernel(makes_arrays=False)
    def one_pass(mass, work, planes):
        """Add friction of all planes to `trial`; largest change [m], and whether all stick."""
        step, every, inertia = work.step, work.count + work.soft, mass / work.dt
        total, change, stick = 0.0, 0.0, True
        for k in range(every):
            total += planes[k].push
        for c in range(3):
            work.trial[c] = work.free[c]
        for k in range(every):
            n, u, friction, push = (
                planes[k].normal, planes[k].drift, planes[k].friction, planes[k].push,
            )  # fmt: skip
            if push <= 0.0:
                for c in range(3):
                    friction[c] = 0.0
                continue
            along = 0.0
            for c in range(3):
                along += (step[c] - u[c]) * n[c]
            size, share = 0.0, push / total
            for c in range(3):
                trial = friction[c] - share * (step[c] - u[c] - along * n[c])
                size += trial * trial
            size = np.sqrt(size)
            fraction = transmitted(
                inertia * push, inertia * size, size / (share * work.dt), work.friction
            )
            stick = stick and fraction == 1.0
            for c in range(3):
                trial = friction[c] - share * (step[c] - u[c] - along * n[c])
                change = max(change, abs(fraction * trial - friction[c]))
                friction[c] = fraction * trial
                work.trial[c] += friction[c]
        return change, stick

    @kernel(makes_arrays=False)
    def apply_friction(mass, work, planes):
        count, soft, stick, slack = work.count, work.soft, True, work.roundoff
        for _ in range(PASSES):
            change, stick = one_pass(mass, work, planes)
            if work.pushing == PINCHED:
                for k in range(count):
                    for c in range(3):
                        work.trial[c] += planes[k].push * planes[k].normal[c]
                for c in range(3):
                    work.step[c] = work.trial[c]
                break
            alone = work.pushing == 1 and soft == 0
            work.pushing = nearest_step(work.trial, planes, count, work.first, slack, work.step)
            if (alone and work.pushing == 1) or change <= slack:
                break
        if work.pushing == 0 and count > 0:  # friction alone would lift the node off: leave it out
            for c in range(3):
                work.trial[c] = work.free[c]
                for k in range(count):
                    planes[k].friction[c] = 0.0
                for k in range(count, count + soft):
                    work.trial[c] += planes[k].friction[c]
            work.pushing = nearest_step(work.trial, planes, count, work.first, slack, work.step)
            stick = stick and soft > 0
        work.stick = stick

    return apply_friction
