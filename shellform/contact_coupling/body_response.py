# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a body makes of the velocities that self-contact would give the nodes that touch it.

The contact of the body is asked in advance, as often as sweeps need it; it is computed and booked
once, afterwards. From its answers: nodes that stick to the body cannot move, those that slide move
along it, and those on flesh go into it too. Its normal is the direction of the push without
friction. Asked are nodes that touched the body in the step before, and fast ones that were near.
"""

from typing import Any

from mpi4py import MPI

import numpy as np

from contact.kernel import kernel
from contact.self_contact.relaxation import Answer, Respond
from contact.solver.friction import Friction

FRICTIONLESS = Friction(0.0)
SLIDES = 1e-6  # of the normal impulse: friction this near to the kinetic one is that of slip


@kernel(makes_arrays=False)
def leave(
    u: np.ndarray,
    after: np.ndarray,
    pushes: np.ndarray,
    kinetic: float,
    give: np.ndarray,
    held: np.ndarray,
    free: np.ndarray,
    left: np.ndarray,
) -> None:
    """Fill left (k, 3, 3) with what a body leaves of the mobilities `free` of nodes.

    u, after : (k, 3), velocities that it was given and that it made of them, of which those held by
        supports, held (k, 3) bool, are set back [m/s]
    pushes : (k, 3), along its normals, where it pushes without friction; kinetic : coefficient
    give : (k,), part of a change along the normal that it leaves, see `normal_give` of corrections
    """
    for i in range(len(u)):
        pushed, along, square, size = False, 0.0, 0.0, 0.0
        for c in range(3):
            given = after[i, c] - u[i, c]
            pushed = pushed or given != 0.0
            along += given * pushes[i, c]
            square += given * given
            size += pushes[i, c] * pushes[i, c]
        across = 0.0
        if size > 0.0:
            along /= np.sqrt(size)
            across = np.sqrt(max(0.0, square - along * along))
        slides = size > 0.0 and abs(across - kinetic * along) <= SLIDES * along
        for c in range(3):
            if held[i, c]:
                after[i, c] = u[i, c]
            for e in range(3):
                left[i, c, e] = free[i, c, e]
                if pushed:
                    left[i, c, e] = 0.0
        if pushed and slides:
            for c in range(3):
                for e in range(3):
                    for a in range(3):
                        # (1 - n n) free (1 - n n), free being diagonal
                        one = (a == c) - pushes[i, a] * pushes[i, c] / size
                        other = (a == e) - pushes[i, a] * pushes[i, e] / size
                        left[i, c, e] += one * free[i, a, a] * other
        if pushed and size > 0.0 and give[i] > 0.0:
            normal = 0.0
            for a in range(3):
                normal += free[i, a, a] * pushes[i, a] * pushes[i, a] / size
            for c in range(3):
                for e in range(3):
                    left[i, c, e] += give[i] * normal * pushes[i, c] * pushes[i, e] / size


def of_all_ranks(comm: Any, mine: Answer | None) -> Answer | None:
    """Answers of all ranks, one rank after another; numbers are exchanged as they stand."""
    count = 0 if mine is None else len(mine[0])
    own = np.empty((count, 13))
    if mine is not None:
        own[:, 0], own[:, 1:4], own[:, 4:] = mine[0], mine[1], mine[2].reshape(count, 9)
    counts = np.empty(comm.size, np.int64)
    comm.Allgather(np.array([count]), counts)
    if not counts.any():
        return None
    found = np.empty((counts.sum(), 13))
    comm.Allgatherv(own, [found, 13 * counts, MPI.DOUBLE])
    nodes, after = found[:, 0].astype(np.int64), found[:, 1:4].copy()
    return nodes, after, found[:, 4:].copy().reshape(-1, 3, 3)


def response(correction: Any, cloth: Any, stepper: Any, x: np.ndarray, dt: float) -> Respond:
    """Answers of a body in a step of dt [s], for `SelfContactSolver.solve`.

    correction : NodeCorrection or UnionCorrection of the nodes; cloth : ExplicitSelfContact
    x : (n_owned, 3), positions [m]
    """
    comm, own = stepper.shell.comm, cloth.own
    normals: list[np.ndarray] = []
    asked: list[Any] = []  # nodes, and what does not change between the turns of a step

    def respond(v, live):
        if not asked:
            near = np.flatnonzero(live[own])
            may = correction.may_touch(near, stepper.v_old[near], dt, 0.5 * cloth.thickness)
            nodes = near[may]
            whole = nodes + own.start
            free = cloth.solver.relaxation.mobility[whole]
            asked.extend((nodes, whole, x[nodes], stepper.mass[nodes], cloth.held[nodes], free))
        mine = answer(v, *asked) if len(asked[0]) else None
        return mine if comm.size == 1 else of_all_ranks(comm, mine)

    def answer(v, nodes, whole, y, mass, held, free):
        """Those of nodes (k,) of this rank at velocities v (n, 3) of all."""
        u, left = v[whole], np.empty_like(free)
        ask = correction.preview
        after, active, sticking = ask(nodes, y, u, mass, dt, stepper.time)
        give = correction.normal_give(nodes, dt)
        if (sticking < active or give.any()) and not normals:
            normal = after - u
            if correction.friction.static > 0.0:
                normal = ask(nodes, y, u, mass, dt, stepper.time, FRICTIONLESS)[0] - u
            normals.append(normal)
        kinetic = correction.friction.kinetic
        pushes = normals[0] if normals else after - u
        leave(u, after, pushes, kinetic, give, held, free, left)
        return whole, after, left

    return respond
