# SPDX-License-Identifier: LGPL-3.0-or-later
"""The relaxed membrane: the conditions of its minimum, a search without them, differences."""

import numpy as np
import pytest
from scipy.optimize import minimize

from shellform.material.relaxed_stress import relax
from shellform.material.wrinkling import (
    SLACK,
    TAUT,
    WRINKLED,
    trial_angles,
    wrinkling_load,
)


def fabrics(count, seed=0):
    """Stiffness matrices from balanced cloth to one soft in shear, and stiffer in the weft."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        A = np.diag([1.0, 10 ** rng.uniform(-1, 1), 10 ** rng.uniform(-4, 0)])
        A[0, 1] = A[1, 0] = rng.uniform(0, 0.4) * np.sqrt(A[0, 0] * A[1, 1])
        yield A


def strains(count, seed):
    """Random strains, half of them with a load of wrinkling, of the order 0.1."""
    rng = np.random.default_rng(seed)
    E = 0.1 * rng.normal(size=(count, 3)) * [1.0, 1.0, 2.0]
    return E, 10 ** rng.uniform(-5, -1, count) * rng.integers(0, 2, count)


def relaxed(E, A, load):
    m = len(E)
    out = np.empty(m), np.empty((m, 3)), np.empty((m, 3, 3)), np.empty(m, np.int64), np.empty(m)
    relax(E, A, np.linalg.inv(A), trial_angles(A), np.broadcast_to(load, m), *out)
    return out


def smallest(a):
    """Smaller eigenvalue of tensors (11, 22, 12)."""
    return 0.5 * (a[:, 0] + a[:, 1]) - np.hypot(0.5 * (a[:, 0] - a[:, 1]), a[:, 2])


def test_stress_fulfils_the_conditions_of_the_minimum():
    """Ten thousand strains. The problem is convex: its conditions of optimality suffice."""
    seen = np.zeros(3, int)
    for k, A in enumerate(fabrics(20)):
        E, load = strains(500, 100 + k)
        energy, stress, _, state, _ = relaxed(E, A, load)
        W = stress @ np.linalg.inv(A) - E  # engineering shear
        W[:, 2] *= 0.5
        Z = stress + load[:, None] * [1.0, 1.0, 0.0]
        size = np.abs(E).max()
        assert smallest(W).min() > -1e-9 * size
        assert smallest(Z).min() > -1e-9 * size
        assert np.abs(W @ [1, 0, 0] * Z[:, 0] + W[:, 1] * Z[:, 1] + 2 * W[:, 2] * Z[:, 2]).max() < (
            1e-9 * size**2
        )
        elastic = 0.5 * np.sum(stress * (stress @ np.linalg.inv(A)), axis=1)
        np.testing.assert_allclose(energy, elastic + load * (W[:, 0] + W[:, 1]), atol=1e-14)
        seen += np.bincount(state, minlength=3)
    assert seen.min() > 500


@pytest.mark.slow
def test_stress_against_a_search():
    """Minimisation over W = L L^T from several starts, which knows no angles."""
    rng = np.random.default_rng(3)
    for k, A in enumerate(fabrics(5, seed=1)):
        E, load = strains(8, 200 + k)
        _, stress, *_ = relaxed(E, A, load)
        for e, cost, wanted in zip(E, load, stress, strict=True):

            def strain(x, e=e):
                return e + [x[0] ** 2, x[1] ** 2 + x[2] ** 2, 2 * x[0] * x[1]]

            def energy(x, A=A, cost=cost, strain=strain):
                return 0.5 * strain(x) @ A @ strain(x) + cost * (x @ x)

            starts = 0.3 * rng.normal(size=(12, 3))
            found = [minimize(energy, x, method="BFGS", options={"gtol": 1e-12}) for x in starts]
            best = min(found, key=lambda result: result.fun)
            np.testing.assert_allclose(wanted, A @ strain(best.x), atol=1e-5)


def test_stress_is_the_slope_of_the_energy_and_tangent_that_of_the_stress():
    h = 1e-7
    for k, A in enumerate(fabrics(10, seed=2)):
        E, load = strains(300, 300 + k)
        _, stress, tangent, state, _ = relaxed(E, A, load)
        for i in range(3):
            step = h * np.eye(3)[i]
            ahead, behind = relaxed(E + step, A, load), relaxed(E - step, A, load)
            slope = (ahead[0] - behind[0]) / (2 * h)
            np.testing.assert_allclose(slope, stress[:, i], atol=1e-7)
            same = (ahead[3] == state) & (behind[3] == state)
            slope = (ahead[1] - behind[1]) / (2 * h)
            np.testing.assert_allclose(slope[same], tangent[same, :, i], atol=2e-4)


def test_energy_is_convex_along_lines():
    for k, A in enumerate(fabrics(10, seed=4)):
        (first, load), (second, _) = strains(200, 400 + k), strains(200, 500 + k)
        t = np.linspace(0.0, 1.0, 9)
        energy = np.array([relaxed(first + s * (second - first), A, load)[0] for s in t])
        bent = energy[2:] - 2 * energy[1:-1] + energy[:-2]
        assert bent.min() > -1e-13


@pytest.mark.parametrize(
    ("E", "state", "stress"),
    [
        ((0.01, 0.01, 0.0), TAUT, (0.013, 0.013, 0.0)),
        ((0.01, -0.01, 0.0), WRINKLED, (0.01 * (1 - 0.3**2), 0.0, 0.0)),
        ((-0.01, -0.01, 0.0), SLACK, (0.0, 0.0, 0.0)),
    ],
)
def test_isotropic_sheet(E, state, stress):
    """nu = 0.3: pulled one way and shortened the other it carries uniaxial tension."""
    A = np.array([[1.0, 0.3, 0.0], [0.3, 1.0, 0.0], [0.0, 0.0, 0.35]])
    _, found, _, is_state, direction = relaxed(np.array([E]), A, 0.0)
    assert is_state[0] == state
    np.testing.assert_allclose(found[0], stress, atol=1e-12)
    assert np.sin(direction[0]) == pytest.approx(0.0, abs=1e-9)


def test_no_compression_beyond_the_load():
    A = next(fabrics(1))
    E = np.array([[-0.3, -0.2, 0.1]])
    _, stress, *_ = relaxed(E, A, 0.004)
    np.testing.assert_allclose(stress[0], [-0.004, -0.004, 0.0], atol=1e-12)


def test_load_of_wrinkling():
    """Euler's strip, half a wave long, in the open; 2 sqrt(k D) between beds of flesh."""
    D, h = 1.2e-5, 0.03
    assert wrinkling_load(D, h) == pytest.approx(D * (np.pi / h) ** 2, rel=1e-12)
    k = 4e5
    assert wrinkling_load(D, h, k) == pytest.approx(2 * np.sqrt(k * D), rel=1e-12)
    # cells finer than the wave change nothing; coarse waves cost what their shape does
    q = np.linspace(np.pi / 0.001, 3 * np.pi / 0.001, 20001)
    for size in (0.001, 0.003):
        q = np.linspace(np.pi / size, 10 * np.pi / size, 20001)
        cost = (D * q**2 + 1e9 / q**2).min()
        assert wrinkling_load(D, size, 1e9) == pytest.approx(cost, rel=1e-6)
