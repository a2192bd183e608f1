# SPDX-License-Identifier: LGPL-3.0-or-later
"""Walks of public data sets, where they have been downloaded."""

import numpy as np
import pytest

from contact.body.segment_frame import pose_from_markers
from shellform.motion.capture.read_motion import (
    choose_map,
    read_markers,
    read_motion,
    recording,
)


def test_bmc_walk(paper_data):
    """Real walk, y up, mm: 2.03 m in 250 frames at 150 Hz; bones; lateral markers alone; a belt."""
    path = paper_data / "bmc_walk2.trc"
    markers = read_markers(path)
    rec = recording(markers)
    assert len(markers.names) == 28 and rec.rate == pytest.approx(150.0)
    assert len(rec.times) == 251
    speed = 2.03 / (250 / 150)  # way of the pelvis over the time, the capture's description
    assert rec.facts["speed"] == pytest.approx(speed, rel=0.03)
    feet = {s: [t for n, t in rec.facts["events"] if n.startswith(s)] for s in ("left", "right")}
    step = feet["right"][0] - feet["left"][0]
    assert rec.facts["cadence"] == pytest.approx(60 / step, rel=0.03)
    bones(recording(markers, cutoff=None, rigid=False), rec)
    assert any("L.MT2" in note for note in rec.notes)
    assert choose_map(markers).name == "medial"
    other = {"R": "L", "L": "R"}  # labels of the wrong side, as another walk of this set has them
    names = tuple(other[n[0]] + n[1:] for n in markers.names)
    wrong = type(markers)(names, markers.times, markers.positions, markers.rate, "mirrored")
    for segment, track in recording(wrong).points.items():
        assert np.abs(track - rec.points[segment]).max() < 1e-12
    lateral = recording(markers, "lateral", rigid=False)
    both = recording(markers, "medial", rigid=False)
    for joint in ("right_knee", "left_knee", "right_ankle", "left_ankle"):
        off = np.linalg.norm(lateral.joint_centre(joint) - both.joint_centre(joint), axis=1)
        assert np.median(off) < 0.02, joint
    still = markers.positions - (markers.times * 1.2)[:, None, None] * [1.0, 0.0, 0.0]
    walking = type(markers)(markers.names, markers.times, still, markers.rate, "belt")
    belt = recording(walking).facts
    assert belt["belt_speed"] == pytest.approx(1.2, rel=0.05)
    assert belt["stride_length"] == pytest.approx(rec.facts["stride_length"], rel=0.03)


def test_biomechzoo_walk(paper_data):
    """Real walk, z up, along y: cadence and strides against the foot strikes the file marks."""
    ezc3d = pytest.importorskip("ezc3d", reason="C3D files are read by ezc3d, not installed here")
    path = paper_data / "biomechzoo_HC038A11.c3d"
    rec = read_motion(path)
    assert rec.rate == pytest.approx(100.0) and len(rec.times) == 246
    assert rec.facts["heading"] == pytest.approx(np.pi / 2, abs=0.1)
    event = ezc3d.c3d(str(path))["parameters"]["EVENT"]
    labels, sides = event["LABELS"]["value"], event["CONTEXTS"]["value"]
    seconds, lengths, durations = event["TIMES"]["value"][1], [], []
    for side in ("right", "left"):
        marked = sorted(
            t for t, w, s in zip(seconds, labels, sides)
            if w == "Foot Strike" and s.lower() == side
        )  # fmt: skip
        heel = rec.points[f"{side}_foot"][
            np.rint((np.array(marked) - rec.times[0]) * 100).astype(int), 0
        ]
        durations += np.diff(marked).tolist()
        lengths += np.linalg.norm(np.diff(heel[:, :2], axis=0), axis=1).tolist()
        found = [t for n, t in rec.facts["events"] if n.startswith(side)]
        for t in marked:
            assert min(abs(t - f) for f in found) < 0.05
    assert rec.facts["cadence"] == pytest.approx(120 / np.median(durations), rel=0.03)
    assert rec.facts["stride_length"] == pytest.approx(np.median(lengths), rel=0.03)
    assert rec.facts["stature"] == pytest.approx(1.74, rel=0.05)  # PROCESSING:Height
    raw = read_motion(path, cutoff=None, rigid=False)
    bones(raw, rec)
    # PROCESSING:RFemurLength, RTibiaLength
    assert raw.lengths()["right_thigh"][0] == pytest.approx(0.4125, rel=0.02)
    assert raw.lengths()["right_shank"][0] == pytest.approx(0.4198, rel=0.02)
    # Plug-in Gait: its model points are used, which is told; its markers alone are less sure
    said = next(n for n in raw.notes if n.startswith("joint centres of the file"))
    assert all(point in said for point in ("RFEP", "RFEO", "RTIO", "LFEP", "LFEO", "LTIO"))
    alone = read_motion(path, map="plug-in-gait-markers", rigid=False)
    assert not any("RFEO" in n for n in alone.notes if n.startswith("joint centres of the file"))
    lateral = read_motion(path, map="lateral", rigid=False)
    for joint in ("right_hip", "right_knee", "left_knee", "right_ankle", "left_ankle"):
        for markers in (lateral, alone):
            off = np.linalg.norm(markers.joint_centre(joint) - raw.joint_centre(joint), axis=1)
            assert np.median(off) < 0.03, joint


def bones(raw, rec):
    """Thigh and shank: 2 % (standard deviation) as measured, constant in the recording; det +1."""
    for segment, track in raw.points.items():
        _, axes = pose_from_markers(*np.moveaxis(rec.points[segment], 1, 0))
        assert np.abs(np.linalg.det(axes) - 1).max() < 1e-12
        if segment.endswith(("thigh", "shank")):
            length = np.linalg.norm(track[:, 1] - track[:, 0], axis=1)
            assert length.std() < 0.02 * np.median(length), segment
            assert rec.lengths()[segment][1] < 1e-9, segment
