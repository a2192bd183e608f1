# SPDX-License-Identifier: LGPL-3.0-or-later
"""Statistics of an ensemble against made-up curves whose statistics are known.

Shares are counted in fixed-seed trials; their bars are 4 standard deviations of the binomial count.
"""

import numpy as np
import pytest
from scipy import stats

from shellform.results.ensemble import (
    Estimate,
    band,
    differ,
    estimate,
    jackknife,
    paired_difference,
    peak,
    peak_difference,
    peak_of_mean,
    root_mean_squares,
    student,
)

pytestmark = pytest.mark.serial
TIMES = np.linspace(0.0, 1.0, 51)
TRIALS = 2000


def made_up(rng, runs, scatter=0.3, height=-4.0):
    """Curves (runs, 51): a bump of a known height, with smooth noise of a known scatter.

    Noise is a sum of five waves with independent normal amplitudes, of one variance everywhere.
    """
    k = np.arange(1, 6)
    waves = np.concatenate([np.cos(np.outer(k, 6 * TIMES)), np.sin(np.outer(k, 6 * TIMES))])
    noise = rng.standard_normal((runs, 10)) @ waves / np.sqrt(5)
    return height * np.exp(-0.5 * ((TIMES - 0.4) / 0.1) ** 2) + scatter * noise


def inside(share, count=TRIALS, level=0.95):
    """Whether a counted share is that of the level."""
    return abs(share - level) < 4 * np.sqrt(level * (1 - level) / count)


def test_mean_and_band_by_hand():
    found = band([[1.0, 2.0], [3.0, 2.0], [5.0, 2.0]])
    assert found.mean == pytest.approx([3, 2]) and found.spread == pytest.approx([2, 0])
    assert found.error == pytest.approx([2 / 3**0.5, 0]) and found.runs == 3
    value, error, runs = estimate([1.0, 3.0, 5.0])
    assert (value, error, runs) == (pytest.approx(3), pytest.approx(2 / 3**0.5), 3)


def test_one_run_has_no_error():
    """Neither spread nor error, and no difference can be told."""
    found = band([[1.0, -2.0]])
    assert np.isnan(found.spread).all() and np.isnan(found.error).all()
    alone = peak_of_mean(np.array([[1.0, -2.0]]))
    assert alone.value == -2.0 and np.isnan(alone.error) and alone.runs == 1
    assert alone.interval() == (-np.inf, np.inf) and differ(alone) is None


def test_students_factor():
    for degrees in (1, 2, 7, 100):
        assert student(degrees) == pytest.approx(stats.t.ppf(0.975, degrees), rel=1e-9)


def test_jackknife_of_a_mean_is_the_standard_error():
    values = np.random.default_rng(1).standard_normal(9)
    found = jackknife(lambda some: float(some.mean()), values)
    assert found == pytest.approx(estimate(values), rel=1e-12)


def test_peak_whose_place_is_fixed():
    """Then its error is the standard error there."""
    curves = made_up(np.random.default_rng(2), 6, scatter=0.01)
    at = np.abs(curves.mean(axis=0)).argmax()
    for k in range(6):  # the same place without any one run
        assert np.abs(np.delete(curves, k, axis=0).mean(axis=0)).argmax() == at
    found = peak_of_mean(curves)
    assert found.value == curves[:, at].mean()
    assert found.error == pytest.approx(curves[:, at].std(ddof=1) / 6**0.5, rel=1e-9)


def test_peak_of_the_mean_and_mean_of_the_peaks():
    """The mean of the peaks keeps its bias however many runs; the peak of the mean loses it.

    Of a curve that is noise alone, of variance 1: single peaks are about 2 in size, that of the
    mean of n is 1/sqrt(n) of it.
    """
    rng = np.random.default_rng(3)
    sizes = {}
    for runs in (4, 64):
        curves = made_up(rng, 200 * runs, 1.0, 0.0).reshape(200, runs, -1)
        singles = np.mean([abs(peak(curve)) for curve in curves[:, 0]])
        means = np.array([abs(peak_of_mean(some).value) for some in curves])
        sizes[runs] = means.mean()
        off = singles / runs**0.5 - means.mean()
        assert abs(off) < 4 * means.std() / 200**0.5 * (1 + runs**-0.5) and singles > 1.5
    assert sizes[4] / sizes[64] == pytest.approx(4, rel=0.1)


