# SPDX-License-Identifier: LGPL-3.0-or-later
"""Patches of nearly one size on the skin of ellipsoids, to sum up what happens there.

Every ellipsoid is cut into rows of equal area along its axis e1 and columns of equal area around
it. In between, (row, column) runs with the part of the area passed, so the patch of a point is
found from two tables. What happens at a point is shared out among the four nearest patches by
bilinear weights (cloud in cell: Hockney and Eastwood, Computer Simulation Using Particles, 1981):
nothing is lost, and a map stays even where points and patches do not match.
"""

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ellipe

from contact.kernel import kernel

KNOTS = 129  # of the tables that turn places into parts of the area
GAUSS = 4  # points in each direction of a piece whose area is integrated
SMALLEST = 1e-3  # patches below this [m] are taken for a mistake in the unit


def areas_between(radii: np.ndarray, heights: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """Areas [m^2] of the pieces of an ellipsoid between heights and angles.

    A point is (r1 s, r2 c cos phi, r3 c sin phi), c = sqrt(1 - s^2). By Nanson's formula
    dA = r1 r2 r3 |u / r| ds dphi, u the point of the unit sphere; Gauss points in every piece.

    Parameters
    ----------
    radii : (3,) [m]; heights : (k + 1,), s from -1 to 1; angles : (l + 1,), phi [rad]

    Returns
    -------
    (k, l) float
    """
    x, w = np.polynomial.legendre.leggauss(GAUSS)

    def points(edges):
        half, middle = 0.5 * np.diff(edges)[:, None], 0.5 * (edges[1:] + edges[:-1])[:, None]
        return (middle + half * x).ravel(), (half * w).ravel()

    (s, ds), (phi, dphi) = points(np.asarray(heights)), points(np.asarray(angles))
    around = (np.cos(phi) / radii[1]) ** 2 + (np.sin(phi) / radii[2]) ** 2
    density = np.sqrt((s[:, None] / radii[0]) ** 2 + (1 - s[:, None] ** 2) * around)
    pieces = np.prod(radii) * density * ds[:, None] * dphi
    shape = len(heights) - 1, GAUSS, len(angles) - 1, GAUSS
    return pieces.reshape(shape).sum(axis=(1, 3))


class Patches:
    """Patches on m ellipsoids, numbered ellipsoid by ellipsoid, row by row from -e1 to e1.

    Parameters
    ----------
    radii : (m, 3) [m]; size : float, side of a patch wished for [m]

    Attributes
    ----------
    rows, columns : (m,) int; first : (m + 1,) int, first patch of every ellipsoid
    owner : (P,) int, ellipsoid; areas : (P,) [m^2]
    centres : (P, 3), from the centre of the ellipsoid in its axes e1, e2, e3, its segment's [m]
    heights, sectors : (m, KNOTS), part of the area below a height s and before an angle phi
    """

    def __init__(self, radii: ArrayLike, size: float):
        if not (np.isfinite(size) and size >= SMALLEST):
            raise ValueError(f"patches have a size of at least {SMALLEST} m, not {size} m")
        self.radii, self.size = np.array(radii, float).reshape(-1, 3), float(size)
        m = len(self.radii)
        self.rows, self.columns = np.zeros(m, np.int64), np.zeros(m, np.int64)
        self.heights, self.sectors = np.zeros((m, KNOTS)), np.zeros((m, KNOTS))
        s, phi = np.linspace(-1, 1, KNOTS), np.linspace(-np.pi, np.pi, KNOTS)
        owner, areas, centres = [], [], []
        for b, r in enumerate(self.radii):
            fine = areas_between(r, s, phi)
            long, short = max(r[1:]), min(r[1:])
            girth = 4 * long * ellipe(1 - (short / long) ** 2)
            rows = max(2, round(fine.sum() / (girth * size)))
            columns = max(4, round(girth / size))
            self.rows[b], self.columns[b] = rows, columns
            for table, part in ((self.heights[b], fine.sum(1)), (self.sectors[b], fine.sum(0))):
                table[1:] = np.cumsum(part) / part.sum()
            edges = np.interp(np.arange(rows + 1) / rows, self.heights[b], s)
            angles = np.interp(np.arange(columns + 1) / columns, self.sectors[b], phi)
            areas.append(areas_between(r, edges, angles).ravel())
            middle = np.interp((np.arange(rows) + 0.5) / rows, self.heights[b], s)[:, None]
            angle = np.interp((np.arange(columns) + 0.5) / columns, self.sectors[b], phi)
            ring = np.sqrt(1 - middle**2)
            unit = middle + 0 * angle, ring * np.cos(angle), ring * np.sin(angle)
            centres.append((r * np.stack(unit, axis=-1)).reshape(-1, 3))
            owner.append(np.full(rows * columns, b))
        self.first = np.concatenate([[0], np.cumsum(self.rows * self.columns)])
        self.owner, self.areas = np.concatenate(owner), np.concatenate(areas)
        self.centres = np.concatenate(centres)
        self.tables = self.radii, self.heights, self.sectors, self.rows, self.columns, self.first

    def values(self, b: int, places: ArrayLike, numbers: ArrayLike) -> np.ndarray:
        """Numbers (P, ...) of patches, interpolated at places (k, 3) on ellipsoid b, its axes."""
        places = np.ascontiguousarray(places, float)
        which, weights = np.empty((len(places), 4), np.int64), np.empty((len(places), 4))
        _shares_at(places, b, *self.tables, which, weights)
        return np.einsum("ka,ka...->k...", weights, np.asarray(numbers)[which])


@kernel
def four_nearest(
    x0: float,
    x1: float,
    x2: float,
    b: int,
    radii: np.ndarray,
    heights: np.ndarray,
    sectors: np.ndarray,
    rows: np.ndarray,
    columns: np.ndarray,
    first: np.ndarray,
    which: np.ndarray,
    weights: np.ndarray,
) -> None:
    """Four nearest patches of a point on ellipsoid b and their shares, written into (4,) arrays."""
    u0, u1, u2 = x0 / radii[b, 0], x1 / radii[b, 1], x2 / radii[b, 2]
    last = heights.shape[1] - 1
    s = u0 / np.sqrt(u0 * u0 + u1 * u1 + u2 * u2)
    z = 0.5 * (s + 1.0) * last
    k = min(int(z), last - 1)
    row = rows[b] * (heights[b, k] + (z - k) * (heights[b, k + 1] - heights[b, k])) - 0.5
    z = 0.5 * (np.arctan2(u2, u1) / np.pi + 1.0) * last
    k = min(int(z), last - 1)
    column = columns[b] * (sectors[b, k] + (z - k) * (sectors[b, k + 1] - sectors[b, k])) - 0.5
    i, j = int(np.floor(row)), int(np.floor(column))
    f, g = row - i, column - j
    for a in range(4):
        up, on = a // 2, a % 2
        at = first[b] + min(max(i + up, 0), rows[b] - 1) * columns[b]
        which[a] = at + (j + on) % columns[b]
        weights[a] = (f if up else 1.0 - f) * (g if on else 1.0 - g)


@kernel
def _shares_at(places, b, radii, heights, sectors, rows, columns, first, which, weights):
    for k in range(len(places)):
        x = places[k]
        four_nearest(
            x[0], x[1], x[2], b, radii, heights, sectors, rows, columns, first, which[k],
            weights[k],
        )  # fmt: skip
