# SPDX-License-Identifier: LGPL-3.0-or-later
"""Markers of a static trial carried into a walk by clusters, against a walker known beforehand."""

import numpy as np
import pytest

from shellform.motion.capture.cluster_fit import carried
from shellform.motion.capture.read_motion import read_markers, read_motion, recording
from shellform.motion.capture.static_trial import with_static
from tests.motion.capture.made_up import (
    GAIT2392,
    HELEN_HAYES,
    TAKEN_OFF,
    WRITERS,
    walker,
    write_trc,
    y_up,
)
from tests.motion.capture.test_exports import motive, nexus, qtm

EXACT = 1e-4  # m; the bar is 0.1 mm


def trials(folder, labels, off=TAKEN_OFF, seed=0, noise=0.0, **motion):
    """Files of a static trial, turned and swaying elsewhere, and of a walk without `off`."""
    names, tracks, truth = walker(labels, **motion)
    _, standing, _ = walker(labels, seconds=0.5, speed=0.02)
    angle = 0.7
    turn = np.array(
        [[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]]
    )
    standing = standing @ turn.T + [3.0, -2.0, 0.0]
    rng = np.random.default_rng(seed)
    walking = tracks + rng.normal(0.0, noise, tracks.shape) if noise else tracks
    gone = {labels[key].replace("{S}", s) for key in off if key in labels for s in "RL"}
    keep = [k for k, name in enumerate(names) if name not in gone]
    static = write_trc(folder / "standing.trc", names, 1000 * y_up(standing))
    walk = write_trc(folder / "walk.trc", [names[k] for k in keep], 1000 * y_up(walking[:, keep]))
    return walk, static, truth


@pytest.mark.parametrize("twist", [0.0, np.radians(10)])
def test_knees_and_ankles_by_clusters(tmp_path, twist):
    """gait2392: no marker at knee or ankle in the walk, three on thigh and shank: 0.1 mm."""
    walk, static, truth = trials(tmp_path, GAIT2392, twist=twist)
    rec = read_motion(walk, static, cutoff=None, rigid=False)
    assert "map 'medial'" in rec.notes
    assert sum("carried from" in note for note in rec.notes) == 4
    for side in ("right", "left"):
        for joint in ("hip", "knee", "ankle"):
            off = rec.joint_centre(f"{side}_{joint}") - truth[side][joint]
            assert np.linalg.norm(off, axis=1).max() < EXACT, (side, joint)
        assert f"{side}_foot" in rec.points


@pytest.mark.parametrize("ending", ["trc", "csv", "c3d", "motive.csv", "nexus.csv", "qtm.tsv"])
def test_a_static_trial_of_one_frame(tmp_path, ending):
    """Exported as a mean of its frames: read from every format of markers, and no motion by
    itself."""
    walk, _, truth = trials(tmp_path, GAIT2392)
    names, tracks, _ = walker(GAIT2392, seconds=0.01)
    path, unit = tmp_path / f"standing.{ending}", 1000.0
    if ending in WRITERS:
        WRITERS[ending](path, names, unit * tracks, unit="mm")
    else:
        text = {"motive.csv": motive, "nexus.csv": nexus, "qtm.tsv": qtm}[ending](names, tracks)
        path.write_text(text, newline="")
    assert len(read_markers(path).times) == 1
    rec = read_motion(walk, path, cutoff=None, rigid=False)
    for joint in ("right_knee", "left_ankle"):
        side, name = joint.split("_")
        assert np.linalg.norm(rec.joint_centre(joint) - truth[side][name], axis=1).max() < EXACT
    with pytest.raises(ValueError, match=r"one frame is no motion.*static="):
        read_motion(path)


def test_a_marker_of_the_midfoot_is_none_of_the_shank(tmp_path):
    """It lies 80 mm beside the ankle and hardly moves against the shank while a foot is flat, as in
    the first frames of gait2392's walk: the ankle would follow the foot."""
    labels = {**GAIT2392, "midfoot": "{S}.Midfoot.Sup"}
    walk, _, truth = trials(tmp_path, labels, seconds=0.06)
    names, tracks, _ = walker(labels, seconds=0.01)
    static = write_trc(tmp_path / "standing.trc", names, 1000 * y_up(tracks))
    rec = read_motion(walk, static, cutoff=None, rigid=False)
    by = [n.split(" by ")[1] for n in rec.notes if n.startswith("R.Ankle.Lat")]
    assert by and "Midfoot" not in by[0], by
    off = rec.joint_centre("right_ankle") - truth["right"]["ankle"]
    assert np.linalg.norm(off, axis=1).max() < EXACT


def test_clusters_with_noise_and_gaps(tmp_path):
    """1 mm of noise in each marker, one of a cluster lost for a while and a fourth one beside it:
    no more at the joints than the lever of the cluster makes of it."""
    labels = {**GAIT2392, "t4": "{S}.Thigh.Fourth"}
    walk, static, truth = trials(tmp_path, labels, noise=1e-3)
    text = walk.read_text().splitlines()
    column = 2 + 3 * [c for c in text[3].split("\t")[2:] if c].index("R.Thigh.Front")
    for k in range(106, 186):
        cells = text[k].split("\t")
        cells[column : column + 3] = ["", "", ""]
        text[k] = "\t".join(cells)
    walk.write_text("\n".join(text) + "\n")
    rec = read_motion(walk, static, cutoff=None, rigid=False)
    for joint in ("right_knee", "left_knee"):
        side, name = joint.split("_")
        off = np.linalg.norm(rec.joint_centre(joint) - truth[side][name], axis=1)
        assert np.sqrt(np.mean(off**2)) < 6e-3
    assert len(rec.times) == 350


