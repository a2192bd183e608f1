# SPDX-License-Identifier: LGPL-3.0-or-later
"""Marker positions from a CSV file: as Motive, Nexus and QTM export them, or as a script writes it.

The latter is a line of names, then one line a frame. The first column is the time [s], then come
three columns a marker, `name_x, name_y, name_z`; a unit may follow in brackets, `name_x [mm]`.
Cells are separated by commas, semicolons or tabs; an empty cell is a gap. The rate follows from the
times.
"""

import re
from pathlib import Path

from .marker_table import Raw, even_times, numbers_of, table_of
from .motive_file import read_motive
from .nexus_file import SECTIONS, read_nexus
from .qtm_file import read_qtm
from .text_tables import cells_of, separator_of, text_of, unended, with_points


def read_csv(path: str | Path) -> Raw:
    """`Raw` of a CSV file; ValueError naming line, column and mend where it is malformed."""
    text, notes = text_of(path)
    lines, torn = text.splitlines(), unended(text)
    while lines and not lines[-1].strip():
        lines.pop()
    while lines and not lines[0].strip():
        lines.pop(0)
    if len(lines) < 2:
        raise ValueError(f"{path}: a line of names and frames of numbers are needed")
    separator = separator_of(max(lines[:12], key=len))
    words = [cells_of(line, separator)[:1] for line in lines]
    if torn and len(lines) > 4:
        # the last number may have lost its end
        lines, words = lines[:-1], words[:-1]
        notes.append("the last line has no end and is left out")
    lines, said = _points(lines, separator)
    notes += said
    if words[0] and words[0][0].lower().startswith("format version"):
        raw = read_motive(lines, separator, path)
    elif ["Trajectories"] in words:
        raw = read_nexus(lines, separator, path)
    elif any(w in (["MARKER_NAMES"], ["NO_OF_FRAMES"]) for w in words[:20]):
        raw = read_qtm(lines, separator, path)
    elif words[0] and words[0][0] in (*SECTIONS, "Devices"):
        raise ValueError(f"{path}: no section Trajectories; export the trajectories from Nexus")
    else:
        raw = _own(lines, separator, path)
    return raw._replace(notes=(*notes, *raw.notes))


def _points(lines, separator):
    """Lines whose decimal commas have become points."""
    if separator in (",", ""):
        return lines, []
    rows, notes = with_points([line.split(separator) for line in lines], separator)
    return ([separator.join(row) for row in rows], notes) if notes else (lines, [])


def _own(lines, separator, path):
    head = [c.strip().strip('"') for c in cells_of(lines[0], separator)]
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
                "them name_x, name_y, name_z after a first column of times, or export it from "
                "Motive, Nexus or QTM"
            )
        names.append(found[0].group(1))
    if not names or len(units) > 1:
        what = f"different units {', '.join(sorted(units))}" if names else "no marker"
        raise ValueError(f"{path}: the first line has {what}; write time, name_x, name_y, name_z")
    rows = []
    for k, line in enumerate(lines[1:], 2):
        if not line.strip():
            continue
        cells = cells_of(line, separator)
        if len(cells) != len(head):
            raise ValueError(
                f"{path}: line {k} has {len(cells)} cells, not {len(head)}; the file is cut off or "
                "a cell is missing"
            )
        rows.append(numbers_of(cells, path, k))
    table = table_of(rows, path)
    times, positions, rate, notes = even_times(
        table[:, 0], table[:, 1:].reshape(len(rows), -1, 3), None, path
    )
    return Raw(tuple(names), times, positions, rate, next(iter(units), None), None, tuple(notes))
