# SPDX-License-Identifier: LGPL-3.0-or-later
"""Flesh under cloth: closed forms of depth and force, loops, books, a hard body as its limit."""

import numpy as np
import pytest

from contact.body.flesh_bed import HARD, Flesh
from contact.body.segments import Body, Fixed, Segment
from contact.solver.flesh_correction import FleshCorrection
from contact.solver.velocity_correction import VelocityCorrection
from tests.contact.solver.bodies import G

AREAL = 0.25  # kg/m^2
DT = 1e-4


class Lifted:
    """A body that goes up and down, z0 + height(t)."""

    def __init__(self, z0, height):
        self.z0, self.height = z0, height

    def pose(self, t):
        """Centre, axes, velocity and spin, see Fixed."""
        centre, axes, velocity, spin = Fixed((0.0, 0.0, self.z0 + self.height(t))).pose(t)
        velocity = velocity + [0, 0, (self.height(t + 1e-7) - self.height(t - 1e-7)) / 2e-7]
        return centre, axes, velocity, spin


def ball(radius=0.1, motion=None):
    return Body([Segment("limb", [radius] * 3, motion or Fixed((0.0, 0.0, -radius)))])


def on(body, n, flesh, friction=0.0, areal=AREAL, offset=0.0):
    return FleshCorrection(body, n, friction, offset, flesh=flesh, areal_mass=areal)


def test_a_node_at_rest_sinks_until_the_bed_bears_it():
    """p = rho g, d = p/k; the force is the weight."""
    k, mass = 2e3, np.array([3e-4])
    correction = on(ball(), 1, Flesh(k), friction=0.3)
    x, v = np.array([[0.0, 0.0, 1e-5]]), np.zeros((1, 3))
    for step in range(20000):
        old = v.copy()
        v *= 1 - 60 * DT  # drag brings it to rest
        v[:, 2] -= DT * G
        correction(x, v, mass, DT, step * DT, v_old=old)
        x += DT * v
    depth = AREAL * G / k
    assert x[0, 2] == pytest.approx(-depth, rel=1e-6)
    assert correction.sides["depth"][0] == pytest.approx(depth, rel=1e-6)
    assert correction.last.impulse[0, 2] / DT == pytest.approx(mass[0] * G, rel=1e-6)
    stored = 0.5 * k * depth**2 * mass[0] / AREAL
    assert correction.stored_energy(mass) == pytest.approx(stored, rel=1e-5)


def test_a_node_rests_in_a_valley_between_two_limbs():
    """Both press alike, k d = rho g/cos(angle of their normals to the pull), and neither throws it.

    Pulled aside as well, it stays in the valley as long as both still press.
    """
    radius, half, k, mass = 0.1, 0.05, 2e4, np.array([3e-4])
    limbs = [
        Segment(name, [radius] * 3, Fixed((sign * half, 0.0, 0.0)))
        for name, sign in (("one", -1), ("other", 1))
    ]
    for aside in (0.0, 0.3):
        pull = 50.0 * G * np.array([np.sin(aside), 0.0, -np.cos(aside)])
        correction = on(Body(limbs), 1, Flesh(k))
        x, v = np.array([[1e-3, 0.0, 0.0871]]), np.zeros((1, 3))
        speeds = []
        for step in range(6000):
            old = v.copy()
            v *= 1 - 60 * DT
            v += DT * pull
            correction(x, v, mass, DT, step * DT, v_old=old)
            x += DT * v
            speeds.append(np.linalg.norm(v))
        assert max(speeds[-500:]) < 1e-6
        away = [x[0] - (sign * half, 0.0, 0.0) for sign in (-1, 1)]
        depths = [radius - np.linalg.norm(arm) for arm in away]
        assert depths[0] == pytest.approx(depths[1], rel=1e-6)
        # pushes along both normals bear the pull; their sum is the pressure times the area
        normals = np.column_stack([arm / np.linalg.norm(arm) for arm in away])[[0, 2]]
        pushes = np.linalg.solve(normals, -AREAL * pull[[0, 2]])
        assert pushes.min() > 0 and depths[0] == pytest.approx(pushes.sum() / k, rel=1e-6)
        found = correction.last.segment_impulse[:, [0, 2]] / DT / mass * AREAL
        assert found == pytest.approx((normals * pushes).T, rel=1e-6)


