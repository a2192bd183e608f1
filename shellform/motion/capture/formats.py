# SPDX-License-Identifier: LGPL-3.0-or-later
"""The reader of a marker file, by the ending of its name."""

from pathlib import Path

from .csv_file import read_csv
from .marker_table import named_once
from .trc_file import read_trc


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
    return named_once(readers[path.suffix.lower()](path), path)
