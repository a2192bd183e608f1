# SPDX-License-Identifier: LGPL-3.0-or-later
"""A law of friction that depends on the slip velocity, in one file: all that a new law needs.

Stribeck's curve: mu falls from the static to the kinetic coefficient as the slip gets faster,
mu(v) = mu_k + (mu_s - mu_k) exp(-v / v_s) (R. Stribeck, 1902; the exponential form is Bo and
Pavelescu's, Wear 82, 1982).
"""

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from contact.kernel import kernel
from contact.solver.active_set import judge_kernel
from contact.solver.friction import Friction, as_friction
from contact.solver.held_nodes import SLIP, STICK, SolvedStep, new, push_kernel
from contact.solver.slip_friction import slip_friction
from contact.solver.step_record import step_record
from contact.solver.velocity_correction import VelocityCorrection
from tests.contact.solver.bodies import G, spheres


@kernel
def _stribeck(speed, parameters):
    mu_s, mu_k, scale = parameters[0], parameters[1], parameters[2]
    return mu_k + (mu_s - mu_k) * np.exp(-speed / scale)


@dataclass(frozen=True)
class Stribeck(Friction):
    """Friction that falls with the slip speed; `scale` is where most of the fall is done [m/s]."""

    scale: float = 0.1

    kinetic_coefficient = staticmethod(_stribeck)

    @property
    def parameters(self):
        return *super().parameters, self.scale

    def at(self, speed):
        """mu at a slip speed [m/s]."""
        return self.kinetic + (self.static - self.kinetic) * np.exp(-speed / self.scale)


LAW = Stribeck(0.6, 0.2, scale=0.5)
PLAIN = 1e6  # radius of a sphere that is a plain, for a way of metres [m]


def thrown(law, speed, seconds, dt):
    """Speeds of a node thrown along a plain, step by step."""
    correction = VelocityCorrection(spheres((0, 0, -PLAIN), radius=PLAIN), 1, law)
    x, v, speeds = np.zeros((1, 3)), np.array([[speed, 0.0, 0.0]]), []
    for step in range(round(seconds / dt)):
        v[0, 2] -= G * dt
        correction(x, v, np.array([0.3]), dt, step * dt)
        x += dt * v
        speeds.append(v[0, 0])
    return np.array(speeds), correction


def test_a_thrown_node_slows_down_as_the_equation_says():
    """dv/dt = -mu(v) g, against an integrator of high order; the error is of first order."""
    exact = solve_ivp(lambda t, v: -LAW.at(v) * G, (0, 0.5), [2.0], rtol=1e-10, atol=1e-12)
    errors = []
    for dt in (4e-3, 2e-3, 1e-3):
        speeds, correction = thrown(LAW, 2.0, 0.5, dt)
        assert correction.sticking == 0 and speeds[-1] > 0.3
        errors.append(abs(speeds[-1] - exact.y[0, -1]))
    assert errors[0] < 5e-3
    assert np.abs(np.array(errors[:-1]) / errors[1:] - 2).max() < 0.1
    # and the law makes a difference: neither coefficient alone comes near
    for mu in (0.2, 0.6):
        assert abs(thrown(mu, 2.0, 0.5, 1e-3)[0][-1] - exact.y[0, -1]) > 20 * errors[0]


def test_it_comes_to_rest_and_sticks_below_the_static_cone():
    speeds, correction = thrown(LAW, 0.5, 0.3, 1e-3)
    assert abs(speeds[-1]) < 1e-12 and correction.sticking == 1
    book = correction.window
    assert book.friction_loss.sum() == pytest.approx(0.5 * 0.3 * 0.5**2, rel=1e-3)


def test_a_constant_law_is_the_default_bit_for_bit():
    flat = Stribeck(0.3, 0.3)
    assert np.array_equal(thrown(flat, 1.0, 0.2, 1e-3)[0], thrown(0.3, 1.0, 0.2, 1e-3)[0])


def test_the_law_may_change_between_steps():
    correction = VelocityCorrection(spheres((0, 0, -PLAIN), radius=PLAIN), 1, 0.3)
    assert correction.friction == Friction(0.3)
    slowed = []
    for law in (LAW, 0.6, (0.6, 0.2), LAW):
        correction.friction = law
        assert correction.friction == as_friction(law)
        v = np.array([[1.0, 0.0, -0.01]])
        correction(np.zeros((1, 3)), v, np.ones(1), 1e-3, 0.0)
        slowed.append(1.0 - v[0, 0])
    expected = [LAW.at(1.0), 0.6, 0.2, LAW.at(1.0)]
    assert slowed == pytest.approx(0.01 * np.array(expected), rel=1e-9)


