# SPDX-License-Identifier: LGPL-3.0-or-later
"""Poses and motions of the body; Eq. 17 from markers of known pose."""

import numpy as np
import pytest

from contact.body.segment_frame import pose_from_markers
from contact.body.segments import Body, Fixed, Segment, Steady, turned


def random_axes(rng):
    q = np.linalg.qr(rng.standard_normal((3, 3)))[0]
    return q * np.sign(np.linalg.det(q))


def test_pose_from_markers_of_known_poses():
    rng = np.random.default_rng(0)
    axes = np.array([random_axes(rng) for _ in range(200)])
    centre = rng.uniform(-2, 2, (200, 3))
    half = rng.uniform(0.05, 0.5, (200, 1))
    along, aside = rng.uniform(-1, 1, (200, 1)), rng.uniform(0.02, 0.3, (200, 1))
    J1, J2 = centre - half * axes[:, 0], centre + half * axes[:, 0]
    M = centre + along * axes[:, 0] + aside * axes[:, 1]
    c, found = pose_from_markers(J1, J2, M)
    assert np.abs(c - centre).max() < 1e-12
    assert np.abs(found - axes).max() < 1e-12
    assert np.abs(np.linalg.det(found) - 1).max() < 1e-12
    one = pose_from_markers(J1[3], J2[3], M[3])
    assert one[1].shape == (3, 3) and np.array_equal(one[1], found[3])


def test_axes_stay_a_rotation_when_the_marker_nears_the_line():
    J1, J2 = np.zeros(3), np.array([0.3, 0.4, 0.1])
    for offset in (1e-2, 1e-4, 2e-6):
        axes = pose_from_markers(J1, J2, 0.9 * J2 + offset * np.array([0.0, 0.1, -0.4]))[1]
        assert np.abs(axes @ axes.T - np.eye(3)).max() < 1e-14
        assert np.linalg.det(axes) == pytest.approx(1, abs=1e-14)


def test_markers_that_span_no_plane_are_refused():
    J1, J2 = np.zeros((3, 3)), np.tile([1.0, 2.0, 3.0], (3, 1))
    M = np.array([[1.0, 0, 0], [2.0, 4.0, 6.0], [0, 1.0, 0]])
    with pytest.raises(ValueError, match=r"M lies on the line J1-J2.* in row \[1\]"):
        pose_from_markers(J1, J2, M)
    with pytest.raises(ValueError, match="coincide"):
        pose_from_markers(J1[0], J1[0], M[0])
    with pytest.raises(ValueError, match="not finite"):
        pose_from_markers(J1[0], J2[0], [np.nan, 0, 0])


def test_turning_rows():
    axes = turned(np.eye(3), np.array([0.0, 0.0, np.pi / 2]))
    assert np.abs(axes - [[0, 1, 0], [-1, 0, 0], [0, 0, 1]]).max() < 1e-15
    angle = np.array([0.3, -2.0, 1.1])
    axes = turned(np.eye(3), angle)
    assert np.abs(axes @ axes.T - np.eye(3)).max() < 1e-15 * 4
    assert np.trace(axes) == pytest.approx(1 + 2 * np.cos(np.linalg.norm(angle)), abs=1e-14)
    assert np.abs(turned(axes, -angle) - np.eye(3)).max() < 1e-15 * 4


def test_steady_motion_has_the_velocity_it_says():
    rng = np.random.default_rng(1)
    motion = Steady([1, 2, 3], random_axes(rng), velocity=[0.5, -1, 2], spin=[3, -2, 1])
    h, t = 1e-5, 0.7
    ahead, back = motion.pose(t + h), motion.pose(t - h)
    _, axes, velocity, spin = motion.pose(t)
    assert np.abs((ahead[0] - back[0]) / (2 * h) - velocity).max() < 1e-9
    assert np.abs((ahead[1] - back[1]) / (2 * h) - np.cross(spin, axes)).max() < 1e-8


