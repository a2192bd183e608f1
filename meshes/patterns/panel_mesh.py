# SPDX-License-Identifier: LGPL-3.0-or-later
"""Quads throughout in a flat panel, with given nodes on its edges.

A panel of four corners whose opposite sides have as many nodes gets a grid between them (Coons).
Of others gmsh meshes the polygon of every second node with quads and triangles; all are cut through
the middles of their sides (meshes.subdivide), the new nodes of the outline go where the curves are,
and those inside to the mean of their neighbours, a few times over.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from meshes.geometry import area_vectors
from meshes.shapes.outline import mesh_polygon
from meshes.subdivide import split_blocks
from meshes.topology import boundary_segments, directed_edges
from meshes.validity import MeshError

from .pattern import Panel

SMOOTHED = 5  # times
CORNER = np.radians(30.0)  # of a turn in the outline


class PanelMesh(NamedTuple):
    """Mesh of a panel: points (n, 2) [m], quads (m, 4), nodes of each edge in its direction."""

    points: np.ndarray
    cells: np.ndarray
    edges: dict[str, np.ndarray]


def mesh_panel(
    panel: Panel, fractions: Mapping[str, np.ndarray], size: float, source: str
) -> PanelMesh:
    """Mesh of a panel, its quads counter-clockwise.

    Parameters
    ----------
    fractions : of each edge's length, where its coarse nodes lie, from 0 to 1; size : of these [m]

    Raises
    ------
    MeshError where cells do not fit the outline
    """
    fine = {e.name: e.at(_halved(fractions[e.name])) for e in panel.edges}
    made = _grid(panel, fine) or _by_gmsh(panel, fractions, fine, size, source)
    turned = _areas(made.points, made.cells) < 0.0
    return made._replace(cells=np.where(turned[:, None], made.cells[:, ::-1], made.cells))


def _halved(fractions):
    return np.sort(np.concatenate([fractions, 0.5 * (fractions[1:] + fractions[:-1])]))


def _areas(points, cells):
    return area_vectors(np.column_stack([points, np.zeros(len(points))]), cells)[:, 2]


def _grid(panel, fine):
    """Grid of a panel with four corners, None where sides or cells do not fit it."""
    count = len(panel.edges)
    lines = [fine[edge.name] for edge in panel.edges]
    corners = []
    for k in range(count):
        before, after = lines[k - 1][-1] - lines[k - 1][-2], lines[k][1] - lines[k][0]
        turn = np.arctan2(before[0] * after[1] - before[1] * after[0], before @ after)
        if abs(turn) > CORNER:
            corners.append((k, np.sign(turn)))
    if len(corners) != 4 or len({sign for _, sign in corners}) > 1:
        return None
    starts = [k for k, _ in corners]
    order = [(starts[0] + k) % count for k in range(count)]
    sides: list[list[int]] = []
    for k in order:
        if k in starts:
            sides.append([])
        sides[-1].append(k)
    whole = [
        np.concatenate([*(lines[k][:-1] for k in side), lines[side[-1]][-1:]]) for side in sides
    ]
    n, m = len(whole[0]), len(whole[1])
    if len(whole[2]) != n or len(whole[3]) != m:
        return None
    low, right, high, left = whole[0], whole[1], whole[2][::-1], whole[3][::-1]
    u, v = np.linspace(0, 1, n)[:, None, None], np.linspace(0, 1, m)[None, :, None]
    points = (1 - v) * low[:, None] + v * high[:, None] + (1 - u) * left[None] + u * right[None]
    points -= (1 - u) * ((1 - v) * low[0] + v * high[0]) + u * ((1 - v) * low[-1] + v * high[-1])
    number = np.arange(n * m).reshape(n, m)
    corner = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
    cells, points = np.stack([c.ravel() for c in corner], axis=1), points.reshape(-1, 2)
    sides_of = np.roll(points[cells], -1, axis=1) - points[cells]
    after = np.roll(sides_of, -1, axis=1)
    turn = sides_of[..., 0] * after[..., 1] - sides_of[..., 1] * after[..., 0]
    if not (np.all(turn > 0) or np.all(turn < 0)):
        return None
    borders = [number[:, 0], number[-1], number[::-1, -1], number[0, ::-1]]
    edges = {}
    for side, nodes in zip(sides, borders, strict=True):
        at = 0
        for k in side:
            edges[panel.edges[k].name] = nodes[at : at + len(lines[k])]
            at += len(lines[k]) - 1
    return PanelMesh(points, cells, edges)


def _by_gmsh(panel, fractions, fine, size, source):
    coarse = [fine[e.name][::2] for e in panel.edges]
    corners = np.concatenate([line[:-1] for line in coarse])
    try:
        flat, blocks, sides = mesh_polygon(corners, size, True, whole_sides=True)
    except ImportError:
        raise
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
        points[nodes] = fine[edge.name]
        edges[edge.name] = nodes
    used = np.unique(cells)
    number = np.full(len(points), -1)
    number[used] = np.arange(len(used))
    points, cells = points[used], number[cells]
    edges = {name: number[nodes] for name, nodes in edges.items()}
    return PanelMesh(_smoothed(points, cells), cells, edges)


def _smoothed(points, cells):
    """Points (n, 2), those inside at the mean of their neighbours, unless a cell turns over."""
    ends = np.unique(np.sort(directed_edges(cells)[:, :2], axis=1), axis=0)
    border, n = np.unique(boundary_segments(cells)), len(points)
    many = np.bincount(ends.ravel(), minlength=n)
    moved = points.copy()
    for _ in range(SMOOTHED):
        sums = [
            np.bincount(ends[:, 0], x[ends[:, 1]], n) + np.bincount(ends[:, 1], x[ends[:, 0]], n)
            for x in moved.T
        ]
        mean = np.stack(sums, axis=1) / many[:, None]
        mean[border] = points[border]
        moved = mean
    before, after = _areas(points, cells), _areas(moved, cells)
    return moved if np.all(before * after > 0) else points
