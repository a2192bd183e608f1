# SPDX-License-Identifier: LGPL-3.0-or-later
"""A dressed wearer walks: forces add up, torques turn with the scene, files are complete.

The walk is short: out of the second stride of the synthetic walk, with a quick way into it. Cloth
that folds is chaotic: a difference of roundoff grows some hundredfold in 20 ms where it is relaxed,
so two runs that are equal but for roundoff, which settle for 0.1 s before, are compared for 60 ms,
to a hundredth; what they are compared with differs by a tenth at least.
"""

import json
import re
from functools import partial

from mpi4py import MPI

import numpy as np
import pytest

from shellform.fem.director import rotation_matrix
from shellform.motion.gait.synthetic_walk import synthetic_walk
from shellform.results.joint_torque import COLUMNS, rows_until
from shellform.scene.garment import garment_of
from shellform.scene.wearer import wearer_of
from shellform.simulation.figures import draw
from shellform.simulation.run import run as run_scene
from shellform.simulation.summary import summary_lines
from tests.dressing.test_dress import dressed
from tests.scene.test_wearer_and_garment import turned
from tests.simulation.short_walk import JOINTS, WALK, contact_forces, table, torques, vectors

COMM = MPI.COMM_WORLD


def test_forces_balance(walked):
    """In every window contact gives the weight and the change of momentum: 0.5 % of the weight.

    The belt is a closed cable: it gives nothing in sum.
    """
    out, results, _ = walked
    rows = table(out / "ledger.csv")
    names = wearer_of(WALK).names
    t, p = np.array([row["time"] for row in rows]), vectors(rows, "momentum")
    needed = np.diff(p, axis=0) / np.diff(t)[:, None] + [0.0, 0.0, results["weight"]]
    off = np.abs(contact_forces(rows, names)[1:] - needed).max() / results["weight"]
    moved = np.abs(needed[:, :2]).max() / results["weight"]
    print(f"forces balance to {100 * off:.3f} % of the weight; accelerations to {moved:.2f} g")
    assert off < 0.005 < 0.1 < moved
    assert results["force_balance_error"] < 1e-6
    surface = garment_of(WALK, wearer_of(WALK))
    corners = surface.points[surface.cells]
    one, other = np.roll(corners, -1, axis=1) - corners, np.roll(corners, 1, axis=1) - corners
    area = 0.25 * np.linalg.norm(np.cross(one, other), axis=2).sum()
    assert results["weight"] == pytest.approx(9.81 * 0.21 * area, rel=1e-9)


def test_segments_get_what_nodes_give(walked):
    """Wrenches of the segments are the forces of the frames, and give the torques of the file."""
    meshio = pytest.importorskip("meshio")
    out, results, watched = walked
    rows, wearer = table(out / "ledger.csv"), wearer_of(WALK)
    whole = contact_forces(rows, wearer.names)
    times = np.array([row["time"] for row in rows])
    frames = re.findall(r'timestep="(.*?)".*file="(.*?)"', (out / "series.pvd").read_text())
    assert len(frames) == 7 and watched == ["walk"] * 6  # the first frame is that of the dressed
    for at, file in frames[1:]:
        data = meshio.read(out / file).point_data
        k = np.abs(times - float(at)).argmin()
        size = np.abs(data["contact_force"]).sum()
        assert np.abs(data["contact_force"].sum(axis=0) - whole[k]).max() < 1e-9 * size
        assert (data["contact_pressure"] >= 0).all()
    # about joints that move by 20 mm in a window: to 1 % of the largest
    found, start, mine = torques(out), wearer.start, []
    for row in rows:
        middle = 0.5 * (start + row["time"])
        pose, joints, start = wearer.new_pose(middle), wearer.new_joints(middle), row["time"]
        for joint, centre in zip(wearer.joints, joints.centres, strict=True):
            torque = np.zeros(3)
            for name in results["parts"][joint]:
                force, moment = (vectors([row], f"{k}_{name}")[0] for k in ("force", "moment"))
                torque -= moment + np.cross(pose.centres[wearer.index(name)] - centre, force)
            mine.append(torque)
    mine = np.reshape(mine, (-1, 6, 3))
    assert np.abs(mine - found[:, :, :3]).max() < 0.01 * np.abs(found).max()


