# SPDX-License-Identifier: LGPL-3.0-or-later
"""Stress of the wrinkling membrane in the lanes of quad_force.c: against brute force."""

import numpy as np
import pytest

from shellform.fem.quad_force import relaxed_stress


def stiffnesses(count=20):
    """Random fabrics (3, 3): E2/E1 from 0.1 to 10, G/E from 1e-4 to 1, some with coupling."""
    rng = np.random.default_rng(0)
    for k in range(count):
        ratio = 10 ** rng.uniform(-1, 1)
        C = np.diag([1.0, ratio, 10 ** (-4 * k / (count - 1)) * np.sqrt(ratio)])
        C[0, 1] = C[1, 0] = rng.uniform(0, 0.7) * np.sqrt(ratio)
        if k % 5 == 4:
            C[0, 2] = C[2, 0] = 0.4 * np.sqrt(C[0, 0] * C[2, 2])
        yield 1e4 * C


def strains(rng, count, C):
    """Of all kinds, many of them near the borders of taut, wrinkled and slack."""
    e = rng.standard_normal((count, 3)) * 10.0 ** rng.uniform(-2, 0, (count, 3))
    third = count // 3
    angle, size = rng.uniform(0, np.pi, third), rng.standard_normal((third, 2))
    c, s = np.cos(angle), np.sin(angle)
    size[:, 1] *= 10.0 ** rng.uniform(-8, 0, third)
    frame = [[c * c, s * s], [s * s, c * c], [2 * c * s, -2 * c * s]]
    e[:third] = np.einsum("kim,mi->mk", frame, size)  # principal strains of unlike size
    taut = np.einsum("kim,mi->mk", [frame[0], frame[1], [c * s, -c * s]], size)
    e[third : 2 * third] = C[0, 0] * np.linalg.solve(C, taut.T).T  # and stresses
    return 1e-2 * e


def brute(C, e):
    """Stress without cost, by trying all angles and halving the best interval."""
    S, n = np.linalg.inv(C), e @ C.T
    fine = np.concatenate([np.geomspace(1e-6, np.pi / 4, 3000), [0.0]])
    fine = np.unique(np.concatenate([fine, -fine, np.pi / 2 - fine, np.pi / 2 + fine]))

    def fibre(t):
        c, s = np.cos(t), np.sin(t)
        return np.stack([c * c, s * s, c * s], -1)

    def rate(t):
        v, c2, s2 = fibre(t), np.cos(2 * t), np.sin(2 * t)
        dv = np.stack([-s2, s2, c2], -1)
        p, q = np.sum(v * e, -1), np.sum((v @ S) * v, -1)
        dp, dq = np.sum(dv * e, -1), 2 * np.sum((v @ S) * dv, -1)
        return np.where(p > 0, 2 * dp * q - p * dq, np.sign(best - t))

    v = fibre(fine)
    gain = np.maximum(e @ v.T, 0) / np.sqrt(np.sum((v @ S) * v, -1))
    principal = 0.5 * np.arctan2(e[:, 2], e[:, 0] - e[:, 1])
    best = np.where(gain.max(axis=1) > 0, fine[gain.argmax(axis=1)], principal)
    width = np.max(
        np.diff(fine)[np.clip(gain.argmax(axis=1)[:, None] + [-1, 0], 0, len(fine) - 2)], 1
    )
    low, high = best - width, best + width
    for _ in range(80):
        middle = 0.5 * (low + high)
        up = rate(middle) > 0
        low, high = np.where(up, middle, low), np.where(up, high, middle)
    v = fibre(0.5 * (low + high))
    pull = np.maximum(np.sum(v * e, -1), 0) / np.sum((v @ S) * v, -1)
    taut = (n[:, 0] >= 0) & (n[:, 1] >= 0) & (n[:, 0] * n[:, 1] >= n[:, 2] ** 2)
    return np.where(taut[:, None], n, pull[:, None] * v)


@pytest.mark.parametrize("free", [True, False])
def test_brute_force(free):
    """20 fabrics and 500 strains each, without cost and with it."""
    rng, worst = np.random.default_rng(1), 0.0
    for C in stiffnesses():
        e = strains(rng, 500, C)
        cost = np.zeros(500) if free else 10.0 ** rng.uniform(-3, 2, 500)
        shift = cost[:, None] * np.linalg.solve(C, [1.0, 1.0, 0.0])
        exact = brute(C, e) - cost[:, None] * [1.0, 1.0, 0.0]
        stress = relaxed_stress(C, e - shift, cost)
        scale = np.abs(e - shift).max(axis=1) * np.abs(C).max()
        worst = max(worst, (np.abs(stress - exact).max(axis=1) / scale).max())
    assert worst < 1e-7
