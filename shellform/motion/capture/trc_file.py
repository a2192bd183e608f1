# SPDX-License-Identifier: LGPL-3.0-or-later
"""Marker positions from a TRC file (Motion Analysis, OpenSim).

Some lines of header, a line of labels that begins with `Frame#`, then one line a frame: number,
time [s], x, y, z of each marker; an empty cell is a gap. Headers lie: the number of markers and of
frames, the position of the tabs and the rounded times are not believed. Labels are counted, the
rate is the header's, and what differs is noted. Any encoding, tabs, semicolons, commas or blanks.
"""

from pathlib import Path

from .marker_table import Raw, even_times, number_of, numbers_of, table_of
from .text_tables import cells_of, separator_of, text_of, unended, with_points


def read_trc(path: str | Path) -> Raw:
    """`Raw` of a TRC file; ValueError naming line and mend where it is cut off or malformed."""
    text, told = text_of(path)
    lines = text.splitlines()
    top = next(
        (k for k, s in enumerate(lines) if s.strip(' "\t').lower().startswith("frame")), None
    )
    if top is None:
        raise ValueError(f"{path}: no line starts with 'Frame#', so there are no marker labels")
    separator = separator_of(lines[top])
    if separator != "\t":
        told.append(f"cells separated by {_WORDS[separator]}, not by tabs")
    labels = [t for t in _cells(lines[top], separator) if t][1:]
    if labels and labels[0].lower().startswith("time"):
        labels = labels[1:]
    if not labels:
        raise ValueError(f"{path}: line {top + 1} names no marker after 'Frame#' and 'Time'")
    header = _header(lines[:top], separator)
    width = 2 + 3 * len(labels)
    rows: list[list[float]] = []
    used, ends = [], []
    table, said = with_points([_cells(line, separator) for line in lines[top + 1 :]], separator)
    told += said
    for k, cells in enumerate(table, top + 2):
        first = next((c for c in cells if c), "")
        if not first or (not rows and first[0] in "Xx"):
            continue  # a blank line, or X1 Y1 Z1 ...
        rows.append(_row(cells, width, path, k))
        used.append(len(cells))
        ends.append(max((j for j, c in enumerate(cells) if c), default=0))
    numbers = table_of(rows, path)
    said, whole = header.get("numframes"), max(set(used), key=used.count)
    torn = [k for k in range(len(rows)) if used[k] < whole and (ends[k] - 1) % 3]
    cut = not text.endswith("\n") and (used[-1] < whole or (said and len(rows) < said))
    if torn or cut:
        k = torn[0] if torn else len(rows) - 1
        of = f" of {said:.0f}" if said else ""
        raise ValueError(
            f"{path}: cut off in frame {k + 1}{of}; copy it again, or delete this line and correct "
            "NumFrames"
        )
    notes = told
    if not said and len(rows) > 1 and unended(text):
        rows.pop()
        numbers = numbers[:-1]
        notes.append("the last line has no end and is left out")
    if said and len(rows) != said:
        notes.append(f"the header says {said:.0f} frames, the file holds {len(rows)}")
    said = header.get("nummarkers")
    if said and len(labels) != said:
        notes.append(f"the header says {said:.0f} markers, the file names {len(labels)}")
    rate = header.get("datarate") or header.get("camerarate")
    times, positions, rate, more = even_times(
        numbers[:, 1], numbers[:, 2:].reshape(len(rows), -1, 3), rate, path
    )
    return Raw(tuple(labels), times, positions, rate, header.get("units"), None, (*notes, *more))


def _cells(line, separator):
    """Cells of a line; between blanks where it lacks the separator of the others."""
    return cells_of(line, separator if separator in line else "")


_WORDS = {";": "semicolons", ",": "commas", "": "blanks", "\t": "tabs"}


def _header(lines, separator):
    """Values by lower-case key; tabs may be doubled, a value may be missing."""
    for k, line in enumerate(lines[:-1]):
        keys = [c.lower() for c in _cells(line, separator) if c]
        if "datarate" in keys or "units" in keys:
            values = [c for c in _cells(lines[k + 1], separator) if c]
            if len(values) != len(keys):  # one is missing: take them by their place
                values = _cells(lines[k + 1], separator)
            found = dict(zip(keys, values))
            out = {"units": found.get("units") or None}
            for key in ("datarate", "camerarate", "numframes", "nummarkers"):
                number = number_of(found.get(key, ""))
                if number is not None and number > 0:
                    out[key] = number
            return out
    return {}


def _row(cells, width, path, line):
    while len(cells) > width and not cells[-1]:
        cells = cells[:-1]
    if len(cells) > width:  # doubled tabs; without blanks it is clear what is meant
        cells = [c for c in cells if c]
    if len(cells) > width:
        raise ValueError(
            f"{path}: line {line} holds {len(cells)} numbers for {(width - 2) // 3} marker labels; "
            "name every marker once in the line 'Frame#'"
        )
    return numbers_of(cells + [""] * (width - len(cells)), path, line)
