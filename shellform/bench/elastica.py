# SPDX-License-Identifier: LGPL-3.0-or-later
"""Heavy strips as elasticas, for curvatures that follow from moments: what `hang` and `loop` meet.

With the arc length s, the tangent at the angle phi above the horizontal, weight w per length and
width, and the force (H, V) that the part beyond s exerts,

    dphi/ds = kappa(m),   dm/ds = H sin phi - V cos phi,   dx/ds = cos phi,   dz/ds = sin phi.

A strip held level at s = 0, its end free: H = 0, V = -w (l - s), m(l) = 0. A loop whose ends are
held together, half of it from the grip to its lowest point at s = l: V is the same, as the halves
push each other across only, H follows from x(l) = 0 (Peirce, J. Text. Inst. 21, T377, 1930).
Solved by collocation (scipy's solve_bvp), the weight being put on in steps.
"""

from collections.abc import Callable

import numpy as np
from scipy.integrate import solve_bvp
from scipy.optimize import brentq

from shellform.errors import NotConverged
from shellform.material.sheet import Sheet

from .cycle import expected_loads, says_its_loads

CHORD = np.radians(41.5)  # below the horizontal, where ASTM D1388 reads the overhang
STEPS = 12
POINTS = 101

Curvature = Callable[[np.ndarray], np.ndarray]  # [1/m] of moments per width [N]


def curvature_of(fabric: Sheet, yarn: str, most: float = 2000.0) -> Curvature:
    """Curvature of a first bending of a fabric, up to `most` [1/m], as a function of the moment."""
    row = 1 if yarn == "weft" else 0
    if not says_its_loads(fabric) or (fabric.law is None and fabric.friction is None):
        B = float(fabric.bending[row, row])
        return lambda m: m / B
    kappa = np.concatenate([[0.0], np.geomspace(1e-2, most, 800)])
    moment = expected_loads(fabric, "bend", yarn, kappa)
    return lambda m: np.sign(m) * np.interp(np.abs(m), moment, kappa)


def cantilever(curvature: Curvature, weight: float, overhang: float) -> tuple[float, float]:
    """Fall and reach [m] of the tip of a strip of a weight [N/m2] held level.

    NotConverged where collocation finds no solution.
    """
    shape = np.zeros((4, POINTS))
    shape[2] = np.linspace(0, overhang, POINTS)
    x = _solve(
        curvature, weight, overhang, shape, None,
        lambda a, b: np.array([a[0], b[1], a[2], a[3]]),
    )  # fmt: skip
    return float(-x[3, -1]), float(x[2, -1])


def overhang_of(curvature: Curvature, weight: float, guess: float) -> float:
    """Overhang [m] of a strip whose chord falls by 41.5 degrees; `guess` [m] is near it."""

    def off(length):
        fall, reach = cantilever(curvature, weight, length)
        return np.arctan2(fall, reach) - CHORD

    return float(brentq(off, 0.5 * guess, 2.0 * guess, xtol=1e-6 * guess))


def loop_height(curvature: Curvature, weight: float, length: float, turn: float) -> float:
    """Distance [m] from the grip to the lowest point of a loop of a length [m].

    turn : angle [rad] from the lowest point to the grip, 3 pi/2 of a heart, pi/2 of a pear
    """
    half = 0.5 * length
    s = np.linspace(0, half, POINTS)
    # from the grip down to the lowest point, the arc of a circle to start with
    phi = turn * s / half - turn
    shape = np.zeros((4, POINTS))
    shape[0] = phi
    shape[2] = np.concatenate([[0.0], np.cumsum(np.cos(phi[:-1])) * half / (POINTS - 1)])
    shape[3] = np.concatenate([[0.0], np.cumsum(np.sin(phi[:-1])) * half / (POINTS - 1)])

    def ends(a, b, _):
        return np.array([a[0] + turn, a[2], a[3], b[0], b[2]])

    x = _solve(curvature, weight, half, shape, np.zeros(1), ends)
    return float(-x[3, -1])


def _solve(curvature, weight, length, shape, across, ends):
    """Solution (4, n) of phi, m, x, z; `across` is H to start with, None where there is none."""
    s = np.linspace(0, length, shape.shape[1])
    shape = shape.copy()
    for part in np.linspace(0, 1, STEPS + 1) ** 2:

        def slopes(s, y, p=None, w=part * weight):
            H = 0.0 if p is None else p[0]
            V = -w * (length - s)
            bent = H * np.sin(y[0]) - V * np.cos(y[0])
            return np.array([curvature(y[1]), bent, np.cos(y[0]), np.sin(y[0])])

        found = solve_bvp(slopes, ends, s, shape, p=across, tol=1e-6, max_nodes=20000)
        if not found.success:
            raise NotConverged(f"no elastica found at {part:.2g} of the weight: {found.message}")
        s, shape, across = found.x, found.y, found.p
    return shape
