# SPDX-License-Identifier: LGPL-3.0-or-later
"""Damping of explicit steps: it resists strain rates alone."""

import numpy as np
import pytest

import meshes
from shellform import Fabric, Shell
from shellform.dynamics.explicit import Newmark
from shellform.fem.internal_force import InternalForce
from tests.dynamics.test_explicit import sheet, totals, tumble


def test_free_fall_is_exact_and_undamped_by_stiffness_damping():
    shell = sheet(6)
    shell.loads.gravity((0.0, 0.0, -9.81))
    newmark = Newmark(shell, damping=1e-4)
    newmark.advance(0.1)
    drop = newmark.w[: newmark.n_owned, 2]
    assert drop == pytest.approx(-0.5 * 9.81 * 0.1**2, rel=1e-10)


def test_stiffness_damping_takes_energy_only_from_strain():
    shell = sheet(6)
    newmark = Newmark(shell, damping=2e-4)
    tumble(newmark)
    *_, k0, e0 = totals(newmark)
    p0, *_ = totals(newmark)
    newmark.advance(0.2)
    p, _, k, e = totals(newmark)
    assert k + e < 0.99999 * (k0 + e0)
    assert np.abs(p - p0).max() < 1e-12 * np.abs(p0).max()


@pytest.mark.parametrize("element", ["quads", "chords", "triangles", "9-node"])
def test_damping_resists_strain_rates_alone(element):
    """Symmetric, never giving energy, deaf to rigid motion, whatever stress there is."""
    options = {"triangles": element == "triangles", "degree": 2 if element == "9-node" else 1}
    surface = meshes.rectangle(1.0, 0.7, (3, 2), **options)
    chords = {"membrane": "chords"} if element == "chords" else {}
    shell = Shell(surface, Fabric.isotropic(1e6, 0.3, 1e-2, 1000.0), **chords)
    rng = np.random.default_rng(3)
    field = rng.standard_normal((len(surface.points), 12))
    w = shell.w.x.array.reshape(-1, 6)
    w += np.array([0.02] * 3 + [0.3] * 3) * field[shell.partition.nodes, :6]
    w[:, 3:] /= np.linalg.norm(w[:, 3:], axis=1, keepdims=True)
    x = surface.points[shell.partition.nodes] + w[:, :3]
    n, total = shell.partition.n_owned, shell.comm.allreduce
    plain, damped = InternalForce(shell), InternalForce(shell, damped=True)
    still = plain(w)[:n].copy()
    size = np.sqrt(total(np.sum(still**2)))

    def viscous(rates):
        return damped(w, 0.0, w + rates)[:n] - still

    np.testing.assert_allclose(damped(w)[:n], still, atol=1e-13 * size)
    spin, shift = np.array([0.1, -0.2, 0.3]), np.array([0.3, 0.1, -0.2])
    rigid = np.hstack([np.cross(spin, x) + shift, np.cross(spin, w[:, 3:])])
    assert np.abs(viscous(rigid)).max(initial=0.0) < 1e-12 * size
    one = field[shell.partition.nodes, 6:]
    two = field[shell.partition.nodes, 5::-1].copy()
    first = viscous(one)
    power = total(np.vdot(first, one[:n]))
    assert power > 0
    assert total(damped.loss) == pytest.approx(power, rel=1e-9)
    assert total(np.vdot(viscous(two), one[:n])) == pytest.approx(
        total(np.vdot(first, two[:n])), abs=1e-9 * power
    )
    np.testing.assert_allclose(viscous(2 * one), 2 * first, atol=1e-9 * size)


def test_damping_does_not_feed_a_buckling_sheet():
    """Pressed flat, a sheet gives energy to a bulge; damping must not take that for resistance."""
    shell = sheet(12)
    w = shell.w.x.array.reshape(-1, 6)
    x = shell.surface.points[shell.partition.nodes]
    w[:, 0] = -0.1 * x[:, 0]
    bulge = np.zeros_like(w)
    bulge[:, 2] = 1e-4 * np.sin(2 * np.pi * x[:, 0])
    bulge[:, 3] = -1e-4 * 2 * np.pi * np.cos(2 * np.pi * x[:, 0])
    n, total = shell.partition.n_owned, shell.comm.allreduce
    plain, damped = InternalForce(shell), InternalForce(shell, damped=True)
    still = plain(w)[:n].copy()
    moved = plain(w + bulge)[:n] - still
    viscous = damped(w, 0.0, w + bulge)[:n] - still
    assert total(np.vdot(moved, bulge[:n])) < 0
    assert total(np.vdot(viscous, bulge[:n])) > 0
