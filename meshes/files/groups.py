"""Named edges and panels as mesh files know them: physical groups, cell sets and cell data.

Cells in a file lie in blocks; ``origins`` (m, 2) says for each cell of the surface which block and
which row of it the cell was.
"""
# SPDX-License-Identifier: LGPL-3.0-or-later

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING

import numpy as np

from meshes.subdivide import halve
from meshes.surface import Surface
from meshes.topology import directed_edges, edge_keys
from meshes.validity import MeshError

if TYPE_CHECKING:
    import meshio

_LINES = ("line", "line3")


def read_groups(
    mesh: meshio.Mesh, origins: np.ndarray, blocks: list[np.ndarray], name: str
) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray], np.ndarray | None]:
    """Named edges, panels and warp directions of a meshio mesh.

    Parameters
    ----------
    mesh : meshio mesh.
    origins : (m, 2) block and row of every surface cell.
    blocks : the surface cells by kind, in the order of ``origins``.
    name : of the file, for messages.

    Returns
    -------
    edges {name: (k, 2 | 3)}, panels {name: cell indices}, warp None or (m, 3).
    """
    edges, panels = {}, {}
    known = np.concatenate([directed_edges(block) for block in blocks])
    for label, masks in _masks(mesh).items():
        segments = [
            np.asarray(mesh.cells[number].data, dtype=np.int64)[mask, :2]
            for number, mask in masks.items()
            if mesh.cells[number].type in _LINES and mask.any()
        ]
        if segments:
            edges[label] = _on_sides(np.concatenate(segments), known, label, name)
        inside = np.zeros(len(origins), dtype=bool)
        for number, mask in masks.items():
            rows = np.flatnonzero(origins[:, 0] == number)
            inside[rows] = mask[origins[rows, 1]]
        if inside.any():
            panels[label] = np.flatnonzero(inside)
    warp = None
    if "warp" in mesh.cell_data:
        data = mesh.cell_data["warp"]
        warp = np.array([data[block][row] for block, row in origins.tolist()])
    return {label: edge for label, edge in edges.items() if len(edge)}, panels, warp


def _on_sides(segments, known, label, name):
    """The segments that are sides of cells, with middle points where the cells have them."""
    size = 1 + int(max(segments.max(), known[:, :2].max()))
    on_a_side = np.isin(edge_keys(segments, size), edge_keys(known, size))
    if not on_a_side.all():
        warnings.warn(
            f"{name}: {int((~on_a_side).sum())} segments of '{label}' lie along no side of a cell "
            "and are left out.",
            stacklevel=5,
        )
    segments = segments[on_a_side]
    if known.shape[1] == 3 and len(segments):
        return halve(segments, known, known[:, 2], size)[:, [0, 2, 1]]
    return segments


def _masks(mesh):
    """Members of every named group: {name: {block number: mask over its rows}}."""
    groups = {}

    def join(label, number, mask):
        members = groups.setdefault(label, {})
        members[number] = members[number] | mask if number in members else mask

    for key, data in mesh.cell_data.items():
        if key.startswith(("edge:", "panel:")):
            kind, label = key.split(":", 1)
            for number, values in enumerate(data):
                if (mesh.cells[number].type in _LINES) == (kind == "edge"):
                    join(label, number, np.asarray(values).reshape(-1) == 1)
    titles = {
        (int(value[0]), int(value[1])): label
        for label, value in mesh.field_data.items()
        if np.size(value) == 2
    }
    for number, tags in enumerate(mesh.cell_data.get("gmsh:physical", [])):
        line = mesh.cells[number].type in _LINES
        # Tag 0 means that a cell belongs to no group.
        for tag in np.setdiff1d(tags, 0).tolist():
            title = titles.get((tag, 1 if line else 2), f"{'edge' if line else 'panel'}_{tag}")
            join(title, number, np.asarray(tags) == tag)
    for label, members in mesh.cell_sets.items():
        if label.startswith("gmsh:"):
            continue
        for number, rows in enumerate(members):
            if rows is not None and len(rows):
                mask = np.zeros(len(mesh.cells[number].data), dtype=bool)
                mask[np.asarray(rows, dtype=np.int64)] = True
                join(label, number, mask)
    return groups


