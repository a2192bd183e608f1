# SPDX-License-Identifier: LGPL-3.0-or-later
"""The push of a bed of flesh on a node, and its friction, Eqs. 15 and 16; see flesh_step.py.

In a valley between two segments whose skins bend the same way, max(d_1, d_2) is the depth of a node
in the body. The bed presses with p of that depth; where both are the greatest, along a mean of both
normals, by as much of each as leaves the node in the valley:

    s_1 - s_2 = (d_1 - d_2)/(1 - g),   s_1 + s_2 = dt^2 p(d')/rho,
    d' = (d_1 + d_2)/2 - (1 + g)(s_1 + s_2)/2,

d_1, d_2 being the depths without a push, g = n_1 . n_2. This is the step of least energy: a node
that only the deeper one pressed would be thrown to and fro across the valley.
"""

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from contact.kernel import kernel

from .friction import cone_kernel

# what a node remembers of the bed that presses it
SIDE = np.dtype(
    [
        ("owner", np.int64),  # segment, -1: none
        ("depth", float),  # d [m]
        ("recess", float),  # of the skin where it met the node already inside [m]
        ("slip", float),  # s [m]
        ("relaxing", float),  # q [Pa]
    ]
)


@kernel(makes_arrays=False)
def press(bed: Any, side: Any, free_depth: float, compliance: float, dt: float) -> float:
    """Push s [m] of a bed on a node whose depth would be `free_depth` without it.

    compliance : dt^2/rho [m/Pa]; side : SIDE as of the step before, set to that of this one
    """
    decay = 1.0 / (1.0 + dt / bed.relaxation_time) if bed.relaxation_time > 0.0 else 0.0
    slope = bed.stiffness + bed.relaxing_stiffness * decay
    rest = (side.relaxing - bed.relaxing_stiffness * side.depth) * decay
    stuck, slides = slope + bed.slip_stiffness, 0.0
    push = compliance * (rest - bed.slip_stiffness * side.slip + stuck * free_depth)
    push /= 1.0 + compliance * stuck
    borne = bed.slip_stiffness * (free_depth - push - side.slip)
    if abs(borne) > bed.yield_pressure:
        slides = bed.yield_pressure if borne > 0.0 else -bed.yield_pressure
        push = compliance * (rest + slides + slope * free_depth) / (1.0 + compliance * slope)
        borne = slides
    push = max(0.0, push)
    depth = free_depth - push
    side.relaxing = (side.relaxing + bed.relaxing_stiffness * (depth - side.depth)) * decay
    # skin that comes back more slowly than the cloth leaves it pulls nothing
    side.relaxing = max(side.relaxing, -bed.stiffness * depth - borne)
    side.slip = depth - borne / bed.slip_stiffness if bed.slip_stiffness > 0.0 else 0.0
    side.depth = depth
    return push


@kernel(makes_arrays=False)
def touch_side(side: Any, owner: int, depth: float, same: bool, recovery: float) -> None:
    """Let a bed of segment `owner` press a node at `depth` [m]; its recess fades.

    same : whether the segment that pressed it before is still there: flesh goes on from one to the
    other; else the bed begins anew, where the node is
    """
    if side.owner < 0 or not (same or side.owner == owner):
        begun = side.depth if side.owner >= 0 else 0.0
        side.depth = side.slip = side.relaxing = 0.0
        side.recess = max(0.0, depth - begun)
    side.owner = owner
    side.recess = max(0.0, side.recess - recovery)


@cache
def bed_kernel(kinetic_coefficient: Callable) -> Any:
    """Kernel press_planes(count, mass, work, side, planes, bed, compliance) of a law of friction.

    It fills the pushes and the friction of the first one or two planes on a bed, whose bounds are
    the depths that the free step ends at [m], and `work.change`; whether the node sticks.
    compliance : see `press`; side : SIDE, after `touch_side`
    """
    transmitted = cone_kernel(kinetic_coefficient)

    @kernel(makes_arrays=False)
    def press_planes(count, mass, work, side, planes, bed, compliance):
        free, step, dt, inertia = work.free, work.step, work.dt, mass / work.dt
        p, q = planes[0], planes[count - 1]
        if count == 1:
            p.push = press(bed, side, p.bound - side.recess, compliance, dt)
        else:
            g = p.normal[0] * q.normal[0] + p.normal[1] * q.normal[1] + p.normal[2] * q.normal[2]
            half, mean = 0.5 * (1.0 + g), 0.5 * (p.bound + q.bound)
            total = press(bed, side, mean - side.recess, compliance * half, dt) / half
            apart = (p.bound - q.bound) / (1.0 - g)
            p.push = max(0.0, 0.5 * (total + apart))
            q.push = max(0.0, 0.5 * (total - apart))
        total = greatest = along = 0.0
        for k in range(count):
            total += planes[k].push
        for c in range(3):
            step[c], work.at[c] = free[c], 0.0
            for k in range(count):
                step[c] += planes[k].push * planes[k].normal[c]
                part = planes[k].push / total if total > 0.0 else 1.0 / count
                work.at[c] += part * planes[k].drift[c]
        for c in range(3):
            greatest += (step[c] - free[c]) ** 2
            along += (step[c] - free[c]) * (step[c] - work.at[c])
        greatest = np.sqrt(greatest)
        along = along / greatest**2 if greatest > 0.0 else 0.0
        size = 0.0
        for c in range(3):
            slip = step[c] - work.at[c] - along * (step[c] - free[c])
            work.impulse[c] = -slip
            size += slip * slip
        size = np.sqrt(size)
        fraction = transmitted(inertia * greatest, inertia * size, size / dt, work.friction)
        for c in range(3):
            rub = fraction * work.impulse[c]
            for k in range(count):
                part = planes[k].push / total if total > 0.0 else 1.0 / count
                planes[k].friction[c] = part * rub
            work.change[c] = (step[c] - free[c] + rub) / dt
        return fraction == 1.0 and work.friction[0] > 0.0

    return press_planes
