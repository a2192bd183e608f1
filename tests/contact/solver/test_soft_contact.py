# SPDX-License-Identifier: LGPL-3.0-or-later
"""Soft segments that close over cloth: balance, work given back, friction, hard creases."""

import numpy as np
import pytest
from scipy.optimize import brentq

from contact.body.segments import Body, Segment
from contact.solver.velocity_correction import VelocityCorrection
from tests.contact.solver.bodies import clearance, energy, spheres

FLESH = 1e5  # stiffness over areal mass [1/s^2]


NONE = np.zeros(3)


def pull_in(correction, x, mass, dt, steps, pull):
    """Positions and velocities of nodes (n, 3) after steps under an acceleration (3,)."""
    v = np.zeros_like(x)
    for step in range(steps):
        before = v.copy()
        v += dt * np.asarray(pull)
        correction(x, v, mass, dt, step * dt, v_old=before)
        x += dt * v
    return v


def test_soft_bodies_let_cloth_into_the_crease_until_they_balance_its_pull():
    """Between two spheres, normals obtuse: 2 k d cos = pull; hard ones hold at their crease."""
    body, half, dt, pull = spheres((-0.08, 0, 0), (0.08, 0, 0)), 0.08, 1e-3, 200.0
    edge = np.sqrt(0.1**2 - half**2)

    def surplus(z):
        arm = np.hypot(half, z)
        return 2 * FLESH * (0.1 - arm) * z / arm - pull

    expected = {np.inf: edge, FLESH: brentq(surplus, 0.7 * edge, edge, xtol=1e-15)}
    for flesh, height in expected.items():
        correction = VelocityCorrection(body, 1, flesh=flesh, recovery=1e-9)
        x = np.array([[0.0, 0.0, edge + 1e-3]])
        v = pull_in(correction, x, np.ones(1), dt, 3000, (0, 0, -pull))
        assert x[0] == pytest.approx([0, 0, height], abs=1e-9) and np.abs(v).max() < 1e-9
        assert correction.last.segment_impulse[:, 2] == pytest.approx([pull * dt / 2] * 2)
        assert correction.pinched == (flesh < np.inf)
        assert correction.pinch_depth == pytest.approx(
            0.1 - np.hypot(half, height) if flesh < np.inf else 0.0, abs=1e-9
        )
    with pytest.raises(ValueError, match="positive, not 0"):
        VelocityCorrection(body, 1, flesh=0.0)


def closing(gap, seconds):
    """Two spheres of 0.1 m whose skins go from `gap` apart to as much overlap and back."""

    def motion(sign):
        def pose(t):
            a = 2 * np.pi / seconds
            on = 0.0 <= t <= seconds
            away = 0.1 + 0.5 * gap * (np.cos(a * t) if on else 1.0)
            speed = -0.5 * gap * a * np.sin(a * t) if on else 0.0
            return sign * np.array([away, 0, 0]), np.eye(3), sign * np.array([speed, 0, 0]), NONE

        return pose

    return Body([Segment("left", [0.1] * 3, motion(-1)), Segment("right", [0.1] * 3, motion(1))])


def test_flesh_that_closes_over_cloth_takes_it_to_the_middle_and_gives_the_work_back():
    """Skins overlap by 20 mm and part again: the cloth stays, is let go, and no work is left."""
    body, dt, seconds = closing(0.02, 1.0), 2e-4, 1.0
    correction = VelocityCorrection(body, 1, flesh=FLESH)
    x, v, mass = np.array([[0.004, 0.0, 0.0]]), np.zeros((1, 3)), np.array([1e-3])
    deepest = 0.0
    for step in range(int(1.2 * seconds / dt)):
        before = v.copy()
        correction(x, v, mass, dt, step * dt, v_old=before)
        x += dt * v
        deepest = max(deepest, correction.pinch_depth)
        if abs(step * dt - 0.5 * seconds) < dt / 2:
            # as deep in one as in the other
            assert abs(clearance(body, step * dt, x)[:, 0] + 0.01).max() < 5e-4
            assert correction.pinched == 1 and correction.max_depth == 0.0
            # flesh on flesh is not the cloth's: k d of 1 N/kg is left out of what is booked
            push = np.abs(correction.last.segment_impulse[:, 0]).max()
            assert push < 0.05 * mass[0] * FLESH * 0.01 * dt
    assert 0.009 < deepest < 0.012 and not correction.pinched
    assert clearance(body, 1.2 * seconds, x).min() > 0.0
    book = correction.window
    stored = book.impact_loss.sum()
    work = book.work.sum() - book.friction_loss.sum() - stored
    assert work == pytest.approx(energy(mass, v), abs=1e-12)
    assert abs(stored) < 0.01 * mass[0] * FLESH * deepest**2 and np.linalg.norm(v) < 0.05


