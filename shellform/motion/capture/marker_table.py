# SPDX-License-Identifier: LGPL-3.0-or-later
"""The table that every marker file becomes, and the checks that all formats share.

A reader makes a `Raw` of labels, times and positions and interprets nothing but the layout: gaps
are NaN, units and vertical are only what the file says of them. Here are the parts it is made with:
numbers in cells, times on an even grid.
"""

from pathlib import Path
from typing import NamedTuple

import numpy as np

NO_NUMBER = {"", "nan", "na", "n/a", "null", "none", "-", "1.#qnan", "1.#ind"}
ROUNDED = 0.25  # of a frame, how far rounded times lie off their even grid


class Raw(NamedTuple):
    """What a file holds.

    names : m labels; times : (n,) [s]; positions : (n, m, 3) in its unit, NaN for gaps; rate [Hz]
    unit : as the file spells it, or None; up : "x", "-x", ... the axis it calls vertical, or None
    notes : what was found and repaired on the way
    """

    names: tuple[str, ...]
    times: np.ndarray
    positions: np.ndarray
    rate: float
    unit: str | None = None
    up: str | None = None
    notes: tuple[str, ...] = ()


def number_of(cell: str) -> float | None:
    """The number in a cell, NaN for a gap, None for anything else, infinity too."""
    try:
        number = float(cell)
    except ValueError:
        return np.nan if cell.lower() in NO_NUMBER else None
    return None if np.isinf(number) else number


def numbers_of(cells: list[str], path: str | Path, line: int) -> list[float]:
    """Numbers in the cells of a line; ValueError naming line and column of what is none."""
    out = []
    for column, cell in enumerate(cells, 1):
        number = number_of(cell)
        if number is None:
            raise ValueError(
                f"{path}: line {line}, column {column} holds {cell!r}, no number; write numbers "
                "with a point and leave a missing one empty"
            )
        out.append(number)
    return out


def table_of(rows: list[list[float]], path: str | Path) -> np.ndarray:
    """Rows of numbers as an array (n, columns); ValueError where there is none.

    One frame is a table too, as of a static trial: `recording` asks for the two of a motion.
    """
    if not rows:
        raise ValueError(f"{path}: no frame of numbers; export it again")
    return np.array(rows)


def even_times(
    times: np.ndarray, positions: np.ndarray, rate: float | None, path: str | Path
) -> tuple[np.ndarray, np.ndarray, float, list[str]]:
    """Frames on an even grid of times; frames that were left out become gaps.

    A rate from the header counts, as times are often rounded to 1 ms. Without it, times that
    rounding can have put off an even grid are taken as one. One frame alone needs no rate, and gets
    1 Hz without.
    """
    if len(times) == 1:
        return np.nan_to_num(times), positions, rate or 1.0, []
    steps = np.diff(times)
    if not np.isfinite(times).all() or not (steps >= 0).all() or times[-1] <= times[0]:
        bad = int(np.argmax(~(steps >= 0))) + 2
        raise ValueError(f"{path}: the time of frame {bad} is missing or does not rise")
    n, span = len(times), times[-1] - times[0]
    if rate and abs(span * rate - (n - 1)) < max(1.0, 0.01 * n):
        return times[0] + np.arange(n) / rate, positions, rate, []
    even = (n - 1) / span
    if not rate and np.abs((times - times[0]) * even - np.arange(n)).max() < ROUNDED:
        return times[0] + np.arange(n) / even, positions, even, []
    measured = rate or 1.0 / np.median(steps)
    count = np.rint(steps * measured)
    if (count < 1).any() or np.median(count) > 1 or abs(span * measured / count.sum() - 1) > 0.02:
        if rate:
            raise ValueError(
                f"{path}: the header's rate is {rate:.6g} Hz and the time column runs at "
                f"{1 / np.median(steps):.6g} Hz; correct the wrong one"
            )
        raise ValueError(f"{path}: the times are not evenly spaced; resample the tracks evenly")
    rate = rate or count.sum() / span  # over the whole file, rounded times do not matter
    place = np.concatenate([[0], np.cumsum(count)]).astype(int)
    length, notes = place[-1] + 1, []
    if length > n:
        if length > 10 * n:
            raise ValueError(f"{path}: the times leave out most frames; is the first one right?")
        notes.append(f"{length - n} frames that the file leaves out taken for gaps")
    out = np.full((length, *positions.shape[1:]), np.nan)
    out[place] = positions
    return times[0] + np.arange(length) / rate, out, rate, notes
