# SPDX-License-Identifier: LGPL-3.0-or-later
"""CSV and text files of Nexus (Vicon), section Trajectories.

The word Trajectories, the rate, a line of names over every third column, `Frame, Sub Frame, X, Y,
Z, ...`, a line of units, the frames, an empty line. Other sections (Devices, Model Outputs, ...)
may stand before and after; of Model Outputs the points are taken, as Plug-in Gait's joints.
"""

from pathlib import Path

import numpy as np

from .marker_table import Raw, even_times, number_of, numbers_of, table_of
from .text_tables import cells_of

SECTIONS = ("Trajectories", "Model Outputs")


def read_nexus(lines: list[str], separator: str, path: str | Path) -> Raw:
    """`Raw` of a Nexus CSV file; ValueError naming line and mend where it is malformed."""
    found = {}
    for k, line in enumerate(lines):
        word = cells_of(line, separator)[:1]
        if word and word[0] in SECTIONS and word[0] not in found:
            found[word[0]] = _section(lines, k, separator, path)
    main = found["Trajectories"]
    names, numbers, places, rate, unit = main
    notes = _cut_short(lines, separator, numbers)
    model = found.get("Model Outputs")
    if model is not None and model[0]:
        if model[3] == rate and np.array_equal(model[1], numbers) and model[4] == unit:
            keep = [k for k, n in enumerate(model[0]) if n not in names]
            names = names + [model[0][k] for k in keep]
            places = np.concatenate([places, model[2][:, keep]], axis=1)
        else:
            notes.append("section Model Outputs has other frames and is left out")
    if not names:
        raise ValueError(f"{path}: section Trajectories names no marker over columns X, Y, Z")
    times, places, rate, more = even_times(numbers / rate, places, rate, path)
    return Raw(tuple(names), times, places, rate, unit, None, (*notes, *more))


def _cut_short(lines, separator, numbers):
    """A note where devices go on beyond the trajectories: the format has no number of frames."""
    words = [line.split(separator or None, 1)[:1] for line in lines]
    if ["Devices"] not in words:
        return []
    frames = [number_of(w[0]) if w else None for w in words[words.index(["Devices"]) + 5 :]]
    end = next((k for k, frame in enumerate(frames) if frame is None or np.isnan(frame)), None)
    last = max(frames[:end], default=0.0)
    if last <= numbers[-1]:
        return []
    return [
        f"the trajectories end at frame {numbers[-1]:.0f}, the devices at {last:.0f}: the file may "
        "be cut off"
    ]


def _section(lines, top, separator, path):
    """Names, numbers of the frames (n,), places (n, m, 3), rate and unit of a section."""
    cells = [cells_of(line, separator) for line in lines[top : top + 5]]
    rate = number_of(cells[1][0]) if len(cells) == 5 and cells[1] else None
    if not rate or not rate > 0 or cells[3][:1] != ["Frame"]:
        raise ValueError(
            f"{path}: line {top + 1}, section {cells[0][0]}: the rate, names, 'Frame' and units "
            "should follow, a line each; export it again"
        )
    axes, width = [c.upper() for c in cells[3]], len(cells[3])
    while width > 2 and not axes[width - 1]:
        width -= 1
    head, units = (row + [""] * (width - len(row)) for row in (cells[2], cells[4]))
    use = [
        k
        for k in range(2, width - 2)
        if head[k] and axes[k : k + 3] == ["X", "Y", "Z"] and units[k].lower() in _LENGTHS
    ]
    said = {units[k].lower() for k in use}
    if len(said) > 1:
        raise ValueError(f"{path}: line {top + 5} has different units {', '.join(sorted(said))}")
    rows = []
    for k, line in enumerate(lines[top + 5 :], top + 6):
        row = cells_of(line, separator)
        if not any(row):
            break
        if len(row) < width and k == len(lines):
            raise ValueError(
                f"{path}: line {k} has {len(row)} cells, not {width}; the file is cut off or a "
                "cell is missing"
            )
        row = row[:width] + [""] * (width - len(row))
        rows.append(numbers_of(row, path, k))
    table = table_of(rows, path)
    places = np.stack([table[:, k : k + 3] for k in use], axis=1) if use else np.zeros((0, 0, 3))
    return [head[k] for k in use], table[:, 0], places, rate, next(iter(said), None)


_LENGTHS = ("mm", "cm", "m")