def test_a_flat_plate_pressed_into_a_ball_of_flesh():
    """Pressures k (R - s) along the normal sum up to pi k (R - delta) delta^2."""
    radius, delta, k, h = 0.1, 0.01, 1e5, 5e-4
    grid = np.arange(-0.05 + h / 2, 0.05, h)
    x = np.stack([*np.meshgrid(grid, grid, indexing="ij"), np.full((len(grid),) * 2, DT)], -1)
    x = x.reshape(-1, 3)
    areal = 1e9  # so heavy that it does not move
    correction = on(ball(radius), len(x), Flesh(k), areal=areal)
    v = np.zeros_like(x)
    v[:, 2] = -1.0
    mass = np.full(len(x), areal * h * h)
    for step in range(101):
        correction(x, v, mass, DT, step * DT)
        x += DT * v
    assert x[:, 2] == pytest.approx(-delta, rel=1e-6)
    force = correction.last.impulse.sum(axis=0) / DT
    assert force[2] == pytest.approx(np.pi * k * (radius - delta) * delta**2, rel=1e-3)
    assert np.abs(force[:2]).max() < 1e-9 * force[2]


def test_cloth_that_starts_inside_is_not_thrown():
    """It comes out as fast as out of a hard body, but for a swing on the bed."""
    correction = on(ball(), 1, Flesh(6.7e5))
    x, v, mass = np.array([[0.0, 0.0, -0.02]]), np.zeros((1, 3)), np.array([3e-4])
    for step in range(3000):
        correction(x, v, mass, DT, step * DT)
        x += DT * v
        assert v[0, 2] < 0.2  # a node swings on its bed; thrown, it would have 30 m/s
    assert x[0, 2] > -1e-3 and correction.window.impulse[0, 2] > 0


@pytest.mark.parametrize("name", ["elastic", "slips", "relaxes"])
def test_a_closed_cycle_loses_the_area_of_its_loop(name):
    """None, 4 Y (a - Y/k_s), and pi a^2 k_v w tau/(1 + (w tau)^2) at amplitude a; books agree.

    Steps of t press with what they end with: k (d' - d)^2/2 more a step, pi^2 k a^2 t/T a cycle.
    """
    more, wanted, mean, a, period = {}, 0.0, 4e-3, 2e-3, 0.5
    if name == "slips":
        more, wanted = {"slip_stiffness": 1e5, "yield_pressure": 50.0}, 4 * 50.0 * (a - 50.0 / 1e5)
    if name == "relaxes":
        more = {"relaxing_stiffness": 1e5, "relaxation_time": 0.2}
        w = 2 * np.pi / period * 0.2
        wanted = np.pi * a**2 * 1e5 * w / (1 + w * w)
    motion = Lifted(-0.1, lambda t: mean - a * np.cos(2 * np.pi * t / period))
    areal = 1e9
    correction = on(ball(motion=motion), 1, Flesh(2e5, **more), areal=areal)
    mass, x, v = np.array([areal * 1e-4]), np.zeros((1, 3)), np.zeros((1, 3))
    cycles, dt, lost, work = 6, period / 4000, [], []
    for step in range(cycles * 4000):
        v[:] = 0.0
        correction(x, v, mass, dt, step * dt)
        if (step + 1) % 4000 == 0:
            lost.append(correction.window.impact_loss.sum())
            work.append(correction.window.work.sum())
            correction.reset()
    of_steps = np.pi**2 * 2e5 * a**2 / 4000
    assert lost[-1] == pytest.approx((wanted + of_steps) * 1e-4, rel=2e-3)
    assert work[-1] == pytest.approx(lost[-1], rel=1e-4)


