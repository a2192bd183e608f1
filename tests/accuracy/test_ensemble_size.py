# SPDX-License-Identifier: LGPL-3.0-or-later
"""How many runs an error needs."""

import pytest

from shellform.accuracy.ensemble_size import MOST, WANTED, error_of_mean, runs_needed

pytestmark = pytest.mark.serial


@pytest.mark.parametrize("asked", [*WANTED, "12%", "8%", 0.05])
def test_runs_are_enough_and_no_more(asked):
    """The error of their mean is within what is asked; with one run less it is not, or is two."""
    wanted = WANTED.get(asked) or (asked if isinstance(asked, float) else float(asked[:-1]) / 100)
    runs = runs_needed(asked)
    assert error_of_mean(runs) <= wanted
    assert runs == 2 or error_of_mean(runs - 1) > wanted


def test_ends():
    """No band without two runs; nobody waits for hundreds."""
    assert runs_needed("90%") == 2 and runs_needed("0.1%") == MOST
    with pytest.raises(ValueError, match="draft, standard, fine or a percentage"):
        runs_needed("quick")
