# SPDX-License-Identifier: LGPL-3.0-or-later
"""Impact: no node passes through a body, at any speed, and none gains energy."""

import numpy as np
import pytest

from contact.body.segments import Body, Fixed, Segment, turned
from contact.solver.velocity_correction import VelocityCorrection
from tests.contact.solver.bodies import LIMB, clearance, energy, limbs, outside, spheres


def patch(side, cells, height):
    """Mass points of a square sheet above the body, and their masses."""
    s = np.linspace(-side / 2, side / 2, cells)
    x = np.array([[a, b, height] for a in s for b in s])
    return x, np.full(len(x), 1e-3 / len(x))


@pytest.mark.parametrize("mu", [0.0, 0.3])
@pytest.mark.parametrize("speed", [0.1, 1.0, 10.0, 100.0, 300.0])
def test_impact_never_tunnels_and_never_gains_energy(speed, mu):
    """A patch flies onto two fixed limbs, at a slant; up to twice the limb in a single step."""
    body = Body(
        [
            Segment("a", LIMB, Fixed([0.03, 0, 0], turned(np.eye(3), np.array([0.3, 0.2, 0.1])))),
            Segment("b", LIMB, Fixed([-0.03, 0, 0], turned(np.eye(3), np.array([-0.4, 0, 1.0])))),
        ]
    )
    for dt in (1e-4, 1e-3):
        x, mass = patch(0.3, 13, 0.11)
        v = np.tile([0.3 * speed, 0.1 * speed, -speed], (len(x), 1))
        correction = VelocityCorrection(body, len(x), mu)
        touched = np.zeros(len(x), bool)
        for step in range(min(400, int(0.5 / (speed * dt)) + 3)):
            before = v.copy()
            correction(x, v, mass, dt, step * dt)
            lost = energy(mass, before) - energy(mass, v)
            assert lost > -1e-14 * energy(mass, before)
            growth = np.sum(v * v, axis=1) - np.sum(before**2, axis=1)
            assert growth.max() < 1e-14 * speed**2
            change = np.sum(mass[:, None] * (v - before), axis=0)
            scale = mass.sum() * speed
            assert np.abs(correction.last.impulse.sum(axis=0) - change).max() < 1e-14 * scale
            book = correction.last
            balance = book.friction_loss.sum() + book.impact_loss.sum()
            assert lost == pytest.approx(balance, abs=1e-13 * mass.sum() * speed**2)
            hit = correction.segment >= 0
            touched |= hit
            path = x[hit] + np.linspace(0, 1, 21)[:, None, None] * (dt * v[hit])
            if hit.any():
                assert clearance(body, 0, path.reshape(-1, 3)).min() > -1e-9
            x += dt * v
            assert clearance(body, 0, x).min() > -1e-9
        if speed * dt * (step + 1) > 0.3:
            # all in the shadow of the limbs were caught, and some flew past
            assert 20 < touched.sum() < len(x)


def test_any_fast_path_among_several_bodies_ends_outside_with_no_more_energy():
    """Steps up to three limbs long in all directions: into one, off it into the next."""
    rng = np.random.default_rng(9)
    body, dt = limbs(rng, 8, moving=False), 1e-3
    x = outside(body, 0, rng, 3000, 0.05)
    free = 300 * rng.uniform(0, 1, (len(x), 1)) * rng.standard_normal(x.shape)
    for mu in (0.0, 0.3):
        v = free.copy()
        correction = VelocityCorrection(body, len(x), mu)
        correction(x, v, np.ones(len(x)), dt, 0.0)
        assert correction.active > 500
        growth = np.sum(v * v, axis=1) - np.sum(free**2, axis=1)
        assert growth.max() < 1e-10 * 300**2
        gap = clearance(body, 0, x + dt * v).min(axis=0)
        assert (gap < -1e-9).sum() <= correction.pinched


def test_at_300_metres_a_second_the_entry_stops_the_node():
    """Straight down on a sphere: the node stays at the pole, its impulse is its momentum."""
    body, dt, mass = spheres((0, 0, 0)), 1e-3, np.array([2e-3])
    x, v = np.array([[0.0, 0, 0.15]]), np.array([[0.0, 0, -300.0]])
    correction = VelocityCorrection(body, 1)
    correction(x, v, mass, dt, 0.0)
    assert x[0, 2] + dt * v[0, 2] == pytest.approx(0.1, abs=1e-12)
    correction(x + dt * v, v, mass, dt, dt)
    assert abs(v[0, 2]) < 1e-9
    assert correction.window.impulse[0] == pytest.approx([0, 0, 0.6], rel=1e-12)
    assert correction.window.impact_loss.sum() == pytest.approx(0.5 * 2e-3 * 300**2, rel=1e-12)


def test_a_path_that_misses_the_body_is_left_alone():
    """Over the horizon in one long step: below the plane of the start, but outside."""
    x, v = np.array([[0.0, 0, 0.1001]]), np.array([[300.0, 0, -1.0]])
    correction = VelocityCorrection(spheres((0, 0, 0)), 1, 0.5)
    correction(x, v, np.ones(1), 1e-3, 0.0)
    assert correction.segment[0] == -1 and np.array_equal(v, [[300.0, 0, -1.0]])
