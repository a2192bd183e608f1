# SPDX-License-Identifier: LGPL-3.0-or-later
"""The active set of contact under implicit steps: who is held after the next solve.

implicit_contact.py says how the set is used, held_nodes.py what it holds.
"""

import numpy as np

from contact.geometry.ellipsoid import foot_and_normal

from .held_nodes import FIXED, OPEN, PASSES, PLANES, SLIP, STICK, compiled, dot, shared

INSIDE = 1e-9  # m: a node is met when it ends deeper than this
LONG = 0.1  # of the shortest semi-axis: a longer way is looked along for bodies passed through
LOOKS = 16  # places looked at on a long way
FLIPS = 3  # changes of a node in one step after which no plane is taken from it any more


@compiled
def _foot(x, centre, axes, radii, normal):
    """Distance of x to an ellipsoid; its outward normal into `normal`."""
    q0, q1, q2 = x[0] - centre[0], x[1] - centre[1], x[2] - centre[2]
    y0 = axes[0, 0] * q0 + axes[0, 1] * q1 + axes[0, 2] * q2
    y1 = axes[1, 0] * q0 + axes[1, 1] * q1 + axes[1, 2] * q2
    y2 = axes[2, 0] * q0 + axes[2, 1] * q1 + axes[2, 2] * q2
    distance, _, _, _, n0, n1, n2 = foot_and_normal(y0, y1, y2, radii[0], radii[1], radii[2])
    for c in range(3):
        normal[c] = n0 * axes[0, c] + n1 * axes[1, c] + n2 * axes[2, c]
    return distance


@compiled
def _carried(x, c0, axes0, c1, axes1, out):
    """Where the body takes its point x over the step."""
    for c in range(3):
        out[c] = c1[c]
    for k in range(3):
        y = dot(axes0[k], x - c0)
        for c in range(3):
            out[c] += y * axes1[k, c]


@compiled
def _tangent(x, c1, axes1, radii, offset, nodes, i, k):
    """Plane k of node i at the foot of x; height of x over it."""
    b = nodes.owner[i, k]
    distance = _foot(x, c1[b], axes1[b], radii[b], nodes.normal[i, k])
    gap = distance - offset + nodes.way_out[i]
    nodes.height[i, k] = dot(nodes.normal[i, k], x) - gap
    return gap


@compiled
def _put_on(x, c1, axes1, radii, offset, nodes, i):
    """Move x onto the surfaces that hold node i, its planes with it."""
    for _ in range(PASSES):
        worst, count = 0.0, 0
        for k in range(PLANES):
            if nodes.owner[i, k] < 0:
                continue
            gap = _tangent(x, c1, axes1, radii, offset, nodes, i, k)
            for c in range(3):
                x[c] -= gap * nodes.normal[i, k, c]
            worst, count = max(worst, abs(gap)), count + 1
        if count <= 1 or worst < 1e-13:
            break


@compiled
def begin(x0, c0, axes0, c1, axes1, radii, law, dt, nodes):
    """Carry last step's set to the start of a step; returns the deepest start inside [m]."""
    offset, recovery, deepest = law[2], law[3], 0.0
    normal = np.empty(3)
    for i in range(len(x0)):
        nodes.flips[i] = 0
        nodes.way_out[i] = 0.0
        if nodes.state[i] == FIXED:
            continue
        depth = 0.0
        for b in range(len(radii)):
            far = max(radii[b, 0], radii[b, 1], radii[b, 2]) + offset
            q = x0[i] - c0[b]
            if dot(q, q) < far * far:
                depth = max(depth, offset - _foot(x0[i], c0[b], axes0[b], radii[b], normal))
        deepest = max(deepest, depth)
        nodes.way_out[i] = max(0.0, depth - recovery * dt)
        if nodes.state[i] > OPEN:
            b = nodes.owner[i, 0]
            _carried(x0[i], c0[b], axes0[b], c1[b], axes1[b], nodes.anchor[i])
            _put_on(nodes.anchor[i], c1, axes1, radii, offset, nodes, i)
    return deepest


