# SPDX-License-Identifier: LGPL-3.0-or-later
"""Marker files as tables of numbers: TRC, CSV, C3D.

Nothing is interpreted here but the layout. Headers lie: the number of markers, the position of the
tabs and the rounded time column are not believed; labels are counted, the rate is the header's.

CSV: a line of names, then numbers. The first column is the time [s], then three columns a marker,
`name_x, name_y, name_z`; a unit may follow in brackets, `name_x [mm]`. Empty cells are gaps.
"""

import re
from pathlib import Path
from typing import NamedTuple

import numpy as np

NO_NUMBER = {"", "nan", "na", "n/a", "null", "none", "-", "1.#qnan", "1.#ind"}
ROUNDED = 0.25  # of a frame, how far rounded times lie off their even grid


class Raw(NamedTuple):
    """What a file holds: labels, times (n,) [s], positions (n, m, 3) in its unit, rate [Hz]."""

    names: tuple
    times: np.ndarray
    positions: np.ndarray
    rate: float
    unit: str | None = None
    up: str | None = None
    notes: tuple = ()


def read_table(path):
    """`Raw` of a file, by its ending.

    Raises
    ------
    ValueError
        One sentence naming file, place and mend.
    ImportError
        When a C3D file is asked for and ezc3d is not installed.
    """
    from .c3d_file import read_c3d  # it needs Raw from here

    path = Path(path)
    readers = {".trc": read_trc, ".csv": read_csv, ".c3d": read_c3d}
    if path.suffix.lower() not in readers:
        raise ValueError(f"{path}: no marker file; .trc, .csv and .c3d are read")
    if not path.is_file():
        raise ValueError(f"{path}: no such file")
    return _named_once(readers[path.suffix.lower()](path), path)


def read_trc(path):
    """`Raw` of a TRC file (Motion Analysis, OpenSim)."""
    text = Path(path).read_text(encoding="utf-8", errors="replace")
    lines = text.splitlines()
    top = next((k for k, s in enumerate(lines) if s.strip().lower().startswith("frame")), None)
    if top is None:
        raise ValueError(f"{path}: no line starts with 'Frame#', so there are no marker labels")
    labels = [t for t in _cells(lines[top]) if t][1:]
    if labels and labels[0].lower().startswith("time"):
        labels = labels[1:]
    if not labels:
        raise ValueError(f"{path}: line {top + 1} names no marker after 'Frame#' and 'Time'")
    header = _trc_header(lines[:top])
    width = 2 + 3 * len(labels)
    rows, used, ends = [], [], []
    for k, line in enumerate(lines[top + 1 :], top + 2):
        cells = _cells(line)
        first = next((c for c in cells if c), "")
        if not first or (not rows and first[0] in "Xx"):
            continue  # a blank line, or X1 Y1 Z1 ...
        rows.append(_trc_row(cells, width, path, k))
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
    times, positions, rate, more = _even(
        table[:, 1], table[:, 2:].reshape(len(rows), -1, 3), rate, path
    )
    return Raw(tuple(labels), times, positions, rate, header.get("units"), None, (*notes, *more))


def _cells(line):
    return [c.strip() for c in (line.split("\t") if "\t" in line else line.split())]


def _trc_header(lines):
    """Values by lower-case key; tabs may be doubled, a value may be missing."""
    for k, line in enumerate(lines[:-1]):
        keys = [c.lower() for c in _cells(line) if c]
        if "datarate" in keys or "units" in keys:
            values = [c for c in _cells(lines[k + 1]) if c]
            if len(values) != len(keys):  # one is missing: take them by their place
                values = _cells(lines[k + 1])
            found = dict(zip(keys, values))
            out = {"units": found.get("units") or None}
            for key in ("datarate", "camerarate", "numframes", "nummarkers"):
                number = _number(found.get(key, ""))
                if number is not None and number > 0:
                    out[key] = number
            return out
    return {}


def _trc_row(cells, width, path, line):
    while len(cells) > width and not cells[-1]:
        cells = cells[:-1]
    if len(cells) > width:  # doubled tabs; without blanks it is clear what is meant
        cells = [c for c in cells if c]
    if len(cells) > width:
        raise ValueError(
            f"{path}: line {line} holds {len(cells)} numbers for {(width - 2) // 3} marker labels; "
            "name every marker once in the line 'Frame#'"
        )
    return _numbers(cells + [""] * (width - len(cells)), path, line)


def _number(cell):
    """The number in a cell, NaN for a gap, None for anything else, infinity too."""
    try:
        number = float(cell)
    except ValueError:
        return np.nan if cell.lower() in NO_NUMBER else None
    return None if np.isinf(number) else number


def _numbers(cells, path, line):
    out = [_number(c) for c in cells]
    if None in out:
        k = out.index(None)
        raise ValueError(
            f"{path}: line {line}, column {k + 1} holds {cells[k]!r}, no number; write numbers "
            "with a point and leave a missing one empty"
        )
    return out


def read_csv(path):
    """`Raw` of a CSV file, laid out as the module says."""
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
        found = [re.fullmatch(r"(.+?)[ _.:]([xyz])", c, re.IGNORECASE) for c in head[k : k + 3]]
        said = "".join(m.group(2).lower() for m in found if m)
        if said != "xyz" or len({m.group(1) for m in found}) != 1:
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
        rows.append(_numbers(cells, path, k))
    table = np.array(rows)
    times, positions, rate, notes = _even(
        table[:, 0], table[:, 1:].reshape(len(rows), -1, 3), None, path
    )
    return Raw(tuple(names), times, positions, rate, next(iter(units), None), None, tuple(notes))


def _even(times, positions, rate, path):
    """Frames on an even grid of times; frames that were left out become gaps.

    A rate from the header counts, as times are often rounded to 1 ms. Without it, times that
    rounding can have put off an even grid are taken as one.
    """
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


def _named_once(raw, path):
    """Labels without prefix, each once; of two the one that holds numbers."""
    short = [name.split(":")[-1].strip() for name in raw.names]
    notes = list(raw.notes)
    prefixes = sorted({n.split(":")[0].strip() for n in raw.names if ":" in n})
    if prefixes:
        notes.append(f"prefix {', '.join(prefixes)} taken off the labels")
    full = np.isfinite(raw.positions).any(axis=(0, 2))
    keep = []
    for k, name in enumerate(short):
        twins = [j for j, other in enumerate(short) if other == name]
        holding = [j for j in twins if full[j]]
        if len(holding) > 1:
            raise ValueError(
                f"{path}: two markers are called '{name}' ({', '.join(raw.names[j] for j in twins)}"
                "); export one subject, or rename one"
            )
        if k == (holding or twins)[0]:
            keep.append(k)
    return raw._replace(
        names=tuple(short[k] for k in keep), positions=raw.positions[:, keep], notes=tuple(notes)
    )
