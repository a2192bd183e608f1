# SPDX-License-Identifier: LGPL-3.0-or-later
"""Trunk and arms of a capture with Plug-in Gait's markers of the upper body."""

import numpy as np
import pytest

from shellform.motion.anthropometry import ellipsoids
from shellform.motion.arms_off_trunk import GAP, arms_off_trunk
from shellform.motion.capture.read_motion import read_markers, read_motion
from shellform.motion.joint_coordinates import coordinates, heading_axes
from shellform.motion.recording import SIDES, UPPER_SEGMENTS
from shellform.motion.upper_anthropometry import upper_ellipsoids
from shellform.motion.wearer import Wearer
from shellform.scene.parts import Garment, Motion
from shellform.scene.scene import Scene
from shellform.scene.wearer import wearer_of
from tests.meshes.patterns.drafts import FILES

CENTRES = {"CLO": ("upper_arm", 0), "HUO": ("upper_arm", 1), "RAO": ("forearm", 1)}


@pytest.fixture(scope="module")
def capture(paper_data):
    return paper_data / "biomechzoo_HC038A11.c3d"


@pytest.fixture(scope="module")
def walk(capture):
    return read_motion(capture, upper=True, window=(3.0, 4.5))


def bodies(recording):
    lengths = {name: length for name, (length, _) in recording.lengths().items()}
    stature = recording.facts["stature"]
    return [*ellipsoids(lengths, stature), *upper_ellipsoids(lengths, stature)]


def test_joint_centres_against_those_of_plug_in_gait(capture, walk):
    """The file has both: its model's shoulder, elbow and wrist, made with the lab's own measures.

    There the shoulder is 80 mm below the marker, here 60, and the wrist is 30 mm beside the middle
    of its markers.
    """
    assert set(list(walk.points)[-5:]) == set(UPPER_SEGMENTS)
    markers = read_markers(capture)
    use = np.searchsorted(markers.times, walk.times - 1e-6)
    for side in SIDES:
        for label, (part, end) in CENTRES.items():
            model = markers.track(side[0].upper() + label)[use]
            off = np.linalg.norm(model - walk.points[f"{side}_{part}"][:, end], axis=1)
            assert np.median(off) < 0.045, (side, label)
    sizes = {name: length for name, (length, _) in walk.lengths().items()}
    assert sizes["left_upper_arm"] == pytest.approx(sizes["right_upper_arm"], rel=0.03)


def test_who_does_not_ask_has_none_of_it(capture, walk):
    """The lower body is the same with and without, and the upper body is not there."""
    plain = read_motion(capture, window=(3.0, 4.5))
    assert not set(UPPER_SEGMENTS) & set(plain.points)
    for name, track in plain.points.items():
        assert np.array_equal(track, walk.points[name]), name


def test_arms_swing_in_a_shirt(capture):
    """They begin in the neutral pose, come into the capture, and the notes assume nothing."""
    motion = Motion(file=str(capture), start=3.0, end=3.6)
    wearer = wearer_of(Scene(motion=motion, garment=Garment(file=str(FILES / "shirt.json"))))
    recording = wearer.recording
    assert not any("assumed" in note for note in recording.notes)
    found = coordinates(recording.points, heading_axes(recording.points["pelvis"][0]))
    for side in SIDES:
        flexion = found.angles[f"{side}_upper_arm"][:, 0]
        assert flexion[0] == pytest.approx(0.0, abs=1e-6)
        assert np.ptp(flexion[recording.first_frame :]) > np.radians(10.0)
    # both arms swing against each other
    right, left = (
        np.diff(found.angles[f"{side}_upper_arm"][recording.first_frame :, 0]) for side in SIDES
    )
    assert np.corrcoef(right, left)[0, 1] < -0.5


def test_arms_held_off_the_trunk(walk):
    """Once is enough; about the shoulder alone: elbows bend as before, clear of the trunk."""
    rows = bodies(walk)
    held = arms_off_trunk(walk, rows)
    assert "arms held off the trunk" in held.notes[-1]
    assert arms_off_trunk(held, rows) is held
    base = heading_axes(walk.points["pelvis"][0])
    before, after = (coordinates(r.points, base) for r in (walk, held))
    for side in SIDES:
        name = f"{side}_forearm"
        assert after.angles[name] == pytest.approx(before.angles[name], abs=1e-9)
        shoulder = f"{side}_upper_arm"
        assert held.points[shoulder][:, 0] == pytest.approx(walk.points[shoulder][:, 0], abs=1e-12)
    # in frames between those that were looked at
    wearer = Wearer(held, rows)
    for t in held.times[::10]:
        pose = wearer.new_pose(t)
        for side in SIDES:
            elbow = held.points[f"{side}_forearm"][np.searchsorted(held.times, t), 0]
            for name in ("thorax", "abdomen", "pelvis"):
                k = wearer.index(name)
                y = (elbow - pose.centres[k]) @ pose.axes[k].T / wearer.radii[k]
                assert (np.linalg.norm(y) - 1) * wearer.radii[k].max() > GAP, (side, name)
