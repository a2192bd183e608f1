# SPDX-License-Identifier: LGPL-3.0-or-later
"""Statistics of an ensemble of runs: mean, band, peak of the mean curve, differences of pairs.

Folds of cloth are chaotic: runs whose starts differ by a thousandth part in their course and agree
in their statistics. Of n runs with values y_k

    mean m = sum y_k / n,   spread s, s^2 = sum (y_k - m)^2 / (n - 1),   standard error s / sqrt(n).

A curve has these at each of its times. Its root mean square and its work are numbers of each run,
so their errors are those of n numbers. Its peak is that of the mean curve: the mean of the runs'
peaks lies above it, as each run's own scatter adds to its peak. The error of that peak is the
jackknife's (Quenouille 1956, Tukey 1958; Efron and Stein, Ann. Stat. 9, 1981), from the n peaks p_k
of the curves averaged without run k,

    e^2 = (n - 1)/n sum (p_k - mean p)^2,

which is s / sqrt(n) at the place of the peak where that place is the same in all of them. Intervals
are Student's with n - 1 degrees of freedom. One run alone has neither spread nor error: nan.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.special import stdtrit

LEVEL = 0.95  # of intervals


class Band(NamedTuple):
    """Mean of n runs with its band: spread of the runs, standard error of the mean."""

    mean: np.ndarray
    spread: np.ndarray
    error: np.ndarray
    runs: int


class Estimate(NamedTuple):
    """A number with its standard error (nan for one run) and how many runs it comes from."""

    value: float
    error: float
    runs: int

    def interval(self, level: float = LEVEL) -> tuple[float, float]:
        """Confidence interval (low, high); (-inf, inf) for one run."""
        if self.runs < 2:
            return -np.inf, np.inf
        reach = student(self.runs - 1, level) * self.error
        return self.value - reach, self.value + reach


def student(degrees: int, level: float = LEVEL) -> float:
    """Factor of the standard error in a two-sided confidence interval of Student's t."""
    return float(stdtrit(degrees, 0.5 * (1 + level)))


def band(samples: np.ndarray) -> Band:
    """Mean, spread and standard error of samples (n, ...) over the n runs."""
    samples = np.asarray(samples, float)
    runs = len(samples)
    mean = samples.mean(axis=0)
    spread = samples.std(axis=0, ddof=1) if runs > 1 else np.full(mean.shape, np.nan)
    return Band(mean, spread, spread / np.sqrt(runs), runs)


def estimate(values: np.ndarray) -> Estimate:
    """Mean of one number a run (n,), with its standard error."""
    found = band(values)
    return Estimate(float(found.mean), float(found.error), found.runs)


def peak(curve: np.ndarray) -> float:
    """Value of largest size of a curve (w,), with its sign."""
    return float(curve[np.abs(curve).argmax()])


def jackknife(statistic: Callable[[np.ndarray], float], samples: np.ndarray) -> Estimate:
    """A number that a function makes of all samples (n, ...), with its jackknife error."""
    samples = np.asarray(samples, float)
    runs = len(samples)
    if runs == 1:
        return Estimate(statistic(samples), np.nan, 1)
    parts = np.array([statistic(np.delete(samples, k, axis=0)) for k in range(runs)])
    error = np.sqrt((runs - 1) / runs * np.sum((parts - parts.mean()) ** 2))
    return Estimate(statistic(samples), float(error), runs)


def peak_of_mean(curves: np.ndarray) -> Estimate:
    """Peak of the mean of curves (n, w), with its jackknife error.

    Without any one run it is the peak of the same sign, though that of the other may be larger.
    """
    sign = np.sign(peak(np.mean(curves, axis=0)))
    return jackknife(lambda some: _signed_peak(some.mean(axis=0), sign), curves)


def _signed_peak(curve, sign):
    """Largest value of a curve in a direction."""
    return float(sign * (sign * curve).max())


def root_mean_squares(curves: np.ndarray, widths: np.ndarray) -> np.ndarray:
    """Root mean square (...) in time of curves (..., w) over windows of widths (w,)."""
    return np.sqrt(np.sum(widths * curves**2, axis=-1) / np.sum(widths))


def peak_difference(one: np.ndarray, other: np.ndarray) -> Estimate:
    """Peak of the mean of curves `one` (n, w) less that of `other` (n, v), run paired with run."""
    runs = min(len(one), len(other))
    pair = one[:runs], other[:runs]
    signs = [np.sign(peak(curves.mean(axis=0))) for curves in pair]

    def difference(chosen: np.ndarray) -> float:
        means = (curves[chosen.astype(int)].mean(axis=0) for curves in pair)
        a, b = (_signed_peak(mean, sign) for mean, sign in zip(means, signs, strict=True))
        return a - b

    return jackknife(difference, np.arange(runs))


def paired_difference(one: np.ndarray, other: np.ndarray) -> Estimate:
    """Mean of `one` less `other`, a number a run (n,), run paired with run."""
    runs = min(len(one), len(other))
    return estimate(np.asarray(one, float)[:runs] - np.asarray(other, float)[:runs])


def differ(difference: Estimate, level: float = LEVEL) -> bool | None:
    """Whether a difference is none of chance: zero outside its interval; None for one run."""
    if difference.runs < 2:
        return None
    low, high = difference.interval(level)
    return not low <= 0.0 <= high
