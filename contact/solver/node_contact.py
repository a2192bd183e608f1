# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contact of one node with the body over one step: normal pushes, friction, what is booked.

supporting_planes.py bounds the step, nearest_step.py corrects it along the normals, and
plane_friction.py says how much of the slip that is left is taken as well. Lengths become impulses
by mass / dt.
"""

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from contact.kernel import kernel

from .contact_ledger import book_impulse
from .nearest_step import EJECTION, PINCHED, nearest_step
from .plane_friction import friction_kernel
from .soft_contact import bed_stiffness, from_cloth, opposed, soft_pushes
from .supporting_planes import find_planes, keep_one_exit


@kernel(makes_arrays=False)
def begin_path(work: Any) -> None:
    """At the start of the step, with no planes."""
    for c in range(3):
        work.step[c] = work.free[c]
        work.at[c] = 0.0
    work.count, work.pushing, work.first, work.stick = 0, 0, -1, False
    work.roundoff, work.depth, work.tau = 0.0, 0.0, 0.0


@kernel(makes_arrays=False)
def look_at_depths(work: Any, found: int, segments: np.ndarray, planes: np.ndarray) -> None:
    """Take up the depths of planes from `count` to before `found`; counts those deep inside."""
    work.inside = 0
    for k in range(work.count, found):
        work.depth = max(work.depth, planes[k].depth)
        work.roundoff = max(work.roundoff, segments[planes[k].owner].roundoff)
        work.inside += planes[k].depth > work.recovery


@kernel(makes_arrays=False)
def push_out(last: int, work: Any, planes: np.ndarray) -> None:
    """The nearest admissible step without friction; `last` is the segment touched last."""
    work.first = -1
    for k in range(work.count):
        if planes[k].owner == last:
            work.first = k
        for c in range(3):
            planes[k].friction[c] = 0.0
    work.pushing = nearest_step(work.free, planes, work.count, work.first, work.roundoff, work.step)
    if work.pushing != 0 and work.pushing != 1 and work.depth > work.roundoff:
        # where several segments hold the node, the way out may be EJECTION times the overlap
        least = work.recovery / EJECTION
        for k in range(work.count):
            planes[k].bound -= max(0.0, min(planes[k].depth, work.recovery) - least)
            planes[k].depth = min(planes[k].depth, least)
        work.pushing = nearest_step(
            work.free, planes, work.count, work.first, work.roundoff, work.step
        )


@kernel(makes_arrays=False)
def book_planes(
    x: np.ndarray,
    v: np.ndarray,
    mass: float,
    work: Any,
    segments: np.ndarray,
    planes: np.ndarray,
    book: np.ndarray,
) -> int:
    """Book the impulses of all planes; the segment that pushes most, or -1."""
    count, every, dt = work.count, work.count + work.soft, work.dt
    segment, greatest, normal = -1, 0.0, work.at
    for k in range(every):
        push, b = planes[k].push, planes[k].owner
        if push > greatest:
            segment, greatest = b, push
        from_cloth(planes, count, every, k, segments, normal)
        done = pressed = rubbed = 0.0
        for c in range(3):
            surface = planes[k].drift[c] / dt
            slip = v[c] + 0.5 * (work.change[c] - work.kick[c]) - surface
            pushed, friction = mass / dt * normal[c], mass / dt * planes[k].friction[c]
            work.impulse[c] = pushed + friction
            done += work.impulse[c] * surface
            pressed -= pushed * slip
            rubbed -= friction * slip
        book_impulse(book[b], segments[b].centre, x, work.impulse, done, rubbed, pressed)
    return segment


@cache
def node_kernel(kinetic_coefficient: Callable) -> Any:
    """Kernel correct_node(x, v, mass, node, work, segments, planes, book) of a law of friction.

    x, v : (3,) float, position at t [m], velocity before contact [m/s]
    mass : float, effective mass [kg]
    node : NODE, `penetrated` is updated
    work : STEP; `change` is filled and counts are added to
    segments : (m,) SEGMENT; planes : (2 m,) PLANE, work
    book : (m, BOOKED) float, see contact_ledger.py, added to

    Returns the segment (-1: no contact), the depth at the start [m], the same of a pinched node,
    whose first depth is zero.
    """
    apply_friction = friction_kernel(kinetic_coefficient)

    @kernel(makes_arrays=False)
    def follow_path(x, mass, node, work, segments, planes):
        """From plane to plane until the step is admissible; set of segments that press the node
        against each other, where that is seen on the way."""
        begin_path(work)
        allowed = node.allowed & ~node.penetrated
        while True:
            found = find_planes(x, allowed, node.far, work, segments, planes)
            if found == work.count:
                return 0
            look_at_depths(work, found, segments, planes)
            if work.inside > 1:
                if work.flesh < np.inf:
                    against = opposed(planes, found, segments, True)
                    if against:
                        return against
                found = keep_one_exit(x, node.segment, work, segments, found, planes)
            work.count = found
            push_out(node.segment, work, planes)
            if work.pushing != 0 and work.friction[0] > 0.0 and work.soft == 0:
                apply_friction(mass, work, planes)
            if work.inside > 1 or work.pushing == PINCHED:
                return 0

    @kernel(makes_arrays=False)
    def correct_node(x, v, mass, node, work, segments, planes, book):
        begun, pinch = 0, 0.0
        while True:  # again whenever segments are found to press the node against each other
            for c in range(3):
                work.free[c] = work.dt * v[c]
            work.soft, pinch = 0, 0.0
            if node.penetrated:
                pinch = soft_pushes(x, node, begun, work, segments, planes)
            against = follow_path(x, mass, node, work, segments, planes)
            soft, pushing = work.soft, work.pushing
            for k in range(soft):
                planes[work.count + k] = planes[len(segments) + k]
            if work.flesh < np.inf and not against and (pushing > 1 or pushing == PINCHED or soft):
                against = opposed(planes, work.count + soft, segments, pushing == PINCHED)
            if against & ~node.penetrated:
                begun |= against & ~node.penetrated
                node.penetrated |= against
                continue
            if soft and work.friction[0] > 0.0:
                apply_friction(mass, work, planes)
            break
        if work.pushing == 0 and work.soft == 0:
            return -1, work.depth, pinch
        depth = work.depth
        if work.pushing == PINCHED:
            pinch, depth = max(pinch, depth), 0.0
        if work.pushing == PINCHED or work.soft:
            work.pinched += 1
        if work.bed > 0.0:
            work.beds = bed_stiffness(planes, work, segments)
        for c in range(3):
            work.change[c] = 0.0
            for k in range(work.count + work.soft):
                push = planes[k].push * planes[k].normal[c]
                work.change[c] += (push + planes[k].friction[c]) / work.dt
        segment = book_planes(x, v, mass, work, segments, planes, book)
        if segment < 0:  # pinched, and on the near side of the segment that holds it
            return node.segment, depth, pinch
        work.active += 1
        work.sticking += work.stick
        return segment, depth, pinch

    return correct_node
