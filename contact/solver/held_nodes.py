# SPDX-License-Identifier: LGPL-3.0-or-later
"""Nodes held by contact under implicit steps: by which planes, with what impulse.

A node has up to three planes, each tangent to a segment of the body at the node's foot. Reactions
and impulses are shared out among them by passes over the planes: each takes what acts against it,
at most what its cone of friction transmits (friction.py).
"""

from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from contact.kernel import kernel

from .friction import cone_kernel

FIXED, OPEN, SLIP, STICK = -1, 0, 1, 2
PLANES = 3
PASSES = 40  # over the planes of a node where several hold it


class Set(NamedTuple):
    """Nodes in contact.

    state (n,): FIXED (wholly held by supports), OPEN, SLIP or STICK; owner (n, 3): segments, -1
    where none; over (n, 3): what of them, see obstacle.py; normal (n, 3, 3), height (n, 3): planes
    normal . x = height at the end of the step [m];
    anchor (n, 3): where the place on the body that the node started on ends the step [m];
    cone (n,): friction of a node that slips [N]; way_out (n,): depth kept at the end of the step
    by a node that starts far inside [m]; flips (n,): changes in this step.
    """

    state: np.ndarray
    owner: np.ndarray
    over: np.ndarray
    normal: np.ndarray
    height: np.ndarray
    anchor: np.ndarray
    cone: np.ndarray
    way_out: np.ndarray
    flips: np.ndarray


class SolvedStep(NamedTuple):
    """A step whose positions are found, n nodes.

    x (n, 3): positions at its end [m]; v (n, 3): velocities advanced by all forces but contact
    [m/s], changed; v_old (n, 3): those at its start; mean (n, 3): acceleration by all forces but
    contact; moved (n, 3): displacement in the step [m]; a (n, 3): acceleration at its start
    [m/s^2]; mass (n,) [kg].
    """

    x: np.ndarray
    v: np.ndarray
    v_old: np.ndarray
    mean: np.ndarray
    moved: np.ndarray
    a: np.ndarray
    mass: np.ndarray


def new(n: int) -> Set:
    """Set of n open nodes."""
    return Set(
        np.zeros(n, np.int64), np.full((n, PLANES), -1), np.zeros((n, PLANES), np.int64),
        np.zeros((n, PLANES, 3)), np.zeros((n, PLANES)), np.zeros((n, 3)), np.zeros(n), np.zeros(n),
        np.zeros(n, np.int64),
    )  # fmt: skip


def copy(nodes: Set) -> Set:
    """Copy of a Set."""
    return Set(*(array.copy() for array in nodes))


def take(source: Set, target: Set) -> None:
    """Copy one Set into another."""
    for here, there in zip(source, target, strict=True):
        there[:] = here


@kernel
def dot(a: np.ndarray, b: np.ndarray) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@cache
def share_kernel(kinetic_coefficient: Callable) -> Any:
    """Kernel share(free, surface, normal, owner, mass, rough, speeds, friction, push) of a law.

    Impulses (or forces) of the planes that hold a node.

    free : (3,), velocity before; changed to that after
    surface : (3, 3), velocities of the planes; normal, owner : of one node
    mass : float [kg]
    rough : bool, with friction; speeds : bool, whether `free` is a velocity: the law gets the
        speed of the slip, else zero
    friction : numbers of the law, see friction.py; push : (3, 3), filled

    Returns the sum of the normal impulses; True if all friction that was asked for is transmitted.
    """
    transmitted = cone_kernel(kinetic_coefficient)

    @kernel
    def share(free, surface, normal, owner, mass, rough, speeds, friction, push):
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
                tangential = trial - along * n
                along = max(0.0, along)
                size = np.sqrt(dot(tangential, tangential))
                fraction = 1.0
                if size > 0.0:
                    speed = size / mass if speeds else 0.0
                    fraction = transmitted(along, size, speed, friction) if rough else 0.0
                whole = whole and fraction == 1.0
                total += along
                for c in range(3):
                    new = along * n[c] + fraction * tangential[c]
                    free[c] += (new - push[k, c]) / mass
                    change = max(change, abs(new - push[k, c]))
                    push[k, c] = new
            if count == 1 or change <= 1e-14 * total:
                break
        return total, whole

    return share


@cache
def push_kernel(kinetic_coefficient: Callable) -> Any:
    """Kernel push(solved, surface, work, before, nodes, impulse, impulses, energies, pushed) of a
    law of friction: impulses of a solved step on its velocities v.

    solved : SolvedStep; surface (n, 3, 3) : velocities of the body below the planes; work : STEP
    before : (n,), states of the nodes in the last step; nodes : Set; impulse : (n, 3), filled
    impulses, energies (n, 3, 3), filled : of the planes, see `Obstacle`
    pushed : (n, 3), filled: part of contact in the acceleration that the next step starts from

    Returns the nodes held, of these in stick.
    """
    share = share_kernel(kinetic_coefficient)

    @kernel
    def push(solved, surface, work, before, nodes, impulse, impulses, energies, pushed):
        x, v, v_old, mean, moved, a, mass = solved
        active, sticking, dt = 0, 0, work.dt
        for i in range(len(x)):
            if nodes.state[i] <= OPEN:
                continue
            owner, normals, planes = nodes.owner[i], nodes.normal[i], impulses[i]
            free = v[i].copy()
            total, whole = share(
                free, surface[i], normals, owner, mass[i], work.friction[0] > 0.0, True,
                work.friction, planes,
            )  # fmt: skip
            active += 1
            sticking += whole
            # positions that velocities did not move: forces did work on that way
            astray = 0.0
            for c in range(3):
                astray += mass[i] * mean[i, c] * (moved[i, c] - 0.5 * dt * (v_old[i, c] + free[c]))
                impulse[i, c] = 0.0
            for k in range(PLANES):
                if owner[k] < 0:
                    continue
                along = dot(planes[k], normals[k])
                part = along / total if total > 0.0 else (1.0 if k == 0 else 0.0)
                done, lost, impact = 0.0, 0.0, part * astray
                for c in range(3):
                    normal = along * normals[k, c]
                    slip = 0.5 * (v_old[i, c] + free[c]) - surface[i, k, c]
                    done += planes[k, c] * surface[i, k, c]
                    lost -= (planes[k, c] - normal) * slip
                    impact -= normal * slip
                    impulse[i, c] += planes[k, c]
                energies[i, k, 0], energies[i, k, 1], energies[i, k, 2] = done, lost, impact
            for c in range(3):
                v[i, c] += impulse[i, c] / mass[i]
                pushed[i, c] = impulse[i, c] / (mass[i] * dt) if before[i] > OPEN else -a[i, c]
        return active, sticking

    return push
