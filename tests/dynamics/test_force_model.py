# SPDX-License-Identifier: LGPL-3.0-or-later
"""A force model of the test's own under the stepper: what pushes nodes is a seam."""

import numpy as np
import pytest

import meshes
from shellform import Fabric, Shell
from shellform.dynamics.explicit import Newmark
from shellform.dynamics.stable_step import SPARE
from shellform.results.ledger import Ledger

K = 400.0  # [1/s^2], of the ground for every kg


class Ground:
    """Every node on a spring to where it was at rest, with a damper of its own."""

    turns_directors = False
    friction = None

    def __init__(self, mass, comm, damping=0.0):
        self.mass, self.comm, self.damping = mass[:, None], comm, damping
        self.r, self.viscous = np.zeros((len(mass), 6)), np.zeros((len(mass), 3))

    def force(self, w, v, q, time):
        self.viscous[:] = self.damping * K * self.mass * v
        self.r[:, :3] = K * self.mass * w[: len(v), :3] + self.viscous
        return self.r

    def freeze(self, w):
        return None

    def elastic(self, w, frozen):
        self.r[:, :3] = K * self.mass * w[: len(self.mass), :3]
        return self.r

    def energy(self, w):
        stored = 0.5 * K * np.sum(self.mass * w[: len(self.mass), :3] ** 2)
        return {"ground": self.comm.allreduce(stored)}

    def damping_loss(self, v_old, v, dt, last):
        return 0.5 * dt * np.vdot(self.viscous, v_old + v)

    def describe(self):
        return {"terms": ["ground"]}


@pytest.fixture
def shell(monkeypatch):
    """A sheet whose own forms must not be compiled."""

    def refuse(*_):
        raise AssertionError("the shell's own force is not asked for")

    monkeypatch.setattr("shellform.dynamics.explicit.ShellForce", refuse)
    return Shell(meshes.rectangle(1.0, 1.0, (4, 4)), Fabric.isotropic(1e5, 0.3, 1e-3, 200.0))


def on_ground(shell, damping=0.0, **options):
    mass = shell.fabric.areal_mass * nodal(shell)
    model = Ground(mass, shell.comm, damping)
    stepper = Newmark(shell, damping=damping, force_model=model, **options)
    assert mass == pytest.approx(stepper.mass, rel=1e-12)
    return stepper


def nodal(shell):
    """Areas of this rank's nodes [m^2] of the square of 4 x 4 cells."""
    x = shell.surface.points[shell.partition.owned_nodes, :2]
    inside = np.where((x > 1e-9) & (x < 1 - 1e-9), 1.0, 0.5)
    return inside.prod(axis=1) / 16


def test_frequency_is_exact(shell):
    """u_n = v dt sin(n theta)/sin(theta), sin(theta/2) = omega dt/2; the stable step is 2/omega."""
    stepper = on_ground(shell, time_step_factor=0.4)
    assert stepper.critical_dt == pytest.approx(SPARE * 2 / np.sqrt(K), rel=1e-6)
    stepper.v[:] = [0.3, 0.0, -0.1]
    dt = 0.02
    theta = 2 * np.arcsin(0.5 * np.sqrt(K) * dt)
    kept = []
    for n in range(1, 60):
        stepper.step(dt)
        way = dt * np.sin(n * theta) / np.sin(theta)
        exact = np.tile([0.3 * way, 0.0, -0.1 * way], (stepper.n_owned, 1))
        np.testing.assert_allclose(stepper.owned[:, :3], exact, atol=1e-13)
        now = stepper.balance()
        kept.append(now["kinetic"] + (1 - K * dt**2 / 4) * now["strain"])
    np.testing.assert_allclose(kept, 0.5 * 0.2 * (0.3**2 + 0.1**2), rtol=1e-12)
    # directors are not moved, and do not count
    assert np.array_equal(stepper.owned[:, 3:], np.tile([0.0, 0.0, 1.0], (stepper.n_owned, 1)))
    assert stepper.describe() == {"terms": ["ground", "inertia"]}


def test_damping_and_loads_are_booked(shell):
    """Kinetic and stored energy, what the damper takes and the weight gives add up with the step.

    At first order, as the damper acts with the velocity at the start of a kick.
    """
    shell.loads.gravity((0.0, 0.0, -9.81))
    errors = []
    for part in (0.04, 0.02):
        stepper = on_ground(shell, damping=0.02, time_step_factor=part)
        shell.w.x.array.reshape(-1, 6)[:, :3] = 0.0
        ledger = stepper.add(Ledger())
        stepper.advance(0.2)
        row = ledger.record()
        errors.append(abs(row["energy_residual"]) / row["external_work"])
        assert row["damping_loss"] > 0.05 * row["external_work"] > 0
    assert errors[1] < errors[0] < 0.05
