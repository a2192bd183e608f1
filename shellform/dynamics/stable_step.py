# SPDX-License-Identifier: LGPL-3.0-or-later
"""The largest stable step of explicit Newmark steps, 2/omega_max: Sec. 3.1.3.

omega_max^2 is the largest Ritz value of a Lanczos run on M^-1 K (Lanczos, J. Res. Natl. Bur. Stand.
45, 1950); products with K are differences of internal forces, so no matrix is made. Ritz values
come from below: a few per cent are taken off the step for that.
"""

from typing import Any

from mpi4py import MPI

import numpy as np

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


def largest_eigenvalue(stepper: Any, iterations: int) -> float:
    """Largest eigenvalue omega^2 [1/s^2] of M^-1 K on what supports leave free, from below."""
    comm, w, owned = stepper.shell.comm, stepper.w, stepper.owned
    held, plane, model = stepper.held, stepper.nodes["plane"], stepper.force_model
    frozen = model.freeze(w)
    root = np.sqrt(np.repeat(np.column_stack([stepper.mass, stepper.inertia]), 3, axis=1))
    cell = stepper.shell.surface.mean_cell_size
    base, d = owned.copy(), owned[:, 3:].copy()
    r = model.elastic(w, frozen).copy()
    pull = np.sum(r[:, 3:] * d, axis=1, keepdims=True)

    def admissible(y):
        y[:, :3][held[:, :3]] = 0.0
        y[:, 3:][held[:, 3]] = 0.0
        y[:, 3:] -= np.sum(y[:, 3:] * d, axis=1, keepdims=True) * d
        y[:, 3:] -= np.sum(y[:, 3:] * plane, axis=1, keepdims=True) * plane
        return y

    def dot(a, b):
        return comm.allreduce(float(np.vdot(a, b)))

    def product(y):
        y = y / root
        size = comm.allreduce(
            max(np.abs(y[:, :3]).max(initial=0.0) / cell, np.abs(y[:, 3:]).max(initial=0.0)),
            MPI.MAX,
        )
        h = 1e-6 / size
        sides = []
        for sign in (1, -1):
            owned[:] = base + sign * h * y
            stepper.scatter()
            sides.append(model.elastic(w, frozen).copy())
        z = (sides[0] - sides[1]) / (2 * h)
        z[:, 3:] -= pull * y[:, 3:]
        return admissible(z) / root

    # the same start on any number of ranks
    whole = np.random.default_rng(0).standard_normal((len(stepper.shell.surface.points), 6))
    y = admissible(whole[stepper.shell.partition.owned_nodes])
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
