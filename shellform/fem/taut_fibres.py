# SPDX-License-Identifier: LGPL-3.0-or-later
"""Directions in which a wrinkled sheet may be taut: what their stiffness is, and where to look.

A sheet that wrinkles freely bears stress along one direction theta only. With the fibre
v = (cos^2, sin^2, cos sin) and the stiffness C in the axes of the fabric, its energy is the largest
(v.e)_+^2 / (2 v.C^-1.v) over theta (Pipkin, IMA J. Appl. Math. 36, 1986): quad_force.c looks among
samples, then takes Newton steps. Cloth soft in shear is stiff in narrow ranges about its yarns:
samples are spaced evenly in the integral of (v.C^-1.v)^-1/2, geometrically about the yarns.
"""

import numpy as np

SAMPLES = 24  # as in quad_force.c


def fibre_compliance(membrane: np.ndarray) -> np.ndarray:
    """Coefficients (5,) [m/N] of v.C^-1.v (1 + t^2)^2 by powers of t = tan theta."""
    S = np.linalg.inv(membrane)
    return np.array([S[0, 0], 2 * S[0, 2], 2 * S[0, 1] + S[2, 2], 2 * S[1, 2], S[1, 1]])


def compliance_at(q: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """v.C^-1.v [m/N] at angles, q of `fibre_compliance`."""
    c, s = np.cos(angle), np.sin(angle)
    return sum(q[k] * c ** (4 - k) * s**k for k in range(5))


def trial_angles(q: np.ndarray, count: int = SAMPLES) -> np.ndarray:
    """Angles (count,) in ascending order [rad], one of them that of the stiffest fibre."""
    fine = np.linspace(0.0, np.pi, 100_001)
    density = compliance_at(q, fine) ** -0.5
    reached = np.concatenate([[0.0], np.cumsum(0.5 * (density[1:] + density[:-1]))])
    at = reached[np.argmax(density)] + reached[-1] * np.arange(count) / count
    return np.sort(np.interp(at % reached[-1], reached, fine))


def table(membrane: np.ndarray) -> np.ndarray:
    """The fabric as quad_force.c reads it, its `struct fabric`: (14 + 7 SAMPLES,).

    Parameters
    ----------
    membrane : (3, 3), stiffness C [N/m]
    """
    q = fibre_compliance(membrane)
    angle = trial_angles(q)
    root = compliance_at(q, angle) ** -0.5
    before, after = np.roll(angle, 1), np.roll(angle, -1)
    before[0] -= np.pi
    after[-1] += np.pi
    weft = np.abs(np.cos(angle)) < np.abs(np.sin(angle))
    # from the weft angles are counted backwards
    local = (np.tan(np.where(weft, np.pi / 2 - a, a)) for a in (angle, before, after))
    at, *sides = local
    low, high = np.clip(np.sort(sides, axis=0), at - 2, at + 2)
    return np.concatenate(
        [
            membrane[np.triu_indices(3)], np.linalg.solve(membrane, [1.0, 1.0, 0.0]), q,
            root, root * np.cos(2 * angle), root * np.sin(2 * angle), weft,
            at, low, high,
        ]
    )  # fmt: skip