def test_error_falls_with_the_root_of_the_runs():
    """Standard errors told, and what means of many ensembles really scatter, both 1/sqrt(n)."""
    rng, scatter = np.random.default_rng(4), 0.3
    for runs in (2, 8, 32):
        curves = made_up(rng, 400 * runs, scatter).reshape(400, runs, -1)
        bands = [band(some) for some in curves]
        variance = np.mean([found.error**2 for found in bands], axis=0)
        assert np.sqrt(variance) == pytest.approx(scatter / runs**0.5, rel=0.2)
        scattered = np.std([found.mean for found in bands], axis=0)
        assert scattered == pytest.approx(scatter / runs**0.5, rel=0.2)


@pytest.mark.parametrize("runs", [2, 3, 8])
def test_intervals_hold_what_they_promise(runs):
    """95 % of the intervals of a root mean square hold the true one."""
    rng, widths = np.random.default_rng(5), np.full(len(TIMES), 0.02)
    truth = root_mean_squares(made_up(rng, 200000), widths).mean()
    values = root_mean_squares(made_up(rng, TRIALS * runs), widths).reshape(TRIALS, runs)
    within = [low <= truth <= high for low, high in (estimate(v).interval() for v in values)]
    assert inside(np.mean(within))


@pytest.mark.parametrize("runs", [3, 8])
def test_intervals_of_peaks(runs):
    """Of a peak of the mean, whose place moves with the runs: 95 %, with 2 % for that."""
    rng = np.random.default_rng(6)
    curves = made_up(rng, TRIALS * runs, 0.1).reshape(TRIALS, runs, -1)
    intervals = [peak_of_mean(some).interval() for some in curves]
    share = np.mean([low <= -4.0 <= high for low, high in intervals])
    assert abs(share - 0.95) < 0.02 + 4 * np.sqrt(0.95 * 0.05 / TRIALS)


def test_equal_ensembles_do_not_differ():
    curves = made_up(np.random.default_rng(7), 3)
    widths = np.full(len(TIMES), 0.02)
    for found in (
        paired_difference(*[root_mean_squares(curves, widths)] * 2),
        peak_difference(curves, curves),
    ):
        assert found == Estimate(0.0, 0.0, 3) and differ(found) is False


@pytest.mark.parametrize("runs", [2, 3, 8])
def test_false_alarms(runs):
    """Two ensembles of the same cloth are told to differ in 5 % of the trials."""
    rng, widths = np.random.default_rng(8), np.full(len(TIMES), 0.02)
    one, other = made_up(rng, 2 * TRIALS * runs, 0.1).reshape(2, TRIALS, runs, -1)
    a, b = root_mean_squares(one, widths), root_mean_squares(other, widths)
    alarms = np.mean([differ(paired_difference(*pair)) for pair in zip(a, b, strict=True)])
    assert inside(1 - alarms)
    if runs > 2:
        alarms = np.mean([differ(peak_difference(*pair)) for pair in zip(one, other, strict=True)])
        assert abs(alarms - 0.05) < 0.02 + 4 * np.sqrt(0.95 * 0.05 / TRIALS)


def test_known_shift_is_found():
    """Peaks of -4 and -5 with a scatter of 0.3, 6 runs: the interval holds -1 and not 0.

    The power is that of Student's test at 1 / (0.3 sqrt(2/6)) = 5.8 standard errors: above 98 %.
    """
    rng, found = np.random.default_rng(9), []
    for _ in range(200):
        pair = made_up(rng, 6, height=-5.0), made_up(rng, 6, height=-4.0)
        found.append(peak_difference(*pair))
    assert np.mean([differ(one) for one in found]) > 0.9
    assert np.mean([one.value for one in found]) == pytest.approx(-1.0, abs=0.1)


def test_what_both_share_drops_out():
    """Runs in pairs: what changes both alike does not widen the interval of the difference."""
    rng = np.random.default_rng(10)
    shared, own = 10 * rng.standard_normal(5), 0.1 * rng.standard_normal((2, 5))
    found = paired_difference(shared + own[0] + 1.0, shared + own[1])
    assert found.value == pytest.approx(1.0, abs=0.5) and found.error < 0.3
    # the longer ensemble gives its first runs
    assert paired_difference(shared[:3], shared).runs == 3
