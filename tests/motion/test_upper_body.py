# SPDX-License-Identifier: LGPL-3.0-or-later
"""Trunk and arms: the neutral pose, arms raised, sizes, joints and what counts as flexion."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from shellform.motion.anthropometry import girth
from shellform.motion.arm_lowering import arms_lowered
from shellform.motion.gait.standing_pose import standing
from shellform.motion.joint_coordinates import coordinates, heading_axes, points_of
from shellform.motion.proportions import LENGTHS
from shellform.motion.recording import UPPER_JOINTS, UPPER_SEGMENTS, Recording
from shellform.motion.upper_anthropometry import GIRTHS, upper_ellipsoids, upper_girths
from shellform.motion.upper_body import (
    ABDUCTED,
    BENT,
    BREADTH,
    INWARD,
    abduction,
    arms_raised,
    neutral,
    with_upper_body,
)
from shellform.motion.wearer import Wearer

SIDED = {
    f"{side}_{part}": LENGTHS[part] for side in ("right", "left") for part in ("thigh", "shank")
}
STILL = standing({"pelvis": LENGTHS["pelvis"], **SIDED})


def whole(frames=8):
    """A recording of one who stands, with the upper body."""
    points = {name: np.repeat(track[None], frames, axis=0) for name, track in STILL.items()}
    return with_upper_body(Recording(np.linspace(0.0, 0.1 * (frames - 1), frames), points))


def first(recording):
    return {name: track[0] for name, track in recording.points.items()}


def test_neutral_pose_rides_on_the_pelvis_and_is_told():
    recording = whole()
    points = first(recording)
    assert set(UPPER_SEGMENTS) <= set(points)
    assert any("assumed" in note and "30 degrees" in note for note in recording.notes)
    assert abduction(points) == pytest.approx(ABDUCTED, abs=1e-12)
    shoulders = [points[f"{side}_upper_arm"][0] for side in ("right", "left")]
    assert np.linalg.norm(shoulders[0] - shoulders[1]) == pytest.approx(BREADTH - 2 * INWARD)
    # a pelvis that turns takes them along as a rigid body
    turn = Rotation.from_rotvec([0.2, -0.3, 0.7]).as_matrix()
    turned = neutral({"pelvis": (points["pelvis"] @ turn.T)[None]})
    for name in UPPER_SEGMENTS:
        assert turned[name][0] == pytest.approx(points[name] @ turn.T, abs=1e-12)


def test_what_a_motion_has_is_kept():
    """A captured thorax decides where the arms hang; what is assumed is told by name."""
    recording = whole()
    lean = Rotation.from_rotvec([0.0, 0.3, 0.0]).as_matrix()
    thorax = recording.points["thorax"] @ lean.T
    lower = {n: p for n, p in recording.points.items() if n not in UPPER_SEGMENTS}
    found = with_upper_body(Recording(recording.times, {**lower, "thorax": thorax}))
    assert found.points["thorax"] is thorax
    assert "trunk" not in found.notes[-1] and "left forearm" in found.notes[-1]
    wanted = recording.points["left_forearm"] @ lean.T
    assert found.points["left_forearm"] == pytest.approx(wanted, abs=1e-12)


def test_arms_come_down_into_the_first_frame():
    recording = whole()
    angle = np.radians(40.0)
    tracks = arms_raised({n: p[None] for n, p in first(recording).items()}, angle)
    raised = {name: track[0] for name, track in tracks.items()}
    assert abduction(raised) == pytest.approx(ABDUCTED + angle, abs=1e-12)
    down = arms_lowered(recording, angle, 2.0, 0.3, 0.9)
    place = int(np.argmin(np.abs(down.times - 2.0)))
    assert down.times[0] == pytest.approx(2.0 - 1.2) and down.times[place] == pytest.approx(2.0)
    for name, points in first(recording).items():
        assert down.points[name][place] == pytest.approx(points, abs=1e-12)
        assert down.points[name][0] == pytest.approx(raised[name], abs=1e-12)
    held = down.points["left_forearm"][down.times < 1.1 - 1e-9]
    assert np.ptp(held, axis=0).max() < 1e-12 and len(held) > 3


def test_girths_are_those_of_a_tape():
    """Around each ellipsoid where it is measured; the wrist's at its centre."""
    recording = whole()
    rows = upper_ellipsoids({n: v for n, (v, _) in recording.lengths().items()})
    wearer = Wearer(recording, rows)
    pose, points = wearer.new_pose(0.0), first(recording)
    for name, wanted in (("thorax", "chest"), ("neck", "neck"), ("left_upper_arm", "upper_arm")):
        k = wearer.index(name)
        axis = pose.axes[k, 0]
        found = girth(
            pose.centres[[k]], pose.axes[[k]], wearer.radii[[k]], axis @ pose.centres[k], axis
        )
        assert found == pytest.approx(GIRTHS[wanted], rel=1e-3), name
    k = wearer.index("left_forearm")
    wrist, axis = points["left_forearm"][1], pose.axes[k, 0]
    found = girth(pose.centres[[k]], pose.axes[[k]], wearer.radii[[k]], axis @ wrist, axis)
    assert found == pytest.approx(GIRTHS["wrist"], rel=1e-3)


