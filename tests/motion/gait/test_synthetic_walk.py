# SPDX-License-Identifier: LGPL-3.0-or-later
"""The walk without a capture: published angles, rolling feet, clearance, smoothness, symmetry."""

import numpy as np
import pytest

from contact.body.segment_frame import pose_from_markers
from shellform.motion.gait.footfall import rolled, sole, turned
from shellform.motion.gait.synthetic_walk import joint_angles, standing, synthetic_walk
from shellform.motion.proportions import STATURE
from shellform.motion.recording import SEGMENTS, SIDES

# Angles [degree] of hip and knee over a level stride from heel strike to heel strike: means of 15
# adults (BioCV, as in myogait 0.9.2) and of 10 (CROSS_OBSTACLE_DATASET, trials without obstacle).
PERCENT = (0, 10, 20, 30, 40, 50, 60, 65, 70, 75, 80, 90)
HIP = (
    (21.6, 18.2, 8.8, -3.0, -12.7, -18.6, -13.6, -4.2, 5.5, 13.5, 19.0, 21.8),
    (28.5, 23.2, 12.7, 1.8, -7.1, -13.5, -10.2, -2.0, 7.7, 16.4, 22.8, 25.3),
)
KNEE = (
    (5.2, 17.0, 16.4, 8.3, 5.0, 11.3, 37.6, 53.7, 62.3, 61.6, 52.8, 17.2),
    (11.4, 17.7, 16.4, 11.3, 9.2, 14.1, 37.5, 54.4, 65.2, 66.3, 58.4, 22.3),
)


@pytest.fixture(scope="module")
def walk():
    return synthetic_walk()


@pytest.fixture(scope="module")
def level():
    return synthetic_walk(obstacle=0.0, rate=200.0)


def strikes(recording, side):
    return [time for name, time in recording.facts["events"] if name == f"{side}_heel_strike"]


def soles(recording, side):
    """Sole (n, k, 3) of a foot, rebuilt from its points J1, J2, M alone."""
    heel, toe, marker = np.moveaxis(recording.points[f"{side}_foot"], 1, 0)
    axes = pose_from_markers(heel, toe, marker)[1]
    sign = -1.0 if side == "right" else 1.0
    scale = recording.facts["stature"] / STATURE
    outline = sole() * scale
    from_heel = outline - outline[0]  # the outline begins at the heel end
    return (
        heel[:, None]
        + from_heel[None, :, :1] * axes[:, None, 0]
        + from_heel[None, :, 1:] * sign * axes[:, None, 2]
    )


@pytest.mark.parametrize("side", SIDES)
def test_level_stride_has_published_angles(level, side):
    """Hip and knee within 4.5 degrees rms of either mean curve; peaks in the published range."""
    angles = joint_angles(level)
    begin, end = strikes(level, side)[-3:-1]
    at = begin + np.array(PERCENT) / 100 * (end - begin)
    within = (level.times >= begin) & (level.times <= end)
    hip, knee = angles[f"{side}_hip_flexion"], angles[f"{side}_knee_flexion"]
    for track, curves in ((hip, HIP), (knee, KNEE)):
        found = np.interp(at, level.times, track)
        for curve in curves:
            assert np.sqrt(np.mean((found - curve) ** 2)) < 4.5
    assert 25 < hip[within].max() < 35 and -20 < hip[within].min() < -10
    assert 60 < knee[within].max() < 66
    stance = within & (level.times < begin + 0.45 * (end - begin))
    assert knee[stance].max() < 20.5
    ankle = angles[f"{side}_ankle_dorsiflexion"][within]
    assert -30 < ankle.min() < -10 and 10 < ankle.max() < 25


