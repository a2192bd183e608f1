# SPDX-License-Identifier: LGPL-3.0-or-later
"""Error as a power of the size of a cell: fitted, inverted, extrapolated."""

import numpy as np
import pytest

from shellform.accuracy.convergence import (
    PowerLaw,
    cheapest,
    companion_cells,
    companion_error,
    fit,
    pareto_front,
    richardson,
)

pytestmark = pytest.mark.serial

RATIOS = np.array([0.1, 0.2, 0.4, 0.8])


@pytest.mark.parametrize("order", [1.0, 2.0, 5.7])
def test_fit_recovers_a_law(order):
    """Exact powers, with a spread beneath, give their factor and order back."""
    for spread in (0.0, 1e-3):
        law = fit(RATIOS, np.hypot(0.3 * RATIOS**order, spread), spread=spread)
        if spread and order > 2:
            continue  # all but one of the points lie within the spread
        assert law.order == pytest.approx(order, rel=1e-6)
        assert law.factor == pytest.approx(0.3, rel=1e-6)
        assert law.error(0.3) == pytest.approx(np.hypot(0.3 * 0.3**order, spread), rel=1e-6)


def test_fit_leaves_out_what_says_nothing():
    """Points within their uncertainty, and coarse ones above the power, do not bend the law."""
    errors = 0.3 * RATIOS**2
    assert fit(RATIOS, errors + [0.01, 0, 0, 0], [0.008, 0, 0, 0]).order == pytest.approx(2.0)
    law = fit([*RATIOS, 1.6], [*errors, 10 * 0.3 * 1.6**2])
    assert law.order == pytest.approx(2.0) and law.coarsest == 0.8
    # one point well above what is known: those within it count, but for the finest
    law = fit(RATIOS, 0.3 * RATIOS**2, 0.03)
    assert law.order == pytest.approx(2.0) and law.factor == pytest.approx(0.3)
    # scattered points show no order, and none is told
    flat = fit(RATIOS, [0.1, 0.12, 0.09, 0.1], spread=0.05)
    assert flat.order == 0.0
    assert flat.ratio(0.05) == (0.1, False) and flat.ratio(0.2) == (0.8, True)


def test_a_law_is_inverted():
    law = PowerLaw(0.3, 2.0, scatter=1.0, finest=0.01, coarsest=10.0)
    for error in (0.1, 0.01, 0.001):
        ratio, kept = law.ratio(error, sensitivity=2.0, own=0.3 * error)
        assert kept and law.error(ratio, 2.0, 0.3 * error) == pytest.approx(error, rel=1e-12)
    spread = PowerLaw(0.3, 2.0, spread=0.05, finest=0.01, coarsest=10.0)
    ratio, kept = spread.ratio(0.03)
    assert not kept and spread.error(ratio) == pytest.approx(0.05 * np.sqrt(2))


def test_a_floor_stays():
    """What the reference is known to is left by any cells and any runs."""
    law = PowerLaw(0.3, 2.0, spread=0.02, finest=0.01, coarsest=10.0, floor=0.03)
    assert law.error(1e-9) == pytest.approx(np.hypot(0.02, 0.03))
    assert law.of_runs(10**8).error(1e-9) == pytest.approx(0.03, rel=1e-6)
    ratio, kept = law.ratio(0.05)
    assert kept and law.error(ratio) == pytest.approx(0.05)
    assert not law.of_runs(10**8).ratio(0.03)[1]


def test_richardson_is_exact_for_a_power():
    value = lambda h: 3.0 + 0.2 * h**2  # noqa: E731
    assert richardson(value(0.1), value(0.2), 2.0, 2.0) == pytest.approx(0.2 * 0.01, rel=1e-9)


@pytest.mark.parametrize(("cells", "other"), [(40, 20), (19, 12), (14, 21)])
def test_a_companion_has_cells_for_which_the_power_holds(cells, other):
    """More cells or fewer: a power gives its error back."""
    assert companion_cells(cells, 12) == other
    error = lambda n: 0.2 * n**-1.6  # noqa: E731
    assert companion_error(error(cells) - error(other), cells, other, 1.6) == pytest.approx(
        error(cells)
    )


def test_front_and_cheapest():
    rows = [
        {"core_seconds": s, "error": e} for s, e in [(4, 1), (1, 8), (2, 9), (3, 2), (5, 2), (3, 4)]
    ]
    assert [(r["core_seconds"], r["error"]) for r in pareto_front(rows)] == [(1, 8), (3, 2), (4, 1)]
    assert cheapest(rows, 2)["core_seconds"] == 3 and cheapest(rows, 0.5) is None
