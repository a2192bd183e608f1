# SPDX-License-Identifier: LGPL-3.0-or-later
"""Object file format .off, as text: counts, points, faces of any number of corners.

Letters before OFF (ST, C, N) say what stands behind the three numbers of a point; what stands
behind a face's corners is its colour; '#' begins a comment.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from .mesh_data import MeshData, from_faces


def read_off(path: Path) -> MeshData:
    """Points and faces of a .off file.

    Raises
    ------
    ValueError : for another beginning, points in 4-D or n-D, and a file that ends too early.
    """
    lines = (line.split("#", 1)[0].split() for line in _text(path).splitlines())
    rows = [words for words in lines if words]
    if not rows or not re.fullmatch(r"(ST)?C?N?OFF", rows[0][0]):
        raise ValueError("it does not begin with OFF, or its points are not in 3-D")
    if rows[0][1:2] == ["BINARY"]:
        raise ValueError("it is binary, save it as text")
    # the counts may stand behind the word, or on the next line
    rows[0] = rows[0][1:]
    rows = rows[0 if rows[0] else 1 :]
    if not rows or len(rows[0]) < 2:
        raise ValueError("the numbers of its points and faces are missing")
    count, faces = (int(word) for word in rows[0][:2])
    if min(count, faces) < 0 or len(rows) < 1 + count + faces:
        raise ValueError(f"it ends before its {count} points and {faces} faces do")
    points = [[float(word) for word in row[:3]] for row in rows[1 : 1 + count]]
    if any(len(point) < 3 for point in points):
        raise ValueError("a point has less than three coordinates")
    corners: list[int] = []
    sizes: list[int] = []
    for number, row in enumerate(rows[1 + count : 1 + count + faces]):
        size = int(row[0])
        if size < 0 or len(row) < 1 + size:
            raise ValueError(f"face {number} has less corners than it says")
        corners += [int(word) for word in row[1 : 1 + size]]
        sizes.append(size)
    return from_faces(
        np.array(points, dtype=np.float64).reshape(-1, 3),
        np.array(corners, dtype=np.int64),
        np.array(sizes, dtype=np.int64),
    )


def _text(path: Path) -> str:
    return path.read_bytes().decode("utf-8-sig", errors="replace")
