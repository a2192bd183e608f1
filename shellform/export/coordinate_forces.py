# SPDX-License-Identifier: LGPL-3.0-or-later
"""The garment as a force of each coordinate, fitted to a run: what it does at an angle and a speed.

    tau = a0 + a1 q + a2 q^2 + a3 q^3 + b dq/dt

by least squares over the windows that count, each by its length. A garment has friction and hangs
on other joints too: what is left over is told with the fit, and where it is large the force stands
for little. Outside the angles of the run a cubic is a guess: q is held to them.
"""

from typing import NamedTuple

import numpy as np


class Fit(NamedTuple):
    """A fitted force.

    a : (4,), of q [rad]; b : of its rate [rad/s]; low, high : angles of the run [rad]
    left : root mean square of what is left over [N m]; size : of the torque itself [N m]
    """

    a: np.ndarray
    b: float
    low: float
    high: float
    left: float
    size: float

    def expression(self) -> str:
        """The force as OpenSim's expressions spell it, of q and qdot."""
        powers = "+".join(
            f"({value:.9g})" + f"*{self._held()}" * k for k, value in enumerate(self.a)
        )
        return f"{powers}+({self.b:.9g})*qdot"

    def _held(self):
        return f"min(max(q,{self.low:.9g}),{self.high:.9g})"


def fit(torque: np.ndarray, angle: np.ndarray, rate: np.ndarray, weights: np.ndarray) -> Fit:
    """Fit a force to torques (n,) [N m] at angles [rad] and rates [rad/s].

    Powers that the angles do not tell apart come out as small as they can be.
    """
    middle, half = 0.5 * (angle.max() + angle.min()), max(0.5 * np.ptp(angle), 1e-9)
    x, fastest = (angle - middle) / half, max(np.abs(rate).max(), 1e-9)
    basis = np.column_stack([np.ones_like(x), x, x**2, x**3, rate / fastest])
    root = np.sqrt(weights / weights.sum())
    found = np.linalg.lstsq(root[:, None] * basis, root * torque, rcond=1e-8)[0]
    scaled = np.polynomial.Polynomial(found[:4], [middle - half, middle + half], [-1, 1])
    a = np.zeros(4)
    plain = scaled.convert().coef
    a[: len(plain)] = plain
    left = float(np.linalg.norm(root * (torque - basis @ found)))
    size = float(np.linalg.norm(root * torque))
    return Fit(a, float(found[4] / fastest), float(angle.min()), float(angle.max()), left, size)
