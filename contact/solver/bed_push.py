# SPDX-License-Identifier: LGPL-3.0-or-later
"""The push of beds of flesh on a node, and their friction, Eqs. 15 and 16; see flesh_step.py.

A node may be in the beds of several segments, in a valley between them or where they press it from
both sides. Flesh there gives way like one bed of which w d is the greatest, w^2 = k the stiffness:
the energy k d^2/2 of a node is that of the bed that has most. The step of least energy presses with
one bed, or with two that have alike,

    w_1 d_1' = w_2 d_2',  s_1 + s_2 w_1/w_2 = dt^2 p_1(d_1')/rho,  d_i' = d_i - s_i - g s_j,

s_i being the pushes, d_i the depths without a push, g = n_1 . n_2. So a node is not thrown to and
fro across a valley, and two sides that press it alike hold it between them.
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


@kernel(makes_arrays=False)
def pressure(bed: Any, side: Any) -> float:
    """What a bed presses a node with [Pa], in the state of its side."""
    borne = bed.slip_stiffness * (side.depth - side.slip)
    return max(0.0, bed.stiffness * side.depth + side.relaxing + borne)


@kernel(makes_arrays=False)
def press_two(
    p: Any, q: Any, bed: Any, other: Any, side: Any, compliance: float, dt: float
) -> None:
    """Fill the pushes of two planes, of beds that have alike; bed and side are of plane p."""
    g = p.normal[0] * q.normal[0] + p.normal[1] * q.normal[1] + p.normal[2] * q.normal[2]
    part = np.sqrt(bed.stiffness / other.stiffness)
    one, two = p.bound - side.recess, q.bound - side.recess
    both = max(1.0 - 2.0 * g * part + part * part, 1e-15)
    mean = (one * (1.0 - g * part) + two * (part - g)) / both
    press(bed, side, mean, compliance * max(0.0, 1.0 - g * g) / both, dt)
    total = compliance * pressure(bed, side)
    q.push = (total - one + side.depth) / max(part - g, 1e-15)
    q.push = min(max(q.push, 0.0), total / part)
    p.push = total - part * q.push


@kernel(makes_arrays=False)
def deepest_of(count: int, planes: np.ndarray, beds: np.ndarray) -> int:
    """Plane of whose bed a node would have most energy without a push; the first of none."""
    first, most = 0, 0.0
    for k in range(count):
        energy = beds[planes[k].owner].stiffness * max(0.0, planes[k].bound) ** 2
        if energy > most:
            first, most = k, energy
    return first


@kernel(makes_arrays=False)
def deeper_than_first(count: int, planes: np.ndarray, beds: np.ndarray, recess: float) -> int:
    """Plane of whose bed a node has most after the push of plane 0, more than of that; else 0."""
    p, found = planes[0], 0
    most = np.sqrt(beds[p.owner].stiffness) * (p.bound - recess - p.push)
    most += 1e-9 * abs(most)
    for k in range(1, count):
        n, m = p.normal, planes[k].normal
        g = n[0] * m[0] + n[1] * m[1] + n[2] * m[2]
        energy = np.sqrt(beds[planes[k].owner].stiffness)
        energy *= planes[k].bound - recess - g * p.push
        if energy > most:
            found, most = k, energy
    return found


@kernel(makes_arrays=False)
def exchange(k: int, j: int, planes: np.ndarray, over: np.ndarray) -> None:
    """Exchange planes k and j, and what they are over, if that is told."""
    p, q = planes[k], planes[j]
    p.owner, q.owner = q.owner, p.owner
    p.depth, q.depth = q.depth, p.depth
    p.bound, q.bound = q.bound, p.bound
    for c in range(3):
        p.normal[c], q.normal[c] = q.normal[c], p.normal[c]
        p.drift[c], q.drift[c] = q.drift[c], p.drift[c]
    if len(over):
        over[k], over[j] = over[j], over[k]


@cache
def bed_kernel(kinetic_coefficient: Callable) -> Any:
    """Kernel press_planes(count, mass, work, side, planes, over, beds, compliance) of a law.

    Of `count` planes, whose bounds are the depths that the free step ends at [m], it brings those
    that press forward, one or two, fills their pushes, their friction and `work.change`, and
    returns how many they are. over : see `exchange`; beds (m,) BED of the owners; side : SIDE of
    the node; compliance : see `press`
    """
    transmitted = cone_kernel(kinetic_coefficient)

    @kernel(makes_arrays=False)
    def press_planes(count, mass, work, side, planes, over, beds, compliance):
        free, step, dt, inertia = work.free, work.step, work.dt, mass / work.dt
        same = False
        for k in range(count):
            same = same or planes[k].owner == side.owner
        exchange(deepest_of(count, planes, beds), 0, planes, over)
        p = planes[0]
        touch_side(side, p.owner, p.depth, same, work.recovery)
        was = side.depth, side.slip, side.relaxing
        bed = beds[p.owner]
        p.push = press(bed, side, p.bound - side.recess, compliance, dt)
        pressing = 1
        if count > 1 and p.push > 0.0:
            other = deeper_than_first(count, planes, beds, side.recess)
            if other > 0:
                pressing = 2
                exchange(other, 1, planes, over)
                side.depth, side.slip, side.relaxing = was
                press_two(p, planes[1], bed, beds[planes[1].owner], side, compliance, dt)
        for c in range(3):
            step[c] = free[c]
            for k in range(pressing):
                step[c] += planes[k].push * planes[k].normal[c]
        stick = work.friction[0] > 0.0
        for k in range(pressing):
            plane = planes[k]
            n, u, along, size = plane.normal, plane.drift, 0.0, 0.0
            for c in range(3):
                along += (step[c] - u[c]) * n[c]
            for c in range(3):
                plane.friction[c] = -(step[c] - u[c] - along * n[c])
                size += plane.friction[c] * plane.friction[c]
            size = np.sqrt(size)
            fraction = 0.0
            if plane.push > 0.0:
                fraction = transmitted(
                    inertia * plane.push, inertia * size, size / dt, work.friction
                )
                stick = stick and fraction == 1.0
            for c in range(3):
                plane.friction[c] *= fraction
                step[c] += plane.friction[c]
        for c in range(3):
            work.change[c] = (step[c] - free[c]) / dt
        work.stick = stick
        return pressing

    return press_planes
