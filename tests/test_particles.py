# SPDX-License-Identifier: LGPL-3.0-or-later
"""The particle model against its continuum, conservation laws and the buckled column."""

import numpy as np
import pytest

import meshes
import shellform.shell
from shellform import Fabric, Shell
from shellform.newmark import Newmark
from shellform.particles import Particles, hand_over
from shellform.springs import buckling_force

pytestmark = pytest.mark.serial
CLOTH = {"youngs_modulus": 1e6, "poisson_ratio": 0.3, "thickness": 1e-3, "density": 200.0}


def sheet(cells=6):
    return Shell(meshes.rectangle(1.0, 1.0, (cells, cells)), Fabric.isotropic(**CLOTH))


@pytest.fixture
def no_forms(monkeypatch):
    def refuse(*args, **options):
        raise AssertionError("a form was compiled")

    monkeypatch.setattr(shellform.shell, "compiled", refuse)


@pytest.mark.parametrize("bending", ["flexion", "buckling", "none"])
def test_stretch_and_shear_have_the_fabrics_energy(bending, no_forms):
    shell = sheet()
    p = Particles(shell, bending=bending)
    A, X, e = shell.fabric.membrane, p.points, 1e-5
    strains = {0: (e * X[:, 0], 0), 1: (0, e * X[:, 1]), 2: (e * X[:, 1], 0)}
    for k, (u, v) in strains.items():
        p.owned[:, 0], p.owned[:, 1] = u, v
        energy = sum(p.shell.energy().values())
        assert energy == pytest.approx(0.5 * A[k, k] * e * e, rel=1e-4)
    p.owned[:, 0], p.owned[:, 1] = e * X[:, 0], e * X[:, 1]
    both = 0.5 * (A[0, 0] + A[1, 1] + 2 * A[2, 2]) * e * e  # C12 is G t
    assert sum(p.shell.energy().values()) == pytest.approx(both, rel=1e-4)


def test_column_force_is_the_slope_of_its_energy():
    for length in (0.3, 0.7, 0.95, 0.999):
        h = 1e-6
        slope = buckling_force(length + h, 1.0, 2.0)[1] - buckling_force(length - h, 1.0, 2.0)[1]
        assert buckling_force(length, 1.0, 2.0)[0] == pytest.approx(slope / (2 * h), rel=1e-6)
    assert buckling_force(1 - 1e-9, 1.0, 2.0)[0] == pytest.approx(-24.0, rel=1e-6)


@pytest.mark.parametrize("bending", ["flexion", "buckling"])
def test_free_flight(bending, no_forms):
    p = Particles(sheet(), 0.5, damping=1e-4, bending=bending)
    p.v[:] = np.cross([1, 2, 3], p.points) + [0.3, 0.2, 0.1] + 0.05 * np.sin(7 * p.points[:, ::-1])
    a, j, *_ = p.momenta()
    p.advance(1000 * p.dt)
    b, k, *_ = p.momenta()
    assert np.abs(b - a).max() < 1e-12 and np.abs(k - j).max() < 1e-12


def test_free_fall():
    shell = sheet()
    shell.loads.gravity((0, 0, -9.81))
    p = Particles(shell, damping=1e-4)
    p.advance(0.1)
    assert p.owned[:, 2] == pytest.approx(-0.5 * 9.81 * 0.01, rel=1e-10)


def test_strain_limit():
    p = Particles(sheet(), 0.5, strain_limit=0.1)
    p.v[:] = 20 * (p.points - [0.5, 0.5, 0])
    a = p.mass @ p.v
    for _ in range(200):
        p.step(p.dt)
        x, s = p.points + p.owned[:, :3], p.internal
        pairs = s.pairs[: s.limited]
        length = np.linalg.norm(x[pairs[:, 1]] - x[pairs[:, 0]], axis=1)
        assert (length / s.rest[: s.limited]).max() < 1.1 + 0.02
    assert np.abs(p.mass @ p.v - a).max() < 1e-12


def test_more_ranks_are_refused():
    shell = sheet(2)
    shell.comm = type("Comm", (), {"size": 2})()
    with pytest.raises(ValueError, match="one rank"):
        Particles(shell)


def test_hand_over_keeps_momentum():
    shell = sheet(4)
    p = Particles(shell)
    p.v[:] = np.cross([1, 2, 3], p.points) + [0, 0, 1]
    p.advance(0.02)
    newmark = Newmark(shell)
    hand_over(p, newmark)
    assert newmark.momenta()[0] == pytest.approx(p.momenta()[0], abs=1e-13)
    newmark.advance(0.04)
    assert np.isfinite(newmark.owned).all()


def test_rests_on_a_sphere_with_its_weight(no_forms):
    from contact.body import Body, Fixed, Segment
    from shellform.ledger import Ledger
    from shellform.touch import Touch

    surface = meshes.rectangle(0.5, 0.5, (10, 10)).transform(translation=(-0.25, -0.25, 2e-3))
    shell = Shell(surface, Fabric.isotropic(**CLOTH))
    shell.loads.gravity((0, 0, -9.81))
    p = Particles(shell, 0.8, damping=1e-3, drag=8.0)
    touch = Touch(p, Body([Segment("limb", [0.25] * 3, Fixed((0.0, 0.0, -0.25)))]), 0.3)
    ledger = Ledger(None, p, touch)
    p.advance(2.0)
    ledger.record()
    p.advance(2.4)
    row, weight = ledger.record(), 0.2 * 0.25 * 9.81
    assert [row[f"force_limb_{a}"] for a in "xyz"] == pytest.approx(
        [0, 0, weight], abs=1e-3 * weight
    )
    assert row["momentum_residual"] < 1e-10 * weight