def test_level_stride_has_published_measures(level):
    """Step, cadence, stance and pelvis: men of Murray 1964 and free captures."""
    right, left = strikes(level, "right"), strikes(level, "left")
    heel = {
        side: np.interp(strikes(level, side), level.times, level.points[f"{side}_foot"][:, 0, 0])
        for side in SIDES
    }
    steps = np.array(heel["left"][1:]) - heel["right"][1:]
    assert np.all((steps > 0.64) & (steps < 0.79))
    assert level.facts["stride_length"] == pytest.approx(heel["right"][2] - heel["right"][1])
    cadence = 120.0 / (right[2] - right[1])
    assert 105 < cadence < 117 and level.facts["cadence"] == pytest.approx(cadence)
    off = next(t for name, t in level.facts["events"] if name == "right_toe_off" and t > right[1])
    assert 0.57 < (off - right[1]) / (right[2] - right[1]) < 0.63
    within = (level.times >= left[1]) & (level.times <= left[2])
    middle = level.points["pelvis"][within, 1]
    assert 0.038 < np.ptp(middle[:, 2]) < 0.050
    assert np.ptp(middle[:, 1]) == pytest.approx(0.040, abs=0.008)


def test_crossing_is_within_the_joints(walk):
    """Lead and trail foot clear the obstacle by 5 to 10 cm with joints that people have."""
    angles = joint_angles(walk)
    for side in SIDES:
        assert angles[f"{side}_hip_flexion"].max() < 115
        assert 120 < angles[f"{side}_knee_flexion"].max() < 140
        assert angles[f"{side}_knee_flexion"].min() > 2.9
        assert angles[f"{side}_hip_abduction"].max() < 25
        assert np.abs(angles[f"{side}_ankle_dorsiflexion"]).max() < 30
    assert angles["right_hip_flexion"].max() > angles["left_hip_flexion"].max() + 30  # who leads


CLEARED = [(0.5, 0.06, 1.755), (0.3, 0.03, 1.755), (0.1, 0.06, 1.9), (0.5, 0.07, 1.65)]


@pytest.mark.parametrize("height, depth, stature", CLEARED)
def test_feet_and_shanks_clear_the_obstacle(height, depth, stature):
    recording = synthetic_walk(stature, obstacle=height, depth=depth, rate=400.0)
    box = recording.facts["obstacle"]
    assert (box["height"], box["depth"]) == (height, depth)
    for side in SIDES:
        points = soles(recording, side)
        x, z = points[..., 0], points[..., 2]
        over = (x > box["front"]) & (x < box["front"] + depth)
        low = z[over].min() - height
        assert 0.05 < low < 0.10
        knee, ankle = np.moveaxis(recording.points[f"{side}_shank"][:, :2], 1, 0)
        for part in np.linspace(0, 1, 11):
            p = knee + part * (ankle - knee)
            over = (p[:, 0] > box["front"]) & (p[:, 0] < box["front"] + depth)
            assert p[over, 2].min() > height + 0.05
    crossed = [
        track[0, 0, 0] < box["front"] < track[-1, 0, 0] for track in recording.points.values()
    ]
    assert all(crossed)


def test_any_obstacle_and_stature_within_reach():
    """Corners of what is accepted: joints stay human, the sole stays off."""
    for stature, share in ((1.5, 0.02), (1.5, 0.2), (1.95, 0.305)):
        for stride in (2, 3):
            height, depth = share * stature, 0.045 * stature
            recording = synthetic_walk(stature, 3, height, stride, depth=depth)
            angles = joint_angles(recording)
            for side in SIDES:
                assert angles[f"{side}_knee_flexion"].max() < 142
                assert angles[f"{side}_hip_flexion"].max() < 122
                assert angles[f"{side}_knee_flexion"].min() > 1


def test_segments_keep_their_lengths(walk):
    for name, track in walk.points.items():
        length = np.linalg.norm(track[:, 1] - track[:, 0], axis=1)
        assert np.ptp(length) < 1e-12, name
    assert set(walk.points) == set(SEGMENTS)
    # thigh and shank of the right stature, de Leva 1996 and ANSUR II heights
    lengths = walk.lengths()
    assert 0.233 < lengths["right_thigh"][0] / 1.755 < 0.2430
    assert 0.238 < lengths["left_shank"][0] / 1.755 < 0.2493
    assert lengths["left_foot"][0] / 1.755 == pytest.approx(0.152, abs=5e-4)


