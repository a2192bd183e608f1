# SPDX-License-Identifier: LGPL-3.0-or-later
"""From files of markers to torques: what is told on the way, and in whose words it is refused."""

import numpy as np
import pytest

from demos import walk as demo
from shellform import __main__, console
from shellform.scene.parts import Garment, Motion, Steps
from shellform.scene.scene import Scene
from shellform.simulation.check import check
from shellform.simulation.run import run
from tests.motion.capture.c3d_bytes import write_c3d_bytes
from tests.motion.capture.made_up import (
    BMC,
    CMU,
    GAIT2392,
    HELEN_HAYES,
    IOR,
    PLUG_IN,
    PLUG_IN_MARKERS,
    POSE2SIM,
    walker,
    write_trc,
    y_up,
)
from tests.motion.capture.test_static_trial import trials

pytestmark = pytest.mark.serial

SETS = {
    "ior": IOR,
    "helen-hayes": HELEN_HAYES,
    "plug-in-gait": PLUG_IN,
    "plug-in-gait-markers": PLUG_IN_MARKERS,
    "cmu": CMU,
    "joint-centres": POSE2SIM,
}
COARSE = Garment(cell_size=0.04)


def theia(folder):
    """A C3D file of poses, their z up the segment and x to the right."""
    names, tracks, truth = walker(POSE2SIM)
    poses = {}
    for side in ("right", "left"):
        toe = tracks[:, names.index(f"{side[0].upper()}BigToe")]
        ends = [*(truth[side][joint] for joint in ("hip", "knee", "ankle")), toe]
        ends.append(2 * toe - ends[2])
        for part, a, b in zip(("thigh", "shank", "foot", "toes"), ends, ends[1:]):
            pose = np.tile(np.eye(4), (len(a), 1, 1))
            z = (a - b) / np.linalg.norm(a - b, axis=1, keepdims=True)
            x = np.tile([0.0, -1.0, 0.0], (len(a), 1))
            pose[:, :3, :3] = np.stack([x, np.cross(z, x), z], axis=2)
            pose[:, :3, 3] = 1000 * a
            poses[f"{side[0]}_{part}_4X4"] = pose
    blank = np.zeros((len(tracks), 0, 3))
    return write_c3d_bytes(folder / "theia.c3d", [], blank, poses=poses)


# in every run those that differ most: markers, joint centres, poses
QUICK = ("joint-centres",)
KEYS = [pytest.param(k, marks=() if k in QUICK else pytest.mark.thorough) for k in [*SETS, "theia"]]


@pytest.mark.slow
@pytest.mark.parametrize("key", KEYS)
def test_from_file_to_torque(tmp_path, key, capsys):
    """Every set: trousers on the walker, torques of loose trousers, notes printed."""
    if key == "theia":
        pytest.importorskip("ezc3d", reason="C3D files are read by ezc3d, not installed here")
        path = theia(tmp_path)
    else:
        names, tracks, _ = walker(SETS[key])
        path = write_trc(tmp_path / "walk.trc", names, 1000 * y_up(tracks))
    motion = Motion(file=str(path), start=1.0, end=1.1, initiation=0.4)
    results = run(Scene(motion=motion, garment=COARSE, steps=Steps(runs=1)), tmp_path / "out")
    peaks = [abs(joint["peak_torque"]) for joint in results["joints"].values()]
    assert len(peaks) == 6 and np.isfinite(peaks).all()
    assert 1e-3 < max(peaks) < 5.0  # loose trousers: 0.1 to 2 N m, see the notes on motion
    assert f"map '{key}'" in capsys.readouterr().out


def test_check_prints_what_was_chosen(tmp_path):
    names, tracks, _ = walker(IOR)
    path = write_trc(tmp_path / "walk.trc", names, 1000 * y_up(tracks))
    motion = Motion(file=str(path), start=1.0, end=1.2, initiation=0.4)
    lines = "\n".join(check(Scene(motion=motion, garment=COARSE)))
    assert "map 'ior'" in lines and "all 22 labels belong to the set" in lines


def gappy(folder):
    names, tracks, _ = walker(BMC)
    tracks[50:70, names.index("R.Knee")] = np.nan
    tracks[60:95, names.index("L.Ankle")] = np.nan
    return write_trc(folder / "walk.trc", names, 1000 * tracks)


def test_a_refusal_in_the_words_of_a_scene(tmp_path, capsys, monkeypatch):
    """All gaps, keys of [motion], the file as the user called it."""
    gappy(tmp_path)
    (tmp_path / "scene.toml").write_text('[motion]\nfile = "walk.trc"\n')
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit):
        console.run(__main__.main, ["check", "scene.toml"])
    said = capsys.readouterr().err
    assert ": walk.trc: marker 'R.Knee' lacks from t = 0.500 s" in said and "'L.Ankle'" in said
    assert "raise max_gap_s = 0.351" in said and "with start_s and end_s" in said
    assert said.count("\n") == 1


def test_a_refusal_in_the_words_of_the_walk(tmp_path, capsys):
    """Options of demos/walk.py, which has them."""
    path = gappy(tmp_path)
    with pytest.raises(SystemExit):
        console.run(
            demo.main,
            ["--motion", str(path), "--runs", "1", "--out", str(tmp_path / "out")],
            words=demo.WORDS,
        )
    said = capsys.readouterr().err
    assert "raise --max-gap 0.351" in said and "--start and --seconds" in said
    options = demo.arguments(
        ["--motion", str(path), "--max-gap", "0.351", "--start", "1", "--unit", "mm", "--up", "z"]
    )
    motion = demo.scene_of(options, "compliant").motion
    assert (motion.max_gap, motion.start, motion.unit, motion.up) == (0.351, 1.0, "mm", "z")
    flags = {word.split()[0] for word in demo.WORDS.values()}
    for flag in flags:
        assert hasattr(options, flag.removeprefix("--").replace("-", "_")), flag


def test_a_static_trial_of_a_scene(tmp_path):
    """`static` under [motion], relative to the scene's file."""
    trials(tmp_path, GAIT2392)
    text = '[motion]\nfile = "walk.trc"\nstatic = "standing.trc"\ninitiation_s = 0.4\nend_s = 0.2\n'
    (tmp_path / "scene.toml").write_bytes(b"\xef\xbb\xbf" + text.encode())
    lines = "\n".join(check(tmp_path / "scene.toml"))
    assert "carried from" in lines and "map 'medial'" in lines
