# SPDX-License-Identifier: LGPL-3.0-or-later
"""What errors cost in a scene of one's own, and the error of a run from a companion run."""

import json

import pytest

from shellform import console
from shellform.__main__ import main
from shellform.accuracy.convergence import (
    PowerLaw,
)
from shellform.scene.parts import Garment, Steps
from shellform.scene.scene import Scene
from shellform.simulation import error_study
from shellform.simulation.summary import summary_of

pytestmark = pytest.mark.serial


def test_trade_of_the_default_scene(tmp_path, capsys, monkeypatch):
    """`shellform new` and `shellform trade`: a line a wish; nodes go with h^-2, steps with h."""
    monkeypatch.chdir(tmp_path)
    main(["new", "scene.toml"])
    capsys.readouterr()
    main(["trade", "scene.toml"])
    said = capsys.readouterr().out.splitlines()
    assert "error of torque rms" in said[0]
    rows = {line.split()[0]: line.split() for line in said[2:9]}
    assert list(rows) == ["draft", "standard", "fine", "10%", "3%", "1%", "0.3%"]
    sizes, nodes, steps = (
        [float(rows[word][k]) for word in ("draft", "standard", "fine")] for k in (-5, -4, -3)
    )
    assert sizes[0] > sizes[1] > sizes[2]
    assert nodes[2] == pytest.approx(nodes[0] * (sizes[0] / sizes[2]) ** 2, rel=0.01)
    assert steps[2] == pytest.approx(steps[0] * sizes[2] / sizes[0], rel=0.05)
    minutes = [float(rows[word][-2]) for word in ("draft", "standard", "fine")]
    assert minutes[0] < minutes[1] < minutes[2]
    assert not (tmp_path / "out").exists()
    # what no cells can keep is told with the reason
    assert "of torque rms cannot be promised: " in said[-1]


def false_run(monkeypatch, order=2.0):
    """`run` leaves torques with an error of h^order, in place of a walk."""

    def run(scene, out, comm, dressed=None, watch=None):
        out.mkdir(parents=True, exist_ok=True)
        size = 1 + scene.cell_size**order
        joints = {"right_hip": 2.0 * size, "right_knee": 0.3 * size, "right_ankle": 0.0}
        results = {"joints": {name: {"rms_torque": value} for name, value in joints.items()}}
        entry = {"seconds": {"total": 60.0}, "results": results}
        (out / "summary.json").write_text(json.dumps(entry))

    monkeypatch.setattr(error_study, "run", run)


def measured_as(monkeypatch, law):
    """Errors of torques go with the size as `law` says, in place of the table's."""
    home = "shellform.accuracy.choice.power_laws"
    monkeypatch.setattr(
        home, lambda *_, **__: {"quads": dict.fromkeys(("torque rms", "torque curve"), law)}
    )


def test_a_companion_run_gives_the_error(tmp_path, monkeypatch):
    """With torques whose error is a power of the size the estimate is that error."""
    law = PowerLaw(1.0, 2.0, finest=0.1, coarsest=10.0)
    measured_as(monkeypatch, law)
    false_run(monkeypatch)
    scene = Scene(garment=Garment(cell_size=0.018))
    error_study.run(scene, tmp_path, console.MPI.COMM_SELF)
    entry = error_study.estimate(scene, tmp_path, console.MPI.COMM_SELF)
    assert entry == summary_of(tmp_path)["accuracy"]
    assert entry["estimated"] == pytest.approx(0.018**2, rel=1e-2)
    assert entry["asked"] is None and entry["promised"] is None
    assert entry["cell_size"] == pytest.approx(0.018)
    # where errors show no order the difference itself is told
    flat = PowerLaw(0.3, 0.0, finest=0.1, coarsest=10.0)
    measured_as(monkeypatch, flat)
    entry = error_study.estimate(scene, tmp_path, console.MPI.COMM_SELF)
    assert entry["estimated"] == pytest.approx(3 * 0.018**2, rel=1e-2)


@pytest.mark.parametrize(
    ("size", "other"), [(0.0175, 0.035), (0.025, 0.04), (0.035, 0.04), (0.04, 0.032)]
)
def test_cells_beside_make_trousers(size, other):
    assert error_study.companion_scene(
        Scene(garment=Garment(cell_size=size))
    ).cell_size == pytest.approx(other)


@pytest.mark.parametrize("given", [["trade"], ["run", "--estimate"]])
def test_cells_of_a_file_cannot_be_chosen(given, tmp_path, capsys):
    """One sentence, before any computation."""
    (tmp_path / "scene.toml").write_text('[garment]\nfile = "skirt.obj"')
    with pytest.raises(SystemExit) as stop:
        console.run(main, [*given, str(tmp_path / "scene.toml")])
    said = capsys.readouterr()
    assert stop.value.code == 2 and said.out == ""
    assert "needs cells of other sizes, and garment.file" in said.err


def test_the_two_cheapest_are_compared(tmp_path, monkeypatch):
    """`shellform trade --measure`: minutes and differences of what was run."""
    false_run(monkeypatch)
    said = error_study.cost_table(
        Scene(steps=Steps(accuracy="draft")), console.MPI.COMM_SELF, tmp_path
    )
    finer, coarser = (line.split() for line in said[-1:-3:-1])
    sizes = sorted((float(path.name.split("_")[1]) for path in tmp_path.iterdir()), reverse=True)
    assert [float(coarser[0]), float(finer[0])] == pytest.approx(sizes, abs=0.06)
    assert coarser[1] == "1.0" and coarser[2:] == ["0", "%"] and len(finer) == 2
