# SPDX-License-Identifier: LGPL-3.0-or-later
"""The contact hook: a slow twin of the kernel, balances, settings, restart."""

import numpy as np
import pytest

from contact.body.segments import Body, Fixed, Segment
from contact.geometry.ellipsoid import closest_points
from contact.solver.friction import Friction
from contact.solver.velocity_correction import VelocityCorrection
from tests.contact.solver.bodies import G, energy, limbs, outside, spheres


def twin(x, v, mass, dt, start, end, radii, mu_s, mu_k, offset):
    """One node on one moving ellipsoid by dense search and bisection; not inside at the start."""
    (c0, a0), (c1, a1) = start, end

    def gap(y):
        foot, normal, distance = closest_points(y, radii)
        return distance[0] - offset, foot[0], normal[0]

    y0, y1 = a0 @ (x - c0), a1 @ (x + dt * v - c1)
    way = np.linalg.norm(y1 - y0)
    first_gap, foot, normal = gap(y0)
    if first_gap > way:
        return v, None
    if way > 1e-3 * radii.min() ** 2 / radii.max() and first_gap > 0:
        times = np.linspace(0, 1, 4001)
        inside = closest_points(y0 + times[:, None] * (y1 - y0), radii)[2] < offset
        if not inside.any():
            return v, None
        low, high = times[inside.argmax() - 1], times[inside.argmax()]
        for _ in range(60):
            middle = 0.5 * (low + high)
            if gap(y0 + middle * (y1 - y0))[0] < 0:
                high = middle
            else:
                low = middle
        _, foot, normal = gap(y0 + high * (y1 - y0))
    surface = (c1 + a1.T @ y0 - x) / dt
    n = a1.T @ normal
    plane = n @ (a1.T @ (foot - y0)) + offset  # along n from the start, in the moved body
    relative = v - surface
    push = plane - dt * relative @ n
    if push <= 0:
        return v, None
    relative = relative + push / dt * n
    slip = relative - (relative @ n) * n
    normal_impulse, size = mass * push / dt, np.linalg.norm(slip)
    if mass * size <= mu_s * normal_impulse:
        relative = relative - slip
    else:
        relative = relative - mu_k * normal_impulse / mass * slip / size
    return surface + relative, 0


@pytest.mark.parametrize("speed", [0.1, 3.0, 100.0])
@pytest.mark.parametrize("offset", [0.0, 0.004])
def test_kernel_does_what_its_slow_twin_does(speed, offset):
    rng = np.random.default_rng(0)
    body, dt, t = limbs(rng, 1), 1e-3, 0.3
    x = outside(body, t, rng, 60, 3e-3, offset)
    v = speed * rng.standard_normal(x.shape)
    mass = rng.uniform(1e-4, 1e-2, len(x))
    start, end = body.pose(t, body.new_pose()), body.pose(t + dt, body.new_pose())
    poses = [(p.centres[0], p.axes[0]) for p in (start, end)]
    expected = [
        twin(*node, dt, *poses, body.radii[0], 0.4, 0.3, offset)
        for node in zip(x, v, mass, strict=True)
    ]
    correction = VelocityCorrection(body, len(x), (0.4, 0.3), offset)
    correction(x, v, mass, dt, t)
    assert np.array_equal(correction.segment, [-1 if e[1] is None else 0 for e in expected])
    assert 10 < correction.active < len(x)
    assert np.abs(v - [e[0] for e in expected]).max() < 1e-9 * max(1, speed)


