# SPDX-License-Identifier: LGPL-3.0-or-later
"""The particle model against its continuum, conservation laws and the buckled column."""

import numpy as np
import pytest

import meshes
import shellform.fem.shell
from shellform import Fabric, Shell
from shellform.dynamics.explicit import Newmark
from shellform.dynamics.mass_spring import Particles, hand_over
from shellform.dynamics.spring_kernels import buckling_force

pytestmark = pytest.mark.serial
CLOTH = {"youngs_modulus": 1e6, "poisson_ratio": 0.3, "thickness": 1e-3, "density": 200.0}


def sheet(cells=6):
    return Shell(meshes.rectangle(1.0, 1.0, (cells, cells)), Fabric.isotropic(**CLOTH))


@pytest.fixture
def no_forms(monkeypatch):
    def refuse(*args, **options):
        raise AssertionError("a form was compiled")

    monkeypatch.setattr(shellform.fem.shell, "compiled", refuse)


@pytest.mark.parametrize("bending", ["flexion", "buckling", "none"])
def test_stretch_and_shear_have_the_fabrics_energy(bending, no_forms):
    shell = sheet()
    p = Particles(shell, bending=bending)
    A, X, e = shell.fabric.membrane, p.points, 1e-5
    strains = {0: (e * X[:, 0], 0), 1: (0, e * X[:, 1]), 2: (e * X[:, 1], 0)}
    for k, (u, v) in strains.items():
        p.owned[:, 0], p.owned[:, 1] = u, v
        energy = sum(p.strain_energy().values())
        assert energy == pytest.approx(0.5 * A[k, k] * e * e, rel=1e-4)
    p.owned[:, 0], p.owned[:, 1] = e * X[:, 0], e * X[:, 1]
    both = 0.5 * (A[0, 0] + A[1, 1] + 2 * A[2, 2]) * e * e  # C12 is G t
    assert sum(p.strain_energy().values()) == pytest.approx(both, rel=1e-4)


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
    assert sum(p.strain_energy().values()) > 1e-6  # it does deform
    assert np.abs(b - a).max() < 1e-12 and np.abs(k - j).max() < 1e-12


def test_free_fall():
    shell = sheet()
    shell.loads.gravity((0, 0, -9.81))
    p = Particles(shell, damping=1e-4)
    p.advance(0.1)
    assert p.owned[:, 2] == pytest.approx(-0.5 * 9.81 * 0.01, rel=1e-10)


def test_strain_limit():
    """Kept to its slack in a throw that would stretch the sheet far beyond, momentum too."""
    most = {}
    for bound in (None, 0.1):
        p = Particles(sheet(), 0.5, strain_limit=bound)
        p.v[:] = 60 * (p.points - [0.5, 0.5, 0])
        a, most[bound] = p.mass @ p.v, 0.0
        for _ in range(200):
            p.step(p.dt)
            x, s = p.points + p.owned[:, :3], p.force_model
            pairs = s.table["ends"][: s.limited]
            length = np.linalg.norm(x[pairs[:, 1]] - x[pairs[:, 0]], axis=1)
            most[bound] = max(most[bound], (length / s.table["rest"][: s.limited]).max())
        assert np.abs(p.mass @ p.v - a).max() < 1e-12
    assert most[0.1] < 1.1 + 0.02
    assert most[None] > 1.2


@pytest.mark.parametrize("bending", ["none", "buckling"])
def test_second_order_in_time(bending, no_forms):
    """A swinging two-cell pendulum of springs against its own equations solved to 1e-10."""
    from scipy.integrate import solve_ivp

    def pendulum():
        shell = Shell(meshes.rectangle(0.2, 0.1, (2, 1)), Fabric.isotropic(1e4, 0.3, 1e-3, 200.0))
        shell.supports.hold("left")
        shell.loads.gravity((0, 0, -9.81))
        p = Particles(shell, bending=bending)
        p.v[:, 2] = -2 * p.points[:, 0]
        p.v[p.held[:, 0]] = 0.0
        return p

    p, end = pendulum(), 0.2
    free, n = ~p.held[:, :3], p.n_owned
    w, weight = p.w.copy(), p.external.force.copy()

    def rate(_, y):
        u, v = y.reshape(2, n, 3)
        w[:, :3] = u
        return np.concatenate(
            [v, free * (weight - p.force_model.force(w, v, v, 0.0)[:, :3]) / p.mass[:, None]]
        ).ravel()

    start = np.concatenate([np.zeros((n, 3)), p.v]).ravel()
    exact = solve_ivp(rate, (0, end), start, rtol=1e-11, atol=1e-13, method="DOP853").y[:, -1]
    exact = exact.reshape(2, n, 3)[0]
    errors, count = [], int(np.ceil(end / (0.3 * p.critical_dt)))
    for steps in (count, 2 * count, 4 * count):
        p = pendulum()
        p.dt, p.recheck = end / steps, 10**9
        p.advance(end)
        assert p.steps == steps
        errors.append(np.abs(p.owned[:, :3] - exact).max())
    assert np.abs(exact).max() > 0.1  # it swings far
    assert np.log2(errors[1] / errors[2]) == pytest.approx(2.0, abs=0.1)


