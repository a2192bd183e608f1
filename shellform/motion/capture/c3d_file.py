# SPDX-License-Identifier: LGPL-3.0-or-later
"""C3D files, by ezc3d (MIT licence), which is imported only when one is read.

Vicon stores angles, forces, moments and powers in the same list as places: they are told apart by
the groups POINT:ANGLES, FORCES, ... and by their names. A residual below 0 marks a gap.
"""

import re
import struct
import subprocess
import sys
from pathlib import Path

import numpy as np

from .marker_table import Raw

NO_PLACE = re.compile(r"(angles?|forces?|moments?|powers?|torques?|index)$", re.IGNORECASE)
READ = "import sys, ezc3d; ezc3d.c3d(sys.argv[1])"
PATIENCE = 60  # s
NO_PLACE_GROUPS = ("ANGLE", "FORCE", "MOMENT", "POWER", "SCALAR", "REACTION", "TORQUE")


def read_c3d(path: str | Path) -> Raw:
    """`Raw` of a C3D file: places only, NaN for gaps, unit and vertical as its parameters say.

    Raises
    ------
    ValueError
        When the file is cut off or no C3D file.
    ImportError
        When ezc3d is not installed.
    """
    try:
        import ezc3d
    except ImportError:
        raise ImportError(
            f"{path}: a C3D file is read by ezc3d, which is not installed; run `pip install "
            "ezc3d`, or export the markers as TRC or CSV"
        ) from None
    check_length(path)
    try_out(path)
    try:
        file = ezc3d.c3d(str(path))
    except (OSError, RuntimeError, ValueError, IndexError) as error:
        raise ValueError(f"{path}: ezc3d cannot read it ({error}); export it again") from None
    point = file["parameters"]["POINT"]
    tracks = np.transpose(file["data"]["points"][:3], (2, 1, 0)).astype(float)
    residuals = file["data"]["meta_points"]["residuals"]
    if residuals.shape[1:] == tracks.shape[1::-1]:
        tracks[residuals[0].T < 0] = np.nan
    labels = _strings(point, "LABELS")[: tracks.shape[1]]
    if not labels or len(tracks) < 2:
        raise ValueError(f"{path}: holds {len(labels)} points in {len(tracks)} frames, no motion")
    others = {
        name
        for key in point
        if key.rstrip("0123456789").startswith(NO_PLACE_GROUPS) and not key.endswith("UNITS")
        for name in _strings(point, key)
    }
    keep = [
        k
        for k, name in enumerate(labels)
        if name not in others and not NO_PLACE.search(name) and not name.startswith("*")
    ]
    notes = []
    if len(keep) < len(labels):
        notes.append(f"{len(labels) - len(keep)} points that are no places or unnamed left out")
    rate = float(point["RATE"]["value"][0]) if "RATE" in point else 0.0
    rate = rate if rate > 0 else float(file["header"]["points"]["frame_rate"])
    if not rate > 0:
        raise ValueError(f"{path}: the frame rate is {rate:g} Hz; set POINT:RATE")
    first = int(file["header"]["points"]["first_frame"])
    times = (first + np.arange(len(tracks))) / rate
    unit = next(iter(_strings(point, "UNITS")), "").lower() or None
    names = tuple(labels[k] for k in keep)
    return Raw(names, times, tracks[:, keep], rate, unit, _vertical(point), tuple(notes))


def check_length(path: str | Path) -> None:
    """Refuse a file shorter than its header says, before a library meets its end.

    The header's words: 2 points, 3 analog values a frame, 4 and 5 first and last frame, 7 and 8
    scale (negative: numbers of 4 bytes), 9 first block of data; blocks of 512 bytes (c3d.org).
    """
    path = Path(path)
    with path.open("rb") as file:
        head = file.read(512)
        if len(head) < 512 or head[1] != 0x50:
            raise ValueError(f"{path}: no C3D file, or cut off in its header; copy it again")
        file.seek(512 * (head[0] - 1))
        processor = (file.read(4) + bytes(4))[3]
    if processor != 84:  # other byte orders: left to the library
        return
    points, analog, first, last = struct.unpack_from("<4H", head, 2)
    (scale,) = struct.unpack_from("<f", head, 12)
    (block,) = struct.unpack_from("<H", head, 16)
    frame = (4 * points + analog) * (4 if scale < 0 else 2)
    if not (0 < first <= last < 65535) or block < 2:
        return
    told, size = 512 * (block - 1) + (last - first + 1) * frame, path.stat().st_size
    if size < told:
        raise ValueError(
            f"{path}: cut off, {size} bytes of the {told} its header tells of; copy it again"
        )


def try_out(path: str | Path) -> None:
    """Let a process of its own read the file first: the library crashes on some that are damaged.

    Raises
    ------
    ValueError
        When that process is ended by a signal, or takes longer than a minute.
    """
    try:
        code = subprocess.run(
            [sys.executable, "-c", READ, str(path)], capture_output=True, timeout=PATIENCE
        ).returncode
    except subprocess.TimeoutExpired:
        code = -1
    if code < 0:
        raise ValueError(
            f"{path}: ezc3d breaks down on it, so its parameters are damaged; export it again"
        )


def _strings(group, key):
    """The strings of KEY, KEY2, KEY3, ... in order."""
    out = []
    for k in range(1, 100):
        name = key if k == 1 else f"{key}{k}"
        if name not in group or "value" not in group[name]:
            break
        value = group[name]["value"]
        out += [str(v).strip() for v in value] if len(value) else []
    return out


def _vertical(point):
    """POINT:Y_SCREEN, the axis that is drawn upward, as "z" or "-y"; None where it is not told."""
    said = next(iter(_strings(point, "Y_SCREEN")), "").lower().lstrip("+")
    return said if said in ("x", "y", "z", "-x", "-y", "-z") else None
