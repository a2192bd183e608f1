# SPDX-License-Identifier: LGPL-3.0-or-later
"""How many runs the mean of an ensemble needs for an error: standard error = scatter / sqrt(runs).

Torque curves of runs whose starts differ by a thousandth part scatter; so the mean curve of n runs
is off by scatter / sqrt(n), however small its cells. The scatter of single runs was measured, of
level walks and of walks over an obstacle (measured.csv, the spread of the torque curve). A word
asks for the standard error of `asked.WALK_WORDS`, a percentage for itself. Root mean square, work
and peak repeat better than the curve.
"""

import math
from pathlib import Path

from .asked import relative_error
from .measured import TABLE, power_laws

CURVE = "torque curve"
LEAST = 3  # an interval of Student's has the factor 12.7 with two runs, 4.3 with three
MOST = 16  # a smaller error asks for more runs than anyone waits for: `--runs` gives them


def curve_scatter(table: Path = TABLE) -> float:
    """Scatter of the torque curve of a single run of a walk, over its root mean square."""
    return next(iter(power_laws("walk", table).values()))[CURVE].spread


def runs_needed(asked: float | str, table: Path = TABLE) -> int:
    """Runs whose mean curve is off by no more than an error; LEAST to MOST.

    Parameters
    ----------
    asked : relative error, 'N%' or a word

    Raises
    ------
    ValueError for an error that is none

    Examples
    --------
    >>> runs_needed("90%"), runs_needed("0.1%")
    (3, 16)
    """
    error = relative_error(asked, "walk")
    return min(MOST, max(LEAST, math.ceil((curve_scatter(table) / error) ** 2 - 1e-9)))


def error_of_mean(runs: int, table: Path = TABLE) -> float:
    """Standard error of the mean curve of an ensemble, over its root mean square."""
    return curve_scatter(table) / math.sqrt(runs)
