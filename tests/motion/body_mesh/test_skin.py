# SPDX-License-Identifier: LGPL-3.0-or-later
"""The skin of a wearer through walks: no triangle turned inside-out, volumes kept, rates exact."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from contact.body.surface_motion import SurfaceMotion
from contact.geometry.triangle_mesh.closed import closed_surface, volume
from shellform.motion.anthropometry import ellipsoids
from shellform.motion.body_mesh.fitting import asked_girths
from shellform.motion.body_mesh.segment_volumes import SegmentVolumes
from shellform.motion.body_mesh.skin import skin_of
from shellform.motion.gait.synthetic_walk import synthetic_walk
from shellform.motion.proportions import STATURE
from shellform.motion.recording import JOINTS, SEGMENTS, Recording
from shellform.motion.wearer import Wearer

from .manikin import manikin


def wearer_of(recording):
    return Wearer(recording, ellipsoids(recording.lengths()))


@pytest.fixture(scope="module")
def walk():
    return wearer_of(synthetic_walk(strides=1, obstacle=0.0))


@pytest.fixture(scope="module")
def skin(walk):
    return skin_of(walk, manikin(), STATURE, asked_girths(STATURE))


def test_stands_at_the_start_as_it_was_bound(walk, skin):
    assert isinstance(skin, SurfaceMotion)
    x = skin.positions(walk.start, np.empty((skin.vertex_count, 3)))
    closed_surface(x, skin.triangles, "skin")
    assert abs(x[:, 2].min()) < 1e-9
    assert skin.names == SEGMENTS
    knee = walk.new_joints(walk.start).centres[walk.joints.index("right_knee")]
    near = x[(np.abs(x[:, 2] - knee[2]) < 0.012) & (x[:, 1] < 0)]
    middle = 0.5 * (near.min(axis=0) + near.max(axis=0))
    assert np.abs(middle[:2] - knee[:2]).max() < 0.012


def test_no_triangle_turns_and_the_volume_stays(walk, skin):
    n, T = skin.vertex_count, skin.triangles
    x = skin.positions(walk.start, np.empty((n, 3)))
    normals, whole = crosses(x, T), volume(x, T)
    turned = skin.bound.axes
    least, volumes, changes = [], [], []
    which = np.array([list(walk.recording.points).index(name) for name in skin.names])
    parts = SegmentVolumes(skin, x, lambda t, out: walk.segments_into(t, which, out))
    rest = parts(walk.start, x)
    for t in np.linspace(walk.start, walk.end, 40):
        x = skin.positions(t, x)
        changes.append(parts(t, x) / rest - 1.0)
        pose = walk.segment_pose(t, SEGMENTS)
        turns = [pose.axes[j].T @ turned[j] for j in range(len(SEGMENTS))]
        q = Rotation.from_matrix(turns).as_quat()
        q *= np.where(q @ q[0] < 0, -1.0, 1.0)[:, None]  # no segment turns by half against another
        of_vertex = np.einsum("ik,ikc->ic", skin.weights, q[skin.which])
        carried = sum(Rotation.from_quat(of_vertex[T[:, k]]).apply(normals) for k in range(3))
        now = crosses(x, T)
        size = np.linalg.norm(carried, axis=1) * np.linalg.norm(now, axis=1)
        least.append((np.einsum("ij,ij->i", carried, now) / size).min())
        volumes.append(volume(x, T) / whole)
    assert min(least) > 0.1
    assert 0.95 < min(volumes) <= max(volumes) < 1.05
    assert np.abs(changes).max() < 0.06  # crude legs; 5 % on the installed bodies


def crosses(x, T):
    return np.cross(x[T[:, 1]] - x[T[:, 0]], x[T[:, 2]] - x[T[:, 0]])


def test_power_over_the_joints(walk, skin):
    """Force on the skin times its speed is force and moment on the segments times theirs."""
    n = skin.vertex_count
    force = np.zeros((n, 6))
    force[:, :3] = np.random.default_rng(0).normal(size=(n, 3))
    for t in np.linspace(0.2, 0.9, 5) * walk.end:
        velocity = skin.velocities(t, np.empty((n, 3)))
        book = np.zeros((len(SEGMENTS), 9))
        skin.add_to_segments(t, force, book)
        pose = walk.segment_pose(t, SEGMENTS)
        power = np.sum(force[:, :3] * velocity)
        of_segments = np.sum(book[:, :3] * pose.velocities) + np.sum(book[:, 3:6] * pose.spins)
        assert abs(power - of_segments) < 1e-9 * np.abs(force[:, :3] * velocity).sum()
        # over joints: all that is below, about the joint, times how it turns against what is above
        joints = walk.joint_state(t, walk.new_joints())
        moment = {}
        for joint, (above, below, _) in JOINTS.items():
            k = walk.joints.index(joint)
            under = [s for s in SEGMENTS if s == below or below_of(s, below)]
            which = [SEGMENTS.index(s) for s in under]
            arm = pose.centres[which] - joints.centres[k]
            moment[joint] = (book[which, 3:6] + np.cross(arm, book[which, :3])).sum(axis=0)
        over = sum(moment[j] @ joints.spins[walk.joints.index(j)] for j in moment)
        base = base_power(pose, book)
        # a joint's centre, as both of its segments carry it, is one point of this walk
        assert abs(power - base - over) < 1e-6 * np.abs(force[:, :3] * velocity).sum()


def below_of(segment, above):
    chain = {below: up for up, below, _ in JOINTS.values()}
    while segment in chain:
        segment = chain[segment]
        if segment == above:
            return True
    return False


def base_power(pose, book):
    """Power of all forces if the whole body moved as the pelvis does."""
    arm = pose.centres - pose.centres[0]
    moment = (book[:, 3:6] + np.cross(arm, book[:, :3])).sum(axis=0)
    return book[:, :3].sum(axis=0) @ pose.velocities[0] + moment @ pose.spins[0]


def closed_legs(recording, angle):
    """The recording with both legs turned towards each other by an angle."""
    points = {name: np.array(track) for name, track in recording.points.items()}
    for side, sign in (("right", 1.0), ("left", -1.0)):
        hip = points[f"{side}_thigh"][:, :1].copy()
        turn = Rotation.from_rotvec([sign * angle, 0.0, 0.0]).as_matrix()
        for part in ("thigh", "shank", "foot"):
            track = points[f"{side}_{part}"]
            track[:] = hip + (track - hip) @ turn.T
    return Recording(recording.times, points)


def test_thighs_give_way_to_each_other(walk):
    """Legs that close by 8 degrees each: carried by its segment alone a thigh passes the middle."""
    wearer = wearer_of(closed_legs(walk.recording, np.radians(8.0)))
    closed = skin_of(wearer, manikin(), STATURE, asked_girths(STATURE))
    x = closed.positions(wearer.start, np.empty((closed.vertex_count, 3)))
    pose, points = wearer.segment_pose(wearer.start, SEGMENTS), closed.points
    for side, sign in (("right", -1.0), ("left", 1.0)):
        k = SEGMENTS.index(f"{side}_thigh")
        inner = (closed.which[:, 0] == k) & (closed.weights[:, 0] > 0.9) & (points[:, 2] > 0.68)
        turn = pose.axes[k].T @ closed.bound.axes[k]
        rigid = pose.centres[k] + (points - closed.bound.centres[k]) @ turn.T
        assert (sign * rigid[inner, 1]).min() < -0.008
        assert (sign * x[inner, 1]).min() > 0.001


def test_a_recording_without_feet(walk):
    recording = walk.recording
    points = {name: track for name, track in recording.points.items() if "foot" not in name}
    bare = Wearer(Recording(recording.times, points), ellipsoids(recording.lengths(), feet=False))
    skin = skin_of(bare, manikin(), STATURE)
    assert skin.names == tuple(name for name in SEGMENTS if "foot" not in name)
    assert np.isfinite(skin.positions(0.5, np.empty((skin.vertex_count, 3)))).all()
