# SPDX-License-Identifier: LGPL-3.0-or-later
"""Skin on several segments: against a slow twin, differences in time, the adjoint."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

from contact.body.bulge import Bulge, Swell
from contact.body.flesh import kept_on_side
from contact.body.segments import Pose
from contact.body.skinned_surface import LEAST, Bend, SkinnedSurface

RADIUS, LONG = 0.06, 0.4  # of a leg whose knee is at the origin, the thigh upwards [m]
NAMES = ("thigh", "shank")


def leg():
    """Vertices, triangles and weights of a closed tube; weights by the angle behind the knee."""
    heights, around = np.linspace(LONG, -LONG, 41), 2 * np.pi * np.arange(24) / 24
    ring = RADIUS * np.stack([np.cos(around), np.sin(around)], axis=1)
    points = [np.column_stack([ring, np.full(24, z)]) for z in heights]
    points = np.concatenate([*points, [[0, 0, LONG], [0, 0, -LONG]]])
    triangles = []
    for k in range(40):
        for a, b in zip(range(24), [*range(1, 24), 0], strict=True):
            p, q, r, s = 24 * k + a, 24 * k + b, 24 * k + 24 + b, 24 * k + 24 + a
            triangles += [(p, s, r), (p, r, q)]
    for a, b in zip(range(24), [*range(1, 24), 0], strict=True):
        triangles += [(984, a, b), (985, 960 + b, 960 + a)]
    shank = np.clip(0.5 - np.arctan2(points[:, 2], np.hypot(points[:, 0], 0.025)) / 2.4, 0, 1)
    return points, np.array(triangles), np.column_stack([1 - shank, shank])


def bending(t, out, rest):
    """Thigh tumbles, knee bends up to 150 degrees at t = 1: centres, axes, velocities, spins."""

    def place(t):
        thigh = Rotation.from_rotvec(np.array([0.3, -0.5, 0.2]) * np.sin(t))
        shank = thigh * Rotation.from_rotvec([0.0, np.radians(150.0) * t, 0.0])
        knee = np.array([0.1 * t, 0.3 * t**2, -0.2 * np.sin(t)])
        return knee, (thigh, shank)

    h = 1e-4
    knee, turns = place(t)
    (ahead, after), (back, before) = place(t + h), place(t - h)
    for j in range(2):
        arm = rest.centres[j]
        out.centres[j] = knee + turns[j].apply(arm)
        out.axes[j] = rest.axes[j] @ turns[j].as_matrix().T
        out.velocities[j] = (ahead + after[j].apply(arm) - back - before[j].apply(arm)) / (2 * h)
        out.spins[j] = (after[j] * before[j].inv()).as_rotvec() / (2 * h)
    return out


def rest():
    axes = Rotation.from_rotvec([[0.0, 0.4, 0.0], [0.2, 0.0, 0.1]]).as_matrix()
    return Pose(np.array([[0.0, 0, 0.2], [0.01, 0, -0.2]]), axes, *np.zeros((2, 2, 3)))


def knee(room=0.0):
    up, down = np.array([0.0, 0.0, LONG]), np.array([0.0, 0.0, -LONG])
    return Bend("thigh", "shank", np.zeros(3), up, down, room=room)


def between(n):
    """Rows of a matrix that draws each vertex a little to the next."""
    columns = np.stack([np.arange(n), np.roll(np.arange(n), -1)], axis=1).ravel()
    return 2 * np.arange(n + 1), columns, np.tile([0.9, 0.1], n)


def bulge(points):
    """Thigh and shank bulge along and across the limb, the thigh by both cosines at once."""
    fields = np.where(points[:, 2] > 0.05, 0, np.where(points[:, 2] < -0.03, 1, -1))
    fields[::7] = -1
    directions = np.random.default_rng(5).normal(size=points.shape)
    ahead, up = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
    c = np.linspace(-0.9, 0.8, 6)
    rising = CubicSpline(c, 0.01 * np.sin(3.0 * c)).c[::-1].T
    swells = [
        Swell(0, *NAMES, up, -up, (c[0], c[-1]), rising),
        Swell(0, *NAMES, ahead, up, (-1.0, 1.0), [[0.0, -0.01, 0.005, 0.001]]),
        Swell(1, *NAMES, up, np.sqrt(0.5) * (ahead - up), (c[0], c[-1]), -2.0 * rising),
    ]
    return Bulge(fields, directions, swells)


@pytest.fixture(params=["", "smoothed", "bulged"])
def skin(request):
    points, triangles, weights = leg()
    bound, way = rest(), request.param
    return SkinnedSurface(
        points, triangles, weights, NAMES, lambda t, out: bending(t, out, bound), bound,
        [knee(0.004 if way else 0.0)],
        between(len(points)) if way else None,
        bulge(points) if way == "bulged" else None,
    )  # fmt: skip


def places(skin, t):
    return skin.positions(t, np.empty((skin.vertex_count, 3))).copy()


def slow(t, press=True, points=None):
    """Positions by whole quaternions of scipy, one vertex after the other; points: as bulged."""
    bound_at, _, weights = leg()
    points = bound_at if points is None else points
    weights = np.where(weights < LEAST, 0.0, weights)
    weights /= weights.sum(axis=1, keepdims=True)
    bound = rest()
    pose = bending(t, Pose(*(np.zeros_like(part) for part in bound)), bound)
    turns = [Rotation.from_matrix(pose.axes[j].T @ bound.axes[j]) for j in range(2)]
    q = np.array([turn.as_quat() for turn in turns])
    q[1] *= np.sign(q[0] @ q[1])
    d = []
    for j in range(2):
        shift = pose.centres[j] - turns[j].apply(bound.centres[j])
        d.append(0.5 * hamilton(np.append(shift, 0.0), q[j]))
    ends = (0, [0, 0, 1]), (1, [0, 0, -1])
    halves = [pose.axes[j].T @ (bound.axes[j] @ end) for j, end in ends]
    normal = (halves[0] - halves[1]) / np.linalg.norm(halves[0] - halves[1])
    at = np.mean([pose.centres[j] - turns[j].apply(bound.centres[j]) for j in range(2)], axis=0)
    out = []
    for p, at_first, w in zip(points, bound_at, weights, strict=True):
        r, e = w @ q, w @ np.array(d)
        x = Rotation.from_quat(r).apply(p)
        x += 2 * hamilton(e, r * [-1, -1, -1, 1])[:3] / (r @ r)
        side, margin = np.sign(at_first[2]), min(0.5 * abs(at_first[2]), 0.015)
        s = side * normal @ (x - at)
        if press and s < margin:
            x += side * (margin**2 / (2 * margin - s) - s) * normal
        out.append(x)
    return np.array(out)


def hamilton(a, b):
    """Product of quaternions, real part last."""
    v = a[3] * b[:3] + b[3] * a[:3] + np.cross(a[:3], b[:3])
    return np.append(v, a[3] * b[3] - a[:3] @ b[:3])


@pytest.mark.parametrize("t", [0.0, 0.35, 1.0])
def test_equals_the_slow_twin(t):
    points, triangles, weights = leg()
    bound = rest()
    skin = SkinnedSurface(
        points, triangles, weights, NAMES, lambda t, out: bending(t, out, bound), bound, [knee()]
    )
    wanted = slow(t)
    assert np.abs(places(skin, t) - wanted).max() < 1e-12
    assert t < 1.0 or np.abs(wanted - slow(t, press=False)).max() > 1e-4  # some flesh is pressed


def test_is_where_it_was_bound():
    points, triangles, weights = leg()
    bound = rest()
    still = SkinnedSurface(
        points, triangles, weights, NAMES, lambda t, out: bending(0.0, out, bound), bound, [knee()]
    )
    assert np.abs(places(still, 0.0) - points).max() < 1e-14


@pytest.mark.parametrize("t", [0.2, 0.9])
def test_velocity_is_the_derivative_of_position(skin, t):
    h = 1e-5
    velocity = skin.velocities(t, np.empty((skin.vertex_count, 3))).copy()
    difference = (places(skin, t + h) - places(skin, t - h)) / (2 * h)
    assert np.abs(velocity - difference).max() < 1e-6 * np.abs(velocity).max()


@pytest.mark.parametrize("t", [0.2, 0.9])
def test_what_is_booked_has_the_same_power_force_moment_and_energy(skin, t):
    n = skin.vertex_count
    at_vertices = np.random.default_rng(3).normal(size=(n, 6))
    at_vertices[::3] = 0.0
    book = np.zeros((2, 9))
    skin.add_to_segments(t, at_vertices, book)
    velocity = skin.velocities(t, np.empty((n, 3)))
    pose = bending(t, Pose(*(np.zeros_like(part) for part in rest())), rest())
    force = at_vertices[:, :3]
    power = np.sum(book[:, :3] * pose.velocities) + np.sum(book[:, 3:6] * pose.spins)
    # the spins here are differences
    assert abs(power - np.sum(force * velocity)) < 1e-9 * np.abs(force * velocity).sum()
    assert np.abs(book[:, :3].sum(axis=0) - force.sum(axis=0)).max() < 1e-11
    moment = book[:, 3:6].sum(axis=0) + np.cross(pose.centres, book[:, :3]).sum(axis=0)
    assert np.abs(moment - np.cross(places(skin, t), force).sum(axis=0)).max() < 1e-11
    assert np.abs(book[:, 6:].sum(axis=0) - at_vertices[:, 3:].sum(axis=0)).max() < 1e-11


def test_calf_and_thigh_meet_as_flesh_where_blended_matrices_overlap():
    points, triangles, weights = leg()
    bound, t = rest(), 0.9  # 135 degrees
    skin = SkinnedSurface(
        points, triangles, weights, NAMES, lambda t, out: bending(t, out, bound), bound, [knee()]
    )
    pose = bending(t, Pose(*(np.zeros_like(part) for part in bound)), bound)
    turns = [pose.axes[j].T @ bound.axes[j] for j in range(2)]
    at = [pose.centres[j] - turns[j] @ bound.centres[j] for j in range(2)]
    rigid = np.where(weights[:, :1] > 0.5, points @ turns[0].T + at[0], points @ turns[1].T + at[1])
    normal = turns[0] @ [0, 0, 1] - turns[1] @ [0, 0, -1]
    normal /= np.linalg.norm(normal)

    def past(x):
        return (np.sign(points[:, 2]) * ((x - np.mean(at, axis=0)) @ normal)).min()

    assert past(rigid) < -0.03  # rigid parts: each 30 mm and more beyond the plane of the other
    assert past(places(skin, t)) > -1e-12
    volume = [
        np.einsum("ij,ij->", x[triangles[:, 0]], np.cross(x[triangles[:, 1]], x[triangles[:, 2]]))
        for x in (points, places(skin, t))
    ]
    assert abs(volume[1] / volume[0] - 1) < 0.05


def test_flesh_is_smooth_and_stays_on_its_side():
    s, h = np.linspace(-0.1, 0.03, 400), 1e-7
    for margin, room in ((0.001, 0.0), (0.015, 0.0), (0.015, 0.004)):
        g, slope = np.array([kept_on_side(value, margin, room) for value in s]).T
        ahead = np.array([kept_on_side(value + h, margin, room)[0] for value in s])
        back = np.array([kept_on_side(value - h, margin, room)[0] for value in s])
        assert (g > room).all() and (slope > 0).all()
        assert np.abs((ahead - back) / (2 * h) - slope).max() < 1e-3
        assert (g[s >= margin] == s[s >= margin]).all()


def test_wrong_weights_are_refused():
    points, triangles, weights = leg()
    with pytest.raises(ValueError, match=r"takes weights \(986, 2\) whose rows add up to 1"):
        SkinnedSurface(points, triangles, weights[:, :1], NAMES, None, rest())


def test_steps_allocate_nothing(skin):
    from numba.core.runtime import rtsys

    n = skin.vertex_count
    out, at_vertices, book = np.empty((n, 3)), np.ones((n, 6)), np.zeros((2, 9))
    for t in (0.1, 0.2):
        before = rtsys.get_allocation_stats().alloc
        skin.positions(t, out)
        skin.add_to_segments(t, at_vertices, book)
        made = rtsys.get_allocation_stats().alloc - before
    assert made == 0