def held_on_a_plain(law, dt):
    """Step and set of one node that slips on a plain."""
    step, nodes = step_record(law, 0.0), new(1)
    step["dt"] = dt
    nodes.state[:], nodes.owner[:, 0], nodes.normal[:, 0, 2] = SLIP, 0, 1.0
    return step[0], nodes


def test_implicit_steps_push_with_the_same_law():
    """One solved step: the impulse is mu(v) of the normal one, and its loss is booked."""
    dt, mass, speed, zero = 0.01, np.array([0.3]), 0.4, np.zeros((1, 3))
    work, nodes = held_on_a_plain(LAW, dt)
    v = np.array([[speed, 0.0, -G * dt]])
    solved = SolvedStep(zero, v, np.array([[speed, 0.0, 0.0]]), zero, dt * v, zero, mass)
    impulse, pushed = np.zeros((1, 3)), np.zeros((1, 3))
    surface, impulses, energies = (np.zeros((1, 3, 3)) for _ in range(3))
    push = push_kernel(LAW.kinetic_coefficient)
    held = push(solved, surface, work, nodes.state, nodes, impulse, impulses, energies, pushed)
    assert held == (1, 0)
    mu = LAW.at(speed)
    assert impulse[0] == pytest.approx(0.3 * G * dt * np.array([-mu, 0.0, 1.0]), abs=1e-15)
    assert impulses[0, 0] == pytest.approx(impulse[0], abs=1e-18)
    assert v[0] == pytest.approx([speed - mu * G * dt, 0.0, 0.0], abs=1e-15)
    loss = 0.3 * mu * G * dt * (speed - 0.5 * mu * G * dt)
    assert energies[0, 0, 1] == pytest.approx(loss, rel=1e-12)


def test_implicit_steps_rub_slipping_nodes_with_the_same_law():
    """Friction against the way of the step, mu(way / dt) of the normal force; its slope."""
    dt, way, least = 0.01, 3e-3, 1e-5
    judge, (work, nodes) = judge_kernel(LAW.kinetic_coefficient), held_on_a_plain(LAW, dt)
    changed, reaction = np.zeros(1, bool), np.array([[0.0, 0.0, 2.0]])
    judge(np.array([[way, 0.0, 0.0]]), reaction, least, changed, work, nodes)
    assert nodes.state[0] == SLIP and not changed[0]
    assert nodes.cone[0] == pytest.approx(2.0 * LAW.at(way / dt), rel=1e-12)

    def rubbed(x, y, z=0.0):
        force, stiffness = np.zeros((1, 3)), np.zeros((1, 3, 3))
        owned = np.array([[x, y, z, 0.0, 0.0, 0.0]])
        axes, held = np.eye(3)[None], np.array([[False, False, True]])
        slip_friction(np.zeros((1, 3)), owned, nodes, axes, held, least, force, stiffness)
        return force[0], stiffness[0]

    for x, y in ((way, 0.0), (2e-3, -1e-3), (4e-6, 3e-6)):
        force, stiffness = rubbed(x, y, 1e-3)
        size = max(np.hypot(x, y), least)
        assert force == pytest.approx(-nodes.cone[0] * np.array([x, y, 0.0]) / size, rel=1e-12)
        for k, step in enumerate(1e-4 * least * np.eye(2)):
            ahead, behind = rubbed(x + step[0], y + step[1]), rubbed(x - step[0], y - step[1])
            slope = (behind[0] - ahead[0]) / (2e-4 * least)
            assert slope == pytest.approx(stiffness[k], abs=1e-6 * nodes.cone[0] / least)
    # it has not moved: sticks
    judge(np.array([[0.9 * least, 0.0, 0.0]]), reaction, least, changed, work, nodes)
    assert nodes.state[0] == STICK and changed[0]


@kernel
def _with_arrays(speed, parameters):
    both = np.zeros(2)
    both[0] = parameters[1]
    return both[0]


@kernel
def _no_number(speed, parameters):
    return parameters.kinetic


@pytest.mark.parametrize("coefficient", [_with_arrays, _no_number])
def test_a_kernel_that_does_not_compile_is_named(coefficient):
    @dataclass(frozen=True)
    class Odd(Friction):
        kinetic_coefficient = staticmethod(coefficient)

    with pytest.raises(ValueError, match=r"Odd\.kinetic_coefficient.* does not compile.*no arrays"):
        as_friction(Odd(0.3))
