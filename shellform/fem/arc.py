# SPDX-License-Identifier: LGPL-3.0-or-later
"""A bent sheet between two points: length of its arc and the angle it turns by, as series.

Written for numbers, arrays and UFL expressions alike. With dx = difference of positions, dd =
difference of directors; xx = dx . dx, xd = dx . dd, dd = dd . dd. quad_force.c has compiled twins.
"""

from typing import Any

import numpy as np

from meshes import Surface


def half_length_squared(xx: Any, xd: Any, dd: Any, weight: Any = 1) -> Any:
    """l^2/2 [m^2]; of a circular arc up to the fourth order of its angle, 0.1 % below at 60 deg.

    `weight` is that of what the arc is longer than its chord: 0 gives the chord.
    """
    return 0.5 * xx + weight * xd**2 * (1 + 2 * dd / 15) / 24


def turning(xd: Any, dd: Any) -> Any:
    """dx . dd [m] with the chord of the turn made its angle: phi = |dd| (1 + |dd|^2/24 + ...)."""
    return xd * (1 + dd / 12 + dd**2 / 90)


def arc_lengths(points: np.ndarray, directors: np.ndarray) -> np.ndarray:
    """Lengths (k,) [m] between two points (k, 2, 3) with the directors there."""
    dx, dd = points[:, 1] - points[:, 0], directors[:, 1] - directors[:, 0]
    products = (np.sum(a * b, axis=1) for a, b in ((dx, dx), (dx, dd), (dd, dd)))
    return np.sqrt(2 * half_length_squared(*products))


def sides_at_rest(surface: Surface) -> np.ndarray:
    """Lengths (m, corners) [m] of the sides of straight cells without stress.

    Of arcs, or, of cells cut from flat panels, those that they have there.
    """
    if surface.flat is not None:
        return np.linalg.norm(np.roll(surface.flat, -1, axis=1) - surface.flat, axis=2)
    cells = surface.cells[:, : 4 if surface.cells.shape[1] > 3 else 3]
    pairs = np.stack([cells, np.roll(cells, -1, axis=1)], 2).reshape(-1, 2)
    directors = np.asarray(surface.directors)
    return arc_lengths(surface.points[pairs], directors[pairs]).reshape(cells.shape)