@compiled
def _met(x0, x1, c0, axes0, c1, axes1, radii, law, nodes, i, fraction):
    """Segment that node i ends in deepest, or passes through first; -1: none.

    fraction (1,) : part of the step after which it is met
    """
    offset, found, deepest = law[2], -1, INSIDE
    normal, start, at = np.empty(3), np.empty(3), np.empty(3)
    for b in range(len(radii)):
        if b == nodes.owner[i, 0] or b == nodes.owner[i, 1] or b == nodes.owner[i, 2]:
            continue
        _carried(x0, c0[b], axes0[b], c1[b], axes1[b], start)
        way = np.sqrt(dot(x1 - start, x1 - start))
        far = max(radii[b, 0], radii[b, 1], radii[b, 2]) + offset
        if dot(x1 - c1[b], x1 - c1[b]) > (far + way) ** 2:
            continue
        looks = LOOKS if way > LONG * min(radii[b, 0], radii[b, 1], radii[b, 2]) else 1
        before = _foot(start, c1[b], axes1[b], radii[b], normal) - offset
        for look in range(1, looks + 1):
            for c in range(3):
                at[c] = start[c] + look / looks * (x1[c] - start[c])
            gap = _foot(at, c1[b], axes1[b], radii[b], normal) - offset
            depth = -gap - nodes.way_out[i]
            if depth > deepest:
                found, deepest = b, depth
                part = before / (before - gap) if before > 0.0 else 0.0
                fraction[0] = (look - 1 + part) / looks
                break
            before = gap
    return found


@compiled
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


@compiled
def judge(x0, x1, force, pull, c0, axes0, c1, axes1, radii, law, nodes):
    """Change the set after a solve that ended at x1 with reactions `force` (n, 3) [N].

    `pull` (n,) is the force of inertia over a displacement, m/(beta dt^2) [N/m].

    Returns
    -------
    changes; largest distance of a held node from its surfaces [m]; largest change of a friction
    load over what the normal force allows
    """
    mu_s, mu_k, offset, _ = law
    changes, worst, soft = 0, 0.0, 0.0
    still, push = np.zeros((PLANES, 3)), np.zeros((PLANES, 3))
    fraction = np.zeros(1)
    for i in range(len(x0)):
        if nodes.state[i] == FIXED:
            continue
        changed = False
        if nodes.state[i] > OPEN and nodes.flips[i] <= FLIPS:
            stick = nodes.state[i] == STICK
            # the force that acts on the node is the impulse that would stop minus that
            free = -force[i]
            cone = (mu_s, mu_k) if stick else (0.0, 0.0)
            total, whole = shared(
                free, still, nodes.normal[i], nodes.owner[i], 1.0, cone[0], cone[1], push
            )
            for k in range(PLANES - 1, -1, -1):
                if nodes.owner[i, k] >= 0 and dot(push[k], nodes.normal[i, k]) <= 0.0:
                    _drop(nodes, i, k)
                    changed = True
            if nodes.state[i] == STICK:
                if not whole:
                    nodes.state[i], changed = SLIP, True
                    for c in range(3):
                        nodes.load[i, c] = 0.0
                        for k in range(PLANES):
                            along = dot(push[k], nodes.normal[i, k])
                            if nodes.owner[i, k] >= 0:
                                nodes.load[i, c] += push[k, c] - along * nodes.normal[i, k, c]
            elif nodes.state[i] == SLIP:
                # the return map of friction: what would stop the slip, cut to what may be
                rub = nodes.load[i] - pull[i] * (x1[i] - nodes.anchor[i])
                for k in range(PLANES):
                    if nodes.owner[i, k] >= 0:
                        rub -= dot(rub, nodes.normal[i, k]) * nodes.normal[i, k]
                size = np.sqrt(dot(rub, rub))
                if mu_s > 0.0 and size <= mu_k * total:
                    nodes.state[i], changed = STICK, True
                    nodes.load[i] = 0.0
                elif mu_k > 0.0:
                    rub *= mu_k * total / size
                    step = rub - nodes.load[i]
                    soft = max(soft, np.sqrt(dot(step, step)) / (mu_k * total))
                    nodes.load[i] = rub
        count = 0
        for k in range(PLANES):
            if nodes.owner[i, k] >= 0:
                count += 1
                if nodes.state[i] == SLIP:
                    worst = max(worst, abs(_tangent(x1[i], c1, axes1, radii, offset, nodes, i, k)))
        if count < PLANES:
            b = _met(x0[i], x1[i], c0, axes0, c1, axes1, radii, law, nodes, i, fraction)
            if b >= 0:
                changed = True
                nodes.owner[i, count] = b
                if count == 0:
                    nodes.state[i] = STICK if mu_s > 0.0 else SLIP
                    nodes.load[i] = 0.0
                    part, start = fraction[0], np.empty(3)
                    _carried(x0[i], c0[b], axes0[b], c1[b], axes1[b], start)
                    for c in range(3):
                        nodes.anchor[i, c] = start[c] + part * (x1[i, c] - start[c])
                _put_on(nodes.anchor[i], c1, axes1, radii, offset, nodes, i)
        if changed:
            changes += 1
            nodes.flips[i] += 1
    return changes, worst, soft
