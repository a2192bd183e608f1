# SPDX-License-Identifier: LGPL-3.0-or-later
"""Error as a power of the size of a cell: fitted, inverted, extrapolated; the best of many runs.

    error^2 = (s C r^p + own)^2 + spread^2,   r = h/l,

see choice.py for what h, l, s, spread and own are.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

FLAT = 0.25  # an order below this is none


@dataclass(frozen=True)
class PowerLaw:
    """Relative error of a quantity over r = h/l.

    Attributes
    ----------
    factor, order : C and p
    spread : see the header
    scatter : >= 1, factor by which measured errors lie about the power
    finest, coarsest : r measured; the power is not trusted above the coarsest
    doubt : relative uncertainty of what errors were measured against
    floor : what no cells and no runs take off, where the doubt counts as an error
    """

    factor: float
    order: float
    spread: float = 0.0
    scatter: float = 1.0
    finest: float = 0.0
    coarsest: float = math.inf
    doubt: float = 0.0
    floor: float = 0.0

    def error(self, ratio: float, sensitivity: float = 1.0, own: float = 0.0) -> float:
        """Relative error at r."""
        of_cells = sensitivity * self.factor * ratio**self.order + own
        return math.hypot(of_cells, self.spread, self.floor)

    def of_runs(self, runs: int) -> "PowerLaw":
        """The law of the mean of several runs from other starts."""
        return replace(self, spread=self.spread / math.sqrt(runs))

    def ratio(self, error: float, sensitivity: float = 1.0, own: float = 0.0) -> tuple[float, bool]:
        """Largest r that keeps an error, and whether it does.

        Where none does, r at which cells add no more than what stays anyway, half the finest
        measured at least.
        """
        stays = math.hypot(self.spread, self.floor)
        of_cells = math.sqrt(max((error / self.scatter) ** 2 - stays**2, 0.0)) - own
        goal = of_cells if of_cells > 0 else math.hypot(stays, own)
        if self.order < FLAT:
            kept = self.error(self.finest, sensitivity, own) <= error
            return (self.coarsest if kept else self.finest), kept
        ratio = (goal / (sensitivity * self.factor)) ** (1 / self.order)
        lowest = 0.5 * self.finest
        return min(max(ratio, lowest), self.coarsest), of_cells > 0 and ratio >= lowest


def fit(
    ratios: ArrayLike, errors: ArrayLike, unsure: ArrayLike = 0.0, spread: float = 0.0
) -> PowerLaw:
    """The power law of measured errors, by least squares of the logarithms.

    What lies within twice its uncertainty says little and is left out, as long as two points stay;
    else all but the finest count, whose error is that uncertainty itself. While the coarsest point
    is the one farthest off the line, by more than a factor 1.3, it is left out as well: the power
    does not hold there yet.

    Parameters
    ----------
    ratios, errors : (k,) ; unsure : (k,) or float, uncertainty of the errors; spread : float
    """
    order = np.argsort(ratios)
    r, e = np.asarray(ratios, float)[order], np.asarray(errors, float)[order]
    doubt = np.broadcast_to(np.asarray(unsure, float), e.shape)[order]
    known = float(doubt.max())
    seen = e > 1.2 * spread
    keep = seen & (e > 2 * doubt)
    if keep.sum() < 2 and keep.any():
        keep = seen & (r > r[0])
    if keep.sum() < 2:
        # nothing but what stays anyway is seen
        level = math.sqrt(max(np.mean(e**2) - spread**2, 1e-30))
        return PowerLaw(level, 0.0, spread, 1.5, r[0], r[-1], known)
    r, e = r[keep], np.sqrt(e[keep] ** 2 - spread**2)
    while True:
        p, c = np.polyfit(np.log(r), np.log(e), 1)
        off = np.log(e) - c - p * np.log(r)
        if np.argmax(np.abs(off)) < len(r) - 1 or abs(off[-1]) < math.log(1.3) or len(r) < 4:
            break
        r, e = r[:-1], e[:-1]
    if p < FLAT:
        p, c = 0.0, np.log(e).mean()
        off = np.log(e) - c
    scatter = float(np.exp(np.sqrt(np.mean(off**2))))
    return PowerLaw(float(np.exp(c)), float(p), spread, max(scatter, 1.05), r[0], r[-1], known)


def richardson(fine: ArrayLike, coarse: ArrayLike, by: float, order: float) -> float:
    """Error of the fine value, from a coarser one: |fine - coarse|/(by^order - 1).

    fine, coarse : float, or curves (k,): then the root mean square; by : ratio of the sizes
    """
    apart = float(np.sqrt(np.mean((np.asarray(fine) - np.asarray(coarse)) ** 2)))
    return apart / (by ** max(order, 1.0) - 1)


def companion_cells(cells: int, fewest: int) -> int:
    """Number of cells of a run to compare one of `cells` with: half of them.

    Not below the `fewest` for which errors are a power yet; half as many again where these are
    nearly all.
    """
    fewer = max(round(cells / 2), fewest)
    return fewer if fewer <= 0.75 * cells else int(np.ceil(1.5 * cells))


def companion_error(apart: float, cells: float, companion: float, order: float) -> float:
    """Error of a run with `cells`, from its difference to one with `companion`, more or fewer."""
    by = max(cells, companion) / min(cells, companion)
    finer = companion > cells
    return richardson(apart, 0.0, by, order) * (by ** max(order, 1.0) if finer else 1.0)


def pareto_front(rows: Sequence[dict]) -> list[dict]:
    """Rows that no other beats in both `error` and `core_seconds`, the cheapest first."""
    best: list[dict] = []
    lowest = math.inf
    for row in sorted(rows, key=lambda row: (row["core_seconds"], row["error"])):
        if row["error"] < lowest:
            best.append(row)
            lowest = row["error"]
    return best


def cheapest(rows: Sequence[dict], error: float) -> dict | None:
    """Cheapest row within an error, or None."""
    good = [row for row in rows if row["error"] <= error]
    return min(good, key=lambda row: row["core_seconds"], default=None)