def test_files_of_a_run(walked):
    """torque.csv, ledger.csv, series, checkpoint, dressed state, summary.json with its keys."""
    out, results, _ = walked
    wearer = wearer_of(WALK)
    rows = rows_until(out / "torque.csv", np.inf)
    assert tuple(rows[0]) == COLUMNS
    assert len(rows) == 6 * round((wearer.end - wearer.start) / WALK.output.window)
    assert rows[-1]["time"] == pytest.approx(1.7, abs=1e-9)
    for name in ("scene.toml", "checkpoint.npz", "dressed.npz"):
        assert (out / name).is_file()
    assert not list(out.glob("*.part*"))
    summary = json.loads((out / "summary.json").read_text())
    for key in (
        "scene", "plan", "settings", "ranks", "cells", "nodes", "dofs", "steps", "time_step",
        "newton_iterations", "seconds", "peak_memory_mb", "versions", "results",
    ):  # fmt: skip
        assert key in summary
    assert set(summary["seconds"]) >= {"setup", "compile", "assemble", "solve", "contact", "total"}
    assert summary["ranks"] == COMM.size and summary["dofs"] == 5 * summary["nodes"]
    found = summary["results"]
    for key in (
        "max_penetration", "force_balance_error", "strides", "stride_length", "parts", "window",
        "dressing", "pinched_most", "notes", "weight", "counted_s",
    ):  # fmt: skip
        assert key in found
    assert list(found["joints"]) == JOINTS
    assert found["counted_s"] == pytest.approx([1.5, 1.7], abs=1e-9)
    assert found["strides"] == {"right": [], "left": []}
    assert found["window"] == 0.02 and found["parts"]["left_knee"] == ["left_shank", "left_foot"]
    assert found["stride_length"] == pytest.approx(1.32)
    for joint, numbers in found["joints"].items():
        # the way into the walk counts for nothing
        mine = [row for row in rows if row["joint"] == joint and row["time"] > 1.5 + 1e-6]
        assert len(mine) == 10
        flexion = np.array([row["torque_flexion"] for row in mine])
        assert abs(numbers["peak_torque"]) == pytest.approx(np.abs(flexion).max(), rel=1e-9)
        assert numbers["rms_torque"] == pytest.approx(np.sqrt(np.mean(flexion**2)), rel=1e-6)
        power = np.array([row["power"] for row in mine])
        assert numbers["work"] == pytest.approx(power.sum() * 0.02, rel=1e-6, abs=1e-12)
        assert numbers["resistance"] >= max(0.0, -numbers["work"]) - 1e-12
    lines = "\n".join(summary_lines(results))
    assert "right_knee" in lines and "% of the weight" in lines


@pytest.mark.serial
@pytest.mark.slow
def test_pictures_when_asked(walked):
    """Of the files of a run alone; the run itself has drawn nothing."""
    out, _, _ = walked
    assert not list(out.glob("*.png")) + list(out.glob("*.gif"))
    draw(out)
    for name in ("walk.png", "torque.png", "wrinkles.png"):
        assert (out / name).read_bytes()[:4] == b"\x89PNG"
    assert (out / "walk.gif").read_bytes()[:3] == b"GIF"


@pytest.fixture
def walks(monkeypatch, tmp_path):
    """Function: torques of a run whose synthetic walk is made by another function."""

    def run(make, state):
        monkeypatch.setattr("shellform.scene.wearer.synthetic_walk", make)
        run_scene(WALK, tmp_path, COMM, state)
        return torques(tmp_path)

    return run


def compared(what, one, other):
    """Differences of the windows over the largest torque; asserts the first three: 1e-2."""
    size = np.abs(one[:3]).max()
    off = np.abs(one - other).max(axis=(1, 2)) / size
    print(f"{what}: largest torque {size:.3f} N m; windows differ by", *(f"{x:.0e}" for x in off))
    assert size > 0.05
    assert off[:3].max() < 1e-2


@pytest.mark.serial
@pytest.mark.slow
@pytest.mark.thorough
def test_turned_walk(walked, walks):
    """In another place and direction: world components turn, those about the joints' axes stay."""
    angle, shift = 2.3, (4.0, -3.0)
    found = walks(
        lambda **kinds: turned(synthetic_walk(**kinds), angle, shift), dressed("compliant").path
    )
    plain = torques(walked[0])
    turn = rotation_matrix([0.0, 0.0, angle])
    compared("turned", np.dstack([plain[:, :, :3] @ turn.T, plain[:, :, 3]]), found)
    assert (
        np.abs(plain[:5, :, :3] @ turn.T - plain[:5, :, :3]).max() > 0.1 * np.abs(plain[:3]).max()
    )


@pytest.mark.serial
@pytest.mark.slow
def test_mirrored_walk(walked, walks, tmp_path):
    """The left foot first, in trousers draped the other way round: left and right change places."""
    with np.load(dressed("compliant").path) as file:
        state = dict(file)
    mirror = np.array([1.0, -1.0, 1.0])
    twin = np.linalg.norm(state["rest"][:, None] - state["rest"] * mirror, axis=2)
    assert twin.min(axis=1).max() < 1e-12
    for name in ("positions", "directors"):
        state[name] = state[name][twin.argmin(axis=1)] * mirror
    np.savez(tmp_path / "mirrored.npz", **state)
    found = walks(partial(synthetic_walk, first="left"), tmp_path / "mirrored.npz")
    plain = torques(walked[0])
    # a torque is an axial vector
    compared("mirrored", plain[:, [3, 4, 5, 0, 1, 2]] * [-1, 1, -1, 1], found)
    assert np.abs(plain[:3] - plain[:3, [3, 4, 5, 0, 1, 2]]).max() > 0.1 * np.abs(plain[:3]).max()
