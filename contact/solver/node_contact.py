# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contact of one point with the body over one step: normal pushes, friction, what is booked.

The planes of planes.py bound the step, wedge.py corrects it along their normals, friction.py says
how much of the slip that is left is taken as well. Lengths become impulses by mass / dt.

A row of the book holds for one segment, all as acting on the cloth: impulse (3) [N s], its moment
about the segment's centre at t (3) [N m s], work done by the moving segment, friction loss, impact
loss [J].
"""

import numpy as np
from numba import njit

from .friction import transmitted
from .nearest_step import EJECTION, PINCHED, nearest_step
from .soft_crease import from_cloth, opposed, soften
from .supporting_planes import find_planes, keep_one_exit

RUBS = 12  # passes of friction where several bodies hold a point
WORK, FRICTION, IMPACT, BOOKED = 6, 7, 8, 9
EVALUATED, ACTIVE, PINCHES, STICKING, COUNTS = 0, 1, 2, 3, 4


@njit(cache=True, error_model="numpy")
def _rub(
    free, planes, count, soft, first, pushing, slack, mu_s, mu_k, inertia, moved, step
):  # fmt: skip
    """Friction on all planes that push; `step` is updated. Returns planes pushing, all stick.

    Planes after the first `count` are those of soft parts, whose pushes are in `free`.

    Friction works on the slip that is left: planes share it by their push, so a groove of two
    equal sides holds with the sum of both. Friction on one plane may press the point against
    another: normals and friction are repeated in turn.
    """
    stick, every = True, count + soft
    for _ in range(RUBS):
        total = 0.0
        for k in range(every):
            total += planes[k].push
        for c in range(3):
            moved[c] = free[c]
        change, stick = 0.0, True
        for k in range(every):
            n, u, rub, push = planes[k].normal, planes[k].drift, planes[k].rub, planes[k].push
            if push <= 0.0:
                for c in range(3):
                    rub[c] = 0.0
                continue
            along = 0.0
            for c in range(3):
                along += (step[c] - u[c]) * n[c]
            size, share = 0.0, push / total
            for c in range(3):
                trial = rub[c] - share * (step[c] - u[c] - along * n[c])
                size += trial * trial
            size = np.sqrt(size)
            fraction = transmitted(inertia * push, inertia * size, mu_s, mu_k)
            stick = stick and fraction == 1.0
            for c in range(3):
                trial = rub[c] - share * (step[c] - u[c] - along * n[c])
                change = max(change, abs(fraction * trial - rub[c]))
                rub[c] = fraction * trial
                moved[c] += rub[c]
        if pushing == PINCHED:
            for k in range(count):
                for c in range(3):
                    moved[c] += planes[k].push * planes[k].normal[c]
            for c in range(3):
                step[c] = moved[c]
            break
        alone = pushing == 1 and soft == 0
        pushing = nearest_step(moved, planes, count, first, slack, step)
        if (alone and pushing == 1) or change <= slack:
            break
    if pushing == 0 and count > 0:  # friction alone would lift the point off: leave it out
        for c in range(3):
            moved[c] = free[c]
            for k in range(count):
                planes[k].rub[c] = 0.0
            for k in range(count, every):
                moved[c] += planes[k].rub[c]
        pushing = nearest_step(moved, planes, count, first, slack, step)
        stick = stick and soft > 0
    return pushing, stick


@njit(cache=True, error_model="numpy")
def meet_body(
    x, v, kick, mass, dt, law, last, allowed, sunk, far, left, travel, planes, room, book, counts,
    change,
):  # fmt: skip
    """Contact of one point over one step.

    Parameters
    ----------
    x, v : (3,) float, position at t [m], velocity before contact [m/s]
    kick : (3,) float, change of velocity by the forces of this step [m/s]
    mass : float, effective mass [kg]
    law : mu_s, mu_k, offset [m], recovery [m/s], flesh [1/s^2]: see pinch.py
    last : int, segment of the last step or -1
    allowed : int, segments that the point can touch, see travel.py
    sunk : int, soft segments that have let the point in, see pinch.py
    far : int, segments that a step of up to `left` [m] cannot reach, see clearance.py
    planes : (2 m,) PLANE; room : (5, 3) float, scratch
    book : (m, 9) float, added to; counts : (4,) int, added to
    change : (3,) float, filled: change of velocity [m/s]

    Returns
    -------
    segment (-1: no contact), sunk, depth at the start [m], the same of a pinched point, whose first
    depth is zero
    """
    mu_s, mu_k, offset, recovery, flesh = law
    free, step, moved, at = room[0], room[1], room[2], room[3]
    fresh, away = 0, len(travel)
    while True:  # again whenever parts are found to press the point against each other
        for c in range(3):
            free[c] = dt * v[c]
        soft, pinch = 0, 0.0
        if sunk:
            sunk, soft, pinch = soften(
                x, free, kick, dt, flesh, travel, offset, sunk, fresh, planes, away
            )  # fmt: skip
        for c in range(3):
            step[c] = free[c]
            at[c] = 0.0
        count, pushing, first, slack, depth, tau = 0, 0, -1, 0.0, 0.0, 0.0
        stick, against = False, 0
        while True:
            found, tau, evaluated = find_planes(
                x,
                at,
                tau,
                step,
                travel,
                allowed & ~sunk,
                far,
                left,
                offset,
                recovery * dt,
                count,
                planes,
            )
            counts[EVALUATED] += evaluated
            if found == count:
                break
            inside = 0
            for k in range(count, found):
                depth = max(depth, planes[k].depth)
                slack = max(slack, travel[planes[k].owner].slack)
                inside += planes[k].depth > recovery * dt
            if inside > 1:
                if flesh < np.inf:
                    against = opposed(planes, found, travel, True)
                    if against:
                        break
                found = keep_one_exit(x, travel, offset, recovery * dt, last, found, planes)
            count, first = found, -1
            for k in range(count):
                if planes[k].owner == last:
                    first = k
                for c in range(3):
                    planes[k].rub[c] = 0.0
            pushing = nearest_step(free, planes, count, first, slack, step)
            if pushing != 0 and pushing != 1 and depth > slack:
                # where several bodies hold the point, the way out may be EJECTION times the overlap
                least = recovery * dt / EJECTION
                for k in range(count):
                    planes[k].bound -= max(0.0, min(planes[k].depth, recovery * dt) - least)
                    planes[k].depth = min(planes[k].depth, least)
                pushing = nearest_step(free, planes, count, first, slack, step)
            if pushing != 0 and mu_s > 0.0 and soft == 0:
                pushing, stick = _rub(
                    free, planes, count, 0, first, pushing, slack, mu_s, mu_k, mass / dt, moved,
                    step,
                )  # fmt: skip
            if inside > 1 or pushing == PINCHED:
                break
        if soft:
            for k in range(soft):
                planes[count + k] = planes[away + k]
        if flesh < np.inf and not against and (pushing > 1 or pushing == PINCHED or soft):
            every = count + soft
            against = opposed(planes, every, travel, pushing == PINCHED)
        if against & ~sunk:
            fresh |= against & ~sunk
            sunk |= against
            continue
        if soft and mu_s > 0.0:
            pushing, stick = _rub(
                free, planes, count, soft, first, pushing, slack, mu_s, mu_k, mass / dt, moved, step
            )
        break
    every = count + soft
    if pushing == 0 and soft == 0:
        return -1, sunk, depth, pinch
    if pushing == PINCHED:
        counts[PINCHES] += 1
        pinch, depth = max(pinch, depth), 0.0
    elif soft:
        counts[PINCHES] += 1

    for c in range(3):
        change[c] = 0.0
        for k in range(every):
            change[c] += (planes[k].push * planes[k].normal[c] + planes[k].rub[c]) / dt
    segment, greatest, normal = -1, 0.0, at
    for k in range(every):
        push, b = planes[k].push, planes[k].owner
        if push > greatest:
            segment, greatest = b, push
        from_cloth(planes, count, every, k, travel, normal)
        work = pressed = rubbed = 0.0
        for c in range(3):
            surface = planes[k].drift[c] / dt
            slip = v[c] + 0.5 * (change[c] - kick[c]) - surface
            pushed, friction = mass / dt * normal[c], mass / dt * planes[k].rub[c]
            moved[c] = pushed + friction
            work += moved[c] * surface
            pressed -= pushed * slip
            rubbed -= friction * slip
        centre = travel[b].centre
        for c in range(3):
            d, e = (c + 1) % 3, (c + 2) % 3
            book[b, c] += moved[c]
            book[b, 3 + c] += (x[d] - centre[d]) * moved[e] - (x[e] - centre[e]) * moved[d]
        book[b, WORK] += work
        book[b, FRICTION] += rubbed
        book[b, IMPACT] += pressed
    if segment < 0:  # pinched, and on the near side of the segment that holds it
        return last, sunk, depth, pinch
    counts[ACTIVE] += 1
    counts[STICKING] += stick
    return segment, sunk, depth, pinch
