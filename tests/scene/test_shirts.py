# SPDX-License-Identifier: LGPL-3.0-or-later
"""Garments that hang on the shoulders: sewn about raised arms, let down, carried, walked."""

import json
from dataclasses import replace

import numpy as np
import pytest

import meshes
from contact.geometry.ellipsoid import closest_points
from meshes.garments.shirt import prepare_shirt
from meshes.patterns import read_pattern, sew
from meshes.patterns.crossings import crossings
from shellform.fem.lumped_mass import nodal_areas
from shellform.motion.recording import UPPER_SEGMENTS
from shellform.results.joint_torque import Torque
from shellform.scene.garment import garment_of
from shellform.scene.parts import Contact, Garment, Motion, Output, Person, Steps
from shellform.scene.scene import Scene
from shellform.scene.scene_file import read_scene, write_scene
from shellform.scene.shoulders import belt_of
from shellform.scene.wearer import dressing_wearer, wearer_of
from shellform.simulation.members import members_of
from shellform.simulation.model import Model
from shellform.simulation.plan import plan_of
from shellform.simulation.run import run
from tests.meshes.patterns.drafts import FILES

SHIRT = Scene(
    motion=Motion(start=1.5, end=1.7, initiation=0.5, obstacle=0.0),
    steps=Steps(runs=1),
    output=Output(checkpoint=0.1, pressure=0.0),
    garment=Garment(file=str(FILES / "shirt.json"), cell_size=0.04),
    contact=Contact(self_contact=True),
)
ARMS = ["right_upper_arm", "right_forearm", "left_upper_arm", "left_forearm"]


def of(**more):
    return replace(SHIRT, garment=replace(SHIRT.garment, **more))


@pytest.fixture(scope="module")
def wearer():
    return wearer_of(SHIRT)


def check_worn(surface, wearer):
    """On trunk and arms, none of it inside the body or through itself."""
    assert {"neck", "hem", "left_cuff", "right_cuff"} <= set(surface.edges)
    assert "waist" not in surface.edges and surface.flat is not None
    assert len(crossings(surface.points, surface.cells)) == 0
    lowering = dressing_wearer(SHIRT, wearer)
    pose = lowering.new_pose(lowering.start)
    for k, name in enumerate(lowering.names):
        distances = closest_points(
            surface.points, lowering.radii[k], pose.centres[k], pose.axes[k]
        )[2]
        assert distances.min() > 0.0, name


@pytest.fixture(scope="module")
def model(comm):
    return Model(SHIRT, comm)


@pytest.mark.serial
def test_sewn_around_trunk_and_arms(model):
    surface = model.surface
    check_worn(surface, model.whole)
    area = sum(panel.area for panel in read_pattern(FILES / "shirt.json").panels)
    assert nodal_areas(surface).sum() == pytest.approx(area, rel=5e-3)
    heights = {n: surface.points[np.unique(e), 2].mean() for n, e in surface.edges.items()}
    assert heights["neck"] > heights["left_cuff"] > heights["hem"]
    assert heights["left_cuff"] == pytest.approx(heights["right_cuff"], abs=0.01)


@pytest.mark.serial
def test_sleeves_without_a_place_go_around_the_arms(wearer, tmp_path):
    """On cylinders about trunk and arms, by their names, drawn with the cuff below."""
    data = json.loads((FILES / "shirt.json").read_text())
    for name, panel in data["pattern"]["panels"].items():
        del panel["translation"], panel["rotation"]
        if "sleeve" in name:
            turn = -1 if name.startswith("left") else 1
            panel["vertices"] = [[-turn * y, turn * x] for x, y in panel["vertices"]]
    (tmp_path / "shirt.json").write_text(json.dumps(data))
    surface = garment_of(of(file=str(tmp_path / "shirt.json"), cell_size=0.05), wearer)
    cuff = surface.points[np.unique(surface.edges["left_cuff"])].mean(axis=0)
    elbow = dressing_wearer(SHIRT, wearer).recording.points["left_upper_arm"][0, 1]
    assert np.linalg.norm(cuff - elbow) < 0.15


def test_only_a_shirt_has_a_wearer_with_arms(wearer):
    """And its plan says so: no belt, joints of trunk and arms, no feet within reach."""
    assert set(ARMS) <= set(wearer.names)
    other = wearer_of(Scene(motion=SHIRT.motion))
    assert len(other.names) == 8 and not {"thorax", *ARMS} & set(other.recording.points)
    assert belt_of(20.0, SHIRT.garment) == 0.0 and belt_of(20.0, Garment()) == 20.0
    assert belt_of(20.0, replace(SHIRT.garment, hangs="waist")) == 20.0
    surface = meshes.sleeve(0.1, 0.4, 0.1, cell_size=0.015)  # a stand-in of that size
    surface = surface.with_edges(neck=lambda points: points[:, 2] > points[:, 2].max() - 1e-6)
    pose = wearer.new_pose(wearer.start)
    shift = pose.centres[wearer.index("neck")] - surface.points.max(axis=0)
    plan = plan_of(SHIRT, wearer, surface.transform(translation=shift))
    assert "belt" not in plan and {"lumbar", "left_shoulder", "right_elbow"} <= set(plan["joints"])
    assert {"thorax", "shoulders", "neck"} <= set(plan["contact"])
    assert {"left_foot", "right_foot"} <= set(plan["out_of_reach"])


def test_starts_of_an_ensemble_differ_by_gravity(tmp_path):
    """A belt that is not there tells no starts apart."""
    members = members_of(replace(SHIRT, steps=Steps(runs=3)), tmp_path)
    pulls = {member.scene.gravity for member in members}
    assert len(pulls) == 3 and {member.scene.belt for member in members} == {SHIRT.belt}


