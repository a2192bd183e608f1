# SPDX-License-Identifier: LGPL-3.0-or-later
"""Explicit steps that diverge are cut back, books and contact with them; energy closes."""

from pathlib import Path

import numpy as np
import pytest

import meshes
from contact.body.segments import Body, Fixed, Segment
from shellform import Fabric, Shell
from shellform.contact_coupling.contact import Contact
from shellform.dynamics import checkpoint
from shellform.dynamics.explicit import Newmark
from shellform.dynamics.state import changing
from shellform.errors import Unstable
from shellform.results.ledger import Ledger
from tests.ranks import launch, needs_mpirun

CLOTH = {"youngs_modulus": 1e6, "poisson_ratio": 0.3, "thickness": 1e-3, "density": 200.0}
G = 9.81
LOSSES = ("drag", "damping", "friction", "impact")


def curtain(factor=0.3, pulled=None):
    """A sheet hung by one edge, swung by gravity; `pulled` drives its free edge in its plane."""
    shell = Shell(meshes.rectangle(0.5, 0.5, (6, 6)), Fabric.isotropic(**CLOTH))
    shell.supports.hold("left")
    shell.loads.gravity((0.0, 0.0, -G))
    if pulled:
        shell.supports.hold("right")
        shell.supports.move("right", pulled)
    return Newmark(shell, factor)


def drape(factor=0.8, **damping):
    """A square a little above a sphere."""
    surface = meshes.rectangle(0.5, 0.5, (8, 8)).transform(translation=(-0.24, -0.255, 1e-3))
    shell = Shell(surface, Fabric.isotropic(**CLOTH))
    shell.loads.gravity((0.0, 0.0, -G))
    stepper = Newmark(shell, factor, **damping)
    limb = Segment("limb", [0.25] * 3, Fixed((0.0, 0.0, -0.25)))
    return stepper, stepper.add(Contact(Body([limb]), 0.3))


def places(stepper):
    return stepper.shell.displacements()


def test_a_step_beyond_the_stable_one_is_cut_back():
    """Forced to 1.4 of the stable step, the swing ends where small steps bring it."""
    end = 0.12
    fine, finer, forced = curtain(0.6), curtain(0.3), curtain()
    fine.advance(end)
    finer.advance(end)
    forced.factor = 1.4
    forced.dt = 1.4 * forced.critical_dt
    forced.recheck = 100
    forced.advance(end)
    assert forced.rewind.cutbacks >= 1
    assert forced.time == end
    error = np.abs(places(forced) - places(finer)).max()
    of_steps = np.abs(places(fine) - places(finer)).max()
    assert np.abs(places(finer)).max() > 0.02  # it swings far
    assert error < 5 * of_steps + 1e-4


def test_a_sheet_that_stiffens_between_two_looks_is_cut_back():
    """Pulled to 1.6 of its length its stable step is less than the factor leaves room for."""

    def pulled(t):
        return np.array([0.3 * min(1.0, t / 0.02), 0.0, 0.0])

    ends = []
    for factor in (0.3, 0.9):
        stepper = curtain(factor, pulled)
        stepper.recheck = 2000 if factor > 0.5 else 100
        first = stepper.critical_dt
        stepper.advance(0.04)
        ends.append(places(stepper))
    assert stepper.find_stable_step() < 0.9 * first  # it did stiffen
    assert stepper.rewind.cutbacks >= 1
    assert np.abs(ends[1] - ends[0]).max() < 0.02 * np.abs(ends[0]).max()


def test_nothing_is_cut_back_without_need():
    """Impact, friction and ringing near the largest step are no divergence."""
    stepper, _ = drape(0.9)
    stepper.recheck = 50
    stepper.v[:, 2] = -3.0
    stepper.advance(0.3)
    assert stepper.rewind.cutbacks == 0
    assert stepper.rewind.cut == 1.0


