# SPDX-License-Identifier: LGPL-3.0-or-later
"""The wearer's pose against known rigid motions; the way from standing into a first frame."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from contact.body.segment_frame import pose_from_markers
from shellform.motion.capture.gait_initiation import gait_initiation
from shellform.motion.recording import JOINTS, Recording
from shellform.motion.wearer import Wearer

# heights of a standing wearer [m]; x forward, z up, right at negative y
HIP, KNEE, ANKLE = 0.92, 0.49, 0.07


def standing(at=(0.0, 0.0)):
    """J1, J2, M of all segments."""
    pose = {"pelvis": [[0, 0, 1.0], [0, 0, HIP], [0.09, 0, 1.0]]}
    for side, sign in (("right", -1), ("left", 1)):
        y = 0.09 * sign
        pose[f"{side}_thigh"] = [[0, y, HIP], [0, y, KNEE], [0, y + 0.06 * sign, KNEE]]
        pose[f"{side}_shank"] = [[0, y, KNEE], [0, y, ANKLE], [0, y + 0.04 * sign, ANKLE]]
        pose[f"{side}_foot"] = [[-0.05, y, 0.03], [0.2, y, 0.02], [0.2, y + 0.05 * sign, 0.02]]
    return {name: np.array(p, float) + [*at, 0] for name, p in pose.items()}


def bent(pose, joint, angle, axis):
    """The pose with all below a joint turned about it by angle [rad]."""
    segment, end = JOINTS[joint][2]
    centre, turn = pose[segment][end].copy(), Rotation.from_rotvec(angle * np.array(axis))
    below = {"hip": "thigh shank foot", "knee": "shank foot", "ankle": "foot"}
    side, kind = joint.split("_")
    out = dict(pose)
    for part in below[kind].split():
        name = f"{side}_{part}"
        out[name] = centre + turn.apply(pose[name] - centre)
    return out


def rigid(times):
    """A segment in steady spin whose centre goes along a parabola; also its exact motion."""
    spin, start = np.array([1.0, -2.0, 3.0]), Rotation.from_rotvec([0.3, 0.2, -0.5])
    local = np.array([[-0.2, 0, 0], [0.2, 0, 0], [0.2, 0.06, 0]])
    turn = Rotation.from_rotvec(spin * np.asarray(times)[:, None]) * start
    centre = np.outer(times, [1, 0.5, 0]) + np.outer(np.square(times), [0, 0, -2.0])
    points = np.array([r.apply(local) for r in turn]) + centre[:, None]
    return points, turn, spin


@pytest.mark.parametrize("offset", [(0, 0, 0), (0.05, -0.02, 0.1)])
def test_pose_of_a_known_motion(offset):
    """Frames to roundoff; between them the error falls with the fourth order of the interval."""
    errors = []
    for n in (21, 41):
        times = np.linspace(0, 1, n)
        points, _, spin = rigid(times)
        ellipsoids = [("limb", "pelvis", offset, (0.2, 0.1, 0.1))]
        wearer = Wearer(Recording(times, {"pelvis": points}), ellipsoids, from_rest=False)
        t = 0.5 + 0.5 / (n - 1)
        _, turn, _ = rigid([t])
        pose = wearer.new_pose(t)
        axes = turn.as_matrix()[0].T
        arm = np.array(offset) @ axes
        centre = np.array([t, 0.5 * t, -2 * t * t]) + arm
        velocity = np.array([1, 0.5, -4 * t]) + np.cross(spin, arm)
        exact = axes, centre, velocity, spin
        got = pose.axes[0], pose.centres[0], pose.velocities[0], pose.spins[0]
        errors.append([np.abs(a - b).max() for a, b in zip(got, exact, strict=True)])
        np.testing.assert_allclose(pose.axes[0] @ pose.axes[0].T, np.eye(3), atol=1e-14)
        assert np.linalg.det(pose.axes[0]) == pytest.approx(1, abs=1e-14)
        at = wearer.new_pose(times[7])
        np.testing.assert_allclose(at.axes[0], pose_from_markers(*points[7])[1], atol=1e-14)
    # rates lose an order
    for (coarse, fine), order in zip(zip(*errors, strict=True), (4, 4, 3, 3), strict=True):
        assert fine < 1e-12 or np.log2(coarse / fine) > order - 0.4


def test_rates_are_those_of_the_pose():
    times = np.linspace(0, 1, 11)
    points, _, _ = rigid(times)
    points = points + 0.05 * np.sin(7 * times)[:, None, None] * [0.3, 1, -2]
    ellipsoids = [("limb", "pelvis", (0.1, 0.2, 0.3), (0.2, 0.1, 0.1))]
    wearer = Wearer(Recording(times, {"pelvis": points}), ellipsoids)
    h = 1e-5
    for t in (0.234, 0.777):
        now, ahead, back = (wearer.new_pose(s) for s in (t, t + h, t - h))
        speed = (ahead.centres - back.centres) / (2 * h)
        np.testing.assert_allclose(now.velocities, speed, atol=1e-8)
        turn = (ahead.axes[0].T @ back.axes[0] - np.eye(3)) / (2 * h)
        spin = 0.5 * np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], 0])
        spin[2] = 0.5 * (turn[1, 0] - turn[0, 1])
        np.testing.assert_allclose(now.spins[0], spin, atol=1e-6)
    for t in (-1.0, 1.5):  # stands still outside its frames
        pose = wearer.new_pose(t)
        assert not pose.velocities.any() and not pose.spins.any()


@pytest.mark.parametrize(
    "joint, axis",
    [
        ("right_hip", (0, -1, 0)),
        ("left_hip", (0, -1, 0)),
        ("right_knee", (0, 1, 0)),
        ("left_knee", (0, 1, 0)),
        ("right_ankle", (0, -1, 0)),
        ("left_ankle", (0, -1, 0)),
    ],
)
def test_flexion_is_positive_on_both_sides(joint, axis):
    """Thigh forward, shank backward, toes up: the spin about the joint's axis is the rate."""
    times = np.linspace(0, 1, 21)
    poses = [bent(standing(), joint, 0.5 * t, axis) for t in times]
    points = {name: np.array([p[name] for p in poses]) for name in poses[0]}
    wearer = Wearer(Recording(times, points), [], from_rest=False)
    state = wearer.new_joints(0.53)
    k = wearer.joints.index(joint)
    assert state.spins[k] @ state.axes[k] == pytest.approx(0.5, abs=1e-6)
    np.testing.assert_allclose(state.axes[k], axis, atol=1e-9)
    others = np.delete(state.spins, k, axis=0)
    np.testing.assert_allclose(others, 0, atol=1e-9)
    segment, end = JOINTS[joint][2]
    np.testing.assert_allclose(state.centres[k], standing()[segment][end], atol=1e-9)


