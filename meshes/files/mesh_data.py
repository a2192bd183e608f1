# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a reader hands over: points, faces by kind, groups, as meshio arranges them.

Formats of drawing programs (.obj, .ply, .stl, .glb) are read here rather than by a library: those
at hand either refuse valid files or cut all quads into triangles, which are the stiffer cells.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True)
class Block:
    """Faces with equally many corners: data (m, k) point indices; type as meshio calls it."""

    type: str
    data: np.ndarray


@dataclass(frozen=True)
class MeshData:
    """Contents of a mesh file, with the attributes of meshio's mesh that are used.

    points : (n, 3); cells : blocks of faces; point_data : {name: (n, ...)};
    cell_sets : {group: for each block the rows in it}; notes : what the reader chose
    """

    points: np.ndarray
    cells: list[Block]
    point_data: dict = field(default_factory=dict)
    cell_sets: dict = field(default_factory=dict)
    cell_data: dict = field(default_factory=dict)
    field_data: dict = field(default_factory=dict)
    notes: tuple[str, ...] = ()


def kind_of(corners: int) -> str:
    """meshio's name of a face with so many corners."""
    return {3: "triangle", 4: "quad"}.get(corners, f"polygon{corners}")


def from_faces(
    points: np.ndarray,
    corners: np.ndarray,
    sizes: np.ndarray,
    groups: Mapping[str, np.ndarray] | None = None,
    point_data: dict | None = None,
    notes: tuple[str, ...] = (),
) -> MeshData:
    """Mesh data of faces of any size.

    Parameters
    ----------
    points : (n, 3).
    corners : (sum of sizes,) point indices, face after face.
    sizes : (m,) corners of each face.
    groups : {name: numbers of faces}.
    """
    starts = np.cumsum(sizes) - sizes
    blocks: list[Block] = []
    sets: dict[str, list[np.ndarray]] = {name: [] for name in groups or {}}
    for size in np.unique(sizes[sizes > 0]).tolist():
        rows = np.flatnonzero(sizes == size)
        blocks.append(Block(kind_of(size), corners[starts[rows][:, None] + np.arange(size)]))
        for name, faces in (groups or {}).items():
            sets[name].append(np.flatnonzero(np.isin(rows, faces)))
    sets = {name: rows for name, rows in sets.items() if sum(map(len, rows))}
    return MeshData(points, blocks, point_data or {}, sets, notes=notes)
