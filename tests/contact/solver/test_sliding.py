# SPDX-License-Identifier: LGPL-3.0-or-later
"""One node sliding or sticking on one body, against closed forms."""

import numpy as np
import pytest

from contact.solver.velocity_correction import VelocityCorrection
from tests.contact.solver.bodies import G, spheres


def incline(slope, mu, seconds, dt, radius=1e4):
    """A node on top of a huge sphere, gravity tilted by atan(slope); way slid, steps sticking."""
    angle = np.arctan(slope)
    gravity = G * np.array([np.sin(angle), 0, -np.cos(angle)])
    correction = VelocityCorrection(spheres((0, 0, -radius), radius=radius), 1, mu)
    x, v, mass = np.zeros((1, 3)), np.zeros((1, 3)), np.array([0.01])
    sticking = 0
    for step in range(round(seconds / dt)):
        v += gravity * (dt if step else dt / 2)
        correction(x, v, mass, dt, step * dt)
        x += dt * v
        sticking += correction.sticking
    return np.linalg.norm(x[0]), sticking, correction


def test_incline_below_the_cone_sticks_for_good():
    way, sticking, correction = incline(0.4, 0.5, 10.0, 1e-3)
    assert way < 1e-9 and sticking == 10_000
    window, angle = correction.window, np.arctan(0.4)
    force = window.impulse[0] / window.seconds
    weight = 0.01 * G * np.array([-np.sin(angle), 0, np.cos(angle)])
    assert force == pytest.approx(weight, rel=1e-4)
    # by the free velocities friction takes what gravity's half kick put in: first order in dt
    assert 0 < window.friction_loss.sum() < 0.01 * G**2 * 1e-3 * 10


def test_incline_above_the_cone_slides_as_the_formula_says():
    way, sticking, _ = incline(0.6, 0.5, 1.0, 5e-4)
    angle = np.arctan(0.6)
    exact = 0.5 * G * (np.sin(angle) - 0.5 * np.cos(angle))
    assert way == pytest.approx(exact, rel=1e-3) and sticking == 0


def test_static_friction_holds_what_kinetic_would_not():
    assert incline(0.4, (0.5, 0.2), 1.0, 1e-3)[0] < 1e-9
    assert incline(0.6, (0.7, 0.2), 1.0, 1e-3)[0] < 1e-9
    assert incline(0.6, (0.5, 0.2), 1.0, 1e-3)[0] > 1


def test_without_friction_nothing_acts_along_the_surface():
    rng = np.random.default_rng(2)
    x = rng.standard_normal((200, 3))
    x *= 0.1001 / np.linalg.norm(x, axis=1, keepdims=True)
    v = rng.standard_normal(x.shape)
    free = v.copy()
    correction = VelocityCorrection(spheres((0, 0, 0)), len(x), 0.0)
    correction(x, v, np.ones(len(x)), 1e-3, 0.0)
    assert correction.active > 50 and correction.sticking == 0
    # the impulse is along the radius to the place where the free path meets the sphere
    hit = correction.segment >= 0
    n = correction.last.impulse[hit]
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    assert np.abs(np.cross(0.1 * n - x[hit], free[hit])).max() < 1e-12
    assert (np.sum(n * free[hit], axis=1) < 0).all()
    assert not correction.last.friction_loss.any()


@pytest.mark.parametrize("start", [0.1, 0.5])
def test_node_leaves_a_smooth_sphere_where_it_should(start):
    """Sliding from rest, cos(leave) = 2/3 cos(start); until then energy is kept."""
    radius, mass = 0.1, np.array([0.01])
    errors = []
    for dt in (2e-4, 1e-4, 5e-5):
        correction = VelocityCorrection(spheres((0, 0, 0), radius=radius), 1, 0.0)
        x, v = radius * np.array([[np.sin(start), 0, np.cos(start)]]), np.zeros((1, 3))
        left = None
        for step in range(round(1.5 / dt)):
            old = v.copy()
            v[0, 2] -= G * (dt if step else dt / 2)
            correction(x, v, mass, dt, step * dt, old)
            if correction.segment[0] == 0:
                left = x[0] / np.linalg.norm(x[0])
            x += dt * v
            if x[0, 2] < 0:
                break
        assert abs(correction.window.impact_loss.sum()) < 2 * dt * mass[0] * G * radius
        errors.append(abs(left[2] - 2 / 3 * np.cos(start)))
    assert errors[-1] < 2e-3 and errors[-1] < 0.6 * errors[0]
