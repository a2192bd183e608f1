# SPDX-License-Identifier: LGPL-3.0-or-later
"""Energy, stress and tangent of a membrane that wrinkles, cell by cell: see wrinkling.py.

The direction of a wrinkled cell is that of the largest energy: the best of many trials, refined by
Newton's method between its neighbours.
"""

import numpy as np

from contact.kernel import kernel

from .wrinkling import SLACK, TAUT, WRINKLED

STEPS = 60  # of a bracketed search that ends after 5 or 6


@kernel
def relax(
    E: np.ndarray,
    membrane: np.ndarray,
    compliance: np.ndarray,
    angles: np.ndarray,
    load: np.ndarray,
    energy: np.ndarray,
    stress: np.ndarray,
    tangent: np.ndarray,
    state: np.ndarray,
    direction: np.ndarray,
) -> None:
    """Relaxed law in all cells.

    Parameters
    ----------
    E : (m, 3), strains (E11, E22, 2 E12); load : (m,), N_c [N/m]
    membrane, compliance : (3, 3), A [N/m] and its inverse; angles : (k,), `trial_angles`
    energy : (m,), set [J/m^2]; stress : (m, 3), set [N/m]; tangent : (m, 3, 3), set [N/m]
    state : (m,) int, set to TAUT, WRINKLED or SLACK; direction : (m,), set: angle from the warp
        [rad] along which a wrinkled cell is taut, its crests
    """
    e, v, v1, n = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    for m in range(E.shape[0]):
        cost = load[m]
        for i in range(3):
            e[i] = E[m, i] + cost * (compliance[i, 0] + compliance[i, 1])
        _multiply(membrane, e, n)
        direction[m] = 0.0
        if n[0] >= 0.0 and n[1] >= 0.0 and n[0] * n[1] >= n[2] * n[2]:
            state[m] = TAUT
            tangent[m] = membrane
        elif e[0] <= 0.0 and e[1] <= 0.0 and 4.0 * e[0] * e[1] >= e[2] * e[2]:
            state[m] = SLACK
            n[:] = 0.0
            tangent[m] = 0.0
        else:
            state[m] = WRINKLED
            theta = _best(e, compliance, angles)
            direction[m] = theta
            p, p1, _, q, q1, _, curve = _derivatives(theta, e, compliance, v, v1)
            pull = max(p, 0.0) / q
            # change of the stress with the angle, and of the angle with the strain
            for i in range(3):
                n[i] = pull * v[i]
                v1[i] = (p1 - p * q1 / q) / q * v[i] + pull * v1[i]
            for i in range(3):
                for j in range(3):
                    turned = v1[i] * v1[j] / curve if curve < 0.0 else 0.0
                    tangent[m, i, j] = v[i] * v[j] / q - turned
        n[0] -= cost
        n[1] -= cost
        stored, shortened = 0.0, 0.0
        for i in range(3):
            elastic = compliance[i, 0] * n[0] + compliance[i, 1] * n[1] + compliance[i, 2] * n[2]
            stored += 0.5 * n[i] * elastic
            if i < 2:
                shortened += elastic - E[m, i]
            stress[m, i] = n[i]
        energy[m] = stored + cost * shortened


@kernel
def _multiply(matrix, x, out):
    for i in range(3):
        out[i] = matrix[i, 0] * x[0] + matrix[i, 1] * x[1] + matrix[i, 2] * x[2]


@kernel
def _derivatives(theta, e, S, v, v1):
    """p = v.e, q = v.S v, their derivatives by the angle, and the second one of p^2/(2 q)."""
    c, s = np.cos(theta), np.sin(theta)
    c2, s2 = c * c - s * s, 2.0 * c * s
    v[0], v[1], v[2] = c * c, s * s, c * s
    v1[0], v1[1], v1[2] = -s2, s2, c2
    p = v[0] * e[0] + v[1] * e[1] + v[2] * e[2]
    p1 = s2 * (e[1] - e[0]) + c2 * e[2]
    p2 = 2.0 * c2 * (e[1] - e[0]) - 2.0 * s2 * e[2]
    q, q1, q2 = 0.0, 0.0, 0.0
    for i in range(3):
        Sv = S[i, 0] * v[0] + S[i, 1] * v[1] + S[i, 2] * v[2]
        Sv1 = S[i, 0] * v1[0] + S[i, 1] * v1[1] + S[i, 2] * v1[2]
        v2 = -2.0 * c2 if i == 0 else (2.0 * c2 if i == 1 else -2.0 * s2)
        q += v[i] * Sv
        q1 += 2.0 * v1[i] * Sv
        q2 += 2.0 * (v1[i] * Sv1 + v2 * Sv)
    curve = (p1 * p1 + p * p2) / q - 2.0 * p * p1 * q1 / q**2
    curve += p * p * (q1 * q1 / q**3 - 0.5 * q2 / q**2)
    return p, p1, p2, q, q1, q2, curve


@kernel
def _gain(theta, e, S):
    """Twice the energy of a direction, and its tension times compliance."""
    c, s = np.cos(theta), np.sin(theta)
    a, b, d = c * c, s * s, c * s
    p = max(a * e[0] + b * e[1] + d * e[2], 0.0)
    q = a * (S[0, 0] * a + 2.0 * (S[0, 1] * b + S[0, 2] * d))
    q += b * (S[1, 1] * b + 2.0 * S[1, 2] * d) + d * S[2, 2] * d
    return p * p / q


@kernel
def _best(e, S, angles):
    """The angle of the largest energy, by Newton's method in the bracket of the best trial."""
    best, value, last = 0, -1.0, len(angles) - 1
    for k in range(len(angles)):
        gain = _gain(angles[k], e, S)
        if gain > value:
            best, value = k, gain
    theta = angles[best]
    low = angles[best - 1] if best > 0 else angles[last] - np.pi
    high = angles[best + 1] if best < last else angles[0] + np.pi
    # directions with tension: within `reach` of the one in which e is largest
    middle, radius = 0.5 * (e[0] + e[1]), 0.5 * np.hypot(e[0] - e[1], e[2])
    principal = 0.5 * np.arctan2(e[2], e[0] - e[1])
    reach = 0.5 * np.arccos(max(-middle / radius, -1.0))
    for k in range(-3, 4):
        trial = principal + 0.3 * k * reach
        gain = _gain(trial, e, S)
        if gain > value:
            value, theta = gain, trial - np.pi * np.floor((trial - angles[0]) / np.pi)
            below = np.searchsorted(angles, theta, side="right") - 1
            low, high = angles[below], angles[below + 1] if below < last else angles[0] + np.pi
            offset = theta - trial
            low = max(low, principal - reach + offset)
            high = min(high, principal + reach + offset)
    v, v1 = np.empty(3), np.empty(3)
    for _ in range(STEPS):
        p, p1, _, q, q1, _, curve = _derivatives(theta, e, S, v, v1)
        slope = (p / q) * (p1 - 0.5 * p * q1 / q)
        if slope > 0.0:
            low = theta
        else:
            high = theta
        new = theta - slope / curve if curve < 0.0 else 0.5 * (low + high)
        if not low < new < high:
            new = 0.5 * (low + high)
        if abs(new - theta) < 1e-14:
            return new
        theta = new
    return theta
