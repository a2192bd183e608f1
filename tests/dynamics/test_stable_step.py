# SPDX-License-Identifier: LGPL-3.0-or-later
"""The largest stable step, estimated: stable, and close to the limit."""

from mpi4py import MPI

import numpy as np
import pytest

from shellform import Shell
from shellform.dynamics.explicit import Newmark
from shellform.dynamics.stable_step import admit, scaled, stiffen
from shellform.errors import Unstable
from tests.dynamics.test_explicit import FABRICS, sheet


@pytest.mark.parametrize("name", FABRICS)
@pytest.mark.parametrize("stretched", [False, True])
def test_stable_step_is_stable_and_close_to_the_limit(name, stretched):
    """At the estimate a perturbation stays bounded; 30 % above it grows."""
    surface = sheet(6).surface

    def growth(factor, steps):
        shell = Shell(surface, FABRICS[name])
        X = surface.points[shell.partition.nodes]
        if stretched:
            w = shell.w.x.array.reshape(-1, 6)
            w[:, 0], w[:, 1] = 0.1 * X[:, 0] + 0.1 * X[:, 1], -0.05 * X[:, 1]
            for edge in ("left", "right", "bottom", "top"):
                shell.supports.clamp(edge)
        newmark = Newmark(shell)
        newmark.dt, newmark.recheck = factor * newmark.critical_dt, 10**9
        newmark.rewind.retries = 0
        rng = np.random.default_rng(0)
        kick = rng.standard_normal((len(surface.points), 3))
        newmark.v[:] = 1e-6 * kick[shell.partition.owned_nodes]
        size = []
        for _ in range(4):
            try:
                newmark.advance(newmark.time + steps / 4 * newmark.dt)
            except Unstable:
                return np.inf
            size.append(shell.comm.allreduce(np.abs(newmark.v).max(), MPI.MAX))
        return size[-1] / size[0]

    assert growth(1.0, 4000) < 10
    assert growth(1.3, 400) > 1e3


@pytest.mark.slow
@pytest.mark.parametrize("name", FABRICS)
def test_a_long_run_at_the_stable_step_does_not_grow(name):
    """100 000 steps at the estimate on a stretched, sheared sheet, seeded by noise."""
    surface = sheet(2).surface
    shell = Shell(surface, FABRICS[name])
    X = surface.points[shell.partition.nodes]
    w = shell.w.x.array.reshape(-1, 6)
    w[:, 0], w[:, 1] = 0.1 * X[:, 0] + 0.1 * X[:, 1], -0.05 * X[:, 1]
    for edge in ("left", "bottom", "top"):
        shell.supports.clamp(edge)
    shell.supports.hold("right")
    newmark = Newmark(shell)
    newmark.dt, newmark.recheck = newmark.critical_dt, 10**9
    newmark.rewind.retries = 0
    noise = np.random.default_rng(0).standard_normal((2, len(surface.points), 3))
    own = shell.partition.owned_nodes
    newmark.v[:] = np.where(newmark.held[:, :3], 0.0, 1e-6 * noise[0, own])
    size = []
    for _ in range(10):
        newmark.advance(newmark.time + 10_000 * newmark.dt)
        size.append(shell.comm.allreduce(np.abs(newmark.v).max(), MPI.MAX))
    assert newmark.steps >= 99_990
    assert max(size[5:]) < 3 * max(size[:5])
    assert max(size) < 1e-4


def test_kernels_do_what_matrices_do():
    """Against projections written as matrices, node by node."""
    rng, n = np.random.default_rng(1), 7
    y, d, root = (rng.standard_normal((n, k)) for k in (6, 3, 6))
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    held, plane, pull = rng.random((n, 4)) < 0.3, np.zeros((n, 3)), rng.standard_normal(n)
    plane[::2] = np.cross(d[::2], [0.0, 0.0, 1.0])
    plane[::2] /= np.linalg.norm(plane[::2], axis=1, keepdims=True)
    moved = np.empty_like(y)
    size = scaled(y, root, 0.1, moved)
    assert np.array_equal(moved, y / root)
    assert size == max(np.abs(moved[:, :3]).max() / 0.1, np.abs(moved[:, 3:]).max())
    found = y.copy()
    stiffen(found, moved, pull)
    admit(found, d, held, plane)
    for i in range(n):
        free = np.diag([*~held[i, :3], *[not held[i, 3]] * 3]).astype(float)
        for normal in (d[i], plane[i]):
            free[3:, 3:] = (np.eye(3) - np.outer(normal, normal)) @ free[3:, 3:]
        pulled = np.diag([0.0, 0, 0, *[pull[i]] * 3])
        assert np.abs(found[i] - free @ (y[i] - pulled @ moved[i])).max() < 1e-13
