# SPDX-License-Identifier: LGPL-3.0-or-later
"""Table files of fabric tests: names of keys in the first line, numbers below, commas between.

Columns may be of different length: empty cells end the shorter ones.
"""

from pathlib import Path

from .laminate import FabricError


def columns(path: Path, where: str) -> dict[str, list[float]]:
    """Numbers by name of the column; `where` begins the message of a file that cannot be read.

    FabricError naming file and line where a cell is no number, or a line has more or fewer cells.
    """
    try:
        lines = [line for line in path.read_text(encoding="utf-8-sig").splitlines() if line.strip()]
    except (OSError, UnicodeDecodeError) as error:
        raise FabricError(f"{where}: file = {str(path)!r} cannot be read: {error}.") from None
    names = [name.strip() for name in lines[0].split(",")] if lines else []
    columns: dict[str, list[float]] = {name: [] for name in names}
    for number, line in enumerate(lines[1:], start=2):
        cells = [cell.strip() for cell in line.split(",")]
        if len(cells) != len(names):
            raise FabricError(
                f"{path} line {number}: {len(cells)} cells, the first line has {len(names)}."
            )
        for name, cell in zip(names, cells, strict=True):
            if cell:
                try:
                    columns[name].append(float(cell))
                except ValueError:
                    raise FabricError(f"{path} line {number}: {cell!r} is no number.") from None
    return columns
