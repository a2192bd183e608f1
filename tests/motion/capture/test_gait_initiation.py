# SPDX-License-Identifier: LGPL-3.0-or-later
"""The way from standing into a first frame: ranges of motion, speeds, lengths, floor, smoothness.

Windows of public captures and of the synthetic walk that begin at heel strike, in mid-swing, in
mid-stance, in a turn, and over an obstacle.
"""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from contact.body.segment_frame import pose_from_markers
from shellform.motion.capture.gait_initiation import gait_initiation
from shellform.motion.capture.read_motion import read_motion
from shellform.motion.gait.leg import joint_angles
from shellform.motion.gait.standing_pose import standing_of
from shellform.motion.gait.synthetic_walk import synthetic_walk
from shellform.motion.recording import JOINTS, SIDES, Recording
from shellform.motion.wearer import Wearer
from shellform.scene.wearer import cut

RANGES = {  # [degree]
    "hip_flexion": (-30, 125),
    "hip_abduction": (-30, 45),
    "knee_flexion": (-5, 150),
    "ankle_dorsiflexion": (-50, 30),
}
C3D, TRC = "biomechzoo_HC038A11.c3d", "bmc_walk2.trc"
# file or obstacle of the synthetic walk, window [s], rate of turning [rad/s]
WINDOWS = {
    "C3D, whole, in swing": (C3D, None, 0.0),
    "C3D, heel strike": (C3D, (3.34, np.inf), 0.0),
    "C3D, mid-swing": (C3D, (3.62, np.inf), 0.0),
    "C3D, mid-stance": (C3D, (3.0, 4.6), 0.0),
    "C3D, mid-swing in a turn": (C3D, (3.62, np.inf), 0.8),
    "TRC, whole": (TRC, None, 0.0),
    "TRC, heel strike": (TRC, (0.53, np.inf), 0.0),
    "TRC, mid-swing": (TRC, (0.36, np.inf), 0.0),
    "TRC, mid-stance": (TRC, (0.75, 1.4), 0.0),
    "TRC, mid-stance in a turn": (TRC, (0.75, 1.6), -0.8),
    "TRC, 0.2 s": (TRC, (1.2, 1.4), 0.0),
    "synthetic, heel strike": (0.0, (2.34, 4.5), 0.0),
    "synthetic, mid-swing in a turn": (0.0, (2.6, 4.5), 0.8),
    "synthetic, 0.2 s": (0.0, (1.5, 1.7), 0.0),
    "synthetic, over the obstacle": (0.5, (3.4, 5.5), 0.0),
    "synthetic, the other foot over it": (0.5, (4.3, 5.8), 0.0),
}


def turning(walk, rate):
    """The walk along a circle: turned with time, the pelvis's way with it."""
    angle = rate * (walk.times - walk.times[0])
    turn = Rotation.from_rotvec(np.outer(angle, [0.0, 0.0, 1.0])).as_matrix()
    flat = walk.points["pelvis"][:, 1] * [1.0, 1.0, 0.0]
    way = np.einsum("nij,nj->ni", turn[:-1], np.diff(flat, axis=0))
    place = flat[0] + np.concatenate([np.zeros((1, 3)), np.cumsum(way, axis=0)])
    points = {
        name: np.einsum("nij,npj->npi", turn, track - flat[:, None]) + place[:, None]
        for name, track in walk.points.items()
    }
    return Recording(walk.times, points, f"{walk.source}, turning")


def window(name, folder):
    what, part, rate = WINDOWS[name]
    if isinstance(what, str):
        if what.endswith("c3d"):
            pytest.importorskip("ezc3d", reason="C3D files are read by ezc3d, not installed here")
        walk = read_motion(folder / what, window=part)
    else:
        walk = cut(synthetic_walk(obstacle=what), *part)
    return turning(walk, rate) if rate else walk


def spins(recording):
    """Speeds (n - 1,) [rad/s] of the turning in each joint."""
    turns = {
        name: Rotation.from_matrix(
            np.swapaxes(pose_from_markers(*np.moveaxis(track, 1, 0))[1], 1, 2)
        )
        for name, track in recording.points.items()
    }
    out = {}
    for joint, (above, below, _) in JOINTS.items():
        between = turns[above].inv() * turns[below]
        step = (between[:-1].inv() * between[1:]).magnitude()
        out[joint] = step / np.diff(recording.times)
    return out


