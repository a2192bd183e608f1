# SPDX-License-Identifier: LGPL-3.0-or-later
"""Files for OpenSim against the forces that they were made of, and in OpenSim itself."""

import csv
import json
import os
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from shellform import __main__
from shellform.export.coordinate_forces import fit
from shellform.export.opensim import FILES, export
from shellform.export.opensim_model import HIPS, read_model
from shellform.export.opensim_names import BODIES, coordinates_of
from shellform.motion.recording import JOINTS
from shellform.results.joint_torque import COLUMNS
from shellform.scene.parts import Motion, Steps
from shellform.scene.scene import Scene
from shellform.scene.scene_file import write_scene
from shellform.scene.wearer import wearer_of

pytestmark = pytest.mark.serial

SCENE = Scene(motion=Motion(strides=1, obstacle=0.0), steps=Steps(runs=1))
WINDOW, MOMENTS = 0.02, 20  # the run is made up: its forces are known at so many times a window


def forces(time, count):
    """Forces [N] on the wearer and moments [N m] about the centres of ellipsoids, made up."""
    phase = 3.0 * time + np.arange(count)[:, None] + np.arange(3)
    return 4.0 * np.sin(phase), 0.3 * np.cos(2.0 * phase)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A folder like that of a run, whose forces are those of `forces`."""
    out = tmp_path_factory.mktemp("run")
    write_scene(SCENE, out / "scene.toml")
    wearer = wearer_of(SCENE)
    m, joints, pose = len(wearer), wearer.new_joints(), wearer.new_pose()
    below = {j: [wearer.index(name) for name in wearer.below(j)] for j in wearer.joints}
    ledger, torque = [], []
    ends = wearer.start + WINDOW * np.arange(1, round((wearer.end - wearer.start) / WINDOW))
    for end in ends.tolist():
        loads, about = np.zeros((m, 6)), np.zeros((len(joints.centres), 4))
        for k in range(MOMENTS):
            time = end - WINDOW + (k + 0.5) * WINDOW / MOMENTS
            f, moment = forces(time, m)
            wearer.pose(time, pose)
            wearer.joint_state(time, joints)
            loads += np.hstack([f, moment]) / MOMENTS
            for i, joint in enumerate(wearer.joints):
                some = below[joint]
                tau = (
                    moment[some] + np.cross(pose.centres[some] - joints.centres[i], f[some])
                ).sum(0)
                about[i] += np.append(tau, tau @ joints.axes[i]) / MOMENTS
        row = {"time": end}
        for name, load in zip(wearer.names, -loads, strict=True):  # the ledger has the cloth's
            row |= {f"force_{name}_{a}": load[k] for k, a in enumerate("xyz")}
            row |= {f"moment_{name}_{a}": load[3 + k] for k, a in enumerate("xyz")}
        ledger.append(row)
        torque += [
            dict(zip(COLUMNS, (end, j, *tau, 0.0), strict=True))
            for j, tau in zip(wearer.joints, about, strict=True)
        ]
    for name, rows in (("ledger.csv", ledger), ("torque.csv", torque)):
        with open(out / name, "w", newline="") as file:
            writer = csv.DictWriter(file, list(rows[0]))
            writer.writeheader()
            writer.writerows(rows)
    (out / "summary.json").write_text("{}")
    return out, wearer, torque


def storage(path):
    """Columns of a .sto or .mot file."""
    head, body = path.read_text().split("endheader\n")
    names, *rows = (line.split("\t") for line in body.splitlines())
    table = np.array(rows, float)
    assert f"nRows={len(table)}" in head and f"nColumns={len(names)}" in head
    return dict(zip(names, table.T, strict=True))


def test_torques_along_coordinates(run, tmp_path):
    """Flexion of hips, knees and ankles is that of torque.csv, but for axes that turn meanwhile."""
    out, _, rows = run
    export(out, tmp_path)
    found = storage(tmp_path / "coordinate_torques.sto")
    for c in coordinates_of("rajagopal"):
        if c.turn:
            continue
        own = np.array([row["torque_flexion"] for row in rows if row["joint"] == c.joint])
        assert np.abs(found[c.name] - c.sign * own).max() < 3e-3 * np.abs(own).max()


def test_work_of_a_hip(run, tmp_path):
    """Torques along the three coordinates of a hip do the work of the torque: tau . spin."""
    out, wearer, rows = run
    found = export(out, tmp_path)
    motion, joints = storage(tmp_path / "coordinates.mot"), wearer.new_joints()
    for side in ("right", "left"):
        names = [c.name for c in coordinates_of("rajagopal") if c.joint == f"{side}_hip"]
        own = [row for row in rows if row["joint"] == f"{side}_hip"]
        tau = np.array([[row[f"torque_{a}"] for a in "xyz"] for row in own])
        which = wearer.joints.index(f"{side}_hip")
        spins = np.array([wearer.joint_state(t, joints).spins[which].copy()
                          for t in found["times"].tolist()])  # fmt: skip
        rates = [np.interp(found["times"], motion["time"], np.gradient(motion[n], motion["time"]))
                 for n in names]  # fmt: skip
        along = sum(found["torques"][n] * r for n, r in zip(names, rates, strict=True))
        work = np.sum(tau * spins, axis=1)
        assert np.abs(along - work)[2:-2].max() < 2e-2 * np.abs(work).max()


def test_loads_in_the_ground(run, tmp_path):
    """Force and moment about the ground's origin are those of all ellipsoids, y up and z right."""
    out, wearer, _ = run
    export(out, tmp_path)
    found = storage(tmp_path / "external_loads.mot")
    bodies = [BODIES[s] for s in dict.fromkeys(wearer.carriers)]

    def vector(name, k):
        return np.array([found[f"{name}{axis}"][k] for axis in "xyz"])

    turn = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
    for k in (5, 40):
        time = found["time"][k]
        f, moment = forces(time, len(wearer))
        centres = wearer.new_pose(time).centres
        total, about = f.sum(0), (moment + np.cross(centres, f)).sum(0)
        got = sum(vector(f"{b}_force_v", k) for b in bodies)
        arm = sum(np.cross(vector(f"{b}_force_p", k), vector(f"{b}_force_v", k))
                  + vector(f"{b}_torque_", k) for b in bodies)  # fmt: skip
        assert got == pytest.approx(turn @ total, abs=2e-3 * np.abs(f).max())
        assert arm == pytest.approx(turn @ about, abs=5e-3 * np.abs(about).max())


