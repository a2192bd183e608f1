# SPDX-License-Identifier: LGPL-3.0-or-later
"""Friction impulses against Eq. 16 written down force by force."""

import numpy as np
import pytest

from contact.solver.friction import Friction, as_friction, cone_kernel

N = np.array([0.6, 0.0, 0.8])
ACROSS = np.array([0.8, 0.0, -0.6])
ASIDE = np.array([0.0, 1.0, 0.0])


transmitted = cone_kernel(Friction.kinetic_coefficient)


def tangential_impulse(normal, trial, mu_s, mu_k, impulse):
    """Friction impulse for a trial impulse (3,), filled; True in stick."""
    fraction = transmitted(normal, np.linalg.norm(trial), 1.0, np.array([mu_s, mu_k]))
    impulse[:] = fraction * trial
    return fraction == 1.0


def contact_force(force, normal, slip, mu_s, mu_k):
    """Eq. 16: force is the residual F, slip the tangential velocity v_T."""
    inward = force @ normal
    if inward > 0:
        return np.zeros(3)
    tangential, pressing = force - inward * normal, abs(inward)
    if np.linalg.norm(slip) > 0:
        return -inward * normal - mu_k * pressing * slip / np.linalg.norm(slip)
    if np.linalg.norm(tangential) <= mu_s * pressing:
        return -force
    return -inward * normal - mu_s * pressing * tangential / np.linalg.norm(tangential)


def force_over_step(force, normal, slip, mass, dt, mu_s, mu_k):
    """The impulses of one step that starts on the surface, over dt."""
    free = slip + dt / mass * force
    normal_impulse = max(0.0, -mass * free @ normal)
    impulse = np.empty(3)
    trial = -mass * (free - (free @ normal) * normal)
    tangential_impulse(normal_impulse, trial, mu_s, mu_k, impulse)
    return (normal_impulse * normal + impulse) / dt


@pytest.mark.parametrize(
    "force",
    [-2 * N, -2 * N + 0.9 * ACROSS, -2 * N - 0.5 * ACROSS + 0.6 * ASIDE, 3 * N + ASIDE],
)
def test_open_and_stick_are_equation_16_at_any_step(force):
    for dt in (1e-6, 1e-2, 10.0):
        expected = contact_force(force, N, np.zeros(3), 0.5, 0.3)
        if force @ N > 0:  # nothing presses: Eq. 16 has no friction either
            assert not expected.any()
        actual = force_over_step(force, N, np.zeros(3), 0.2, dt, 0.5, 0.3)
        assert np.abs(actual - expected).max() < 1e-14


def test_breaking_loose_is_equation_16_with_one_coefficient():
    force = -2 * N + 1.3 * ACROSS - 0.4 * ASIDE
    expected = contact_force(force, N, np.zeros(3), 0.5, 0.5)
    assert np.abs(force_over_step(force, N, np.zeros(3), 0.2, 1e-3, 0.5, 0.5) - expected).max() < (
        1e-14
    )


def test_sliding_is_equation_16_with_an_error_of_first_order():
    force, slip = -2 * N + 0.5 * ACROSS, 0.3 * ASIDE - 0.1 * ACROSS
    expected = contact_force(force, N, slip, 0.5, 0.3)
    steps = np.array([1e-3, 1e-4, 1e-5])
    errors = [
        np.linalg.norm(force_over_step(force, N, slip, 0.2, dt, 0.5, 0.3) - expected)
        for dt in steps
    ]
    assert np.abs(np.log10(errors)[:-1] - np.log10(errors)[1:] - 1).max() < 0.02


def test_stopping_distance_of_a_thrown_block():
    """v0^2 / (2 mu_k g), then rest for good: the slip is exactly zero."""
    g, mu_s, mu_k, dt, mass = 9.81, 0.5, 0.4, 1e-4, 0.3
    v, x, impulse = np.array([2.0, 1.0, 0.0]), np.zeros(3), np.empty(3)
    speed = np.linalg.norm(v)
    for _ in range(20_000):
        tangential_impulse(mass * g * dt, -mass * v, mu_s, mu_k, impulse)
        v = v + impulse / mass
        x = x + dt * v
    assert np.array_equal(v, np.zeros(3))
    assert np.linalg.norm(x) == pytest.approx(speed**2 / (2 * mu_k * g), rel=2e-4)


def test_slip_is_never_turned_around_nor_the_cone_left():
    rng = np.random.default_rng(0)
    impulse = np.empty(3)
    for _ in range(500):
        trial, normal = rng.standard_normal(3), rng.exponential()
        mu_s = rng.uniform(0, 2)
        mu_k = rng.uniform(0, mu_s)
        stick = tangential_impulse(normal, trial, mu_s, mu_k, impulse)
        left = trial - impulse
        assert left @ trial >= 0 and np.linalg.norm(np.cross(left, trial)) < 1e-14
        size = np.linalg.norm(impulse)
        assert size <= mu_s * normal * (1 + 1e-15)
        assert np.array_equal(impulse, trial) if stick else size == pytest.approx(mu_k * normal)
    assert transmitted(0.0, 1.0, 1.0, np.array([0.5, 0.5])) == 0.0
    assert transmitted(0.0, 0.0, 0.0, np.zeros(2)) == 1.0


def test_coefficients_are_checked():
    assert as_friction(0.3) == Friction(0.3) == Friction(0.3, 0.3) != Friction(0.3, 0.2)
    assert as_friction((0.5, 0.2)).parameters == (0.5, 0.2)
    law = Friction(0.4)
    assert as_friction(law) is law
    with pytest.raises(ValueError, match=r"0\.4 exceeds static friction 0\.3"):
        as_friction((0.3, 0.4))
    for wrong in (-0.1, np.nan, np.inf, (0.3, -0.1)):
        with pytest.raises(ValueError, match="finite and not negative"):
            as_friction(wrong)
    with pytest.raises(ValueError, match="pair"):
        as_friction((0.1, 0.1, 0.1))
