# SPDX-License-Identifier: LGPL-3.0-or-later
"""The active set of contact under implicit steps: who is held after the next solve.

implicit_contact.py says how the set is used, held_nodes.py what it holds.
"""

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from contact.geometry.shape import foot_and_normal
from contact.kernel import kernel

from .held_nodes import FIXED, OPEN, PASSES, PLANES, SLIP, STICK, Set, dot, share_kernel
from .segment_motion import turned_by

INSIDE = 1e-9  # m: a node is met when it ends deeper than this
LONG = 0.1  # of the inner radius: a longer way is looked along for segments passed through
LOOKS = 16  # places looked at on a long way
FLIPS = 3  # changes of a node in one step after which no plane is taken from it any more


@kernel
def _foot(x, centre, axes, segment, normal):
    """Distance of x to a segment posed so; its outward normal into `normal`."""
    q0, q1, q2 = x[0] - centre[0], x[1] - centre[1], x[2] - centre[2]
    y0, y1, y2 = turned_by(axes, q0, q1, q2)
    distance, _, _, _, n0, n1, n2 = foot_and_normal(segment, y0, y1, y2)
    for c in range(3):
        normal[c] = n0 * axes[0, c] + n1 * axes[1, c] + n2 * axes[2, c]
    return distance


@kernel
def _carried(x, segment, out):
    """Where the body takes its point x over the step."""
    for c in range(3):
        out[c] = segment.end_centre[c]
    for k in range(3):
        y = dot(segment.axes[k], x - segment.centre)
        for c in range(3):
            out[c] += y * segment.end_axes[k, c]


@kernel
def _tangent(x, segments, offset, nodes, i, k):
    """Plane k of node i at the foot of x; height of x over it."""
    segment = segments[nodes.owner[i, k]]
    distance = _foot(x, segment.end_centre, segment.end_axes, segment, nodes.normal[i, k])
    gap = distance - offset + nodes.way_out[i]
    nodes.height[i, k] = dot(nodes.normal[i, k], x) - gap
    return gap


@kernel
def _put_on(x, segments, offset, nodes, i):
    """Move x onto the surfaces that hold node i, its planes with it."""
    for _ in range(PASSES):
        worst, count = 0.0, 0
        for k in range(PLANES):
            if nodes.owner[i, k] < 0:
                continue
            gap = _tangent(x, segments, offset, nodes, i, k)
            for c in range(3):
                x[c] -= gap * nodes.normal[i, k, c]
            worst, count = max(worst, abs(gap)), count + 1
        if count <= 1 or worst < 1e-13:
            break


@kernel
def begin(x0: np.ndarray, segments: np.ndarray, work: Any, nodes: Set) -> float:
    """Carry last step's set to the start of a step at x0 (n, 3); deepest start inside [m].

    segments : (m,) SEGMENT; work : STEP
    """
    offset, deepest = work.offset, 0.0
    normal = np.empty(3)
    for i in range(len(x0)):
        nodes.flips[i] = 0
        nodes.way_out[i] = 0.0
        if nodes.state[i] == FIXED:
            continue
        depth = 0.0
        for b in range(len(segments)):
            segment = segments[b]
            far = segment.bounding_radius + offset
            q = x0[i] - segment.centre
            if dot(q, q) < far * far:
                own = offset - _foot(x0[i], segment.centre, segment.axes, segment, normal)
                depth = max(depth, own)
        deepest = max(deepest, depth)
        nodes.way_out[i] = max(0.0, depth - work.recovery)
        if nodes.state[i] > OPEN:
            _carried(x0[i], segments[nodes.owner[i, 0]], nodes.anchor[i])
            _put_on(nodes.anchor[i], segments, offset, nodes, i)
    return deepest


@kernel
def _met(x0, x1, segments, offset, nodes, i, fraction):
    """Segment that node i ends in deepest, or passes through first; -1: none.

    fraction (1,) : part of the step after which it is met
    """
    found, deepest = -1, INSIDE
    normal, start, at = np.empty(3), np.empty(3), np.empty(3)
    for b in range(len(segments)):
        if b == nodes.owner[i, 0] or b == nodes.owner[i, 1] or b == nodes.owner[i, 2]:
            continue
        segment = segments[b]
        end, axes = segment.end_centre, segment.end_axes
        _carried(x0, segment, start)
        way = np.sqrt(dot(x1 - start, x1 - start))
        far = segment.bounding_radius + offset
        if dot(x1 - end, x1 - end) > (far + way) ** 2:
            continue
        looks = LOOKS if way > LONG * segment.inner_radius else 1
        before = _foot(start, end, axes, segment, normal) - offset
        for look in range(1, looks + 1):
            for c in range(3):
                at[c] = start[c] + look / looks * (x1[c] - start[c])
            gap = _foot(at, end, axes, segment, normal) - offset
            depth = -gap - nodes.way_out[i]
            if depth > deepest:
                found, deepest = b, depth
                part = before / (before - gap) if before > 0.0 else 0.0
                fraction[0] = (look - 1 + part) / looks
                break
            before = gap
    return found