@pytest.mark.parametrize("flesh", [np.inf, 1e4])
@pytest.mark.parametrize("with_old", [False, True])
def test_momentum_moments_and_energy_close(with_old, flesh):
    """All that changes in the cloth is in the book, whatever the body does, hard or soft."""
    rng = np.random.default_rng(1)
    body, dt, t = limbs(rng), 2e-3, 0.1
    x = outside(body, t, rng, 400, 3e-3)
    mass = rng.uniform(1e-4, 1e-2, len(x))
    correction = VelocityCorrection(body, len(x), (0.5, 0.3), flesh=flesh)
    if flesh < np.inf:  # half of the nodes lie in all that is around them
        x[::2] += 0.2 * (body.pose(t, body.new_pose()).centres.mean(axis=0) - x[::2])
        correction.penetrated[::2] = 15
    old = 2 * rng.standard_normal(x.shape)
    free = old + 0.1 * rng.standard_normal(x.shape) if with_old else old
    v = free.copy()
    correction(x, v, mass, dt, t, old if with_old else None)
    book, impulse = correction.last, correction.last.impulse
    assert correction.active > (100 if flesh == np.inf else 50)
    assert len(set(correction.segment)) == 5
    assert (correction.pinched > 20) == (flesh < np.inf)
    change = mass[:, None] * (v - free)
    scale = np.abs(change).sum()
    assert np.abs(impulse - change).max() < 1e-15 * scale
    assert np.abs(book.segment_impulse.sum(axis=0) - change.sum(axis=0)).max() < 1e-14 * scale
    centres = body.pose(t, body.new_pose()).centres
    moment = book.segment_moment + np.cross(centres, book.segment_impulse)
    assert np.abs(moment.sum(axis=0) - np.cross(x, change).sum(axis=0)).max() < 1e-14 * scale
    # work of the forces and of contact by the mean of old and new velocity
    forces = np.sum(mass[:, None] * (free - old) * (old + v)) / 2
    booked = book.work.sum() - book.friction_loss.sum() - book.impact_loss.sum()
    gained = energy(mass, v) - energy(mass, old)
    assert gained == pytest.approx(forces + booked, abs=1e-13 * energy(mass, old))
    assert book.friction_loss.min() > 0 if not with_old else True
    assert correction.window.seconds == dt
    assert np.array_equal(correction.window.table, book.table)
    correction.reset()
    assert not correction.window.impulse.any() and not correction.window.table.any()


def test_a_node_meets_only_segments_it_can_touch():
    """Two equal spheres in one place: the node stops at the second, or falls through both."""
    body = spheres((0, 0, 0), (0, 0, 0))
    x, mass = np.tile([0.0, 0.0, 0.1], (3, 1)), np.ones(3)
    allowed = [body.mask(["s0"]), body.mask(["s1"]), 0]
    correction = VelocityCorrection(body, 3, allowed=allowed)
    v = np.tile([0.0, 0.0, -1.0], (3, 1))
    correction(x, v, mass, 1e-3, 0.0)
    assert correction.segment.tolist() == [0, 1, -1]
    np.testing.assert_allclose(v[:, 2], [0, 0, -1], atol=1e-12)
    np.testing.assert_allclose(correction.last.segment_impulse[:, 2], [1, 1], rtol=1e-12)
    with pytest.raises(ValueError, match="no segment 's7'"):
        body.mask(["s7"])


def test_nothing_in_reach_nothing_evaluated():
    x, v = np.full((50, 3), 3.0), np.full((50, 3), -1.0)
    kept = v.copy()
    correction = VelocityCorrection(limbs(np.random.default_rng(0)), 50, 0.3)
    correction(x, v, np.ones(50), 1e-3, 0.0)
    assert correction.evaluated == correction.active == 0 and np.array_equal(v, kept)
    assert (correction.segment == -1).all() and not correction.last.impulse.any()
    # beside a long limb: in its bounding sphere, still without a closest point
    limb = Body([Segment("limb", [0.5, 0.05, 0.05], Fixed())])
    correction = VelocityCorrection(limb, 1)
    correction(np.array([[0, 0.2, 0.2]]), np.zeros((1, 3)), np.ones(1), 1e-3, 0.0)
    assert correction.evaluated == 0


def test_fixed_nodes_are_left_alone():
    x, v = np.array([[0, 0, 0.1], [0, 0, 0.1]]), np.array([[0, 0, -1.0], [0, 0, -1.0]])
    correction = VelocityCorrection(spheres((0, 0, 0)), 2, 0.3, fixed=[True, False])
    correction(x, v, np.ones(2), 1e-3, 0.0)
    assert np.array_equal(v[0], [0, 0, -1]) and np.abs(v[1]).max() < 1e-12
    assert not correction.last.impulse[0].any() and correction.segment[0] == -1


def test_offset_is_where_the_node_rests():
    correction = VelocityCorrection(spheres((0, 0, 0)), 1, 0.3, offset=0.007)
    x, v = np.array([[0, 0, 0.12]]), np.zeros((1, 3))
    for step in range(300):
        v[0, 2] -= G * 1e-3
        correction(x, v, np.ones(1), 1e-3, step * 1e-3)
        x += 1e-3 * v
    assert x[0] == pytest.approx([0, 0, 0.107], abs=1e-12)