def test_signs_of_the_models(run, tmp_path):
    """A knee that bends has a positive angle in one model and a negative one in the other."""
    out, *_ = run
    found = {}
    for model in ("rajagopal", "gait2392"):
        export(out, tmp_path / model, model)
        found[model] = [storage(tmp_path / model / name)
                        for name in ("coordinates.mot", "coordinate_torques.sto")]  # fmt: skip
    for mine, theirs in zip(*found.values(), strict=True):
        for name in set(mine) - {"pelvis_tx", "pelvis_ty", "pelvis_tz"}:  # their hips differ
            sign = -1.0 if name.startswith("knee") else 1.0
            assert np.array_equal(mine[name], sign * theirs[name])
    angles = found["rajagopal"][0]
    assert angles["knee_angle_r"].max() > 0.8 and angles["hip_flexion_r"].max() > 0.3
    assert angles["pelvis_ty"].min() > 0.8 and np.ptp(angles["pelvis_tx"]) > 0.5


def test_hips_of_the_model_are_at_those_of_the_wearer(run, tmp_path):
    """Pelvis of coordinates.mot, turned and shifted as OpenSim does it: about z, x, y."""
    out, wearer, _ = run
    middle = wearer.recording.points["pelvis"][:, 1] @ [[1, 0, 0], [0, 0, -1], [0, 1, 0]]
    file = tmp_path / "own.osim"
    file.write_text(model_text())
    chosen = (("rajagopal", None, HIPS["rajagopal"]), ("gait2392", None, HIPS["gait2392"]))
    for name, own, hips in (*chosen, ("rajagopal", file, (-0.06, -0.08, 0.0))):
        export(out, tmp_path / "files", name, own)
        found = storage(tmp_path / "files" / "coordinates.mot")
        tilt, lean, turn = (found[f"pelvis_{k}"] for k in ("tilt", "list", "rotation"))
        x, y, z = hips
        # about y, then about x, then about z, each by its own matrix
        x, z = x * np.cos(turn) + z * np.sin(turn), z * np.cos(turn) - x * np.sin(turn)
        y, z = y * np.cos(lean) - z * np.sin(lean), y * np.sin(lean) + z * np.cos(lean)
        x, y = x * np.cos(tilt) - y * np.sin(tilt), x * np.sin(tilt) + y * np.cos(tilt)
        at = np.stack([found[f"pelvis_t{k}"] for k in "xyz"], axis=1) + np.stack([x, y, z], axis=1)
        assert np.abs(at - middle).max() < 1e-6