def test_joints_stay_together(walk):
    """The mid of both hips is the pelvis's J2, knees and ankles are shared, hip spacing is kept."""
    points = walk.points
    hips = [points[f"{side}_thigh"][:, 0] for side in SIDES]
    assert np.abs(0.5 * (hips[0] + hips[1]) - points["pelvis"][:, 1]).max() < 1e-12
    assert np.ptp(np.linalg.norm(hips[0] - hips[1], axis=1)) < 1e-12
    for side in SIDES:
        thigh, shank, foot = (points[f"{side}_{part}"] for part in ("thigh", "shank", "foot"))
        assert np.abs(thigh[:, 1] - shank[:, 0]).max() < 1e-12
        for end in (0, 1):  # the ankle is fixed in the foot
            assert np.ptp(np.linalg.norm(shank[:, 1] - foot[:, end], axis=1)) < 1e-12


def test_poses_of_every_segment(walk):
    for name, track in walk.points.items():
        axes = pose_from_markers(*np.moveaxis(track, 1, 0))[1]
        assert np.isfinite(axes).all() and np.abs(np.linalg.det(axes) - 1).max() < 1e-12, name


@pytest.mark.parametrize("obstacle", [0.0, 0.5])
def test_two_continuous_derivatives(obstacle):
    """Accelerations jump from frame to frame by what falls with the time between them."""
    jumps = []
    for rate in (200.0, 800.0):
        recording = synthetic_walk(obstacle=obstacle, rate=rate)
        tracks = np.concatenate(list(recording.points.values()), axis=1)
        acceleration = np.diff(tracks, 2, axis=0) * rate**2
        jumps.append(np.abs(np.diff(acceleration, axis=0)).max())
    assert jumps[0] / jumps[1] > 3.0  # 4 with a bounded third derivative, 1 with a step
    assert np.abs(acceleration).max() < 150.0  # m/s^2: toes at toe-off are the fastest


def test_starts_from_standing():
    """At rest in the pose of `standing`, for the time asked for, then off without a jerk."""
    recording = synthetic_walk(stand=0.25, rate=1000.0)
    pose = standing(recording.lengths())
    for name, track in recording.points.items():
        assert np.abs(track[:251] - pose[name]).max() < 1e-9, name
        # from zero velocity and acceleration the way begins with t^3
        moved = np.abs(track[[260, 270]] - track[250]).max(axis=(1, 2))
        assert moved[1] < 1e-3 and (moved[1] < 9 * moved[0] or moved[1] < 1e-9), name
    assert np.abs(recording.points["pelvis"][400] - pose["pelvis"]).max() > 1e-3


@pytest.mark.parametrize("obstacle", [0.0, 0.5])
def test_feet_roll_on_the_floor(obstacle):
    """Never more than 1 mm into the floor; what touches it stands still."""
    rate = 400.0
    recording = synthetic_walk(obstacle=obstacle, rate=rate)
    for side in SIDES:
        points = soles(recording, side)
        z = points[..., 2]
        assert z.min() > -1e-3
        lowest = z.argmin(axis=1)
        frames = np.arange(1, len(z) - 1)
        pick = lowest[frames]
        touching = (z[frames, pick] < 5e-4) & (np.abs(np.diff(lowest))[frames - 1] < 3)
        slip = points[frames + 1, pick] - points[frames - 1, pick]
        speed = np.linalg.norm(slip[..., :2], axis=1) * rate / 2
        assert touching.sum() > rate  # feet are on the floor for more than a second
        within = [  # frames at strike and off belong half to the swing
            (recording.times[frames] > on + 0.005) & (recording.times[frames] < off - 0.005)
            for on, off in stances(recording, side)
        ]
        assert speed[touching & np.any(within, axis=0)].max() < 0.06


