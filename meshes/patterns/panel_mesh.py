# SPDX-License-Identifier: LGPL-3.0-or-later
"""Quads throughout in a flat panel, with given nodes on its edges.

gmsh meshes the polygon of every second node with quads and triangles; all are cut through the
middles of their sides (meshes.subdivide), and the new nodes of the outline go where the curves are.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from meshes.geometry import area_vectors
from meshes.shapes.outline import mesh_polygon
from meshes.subdivide import split_blocks
from meshes.validity import MeshError

from .pattern import Panel


class PanelMesh(NamedTuple):
    """Mesh of a panel: points (n, 2) [m], quads (m, 4), nodes of each edge in its direction."""

    points: np.ndarray
    cells: np.ndarray
    edges: dict[str, np.ndarray]


def mesh_panel(
    panel: Panel, fractions: Mapping[str, np.ndarray], size: float, source: str
) -> PanelMesh:
    """Mesh of a panel.

    Parameters
    ----------
    fractions : of each edge's length, where its coarse nodes lie, from 0 to 1; size : of these [m]

    Raises
    ------
    MeshError where cells do not fit the outline
    """
    coarse = [panel.edge(e.name).at(fractions[e.name]) for e in panel.edges]
    corners = np.concatenate([line[:-1] for line in coarse])
    try:
        flat, blocks, sides = mesh_polygon(corners, size, True, whole_sides=True)
    except Exception as error:  # gmsh raises no other
        raise MeshError(
            f"{source}: panel '{panel.name}' cannot be meshed ({error}): take smaller cells "
            "(cell_size_m under [garment])."
        ) from None
    points = np.column_stack([flat, np.zeros(len(flat))])
    lines = {str(k): side for k, side in enumerate(sides)}
    points, cells, lines, _, _ = split_blocks(points, blocks, lines)
    points, edges, at = points[:, :2], {}, 0
    for edge in panel.edges:
        rows = [lines[str(at + k)] for k in range(len(fractions[edge.name]) - 1)]
        at += len(rows)
        nodes = np.array([rows[0][0, 0], *(node for row in rows for node in row[:, 1])])
        fine = fractions[edge.name]
        fine = np.sort(np.concatenate([fine, 0.5 * (fine[1:] + fine[:-1])]))
        points[nodes] = edge.at(fine)
        edges[edge.name] = nodes
    used = np.unique(cells)
    number = np.full(len(points), -1)
    number[used] = np.arange(len(used))
    points, cells = points[used], number[cells]
    edges = {name: number[nodes] for name, nodes in edges.items()}
    turned = area_vectors(np.column_stack([points, np.zeros(len(points))]), cells)[:, 2] < 0.0
    cells = np.where(turned[:, None], cells[:, ::-1], cells)
    return PanelMesh(points, cells, edges)