@pytest.mark.parametrize("part", [0.9, 1.2])
def test_flesh_holds_cloth_by_the_friction_of_both_sides(part):
    """Between two spheres that overlap by 10 mm friction holds 2 mu k d, and no more."""
    body, mu, depth = spheres((-0.095, 0, 0), (0.095, 0, 0)), 0.3, 0.005
    correction = VelocityCorrection(body, 1, mu, flesh=FLESH)
    correction.penetrated[:] = body.mask(["s0", "s1"])
    x, v = np.zeros((1, 3)), np.zeros((1, 3))
    dt, pull, steps = 1e-4, part * 2 * mu * FLESH * depth, 20
    for step in range(steps):
        before = v.copy()
        v[0, 1] += dt * pull
        correction(x, v, np.ones(1), dt, step * dt, v_old=before)
        x += dt * v
    slipped = max(0.0, part - 1) / part * pull * steps * (steps + 1) * dt**2 / 2
    # along y the way leads out of the lens: both sides push by y / R besides, 2 % here
    assert x[0, 1] == pytest.approx(slipped, rel=0.03, abs=1e-12)


def test_ellipsoids_of_one_segment_make_a_hard_crease():
    """On one rigid part of a wearer, or where normals are acute, it pushes with what it takes."""
    for half, carriers in ((0.08, ("pelvis", "pelvis")), (0.06, ("thigh", "shank"))):
        body = spheres((-half, 0, 0), (half, 0, 0))
        body.carriers = carriers
        correction = VelocityCorrection(body, 1, flesh=1.0)
        v, dt = np.array([[0.0, 0.0, -3e-3]]), 1e-3
        x = np.array([[0.0, 0.0, np.sqrt(0.1**2 - half**2)]])
        correction(x, v, np.ones(1), dt, 0.0)
        assert correction.last.impulse[0, 2] == pytest.approx(3e-3, rel=1e-6)
        assert not correction.pinched


def plates(gap):
    """Two soft bodies, flat at the origin, their skins `gap` apart in z."""
    return spheres((0, 0, -100 - 0.5 * gap), (0, 0, 100 + 0.5 * gap), radius=100.0)


@pytest.mark.parametrize(("flesh", "stiffness"), [(FLESH, 4e4), (np.inf, np.inf)])
def test_beds_of_a_node_between_two_flat_bodies(flesh, stiffness):
    """Pressed by both: the sum of their stiffness, infinite for hard ones; by one or none: zero."""
    offset = 1e-3
    found = {}
    cases = ("both", 1.5e-3, 0.0), ("one", 20e-3, -9.5e-3), ("none", 20e-3, 0.0)
    for name, gap, height in cases:
        correction = VelocityCorrection(plates(gap), 1, offset=offset, flesh=flesh)
        beds, x = correction.watch_beds(4e4), np.array([[0.0, 0.0, height]])
        for step in range(5):
            v = np.array([[0.0, 0.0, -1e-3]])
            correction(x, v, np.ones(1), 1e-4, 1e-4 * step)
        assert (correction.active == 0) == (name == "none")
        found[name] = beds[0]
    assert found == {"both": 2 * stiffness, "one": 0.0, "none": 0.0}
    correction = VelocityCorrection(plates(1.5e-3), 1, offset=offset, flesh=flesh)
    correction(np.zeros((1, 3)), np.zeros((1, 3)), np.ones(1), 1e-4, 0.0)
    assert correction.state()["beds"].size == 0  # nobody asked
