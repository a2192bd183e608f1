# SPDX-License-Identifier: LGPL-3.0-or-later
"""How many runs the mean of an ensemble needs for an error: standard error = scatter / sqrt(runs).

Torque curves of runs whose starts differ by a thousandth part scatter; so the mean curve of n runs
is off by SCATTER / sqrt(n), however small its cells. A word asks for the standard error of WANTED,
a percentage for itself.
"""

import math

from .choice import relative_error

# of single runs of a walk in relaxed cells, of the curve's root mean square: level walking and the
# stride over the obstacle, starts 0.1 % apart. The root mean square itself scatters by 1.5 %, the
# peak by 8 %.
SCATTER = 0.16
WANTED = {"draft": 0.10, "standard": 0.08, "fine": 0.06}
MOST = 16  # a smaller error asks for more runs than anyone waits for: `--runs` gives them


def runs_needed(asked: float | str) -> int:
    """Runs whose mean curve is off by no more than an error; 2 to MOST.

    Parameters
    ----------
    asked : relative error, 'N%' or a word

    Raises
    ------
    ValueError for an error that is none

    Examples
    --------
    >>> [runs_needed(asked) for asked in ("draft", "standard", "fine", "10%", "1%")]
    [3, 4, 8, 3, 16]
    """
    error = WANTED[asked] if asked in WANTED else relative_error(asked)
    return min(MOST, max(2, math.ceil((SCATTER / error) ** 2 - 1e-9)))


def error_of_mean(runs: int) -> float:
    """Standard error of the mean curve of an ensemble, over its root mean square."""
    return SCATTER / math.sqrt(runs)
