# SPDX-License-Identifier: LGPL-3.0-or-later
"""Marker positions from a TRC file (Motion Analysis, OpenSim).

Some lines of header, a line of labels that begins with `Frame#`, then one line a frame: number,
time [s], x, y, z of each marker; an empty cell is a gap. Headers lie: the number of markers and of
frames, the position of the tabs and the rounded times are not believed. Labels are counted, the
rate is the header's, and what differs is noted.
"""

from pathlib import Path

import numpy as np

from .marker_table import Raw, even_times, number_of, numbers_of


def read_trc(path: str | Path) -> Raw:
    """`Raw` of a TRC file; ValueError naming line and mend where it is cut off or malformed."""
    text = Path(path).read_text(encoding="utf-8", errors="replace")
    lines = text.splitlines()
    top = next((k for k, s in enumerate(lines) if s.strip().lower().startswith("frame")), None)
    if top is None:
        raise ValueError(f"{path}: no line starts with 'Frame#', so there are no marker labels")
    labels = [t for t in cells_of(lines[top]) if t][1:]
    if labels and labels[0].lower().startswith("time"):
        labels = labels[1:]
    if not labels:
        raise ValueError(f"{path}: line {top + 1} names no marker after 'Frame#' and 'Time'")
    header = _header(lines[:top])
    width = 2 + 3 * len(labels)
    rows: list[list[float]] = []
    used, ends = [], []
    for k, line in enumerate(lines[top + 1 :], top + 2):
        cells = cells_of(line)
        first = next((c for c in cells if c), "")
        if not first or (not rows and first[0] in "Xx"):
            continue  # a blank line, or X1 Y1 Z1 ...
        rows.append(_row(cells, width, path, k))
        used.append(len(cells))
        ends.append(max((j for j, c in enumerate(cells) if c), default=0))
    if len(rows) < 2:
        raise ValueError(f"{path}: {len(rows)} frames of numbers; at least two are needed")
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
    notes = []
    if said and len(rows) != said:
        notes.append(f"the header says {said:.0f} frames, the file holds {len(rows)}")
    said = header.get("nummarkers")
    if said and len(labels) != said:
        notes.append(f"the header says {said:.0f} markers, the file names {len(labels)}")
    table = np.array(rows)
    rate = header.get("datarate") or header.get("camerarate")
    times, positions, rate, more = even_times(
        table[:, 1], table[:, 2:].reshape(len(rows), -1, 3), rate, path
    )
    return Raw(tuple(labels), times, positions, rate, header.get("units"), None, (*notes, *more))


def cells_of(line: str) -> list[str]:
    """Cells of a line between tabs; between blanks where it has no tab."""
    return [c.strip() for c in (line.split("\t") if "\t" in line else line.split())]


def _header(lines):
    """Values by lower-case key; tabs may be doubled, a value may be missing."""
    for k, line in enumerate(lines[:-1]):
        keys = [c.lower() for c in cells_of(line) if c]
        if "datarate" in keys or "units" in keys:
            values = [c for c in cells_of(lines[k + 1]) if c]
            if len(values) != len(keys):  # one is missing: take them by their place
                values = cells_of(lines[k + 1])
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
