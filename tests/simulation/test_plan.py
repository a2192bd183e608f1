# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a garment can come to is built, and the plan names what is there and nothing else."""

import json
from dataclasses import replace

import numpy as np
import pytest

import meshes
from shellform.contact_coupling import contact as coupling
from shellform.dynamics.explicit import Newmark
from shellform.results.report import Report
from shellform.scene.garment import garment_of
from shellform.scene.parts import Contact, Garment, Motion, Output, Steps
from shellform.scene.reach import SLIPPED, STRETCHED, along_cloth, reachable
from shellform.scene.scene import Scene
from shellform.scene.scene_file import write_scene
from shellform.scene.wearer import cut, dressed_wearer, ellipsoids_of, wearer_of
from shellform.simulation.check import check
from shellform.simulation.model import Model
from shellform.simulation.plan import plan_lines, plan_of
from shellform.simulation.summary import describe
from tests.simulation.test_only_what_is_computed import ball
from tests.simulation.test_only_what_is_loaded import sheet


def level_walk(**more):
    return Scene(motion=Motion(strides=1, obstacle=0.0), **more)


SHORTS = Garment(
    measures={"hem_height": 0.62, "knee_height": 0.65, "hem": 0.62, "knee": 0.66}, cell_size=0.04
)


@pytest.fixture(scope="module")
def dressed():
    """(wearer, shorts) of a level walk."""
    scene = level_walk(garment=SHORTS)
    wearer = wearer_of(scene)
    return wearer, garment_of(scene, wearer)


def test_along_cloth_is_the_length():
    """On a strip along its axis, and up a cylinder: what a ruler says; no less than straight."""
    strip = meshes.rectangle(2.0, 0.5, (8, 2))
    assert along_cloth(strip, "left") == pytest.approx(strip.points[:, 0], abs=1e-14)
    tube = meshes.cylinder(0.3, 1.0, cells=(24, 5))
    up = tube.points[:, 2] - tube.points[:, 2].min()
    edge = next(e for e, s in tube.edges.items() if np.ptp(up[s]) == 0 and up[s].max() == 0)
    assert along_cloth(tube, edge) == pytest.approx(up, abs=1e-12)


def skin(wearer, b, pose, count=40):
    """Points all over ellipsoid b."""
    angle, height = np.meshgrid(np.linspace(0, 2 * np.pi, count), np.linspace(0, np.pi, count))
    unit = [np.cos(angle) * np.sin(height), np.sin(angle) * np.sin(height), np.cos(height)]
    unit = np.stack(unit, axis=-1).reshape(-1, 3)
    return pose.centres[b] + (unit * wearer.radii[b]) @ pose.axes[b]


def test_reach_of_shorts(dressed):
    """Nearest points of waist and every ellipsoid in the walk, by brute force, against the rule."""
    wearer, shorts = dressed
    limit = (1 + STRETCHED) * along_cloth(shorts, "waist").max() + SLIPPED
    k = wearer.index("pelvis")
    start = wearer.new_pose(wearer.start)
    waist = shorts.points[np.unique(shorts.edges["waist"])] - start.centres[k]
    waist = waist @ start.axes[k].T
    nearest = np.full(len(wearer.names), np.inf)
    for time in np.linspace(wearer.start, wearer.end, 80):
        pose = wearer.new_pose(time)
        at = pose.centres[k] + waist @ pose.axes[k]
        for b in range(len(nearest)):
            away = np.linalg.norm(skin(wearer, b, pose)[:, None] - at[::4], axis=2)
            nearest[b] = min(nearest[b], away.min())
    assert np.abs(nearest - limit).min() > 0.01  # else the samples could not tell
    assert np.array_equal(reachable(wearer, shorts, belt=20.0), nearest < limit)


def test_only_what_is_under_the_garment_is_built(dressed):
    """Feet are bare under shorts in a level walk; a belt or a table of parts decides otherwise."""
    wearer, shorts = dressed
    feet = {"right_foot", "left_foot"}
    bare = dressed_wearer(level_walk(), wearer, shorts)
    assert set(wearer.names) - set(bare.names) == feet
    pose, whole = bare.new_pose(1.0), wearer.new_pose(1.0)
    for k, name in enumerate(bare.names):
        b = wearer.index(name)
        assert np.array_equal(pose.centres[k], whole.centres[b])
        assert np.array_equal(bare.radii[k], wearer.radii[b])
    assert bare.joints == wearer.joints
    assert dressed_wearer(level_walk(belt=0.0), wearer, shorts) is wearer
    named = level_walk(output=Output(parts={"right_knee": ["right_shank", "right_foot"]}))
    assert set(dressed_wearer(named, wearer, shorts).names) == {
        *wearer.names
    } - {"left_foot"}  # fmt: skip


