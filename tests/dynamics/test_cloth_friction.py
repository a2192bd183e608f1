# SPDX-License-Identifier: LGPL-3.0-or-later
"""Friction inside the cloth in explicit and implicit steps: books, checkpoints, cut-backs."""

import numpy as np
import pytest

import meshes
from shellform import Fabric, Shell
from shellform.dynamics import checkpoint
from shellform.dynamics.explicit import Newmark
from shellform.dynamics.implicit import ImplicitNewmark
from shellform.dynamics.state import State
from shellform.fem.lumped_mass import ROTARY_SCALE
from shellform.material.friction import ClothFriction
from shellform.material.measurements import measured_fabric
from shellform.results.ledger import Ledger
from tests.material.test_measurements import SUITING

FRICTION = ClothFriction(
    shear=[(60.0, 0.5, 8.5)], bend_warp=[(6e-5, 3e-4)], bend_weft=[(5e-5, 2.4e-4), (1e-5, 2e-4)]
)


def cloth(friction=FRICTION):
    return Fabric.from_stiffness(
        np.diag([200.0, 150.0, 50.0]), np.diag([1.3e-5, 1e-5, 6e-6]), 0.2, 5e-4
    ).with_friction(friction)


def flag(friction=FRICTION, triangles=False, cells=(6, 4)):
    """A sheet held at one edge, falling."""
    surface = meshes.rectangle(0.3, 0.2, cells, triangles=triangles).replace(warp=(1.0, 0.4, 0.0))
    shell = Shell(surface, cloth(friction))
    shell.supports.clamp("left")
    shell.loads.gravity()
    return shell


@pytest.mark.parametrize("triangles", [False, True])
def test_books_close(triangles):
    """What sliders lose is in the ledger; the residual is an error of the steps."""
    residuals, losses = [], []
    for factor in (0.8, 0.4):
        stepper = Newmark(flag(triangles=triangles), factor)
        ledger = stepper.add(Ledger())
        stepper.advance(0.2)
        row = ledger.record()
        losses.append(row["hysteresis_loss"])
        residuals.append(abs(row["energy_residual"]))
        assert row["momentum_residual"] < 1e-13
    assert losses[1] == pytest.approx(losses[0], rel=0.02) and losses[0] > 1e-5
    assert residuals[0] < 1e-2 * losses[0] and residuals[1] < 0.5 * residuals[0] + 1e-6 * losses[0]


def test_measured_cloth_falls():
    """A card with curves, loops and sliders of all strains: no cut-back step, books that close."""
    surface = meshes.rectangle(0.4, 0.4, (8, 8), warp=(1.0, 0.2, 0.0))
    shell = Shell(surface, measured_fabric(SUITING | {"RT_warp_percent": 60.0}))
    shell.supports.hold(np.array([0]))
    shell.loads.gravity()
    stepper = Newmark(shell)
    ledger = stepper.add(Ledger())
    stepper.advance(0.3)
    row = ledger.record()
    assert stepper.rewind.cutbacks == 0
    assert abs(row["energy_residual"]) < 0.01 * row["hysteresis_loss"]
    assert row["hysteresis_loss"] > 0.1 * row["strain"] > 0


def test_friction_takes_energy():
    """The same fall without it: no such column, more motion at the bottom of the swing."""
    kinetic = []
    for friction in (FRICTION, None):
        stepper = Newmark(flag(friction))
        ledger = stepper.add(Ledger())
        stepper.advance(0.2)
        row = ledger.record()
        kinetic.append(row["kinetic"] + row["strain"])
    assert kinetic[0] < kinetic[1]
    assert "hysteresis_loss" not in row and "hysteresis" not in stepper.balance()


@pytest.mark.slow
def test_implicit_steps_follow_explicit_ones():
    explicit = Newmark(flag(), 0.5)
    explicit.advance(0.15)
    wanted, loss = explicit.shell.displacements(), explicit.shell.friction_loss()
    errors, losses = [], []
    for dt in (4e-3, 2e-3):
        shell = flag()
        stepper = ImplicitNewmark(shell, dt, rotary_scale=ROTARY_SCALE)
        ledger = stepper.add(Ledger())
        stepper.advance(0.15)
        row = ledger.record()
        losses.append(row["hysteresis_loss"])
        errors.append(np.abs(shell.displacements() - wanted).max())
        stepper.destroy()
    assert losses[1] == pytest.approx(loss, rel=0.02)
    assert abs(losses[1] - loss) < abs(losses[0] - loss)
    assert errors[1] < 0.01 * np.abs(wanted).max()


def test_goes_on_bit_for_bit(shared_tmp_path, comm):
    first = Newmark(flag())
    for _ in range(150):
        first.step(first.dt)
    checkpoint.save(shared_tmp_path / "c.npz", first)
    comm.Barrier()
    second = Newmark(flag())
    checkpoint.load(shared_tmp_path / "c.npz", second)
    for stepper in (first, second):
        for _ in range(150):
            stepper.step(stepper.dt)
    assert np.array_equal(first.owned, second.owned)
    assert np.array_equal(first.shell.cell_stress.slips, second.shell.cell_stress.slips)
    assert second.shell.friction_loss() == pytest.approx(first.shell.friction_loss(), rel=1e-12)
    other = Newmark(flag(ClothFriction(shear=[(60.0, 0.5)])))
    with pytest.raises(ValueError, match="holds no state of this cloth's friction"):
        checkpoint.load(shared_tmp_path / "c.npz", other)


def test_cut_back_steps_bring_slips_back():
    stepper = Newmark(flag())
    stepper.advance(0.05)
    state, slips = State(stepper).keep(), stepper.shell.cell_stress.slips
    loss = stepper.shell.friction_loss()
    for _ in range(200):
        stepper.step(stepper.dt)
    assert not np.array_equal(stepper.shell.cell_stress.slips, slips) or not slips.size
    state.restore()
    assert np.array_equal(stepper.shell.cell_stress.slips, slips)
    assert stepper.shell.friction_loss() == pytest.approx(loss, rel=1e-12)
