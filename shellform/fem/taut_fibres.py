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
    """v.C^-1.v as q0 + q1 cos 2t + q2 sin 2t + q3 cos 4t + q4 sin 4t; (5,) [m/N], t the angle."""
    S = np.linalg.inv(membrane)
    return np.array(
        [
            (3 * (S[0, 0] + S[1, 1]) + 2 * S[0, 1] + S[2, 2]) / 8,
            (S[0, 0] - S[1, 1]) / 2,
            (S[0, 2] + S[1, 2]) / 2,
            (S[0, 0] + S[1, 1] - 2 * S[0, 1] - S[2, 2]) / 8,
            (S[0, 2] - S[1, 2]) / 4,
        ]
    )


def sampled(q: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """v.C^-1.v [m/N] at doubled angles, q of `fibre_compliance`."""
    waves = [np.ones_like(angle), np.cos(angle), np.sin(angle), np.cos(2 * angle)]
    return q @ [*waves, np.sin(2 * angle)]


def table(membrane: np.ndarray) -> np.ndarray:
    """The fabric as quad_force.c reads it, its `struct fabric`: (14 + 5 SAMPLES,).

    Parameters
    ----------
    membrane : (3, 3), stiffness C [N/m]
    """
    q = fibre_compliance(membrane)
    fine = np.linspace(0.0, 2 * np.pi, 100_001)
    density = sampled(q, fine) ** -0.5
    reached = np.concatenate([[0.0], np.cumsum(0.5 * (density[1:] + density[:-1]))])
    start = fine[np.argmax(density)]  # a sample on the stiffest fibre
    whole = reached[-1]
    at = np.interp(start, fine, reached) + whole * np.arange(SAMPLES) / SAMPLES
    angle = np.sort(np.interp(at % whole, reached, fine))
    after = np.diff(angle, append=angle[0] + 2 * np.pi)
    shift = np.linalg.solve(membrane, [1.0, 1.0, 0.0])
    return np.concatenate(
        [
            membrane[np.triu_indices(3)], shift, q,
            np.cos(angle), np.sin(angle), 1.0 / sampled(q, angle),
            -np.tan(0.5 * np.roll(after, 1)), np.tan(0.5 * after),
        ]
    )  # fmt: skip
