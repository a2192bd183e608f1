# SPDX-License-Identifier: LGPL-3.0-or-later
"""Which marker set a capture has, and joint centres of a known walker in each of them."""

import numpy as np
import pytest

from shellform.motion.capture.marker_sets import choose_map
from shellform.motion.capture.read_motion import read_markers, read_motion
from shellform.motion.capture.segment_map import SHIPPED, plain, segment_map, vocabulary
from tests.motion.capture.c3d_bytes import write_c3d_bytes
from tests.motion.capture.made_up import (
    BMC,
    CMU,
    HELEN_HAYES,
    IOR,
    KINECT,
    LATERAL,
    OPENCAP,
    PLUG_IN,
    PLUG_IN_MARKERS,
    POSE2SIM,
    RAJAGOPAL,
    SKELETON,
    walker,
    write_trc,
    y_up,
)

JOINTS = ("hip", "knee", "ankle")
SETS = {
    "ior": (IOR, "ior"),
    "helen-hayes": (HELEN_HAYES, "helen-hayes"),
    "plug-in-gait without model points": (PLUG_IN_MARKERS, "plug-in-gait-markers"),
    "cmu": (CMU, "cmu"),
    "pose2sim": (POSE2SIM, "joint-centres"),
    "kinect": (KINECT, "joint-centres"),
    "skeleton": (SKELETON, "skeleton"),
}


def off(rec, truth, side, joint):
    """Largest distance of a joint's centre from where it is [m]."""
    return np.linalg.norm(rec.joint_centre(f"{side}_{joint}") - truth[side][joint], axis=1).max()


@pytest.mark.parametrize("key", SETS)
def test_joint_centres_of_a_set(tmp_path, key):
    """To 1e-9 m: the walker has the published pelvis, and widths of joints that the maps take."""
    labels, name = SETS[key]
    names, tracks, truth = walker(labels)
    rec = read_motion(write_trc(tmp_path / "walk.trc", names, 1000 * y_up(tracks)), cutoff=None)
    assert f"map '{name}'" in rec.notes
    assert f"all {len(names)} labels belong to the set" in rec.notes
    for side in ("right", "left"):
        for joint in JOINTS:
            assert off(rec, truth, side, joint) < 1e-9, (side, joint)
        foot = rec.points[f"{side}_foot"]
        heel = truth[side]["ankle"] + [-0.05, 0.0, -0.06]
        assert np.linalg.norm(foot[:, 0] - heel, axis=1).max() < 0.02
    assert rec.facts["stride_length"] == pytest.approx(1.2, rel=0.02)
    assert rec.facts["heading"] == pytest.approx(0.0, abs=1e-6)


def test_opencap_beside_the_joints_it_was_computed_from(tmp_path):
    """`RKnee` is a joint centre there, though in other sets it is the lateral marker; the joints
    are moved by 30 mm, and only the augmented markers may count."""
    names, tracks, truth = walker(OPENCAP)
    more, joints, _ = walker(POSE2SIM)
    both = np.concatenate([tracks, joints + [0.03, 0.0, 0.0]], axis=1)
    path = write_trc(tmp_path / "walk.trc", names + more, y_up(both), unit="m")
    rec = read_motion(path, cutoff=None, rigid=False)
    assert "map 'opencap'" in rec.notes
    for side in ("right", "left"):
        for joint in JOINTS:
            assert off(rec, truth, side, joint) < 1e-9, (side, joint)
    rec = read_motion(path, map="joint-centres", cutoff=None, rigid=False)
    for side in ("right", "left"):
        for joint in JOINTS:
            assert off(rec, truth, side, joint) == pytest.approx(0.03, abs=1e-9)
    assert any("RKnee" in note and "taken for joint centres" in note for note in rec.notes)


