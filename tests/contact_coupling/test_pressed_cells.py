# SPDX-License-Identifier: LGPL-3.0-or-later
"""A relaxed sheet between two soft limbs that close on it: energy, checkpoint, ranks."""

import sys

import numpy as np
import pytest

import meshes
from contact.body.segments import Body, Fixed, Segment, Steady
from shellform import Fabric, Shell
from shellform.contact_coupling.contact import Contact
from shellform.dynamics import checkpoint
from shellform.dynamics.explicit import Newmark
from shellform.results.ledger import Ledger
from tests.ranks import launch, needs_mpirun

FLESH = 2e5  # Pa/m
RADII = [0.5, 0.5, 0.1]


def pressed(comm, factor=0.4, wrinkles="relaxed"):
    """Stepper and contact of a sheet on a limb on which another comes down with 0.5 m/s."""
    surface = meshes.rectangle(0.3, 0.2, (9, 6)).transform(translation=(-0.14, -0.11, 0.0))
    fabric = Fabric.isotropic(2e6, 0.3, 5e-4, 400.0)
    shell = Shell(surface, fabric, comm, wrinkles=wrinkles)
    shell.supports.hold(np.array([0]))
    stepper = Newmark(shell, factor, damping=1e-4, drag=0.5)
    # pressed together already, so that there is a strain for the beds to act on
    points = surface.points[shell.partition.nodes]
    shell.w.x.array.reshape(-1, 6)[:, 0] -= 0.01 * (points[:, 0] + 0.14)
    below = Segment("below", RADII, Fixed((0.0, 0.0, -0.101)))
    above = Segment("above", RADII, Steady((0.0, 0.0, 0.102), np.eye(3), (0.0, 0.0, -0.5)))
    return stepper, stepper.add(Contact(Body([below, above]), 0.3, flesh_stiffness=FLESH))


def closed(comm, seconds=0.012, **options):
    stepper, touch = pressed(comm, **options)
    stepper.advance(seconds)
    return stepper, touch


def state(stepper, touch):
    gather = stepper.shell.partition.gather
    parts = [gather(a) for a in (stepper.owned, stepper.v, stepper.q)]
    return np.hstack([*parts, gather(touch.correction.window.impulse)])


@pytest.mark.parametrize("beds", ["some", "none"])
def test_set_beds_tells_the_energy_it_adds(beds, comm):
    """Of arcs, of the load, of bending in plane: whatever the beds change."""
    shell = pressed(comm)[0].shell
    w, points = shell.w.x.array.reshape(-1, 6), shell.surface.points[shell.partition.nodes]
    w[:, 2] = 0.01 * np.sin(20 * points[:, 0] + 5 * points[:, 1])
    w[:, 3:] += 0.2 * np.cos(15 * points[:, [1, 0, 2]])
    membrane = shell.cell_membrane
    count = len(membrane.area)
    stiffness = FLESH * (np.arange(count) % 3)
    if beds == "none":
        membrane.set_beds(stiffness, w)
        stiffness = np.zeros(count)
    before = membrane.energy(w)
    told = membrane.set_beds(stiffness, w)
    assert abs(told) > 1e-5 or not count
    assert membrane.energy(w) - before == pytest.approx(told, rel=1e-9)
    assert membrane.set_beds(stiffness, w) == 0.0


def test_energy_closes_while_beds_change(comm):
    """The work of the beds is booked: what is left over is as small as without them."""
    rows, works = {}, []
    for kind in ("beds", "none"):
        stepper, touch = pressed(comm, factor=0.2)
        if kind == "none":
            touch.pressed = None
        else:
            look = touch.pressed.look
            touch.pressed.look = lambda *a, look=look: works.append(look(*a)) or works[-1]
        ledger = stepper.add(Ledger())
        stepper.advance(0.015)
        rows[kind] = ledger.record()
    work = comm.allreduce(sum(works))
    assert comm.allreduce(np.count_nonzero(works)) > 10
    residuals = {kind: abs(row["energy_residual"]) for kind, row in rows.items()}
    print(f"work {work:.2e} J, left over {residuals}")
    assert abs(residuals["beds"] - residuals["none"]) < 0.05 * work
    assert residuals["beds"] < 2.0 * residuals["none"]


