"""Closed lines of given girth and the number of cells along a length, for garments made of rings.

A garment's girth is what a tape measures on the mesh: the sum of the chords of a ring. A ring is
therefore an ellipse scaled until its polygon, not its curve, has the girth.
"""
# SPDX-License-Identifier: LGPL-3.0-or-later

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

import numpy as np

Curve = Callable[[np.ndarray], np.ndarray]  # parameters (n,) in 0 to 1 -> points (n, 3)

COARSE = 0.04  # m; cell sizes are brought between half of this and this by doubling
_SAMPLES = 4001


def count_cells(length: float, cell_size: float, least: int = 1) -> int:
    """Number of cells of about ``cell_size`` [m] on ``length`` [m], at least ``least``.

    Half of a cell size of at most 0.04 m gives exactly twice the cells, so that each mesh of a
    convergence study holds the points of the one before: the size is doubled until it lies in
    0.02 to 0.04 m, the cells are counted there and doubled as often.
    """
    doublings = max(0, int(np.floor(np.log2(COARSE / cell_size) + 1e-9)))
    return 2**doublings * max(least, round(length / (cell_size * 2**doublings)))


def polygon_length(points: np.ndarray) -> float:
    """Sum of the chords of a line (n, 3) in m."""
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def names_of(edges: Iterable[str], most: int = 6) -> str:
    """Names of edges for a sentence, the first of them if they are many; 'none' without any."""
    names = [f"'{name}'" for name in edges]
    more = [f"and {len(names) - most} more"] if len(names) > most else []
    return ", ".join(names[:most] + more) or "none"


def spread(curve: Curve, count: int) -> np.ndarray:
    """Parameters (count + 1,) in 0 to 1 at equal arc lengths along ``curve``.

    Parameters
    ----------
    curve : function of parameters (n,) in 0 to 1 returning points (n, 3).
    """
    parameters = np.linspace(0.0, 1.0, _SAMPLES)
    steps = np.linalg.norm(np.diff(curve(parameters), axis=0), axis=1)
    lengths = np.concatenate([[0.0], np.cumsum(steps)])
    return np.interp(np.linspace(0.0, lengths[-1], count + 1), lengths, parameters)


def ellipse(ratio: float, start: float = 0.0, turn: float = 2.0 * np.pi) -> Curve:
    """Curve on the ellipse x = cos, y = ratio sin from the angle ``start`` through ``turn`` rad."""

    def curve(t):
        angle = start + turn * t
        return np.stack([np.cos(angle), ratio * np.sin(angle), np.zeros_like(angle)], axis=1)

    return curve


def half_ring(girth: float, ratio: float, count: int, lift: float = 0.0) -> np.ndarray:
    """The left half of a ring about the z axis, from the front (+x) to the back (-x).

    Parameters
    ----------
    girth : of the whole ring's polygon, in m.
    ratio : breadth (y) over depth (x).
    count : segments on this half.
    lift : height of the back above the front in m; the ring lies in an inclined plane.

    Returns
    -------
    points (count + 1, 3) in m, the front at z = 0; both ends have y = 0 exactly.
    """
    scale = girth / (np.pi * (1.0 + ratio))
    for _ in range(30):

        def curve(t, scale=scale):
            points = scale * ellipse(ratio, turn=np.pi)(t)
            points[:, 2] = 0.5 * lift * (1.0 - points[:, 0] / scale)
            return points

        points = curve(spread(curve, count))
        scale *= 0.5 * girth / polygon_length(points)
    points[[0, -1], 1] = 0.0
    return points


def ring(
    girth: float, ratio: float, count: int, start: float = 0.0, turn: float = 2.0 * np.pi
) -> np.ndarray:
    """A flat closed ring of ``count`` equal segments about the z axis.

    Parameters
    ----------
    girth : of the polygon, in m.
    ratio : breadth (y) over depth (x).
    start, turn : angle of the first point from the x axis, and 2 pi or -2 pi, in rad.

    Returns
    -------
    points (count, 3) in m, without the first point repeated.
    """
    curve = ellipse(ratio, start, turn)
    points = curve(spread(curve, count))
    return girth / polygon_length(points) * points[:-1]


def bezier(corners: Sequence[np.ndarray]) -> tuple[Curve, Curve]:
    """Cubic Bezier curve of four points (4, 3), and its derivative, as functions of t (n,)."""
    a, b, c, d = corners

    def curve(t):
        t = t[:, None]
        s = 1.0 - t
        return s**3 * a + 3.0 * s**2 * t * b + 3.0 * s * t**2 * c + t**3 * d

    def slope(t):
        t = t[:, None]
        s = 1.0 - t
        return 3.0 * (s**2 * (b - a) + 2.0 * s * t * (c - b) + t**2 * (d - c))

    return curve, slope
