# SPDX-License-Identifier: LGPL-3.0-or-later
"""How many runs an error needs."""

import math

import pytest

from demos.studies.accuracy.run import table_text
from shellform.accuracy import measured
from shellform.accuracy.asked import WALK_WORDS, relative_error
from shellform.accuracy.ensemble_size import LEAST, MOST, curve_scatter, error_of_mean, runs_needed

pytestmark = pytest.mark.serial


@pytest.mark.parametrize("asked", [*WALK_WORDS, "12%", "8%", 0.05])
def test_runs_are_enough_and_no_more(asked):
    """The error of their mean is within what is asked; with one less not, or they are least."""
    wanted, runs = relative_error(asked, "walk"), runs_needed(asked)
    assert runs == MOST or error_of_mean(runs) <= wanted
    assert runs == LEAST or error_of_mean(runs - 1) > wanted


def test_ends():
    """No band without some runs; nobody waits for hundreds."""
    assert runs_needed("90%") == LEAST and runs_needed("0.1%") == MOST
    with pytest.raises(ValueError, match="draft, standard, fine or a percentage"):
        runs_needed("quick")


@pytest.mark.parametrize("scatter", [0.05, 0.2, 0.3])
def test_runs_go_with_the_scatter_measured(scatter, tmp_path):
    """Four times the runs for twice the scatter, as the table has it."""
    row = {"case": "walk", "family": "quads", "quantity": "torque curve"}
    rows = [
        row | {"kind": "mesh", "ratio": 1.0, "error": 1.0, "uncertainty": 0.0},
        row | {"kind": "mesh", "ratio": 2.0, "error": 4.0, "uncertainty": 0.0},
        row | {"kind": "spread", "error": scatter},
    ]
    table = tmp_path / "table.csv"
    table.write_text(table_text(rows, measured.COLUMNS))
    assert curve_scatter(table) == scatter
    assert error_of_mean(4, table) == pytest.approx(scatter / 2)
    assert runs_needed("10%", table) == max(LEAST, math.ceil((scatter / 0.1) ** 2 - 1e-9))
