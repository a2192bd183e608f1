# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contact with a shape that is no ellipsoid: weight, stick and slip, balances, the broad phase."""

import numpy as np
import pytest

from contact.body.segments import Body, Fixed, Segment, Steady, turned
from contact.geometry.capsule import Capsule
from contact.solver.active_set import judge_kernel
from contact.solver.friction import Friction
from contact.solver.held_nodes import SLIP, STICK, new
from contact.solver.segment_obstacle import SegmentObstacle
from contact.solver.step_record import step_record
from contact.solver.thin_segments import refusal
from contact.solver.velocity_correction import VelocityCorrection
from tests.contact.solver.bodies import LIMB, G, random_axes

BAR = Capsule(0.4, 0.05)


def bars(rng, count=3):
    """Capsules and an ellipsoid through each other, in motion."""
    segments = []
    for k in range(count):
        pose = rng.uniform(-0.05, 0.05, 3), random_axes(rng)
        rates = rng.uniform(-3, 3, 3), rng.uniform(-20, 20, 3)
        segments.append(Segment(f"bar {k}", BAR, Steady(*pose, *rates)))
    return Body([*segments, Segment("limb", LIMB, Steady((0.0, 0.1, 0.0), spin=(0.0, 9.0, 0.0)))])


def axis_distance(x, pose, shape):
    """Distance (n,) of points from a capsule, from its axis by hand."""
    ends = [pose.centres[0] + s * 0.5 * shape.length * pose.axes[0, 0] for s in (-1, 1)]
    way = ends[1] - ends[0]
    part = np.clip((x - ends[0]) @ way / (way @ way), 0, 1)
    return np.linalg.norm(x - ends[0] - part[:, None] * way, axis=1) - shape.radius


def test_nodes_at_rest_on_a_bar_book_their_weight():
    """Along the top of a level bar, friction holds every node where it is; weight to roundoff."""
    body, dt = Body([Segment("bar", BAR, Fixed((0.0, 0.0, -BAR.radius)))]), 1e-3
    x = np.column_stack([np.linspace(-0.2, 0.2, 9), np.zeros(9), np.full(9, 1e-3)])
    v, mass = np.zeros_like(x), np.linspace(1e-3, 2e-3, 9)
    start = x.copy()
    correction = VelocityCorrection(body, 9, 0.3, offset=1e-3)
    for step in range(500):
        v[:, 2] -= G * dt
        correction(x, v, mass, dt, step * dt)
        x += dt * v
    assert np.abs(x - start).max() < 1e-12 and correction.sticking == 9
    expected = np.column_stack([0 * mass, 0 * mass, mass * G * dt])
    assert np.abs(correction.last.impulse - expected).max() < 1e-15
    assert correction.last.segment_impulse[0] == pytest.approx(expected.sum(axis=0), abs=1e-16)


@pytest.mark.parametrize("slope", [0.4, 0.6])
def test_stick_and_slip_along_a_slanting_bar(slope):
    """mu = 0.5: sticks below the cone, above it slides by (sin - mu cos) g t^2 / 2."""
    angle, dt, seconds, mu = np.arctan(slope), 1e-4, 0.1, 0.5
    axes = turned(np.eye(3), np.array([0.0, angle, 0.0]))
    body = Body([Segment("bar", BAR, Fixed((0.0, 0.0, 0.0), axes))])
    x, v = BAR.radius * axes[2:3], np.zeros((1, 3))
    start = x.copy()
    correction = VelocityCorrection(body, 1, mu)
    for step in range(round(seconds / dt)):
        v[0, 2] -= G * (dt if step else dt / 2)
        correction(x, v, np.ones(1), dt, step * dt)
        x += dt * v
    way = np.linalg.norm(x - start)
    if slope < mu:
        assert way < 1e-12 and correction.sticking == 1
    else:
        exact = 0.5 * G * (np.sin(angle) - mu * np.cos(angle)) * seconds**2
        assert way == pytest.approx(exact, rel=2e-3) and correction.sticking == 0


def test_momentum_moments_and_energy_close():
    """Capsules and an ellipsoid that move through each other, met at once."""
    rng = np.random.default_rng(1)
    body, dt, t = bars(rng), 2e-3, 0.1
    x = rng.uniform(-0.2, 0.2, (3000, 3))
    mass, old = rng.uniform(1e-4, 1e-2, len(x)), 2 * rng.standard_normal(x.shape)
    v = old.copy()
    correction = VelocityCorrection(body, len(x), (0.5, 0.3))
    correction(x, v, mass, dt, t, old)
    book, change = correction.last, mass[:, None] * (v - old)
    assert set(correction.segment) == {-1, 0, 1, 2, 3} and correction.active > 100
    scale = np.abs(change).sum()
    assert np.abs(book.segment_impulse.sum(axis=0) - change.sum(axis=0)).max() < 1e-14 * scale
    centres = body.pose(t, body.new_pose()).centres
    moment = book.segment_moment + np.cross(centres, book.segment_impulse)
    assert np.abs(moment.sum(axis=0) - np.cross(x, change).sum(axis=0)).max() < 1e-14 * scale
    gained = 0.5 * np.sum(mass * np.sum(v * v - old * old, axis=1))
    booked = book.work.sum() - book.friction_loss.sum() - book.impact_loss.sum()
    assert gained == pytest.approx(booked, abs=1e-13 * np.sum(mass * np.sum(old**2, axis=1)))