def test_girths_of_ones_own():
    assert upper_girths(1.755, 4 * 84.6)["chest"] == pytest.approx(2 * GIRTHS["chest"])
    assert upper_girths(girths={"chest": 0.95})["chest"] == 0.95
    with pytest.raises(ValueError, match=r"girth 'chest' of 95 is not in metres"):
        upper_girths(girths={"chest": 95})
    with pytest.raises(
        ValueError, match=r"girth 'wrist' of 0.4 m is not below that of the forearm"
    ):
        upper_girths(girths={"wrist": 0.4})


def test_coordinates_of_the_upper_body():
    """Angles of the neutral pose are those it is made of; points come back from them."""
    points = whole().points
    base = heading_axes(points["pelvis"][0])
    found = coordinates(points, base)
    for side in ("right", "left"):
        assert found.angles[f"{side}_upper_arm"][0] == pytest.approx([0.0, ABDUCTED, 0.0], abs=1e-9)
        assert found.angles[f"{side}_forearm"][0] == pytest.approx([BENT, 0.0, 0.0], abs=1e-9)
    again = points_of(*found, base)
    for name, track in points.items():
        assert again[name] == pytest.approx(track, abs=1e-9)


def test_flexion_is_positive_about_every_joint():
    """A trunk that bends forward, arms that rise before it, elbows that bend: spin . axis > 0."""
    recording, rate = whole(30), 0.5
    base = heading_axes(recording.points["pelvis"][0])
    found = coordinates(recording.points, base)
    for joint, (_, below, _) in UPPER_JOINTS.items():
        angles = {name: a.copy() for name, a in found.angles.items()}
        angles[below][:, 0] += rate * recording.times
        moved = Recording(recording.times, points_of(angles, found.arms, found.local, base))
        wearer = Wearer(
            moved, [("pelvis", "pelvis", np.zeros(3), np.full(3, 0.1))], from_rest=False
        )
        state, k = wearer.new_joints(1.0), wearer.joints.index(joint)
        assert state.spins[k] @ state.axes[k] == pytest.approx(rate, rel=0.02), joint
        others = [j for j in range(len(wearer.joints)) if j != k]
        assert np.abs(state.spins[others]).max() < 1e-9, joint


def test_what_counts_for_a_joint():
    recording = whole()
    rows = upper_ellipsoids({n: v for n, (v, _) in recording.lengths().items()})
    wearer = Wearer(recording, rows)
    arms = {f"{side}_{part}" for side in ("right", "left") for part in ("upper_arm", "forearm")}
    assert set(wearer.below("lumbar")) == {"thorax", "shoulders", "neck", *arms}
    assert wearer.below("left_shoulder") == ["left_upper_arm", "left_forearm"]
    assert wearer.just_below("right_elbow") == ["right_forearm"]
