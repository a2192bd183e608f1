# SPDX-License-Identifier: LGPL-3.0-or-later
"""Segments left out for a while: the same contact bit for bit, with fewer closest points."""

import numpy as np
import pytest

from contact.body.segments import Body, Fixed, Segment, Steady
from contact.geometry.ellipsoid import closest_points
from contact.solver.broad_phase import clearance_left, mark_away, measure, surface_motion
from contact.solver.segment_motion import segment_records, set_motion
from contact.solver.step_record import ALLOWED, FAR, LOOK, SETS
from contact.solver.velocity_correction import VelocityCorrection
from tests.contact.solver.bodies import LIMB, limbs, random_axes

OFFSET = 1e-3


def crowd(rng, spun):
    """Limbs in motion and apart from each other; one far off that may spin too fast to be left out.

    Where a segment turns by more than a tenth of a radian a step no segment is ever left out.
    """
    body = limbs(rng, count=6)
    segments = []
    for k, old in enumerate(body.segments):
        start = rng.uniform(-0.3, 0.3, 3), random_axes(rng)
        motion = Steady(*start, rng.uniform(-0.3, 0.3, 3), rng.uniform(-20, 20, 3))
        segments.append(Segment(old.name, LIMB * rng.uniform(0.7, 1.3), motion))
    spin = Steady((50.0, 0, 0), np.eye(3), (0, 0, 0), (0, 0, 1e3 if spun else 0.0))
    return Body([*segments, Segment("far", LIMB, spin)])


def played(body, flesh, friction=(0.5, 0.3), steps=300, dt=1e-3):
    """Positions, velocities, segments and books of points that fall and are thrown about."""
    rng = np.random.default_rng(5)
    x, v = rng.uniform(-0.5, 0.5, (400, 3)), 0.5 * rng.standard_normal((400, 3))
    mass = rng.uniform(1e-4, 1e-2, len(x))
    correction = VelocityCorrection(body, len(x), friction, OFFSET, flesh=flesh)
    history, evaluated, active, t = [], 0, 0, 0.0
    for step in range(steps):
        if step == 100:  # somebody moves points about
            x[::3] = rng.uniform(-0.5, 0.5, x[::3].shape)
        if step == 150:  # somebody turns the clock back
            t = 0.1
        if step == 200:  # other segments may be met
            correction.allowed[::2] &= ~0b101
        old = v.copy()
        v += 30 * dt * rng.standard_normal(v.shape) - 200 * dt * x
        correction(x, v, mass, dt, t, old)
        evaluated, active = evaluated + correction.evaluated, active + correction.active
        history.append(
            (x.copy(), v.copy(), correction.segment.copy(), correction.last.table[:-1].copy())
        )
        x += dt * v
        t += dt
    assert active > 5 * steps
    return history, evaluated


@pytest.mark.parametrize("flesh", [np.inf, 1e5])
def test_same_contact_with_fewer_closest_points(flesh):
    every, many = played(crowd(np.random.default_rng(1), True), flesh)
    some, few = played(crowd(np.random.default_rng(1), False), flesh)
    for step, (one, other) in enumerate(zip(every, some, strict=True)):
        for a, b in zip(one, other, strict=True):
            assert np.array_equal(a, b), step
    print(f"closest points: {many} without, {few} with")
    assert few < many


def test_a_measurement_says_how_far_the_others_are():
    """Clearance and near set against distances from `closest_points`; motion uses it up."""
    rng = np.random.default_rng(2)
    body = limbs(rng, count=5)
    dt = 1e-3
    poses = [body.pose(t, body.new_pose()) for t in (0.0, dt)]
    segments = segment_records(body)
    set_motion(poses[0].centres, poses[0].axes, poses[1].centres, poses[1].axes, OFFSET, segments)
    motion, thinnest = surface_motion(segments, OFFSET)
    assert thinnest == body.radii.min()
    sets, look, margin = np.zeros((SETS, 1), np.int64), np.zeros((LOOK, 1)), 0.02
    sets[ALLOWED] = 31
    seen = set()
    for x in rng.uniform(-0.4, 0.4, (300, 3)):
        gaps = np.array(
            [
                closest_points(x, r, c, a)[2][0] - OFFSET
                for r, c, a in zip(body.radii, poses[0].centres, poses[0].axes, strict=True)
            ]
        )
        measure(x[None], 0, 1.0, margin, segments, OFFSET, sets, look)
        far = np.array([bool(sets[FAR, 0] >> b & 1) for b in range(5)])
        clearance = look[3, 0]
        assert (gaps[far] > margin).all() and (gaps[~far] <= margin / 0.99).all()
        assert clearance <= min(gaps[far], default=2 * margin)
        assert clearance > margin - 1e-12
        moved = x[None] + [0.003, 0.004, 0.0]
        left = clearance_left(moved, 0, 1.001, motion, look)
        assert left == pytest.approx(clearance - 0.005 - 0.001 - motion, abs=1e-15)
        # all nodes at once say the same of a step of 2 mm; a fixed node needs no clearance
        away, v, still = np.empty(1), np.array([[2.0, 0.0, 0.0]]), np.zeros((2, 3))
        for fixed in (False, True):
            given = np.ones(1), dt, 1.001, motion, np.array([fixed]), sets, look, *still, away
            mark_away(moved, v, *given)
            assert (away[0] >= 0.0) == (fixed or (left >= 0.002 and far.all()))
        seen.add(far.sum())
    assert len(seen) > 2


def test_no_surface_moves_farther_than_said():
    """Points all over ellipsoids that shift and turn, against the bound; at rest it is zero."""
    rng = np.random.default_rng(3)
    unit = rng.standard_normal((2000, 3))
    unit /= np.linalg.norm(unit, axis=1, keepdims=True)
    for _ in range(20):
        body = limbs(rng, count=1)
        start, end = (body.pose(t, body.new_pose()) for t in (0.0, 2e-3))
        segments = segment_records(body)
        set_motion(start.centres, start.axes, end.centres, end.axes, 0.0, segments)
        local = unit * body.radii[0]
        ways = local @ end.axes[0] + end.centres[0] - local @ start.axes[0] - start.centres[0]
        most = np.linalg.norm(ways, axis=1).max()
        assert most <= surface_motion(segments, 0.0)[0] < 3 * most
    still = Body([Segment("s", LIMB, Fixed((0, 0, 0)))])
    pose = still.pose(0.0, still.new_pose())
    segments = segment_records(still)
    set_motion(pose.centres, pose.axes, pose.centres, pose.axes, 0.0, segments)
    assert surface_motion(segments, 0.0)[0] == 0.0