def test_two_markers_and_the_joint_above(tmp_path):
    """Helen Hayes: a wand and the lateral marker stay on, the medial one is taken off."""
    labels = {**HELEN_HAYES, "knee_in": "{S}.Knee.Medial", "ankle_in": "{S}.Ankle.Medial"}
    walk, static, truth = trials(tmp_path, labels, ("knee_in", "ankle_in"), twist=np.radians(10))
    rec = read_motion(walk, static, cutoff=None, rigid=False)
    assert any("and the joint above" in note for note in rec.notes)
    for side in ("right", "left"):
        for joint in ("knee", "ankle"):
            off = rec.joint_centre(f"{side}_{joint}") - truth[side][joint]
            assert np.linalg.norm(off, axis=1).max() < EXACT, (side, joint)


def test_what_a_static_trial_cannot_carry(tmp_path):
    """Limbs with one marker; labels mixed up; a set that both together lack."""
    few = {k: v for k, v in GAIT2392.items() if k not in ("t2", "t3", "s2", "s3")}
    walk, static, _ = trials(tmp_path, few)
    with pytest.raises(ValueError, match=r"walk\.trc: .*standing\.trc alone.*three are needed"):
        read_motion(walk, static)
    walk, static, _ = trials(tmp_path, GAIT2392)
    text = static.read_text()
    swap = {"R.Thigh.Upper": "R.Shank.Upper", "R.Shank.Upper": "R.Thigh.Upper"}
    head = text.splitlines()
    head[3] = "\t".join(swap.get(c, c) for c in head[3].split("\t"))
    static.write_text("\n".join(head) + "\n")
    with pytest.raises(ValueError, match=r"walk\.trc.*standing\.trc"):
        read_motion(walk, static)
    few = {k: v for k, v in GAIT2392.items() if not k.startswith("knee")}
    walk, static, _ = trials(tmp_path, few)
    with pytest.raises(ValueError, match="no shipped map fits") as error:
        read_motion(walk, static)
    assert "a static trial" not in str(error.value)


def test_markers_that_are_in_both_stay_as_they_are(tmp_path):
    """A static trial with nothing more changes nothing."""
    walk, static, _ = trials(tmp_path, GAIT2392, ())
    markers = read_markers(walk)
    both = with_static(markers, read_markers(static))
    assert both.names == markers.names
    assert np.array_equal(both.positions, markers.positions)


def test_a_real_walk_without_its_knees(paper_data):
    """BMC walk without its medial markers, its first half the static trial: skin moves, thighs have
    but a trochanter, and the joints stay within 15 mm of those of all markers."""
    markers = read_markers(paper_data / "bmc_walk2.trc")
    truth = recording(markers, cutoff=None, rigid=False)
    gone = [n for n in markers.names if "Medial" in n]
    keep = [k for k, n in enumerate(markers.names) if n not in gone]
    walk = type(markers)(
        tuple(markers.names[k] for k in keep),
        markers.times,
        markers.positions[:, keep],
        markers.rate,
        "walk",
    )
    half = len(markers.times) // 2
    static = type(markers)(
        markers.names, markers.times[:half], markers.positions[:half], markers.rate, "standing"
    )
    rec = recording(with_static(walk, static), cutoff=None, rigid=False)
    for joint in ("right_knee", "left_knee", "right_ankle", "left_ankle"):
        off = np.linalg.norm(rec.joint_centre(joint) - truth.joint_centre(joint), axis=1)
        assert np.median(off) < 0.015, joint


def test_a_turned_cluster_carries_its_marker():
    """`carried` against turns and shifts known beforehand, one marker missing at times."""
    rng = np.random.default_rng(5)
    shape, marker = rng.normal(size=(5, 3)), rng.normal(size=3)
    angle = np.linspace(0.0, 3.0, 40)
    turn = np.zeros((40, 3, 3))
    turn[:, 1, 1] = 1.0
    turn[:, 0, 0] = turn[:, 2, 2] = np.cos(angle)
    turn[:, 0, 2], turn[:, 2, 0] = np.sin(angle), -np.sin(angle)
    shift = rng.normal(size=(40, 3))
    walking = np.einsum("nab,kb->nka", turn, shape) + shift[:, None]
    truth = turn @ marker + shift
    walking[10:20, 2] = np.nan
    walking[30, :3] = np.nan
    standing = np.tile(shape, (3, 1, 1)) + rng.normal(size=(3, 1, 3))
    track, rms = carried(marker + (standing - shape)[:, 0], standing, walking)
    assert np.isnan(track[30]).all()
    seen = np.arange(40) != 30
    assert np.abs(track - truth)[seen].max() < 1e-12 and rms < 1e-12
