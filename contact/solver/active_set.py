# SPDX-License-Identifier: LGPL-3.0-or-later
"""The active set of contact under implicit steps: who is held after the next solve.

implicit_contact.py says how the set is used, held_nodes.py what it holds, obstacle.py how new nodes
join it.
"""

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from contact.kernel import kernel

from .held_nodes import OPEN, PLANES, SLIP, STICK, dot, share_kernel

FLIPS = 3  # changes of a node in one step after which no plane is taken from it any more


@kernel
def _drop(nodes, i, k):
    """Take a plane from a node; one without planes is open."""
    for j in range(k, PLANES - 1):
        nodes.owner[i, j] = nodes.owner[i, j + 1]
        nodes.over[i, j] = nodes.over[i, j + 1]
        nodes.normal[i, j] = nodes.normal[i, j + 1]
        nodes.height[i, j] = nodes.height[i, j + 1]
    nodes.owner[i, PLANES - 1] = -1
    if nodes.owner[i, 0] < 0:
        nodes.state[i] = OPEN
        nodes.cone[i] = 0.0


@cache
def judge_kernel(kinetic_coefficient: Callable) -> Any:
    """Kernel judge(x1, force, least, changed, work, nodes) of a law of friction.

    Changes the set after a solve that ended at x1 (n, 3) with reactions `force` (n, 3) [N].
    `least` is a slip that is none [m], see slip_friction.py; changed (n,) bool, filled: nodes that
    do; work : STEP; nodes : Set.

    Returns the largest relative change of the friction on a node that slips.
    """
    share = share_kernel(kinetic_coefficient)

    @kernel
    def rub(x1, least, total, work, nodes, i):
        """Set the friction of a node that slips; True if it sticks from now on."""
        way = x1 - nodes.anchor[i]
        for k in range(PLANES):
            if nodes.owner[i, k] >= 0:
                way -= dot(way, nodes.normal[i, k]) * nodes.normal[i, k]
        size = np.sqrt(dot(way, way))
        if size < least and work.friction[0] > 0.0 and nodes.flips[i] <= FLIPS:
            nodes.state[i] = STICK
            return True
        nodes.cone[i] = kinetic_coefficient(size / work.dt, work.friction) * total
        return False

    @kernel
    def judge(x1, force, least, changed, work, nodes):
        soft, still, push = 0.0, np.zeros((PLANES, 3)), np.zeros((PLANES, 3))
        for i in range(len(x1)):
            changed[i] = False
            if nodes.state[i] <= OPEN:
                continue
            # the force that acts on the node is the impulse that would stop minus that
            free = -force[i]
            rough = nodes.state[i] == STICK and work.friction[0] > 0.0
            total, whole = share(
                free, still, nodes.normal[i], nodes.owner[i], 1.0, rough, False, work.friction,
                push,
            )  # fmt: skip
            if nodes.flips[i] <= FLIPS:
                for k in range(PLANES - 1, -1, -1):
                    if nodes.owner[i, k] >= 0 and dot(push[k], nodes.normal[i, k]) <= 0.0:
                        _drop(nodes, i, k)
                        changed[i] = True
                if nodes.state[i] == STICK and not whole:
                    nodes.state[i], changed[i] = SLIP, True
                    nodes.cone[i] = kinetic_coefficient(0.0, work.friction) * total
                    continue
            if nodes.state[i] == SLIP:
                before = nodes.cone[i]
                changed[i] = rub(x1[i], least, total, work, nodes, i) or changed[i]
                allowed = max(nodes.cone[i], before)
                if allowed > 0.0:
                    soft = max(soft, abs(nodes.cone[i] - before) / allowed)
        return soft

    return judge