def test_below_a_joint():
    points = {name: np.array([p, p]) for name, p in standing().items()}
    ellipsoids = [(name, name, (0, 0, 0), (0.1, 0.1, 0.1)) for name in points]
    wearer = Wearer(Recording(np.array([0.0, 1.0]), points), ellipsoids)
    assert wearer.below("right_knee") == ["right_shank", "right_foot"]
    assert wearer.below("left_hip") == ["left_thigh", "left_shank", "left_foot"]


def test_missing_segment_is_named():
    points = {"pelvis": np.array([standing()["pelvis"]] * 2)}
    with pytest.raises(ValueError, match="'knee pad' rides on segment 'right_shank'"):
        Wearer(
            Recording(np.array([0.0, 1.0]), points, "walk.trc"),
            [("knee pad", "right_shank", (0, 0, 0), (0.1, 0.1, 0.1))],
        )


def test_names_are_given_once():
    points = {"pelvis": np.array([standing()["pelvis"]] * 2)}
    twice = [("belly", "pelvis", (0, 0, 0), (0.1, 0.1, 0.1))] * 2
    with pytest.raises(ValueError, match="found twice: belly"):
        Wearer(Recording(np.array([0.0, 1.0]), points), twice)


def walking(times):
    """A made-up stride: the pelvis moves on and turns, the joints swing."""
    poses = []
    for t in times:
        pose = standing((1.3 * t, 0.02 * np.sin(6 * t)))
        for side, sign in (("right", 1), ("left", -1)):
            pose = bent(pose, f"{side}_hip", 0.4 * sign * np.cos(6 * t), (0, -1, 0))
            axis = pose[f"{side}_thigh"][2] - pose[f"{side}_thigh"][1]
            axis = axis * -sign / np.linalg.norm(axis)
            pose = bent(pose, f"{side}_knee", 0.4 + 0.3 * sign * np.sin(6 * t), axis)
            pose = bent(pose, f"{side}_ankle", 0.2 * np.sin(6 * t), (0, -1, 0))
        poses.append(pose)
    points = {name: np.array([p[name] for p in poses]) for name in poses[0]}
    return Recording(np.asarray(times), points, "walk")


def test_gait_initiation_keeps_segments_together_and_arrives_with_the_speed():
    recording = walking(np.arange(100) / 100)
    full = gait_initiation(recording, standing((5.0, 3.0)), 1.0)
    assert full.times[0] == -1.0 and full.rate == pytest.approx(100)
    for _, below, (segment, end) in JOINTS.values():
        if below.endswith("shank"):  # thigh and shank share the knee
            gap = full.points[segment][:, end] - full.points[below.replace("shank", "thigh")][:, 1]
            assert np.abs(gap).max() < 1e-12
    for length, spread in full.lengths().values():
        assert length > 0 and spread < 1e-12
    ellipsoids = [(name, name, (0, 0, 0), (0.1, 0.1, 0.1)) for name in full.points]
    wearer = Wearer(full, ellipsoids)
    begin = wearer.new_pose(-1.0)
    assert np.abs(begin.velocities).max() < 1e-12
    assert np.abs(wearer.new_pose(-0.98).velocities).max() < 0.02
    # before and after the first frame the rates agree with those of the recording alone
    alone = Wearer(recording, ellipsoids, from_rest=False)
    for name in ("velocities", "spins"):
        exact = getattr(alone.new_pose(0.0), name)
        for t in (-1e-4, 0.0, 1e-4):
            assert np.abs(getattr(wearer.new_pose(t), name) - exact).max() < 0.05
    # the pelvis stands on the way, half the first speed behind
    pelvis = full.points["pelvis"][:, :2].mean(axis=1)
    assert pelvis[0, 0] == pytest.approx(pelvis[100, 0] - 0.65, abs=0.01)
    assert (np.diff(pelvis[:, 0]) > -1e-9).all()


def test_no_gait_initiation_and_wrong_ones():
    recording = walking(np.arange(10) / 100)
    assert gait_initiation(recording, standing(), 0.0) is recording
    with pytest.raises(ValueError, match="0 s or longer"):
        gait_initiation(recording, standing(), -1.0)
    with pytest.raises(ValueError, match="lacks left_foot, right_foot"):
        gait_initiation(recording, {n: p for n, p in standing().items() if "foot" not in n})