def model_text(hip=0.08, thigh=0.41, shank="0 -0.4 0", new=False, knee="walker_knee"):
    """A model's file as OpenSim writes it since version 4, or as it did before."""
    rows = [("hip", "pelvis", f"-0.06 -0.08 {hip}"), (knee, "femur", f"0 {-thigh} 0"),
            ("ankle", "tibia", shank)]  # fmt: skip
    made = []
    for side in "rl":
        for joint, body, place in rows:
            place = place.replace(f" {hip}", f" {-hip}") if side == "l" else place
            if new:
                inner = (
                    f"<socket_parent_frame>{body}_offset</socket_parent_frame><frames>"
                    f'<PhysicalOffsetFrame name="{body}_offset"><translation>{place}</translation>'
                    f'</PhysicalOffsetFrame><PhysicalOffsetFrame name="below_offset"><translation>'
                    f"9 9 9</translation></PhysicalOffsetFrame></frames>"
                )
            else:
                inner = f"<location_in_parent>{place}</location_in_parent><location>9 9</location>"
            made.append(f'<CustomJoint name="{joint}_{side}">{inner}</CustomJoint>')
    return f"<OpenSimDocument><Model>{''.join(made)}</Model></OpenSimDocument>"


@pytest.mark.parametrize("new", [False, True])
def test_sizes_of_a_model(new, tmp_path):
    file = tmp_path / "own.osim"
    file.write_text(model_text(new=new, knee="knee" if new else "walker_knee"))
    found = read_model(file)
    assert found.hips == pytest.approx([-0.06, -0.08, 0.0]) and found.width == pytest.approx(0.16)
    assert found.thighs == pytest.approx([0.41] * 2) and found.shanks == pytest.approx([0.4] * 2)
    scales = found.scales(0.2, np.array([0.41, 0.451]), np.array([0.44, 0.4]))
    assert scales == pytest.approx({"pelvis z": 1.25, "femur_r y": 1.0, "tibia_r y": 1.1,
                                    "femur_l y": 1.1, "tibia_l y": 1.0})  # fmt: skip


@pytest.mark.parametrize(
    "text, words",
    [
        ("no xml", "is no OpenSim model"),
        (model_text(knee="knie"), "has no joint knee_r or walker_knee_r"),
        (model_text(shank="0 -0.4"), "does not say where its joint ankle_r is"),
        (model_text(shank="0 nan 0", new=True), "does not say where its joint ankle_r is"),
        (model_text(thigh=410), "must be in metres"),
    ],
)
def test_files_that_are_no_model(text, words, tmp_path):
    file = tmp_path / "own.osim"
    file.write_text(text)
    with pytest.raises(ValueError, match=words):
        read_model(file)
    file.unlink()
    with pytest.raises(ValueError, match="there is no model"):
        read_model(file)


