# SPDX-License-Identifier: LGPL-3.0-or-later
"""Bodies in motion: reactions, work, and the same forces in a turned scene."""

import numpy as np
import pytest

from contact.body.segments import Body, Segment, Steady, turned
from contact.geometry.ellipsoid import closest_points
from contact.solver.velocity_correction import VelocityCorrection
from tests.contact.solver.bodies import LIMB, G, energy, limbs, outside, random_axes


def test_reaction_in_an_accelerating_turning_body():
    """A node that sticks to a body: m (a - g), with the centripetal part, step by step."""
    lift, spin, tilt, dt, mass = 3.0, 4.0, 0.3, 1e-4, np.array([0.02])
    tilted = turned(np.eye(3), np.array([0.0, tilt, 0]))

    def motion(t):
        turn = np.array([0, 0, spin * t])
        centre, velocity = np.array([0, 0, 0.5 * lift * t**2]), np.array([0, 0, lift * t])
        return centre, turned(tilted, turn), velocity, np.array([0, 0, spin])

    body = Body([Segment("disc", [0.4, 0.3, 0.2], motion)])
    material = closest_points([[0.15, 0.05, 0.3]], body.radii[0])[0][0]

    def place(t):
        centre, axes, _, _ = motion(t)
        return centre + material @ axes

    x = place(0.0)[None]
    v = (place(0.0) - place(-dt))[None] / dt
    correction, steps = VelocityCorrection(body, 1, 3.0), 4000
    worst = 0.0
    for step in range(steps):
        t = step * dt
        v += [0, 0, -G * dt]
        correction(x, v, mass, dt, t)
        x += dt * v
        arm = place(t) - motion(t)[0]
        acceleration = np.array([0, 0, lift]) + spin**2 * np.array([-arm[0], -arm[1], 0])
        exact = mass[0] * (acceleration + [0, 0, G])
        error = np.linalg.norm(correction.last.impulse[0] / dt - exact)
        worst = max(worst, error / np.linalg.norm(exact))
        assert correction.sticking == 1
    assert spin**2 * np.linalg.norm(arm[:2]) > 2  # the centripetal part is no trifle
    assert worst < 1e-5
    assert np.linalg.norm(x[0] - place(steps * dt)) < 1e-10


def test_a_moving_wall_takes_the_node_along_and_pays_for_it():
    body = Body([Segment("wall", [10, 10, 10.0], Steady([0, 0, -10], velocity=[0.5, 0, 2.0]))])
    correction, mass = VelocityCorrection(body, 1, 0.1), np.array([0.3])
    x, v, dt = np.array([[0, 0, 1e-4]]), np.zeros((1, 3)), 1e-3
    for step in range(3):
        correction(x, v, mass, dt, step * dt)
        x += dt * v
    # normal velocity of the wall, along it mu times as much
    assert v[0] == pytest.approx([0.2, 0, 2.0], rel=1e-3)
    window = correction.window
    gained = energy(mass, v)
    assert window.work.sum() - window.friction_loss.sum() - window.impact_loss.sum() == (
        pytest.approx(gained, rel=1e-12)
    )
    # force times way of the wall
    way = window.impulse[0] @ [0.5, 0, 2.0]
    assert window.work.sum() == pytest.approx(way, rel=1e-12)


def test_forces_turn_with_the_scene():
    rng = np.random.default_rng(3)
    Q, shift = random_axes(rng), np.array([0.3, -0.2, 0.1])
    results = []
    for turn in (False, True):
        rng = np.random.default_rng(4)
        segments = []
        for k in range(4):
            c, a = rng.uniform(-0.05, 0.05, 3), random_axes(rng)
            u, w = rng.uniform(-3, 3, 3), rng.uniform(-20, 20, 3)
            if turn:
                c, a, u, w = Q @ c + shift, a @ Q.T, Q @ u, Q @ w
            segments.append(Segment(f"limb {k}", LIMB, Steady(c, a, u, w)))
        plain = limbs(np.random.default_rng(0), 1)  # only to draw points around the origin
        x = outside(plain, 0, rng, 300, 0.05)
        v = 3 * rng.standard_normal(x.shape)
        if turn:
            x, v = x @ Q.T + shift, v @ Q.T
        correction = VelocityCorrection(Body(segments), len(x), 0.4)
        correction(x, v, np.full(len(x), 1e-3), 1e-3, 0.0)
        results.append((correction.last, correction.segment))
    (last, segment), (turned_last, turned_segment) = results
    assert np.array_equal(segment, turned_segment) and (segment >= 0).sum() > 50
    scale = np.abs(last.impulse).max()
    assert np.abs(turned_last.impulse - last.impulse @ Q.T).max() < 1e-12 * scale
    assert np.abs(turned_last.segment_impulse - last.segment_impulse @ Q.T).max() < 1e-12 * (
        np.abs(last.segment_impulse).max()
    )
    assert np.abs(turned_last.segment_moment - last.segment_moment @ Q.T).max() < 1e-11 * scale
