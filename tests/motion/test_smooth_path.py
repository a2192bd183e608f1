# SPDX-License-Identifier: LGPL-3.0-or-later
"""The smoothest path within bounds: known minima, bounds, ends; pose to joint angles and back."""

import doctest

import numpy as np
import pytest

import shellform as sf
from shellform.motion import joint_coordinates, smooth_path
from shellform.motion.capture import gait_initiation
from shellform.motion.gait import strides
from shellform.motion.gait.leg import joint_angles
from shellform.motion.gait.synthetic_walk import synthetic_walk
from shellform.motion.joint_coordinates import coordinates, heading_axes, points_of

TIMES = np.linspace(-1.2, 0.0, 601)
path = smooth_path.smooth_path


def quintic(times, begin, end):
    """The quintic from rest into a state, which has the least jerk of all paths."""
    long = times[-1] - times[0]
    powers = np.arange(6)
    rows = [
        0.0**powers,
        powers == 1,
        2.0 * (powers == 2),
        1.0**powers,
        powers,
        powers * (powers - 1),
    ]
    values = [begin, 0, 0, end[0], end[1] * long, end[2] * long**2]
    factors = np.linalg.solve(np.array(rows, float), values)
    return np.polynomial.polynomial.polyval((times - times[0]) / long, factors)


@pytest.mark.parametrize("end", [(1.0, 0.0, 0.0), (1.0, -4.0, 3.0), (-0.3, 2.0, -30.0)])
def test_without_bounds_it_is_the_quintic_of_least_jerk(end):
    exact = quintic(TIMES, 0.2, end)
    assert np.abs(path(TIMES, 0.2, end) - exact).max() < 1e-6
    # bounds that do not bind change nothing
    wide = path(TIMES, 0.2, end, (exact.min() - 0.5, exact.max() + 0.5), 100.0)
    assert np.abs(wide - exact).max() < 1e-5


@pytest.mark.parametrize("end", [(1.0, -4.0, 0.0), (0.1, 3.0, 10.0), (0.9, 5.0, -20.0)])
def test_bounds_hold_and_ends_are_met(end):
    """Value and rate; where the quintic breaks them; ends to the order of their differences."""
    times = np.linspace(-1.2, 0.0, 24001)
    free, h = quintic(times, 0.3, end), times[1] - times[0]
    for bounds, fastest in (((-0.02, 1.2), np.inf), ((-0.02, 1.4), 5.5)):
        found = path(times, 0.3, end, bounds, fastest)
        rate = np.gradient(found, h, edge_order=2)
        assert found.min() > bounds[0] - 1e-6 and found.max() < bounds[1] + 1e-6
        assert np.abs(rate).max() < fastest * (1 + 1e-3)
        assert found[0] == pytest.approx(0.3) and found[-1] == pytest.approx(end[0])
        assert rate[0] == pytest.approx(0.0, abs=1e-2)
        assert rate[-1] == pytest.approx(end[1], abs=0.01 * (1 + abs(end[1])))
        change = np.gradient(rate, h)[-3]
        assert change == pytest.approx(end[2], abs=0.1 * (10 + abs(end[2])))
    assert free.min() < -0.02 or free.max() > 1.2  # so the bounds did bind


def test_no_path_of_less_jerk_within_the_bounds():
    """Steps to either side within the bounds do not lower the jerk: it is convex."""
    bounds, end = (-0.05, 1.02), (0.8, -5.0, 0.0)
    found = path(TIMES, 0.0, end, bounds)
    assert found.max() > 1.0  # it leans on the bound

    def jerk(values):
        return np.sum(np.diff(values, 3) ** 2)

    rng = np.random.default_rng(3)
    tried = 0
    for _ in range(300):
        centre, width, size = rng.uniform(-1.0, -0.2), rng.uniform(0.1, 0.2), rng.normal(0, 0.02)
        bump = np.clip(1 - ((TIMES - centre) / width) ** 2, 0, None) ** 4
        other = found + size * bump
        if other.min() >= bounds[0] and other.max() <= bounds[1]:
            tried += 1
            # coefficients lie a little within the bounds that the values may touch
            assert jerk(other) > 0.95 * jerk(found)
    assert tried > 50


def test_lowest_values_are_kept():
    lowest = 0.3 * np.exp(-(((TIMES + 0.6) / 0.15) ** 2))
    found = path(TIMES, 0.0, (0.0, 0.0, 0.0), lowest=lowest)
    inner = (TIMES > -1.15) & (TIMES < -0.05)
    assert (found - lowest)[inner].min() > -1e-6
    assert 0.3 - 1e-6 < found.max() < 0.4


def test_a_path_that_there_is_not():
    """3 rad in 1.2 s at 1 rad/s; the same in 3.6 s there is."""
    assert path(TIMES, 0.0, (3.0, 0.0, 0.0), fastest=1.0) is None
    assert path(3 * TIMES, 0.0, (3.0, 0.0, 0.0), fastest=1.0) is not None


def test_pose_to_angles_and_back():
    """To roundoff; flexion is that of `joint_angles`, positive on both sides."""
    walk = synthetic_walk(strides=3)
    base = heading_axes(walk.points["pelvis"][0])
    found = coordinates(walk.points, base)
    for name, track in points_of(*found, base).items():
        assert np.abs(track - walk.points[name]).max() < 1e-12
    angles = joint_angles(walk)
    for side in ("right", "left"):
        thigh, shank = (np.degrees(found.angles[f"{side}_{part}"]) for part in ("thigh", "shank"))
        np.testing.assert_allclose(thigh[:, 0], angles[f"{side}_hip_flexion"], atol=1e-9)
        np.testing.assert_allclose(thigh[:, 1], angles[f"{side}_hip_abduction"], atol=1e-9)
        np.testing.assert_allclose(shank[:, 0], angles[f"{side}_knee_flexion"], atol=1e-9)
        foot = np.degrees(found.angles[f"{side}_foot"][:, 0])
        np.testing.assert_allclose(foot, angles[f"{side}_ankle_dorsiflexion"], atol=5.0)


@pytest.mark.parametrize("module", [smooth_path, joint_coordinates, gait_initiation, strides])
def test_examples_of_docstrings(module):
    assert doctest.testmod(module, extraglobs={"sf": sf, "np": np}).failed == 0
