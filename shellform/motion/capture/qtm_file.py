# SPDX-License-Identifier: LGPL-3.0-or-later
"""TSV files of QTM (Qualisys): lines of a key and its values, then frames.

A line of column names may stand between. A row is frame and time, or none of them, and x, y, z of
each marker in mm; a gap is 0, or NULL.
"""

from pathlib import Path

import numpy as np

from .marker_table import Raw, even_times, number_of, numbers_of, table_of
from .text_tables import cells_of


def read_qtm(lines: list[str], separator: str, path: str | Path) -> Raw:
    """`Raw` of a QTM TSV file; ValueError naming line and mend where it is malformed."""
    keys: dict[str, list[str]] = {}
    top = len(lines)
    for k, line in enumerate(lines):
        cells = cells_of(line, separator)
        word = cells[0] if cells else ""
        if number_of(word) is not None and word:
            top = k
            break
        if word:
            keys[word.upper()] = cells[1:]
    names = [n for n in keys.get("MARKER_NAMES", []) if n]
    if not names:
        raise ValueError(f"{path}: no line MARKER_NAMES; export 3D data from QTM with its header")
    rate = number_of((keys.get("FREQUENCY") or [""])[0])
    if not rate or not rate > 0:
        raise ValueError(f"{path}: no FREQUENCY above 0; export 3D data from QTM with its header")
    rows, extra = [], None
    for k, line in enumerate(lines[top:], top + 1):
        cells = cells_of(line, separator)
        if not any(cells):
            continue
        while len(cells) > 3 * len(names) + 2 and not cells[-1]:
            cells = cells[:-1]
        extra = len(cells) - 3 * len(names) if extra is None else extra
        if not 0 <= extra <= 2 or len(cells) != extra + 3 * len(names):
            raise ValueError(
                f"{path}: line {k} holds {len(cells)} cells for {len(names)} markers; the file is "
                "cut off or a cell is missing"
            )
        rows.append(numbers_of(cells, path, k))
    notes, table = [], table_of(rows, path)
    said = number_of((keys.get("NO_OF_FRAMES") or [""])[0])
    if said and said != len(rows):
        notes.append(f"the header says {said:.0f} frames, the file holds {len(rows)}")
    times = np.arange(len(rows)) / rate
    if extra == 2:
        times = table[:, 1]
    elif extra == 1:  # a frame's number rises by 1
        times = table[:, 0] / (rate if (np.diff(table[:, 0]) >= 0.999).all() else 1.0)
    places = table[:, extra:].reshape(len(rows), len(names), 3)
    times, places, rate, more = even_times(times, places, rate, path)
    return Raw(tuple(names), times, places, rate, "mm", None, (*notes, *more))