def test_fit_is_exact_where_it_can_be():
    q, rate = np.random.default_rng(1).uniform(-0.3, 1.9, (2, 60))
    tau = 0.3 - 0.2 * q + 0.1 * q**2 + 0.05 * q**3 - 0.07 * rate
    found = fit(tau, q, rate, np.ones(60))
    assert found.a == pytest.approx([0.3, -0.2, 0.1, 0.05]) and found.b == pytest.approx(-0.07)
    assert found.left < 1e-12 * found.size
    at = {"q": 0.4, "qdot": 2.0, "min": min, "max": max}
    wanted = 0.3 - 0.08 + 0.016 + 0.0032 - 0.14
    assert eval(found.expression(), at) == pytest.approx(wanted)  # Python spells it alike
    assert fit(tau, q, rate + 10 * (q > 1) * np.sign(rate), np.ones(60)).left > 1e-3


def test_command(run, capsys):
    """Files in OUT/opensim, told with what the fits leave over; nothing but whole runs is taken."""
    out, *_ = run
    __main__.main(["export", str(out), "--to", "opensim"])
    said = capsys.readouterr().out
    assert "left over" in said and "knee_angle_r" in said
    for name in FILES:
        assert (out / "opensim" / name).is_file()
    top = ElementTree.parse(out / "opensim" / "external_loads.xml").getroot()
    assert top.findtext(".//datafile") == "external_loads.mot"
    with pytest.raises(ValueError, match="no complete run"):
        export(out / "opensim", out / "nowhere")
    with pytest.raises(ValueError, match=r"rajagopal and gait2392, not 'hamner'"):
        export(out, out / "nowhere", "hamner")
    assert not (out / "nowhere").exists()


def interpreter():
    """A Python that has OpenSim: this one, or that of OPENSIM_PYTHON."""
    for path in filter(None, (sys.executable, os.environ.get("OPENSIM_PYTHON"))):
        if subprocess.run([path, "-c", "import opensim"], capture_output=True).returncode == 0:
            return path
    pytest.skip("no OpenSim: name a Python with `pip install opensim` in OPENSIM_PYTHON")


def test_inverse_dynamics_with_and_without(run, tmp_path):
    """OpenSim loads all of it, and the torques it finds differ by ours, to 1 % of their peak."""
    python = interpreter()
    out, wearer, _ = run
    found = export(out, tmp_path, "gait2392")  # whose knees turn about z
    points = wearer.recording.points
    body = {"forces": len(found["fits"])}
    for side in ("right", "left"):
        thigh, shank = points[f"{side}_thigh"][0], points[f"{side}_shank"][0]
        half = np.linalg.norm(thigh[0] - points["pelvis"][0, 1])
        body[f"hip_{side[0]}"] = [*HIPS["gait2392"][:2], float(half if side == "right" else -half)]
        body[f"knee_{side[0]}"] = [0.0, -float(np.linalg.norm(thigh[1] - thigh[0])), 0.0]
        body[f"ankle_{side[0]}"] = [0.0, -float(np.linalg.norm(shank[1] - shank[0])), 0.0]
    (tmp_path / "body.json").write_text(json.dumps(body))
    script = Path(__file__).with_name("opensim_program.py")
    done = subprocess.run([python, script, tmp_path], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    change = json.loads((tmp_path / "change.json").read_text())
    assert {j.split("_")[1] for j in JOINTS} == {"hip", "knee", "ankle"}
    for name, torque in found["torques"].items():
        ours = np.interp(change["time"], found["times"], torque)
        # what the clothing does the muscles need not do
        gap = np.abs(np.array(change[name]) + ours).max()
        assert gap < 1e-2 * np.abs(ours).max(), name
