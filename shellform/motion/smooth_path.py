# SPDX-License-Identifier: LGPL-3.0-or-later
"""The smoothest way from rest into a given state that keeps within bounds.

A coordinate runs along a quintic B-spline with even knots. Of all such paths q that begin at rest
and end with a given value, rate and change of rate, the one is taken with the least

    integral of (q''')^2 dt   (Flash and Hogan, J. Neurosci. 5, 1985)

among those whose coefficients, and the coefficients of whose derivative, lie within bounds. As a
B-spline lies in the hull of its coefficients (de Boor, A Practical Guide to Splines, 1978), bounds
on value and rate hold at all times. The quadratic program is solved as a problem of least distance
(Lawson and Hanson, Solving Least Squares Problems, 1974, ch. 23).
"""

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import BSpline
from scipy.linalg import solve_triangular
from scipy.optimize import nnls

DEGREE = 5
SPAN = 0.02  # between knots [s], about: what both ends ask for reaches two spans inward
GAUSS = np.polynomial.legendre.leggauss(3)  # exact for the square of a quadratic


def smooth_path(
    times: np.ndarray,
    begin: float,
    end: tuple[float, float, float],
    bounds: tuple[float, float] = (-np.inf, np.inf),
    fastest: float = np.inf,
    lowest: ArrayLike | None = None,
) -> np.ndarray | None:
    """Values (n,) at times (n,) [s] of the smoothest path from rest; None where there is none.

    Parameters
    ----------
    times : (n,) float, rising; the path goes from the first to the last of them
    begin : value at the first time, with no rate and no change of it
    end : value, rate [1/s] and its change [1/s^2] at the last time
    bounds : least and greatest value; widened to what both ends ask for
    fastest : greatest size of the rate [1/s]; where the ends ask for more there they have it
    lowest : (n,) float, values below which the path may not go at each time, or None; both ends and
        two spans beside them are free of it

    Examples
    --------
    >>> times = np.linspace(0.0, 1.0, 51)
    >>> path = smooth_path(times, 0.0, (1.0, -4.0, 0.0), bounds=(-0.1, 1.2))
    >>> bool(path.max() <= 1.2), f"{path[-1]:.3f}"
    (True, '1.000')
    """
    long = times[-1] - times[0]
    spans = max(6, round(long / SPAN))
    h = long / spans
    inner = np.linspace(times[0], times[-1], spans + 1)
    knots = np.concatenate([[times[0]] * DEGREE, inner, [times[-1]] * DEGREE])
    count = spans + DEGREE
    known = np.zeros(count)
    known[:3] = begin
    known[-3:] = _last_three(end, h)
    free = np.arange(3, count - 3)
    basis = BSpline(knots, np.eye(count), DEGREE)
    at = (inner[:-1, None] + 0.5 * h * (1 + GAUSS[0])).ravel()
    weights = np.tile(np.sqrt(0.5 * h * GAUSS[1]), spans)
    jerk = weights[:, None] * basis.derivative(3)(at)
    ends = known[[*range(3), *range(-3, 0)]]
    low, high = min(bounds[0], ends.min()), max(bounds[1], ends.max())
    rates = DEGREE * (np.eye(count, k=1) - np.eye(count))[:-1]
    rates /= (knots[DEGREE + 1 : -1] - knots[1 : -DEGREE - 1])[:, None]
    rates = rates[2:-2]  # those that depend on what is free
    rows, least = [], []
    for row, value in ((np.eye(count)[free], low), (-np.eye(count)[free], -high)):
        if np.isfinite(value):
            rows.append(row)
            least.append(np.full(len(row), value))
    if np.isfinite(fastest):
        rows += [rates, -rates]
        least += [np.full(len(rates), -fastest)] * 2
    if lowest is not None:
        here = (times > times[0] + 2 * h) & (times < times[-1] - 2 * h)
        rows.append(basis(times[here]))
        least.append(np.asarray(lowest, float)[here])
    coefficients = known.copy()
    if rows:
        A, b = np.concatenate(rows), np.concatenate(least)
        found = _least_distance(jerk[:, free], -jerk @ known, A[:, free], b - A @ known)
    else:
        found = np.linalg.lstsq(jerk[:, free], -jerk @ known, rcond=None)[0]
    if found is None:
        return None
    # no digits that a library's sums may give otherwise on another day; the path stays smooth
    coefficients[free] = np.round(found, 9)
    return BSpline(knots, coefficients, DEGREE)(times)


def _last_three(end, h):
    """Last coefficients that give value, rate and change at a clamped end, spans h [s]."""
    value, rate, change = end
    last = h * rate / DEGREE
    before = 2 * (last - h * h * change / (DEGREE * (DEGREE - 1)))
    return value - last - before, value - last, value


def _least_distance(E, f, G, h):
    """x of the least |E x - f| with G x >= h, or None where nothing fulfils that."""
    Q, R = np.linalg.qr(E)
    best = Q.T @ f
    A = solve_triangular(R, G.T, trans=1).T
    scale = np.maximum(np.linalg.norm(A, axis=1), 1e-300)
    A, b = A / scale[:, None], (h - A @ best) / scale
    size = b.max()  # way to the farthest half-space that is missed: makes distances of order one
    if size <= 1e-12 * np.linalg.norm(best):
        return solve_triangular(R, best)
    b = b / size
    M = np.vstack([A.T, b])
    target = np.append(np.zeros(len(A.T)), 1.0)
    u, off = nnls(M, target, maxiter=30 * len(b))
    if off < 1e-7:
        return None
    r = M @ u - target
    y = -r[:-1] / r[-1] * size
    x = solve_triangular(R, y + best)
    slack = (G @ x - h) / np.maximum(np.abs(G).sum(axis=1), 1e-300)
    return x if slack.min() > -1e-6 * max(1.0, np.abs(h).max()) else None