def test_the_key_in_a_file(tmp_path):
    scene = of(hangs="shoulders")
    write_scene(scene, tmp_path / "scene.toml")
    assert read_scene(tmp_path / "scene.toml").garment.hangs == "shoulders"
    with pytest.raises(ValueError, match=r"garment.hangs is auto, waist or shoulders, not 'neck'"):
        of(hangs="neck")


@pytest.mark.serial
def test_refusals(tmp_path):
    """One sentence each, with the mend."""
    with pytest.raises(
        ValueError, match=r"hangs = 'shoulders' is for sewing patterns, and polo.obj"
    ):
        wearer_of(of(file="polo.obj", hangs="shoulders"))
    with pytest.raises(ValueError, match=r"person.body = 'mesh': .* leave person.body out"):
        wearer_of(replace(SHIRT, person=Person(body="mesh")))
    with pytest.raises(ValueError, match=r"steps.dressing = 'particles': .* take 'shell'"):
        wearer_of(replace(SHIRT, steps=Steps(dressing="particles")))
    coarse = {"cell_size": 0.06}
    wide = replace(of(**coarse), person=Person(girths={"chest": 1.6}))
    with pytest.raises(ValueError, match=r"measures 1.6\d* m around the chest, shirt.json only"):
        garment_of(wide, wearer_of(wide))
    data = json.loads((FILES / "shirt.json").read_text())
    for k in (7, 0):  # left open from hem to cuff
        del data["pattern"]["stitches"][k]
    (tmp_path / "open.json").write_text(json.dumps(data))
    opened = sew(read_pattern(tmp_path / "open.json"), 0.06, steps=200)
    with pytest.raises(meshes.MeshError, match=r"open.json: .* four openings.*has 1"):
        prepare_shirt(opened)


@pytest.mark.serial
def test_carried_by_the_shoulders(comm, model):
    """At rest the body holds the weight, along a line through the cloth's middle; no crossings.

    To what has settled: a hundredth of the weight, and of its moment at the length of an arm.
    """
    fit, weight = model.dress(), model.weight
    area = sum(panel.area for panel in read_pattern(FILES / "shirt.json").panels)
    cloth = SHIRT.cloth
    assert weight == pytest.approx(area * cloth.areal_mass * SHIRT.gravity, rel=5e-3)
    assert fit["settled"] and fit["carried"] == pytest.approx(weight, rel=0.01)
    assert "belt_tension" not in fit and fit["depth"] < 1e-4 and fit["stretch"] < 0.05
    stepper, contact = model.stepper, model.contact
    assert contact.cloth.intersections() == 0
    torque = stepper.add(Torque())
    contact.reset()
    stepper.advance(stepper.time + 0.04)
    rows = {row["joint"]: row for row in torque.record(stepper.time)}
    window = contact.window
    table = comm.allreduce(window.table[:, :6]) / window.seconds
    x = stepper.points + stepper.owned[:, :3]
    middle = comm.allreduce(stepper.mass @ x) / comm.allreduce(stepper.mass.sum())
    arms = model.wearer.new_pose(stepper.time).centres - middle
    moment = (table[:, 3:] + np.cross(arms, table[:, :3])).sum(axis=0)
    assert np.linalg.norm(moment) < 0.01 * weight * 0.3
    # torque of the trunk is that of all but what presses the pelvis and the legs
    above = [k for k, s in enumerate(model.wearer.carriers) if s in UPPER_SEGMENTS]
    lumbar = model.wearer.recording.joint_centre("lumbar")[0]
    centres = model.wearer.new_pose(stepper.time).centres[above] - lumbar
    wanted = -(table[above, 3:] + np.cross(centres, table[above, :3])).sum(axis=0)
    found = [rows["lumbar"][f"torque_{axis}"] for axis in "xyz"]
    assert found == pytest.approx(wanted, abs=1e-3 * weight)
    assert np.isfinite([row["torque_flexion"] for row in rows.values()]).all()


@pytest.mark.thorough
@pytest.mark.serial
@pytest.mark.parametrize("size", [0.04, 0.033])
def test_from_file_to_walked(size, tmp_path):
    scene = replace(of(cell_size=size), motion=replace(SHIRT.motion, end=1.9))
    results = run(scene, tmp_path / "out", lines=False)
    fit, weight = results["dressing"], results["weight"]
    assert fit["settled"] and fit["carried"] == pytest.approx(weight, rel=0.01)
    # with 0.033 an arm presses several layers on the trunk: a few edges pass there, see
    # docs/patterns.md, more or fewer by the start
    assert fit["stretch"] < 0.1 and results["intersections"] <= (0 if size == 0.04 else 10)
    assert np.isfinite([j["peak_torque"] for j in results["joints"].values()]).all()


@pytest.mark.thorough
@pytest.mark.serial
@pytest.mark.parametrize("pull", [1.0, 1.001])
@pytest.mark.parametrize("size", [0.05, None])
def test_pinched_in_the_armpit(size, pull, comm):
    """Cells of which an arm presses several layers on the trunk; without a size: as chosen.

    In a scene that says no more than its end.
    """
    scene = replace(of(cell_size=size), motion=Motion(end=1.2), gravity=pull * SHIRT.gravity)
    model = Model(scene, comm)
    fit = model.dress()
    assert model.contact.pinched > 0
    assert fit["settled"] and fit["carried"] == pytest.approx(model.weight, rel=0.01)
    assert fit["stretch"] < 0.18