def test_beds_that_come_and_go_do_little_work(comm):
    """A crease that presses at every other look: a few per cent of what beds give at once.

    Those would let a cell spring open against them, and be gone while it is pushed together again:
    the body would pay for that in each turn.
    """
    stepper, touch = pressed(comm)
    beds, w, membrane = touch.pressed, stepper.w, stepper.shell.cell_membrane
    together, nodes, given = w.copy(), np.full(stepper.n_owned, FLESH), []
    half = together.copy()
    half[:, 0] *= 0.5
    at_once = 0.0  # work of a turn, of beds that come at once
    for x, bed in ((together, FLESH), (half, 0.0)):
        w[:] = x
        before = membrane.energy(w)
        beds.restore(stepper, bed)
        at_once += comm.allreduce(membrane.energy(w) - before)
    stepper.clock.last_dt = 5e-5
    for turn in range(400):
        w[:] = half if turn % 2 else together
        given.append(comm.allreduce(beds.look(stepper, 0.0 * nodes if turn % 2 else nodes)))
    last = sum(given[-100:]) / 50
    print(f"{at_once:.2e} J a turn at once, {last:.2e} J with the lag")
    assert at_once > 1e-4 and abs(last) < 0.05 * at_once


def test_goes_on_bit_for_bit_where_cells_are_pressed(shared_tmp_path, comm):
    """The beds come back between two looks at them, and change afterwards as they would have."""
    stepper, touch = closed(comm)
    while stepper.steps % 10 != 5:
        stepper.step(stepper.dt)
    kept = touch.pressed.beds.copy()
    assert comm.allreduce(np.count_nonzero(kept)) > 5
    checkpoint.save(shared_tmp_path / "c.npz", stepper)
    comm.Barrier()
    other, other_touch = pressed(comm)
    checkpoint.load(shared_tmp_path / "c.npz", other)
    assert np.array_equal(other_touch.pressed.beds, kept)
    for name in ("beds", "load", "arcs"):
        one, again = (getattr(s.shell.wrinkles, name) for s in (stepper, other))
        assert np.array_equal(one, again)
    for each in (stepper, other):
        for _ in range(60):
            each.step(each.dt)
    assert comm.allreduce(int(not np.array_equal(touch.pressed.beds, kept))) > 0
    assert np.array_equal(touch.pressed.beds, other_touch.pressed.beds)
    assert np.array_equal(state(other, other_touch), state(stepper, touch))


def test_a_state_comes_back_with_its_beds(comm):
    stepper, touch = closed(comm)
    kept, before = touch.state(), [a.copy() for a in vars_of(stepper)]
    for _ in range(30):
        stepper.step(stepper.dt)
    moved = any(not np.array_equal(a, b) for a, b in zip(vars_of(stepper), before, strict=True))
    assert comm.allreduce(int(moved)) > 0
    touch.restore(kept)
    for now, then in zip(vars_of(stepper), before, strict=True):
        assert np.array_equal(now, then)


def vars_of(stepper):
    """What cells know of their beds."""
    wrinkles = stepper.shell.wrinkles
    return wrinkles.beds, wrinkles.load, wrinkles.arcs


def test_resolved_sheets_look_at_no_beds(comm):
    _, touch = closed(comm, 0.001, wrinkles="resolved")
    assert touch.pressed is None and not touch.watches_beds


@needs_mpirun
@pytest.mark.serial
@pytest.mark.slow
def test_ranks_agree(tmp_path):
    """Places, beds and wrinkles of 1, 2 and 3 ranks: sums in another order, no more."""
    results = []
    for ranks in (1, 2, 3):
        path = tmp_path / f"{ranks}.npz"
        done = launch(ranks, "-m", "tests.contact_coupling.test_pressed_cells", path)
        assert done.returncode == 0, done.stderr[-2000:]
        results.append(np.load(path))
        assert results[-1]["ranks"] == ranks
    one, *others = results
    assert np.count_nonzero(one["beds"]) > 5 and {*one["state"]} >= {1, 2}
    for other in others:
        assert np.abs(other["x"] - one["x"]).max() < 1e-9
        assert np.array_equal(other["beds"], one["beds"])
        assert np.array_equal(other["state"], one["state"])
        assert np.abs(other["strain"] - one["strain"]).max() < 1e-7
        along = np.sum(other["crest"] * one["crest"], axis=1)
        assert np.abs(along**2 - (one["state"] == 1)).max() < 1e-6


if __name__ == "__main__":
    from mpi4py import MPI

    end, met = closed(MPI.COMM_WORLD, 0.01)
    found, places = end.shell.wrinkling(), end.shell.positions()
    nodes = end.shell.partition.gather(met.pressed.beds[:, None])
    if MPI.COMM_WORLD.rank == 0:
        ranks = MPI.COMM_WORLD.size
        np.savez(sys.argv[1], x=places, beds=nodes, ranks=ranks, **found._asdict())