def swinging(t):
    """Centre on a circle, tilting about x; accelerations known in closed form."""
    centre = np.array([np.cos(2 * t), np.sin(2 * t), 0.0])
    velocity = 2 * np.array([-np.sin(2 * t), np.cos(2 * t), 0.0])
    return centre, turned(np.eye(3), np.array([np.sin(t), 0, 0])), velocity, [np.cos(t), 0, 0]


def test_body_fills_the_arrays_it_is_given():
    body = Body(
        [
            Segment("pelvis", [0.15, 0.1, 0.12], Fixed([0, 0, 1])),
            Segment("thigh", [0.2, 0.08, 0.08], Steady(velocity=[1, 0, 0])),
            Segment("foot", [0.1, 0.04, 0.04], swinging),
        ]
    )
    pose = body.new_pose()
    before = [a.ctypes.data for a in pose]
    assert body.pose(2.0, pose) is pose and before == [a.ctypes.data for a in pose]
    assert np.array_equal(pose.centres[:2], [[0, 0, 1], [2, 0, 0]])
    assert np.abs(pose.centres[2] - swinging(2.0)[0]).max() == 0
    assert np.array_equal(body.radii[1], [0.2, 0.08, 0.08]) and body.index("foot") == 2
    linear, angular = body.accelerations(0.4)
    assert np.abs(linear[2] + 4 * swinging(0.4)[0]).max() < 1e-6
    assert np.abs(angular[2] - [-np.sin(0.4), 0, 0]).max() < 1e-6
    assert not linear[:2].any()


def test_what_cannot_be_a_body_is_refused():
    fixed = Fixed()
    for radii in ([1, 1, 0], [1, -1, 1], [1, np.nan, 1], [1, 1]):
        with pytest.raises(ValueError, match="segment 'arm' needs three finite radii > 0"):
            Segment("arm", radii, fixed)
    with pytest.raises(ValueError, match="name"):
        Segment("", [1, 1, 1], fixed)
    arm = Segment("arm", [1, 1, 1], fixed)
    with pytest.raises(ValueError, match="found twice: arm"):
        Body([arm, arm])
    with pytest.raises(ValueError, match="at least one"):
        Body([])
    with pytest.raises(ValueError, match="no segment 'leg'; there are: arm"):
        Body([arm]).index("leg")


def test_poses_that_are_no_rigid_motion_are_refused():
    zero = np.zeros(3)
    mirrored, stretched = np.diag([1.0, 1, -1]), np.diag([1.0, 1, 1 + 1e-6])
    for axes in (mirrored, stretched):
        with pytest.raises(ValueError, match="axes of segment 'arm'"):
            Body([Segment("arm", [1, 1, 1], Fixed(axes=axes))]).new_pose()
    lost = Segment(
        "arm", [1, 1, 1], lambda t: (zero, np.eye(3), zero, np.full(3, np.nan if t > 1 else 0))
    )
    body = Body([Segment("leg", [1, 1, 1], Fixed()), lost])
    pose = body.new_pose()
    with pytest.raises(ValueError, match=r"motion of segment 'arm' is not finite at t = 2 s"):
        body.pose(2.0, pose)


class Slab:
    """A shape that contact has not been told of."""


@pytest.mark.parametrize("shape", [Slab(), "abc", [0.1, "b", 0.1]])
def test_a_shape_that_contact_does_not_know(shape):
    with pytest.raises(
        ValueError, match=r"'slab' takes three radii in m or one of the shapes .*Caps"
    ):
        Segment("slab", shape, Fixed())


@pytest.mark.parametrize("motion", [None, 3, (0.0, 0.0, 0.0)])
def test_a_motion_that_is_none(motion):
    with pytest.raises(ValueError, match="segment 'ball' moves by a motion as Fixed"):
        Segment("ball", (0.1, 0.1, 0.1), motion)
