# SPDX-License-Identifier: LGPL-3.0-or-later
"""A node between several bodies: creases, pockets, pinching, ways out."""

import numpy as np
import pytest

from contact.body.segments import Body, Fixed, Segment
from contact.solver.velocity_correction import VelocityCorrection
from tests.contact.solver.bodies import LIMB, G, clearance, outside, random_axes, spheres


def groove(radius=0.1, half=0.08):
    """Two overlapping spheres and the height of their crease above the centres."""
    return spheres((-half, 0, 0), (half, 0, 0), radius=radius), np.sqrt(radius**2 - half**2)


def sweep(count, depth):
    """A node at the crease pushed `depth` below it, start and end swept across by +- 2 depths."""
    body, crease = groove()
    s = 2 * depth * np.linspace(-1, 1, count)
    skin = np.sqrt(0.1**2 - (np.abs(s) - 0.08) ** 2)  # height of the union of the two
    x = np.column_stack([s, 0 * s, skin + 0.1 * depth])
    v = np.zeros_like(x)
    v[:, 1], v[:, 2] = 0.3 * depth, crease - depth - x[:, 2]
    correction = VelocityCorrection(body, count)
    correction(x, v, np.ones(count), 1.0, 0.0)
    return s, x + v, correction


@pytest.mark.parametrize("depth", [1e-5, 1e-3, 5e-3])
def test_node_swept_through_a_crease_moves_continuously(depth):
    """Twice as many positions, half the greatest jump of place and direction."""
    jumps = []
    for count in (400, 800, 1600):
        _, end, correction = sweep(count, depth)
        direction = correction.last.impulse
        direction = direction / np.linalg.norm(direction, axis=1, keepdims=True)
        assert (correction.segment >= 0).all() and not correction.pinched
        jumps.append([np.abs(np.diff(q, axis=0)).max() for q in (end, direction)])
        assert clearance(correction.body, 0, end).min() > -1e-12
    jumps = np.array(jumps)
    assert np.all(jumps[1:] < 0.55 * jumps[:-1])
    assert jumps[-1, 0] < 2 * 4 * depth / 1600 and jumps[-1, 1] < 5e-3


def test_crease_shares_the_force():
    _, end, correction = sweep(401, 3e-3)
    book = correction.last
    # the sweep as a whole is symmetric, and its middle position alone
    mirror = np.array([-1, 1, 1])
    left, right = book.segment_impulse
    assert np.abs(left * mirror - right).max() < 1e-12 * np.abs(left).max()
    assert np.abs(end[::-1] * mirror - end).max() < 1e-13
    body, crease = groove()
    for mu in (0.0, 0.4):
        correction = VelocityCorrection(body, 1, mu)
        x, v = np.array([[0, 0, crease]]), np.array([[0.0, 0.01, -0.1]])
        correction(x, v, np.ones(1), 1e-3, 0.0)
        left, right = correction.last.segment_impulse
        assert np.abs(left * mirror - right).max() < 1e-15
        # the pushes along the two normals carry the whole approach: 2 l n_z = 0.1
        n = np.array([0.08, 0, crease]) / 0.1
        assert left[0] == pytest.approx(0.05 * n[0] / n[2], rel=1e-9)
        assert left[2] + right[2] == pytest.approx(0.1, rel=1e-9)
        # friction along the groove by the sum of the two pushes, stopping the slip at most
        assert left[1] + right[1] == pytest.approx(-min(0.01, mu * 0.1 / n[2]), rel=1e-6, abs=1e-12)


def test_groove_holds_with_the_sum_of_its_sides():
    """Gravity along a straight groove: the wedge factor 1 / sin(half opening) on mu."""
    body, crease = groove(1e3, 600.0)
    factor = 1e3 / crease  # 2 l = weight / n_z
    for slope, holds in ((0.98 * 0.3 * factor, True), (1.05 * 0.3 * factor, False)):
        angle = np.arctan(slope)
        gravity = G * np.array([0, np.sin(angle), -np.cos(angle)])
        correction = VelocityCorrection(body, 1, 0.3)
        x, v, dt = np.array([[0.0, 0, crease]]), np.zeros((1, 3)), 1e-3
        for step in range(1000):
            v += gravity * (dt if step else dt / 2)
            correction(x, v, np.ones(1), dt, step * dt)
            x += dt * v
        exact = 0.5 * G * (np.sin(angle) - 0.3 * factor * np.cos(angle))
        if holds:
            assert abs(x[0, 1]) < 1e-9 and correction.sticking == 1
        else:
            assert x[0, 1] == pytest.approx(exact, rel=1e-2)