def test_a_hopeless_case_keeps_the_last_good_state(shared_tmp_path, comm):
    """One node of one rank is lost again and again: all ranks stop, told what was tried."""
    stepper, _ = drape(damping=1e-4)
    stepper.recheck = 40

    def lose(stepper, dt):
        if stepper.time > 0.05 and 0 in stepper.shell.partition.owned_nodes:
            stepper.v[np.flatnonzero(stepper.shell.partition.owned_nodes == 0)] = np.nan

    stepper.add(lose)
    with pytest.raises(Unstable, match=r"node \d+ of rectangle .* with steps of .* is kept"):
        stepper.advance(1.0)
    assert stepper.rewind.cutbacks == stepper.rewind.retries
    assert 0.03 < stepper.time <= 0.05 + stepper.dt
    checkpoint.save(shared_tmp_path / "last.npz", stepper)
    comm.Barrier()
    again, _ = drape(damping=1e-4)
    checkpoint.load(shared_tmp_path / "last.npz", again)
    assert np.isfinite(again.w).all()
    assert again.time == stepper.time
    again.advance(0.1)
    assert np.isfinite(places(again)).all()


def test_books_and_contact_go_back_too(comm):
    """A rewound run has the state it went back to, and its momentum closes as if nothing was."""
    stepper, touch = drape(damping=1e-4, drag=0.5)
    ledger = stepper.add(Ledger())
    stepper.advance(0.12)
    stepper.rewind.begin(0)

    def everything():
        arrays = [*changing(stepper), touch.correction.window.table]
        arrays += [touch.correction.window.impulse, touch.correction.segment]
        return [np.array(a) for a in arrays], stepper.time, stepper.steps

    before, time, steps = everything()
    assert comm.allreduce(np.abs(before[-2]).sum()) > 0  # it touches
    for _ in range(30):
        stepper.step(stepper.dt)
    assert comm.allreduce(np.abs(everything()[0][0] - before[0]).sum()) > 0
    stepper.rewind.back(Unstable("as if"))
    after, again, count = everything()
    assert (again, count) == (time, steps)
    assert all(np.array_equal(a, b) for a, b in zip(after, before, strict=True))
    stepper.advance(0.2)
    weight = stepper.shell.fabric.areal_mass * 0.25 * G
    assert ledger.record()["momentum_residual"] < 1e-10 * weight


def test_the_step_recovers_slowly():
    stepper = curtain(0.8)
    stepper.recheck = 10
    stepper.rewind.begin(0)
    stepper.rewind.back(Unstable("as if"))
    half = stepper.dt
    assert half <= 0.5 * 0.8 * stepper.critical_dt * 1.0001
    parts = []
    for _ in range(30):
        stepper.advance(stepper.time + 10 * stepper.dt)
        parts.append(stepper.dt / (0.8 * stepper.critical_dt))
    assert max(np.diff(parts)) < 0.06
    assert parts[-1] == pytest.approx(1.0, rel=1e-9)


def thrown(factor, damping=0.0, drag=0.0):
    """A free sheet, spinning and bent."""
    shell = Shell(meshes.rectangle(0.5, 0.5, (8, 8)), Fabric.isotropic(**CLOTH))
    stepper = Newmark(shell, factor, damping=damping, drag=drag)
    X = stepper.points - [0.25, 0.25, 0.0]
    stepper.v[:] = np.cross([1.0, 2.0, 3.0], X) + [0.3, 0.2, 0.1]
    stepper.v[:, 2] += 2.0 * np.cos(2 * np.pi * stepper.points[:, 0])
    return stepper


@pytest.mark.parametrize("damping", [0.0, 1e-4])
def test_energy_residual_is_the_error_of_the_steps(damping):
    """Of second order in the step, with damping too, which the column of its own holds."""
    errors = []
    for factor in (0.4, 0.2):
        stepper = thrown(factor, damping, drag=0.5 if damping else 0.0)
        stepper.recheck = 10**9
        ledger = stepper.add(Ledger())
        rows = []
        for k in range(1, 21):
            stepper.advance(0.005 * k)
            rows.append(ledger.record())
        errors.append(np.sqrt(np.mean([row["energy_residual"] ** 2 for row in rows])))
    row, start = rows[-1], ledger.rows[0]
    total = rows[0]["kinetic"]
    assert rows[-1]["strain"] + rows[3]["strain"] > 1e-4 * total  # it does deform
    assert errors[0] < 2e-3 * total
    assert np.log2(errors[0] / errors[1]) > 1.7
    if damping:
        losses = [r["damping_loss"] for r in rows]
        assert row["damping_loss"] > 20 * errors[0]
        assert min(np.diff([0.0, *losses])) > -3 * errors[0]
    else:
        assert row["damping_loss"] == 0.0
    assert start["drag_loss"] == 0.0 or damping


