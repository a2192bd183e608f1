# SPDX-License-Identifier: LGPL-3.0-or-later
"""Explicit Newmark steps against conservation laws, exact frequencies and orders of convergence."""

from fractions import Fraction

import numpy as np
import pytest

import meshes
from shellform import Fabric, Shell
from shellform.dynamics.books import new_books
from shellform.dynamics.explicit import Newmark
from shellform.dynamics.explicit_kernels import NODE, Forces, book
from shellform.dynamics.part import AppliedForce
from shellform.errors import Unstable

CLOTH = {"youngs_modulus": 1e6, "poisson_ratio": 0.3, "thickness": 1e-3, "density": 200.0}


def sheet(cells=8, degree=1, triangles=False, size=1.0, amount=0.1):
    surface = meshes.rectangle(
        size, size, (cells, cells), degree=degree, triangles=triangles,
        parameters=meshes.distorted((cells, cells), amount, seed=3), warp=(1.0, 0.0, 0.0),
    )  # fmt: skip
    return Shell(surface, Fabric.isotropic(**CLOTH))


def tumble(newmark):
    """Start a spin, a flight and a smooth deformation, the same on any number of ranks."""
    X = newmark.points - [0.5, 0.5, 0.0]
    spin = np.array([1.0, 2.0, 3.0])
    newmark.v[:] = np.cross(spin, X) + [0.3, 0.2, 0.1] + 0.05 * np.sin(7 * X[:, [1, 2, 0]])
    newmark.q[:] = np.cross(spin, newmark.w[: newmark.n_owned, 3:])


def totals(newmark):
    """Momentum (3,), angular momentum (3,), kinetic and strain energy at the present time."""
    return *newmark.momenta(), sum(newmark.shell.energy().values())


FABRICS = {
    "isotropic": Fabric.isotropic(**CLOTH),
    "woven": Fabric.orthotropic(2e7, 5e6, 0.1, 2e5, 2e5, 2e5, 5e-4, 400.0),
    "thick": Fabric.isotropic(1e7, 0.2, 0.02, 1000.0),
}

ELEMENTS = {"quad": (1, False), "triangle": (1, True), "nine nodes": (2, False)}


@pytest.mark.parametrize("element", ELEMENTS)
def test_free_flight_conserves_momentum_and_energy(element):
    """1000 steps at half the stable step, no damping."""
    newmark = Newmark(sheet(8, *ELEMENTS[element]), time_step_factor=0.5)
    tumble(newmark)
    p0, j0, k0, e0 = totals(newmark)
    energies = []
    for _ in range(20):
        newmark.advance(newmark.time + 50 * newmark.dt)
        p, j, k, e = totals(newmark)
        assert np.abs(p - p0).max() < 1e-12 * np.abs(p0).max()
        assert np.abs(j - j0).max() < 1e-12 * np.abs(j0).max()
        energies.append((k + e) / (k0 + e0) - 1)
    assert newmark.steps >= 1000
    assert e > 1e-6 * k  # it does deform
    # bounded, and the mean of the second half is that of the first: no drift
    assert np.abs(energies).max() < 1e-4
    assert abs(np.mean(energies[10:]) - np.mean(energies[:10])) < 1e-4


def test_momentum_balance_under_gravity():
    """Momentum grows by weight times time to roundoff; drag and damping off."""
    shell = sheet(6)
    shell.loads.gravity((0.0, 0.0, -9.81))
    newmark = Newmark(shell)
    newmark.advance(0.05)
    p, *_ = totals(newmark)
    weight = shell.fabric.areal_mass * 9.81
    assert p == pytest.approx([0, 0, -weight * 0.05], abs=1e-12 * weight)


def test_impulses_are_booked_to_the_last_digits():
    """What is booked over many steps is off by half a digit a step, however many nodes there are.

    Node by node the same rounding repeats: off by 1.8e-11 here, and growing with nodes and steps.
    """
    n, steps, force, dt = 500, 2000, np.full((500, 3), 1.962 / 625), 1.72e-4
    v, impulse, books = np.zeros((n, 3)), 3.0 * force, new_books()
    nodes = np.zeros(n, NODE)
    forces = Forces(np.zeros((n, 6)), force, impulse)
    for _ in range(steps):
        book(v, v, v, *forces, nodes, 0.0, dt, *books)
    for found, one in (
        (books.impulses[0, 0], force[0, 0] * dt),
        (books.impulses[1, 0], impulse[0, 0]),
    ):
        exact = n * steps * Fraction(one)
        worst = 0.5 * np.finfo(float).eps * (n + steps)
        assert abs(Fraction(found) - exact) <= worst * exact


def test_pressure_and_moment_act_in_full():
    """Without amplitude loads stand at their full value: p A and the moments are the rates."""
    shell = sheet(4)
    shell.loads.pressure(10.0)
    shell.loads.edge_moment("right", (0.0, 3e-3, 0.0))
    newmark = Newmark(shell)
    newmark.advance(0.01)
    p, j, _ = newmark.momenta()
    assert p == pytest.approx([0, 0, 10.0 * 0.01], rel=2e-3, abs=1e-4)
    turned = 10.0 * 0.01 * np.array([0.5, -0.5, 0.0]) + [0.0, 3e-3 * 0.01, 0.0]
    assert j == pytest.approx(turned, abs=2e-5 * 10)