@pytest.mark.parametrize("speed", [1.0, 30.0, 300.0])
def test_no_path_goes_through_a_bar(speed):
    """Steps up to three bars long: the way of every node met stays outside."""
    rng = np.random.default_rng(2)
    axes = random_axes(rng)
    body, dt = Body([Segment("bar", BAR, Fixed((0.1, 0.0, 0.0), axes))]), 1e-3
    pose = body.new_pose()
    x = rng.uniform(-0.4, 0.4, (100_000, 3))
    gap = axis_distance(x, pose, BAR)
    x = x[(gap > 0) & (gap < 2 * speed * dt)][:1000]
    v = speed * rng.standard_normal(x.shape)
    free = v.copy()
    correction = VelocityCorrection(body, len(x), 0.3)
    correction(x, v, np.ones(len(x)), dt, 0.0)
    hit = correction.segment >= 0
    assert hit.sum() > 5
    times = np.linspace(0, 1, 101)[:, None, None]
    path = (x + times * dt * v).reshape(-1, 3)
    assert axis_distance(path, pose, BAR).min() > -1e-9
    # and those whose free path goes through were met, no others
    gaps = axis_distance((x + times * dt * free).reshape(-1, 3), pose, BAR)
    through = gaps.reshape(101, -1).min(axis=0) < -1e-6
    assert hit[through].all()
    assert np.array_equal(v[~hit], free[~hit])


def test_a_node_far_from_a_bar_costs_no_closest_point():
    """Beside it, in its bounding sphere, and again after the broad phase has measured."""
    correction = VelocityCorrection(Body([Segment("bar", BAR, Fixed())]), 1)
    x, v = np.array([[0.0, 0.15, 0.15]]), np.zeros((1, 3))
    for step in range(3):
        correction(x, v, np.ones(1), 1e-3, step * 1e-3)
        assert correction.evaluated == 0


def test_implicit_contact_holds_nodes_on_a_bar():
    """A node carried on a turning bar stays on its skin; one with too much slope slips."""
    law, dt = Friction(0.5, 0.4), 0.01
    body = Body([Segment("bar", BAR, Steady(spin=(0.3, 0.0, 0.0), velocity=(0.0, 0.1, 0.0)))])
    end, step, obstacle = body.new_pose(dt), step_record(law, 1e-3), SegmentObstacle(body, 1e-3)
    step["dt"], step["recovery"] = dt, 1e-3
    obstacle.move(0.0, dt)
    x0, nodes, changed = (
        np.array([[0.1, 0.0, 0.051], [-0.1, 0.0, 0.051]]),
        new(2),
        np.zeros(2, bool),
    )
    nodes.state[:] = STICK
    nodes.owner[:, 0], nodes.over[:, 0] = 0, -1
    given = changed, step[0], obstacle.world, nodes
    assert obstacle.kernels.locate(True, x0, x0, *given)[1] < 1e-15
    assert np.abs(axis_distance(nodes.anchor, end, BAR) - 1e-3).max() < 1e-15
    normal = nodes.normal[0, 0].copy()
    across = np.array([1.0, 0.0, 0.0])
    force = np.array([normal + 0.49 * across, normal + 0.6 * across])
    judge = judge_kernel(law.kinetic_coefficient)
    x1 = nodes.anchor.copy()
    judge(x1, force, 1e-9, changed, step[0], nodes)
    assert obstacle.kernels.locate(False, x0, x1, *given)[0] == 1
    assert nodes.state.tolist() == [STICK, SLIP] and changed.tolist() == [False, True]
    assert nodes.cone[1] == pytest.approx(0.4, abs=1e-15)


def test_semi_axes_are_only_those_of_ellipsoids():
    body = Body([Segment("bar", BAR, Fixed()), Segment("limb", LIMB, Fixed())])
    assert np.array_equal(body.segments[1].radii, LIMB)
    with pytest.raises(ValueError, match="segment 'bar' is no ellipsoid but a Capsule"):
        body.radii
    assert "'bar' and 1 more, 100 mm thick" in refusal(body.names, body.shapes, 0.25, 0.2, 0.0)
