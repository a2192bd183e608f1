# SPDX-License-Identifier: LGPL-3.0-or-later
"""Wavefront .obj files: vertices, faces of any size, groups.

Indices may count from the end (negative), a line may go on after a backslash, and a '#' begins a
comment wherever it stands. Texture coordinates, normals, colours and materials are passed over.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from .mesh_data import MeshData, from_faces


def read_obj(path: Path) -> MeshData:
    """Points, faces and groups of a .obj file; its objects count as groups if it has no groups.

    Raises
    ------
    ValueError : naming the line that cannot be read.
    """
    text = path.read_bytes().decode("utf-8-sig", errors="replace")
    points: list[list[float]] = []
    corners: list[int] = []
    sizes: list[int] = []
    members: dict[str, dict[str, list[int]]] = {"g": {}, "o": {}}
    current: dict[str, list[str]] = {"g": [], "o": []}
    for number, line in _lines(text):
        words = line.split()
        if not words:
            continue
        mark = words[0]
        try:
            if mark == "v":
                if len(words) < 4:
                    raise ValueError(f"a vertex of {len(words) - 1} coordinates")
                points.append([float(word) for word in words[1:4]])
            elif mark == "f":
                face = [_index(word, len(points)) for word in words[1:]]
                for kind, titles in current.items():
                    for title in titles:
                        members[kind].setdefault(title, []).append(len(sizes))
                corners += face
                sizes.append(len(face))
            elif mark == "g":
                # a face may be in several groups at once
                current["g"] = [word for word in words[1:] if word != "default"]
            elif mark == "o":
                current["o"] = [" ".join(words[1:])] if words[1:] else []
        except ValueError as error:
            raise ValueError(f"line {number}: {error}") from None
    groups = {name: np.array(faces) for name, faces in (members["g"] or members["o"]).items()}
    return from_faces(
        np.array(points, dtype=np.float64).reshape(-1, 3),
        np.array(corners, dtype=np.int64),
        np.array(sizes, dtype=np.int64),
        groups,
    )


def _lines(text):
    """Numbered lines without comments, those that a backslash continues joined to one."""
    held, first = "", 0
    for number, line in enumerate(text.splitlines(), start=1):
        line = line.split("#", 1)[0].rstrip()
        first = first or number
        if line.endswith("\\"):
            held += line[:-1] + " "
            continue
        yield first, held + line
        held, first = "", 0
    if held:
        yield first, held


def _index(word, count):
    """Place of a vertex, from 0, of a corner such as '7', '7/1/3' or '-2//5'."""
    index = int(word.split("/", 1)[0])
    if index == 0:
        raise ValueError("a face names vertex 0, and vertices count from 1")
    return index - 1 if index > 0 else count + index
