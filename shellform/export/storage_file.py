# SPDX-License-Identifier: LGPL-3.0-or-later
"""OpenSim's tables, .sto and .mot: a header of a few lines, then columns parted by tabs."""

from pathlib import Path

import numpy as np

from shellform.results.files import write_atomically


def write_storage(
    path: Path, times: np.ndarray, columns: dict[str, np.ndarray], notes: str = ""
) -> None:
    """Write a table; a .mot file is one of the same kind.

    Parameters
    ----------
    path : file; times : (n,) [s]; columns : name -> (n,); angles in radians
    notes : lines that stand in the header
    """
    table = np.column_stack([times, *columns.values()])
    head = [path.stem, "version=1", f"nRows={len(table)}", f"nColumns={table.shape[1]}"]
    lines = [*head, "inDegrees=no", *notes.splitlines(), "endheader", "\t".join(["time", *columns])]
    lines += ["\t".join(f"{value:.10g}" for value in row) for row in table.tolist()]
    write_atomically(path, "\n".join(lines) + "\n")
