# SPDX-License-Identifier: LGPL-3.0-or-later
"""Which marker files are read: a table from the ending of a file's name to its reader.

A new format is one file with a function `path -> Raw` and one entry below. What a file holds is
checked by its reader; what all formats share is in marker_table.py, what labels have
beside the name of a place in subject_labels.py. Readers whose library is not
always installed import it when they are called, as c3d_contents.py does with ezc3d.
"""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from .bvh_file import read_bvh
from .c3d_file import read_c3d
from .csv_file import read_csv
from .marker_table import Raw
from .segment_map import SegmentMap
from .subject_labels import subject_labels
from .trc_file import read_trc


class Format(NamedTuple):
    """A kind of marker file: its reader and, in one sentence, what is read of it."""

    read: Callable[[Path], Raw]
    content: str


RATES = (0.5, 1e5)  # frames a second of any camera [Hz]
LONGEST = 1e7  # of a clock [s], a third of a year

FORMATS = {
    ".trc": Format(read_trc, "Motion Analysis and OpenSim: labels, rate and unit from the header."),
    ".csv": Format(read_csv, "Exports of Motive and Nexus; a script's: times, then x, y, z each."),
    ".tsv": Format(read_csv, "Exports of QTM, and what CSV files hold, between tabs."),
    ".c3d": Format(read_c3d, "Binary, by ezc3d or c3d: places, gaps, unit and vertical; poses."),
    ".bvh": Format(read_bvh, "Skeletons: joints by names, without markers."),
}


def read_table(path: str | Path, map: SegmentMap | None = None) -> Raw:
    """What a marker file holds, by the reader of its ending, with the labels of one subject.

    Parameters
    ----------
    path : the file
    map : SegmentMap that the labels are for, None: any of the shipped ones

    Raises
    ------
    ValueError
        One sentence naming file, place and mend: an ending that is not in `FORMATS`, a file that
        is missing, cut off or malformed.
    ImportError
        When a C3D file is asked for and ezc3d is not installed.
    """
    if not isinstance(path, str | Path):
        raise ValueError(f"a capture is the name of its file, not {path!r}")
    path = Path(path)
    form = FORMATS.get(path.suffix.lower())
    if form is None:
        *most, last = FORMATS
        raise ValueError(f"{path}: no marker file; {', '.join(most)} and {last} are read")
    if not path.is_file():
        raise ValueError(f"{path}: no such file")
    raw = form.read(path)
    if not RATES[0] <= raw.rate <= RATES[1] or not np.abs(raw.times).max() < LONGEST:
        raise ValueError(
            f"{path}: {raw.rate:.4g} frames a second from t = {raw.times[0]:.4g} s on are no "
            "capture; correct rate and times"
        )
    return subject_labels(raw, path, map)
