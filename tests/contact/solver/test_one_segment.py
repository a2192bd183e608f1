# SPDX-License-Identifier: LGPL-3.0-or-later
"""What is skipped with a proof: the same, bit for bit, as looking at everything in each step."""

import numpy as np
import pytest

from contact.body.segments import Body, Segment, Steady
from contact.geometry.capsule import Capsule
from contact.geometry.ellipsoid import Ellipsoid
from contact.geometry.shape import foot_and_normal
from contact.kernel import kernel
from contact.solver import correction_step
from contact.solver.friction import Friction
from contact.solver.guard_planes import height_over_guard, keep_guard
from contact.solver.one_segment import MANY
from contact.solver.segment_motion import segment_records
from contact.solver.step_record import FAR, GUARD, GUARDS
from contact.solver.velocity_correction import VelocityCorrection
from tests.contact.solver.bodies import random_axes

OFFSET, LAW = 1e-3, Friction(0.5, 0.3)


def full_look(monkeypatch):
    """The loop over nodes in which every node asks all its segments, by the general way."""
    # kernels are kept by law: the real ones are made before others take their names
    play(None, 0, np.inf, 2)

    @kernel
    def none_away(x, v, mass, dt, path, motion, fixed, sets, look, frame, shift, away):
        away[:] = -1.0

    @kernel
    def all_may_meet(x, i, reach, work, segments, sets, look):
        sets[FAR, i], work.clearance = 0, -1.0
        return True

    @kernel
    def general(x, v, old, mass, i, sets, guards, work, segments, gaps, book, impulse, window):
        return MANY

    with monkeypatch.context() as patch:
        patch.setattr(correction_step, "mark_away", none_away)
        patch.setattr(correction_step, "may_meet", all_may_meet)
        patch.setattr(correction_step, "one_segment_kernel", lambda law: general)
        correct = correction_step.correction_kernel.__wrapped__(LAW.kinetic_coefficient)
        play(None, 0, np.inf, 2, correct)  # compiled while all this holds
    return correct


def crowd(rng, speed, spin):
    """Ellipsoids and capsules, some over each other; in motion they close on points in between."""
    segments = []
    for k in range(5):
        r = np.array([0.12, 0.05, 0.08]) * rng.uniform(0.6, 1.4, 3)
        shape = Capsule(2 * r[0], r[1]) if k == 4 else r
        pose = rng.uniform(-0.25, 0.25, 3), random_axes(rng)
        closing = -4.0 * (speed > 0.0) * pose[0]
        rates = closing + rng.uniform(-speed, speed, 3), rng.uniform(-spin, spin, 3)
        segments.append(Segment(f"part {k}", shape, Steady(*pose, *rates)))
    return Body(segments)


def play(body, seed, flesh, steps, correct=None, dt=5e-4):
    """All that contact gives for points that are drawn to the middle, step by step."""
    rng = np.random.default_rng(seed)
    body = crowd(rng, 1.0, 10.0) if body is None else body
    x, v = rng.uniform(-0.3, 0.3, (150, 3)), rng.standard_normal((150, 3))
    mass, fixed = rng.uniform(1e-4, 1e-2, len(x)), rng.random(len(x)) < 0.05
    correction = VelocityCorrection(body, len(x), LAW, OFFSET, fixed=fixed, flesh=flesh)
    if correct is not None:
        correction._correct = correct
    history = []
    for step in range(steps):
        if step == steps // 2:  # somebody moves points about
            x[::5] = rng.uniform(-0.4, 0.4, x[::5].shape)
        old = v.copy()
        v += 10 * dt * rng.standard_normal(v.shape) - 1000 * dt * x
        correction(x, v, mass, dt, step * dt, old)
        table = correction.last.table.copy()
        counts = correction.active, correction.sticking, correction.pinched, correction.max_depth
        history.append((v.copy(), correction.segment.copy(), table, np.array(counts)))
        x += dt * v
    return history


@pytest.mark.parametrize(("speed", "spin"), [(0.0, 0.0), (0.5, 5.0), (10.0, 1.0), (1.0, 300.0)])
@pytest.mark.parametrize("flesh", [np.inf, 1e5])
def test_nothing_that_is_skipped_would_have_changed_the_step(monkeypatch, speed, spin, flesh):
    """Bodies at rest, in motion, fast and whirling; points at rest on them and thrown about."""
    look = full_look(monkeypatch)
    met = pinched = 0
    for seed in (1, 2):
        body = crowd(np.random.default_rng(seed), speed, spin)
        every, some = (play(body, seed, flesh, 300, correct) for correct in (look, None))
        for step, (one, other) in enumerate(zip(every, some, strict=True)):
            for a, b in zip(one, other, strict=True):
                assert np.array_equal(a, b), step
        met += sum(counts[0] for *_, counts in some)
        pinched += sum(counts[2] for *_, counts in some)
    print(f"{met:.0f} met, {pinched:.0f} pinched")
    assert met > 500 and (pinched > 0 or speed == 0.0 or flesh == np.inf)


def test_a_node_that_keeps_off_costs_no_closest_point():
    """One that rides along with a body, 0.1 mm off it, is looked at now and then."""
    spin = np.array([0.0, 0.0, 2.0])
    body = Body([Segment("s", (0.3, 0.1, 0.1), Steady(spin=spin))])
    correction, dt = VelocityCorrection(body, 1, LAW, OFFSET), 1e-4
    x = np.array([[0.0, 0.1 + OFFSET + 1e-4, 0.0]])
    looked = []
    for step in range(400):
        angle = 2.0 * dt * (step + 1)
        goal = np.linalg.norm(x) * np.array([[-np.sin(angle), np.cos(angle), 0.0]])
        v = (goal - x) / dt
        correction(x, v, np.ones(1), dt, step * dt)
        looked.append(correction.evaluated)
        assert correction.active == 0
        x += dt * v
    assert sum(looked[:2]) > 0 and sum(looked) < 0.5 * len(looked)


@pytest.mark.parametrize("shape", [Ellipsoid((0.3, 0.05, 0.1)), Capsule(0.3, 0.05)])
def test_a_guard_is_no_higher_than_the_distance(shape):
    """Planes kept at points outside and inside, asked for others near and far."""
    rng = np.random.default_rng(3)
    segment = segment_records(Body([Segment("s", getattr(shape, "radii", shape), Steady())]))[0]
    guards, close = np.zeros((1, GUARDS, GUARD)), 0
    for _ in range(300):
        y = rng.uniform(-0.4, 0.4, 3)
        keep_guard(guards, 0, 0, *foot_and_normal(segment, *y)[1:])
        for z in (y, y + rng.uniform(-1e-3, 1e-3, 3), rng.uniform(-0.4, 0.4, 3)):
            height = height_over_guard(guards, 0, 0, *z)
            distance = foot_and_normal(segment, *z)[0]
            assert height <= distance + 1e-15
            close += height > distance - 1e-4
        assert height_over_guard(guards, 0, 0, *y) == pytest.approx(
            foot_and_normal(segment, *y)[0], abs=1e-15
        )
        assert height_over_guard(guards, 0, GUARDS, *y) == -np.inf  # that of another segment
    assert close >= 600