def test_damping_loss_is_exact(no_forms):
    """What damping takes, spring by spring, is missing in the energy: second order is left over."""
    from shellform.results.ledger import Ledger

    errors = []
    for factor in (0.4, 0.2):
        p = Particles(sheet(), factor, damping=2e-4, bending="none")
        p.v[:] = 3 * np.sin(7 * p.points[:, ::-1])
        p.recheck = 10**9
        ledger, rows = p.add(Ledger()), []
        for k in range(1, 11):
            p.advance(0.004 * k)
            rows.append(ledger.record())
        errors.append(np.sqrt(np.mean([row["energy_residual"] ** 2 for row in rows])))
    assert rows[-1]["damping_loss"] > 20 * errors[0]
    assert np.log2(errors[0] / errors[1]) > 1.7


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
    from contact.body.segments import Body, Fixed, Segment
    from shellform.contact_coupling.contact import Contact
    from shellform.results.ledger import Ledger

    surface = meshes.rectangle(0.5, 0.5, (10, 10)).transform(translation=(-0.25, -0.25, 2e-3))
    shell = Shell(surface, Fabric.isotropic(**CLOTH))
    shell.loads.gravity((0, 0, -9.81))
    p = Particles(shell, 0.8, damping=1e-3, drag=8.0)
    p.add(Contact(Body([Segment("limb", [0.25] * 3, Fixed((0.0, 0.0, -0.25)))]), 0.3))
    ledger = p.add(Ledger())
    p.advance(2.0)
    ledger.record()
    p.advance(2.4)
    row, weight = ledger.record(), 0.2 * 0.25 * 9.81
    assert row["active"] > 3
    assert [row[f"force_limb_{a}"] for a in "xyz"] == pytest.approx(
        [0, 0, weight], abs=1e-3 * weight
    )
    assert row["momentum_residual"] < 1e-10 * weight


def test_a_drape_goes_on_as_a_shell():
    """Particles fall onto a sphere, the shell goes on: momentum kept, its weight on the sphere."""
    from contact.body.segments import Body, Fixed, Segment
    from shellform.contact_coupling.contact import Contact
    from shellform.results.ledger import Ledger

    surface = meshes.rectangle(0.5, 0.5, (8, 8)).transform(translation=(-0.25, -0.25, 2e-3))
    shell = Shell(surface, Fabric.isotropic(**CLOTH))
    shell.loads.gravity((0, 0, -9.81))
    body = Body([Segment("limb", [0.25] * 3, Fixed((0.0, 0.0, -0.25)))])
    p = Particles(shell, 0.8, damping=1e-3, drag=8.0)
    first = p.add(Contact(body, 0.3))
    p.advance(0.15)
    while first.correction.active < 2:
        p.advance(p.time + p.dt)
    assert p.momenta()[2] > 1e-5  # it still moves
    momentum, inside = p.momenta()[0], first.correction.segment.copy()
    newmark = Newmark(shell, 0.8, damping=1e-3, drag=8.0)
    touch = newmark.add(Contact(body, 0.3))
    hand_over(p, newmark)
    assert newmark.time == p.time
    assert np.array_equal(touch.correction.segment, inside)
    assert newmark.momenta()[0] == pytest.approx(momentum, abs=2e-3 * np.linalg.norm(momentum))
    ledger = newmark.add(Ledger())
    newmark.advance(2.2)
    ledger.record()
    newmark.advance(2.6)
    row, weight = ledger.record(), 0.2 * 0.25 * 9.81
    force = [row[f"force_limb_{a}"] for a in "xyz"]
    assert force == pytest.approx([0, 0, weight], abs=1e-3 * weight)
    assert newmark.rewind.cutbacks == 0