def test_prescribed_motion_is_followed():
    """An edge on a circle, its director turned at a rate: there at every output time."""
    shell = sheet(4)

    def place(t):
        return np.array([0.02 * np.sin(40 * t), 0.0, 0.02 * (1 - np.cos(40 * t))])

    def facing(t):
        return np.array([np.sin(5 * t), 0.0, np.cos(5 * t)])

    shell.supports.clamp("left")
    shell.supports.move("left", place, facing)
    newmark = Newmark(shell)
    edge = shell.partition.find("left")
    for k in range(1, 6):
        newmark.advance(0.01 * k)
        assert np.abs(shell.displacements()[edge] - place(newmark.time)).max() < 1e-12
        assert np.abs(shell.directors()[edge] - facing(newmark.time)).max() < 1e-12
    # what the edge gave is what the sheet has
    p = shell.comm.allreduce(newmark.mass @ newmark.v)
    given = shell.comm.allreduce(newmark.support_total)
    assert p == pytest.approx(given, abs=1e-13)


@pytest.mark.parametrize(
    "wrong", [{"time_step_factor": 1.5}, {"damping": -1e-4}, {"drag": float("nan")}]
)
def test_wrong_settings_are_refused(wrong):
    with pytest.raises(ValueError, match="not "):
        Newmark(sheet(2), **wrong)


def test_an_exploding_step_is_told_with_its_node():
    newmark = Newmark(sheet(4))
    newmark.dt, newmark.recheck = 1.5 * newmark.critical_dt, 10**9
    newmark.rewind.retries = 0
    newmark.v[:, 2] = 1e-6 * (-1.0) ** newmark.shell.partition.owned_nodes
    with pytest.raises(Unstable, match=r"node \d+ of rectangle has left the finite numbers at t ="):
        newmark.advance(5000 * newmark.dt)


def test_a_displacement_without_time_is_refused():
    shell = sheet(2)
    shell.supports.move("left", (0.0, 0.0, 0.1))
    with pytest.raises(ValueError, match="function of time"):
        Newmark(shell)


def test_amplitude_is_a_function_of_time():
    shell = sheet(4)
    shell.loads.gravity((0.0, 0.0, -9.81), amplitude=lambda t: 2.0 * t)
    newmark = Newmark(shell)
    newmark.advance(0.05)
    p, *_ = newmark.momenta()
    assert p[2] == pytest.approx(-shell.fabric.areal_mass * 9.81 * 0.05**2, rel=1e-12)


@pytest.mark.parametrize("amplitude", [None, lambda t: 1.0 + t])
def test_an_applied_force_is_external(amplitude):
    """Springs to the ground under gravity: momentum and work are booked, and end."""
    shell = sheet(4)
    shell.loads.gravity((0.0, 0.0, -9.81), amplitude=amplitude)
    newmark = Newmark(shell, 0.5)
    comm, k = shell.comm, 40.0

    class Springs(AppliedForce):
        def add_force(self, stepper, force):
            force -= k * stepper.mass[:, None] * stepper.owned[:, :3]

    springs = newmark.add(Springs())
    newmark.v[:, 0] = 0.3
    start = comm.allreduce(newmark.mass @ newmark.v)
    kinetic = newmark.momenta()[2]
    newmark.advance(0.1)
    given = comm.allreduce(newmark.external_total)
    assert comm.allreduce(newmark.mass @ newmark.v) - start == pytest.approx(given, abs=1e-14)
    # a rigid oscillator about the ground
    root, u = np.sqrt(k), newmark.owned
    assert u[:, 0] == pytest.approx(0.3 / root * np.sin(0.1 * root), rel=1e-4)
    stored = comm.allreduce(0.5 * k * np.sum(newmark.mass * (u[:, :3] ** 2).sum(axis=1)))
    if amplitude is None:
        fallen = comm.allreduce(-9.81 * np.sum(newmark.mass * u[:, 2]))
        work = fallen - stored
        assert newmark.momenta()[2] - kinetic == pytest.approx(work, rel=1e-3)
        half = (
            0.5 * newmark.clock.last_dt * comm.allreduce(np.vdot(newmark.external.force, newmark.v))
        )
        assert comm.allreduce(newmark.work["external"]) + half == pytest.approx(work, rel=1e-3)
    newmark.remove(springs)
    before = comm.allreduce(newmark.mass @ newmark.v)
    newmark.advance(0.15)
    weight = shell.fabric.areal_mass * 9.81
    growth = 0.05 if amplitude is None else 0.05 * 1.125
    change = comm.allreduce(newmark.mass @ newmark.v) - before
    assert change[0] == pytest.approx(0.0, abs=1e-14)
    assert change[2] == pytest.approx(-weight * growth, rel=0.02)