def test_not_a_number_is_reported_with_its_node():
    correction = VelocityCorrection(spheres((0, 0, 0)), 3)
    for broken in (0, 1):
        arrays = [np.ones((3, 3)), np.ones((3, 3))]
        arrays[broken][2, 1] = np.nan
        with pytest.raises(FloatingPointError, match=r"node 2 has position .* at t = 0\.25 s"):
            correction(*arrays, np.ones(3), 1e-3, 0.25)


def test_wrong_settings_are_refused():
    body = spheres((0, 0, 0))
    for settings, message in (
        ({"offset": -1e-3}, "offset"),
        ({"recovery": 0.0}, "recovery"),
        ({"fixed": [True]}, "fixed"),
        ({"friction": (0.1, 0.2)}, "kinetic"),
    ):
        with pytest.raises(ValueError, match=message):
            VelocityCorrection(body, 3, **settings)
    with pytest.raises(ValueError, match=r"v has shape \(2, 3\), not \(3, 3\)"):
        VelocityCorrection(body, 3)(np.zeros((3, 3)), np.zeros((2, 3)), np.ones(3), 1e-3, 0.0)


def test_restart_continues_bit_for_bit():
    def run(correction, x, v, first, steps):
        for step in range(first, first + steps):
            v -= [0, 0, G * 1e-3]
            correction(x, v, mass, 1e-3, step * 1e-3)
            x += 1e-3 * v

    rng = np.random.default_rng(7)
    body = limbs(rng)
    x = outside(body, 0, rng, 100, 0.02)
    v, mass = np.zeros_like(x), np.ones(len(x))
    whole = VelocityCorrection(body, len(x), 0.3)
    run(whole, x, v, 0, 40)
    kept = whole.state(), x.copy(), v.copy()
    run(whole, x, v, 40, 40)
    again = VelocityCorrection(body, len(x), 0.3)
    again.restore(kept[0])
    run(again, kept[1], kept[2], 40, 40)
    assert np.array_equal(x, kept[1]) and np.array_equal(v, kept[2])
    assert np.array_equal(whole.segment, again.segment)


def test_preview_says_what_a_call_does_and_keeps_nothing():
    """Of some nodes, also with another friction; `may_touch` as its formula in arrays."""
    rng = np.random.default_rng(3)
    body, n, dt = Body([Segment("ball", [0.2] * 3, Fixed())]), 60, 1e-3
    x = rng.normal(size=(n, 3))
    x *= rng.uniform(0.2, 0.24, (n, 1)) / np.linalg.norm(x, axis=1)[:, None]
    v, mass = -8.0 * x + rng.normal(size=(n, 3)), np.full(n, 1e-3)
    met, asked = VelocityCorrection(body, n, 0.3), VelocityCorrection(body, n, 0.3)
    free = v.copy()
    for one in (met, asked):
        one(x, v.copy(), mass, dt, 0.0)
    some = np.flatnonzero(rng.uniform(size=n) < 0.5)
    before = {name: value.copy() for name, value in asked.state().items()}
    after, active, _ = asked.preview(some, x[some], free[some], mass[some], dt, 0.0)
    smooth, _, sticking = asked.preview(
        some, x[some], free[some], mass[some], dt, 0.0, Friction(0.0)
    )
    met(x, v, mass, dt, 0.0)
    assert after == pytest.approx(v[some], abs=1e-12) and 0 < active < len(some)
    assert sticking == 0 and np.abs(smooth - after).max() > 1e-3
    again, _, _ = asked.preview(some, x[some], free[some], mass[some], dt, 0.0)
    assert np.array_equal(again, after)
    for name, value in asked.state().items():
        assert np.array_equal(value, before[name])
    way = 2 * dt * np.linalg.norm(free, axis=1)
    nodes = np.arange(n)
    for least in (0.0, float(np.median(way)), 1.0):
        near = ~(asked._away > way + float(asked._work["motion"])) & (way > least)
        expected = near | (asked.segment >= 0)
        assert np.array_equal(asked.may_touch(nodes, free, dt, least), expected)
    assert expected.any() and not expected.all()
