# SPDX-License-Identifier: LGPL-3.0-or-later
"""Flesh below a surface of triangles, and what corrections say in advance of a step."""

import numpy as np
import pytest

from contact.body.flesh_bed import HARD, Flesh
from contact.body.segments import Body, Fixed, Segment
from contact.solver.flesh_correction import FleshCorrection
from contact.solver.friction import Friction
from contact.solver.surface_correction import SurfaceCorrection
from contact.solver.surface_flesh import SurfaceFleshCorrection
from contact.solver.union_correction import UnionCorrection
from contact.solver.velocity_correction import VelocityCorrection
from tests.contact.solver.bodies import G, energy
from tests.contact.solver.surfaces import ball, lump
from tests.contact.solver.test_surface_correction import around

DT = 1e-4
BED = Flesh(5e4, 2e4, 30.0, 2e4, 0.05)


def test_a_flat_plate_pressed_into_a_ball_of_flesh():
    """Pressures k (R - s) along the normal sum up to pi k (R - delta) delta^2, as on a sphere."""
    radius, delta, k, h = 0.1, 0.01, 1e5, 1e-3
    grid = np.arange(-0.05 + h / 2, 0.05, h)
    x = np.stack([*np.meshgrid(grid, grid, indexing="ij"), np.full((len(grid),) * 2, DT)], -1)
    x = x.reshape(-1, 3)
    areal = 1e9  # so heavy that it does not move
    body = ball(radius, 4, (0.0, 0.0, -radius))
    correction = SurfaceFleshCorrection(body, len(x), flesh=Flesh(k), areal_mass=areal)
    v = np.zeros_like(x)
    v[:, 2] = -1.0
    mass = np.full(len(x), areal * h * h)
    for step in range(101):
        correction(x, v, mass, DT, step * DT)
        x += DT * v
    force = correction.last.impulse.sum(axis=0) / DT
    assert force[2] == pytest.approx(np.pi * k * (radius - delta) * delta**2, rel=3e-3)
    assert np.abs(force[:2]).max() < 1e-9 * force[2]
    assert correction.sides["depth"].max() == pytest.approx(delta, rel=1e-3)


def test_momentum_moments_and_energy_close_on_flesh():
    """All that changes in the cloth is in the book, while nodes sink in and come out again."""
    rng = np.random.default_rng(1)
    surface = lump(rng)
    x = around(surface, 0.0, rng, 300, -1e-3, 4e-3)
    mass = rng.uniform(1e-4, 1e-3, len(x))
    correction = SurfaceFleshCorrection(
        surface, len(x), None, (0.5, 0.3), 1e-3, flesh=BED, areal_mass=0.2
    )
    v, touched = rng.standard_normal(x.shape), 0
    for step in range(20):
        old = v.copy()
        correction(x, v, mass, DT, step * DT)
        book, change = correction.last, mass[:, None] * (v - old)
        scale = np.abs(change).sum() + 1e-30
        touched += correction.active
        assert np.abs(book.impulse - change).max() < 1e-14 * scale
        total = book.segment_impulse.sum(axis=0) - change.sum(axis=0)
        assert np.abs(total).max() < 1e-12 * scale
        moment = book.segment_moment + np.cross(correction.start_pose.centres, book.segment_impulse)
        assert np.abs(moment.sum(axis=0) - np.cross(x, change).sum(axis=0)).max() < 1e-12 * scale
        booked = book.work.sum() - book.friction_loss.sum() - book.impact_loss.sum()
        gained = energy(mass, v) - energy(mass, old)
        assert gained == pytest.approx(booked, abs=1e-11 * energy(mass, old))
        x += DT * v
    assert touched > 500 and correction.sides["depth"].max() > 1e-4
    held = correction.segment >= 0
    assert (correction.sides["owner"][held] == correction.segment[held]).all()
    assert correction.stored_energy(mass) > 0


def test_stiff_flesh_is_a_hard_surface():
    """The same place and force as on a rigid one, incline and all."""
    surface, found = ball(0.1, 3, (0.0, 0.0, -0.1)), []
    for correction in (
        SurfaceCorrection(surface, 1, friction=(0.5, 0.4)),
        SurfaceFleshCorrection(surface, 1, None, (0.5, 0.4), flesh=Flesh(HARD), areal_mass=0.2),
    ):
        x, v, mass = np.array([[0.03, 0.0, -0.004]]), np.zeros((1, 3)), np.array([1e-3])
        for step in range(2000):
            old = v.copy()
            v[:, 2] -= DT * G
            correction(x, v, mass, DT, step * DT, v_old=old)
            x += DT * v
        found.append((x.copy(), correction.last.impulse / DT))
    assert np.abs(found[0][0] - found[1][0]).max() < 1e-5
    assert found[0][1] == pytest.approx(found[1][1], rel=1e-3, abs=1e-5 * 1e-3 * G)


def corrections(n):
    """One of each kind, with its surface or body near the origin."""
    limb = Body(
        [Segment("ball", [0.1] * 3, Fixed()), Segment("knob", [0.04] * 3, Fixed((0.1, 0, 0)))]
    )
    skin = ball(0.1, 3)
    soft = {"flesh": BED, "areal_mass": 0.2}
    hard, over = VelocityCorrection(limb, n, 0.4), SurfaceCorrection(skin, n, limb, 0.4)
    return {
        "shapes": VelocityCorrection(limb, n, 0.4),
        "flesh": FleshCorrection(limb, n, 0.4, 0.0, **soft),
        "surface": SurfaceCorrection(skin, n, None, 0.4),
        "soft surface": SurfaceFleshCorrection(skin, n, None, 0.4, **soft),
        "union": UnionCorrection(hard, over, ["knob"]),
    }


@pytest.mark.parametrize("kind", ["shapes", "flesh", "surface", "soft surface", "union"])
def test_what_is_said_in_advance_is_what_is_done(kind):
    """And nothing is kept of having asked: the step afterwards is that of who never asked."""
    rng = np.random.default_rng(7)
    x = around(ball(0.1, 3), 0.0, rng, 120, -5e-4, 2e-3)
    mass, count = np.full(len(x), 1e-3), len(x)
    asked, silent = corrections(count)[kind], corrections(count)[kind]
    v = 0.5 * rng.standard_normal(x.shape)
    for step in range(6):
        told, pushed, sticking = asked.preview(np.arange(count), x, v, mass, DT, step * DT)
        some = np.flatnonzero(rng.random(count) < 0.3)
        part = asked.preview(some, x[some], v[some], mass[some], DT, step * DT)[0]
        asked.preview(some, x[some], v[some], mass[some], DT, step * DT, Friction(0.0))
        other = v.copy()
        silent(x, other, mass, DT, step * DT)
        asked(x, v, mass, DT, step * DT)
        assert np.array_equal(v, other)
        assert np.abs(told - v).max() < 1e-12 and np.abs(part - v[some]).max() < 1e-12
        assert (pushed, sticking) == (asked.active, asked.sticking)
        touching = asked.segment >= 0
        assert asked.may_touch(np.arange(count), v, DT, 0.0)[touching].all()
        x = x + DT * v
        v[:, 2] -= DT * 9.81
    assert touching.any()
    assert np.array_equal(asked.window.table, silent.window.table)
    give = asked.normal_give(np.arange(count), DT)
    soft = "flesh" in kind or "soft" in kind
    assert (give[touching] > 0.9).all() if soft else not give.any()