@pytest.mark.parametrize("name", WINDOWS)
def test_the_way_into_a_window(name, paper_data):
    walk = window(name, paper_data)
    full = gait_initiation(walk, standing_of(walk))
    n = full.first_frame
    assert n == len(full.times) - len(walk.times) and 1.0 <= walk.times[0] - full.times[0] <= 3.0
    for segment, track in walk.points.items():
        np.testing.assert_array_equal(full.points[segment][n:], track)
    # angles, where the first frame itself is outside by as much as it is, and two degrees
    angles, first = joint_angles(full), joint_angles(walk)
    for kind, (least, most) in RANGES.items():
        for side in SIDES:
            one, at = angles[f"{side}_{kind}"][:n], first[f"{side}_{kind}"][0]
            low = least - 0.5 if at >= least else at - 3.0
            high = most + 0.5 if at <= most else at + 3.0
            assert one.min() >= low and one.max() <= high, (kind, side, one.min(), one.max())
    # speeds of each kind of joint
    now, then = spins(full), spins(walk)
    for kind in ("hip", "knee", "ankle"):
        peak = max(then[f"{side}_{kind}"].max() for side in SIDES)
        fastest = max(now[f"{side}_{kind}"][:n].max() for side in SIDES)
        assert fastest <= 2.0 * peak, (kind, fastest / peak)
    # lengths, and joints that stay together
    for segment, track in full.points.items():
        length = np.linalg.norm(track[: n + 1, 1] - track[: n + 1, 0], axis=1)
        # bones of captures are rigid, pelvis and feet change with their markers
        own = walk.points[segment]
        bar = np.ptp(np.linalg.norm(own[:, 1] - own[:, 0], axis=1))
        assert np.ptp(length) < max(bar, 1e-9), segment
    # no point of a foot lower than in the capture or in standing
    feet = [s for s in walk.points if s.endswith("foot")]
    floor = min(walk.points[f][..., 2].min() for f in feet)
    floor = min(floor, min(standing_of(walk)[f][:, 2].min() for f in feet))
    assert min(full.points[f][:n, :, 2].min() for f in feet) > floor - 2e-3
    # at rest at first
    for track in full.points.values():
        assert np.abs(track[1] - track[0]).max() < 1e-4


@pytest.mark.parametrize("name", ["C3D, whole, in swing", "TRC, mid-stance", "synthetic, 0.2 s"])
def test_a_given_time_is_kept_and_so_are_the_ranges(name, paper_data):
    """0.4 s are too short for slow joints, not for the ranges."""
    walk = window(name, paper_data)
    full = gait_initiation(walk, standing_of(walk), 0.4)
    assert full.times[0] == pytest.approx(walk.times[0] - 0.4)
    angles = joint_angles(full)
    for kind, (least, most) in RANGES.items():
        for side in SIDES:
            one = angles[f"{side}_{kind}"][: full.first_frame + 1]
            assert one.min() >= least - 3.0 and one.max() <= most + 0.5, (kind, side)


def fast_walk(rate):
    """The synthetic walk from mid-swing on, at many frames a second."""
    return cut(synthetic_walk(obstacle=0.0, rate=rate), 2.15, 3.2)


def test_velocity_and_acceleration_go_on():
    """One-sided differences at the first frame agree, to their order: C2."""
    jumps = []
    for rate in (200.0, 400.0):
        walk = fast_walk(rate)
        full = gait_initiation(walk, standing_of(walk))
        n, h = full.first_frame, 1 / rate
        tracks = np.concatenate([t.reshape(len(t), -1) for t in full.points.values()], axis=1)
        back, ahead = tracks[n - 3 : n + 1][::-1], tracks[n : n + 4]
        one = [(4 * a[1] - 3 * a[0] - a[2]) / (2 * h) for a in (back, ahead)]
        two = [(2 * a[0] - 5 * a[1] + 4 * a[2] - a[3]) / h**2 for a in (back, ahead)]
        jumps.append([np.abs(one[0] + one[1]).max(), np.abs(two[0] - two[1]).max()])
        size = np.abs(two[1]).max()
    (v1, a1), (v2, a2) = jumps
    # velocities of 4 m/s, accelerations of tens of m/s^2
    assert v2 < 0.02 and a2 < 0.15 * size
    assert v2 < v1 / 3 and a2 < a1 / 1.6


def test_the_wearer_goes_on_smoothly():
    """Through the wearer's spline: velocity and spin at the first frame are the capture's."""
    walk = fast_walk(100.0)
    ellipsoids = [(name, name, (0, 0, 0), (0.1, 0.1, 0.1)) for name in walk.points]
    full = Wearer(gait_initiation(walk, standing_of(walk)), ellipsoids)
    whole = Wearer(synthetic_walk(obstacle=0.0), ellipsoids)
    now, then = full.new_pose(2.15), whole.new_pose(2.15)
    assert np.abs(now.velocities - then.velocities).max() < 0.02
    assert np.abs(now.spins - then.spins).max() < 0.2
    begin = full.new_pose(full.start)
    assert not begin.velocities.any() and not begin.spins.any()


def test_fast_motion_takes_longer():
    """A knee that has far to go from standing, in a capture where all are slow, gets more time."""
    walk = cut(synthetic_walk(obstacle=0.5), 3.35, 3.45)
    t = walk.times
    # ten times as slow: 1 s of it
    slow = Recording(t[0] + 10 * (t - t[0]), walk.points)
    full = gait_initiation(slow, standing_of(slow))
    assert 1.0 < slow.times[0] - full.times[0] <= 3.0


def test_two_frames_and_no_feet():
    walk = cut(synthetic_walk(obstacle=0.0), 2.0, 2.01)
    assert len(walk.times) == 2
    points = {name: track for name, track in walk.points.items() if "foot" not in name}
    bare = Recording(walk.times, points)
    full = gait_initiation(bare, standing_of(bare))
    assert full.first_frame > 0 and np.isfinite(full.points["left_shank"]).all()
    low = min(full.points[f"{side}_shank"][:, 1, 2].min() for side in SIDES)
    floor = min(standing_of(bare)[f"{side}_shank"][1, 2] for side in SIDES)
    assert low > min(floor, *(points[f"{s}_shank"][:, 1, 2].min() for s in SIDES)) - 2e-3
