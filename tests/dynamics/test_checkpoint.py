# SPDX-License-Identifier: LGPL-3.0-or-later
"""A run stopped and started again goes on as if it had not been stopped."""

from pathlib import Path

import numpy as np
import pytest

import meshes
from contact.body.segments import Body, Fixed, Segment
from shellform import Fabric, Shell
from shellform.contact_coupling.contact import Contact
from shellform.dynamics import checkpoint
from shellform.dynamics.explicit import Newmark
from tests.ranks import launch, needs_mpirun


def scene(cells=8, samples="nodes"):
    surface = meshes.rectangle(0.5, 0.5, (cells, cells)).transform(translation=(-0.2, -0.3, 1e-3))
    shell = Shell(surface, Fabric.isotropic(1e6, 0.3, 1e-3, 200.0))
    shell.supports.hold(np.array([0]))
    shell.loads.gravity()
    stepper = Newmark(shell, 0.8, damping=1e-4, drag=0.5)
    stepper.recheck = 50
    limb = Segment("limb", (0.2, 0.3, 0.25), Fixed((0, 0, -0.25)))
    return stepper, stepper.add(Contact(Body([limb]), 0.3, samples=samples))


def steps(stepper, count):
    for _ in range(count):
        stepper.step(stepper.dt)


def state(stepper, touch):
    gather = stepper.shell.partition.gather
    parts = [gather(a) for a in (stepper.owned, stepper.v, stepper.q)]
    return np.hstack([*parts, gather(touch.correction.window.impulse)])


@pytest.mark.parametrize("samples", ["nodes", 1])
def test_goes_on_bit_for_bit(samples, shared_tmp_path, comm):
    """A cut-back step, contact of nodes and samples, the books: all go on."""
    stepper, touch = scene(samples=samples)
    stepper.rewind.cut = 0.5
    steps(stepper, 120)
    checkpoint.save(shared_tmp_path / "c.npz", stepper)
    comm.Barrier()
    steps(stepper, 200)
    other, other_touch = scene(samples=samples)
    checkpoint.load(shared_tmp_path / "c.npz", other)
    assert 0.5 < other.rewind.cut < 0.6  # two good looks later
    steps(other, 200)
    assert other.rewind.cut == stepper.rewind.cut
    assert other.time == stepper.time
    assert other.steps == stepper.steps == 320
    assert comm.allreduce(np.abs(touch.correction.window.impulse).sum()) > 0  # it has met the limb
    assert np.array_equal(state(other, other_touch), state(stepper, touch))
    for kind, value in stepper.work.items():
        total, again = comm.allreduce(value), comm.allreduce(other.work[kind])
        assert again == pytest.approx(total, rel=1e-12, abs=1e-15)
    assert stepper.balance()["damping"] == pytest.approx(other.balance()["damping"], rel=1e-9)


@pytest.mark.parametrize("samples", ["nodes", 1])
def test_looks_go_on(samples, shared_tmp_path, comm):
    """Who looks anew for segments out of reach finds other planes to leave out: other last digits.

    The same closest points are looked for after a restart as without, step by step.
    """
    stepper, touch = scene(samples=samples)
    steps(stepper, 103)
    checkpoint.save(shared_tmp_path / "c.npz", stepper)
    comm.Barrier()
    other, other_touch = scene(samples=samples)
    checkpoint.load(shared_tmp_path / "c.npz", other)
    evaluated = []
    for _ in range(60):
        for one in (stepper, other):
            steps(one, 1)
        counts = [t.correction.evaluated for t in (touch, other_touch)]
        evaluated.append([comm.allreduce(count) for count in counts])
    whole, again = np.array(evaluated).T
    assert len({*whole.tolist()}) > 1  # some steps look, some do not
    assert np.array_equal(whole, again)


def test_samples_need_their_state(shared_tmp_path, comm):
    stepper, _ = scene(samples=1)
    checkpoint.save(shared_tmp_path / "c.npz", stepper)
    comm.Barrier()
    other, _ = scene(samples=2)
    with pytest.raises(ValueError, match="4 samples a cell"):
        checkpoint.load(shared_tmp_path / "c.npz", other)


def test_another_surface_is_refused(shared_tmp_path, comm):
    stepper, _ = scene()
    checkpoint.save(shared_tmp_path / "c.npz", stepper)
    comm.Barrier()
    other, _ = scene(cells=6)
    with pytest.raises(ValueError, match="81 nodes; rectangle has 49"):
        checkpoint.load(shared_tmp_path / "c.npz", other)


SCRIPT = """
import sys
sys.path.insert(0, "{tests}")
from tests.dynamics.test_checkpoint import checkpoint, np, scene, state, steps
stepper, touch = scene()
if sys.argv[1] == "start":
    steps(stepper, 100)
    checkpoint.save(sys.argv[2], stepper)
else:
    checkpoint.load(sys.argv[2], stepper)
    steps(stepper, 200)
    whole = state(stepper, touch)
    if stepper.shell.comm.rank == 0:
        np.save(sys.argv[3], whole)
"""


@needs_mpirun
@pytest.mark.serial
def test_goes_on_with_any_number_of_ranks(tmp_path):
    """Stopped on 2 ranks, gone on with 1, 2 and 3: 1e-8 after 200 steps that let roundoff grow."""
    script = tmp_path / "run.py"
    script.write_text(SCRIPT.format(tests=Path(__file__).resolve().parents[2]))

    def run(ranks, *arguments):
        launch(ranks, script, *arguments).check_returncode()

    run(2, "start", tmp_path / "c.npz")
    results = []
    for ranks in (1, 2, 3):
        run(ranks, "go", tmp_path / "c.npz", tmp_path / f"{ranks}.npy")
        results.append(np.load(tmp_path / f"{ranks}.npy"))
    for other in results[1:]:
        scale = np.abs(results[0]).max(axis=0) + 1e-12
        assert (np.abs(other - results[0]) / scale).max() < 1e-8


def test_beds_go_on(shared_tmp_path, comm):
    """What nodes are bedded on for the next step is in the file where somebody asked for it."""
    stepper, touch = scene()
    steps(stepper, 20)
    checkpoint.save(shared_tmp_path / "plain.npz", stepper)
    touch.bed_stiffness[:] = 1.0 + np.arange(stepper.n_owned)
    checkpoint.save(shared_tmp_path / "beds.npz", stepper)
    comm.Barrier()
    for name, watched in (("plain", False), ("beds", True)):
        other, other_touch = scene()
        checkpoint.load(shared_tmp_path / f"{name}.npz", other)
        assert other_touch.watches_beds == watched
        if watched:
            assert np.array_equal(other_touch.bed_stiffness, touch.bed_stiffness)
        steps(other, 1)
        assert not other_touch.bed_stiffness.any()  # of a single body