def drop_repeats(
    blocks: list[np.ndarray], panels: dict[str, np.ndarray], warp: np.ndarray | None
) -> tuple[list[np.ndarray], dict[str, np.ndarray], np.ndarray | None]:
    """Cells listed once for every group they are in, as gmsh does, become one cell each.

    Returns blocks, panels, warp in the new numbers.
    """
    kept_blocks: list[np.ndarray] = []
    kept: list[np.ndarray] = []
    number, before = [], 0
    for block in blocks:
        _, first, inverse = np.unique(
            np.sort(block, axis=1), axis=0, return_index=True, return_inverse=True
        )
        order = np.argsort(first)
        rank = np.empty(len(order), dtype=np.int64)
        rank[order] = np.arange(len(order))
        kept_blocks.append(block[first[order]])
        number.append(sum(len(rows) for rows in kept) + rank[inverse.ravel()])
        kept.append(before + first[order])
        before += len(block)
    number = np.concatenate(number)
    panels = {label: np.unique(number[cells]) for label, cells in panels.items()}
    return kept_blocks, panels, None if warp is None else warp[np.concatenate(kept)]


def with_groups(
    surface: Surface, cells: list[tuple[str, np.ndarray]], physical: bool, name: str
) -> meshio.Mesh:
    """A meshio mesh of a surface with its edges, panels, directors and warp.

    Parameters
    ----------
    cells : the meshio block of the surface's cells, as a list of one.
    physical : write groups as gmsh's physical groups instead of cell data.
    name : of the file, for messages.

    Raises
    ------
    MeshError : if gmsh's groups cannot express the names.
    """
    import meshio

    kind = "line" if surface.degree == 1 else "line3"
    cells = cells + [(kind, edge) for edge in surface.edges.values()]
    counts = [len(data) for _, data in cells]
    mesh = meshio.Mesh(surface.points, cells, point_data={"directors": surface.directors})
    if surface.warp is not None and physical:
        # What meshio writes as cell data in this format it cannot read back.
        warnings.warn(f"{name}: .msh files keep no warp, save as .vtu to keep it.", stacklevel=3)
    elif surface.warp is not None:
        warp = [np.zeros((count, 3)) for count in counts]
        warp[0][:] = surface.warp
        mesh.cell_data["warp"] = warp
    if not physical:
        for place, label in enumerate(surface.edges, start=1):
            flags = [np.zeros(count, dtype=np.int32) for count in counts]
            flags[place][:] = 1
            mesh.cell_data[f"edge:{label}"] = flags
        for label, panel in surface.panels.items():
            flags = [np.zeros(count, dtype=np.int32) for count in counts]
            flags[0][panel] = 1
            mesh.cell_data[f"panel:{label}"] = flags
        return mesh

    tags = [np.zeros(count, dtype=np.int32) for count in counts]
    for place, label in enumerate(surface.edges, start=1):
        tags[place][:] = place
        mesh.field_data[label] = np.array([place, 1])
    for place, (label, panel) in enumerate(surface.panels.items(), start=len(counts)):
        if label in mesh.field_data:
            raise MeshError(
                f"{name}: '{label}' names both an edge and a panel, rename one or save as .vtu."
            )
        if tags[0][panel].any():
            raise MeshError(
                f"{name}: panel '{label}' shares cells with another, save as .vtu instead."
            )
        tags[0][panel] = place
        mesh.field_data[label] = np.array([place, 2])
    mesh.cell_data["gmsh:physical"] = tags
    mesh.cell_data["gmsh:geometrical"] = [np.full(len(tag), 1, dtype=np.int32) for tag in tags]
    return mesh
