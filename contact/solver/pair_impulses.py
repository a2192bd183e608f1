# SPDX-License-Identifier: LGPL-3.0-or-later
"""Impulses of pairs that share nodes, Eqs. 15 and 16: found all at once, pass by pass.

A pair meets the segment at the point sum_a w_a x_a of its edge or cell. Several pairs share a node.
Its mass is shared out among them by their weights (Tonge, Benevolenski and Voroshilov, ACM Trans.
Graph. 31, 2012; cell_samples.py): with W_a = sum_s w_as of the pairs that push or lack a push

    M_s = 1 / sum_a w_as W_a / m_a,

which is exact where no node is shared. A pass changes the impulse of every pair by what its point
still lacks, M_s (bound - n . step) / dt along the normal and M_s slip across it, keeps the sum of
all passes within the cone of friction, and gives m_a dv_a = sum_s w_as dJ_s to the nodes. The whole
impulse of a pair pushes, although one pass may take back what another gave: passes come closer to
what all pairs together need, in no order, so the same on any number of ranks. Momentum is exact
after any number of them; passes go on until what is lacked has come down to LEFT of the first.
"""

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from contact.kernel import kernel

from .contact_ledger import book_impulse
from .friction import cone_kernel

PASSES = 8, 80  # at least, where there is friction; at most
LEFT = 1e-3  # of what the first pass lacked


@kernel
def add_shares(pairs: np.ndarray, v: np.ndarray, dt: float, share: np.ndarray) -> float:
    """Add the weights of the pairs (k,) PAIR that push or should to W (n,) of their nodes.

    v : (n, 3), velocities by all passes before [m/s]

    Returns the greatest velocity that a pair lacks, or pushes too much [m/s]
    """
    worst = 0.0
    for k in range(len(pairs)):
        pair = pairs[k]
        pair.lacks = pair.bound / dt
        for a in range(len(pair.nodes)):
            for c in range(3):
                pair.lacks -= pair.weights[a] * pair.normal[c] * v[pair.nodes[a], c]
        if pair.push > 0.0 or pair.lacks > 0.0:
            worst = max(worst, abs(pair.lacks))
            for a in range(len(pair.nodes)):
                share[pair.nodes[a]] += pair.weights[a]
    return worst


@kernel
def set_masses(pairs: np.ndarray, share: np.ndarray, mass: np.ndarray, fixed: np.ndarray) -> None:
    """Fill the masses M [kg] of pairs (k,) PAIR; 0 of those that a pass leaves alone.

    share, mass : (n,), W and m [kg] of the nodes; fixed : (n,) bool, those that no push moves
    """
    for k in range(len(pairs)):
        pair, inverse = pairs[k], 0.0
        if pair.push > 0.0 or pair.lacks > 0.0:
            for a in range(len(pair.nodes)):
                i = pair.nodes[a]
                if not fixed[i]:
                    inverse += pair.weights[a] * share[i] / mass[i]
        pair.mass = 1.0 / inverse if inverse > 0.0 else 0.0


@cache
def pass_kernel(kinetic_coefficient: Callable) -> Any:
    """Kernel one_pass(pairs, v, dt, parameters, change) of a law of friction.

    pairs : (k,) PAIR after `add_shares` and `set_masses`, their impulses are updated
    v : (n, 3), velocities by all passes before [m/s]
    parameters : numbers of the law; change : (n, 3 or more), impulses [N s], added to
    """
    transmitted = cone_kernel(kinetic_coefficient)

    @kernel
    def one_pass(pairs, v, dt, parameters, change):
        rough = parameters[0] > 0.0
        slip, given = np.empty(3), np.empty(3)
        for k in range(len(pairs)):
            pair = pairs[k]
            if pair.mass == 0.0:
                continue
            along = 0.0
            for c in range(3):
                speed = -pair.drift[c] / dt
                for a in range(len(pair.nodes)):
                    speed += pair.weights[a] * v[pair.nodes[a], c]
                slip[c] = speed
                along += pair.normal[c] * speed
            push = max(0.0, pair.push + pair.mass * pair.lacks)
            for c in range(3):
                given[c] = (push - pair.push) * pair.normal[c]
            pair.push = push
            if rough:
                size = 0.0
                for c in range(3):
                    slip[c] = pair.friction[c] - pair.mass * (slip[c] - along * pair.normal[c])
                    size += slip[c] * slip[c]
                size = np.sqrt(size)
                part = 0.0
                if push > 0.0:
                    part = transmitted(push, size, size / pair.mass, parameters)
                for c in range(3):
                    given[c] += part * slip[c] - pair.friction[c]
                    pair.friction[c] = part * slip[c]
            for a in range(len(pair.nodes)):
                for c in range(3):
                    change[pair.nodes[a], c] += pair.weights[a] * given[c]

    return one_pass


@kernel
def book_pairs(
    pairs: np.ndarray,
    old: np.ndarray,
    after: np.ndarray,
    dt: float,
    segments: np.ndarray,
    table: np.ndarray,
) -> tuple[int, float]:
    """Book what pairs (k,) PAIR gave in a step; how many pushed, and the deepest start [m].

    old, after : (n, 3), velocities of the nodes before the forces and after contact [m/s]
    segments : (m,) SEGMENT; table : (m, BOOKED), see contact_ledger.py, added to
    """
    active, deepest, impulse = 0, 0.0, np.empty(3)
    for k in range(len(pairs)):
        pair = pairs[k]
        deepest = max(deepest, pair.depth)
        if pair.push <= 0.0:
            continue
        active += 1
        done = pressed = rubbed = 0.0
        for c in range(3):
            surface, slip = pair.drift[c] / dt, 0.0
            for a in range(len(pair.nodes)):
                i = pair.nodes[a]
                slip += 0.5 * pair.weights[a] * (old[i, c] + after[i, c])
            slip -= surface
            impulse[c] = pair.push * pair.normal[c] + pair.friction[c]
            done += impulse[c] * surface
            pressed -= pair.push * pair.normal[c] * slip
            rubbed -= pair.friction[c] * slip
        b = pair.owner
        book_impulse(table[b], segments[b].centre, pair.x, impulse, done, rubbed, pressed)
    return active, deepest
