# SPDX-License-Identifier: LGPL-3.0-or-later
"""CSV files of Motive (OptiTrack).

A first line of keys and values, then lines of what each column is: its type (Marker, Bone, ...),
its name, its identifier, its quantity (Position, Rotation), at last `Frame, Time, X, Y, Z, ...`.
Markers are taken; without any, positions of bones, which are joints.
"""

from pathlib import Path

import numpy as np

from .marker_table import Raw, even_times, number_of, numbers_of, table_of
from .text_tables import cells_of

KINDS = (("Marker",), ("Bone Marker", "Rigid Body Marker"), ("Bone",))


def read_motive(lines: list[str], separator: str, path: str | Path) -> Raw:
    """`Raw` of a Motive CSV file; ValueError naming line and mend where it is malformed."""
    first = cells_of(lines[0], separator)
    keys = {k.lower(): v for k, v in zip(first[::2], first[1::2])}
    head, top = [], None
    for k, line in enumerate(lines[1:], 1):
        cells = cells_of(line, separator)
        if cells and cells[0].lower() == "frame":
            top = k
            break
        head.append(cells)
    if top is None:
        raise ValueError(f"{path}: no line starts with 'Frame'; the file is cut off in its header")
    axes = [c.upper() for c in cells_of(lines[top], separator)]
    width = len(axes)
    head = [row + [""] * (width - len(row)) for row in head if any(row)]
    types = next((r for r in head if any(c in kinds for c in r for kinds in KINDS)), None)
    if types is None or len(head) <= head.index(types) + 1:
        raise ValueError(f"{path}: no line says which columns are markers; export markers too")
    names = head[head.index(types) + 1]
    what = next((r for r in head if "Position" in r), None)
    columns: dict[str, int] = {}
    labels: list[str] = []
    notes: list[str] = []
    for kinds in KINDS:
        for k in range(2, width - 2):
            place = what is None or what[k] == "Position"
            if types[k] in kinds and place and axes[k : k + 3] == ["X", "Y", "Z"]:
                columns.setdefault(names[k], k)
        labels = [n for n in columns if n and not n.lower().startswith("unlabeled")]
        if labels:
            break
    if len(labels) < len(columns):
        notes.append(f"{len(columns) - len(labels)} unlabeled markers left out")
    if labels and kinds == ("Bone",):
        notes.append("no markers, positions of bones: taken for joint centres")
    if not labels:
        raise ValueError(f"{path}: no column is the X of a labelled marker; label them in Motive")
    rows = []
    for k, line in enumerate(lines[top + 1 :], top + 2):
        cells = cells_of(line, separator)
        if not any(cells):
            continue
        if len(cells) != width:
            raise ValueError(
                f"{path}: line {k} has {len(cells)} cells, not {width}; the file is cut off or a "
                "cell is missing"
            )
        rows.append(numbers_of(cells, path, k))
    table = table_of(rows, path)
    said = number_of(keys.get("total exported frames", ""))
    if said and said != len(rows):
        notes.append(f"the header says {said:.0f} frames, the file holds {len(rows)}")
    places = np.stack([table[:, columns[n] : columns[n] + 3] for n in labels], axis=1)
    rate = number_of(keys.get("export frame rate", "")) or number_of(
        keys.get("capture frame rate", "")
    )
    rate = rate if rate and rate > 0 else None
    times, places, rate, more = even_times(table[:, 1], places, rate, path)
    unit = keys.get("length units", "").lower() or None
    return Raw(tuple(labels), times, places, rate, unit, None, (*notes, *more))