def test_energy_lost_is_never_negative_beyond_what_is_stored():
    """Cloth that is thrown on flesh: momentum, moments, and loss >= stored."""
    random = np.random.default_rng(3)
    body = Body(
        [
            Segment("limb", (0.1, 0.12, 0.2), Fixed()),
            Segment("other", (0.1, 0.12, 0.2), Fixed((0.15, 0.0, 0.0))),
        ]
    )
    flesh = Flesh({"limb": 3e4, "other": 6e4}, 1e4, 30.0, 2e4, 0.05)
    n = 400
    x = random.normal(size=(n, 3))
    x *= (0.3 / np.linalg.norm(x, axis=1))[:, None]  # outside both
    v, mass = -4.0 * x / 0.3, random.uniform(1e-4, 2e-4, n)
    correction = on(body, n, flesh, friction=(0.5, 0.3), offset=1e-3)
    touched = 0
    for step in range(1500):
        before, old = v.copy(), v.copy()
        correction(x, v, mass, DT, step * DT, v_old=old)
        impulse = mass[:, None] * (v - before)
        last = correction.last
        assert np.allclose(impulse, last.impulse, atol=1e-18)
        assert np.abs(last.segment_impulse.sum(axis=0) - impulse.sum(axis=0)).max() < 1e-12
        moment = np.cross(x, impulse).sum(axis=0)
        centres = np.array([[0.0, 0.0, 0.0], [0.15, 0.0, 0.0]])
        booked = last.segment_moment + np.cross(centres, last.segment_impulse)
        assert np.abs(booked.sum(axis=0) - moment).max() < 1e-12
        gained = 0.5 * mass @ (np.sum(v**2, axis=1) - np.sum(before**2, axis=1))
        spent = last.work.sum() - last.friction_loss.sum() - last.impact_loss.sum()
        assert gained == pytest.approx(spent, abs=1e-12)
        touched += correction.active
        x += DT * v
        lost = correction.window.impact_loss.sum()
        assert lost >= correction.stored_energy(mass) * (1 - 1e-9) - 1e-9
        assert correction.window.friction_loss.sum() >= 0
    assert touched > 1000


def test_stiff_flesh_is_a_hard_body():
    """The same force and place as with rigid segments, incline and all."""
    found = []
    for correction in (
        VelocityCorrection(ball(), 1, (0.5, 0.4)),
        on(ball(), 1, Flesh(HARD), (0.5, 0.4)),
    ):
        x, v, mass = np.array([[0.03, 0.0, -0.004]]), np.zeros((1, 3)), np.array([1e-3])
        for step in range(3000):
            old = v.copy()
            v[:, 2] -= DT * G
            correction(x, v, mass, DT, step * DT, v_old=old)
            x += DT * v
        found.append((x.copy(), correction.last.impulse / DT))
    assert np.abs(found[0][0] - found[1][0]).max() < 1e-5
    assert found[0][1] == pytest.approx(found[1][1], rel=1e-3, abs=1e-5 * 1e-3 * G)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"stiffness": -1.0}, "stiffness of flesh is above 0"),
        ({"stiffness": {"limb": np.nan}}, "of flesh of limb"),
        ({"stiffness": 1e5, "slip_stiffness": 1.0}, "both slip_stiffness and yield_pressure"),
        ({"stiffness": 1e5, "relaxation_time": "slow"}, "relaxation_time of flesh.*'slow'"),
    ],
)
def test_wrong_flesh(wrong, said):
    with pytest.raises(ValueError, match=said):
        Flesh(**wrong)


def test_flesh_of_no_segment():
    with pytest.raises(ValueError, match=r"flesh of 'calf': no segment.*limb"):
        on(ball(), 1, Flesh({"calf": 1e5}))