def test_a_high_step_brings_the_foot_to_the_hem():
    """The whole motion counts, not its start: over an obstacle the feet are kept."""
    scene = Scene(motion=Motion(strides=3, obstacle=0.5), garment=SHORTS)
    wearer = wearer_of(scene)
    shorts = garment_of(scene, wearer)
    assert dressed_wearer(scene, wearer, shorts) is wearer
    assert not reachable(standing(wearer), shorts, belt=20.0).all()


def test_a_run_leaves_out_what_its_plan_does(shared_tmp_path, comm):
    """Bare feet are not in the body that the cloth meets, and summary.json says so."""
    model = Model(level_walk(garment=SHORTS), comm)
    met = model.contact.correction.body.names
    report = Report(shared_tmp_path, "walk", {}, comm)
    describe(report, model)
    plan = report.summary["plan"]
    assert plan["out_of_reach"] == [name for name in model.whole.names if name not in met]
    assert plan["out_of_reach"] == ["right_foot", "left_foot"] and plan["contact"] == list(met)
    assert (model.contact.correction.allowed < 1 << len(met)).all()


def standing(wearer):
    """The same wearer, for its first moments only."""
    recording = cut(wearer.recording, None, wearer.start + 0.1)
    return type(wearer)(recording, ellipsoids_of(Scene(), wearer.recording))


def test_plan_names_what_is_there_and_nothing_else(dressed):
    wearer, shorts = dressed
    full = plan_of(level_walk(garment=SHORTS), wearer, shorts)
    assert full == plan_of(level_walk(garment=SHORTS))  # of the scene alone
    assert full["terms"] == [
        *("membrane", "bending", "transverse shear", "inertia", "rotary inertia"),
        *("gravity", "drag"),
    ]
    assert full["out_of_reach"] == ["right_foot", "left_foot"]
    assert full["friction"] == [0.3, 0.3] and full["belt"] == 20.0
    assert "pressure.npz" in full["outputs"]
    assert json.loads(json.dumps(full)) == full

    less = level_walk(
        garment=SHORTS, gravity=0.0, belt=0.0, contact=Contact(friction=0.0),
        steps=Steps(drag=0.0, damping=1e-6), output=Output(pressure=0.0),
    )  # fmt: skip
    bare = plan_of(less, wearer, shorts)
    assert bare["terms"][5:] == ["damping"]
    assert set(full) - set(bare) == {"friction", "belt", "out_of_reach"}
    assert "pressure.npz" not in bare["outputs"]
    assert bare["contact"] == list(wearer.names)
    text = "\n".join(plan_lines(bare))
    assert "no friction" in text and "no belt" in text and "gravity" not in text
    assert "friction: 0.3, 0.3" in "\n".join(plan_lines(full))
    kinetic = replace(less, contact=Contact(friction=0.5, kinetic_friction=0.4))
    assert plan_of(kinetic, wearer, shorts)["friction"] == [0.5, 0.4]


def test_plan_of_a_run_is_stored(shared_tmp_path, comm):
    """In summary.json: of a static problem, a fall, and cloth on a ball; only what each has."""
    plans = {}
    for name in ("statics", "fall", "ball"):
        shell, stepper = sheet(comm=comm), None
        if name != "statics":
            shell.loads.gravity()
            stepper = Newmark(shell)
        if name == "ball":
            stepper.add(coupling.Contact(ball(), 0.0))
        report = Report(shared_tmp_path / name, name, {}, comm)
        report.describe(shell, stepper)
        report.write({})
        comm.Barrier()
        plans[name] = json.loads((shared_tmp_path / name / "summary.json").read_text())["plan"]
    strains = ["membrane", "bending", "transverse shear"]
    assert plans["statics"]["terms"] == strains and plans["statics"]["loads"] == {}
    assert plans["fall"]["terms"] == [*strains, "inertia", "rotary inertia"]
    assert plans["fall"]["loads"] == {"gravity": 1}
    assert not {"contact", "friction"} & set(plans["fall"])
    assert plans["ball"]["contact"] == ["ball 0"] and "friction" not in plans["ball"]


@pytest.mark.serial
def test_a_scene_is_checked_by_its_file(tmp_path):
    """`sf.check` takes the file too; one that is not there is named with the mend."""
    path = tmp_path / "scene.toml"
    write_scene(Scene(title="of a file"), path)
    assert check(path)[0] == "of a file"
    with pytest.raises(FileNotFoundError, match="shellform new"):
        check(tmp_path / "none.toml")
