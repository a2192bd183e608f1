# SPDX-License-Identifier: LGPL-3.0-or-later
"""Nodes held by contact under implicit steps: by which planes, with what impulse.

A node has up to three planes, each tangent to a segment of the body at the node's foot. Reactions
and impulses are shared out among them by passes over the planes: each takes what acts against it,
at most what its cone of friction transmits (friction.py).
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from .friction import transmitted
from .node_contact import FRICTION, IMPACT, WORK

FIXED, OPEN, SLIP, STICK = -1, 0, 1, 2
PLANES = 3
PASSES = 40  # over the planes of a node where several hold it

compiled = njit(cache=True, error_model="numpy")


class Set(NamedTuple):
    """Nodes in contact.

    state (n,): FIXED (left to the supports), OPEN, SLIP or STICK; owner (n, 3): segments, -1 where
    none; normal (n, 3, 3), height (n, 3): planes normal . x = height at the end of the step [m];
    anchor (n, 3): where the place on the body that the node started on ends the step [m];
    load (n, 3): friction of a node that slips [N]; way_out (n,): depth kept at the end of the step
    by a node that starts far inside [m]; flips (n,): changes in this step.
    """

    state: np.ndarray
    owner: np.ndarray
    normal: np.ndarray
    height: np.ndarray
    anchor: np.ndarray
    load: np.ndarray
    way_out: np.ndarray
    flips: np.ndarray


def new(n):
    """Set of n open nodes."""
    return Set(
        np.zeros(n, np.int64), np.full((n, PLANES), -1), np.zeros((n, PLANES, 3)),
        np.zeros((n, PLANES)), np.zeros((n, 3)), np.zeros((n, 3)), np.zeros(n),
        np.zeros(n, np.int64),
    )  # fmt: skip


def copy(nodes):
    """Copy of a Set."""
    return Set(*(array.copy() for array in nodes))


def take(source, target):
    """Copy one Set into another."""
    for here, there in zip(source, target, strict=True):
        there[:] = here


@compiled
def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@compiled
def shared(free, surface, normal, owner, mass, mu_s, mu_k, push):
    """Impulses (or forces) of the planes that hold a node.

    Parameters
    ----------
    free : (3,), velocity before; changed to that after
    surface : (3, 3), velocities of the planes; normal, owner : of one node
    mass : float [kg]; push : (3, 3), filled

    Returns
    -------
    sum of the normal impulses; True if all friction that was asked for is transmitted
    """
    push[:] = 0.0
    total, whole = 0.0, True
    for _ in range(PASSES):
        total, whole, change, count = 0.0, True, 0.0, 0
        for k in range(PLANES):
            if owner[k] < 0:
                continue
            count += 1
            n = normal[k]
            trial = push[k] + mass * (surface[k] - free)
            along = dot(trial, n)
            rub = trial - along * n
            along = max(0.0, along)
            size = np.sqrt(dot(rub, rub))
            fraction = transmitted(along, size, mu_s, mu_k) if size > 0.0 else 1.0
            whole = whole and fraction == 1.0
            total += along
            for c in range(3):
                new = along * n[c] + fraction * rub[c]
                free[c] += (new - push[k, c]) / mass
                change = max(change, abs(new - push[k, c]))
                push[k, c] = new
        if count == 1 or change <= 1e-14 * total:
            break
    return total, whole


@compiled
def constrain(points, nodes, axes, held, goal):
    """Axes, held directions and displacements along them (Inertial.hold) from the set."""
    for i in range(len(points)):
        axes[i] = 0.0
        goal[i] = 0.0
        for c in range(3):
            held[i, c] = False
            axes[i, c, c] = 1.0
        if nodes.state[i] == STICK:
            for c in range(3):
                held[i, c] = True
                goal[i, c] = nodes.anchor[i, c] - points[i, c]
        elif nodes.state[i] == SLIP:
            rows = 0
            for k in range(PLANES):
                if nodes.owner[i, k] < 0:
                    continue
                n = nodes.normal[i, k].copy()
                g = nodes.height[i, k] - dot(n, points[i])
                for j in range(rows):
                    along = dot(axes[i, j], n)
                    g -= along * goal[i, j]
                    n -= along * axes[i, j]
                size = np.sqrt(dot(n, n))
                if size < 1e-6:
                    continue
                axes[i, rows] = n / size
                goal[i, rows] = g / size
                held[i, rows] = True
                rows += 1
            _complete(axes[i], rows)


@compiled
def _complete(rows, known):
    """Fill rows (3, 3), of which `known` are orthonormal, to a right-handed basis."""
    if known == 1:
        a = rows[0]
        k = np.argmin(np.abs(a))
        b = np.zeros(3)
        b[k] = 1.0
        b -= a[k] * a
        rows[1] = b / np.sqrt(dot(b, b))
    for c in range(3):
        d, e = (c + 1) % 3, (c + 2) % 3
        if known < 3:
            rows[2, c] = rows[0, d] * rows[1, e] - rows[0, e] * rows[1, d]


@compiled
def push(
    x, v, v_old, mean, moved, a, mass, dt, centres, velocities, spins, law, before, nodes,
    impulse, book, pushed,
):  # fmt: skip
    """Impulses of a solved step on velocities v, booked; returns nodes held, of these in stick."""
    mu_s, mu_k = law[0], law[1]
    active = sticking = 0
    surface, push = np.zeros((PLANES, 3)), np.zeros((PLANES, 3))
    for i in range(len(x)):
        if nodes.state[i] <= OPEN:
            continue
        for k in range(PLANES):
            b = nodes.owner[i, k]
            if b >= 0:
                for c in range(3):
                    d, e = (c + 1) % 3, (c + 2) % 3
                    turn = spins[b, d] * (x[i, e] - centres[b, e])
                    turn -= spins[b, e] * (x[i, d] - centres[b, d])
                    surface[k, c] = velocities[b, c] + turn
        free = v[i].copy()
        total, whole = shared(
            free, surface, nodes.normal[i], nodes.owner[i], mass[i], mu_s, mu_k, push
        )
        active += 1
        sticking += whole
        # positions that velocities did not move: forces did work on that way
        astray = 0.0
        sum_of = np.zeros(3)
        for c in range(3):
            astray += mass[i] * mean[i, c] * (moved[i, c] - 0.5 * dt * (v_old[i, c] + free[c]))
        for k in range(PLANES):
            b = nodes.owner[i, k]
            if b < 0:
                continue
            along = dot(push[k], nodes.normal[i, k])
            share = along / total if total > 0.0 else (1.0 if k == 0 else 0.0)
            for c in range(3):
                d, e = (c + 1) % 3, (c + 2) % 3
                normal = along * nodes.normal[i, k, c]
                slip = 0.5 * (v_old[i, c] + free[c]) - surface[k, c]
                book[b, c] += push[k, c]
                book[b, 3 + c] += (x[i, d] - centres[b, d]) * push[k, e]
                book[b, 3 + c] -= (x[i, e] - centres[b, e]) * push[k, d]
                book[b, WORK] += push[k, c] * surface[k, c]
                book[b, FRICTION] -= (push[k, c] - normal) * slip
                book[b, IMPACT] -= normal * slip
                sum_of[c] += push[k, c]
            book[b, IMPACT] += share * astray
        for c in range(3):
            impulse[i, c] = sum_of[c]
            v[i, c] += sum_of[c] / mass[i]
            pushed[i, c] = sum_of[c] / (mass[i] * dt) if before[i] > OPEN else -a[i, c]
    return active, sticking