@kernel
def _drop(nodes, i, k):
    """Take a plane from a node; one without planes is open."""
    for j in range(k, PLANES - 1):
        nodes.owner[i, j] = nodes.owner[i, j + 1]
        nodes.normal[i, j] = nodes.normal[i, j + 1]
        nodes.height[i, j] = nodes.height[i, j + 1]
    nodes.owner[i, PLANES - 1] = -1
    if nodes.owner[i, 0] < 0:
        nodes.state[i] = OPEN
        nodes.load[i] = 0.0


@kernel
def _begin_slip(nodes, i, push):
    """A node that stuck slips, under the friction that its planes transmit."""
    nodes.state[i] = SLIP
    for c in range(3):
        nodes.load[i, c] = 0.0
        for k in range(PLANES):
            along = dot(push[k], nodes.normal[i, k])
            if nodes.owner[i, k] >= 0:
                nodes.load[i, c] += push[k, c] - along * nodes.normal[i, k, c]


@kernel
def _off_surface(x1, segments, offset, nodes, i):
    """Planes of a node; where it slips they are set anew at x1: greatest distance from them [m]."""
    count, worst = 0, 0.0
    for k in range(PLANES):
        if nodes.owner[i, k] >= 0:
            count += 1
            if nodes.state[i] == SLIP:
                worst = max(worst, abs(_tangent(x1, segments, offset, nodes, i, k)))
    return count, worst


@kernel
def _hold(x0, x1, segments, work, nodes, i, count):
    """Give a node the plane of a segment it has met, if it has; True if so."""
    fraction = np.zeros(1)
    b = _met(x0, x1, segments, work.offset, nodes, i, fraction)
    if b < 0:
        return False
    nodes.owner[i, count] = b
    if count == 0:
        nodes.state[i] = STICK if work.friction[0] > 0.0 else SLIP
        nodes.load[i] = 0.0
        part, start = fraction[0], np.empty(3)
        _carried(x0, segments[b], start)
        for c in range(3):
            nodes.anchor[i, c] = start[c] + part * (x1[c] - start[c])
    _put_on(nodes.anchor[i], segments, work.offset, nodes, i)
    return True


@cache
def judge_kernel(kinetic_coefficient: Callable) -> Any:
    """Kernel judge(x0, x1, force, pull, segments, work, nodes) of a law of friction.

    Changes the set after a solve from x0 (n, 3) that ended at x1 with reactions `force` (n, 3) [N].
    `pull` (n,) is the force of inertia over a displacement, m/(beta dt^2) [N/m]; segments : (m,)
    SEGMENT; work : STEP; nodes : Set.

    Returns the changes; the largest distance of a held node from its surfaces [m]; the largest
    change of a friction load over what the normal force allows.
    """
    share = share_kernel(kinetic_coefficient)

    @kernel
    def return_map(x1, pull, total, work, nodes, i):
        """Friction of a node that slips: what would stop the slip, cut to what may be.

        Relative change of its load; negative where the node sticks from now on.
        """
        way = x1 - nodes.anchor[i]
        friction = nodes.load[i] - pull * way
        for k in range(PLANES):
            if nodes.owner[i, k] >= 0:
                friction -= dot(friction, nodes.normal[i, k]) * nodes.normal[i, k]
                way -= dot(way, nodes.normal[i, k]) * nodes.normal[i, k]
        size = np.sqrt(dot(friction, friction))
        mu_k = kinetic_coefficient(np.sqrt(dot(way, way)) / work.dt, work.friction)
        if work.friction[0] > 0.0 and size <= mu_k * total:
            nodes.state[i] = STICK
            nodes.load[i] = 0.0
            return -1.0
        if mu_k > 0.0:
            friction *= mu_k * total / size
            step = friction - nodes.load[i]
            nodes.load[i] = friction
            return np.sqrt(dot(step, step)) / (mu_k * total)
        return 0.0

    @kernel
    def judge(x0, x1, force, pull, segments, work, nodes):
        changes, worst, soft = 0, 0.0, 0.0
        still, push = np.zeros((PLANES, 3)), np.zeros((PLANES, 3))
        for i in range(len(x0)):
            if nodes.state[i] == FIXED:
                continue
            changed = False
            if nodes.state[i] > OPEN and nodes.flips[i] <= FLIPS:
                # the force that acts on the node is the impulse that would stop minus that
                free = -force[i]
                rough = nodes.state[i] == STICK and work.friction[0] > 0.0
                total, whole = share(
                    free, still, nodes.normal[i], nodes.owner[i], 1.0, rough, False,
                    work.friction, push,
                )  # fmt: skip
                for k in range(PLANES - 1, -1, -1):
                    if nodes.owner[i, k] >= 0 and dot(push[k], nodes.normal[i, k]) <= 0.0:
                        _drop(nodes, i, k)
                        changed = True
                if nodes.state[i] == STICK:
                    if not whole:
                        _begin_slip(nodes, i, push)
                        changed = True
                elif nodes.state[i] == SLIP:
                    change = return_map(x1[i], pull[i], total, work, nodes, i)
                    changed = changed or change < 0.0
                    soft = max(soft, change)
            count, off = _off_surface(x1[i], segments, work.offset, nodes, i)
            worst = max(worst, off)
            if count < PLANES and _hold(x0[i], x1[i], segments, work, nodes, i, count):
                changed = True
            if changed:
                changes += 1
                nodes.flips[i] += 1
        return changes, worst, soft

    return judge