def stances(recording, side):
    """(strike, toe-off) times; the first from the beginning."""
    on = [0.0, *strikes(recording, side)]
    off = [time for name, time in recording.facts["events"] if name == f"{side}_toe_off"]
    return list(zip(on, [*off, recording.times[-1]], strict=False))


def test_rolling_without_slip():
    """The foot's point of contact stands still and on the floor; derivatives agree."""
    outline = sole(2001)
    for rate in (2.0, -2.0):
        times = np.linspace(0.0, 0.25, 6)
        pitch = rate * times
        place, velocity, acceleration = rolled(pitch, rate, 0.0)
        h = 1e-5
        ahead, back = rolled(pitch + rate * h)[0], rolled(pitch - rate * h)[0]
        assert np.abs((ahead - back) / (2 * h) - velocity)[1:].max() < 1e-7
        assert np.abs((ahead - 2 * place + back) / h**2 - acceleration)[1:].max() < 1e-3
        points = place[:, None] + turned(outline, pitch)
        assert np.abs(points[..., 1].min(axis=1)).max() < 1e-5
        assert np.allclose(rolled(0.0)[0], (0.0, 0.075))


def test_mirrored_walk_starts_with_the_other_foot(walk):
    """Sides and y swapped: the walk of who starts left."""
    other = synthetic_walk(first="left")
    for name, track in walk.points.items():
        side = {"right": "left", "left": "right"}.get(name.split("_")[0])
        twin = other.points[name if side is None else f"{side}_{name.split('_')[1]}"]
        assert np.abs(track * [1, -1, 1] - twin).max() < 1e-12, name


def test_scales_with_stature():
    """Lengths with stature, times with its root: the same angles at the same share of time."""
    a = joint_angles(synthetic_walk(1.755, obstacle=0.5, depth=0.06, stand=0.3))
    k = 1.44 / 1.755 * 1.0
    small = synthetic_walk(
        1.44, obstacle=0.5 * k, depth=0.06 * k, stand=0.3 * np.sqrt(k), rate=100.0 / np.sqrt(k)
    )
    for name, track in joint_angles(small).items():
        n = min(len(track), len(a[name]))
        assert n > 500 and np.abs(track[:n] - a[name][:n]).max() < 1e-6, name


def test_four_strides(walk):
    """Four heel strikes of each foot, the obstacle between the third strides' footfalls."""
    for side in SIDES:
        places = np.interp(strikes(walk, side), walk.times, walk.points[f"{side}_foot"][:, 0, 0])
        assert len(places) == 4
        front = walk.facts["obstacle"]["front"]
        assert places[1] < front < places[2]
    toes = np.interp(strikes(walk, "left")[1], walk.times, walk.points["left_foot"][:, 1, 0])
    assert walk.facts["obstacle"]["front"] - toes == pytest.approx(0.24 * 0.845, abs=0.06)
    assert walk.facts["stature"] == 1.755 and walk.rate == pytest.approx(100.0)


@pytest.mark.parametrize(
    "change, message",
    [
        ({"stature": 175.5}, "stature 175.5 is not .* metres"),
        ({"strides": 0}, "strides must be a whole number"),
        ({"strides": 2.5}, "strides must be a whole number"),
        ({"obstacle": -0.1}, "obstacle of -0.1 m"),
        ({"obstacle": 0.9}, "steps over 0 to 0.54 m"),
        ({"obstacle_stride": 1}, "obstacle_stride must be one of 2 to 4"),
        ({"obstacle_stride": 5}, "obstacle_stride must be one of 2 to 4"),
        ({"rate": 5.0}, "rate must be 20"),
        ({"rate": np.nan}, "rate must be 20"),
        ({"stand": -1.0}, "stand must be a time"),
        ({"first": "Right"}, "first must be 'right' or 'left'"),
        ({"depth": 0.3}, "depth of the obstacle"),
    ],
)
def test_bad_arguments_are_refused(change, message):
    with pytest.raises(ValueError, match=message):
        synthetic_walk(**change)