@pytest.mark.parametrize("twist", [0.0, np.radians(10)])
def test_theia_poses_of_segments(tmp_path, twist):
    """C3D of rotations: origins are the joints, and M turns with the thigh about itself."""
    names, tracks, truth = walker(RAJAGOPAL | POSE2SIM, twist=twist, seconds=2.0)
    poses = {}
    for side, sign in (("right", 1.0), ("left", -1.0)):
        S, s = side[0].upper(), side[0]
        lateral = tracks[:, names.index(f"{S}.Knee")] - truth[side]["knee"]
        for part, start, end in (
            ("thigh", truth[side]["hip"], truth[side]["knee"]),
            ("shank", truth[side]["knee"], truth[side]["ankle"]),
            ("foot", truth[side]["ankle"], tracks[:, names.index(f"{S}BigToe")]),
            ("toes", tracks[:, names.index(f"{S}BigToe")], truth[side]["ankle"]),
        ):
            z = (start - end) / np.linalg.norm(start - end, axis=1, keepdims=True)
            right = sign * lateral if part == "thigh" else np.tile([0.0, -1.0, 0.0], (len(z), 1))
            y = np.cross(z, right)
            y /= np.linalg.norm(y, axis=1, keepdims=True)
            pose = np.tile(np.eye(4), (len(z), 1, 1))
            pose[:, :3, :3] = np.stack([np.cross(y, z), y, z], axis=2)
            pose[:, :3, 3] = 1000 * start
            poses[f"{s}_{part}_4X4"] = pose
    trunk = np.tile(np.eye(4), (len(tracks), 1, 1))
    trunk[:, :3, 3] = 1000 * tracks[:, names.index("Neck")]
    poses["neck_4X4"] = trunk
    poses["worldbody_4X4"] = np.tile(np.eye(4), (len(tracks), 1, 1))
    path = write_c3d_bytes(tmp_path / "walk.c3d", [], np.zeros((len(tracks), 0, 3)), poses=poses)
    rec = read_motion(path, cutoff=None, rigid=False)
    assert "map 'theia'" in rec.notes
    for side in ("right", "left"):
        for joint in JOINTS:
            assert off(rec, truth, side, joint) < 1e-6
        S = side[0].upper()
        lateral = tracks[:, names.index(f"{S}.Knee")] - truth[side]["knee"]
        found = rec.points[f"{side}_thigh"][:, 2] - truth[side]["knee"]
        cosine = np.sum(found * lateral, axis=1) / np.linalg.norm(found, axis=1)
        assert (cosine / np.linalg.norm(lateral, axis=1)).min() > 1 - 1e-6


def test_model_points_and_markers_of_plug_in_gait(tmp_path):
    """With and without its model points the walker's recording is the same to 1e-12 m, and so is
    what the clothing is moved by; which are used is told (test_label_families.py)."""
    names, tracks, _ = walker(PLUG_IN)
    keep = [k for k, n in enumerate(names) if not n.endswith(("FEP", "FEO", "TIO"))]
    points = read_motion(write_trc(tmp_path / "points.trc", names, 1000 * tracks))
    markers = [names[k] for k in keep]
    alone = read_motion(write_trc(tmp_path / "markers.trc", markers, 1000 * tracks[:, keep]))
    assert "map 'plug-in-gait'" in points.notes and "map 'plug-in-gait-markers'" in alone.notes
    assert points.points.keys() == alone.points.keys()
    for segment, track in points.points.items():
        assert np.abs(alone.points[segment] - track).max() < 1e-12, segment


def test_what_one_label_is_taken_for_is_told(tmp_path):
    """`R.Knee` on the skin of BMC, at the centre in Pose2Sim: told in both."""
    for labels, word in ((BMC, "markers"), (POSE2SIM, "joint centres")):
        names, tracks, _ = walker(labels, seconds=1.5)
        notes = read_motion(write_trc(tmp_path / "walk.trc", names, 1000 * tracks)).notes
        assert any("Knee" in note and f"taken for {word}" in note for note in notes), word


def test_trochanters_are_no_hip_centres(tmp_path):
    """Labels of a markerless program at hips 0.34 m apart: refused, not taken for centres."""
    names, tracks, _ = walker(POSE2SIM)
    for side, shift in (("R", -0.08), ("L", 0.08)):
        tracks[:, names.index(f"{side}Hip"), 1] += shift
    path = write_trc(tmp_path / "walk.trc", names, 1000 * tracks)
    with pytest.raises(ValueError, match=r"walk\.trc: hips are as far apart as trochanters"):
        read_motion(path)


@pytest.mark.parametrize("apart", [0.0, 0.08])
def test_one_pelvis_and_two_meanings_of_a_knee(tmp_path, apart):
    """ASIS with RHip, RKnee, RAnkle: centres where the hips are as far apart as centres are; where
    they are as far as trochanters, markers, and the hips are left over."""
    labels = {"asis": "{S}ASIS", "psis": "{S}PSIS", "hip_c": "{S}Hip", "heel": "{S}Heel"}
    centres = {**labels, "knee_c": "{S}Knee", "ankle_c": "{S}Ankle"}
    markers = {**labels, "knee": "{S}Knee", "ankle": "{S}Ankle"}
    names, tracks, truth = walker(markers if apart else centres)
    for side, sign in (("R", -1), ("L", 1)):
        tracks[:, names.index(f"{side}Hip"), 1] += sign * apart
    rec = read_motion(write_trc(tmp_path / "walk.trc", names, 1000 * tracks), cutoff=None)
    assert f"map '{'lateral' if apart else 'joint-centres'}'" in rec.notes
    assert any("not RHip, LHip" in note for note in rec.notes) == bool(apart)
    for joint in JOINTS:
        assert off(rec, truth, "right", joint) < 1e-9


