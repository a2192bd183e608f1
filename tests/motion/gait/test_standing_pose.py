# SPDX-License-Identifier: LGPL-3.0-or-later
"""The standing pose of given lengths, and of a recording."""

import numpy as np
import pytest

from contact.body.segment_frame import pose_from_markers
from shellform.motion.gait.synthetic_walk import joint_angles, standing, standing_of, synthetic_walk
from shellform.motion.recording import SIDES, Recording

# Angles [degree] of hip and knee over a level stride from heel strike to heel strike: means of 15
# adults (BioCV, as in myogait 0.9.2) and of 10 (CROSS_OBSTACLE_DATASET, trials without obstacle).


@pytest.fixture(scope="module")
def walk():
    return synthetic_walk()


LENGTHS = {"pelvis": 0.09, "right_thigh": (0.44, 0.01), "left_thigh": 0.43, "right_shank": 0.41}
LENGTHS |= {"left_shank": 0.43, "right_foot": 0.22, "left_foot": 0.22}


def test_standing_pose_of_given_lengths():
    """Lengths to the last digit, feet level on the floor, below the hips, knees as asked for."""
    heading, at, floor = (1.0, 2.0, 0.7), (0.3, -0.2), 0.1
    pose = standing(LENGTHS, heading, at, floor, hip_spacing=0.19, knee=4.0)
    for name, points in pose.items():
        length = float(np.ravel(LENGTHS[name])[0])
        assert np.linalg.norm(points[1] - points[0]) == pytest.approx(length, abs=1e-12)
    times = np.arange(2.0)
    tracks = {name: np.stack([points, points]) for name, points in pose.items()}
    angles = joint_angles(Recording(times, tracks))
    assert angles["right_knee_flexion"][0] > angles["left_knee_flexion"][0] - 90
    straighter = min(angles[f"{side}_knee_flexion"][0] for side in SIDES)
    assert straighter == pytest.approx(4.0, abs=1e-6)
    assert all(0 <= angles[f"{side}_hip_flexion"][0] < 20 for side in SIDES)
    assert all(abs(angles[f"{side}_hip_abduction"][0]) < 1e-9 for side in SIDES)
    ahead = np.array([1.0, 2.0, 0.0]) / np.sqrt(5)
    for side, sign in (("right", -1), ("left", 1)):
        heel, toe, marker = pose[f"{side}_foot"]
        assert np.abs((toe - heel) / 0.22 - ahead).max() < 1e-12
        outward = sign * np.cross([0, 0, 1], ahead)
        assert (marker - toe) @ outward > 0.03
        ankle = pose[f"{side}_shank"][1]
        assert np.abs(ankle[:2] - at - sign * 0.095 * np.cross([0, 0, 1], ahead)[:2]).max() < 1e-12
        assert floor < heel[2] < ankle[2] < floor + 0.1
    axes = pose_from_markers(*pose["pelvis"])[1]
    assert np.abs(axes[:2] - [[0, 0, -1], ahead]).max() < 1e-12


def test_standing_knees_straight():
    pose = standing({**LENGTHS, "right_shank": 0.42}, knee=0.0)
    assert all(np.isfinite(points).all() for points in pose.values())


def test_standing_of_a_recording(walk):
    """The walk's own standing pose; turned and shifted walks give it turned and shifted."""
    pose = standing_of(walk)
    assert set(pose) == set(walk.points)
    for name, points in pose.items():
        assert np.abs(points - walk.points[name][0]).max() < 1e-9, name
    c, s = np.cos(2.0), np.sin(2.0)
    turn, shift = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]), np.array([1.0, -2.0, 0.5])
    moved = {name: track @ turn.T + shift for name, track in walk.points.items()}
    for name, points in standing_of(Recording(walk.times, moved)).items():
        assert np.abs(points - (pose[name] @ turn.T + shift)).max() < 1e-9, name
    without = {name: track for name, track in walk.points.items() if "foot" not in name}
    assert set(standing_of(Recording(walk.times, without))) == set(without)


@pytest.mark.parametrize(
    "lengths, change, message",
    [
        ({"pelvis": 0.1}, {}, "needs the lengths of right_thigh, right_shank, left_thigh"),
        ({**LENGTHS, "left_shank": -0.4}, {}, "length of 'left_shank' must be positive"),
        (LENGTHS, {"heading": (0, 0, 1)}, "no horizontal part"),
        (LENGTHS, {"knee": 60}, "0 to 30 degrees"),
    ],
)
def test_standing_refuses(lengths, change, message):
    with pytest.raises(ValueError, match=message):
        standing(lengths, **change)