def test_rest_in_the_pocket_of_three_spheres():
    """Three equal shares of the weight, on the average and in the last step."""
    angles = 2 * np.pi * np.arange(3) / 3
    centres = 0.11 * np.column_stack([np.cos(angles), np.sin(angles), 0 * angles])
    height = np.sqrt(0.13**2 - 0.11**2)
    correction = VelocityCorrection(spheres(*centres, radius=0.13), 1, 0.0)
    x, v, dt = np.array([[1e-3, -5e-4, height + 2e-3]]), np.zeros((1, 3)), 1e-3
    for step in range(400):
        v[0, 2] -= G * dt
        correction(x, v, np.ones(1), dt, step * dt)
        x += dt * v
    assert x[0] == pytest.approx([0, 0, height], abs=1e-9)
    impulse = correction.last.segment_impulse
    assert impulse[:, 2] == pytest.approx(np.full(3, G * dt / 3), rel=1e-6)
    assert np.abs(impulse.sum(axis=0) - [0, 0, G * dt]).max() < 1e-9 * G * dt


@pytest.mark.parametrize("mu", [0.0, 0.5])
def test_concentric_duplicates_do_not_double_the_force(mu):
    rng = np.random.default_rng(5)
    pose = Fixed([0.1, 0, -0.1], random_axes(rng))
    single = Body([Segment("a", LIMB, pose)])
    triple = Body([Segment(name, LIMB, pose) for name in "abc"])
    x = outside(single, 0, rng, 100, 2e-3)
    v0 = rng.standard_normal(x.shape)
    results = []
    for body in (single, triple):
        correction = VelocityCorrection(body, len(x), mu)
        for _ in range(3):
            v = v0.copy()
            correction(x, v, np.ones(len(x)), 2e-3, 0.0)
        results.append((v, correction.last.segment_impulse.sum(axis=0), correction))
    assert results[0][2].active > 20
    assert np.array_equal(results[0][0], results[1][0])
    assert results[0][1] == pytest.approx(results[1][1], rel=1e-13)
    # each node has one of them, and keeps it
    assert not results[1][2].last.segment_impulse[1:].any()


def test_pinched_node_is_held_and_counted_not_ejected():
    """Two spheres close to less than two offsets and open again."""

    def motion(sign):
        def pose(t):
            # from a gap of 8 mm to 2 mm and back, the offset is 2 mm
            gap = 0.004 - 0.003 * np.sin(np.pi * min(t, 1.0)) ** 2
            return np.array([sign * (0.1 + gap), 0, 0]), np.eye(3), np.zeros(3), np.zeros(3)

        return pose

    body = Body([Segment("left", [0.1] * 3, motion(-1)), Segment("right", [0.1] * 3, motion(1))])
    correction = VelocityCorrection(body, 1, 0.3, offset=0.002)
    x, v, dt, mass = np.array([[-0.001, 0.001, 0]]), np.zeros((1, 3)), 1e-3, np.array([1e-3])
    pinched, fastest = 0, 0.0
    for step in range(1200):
        correction(x, v, mass, dt, step * dt)
        pinched += correction.pinched
        fastest = max(fastest, np.linalg.norm(v))
        x += dt * v
    # the spheres move at 1 cm/s, and a node inside leaves at 10 cm/s at most
    assert pinched > 100 and fastest < 0.1
    assert np.linalg.norm(x) < 0.005
    assert not correction.pinched and clearance(body, 1.2, x).min() > 0.002 - 1e-9


def test_node_that_starts_inside_is_moved_out_at_the_recovery_speed():
    body, dt = spheres((0, 0, 0), (0.02, 0, 0)), 1e-3
    correction = VelocityCorrection(body, 1, 0.0, recovery=0.5)
    x, v = np.array([[-0.05, 0.0, 0.0]]), np.zeros((1, 3))
    depths = []
    for step in range(200):
        v[:] = 0
        correction(x, v, np.ones(1), dt, step * dt)
        assert np.linalg.norm(v) < 0.5 * (1 + 1e-12)
        depths.append(correction.max_depth)
        x += dt * v
    assert depths[0] == pytest.approx(0.05) and depths[-1] < 1e-12
    assert x[0] == pytest.approx([-0.1, 0, 0], abs=1e-12)
    # out of the lens of two bodies: the near skin of the other is inside and no way out
    x = np.array([[0.03, 0.02, 0.0]])
    for step in range(400):
        v[:] = 0
        correction(x, v, np.ones(1), dt, step * dt)
        x += dt * v
    assert clearance(body, 0, x).min() == pytest.approx(0, abs=1e-12)
    assert x[0, 0] > 0.03
