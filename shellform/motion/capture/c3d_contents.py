# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a C3D file holds, by the library that reads it: ezc3d, or c3d for files of MIPS processors.

Both are imported only when such a file is read. ezc3d crashes on some damaged files, which is tried
out in a process of its own first.
"""

import subprocess
import sys
import warnings
from pathlib import Path
from typing import NamedTuple

import numpy as np

from .c3d_header import MIPS, check_length, header_of
from .plain_path import plain_path

READ = "import sys, ezc3d; ezc3d.c3d(sys.argv[1])"
PATIENCE = 20.0  # s, and as much for every 20 MB
LISTS = 100  # LABELS, LABELS2, ... of 255 strings each


class Contents(NamedTuple):
    """Points, poses and the parameters that tell what they are.

    points : (n, m, 3), as stored; missing : (n, m) bool, residual below 0
    texts : dict, "POINT:LABELS" -> list of str, LABELS2, ... joined to it
    numbers : dict, "POINT:RATE" -> first number
    poses : (n, k, 4, 4), of ROTATION data, k = 0 without
    header_rate [Hz], as the header has it; first : number of the first frame
    """

    points: np.ndarray
    missing: np.ndarray
    texts: dict[str, list[str]]
    numbers: dict[str, float]
    poses: np.ndarray
    header_rate: float
    first: int


def contents_of(path: str | Path) -> Contents:
    """Contents of a C3D file.

    Raises
    ------
    ValueError
        When the file is cut off, damaged, or no C3D file.
    ImportError
        When the library that reads it is not installed.
    """
    header = header_of(path)
    check_length(header, path)
    if header.processor == MIPS:
        contents = _by_c3d(path, header)
    else:
        contents = _by_ezc3d(path, header)
    if header.points and len(contents.points):
        check_length(header, path, len(contents.points))
    _check_poses(contents, header, path)
    return contents


def _check_poses(contents, header, path):
    """Refuse ROTATION data that go beyond the end of the file: 17 numbers of 4 bytes a pose."""
    if contents.poses.size and (block := contents.numbers.get("ROTATION:DATA_START")):
        frames, count = contents.poses.shape[:2]
        told = 512 * (int(block) % 65536 - 1) + 68 * frames * count
        if header.size < told:
            raise ValueError(
                f"{path}: cut off, {header.size} bytes of the {told} that its rotations need; copy "
                "it again"
            )


def _by_ezc3d(path, header):
    try:
        import ezc3d
    except ImportError:
        raise ImportError(
            f"{path}: a C3D file is read by ezc3d, which is not installed; run `pip install "
            "ezc3d`, or export the markers as TRC or CSV"
        ) from None
    try_out(path)
    try:
        with plain_path(path) as plain:
            file = ezc3d.c3d(plain)
        data = file["data"]
        points = np.transpose(data["points"][:3], (2, 1, 0)).astype(float)
        residuals = data["meta_points"]["residuals"]
        missing = np.zeros(points.shape[:2], bool)
        if residuals.shape[1:] == points.shape[1::-1]:
            missing = residuals[0].T < 0
        poses = np.moveaxis(np.asarray(data["rotations"], float), (3, 2), (0, 1))
        texts, numbers = {}, {}
        for name, group in file["parameters"].items():
            for key, item in group.items():
                if key == "__METADATA__":
                    continue
                value = item["value"]
                if len(value) and isinstance(value[0], str):
                    texts[f"{name}:{key}"] = [str(v).strip() for v in value]
                elif np.size(value):
                    numbers[f"{name}:{key}"] = float(np.ravel(value)[0])
        first = int(file["header"]["points"]["first_frame"])
    except Exception as error:  # what a library makes of a damaged file is of any kind
        reason = " ".join(str(error).split()) or type(error).__name__
        raise ValueError(f"{path}: ezc3d cannot read it ({reason}); export it again") from None
    return Contents(points, missing, _joined(texts), numbers, poses, header.rate, first)


def _by_c3d(path, header):
    try:
        import c3d
    except ImportError:
        raise ImportError(
            f"{path}: a C3D file of a MIPS processor is read by c3d, which is not installed; run "
            "`pip install c3d`, or export the markers as TRC or CSV"
        ) from None
    try:
        with open(path, "rb") as handle, warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of parameters that are missing
            reader = c3d.Reader(handle)
            frames = [points.copy() for _, points, _ in reader.read_frames(copy=False)]
            texts, numbers = {}, {}
            for name, group in reader.group_items():
                for key in group.param_keys():
                    item = group.get(key)
                    if item.bytes_per_element < 0:
                        value = np.ravel(item.string_array)
                        texts[f"{name}:{key}"] = [str(v).strip() for v in value]
                    elif key == "RATE":
                        numbers[f"{name}:{key}"] = float(item.float_value)
            first = int(reader.first_frame) - 1  # ezc3d counts from 0
        table = np.array(frames, float).reshape(len(frames), -1, 5)
    except Exception as error:  # as above
        reason = " ".join(str(error).split()) or type(error).__name__
        raise ValueError(f"{path}: c3d cannot read it ({reason}); export it again") from None
    none = np.zeros((0, 0, 4, 4))
    return Contents(
        table[..., :3], table[..., 3] < 0, _joined(texts), numbers, none, header.rate, first
    )


def _joined(texts):
    """LABELS with LABELS2, LABELS3, ... behind it: a parameter holds 255 strings."""
    out = dict(texts)
    for key, values in texts.items():
        for k in range(2, LISTS):
            more = texts.get(f"{key}{k}")
            if more is None:
                break
            values = values + more
        out[key] = values
    return out


def try_out(path: str | Path) -> None:
    """Let a process of its own read the file first: the library crashes on some that are damaged.

    Raises
    ------
    ValueError
        When that process is ended by a signal, or takes too long.
    """
    patience = PATIENCE * (1 + Path(path).stat().st_size / 20e6)
    try:
        with plain_path(path) as plain:
            words = [sys.executable, "-c", READ, plain]
            code = subprocess.run(words, capture_output=True, timeout=patience).returncode
    except subprocess.TimeoutExpired:
        code = -1
    if code < 0:
        raise ValueError(
            f"{path}: ezc3d breaks down on it, so its parameters are damaged; export it again"
        )
