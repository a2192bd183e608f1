# SPDX-License-Identifier: LGPL-3.0-or-later
"""The largest stable step of explicit Newmark steps, 2/omega_max: Sec. 3.1.3.

omega_max^2 is the largest Ritz value of a Lanczos run on M^-1 K (Lanczos, J. Res. Natl. Bur. Stand.
45, 1950); products with K are differences of internal forces, so no matrix is made. Ritz values
come from below: a few per cent are taken off the step for that.
"""

from typing import Any

from mpi4py import MPI

import numpy as np

from contact.kernel import kernel

SPARE = 0.97  # of the step that the last Ritz value allows


def stable_step(stepper: Any, iterations: int = 30) -> float:
    """Largest stable step [s] of a Newmark stepper at its present configuration, less SPARE.

    Raises
    ------
    ArithmeticError if no eigenvalue is positive
    """
    value = largest_eigenvalue(stepper, iterations)
    if not value > 0:
        raise ArithmeticError("no positive eigenvalue")
    tau = stepper.damping
    return SPARE * float(np.sqrt(tau**2 + 4 / value) - tau)


@kernel
def scaled(y: np.ndarray, root: np.ndarray, cell: float, out: np.ndarray) -> float:
    """Fill out (n, 6) with y / root; returns its largest entry, of displacements over `cell`."""
    place = turn = 0.0
    for i in range(len(y)):
        for k in range(3):
            out[i, k] = y[i, k] / root[i, k]
            out[i, 3 + k] = y[i, 3 + k] / root[i, 3 + k]
            place, turn = max(place, abs(out[i, k])), max(turn, abs(out[i, 3 + k]))
    return max(place / cell, turn)


@kernel
def stiffen(z: np.ndarray, y: np.ndarray, pull: np.ndarray) -> None:
    """Take off z (n, 6) what a pull (n,) along directors does as y (n, 6) turns them."""
    for i in range(len(z)):
        for k in range(3, 6):
            z[i, k] -= pull[i] * y[i, k]


@kernel
def admit(y: np.ndarray, d: np.ndarray, held: np.ndarray, plane: np.ndarray) -> None:
    """Take off y (n, 6) what supports hold and what would stretch directors d (n, 3).

    held : (n, 4), plane : (n, 3), see NODE in explicit_kernels.py
    """
    for i in range(len(y)):
        for k in range(3):
            y[i, k] = 0.0 if held[i, k] else y[i, k]
            y[i, 3 + k] = 0.0 if held[i, 3] else y[i, 3 + k]
        for normal in (d, plane):
            along = y[i, 3] * normal[i, 0] + y[i, 4] * normal[i, 1] + y[i, 5] * normal[i, 2]
            for k in range(3):
                y[i, 3 + k] -= along * normal[i, k]


def largest_eigenvalue(stepper: Any, iterations: int) -> float:
    """Largest eigenvalue omega^2 [1/s^2] of M^-1 K on what supports leave free, from below."""
    comm, w, owned = stepper.shell.comm, stepper.w, stepper.owned
    held, plane, model = stepper.held, stepper.nodes["plane"].copy(), stepper.force_model
    frozen = model.freeze(w)
    root = np.sqrt(np.repeat(np.column_stack([stepper.mass, stepper.inertia]), 3, axis=1))
    cell = stepper.shell.surface.mean_cell_size
    base, d = owned.copy(), owned[:, 3:].copy()
    r = model.elastic(w, frozen).copy()
    pull = np.sum(r[:, 3:] * d, axis=1)
    moved = np.empty_like(base)

    def over_ranks(number, operation=MPI.SUM):
        # mpi4py takes longer to hand a number to itself than a small sheet does for a product
        return number if comm.size == 1 else comm.allreduce(number, operation)

    def dot(a, b):
        return over_ranks(float(np.vdot(a, b)))

    def product(y):
        size = over_ranks(scaled(y, root, cell, moved), MPI.MAX)
        h = 1e-6 / size
        sides = []
        for sign in (1, -1):
            owned[:] = base + sign * h * moved
            stepper.scatter()
            sides.append(model.elastic(w, frozen).copy())
        z = np.subtract(*sides)
        z /= 2 * h
        stiffen(z, moved, pull)
        admit(z, d, held, plane)
        z /= root
        return z

    # the same start on any number of ranks
    whole = np.random.default_rng(0).standard_normal((len(stepper.shell.surface.points), 6))
    y = whole[stepper.shell.partition.owned_nodes]
    admit(y, d, held, plane)
    y /= np.sqrt(dot(y, y))
    previous, beta, alphas, betas = np.zeros_like(y), 0.0, [], []
    for _ in range(iterations):
        z = product(y) - beta * previous
        alphas.append(dot(y, z))
        z -= alphas[-1] * y
        beta = np.sqrt(dot(z, z))
        if not beta > 1e-12 * abs(alphas[0]):
            break
        betas.append(beta)
        previous, y = y, z / beta
    owned[:] = base
    stepper.scatter()
    off_diagonal = np.array(betas[: len(alphas) - 1])
    tridiagonal = np.diag(alphas) + np.diag(off_diagonal, 1) + np.diag(off_diagonal, -1)
    if not np.isfinite(tridiagonal).all():
        return np.nan
    return float(np.linalg.eigvalsh(tridiagonal)[-1])
