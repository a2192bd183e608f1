# SPDX-License-Identifier: LGPL-3.0-or-later
"""Marker positions from a CSV file, as a spreadsheet or a script writes it.

A line of names, then one line a frame. The first column is the time [s], then come three columns a
marker, `name_x, name_y, name_z`; a unit may follow in brackets, `name_x [mm]`. Cells are separated
by commas, semicolons or tabs; an empty cell is a gap. The rate follows from the times.
"""

import re
from pathlib import Path

import numpy as np

from .marker_table import Raw, even_times, numbers_of


def read_csv(path: str | Path) -> Raw:
    """`Raw` of a CSV file; ValueError naming line, column and mend where it is malformed."""
    try:
        text = Path(path).read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise ValueError(
            f"{path}: byte {error.start} is no text in UTF-8; export the CSV file again"
        ) from None
    lines = [s for s in text.splitlines() if s.strip()]
    if len(lines) < 3:
        raise ValueError(f"{path}: a line of names and at least two frames are needed")
    comma = max(",;\t", key=lines[0].count)
    head = [c.strip().strip('"') for c in lines[0].split(comma)]
    units = {m.group(1) for c in head[1:] if (m := re.search(r"\[(\w+)\]\s*$", c))}
    head = [re.sub(r"\s*\[\w*\]\s*$", "", c) for c in head]
    names = []
    for k in range(1, len(head), 3):
        tries = [re.fullmatch(r"(.+?)[ _.:]([xyz])", c, re.IGNORECASE) for c in head[k : k + 3]]
        found = [m for m in tries if m]
        axes = "".join(m.group(2).lower() for m in found)
        if axes != "xyz" or len({m.group(1) for m in found}) != 1:
            raise ValueError(
                f"{path}: columns {k + 1} to {k + 3} are named {', '.join(head[k : k + 3])}; name "
                "them name_x, name_y, name_z after a first column of times"
            )
        names.append(found[0].group(1))
    if not names or len(units) > 1:
        what = f"different units {', '.join(sorted(units))}" if names else "no marker"
        raise ValueError(f"{path}: the first line has {what}; write time, name_x, name_y, name_z")
    rows = []
    for k, line in enumerate(lines[1:], 2):
        cells = [c.strip() for c in line.split(comma)]
        if len(cells) != len(head):
            raise ValueError(
                f"{path}: line {k} has {len(cells)} cells, not {len(head)}; the file is cut off or "
                "a cell is missing"
            )
        rows.append(numbers_of(cells, path, k))
    table = np.array(rows)
    times, positions, rate, notes = even_times(
        table[:, 0], table[:, 1:].reshape(len(rows), -1, 3), None, path
    )
    return Raw(tuple(names), times, positions, rate, next(iter(units), None), None, tuple(notes))