@pytest.mark.parametrize("form", ["{side}{}", "{}_{S}", "{}.{side}", "Ann:{S} {}"])
def test_the_side_stands_anywhere(tmp_path, form):
    words = {key: label.replace("{S}.", "") for key, label in BMC.items()}
    labels = {key: form.replace("{}", word) for key, word in words.items()}
    names, tracks, truth = walker(labels)
    rec = read_motion(write_trc(tmp_path / "walk.trc", names, 1000 * tracks), cutoff=None)
    assert "map 'medial'" in rec.notes and off(rec, truth, "left", "knee") < 1e-9


def test_an_explicit_lateral_label_goes_before_a_plain_one(tmp_path):
    """`R.Knee` beside `R.Knee.Lat` is something else than the lateral marker."""
    names, tracks, truth = walker({**BMC, "knee": "{S}.Knee.Lat", "knee_c": "{S}.Knee"})
    rec = read_motion(write_trc(tmp_path / "walk.trc", names, 1000 * tracks), cutoff=None)
    assert off(rec, truth, "right", "knee") < 1e-9


def test_a_marker_that_is_only_wished_for_stops_nothing(tmp_path):
    """A cluster's marker never seen but twice, a toe lost for a second: left out and told."""
    names, tracks, truth = walker(RAJAGOPAL)
    tracks[5:-5, names.index("R.TH2")] = np.nan
    tracks[100:220, names.index("L.Toe")] = np.nan
    rec = read_motion(write_trc(tmp_path / "walk.trc", names, 1000 * tracks), cutoff=None)
    assert len(rec.times) == 350
    assert "left_foot" not in rec.points and "right_foot" in rec.points
    assert any("L.Toe, R.TH2 left out" in note for note in rec.notes)
    assert any("no left foot" in note for note in rec.notes)
    assert off(rec, truth, "right", "knee") < 1e-9


def test_another_rule_takes_the_place_of_a_gap(tmp_path):
    """PSIS lost for a second, and a sacral marker there: the sacrum is used."""
    names, tracks, truth = walker({**BMC, "sacrum": "V.Sacral"})
    tracks[100:220, names.index("L.PSIS")] = np.nan
    rec = read_motion(write_trc(tmp_path / "walk.trc", names, 1000 * tracks), cutoff=None)
    assert any(note.startswith("L.PSIS not used") for note in rec.notes)
    assert off(rec, truth, "left", "hip") < 1e-9


def test_all_gaps_at_once(tmp_path):
    """Every gap, the max_gap that fills them, the longest part without: as one sentence."""
    names, tracks, _ = walker(BMC)
    tracks[50:70, names.index("R.Knee")] = np.nan
    tracks[60:95, names.index("L.Ankle")] = np.nan
    tracks[300:320, names.index("R.Knee")] = np.nan
    path = write_trc(tmp_path / "walk.trc", names, 1000 * tracks)
    with pytest.raises(ValueError, match=r"'R\.Knee'.*'L\.Ankle'.*'R\.Knee'") as error:
        read_motion(path)
    said = str(error.value)
    assert "t = 0.500 s for 0.200 s" in said and "t = 3.000 s for 0.200 s" in said
    assert "raise max_gap=0.351" in said and "window=(start, end) as (0.950, 2.990) s" in said
    assert len(read_motion(path, max_gap=0.351).times) == 350
    assert len(read_motion(path, window=(0.95, 2.99)).times) == 205


def test_every_set_knows_what_it_uses():
    """Maps are whole: labels of the markers that points need, and none that two markers share."""
    for name in SHIPPED:
        map = segment_map(name)
        words = vocabulary(map)
        spelled = [s for labels in map.markers.values() for s in labels]
        assert len({plain(s) for s in spelled}) == len(
            {(plain(s), key) for key, labels in map.markers.items() for s in labels}
        ), name
        assert spelled and set(words.values()) >= {k for k, v in map.markers.items() if v}, name


def test_a_file_that_fits_no_set_says_what_it_lacks(tmp_path):
    """By those sets that explain most, and that a static trial may have it."""
    names, tracks, _ = walker(LATERAL)
    keep = [k for k, n in enumerate(names) if "Knee" not in n]
    path = write_trc(tmp_path / "walk.trc", [names[k] for k in keep], 1000 * tracks[:, keep])
    with pytest.raises(
        ValueError, match=r"lateral.*right_thigh needs marker .right_knee_lateral.*static="
    ):
        read_motion(path)


def test_stray_markers_do_not_make_a_giant(tmp_path):
    """A marker 6 m away on the wall: the person among the markers has the size of one."""
    names, tracks, _ = walker(BMC)
    wall = np.tile([6.0, 1.0, 2.0], (len(tracks), 1, 1))
    path = write_trc(tmp_path / "a.trc", [*names, "wall"], 1000 * np.concatenate([tracks, wall], 1))
    assert choose_map(read_markers(path)).name == "medial"
    assert any("not wall" in note for note in read_motion(path).notes)