def test_free_fall_has_no_energy_residual():
    """A uniform force moves all nodes alike: works are exact."""
    shell = Shell(meshes.rectangle(0.5, 0.5, (4, 4)), Fabric.isotropic(**CLOTH))
    shell.loads.gravity((0.0, 0.0, -G))
    stepper = Newmark(shell, drag=0.3)
    stepper.v[:] = [0.5, 0.0, 1.0]
    ledger = stepper.add(Ledger())
    stepper.advance(0.2)
    row = ledger.record()
    assert row["drag_loss"] > 1e-3
    assert abs(row["energy_residual"]) < 1e-12 * row["kinetic"]


def test_energy_of_a_drape_is_accounted_for():
    """Impacts, friction, drag and damping leave little over; at rest nothing runs away."""
    stepper, _ = drape(0.4, damping=2e-4, drag=4.0)
    ledger = stepper.add(Ledger())
    for k in range(1, 11):
        stepper.advance(0.2 * k)
        ledger.record()
    rows = ledger.rows
    given = rows[-1]["external_work"]
    assert given > 0.02
    assert sum(rows[-1][f"{kind}_loss"] for kind in LOSSES) > 0.3 * given
    assert max(abs(row["energy_residual"]) for row in rows) < 0.01 * given
    assert abs(rows[-1]["energy_residual"] - rows[-3]["energy_residual"]) < 1e-4 * given
    assert all(rows[-1][f"{kind}_loss"] > 0 for kind in LOSSES)


def test_work_of_moving_edges_and_moments_closes():
    """An edge carried and turned, a moment on the other: kinetic and strain energy are theirs."""
    errors = []
    for factor in (0.4, 0.2):
        shell = Shell(meshes.rectangle(0.5, 0.5, (4, 4)), Fabric.isotropic(**CLOTH))
        shell.supports.clamp("left")
        shell.supports.move(
            "left",
            lambda t: np.array([0.0, 0.0, 0.05 * (1 - np.cos(20 * t))]),
            lambda t: np.array([np.sin(1 - np.cos(9 * t)), 0.0, np.cos(1 - np.cos(9 * t))]),
        )
        shell.loads.edge_moment("right", (0.0, 1e-3, 0.0))
        stepper = Newmark(shell, factor)
        stepper.recheck = 10**9
        ledger = stepper.add(Ledger())
        rows = []
        for k in range(1, 21):
            stepper.advance(0.005 * k)
            rows.append(ledger.record())
        errors.append(np.sqrt(np.mean([row["energy_residual"] ** 2 for row in rows])))
    size = max(row["kinetic"] + row["strain"] for row in rows)
    assert max(abs(row["external_work"]) for row in rows) > 1e-3 * size
    assert errors[0] < 0.01 * size
    # of first order: moving supports are booked with the velocity of the last half step
    assert np.log2(errors[0] / errors[1]) > 0.9


FAILS = """
import sys
sys.path.insert(0, {tests!r})
from tests.dynamics.test_step_retry import drape
from shellform import console

def main(arguments):
    stepper, touch = drape()
    rank = stepper.shell.comm.rank

    def give_up(stepper, dt):
        if rank == 1 and stepper.steps == 7:
            raise ValueError("rank 1 gives up in a step")

    stepper.add(give_up)
    stepper.advance(1.0)

console.run(main)
"""


@needs_mpirun
@pytest.mark.serial
def test_a_rank_that_fails_in_a_step_ends_all(tmp_path):
    """The other waits for it in its next exchange of ghosts, and is ended all the same."""
    script = tmp_path / "fails.py"
    script.write_text(FAILS.format(tests=str(Path(__file__).resolve().parents[2])))
    done = launch(2, script)
    assert done.returncode != 0
    assert "rank 1 gives up in a step" in done.stderr
