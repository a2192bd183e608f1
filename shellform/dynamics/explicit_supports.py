# SPDX-License-Identifier: LGPL-3.0-or-later
"""Held and moving nodes in explicit steps: which velocities are the supports', and what they are.

A node of prescribed motion gets the velocity that brings it where it is due at the end of a step;
the impulse that takes, and the moment on its director, is the supports'.
"""

from typing import Any

from mpi4py import MPI

import numpy as np

from shellform.fem.supports import Supports

from .books import INTERNAL, SUPPORT
from .explicit_kernels import Forces
from .prescribed_motion import way_to_goal


def conditions(supports: Supports, n: int, comm: Any) -> tuple[np.ndarray, np.ndarray]:
    """Held components (n, 4) bool (u_x, u_y, u_z, director) and normals (n, 3) for directors.

    A director does not turn towards its normal; zero where there is none.

    Raises
    ------
    ValueError on all ranks for inclined supports and for displacements that do not tell a time
    """
    if comm.allreduce(bool(supports.inclined.any()), op=MPI.LOR):
        raise ValueError("explicit steps hold displacements along x, y, z only")
    if supports.steady_goals():
        raise ValueError("in dynamics a prescribed displacement is a function of time")
    held, plane = supports.held[:n], np.nan_to_num(supports.plane[:n])
    fixed = np.column_stack([held[:, :3], held[:, 3] & held[:, 4]])
    return fixed, np.where(held[:, 4:] & ~held[:, 3:4], plane, 0.0)


def follow(stepper: Any, dt: float, kicked: float, forces: Forces) -> None:
    """Give nodes of prescribed motion the velocities that bring them where they are due in dt [s].

    `kicked` [s] is the time over which the last kick added its `forces`. Impulses and works are the
    supports'.
    """
    for nodes, v, q in way_to_goal(stepper, dt):
        if v is not None:
            push = stepper.mass[nodes, None] * (v - stepper.v[nodes])
            forces.support[nodes] += push
            stepper.v[nodes] = v
        if q is not None:
            old = stepper.q[nodes]
            stepper.q[nodes] = q
            # what turns them works against the sheet and their inertia
            inner = 0.5 * kicked * np.vdot(forces.internal[nodes, 3:], old + q)
            gained = 0.5 * stepper.inertia[nodes] @ np.sum(q**2 - old**2, axis=1)
            stepper.books.works[INTERNAL] -= inner
            stepper.books.works[SUPPORT] += inner + gained
