"""Repairs that change how points and cells are joined, not what the surface looks like.

A mesh too faulty to pass the check is built with ``verify=False``; repairs keep that setting, and
``surface.replace(verify=True)`` ends a chain of them. Changes of cell type live in `subdivide`.
"""
# SPDX-License-Identifier: LGPL-3.0-or-later

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from .geometry import (
    area_vectors,
    cell_centres,
    coincident_pairs,
    corner_tangents,
    diagonal,
    mean_normals,
)
from .sheets import components, seams, sheet_of_cells, turned_to_agree
from .subdivide import elevate, split_triangles, to_triangles
from .topology import boundary_segments, corner_count, neighbour_lists
from .validity import MeshError, check_arrays, check_twins

if TYPE_CHECKING:
    from .surface import Surface

__all__ = [
    "boundary_loops",
    "clean",
    "elevate",
    "merge_duplicates",
    "orient",
    "scaled_jacobian",
    "split_triangles",
    "to_triangles",
]

TURNED = {3: [0, 2, 1], 4: [0, 3, 2, 1], 9: [0, 3, 2, 1, 7, 6, 5, 4, 8]}


def orient(
    surface: Surface,
    outward: bool = False,
    towards: ArrayLike | None = None,
    majority: bool = False,
) -> Surface:
    """Turn cells so that all neighbours face the same side.

    Each connected piece keeps the side of its first cell, unless a preference is given.

    Parameters
    ----------
    surface : Surface, usually built with ``verify=False``.
    outward : face away from the centre of each piece (sensible for closed or bulging pieces).
    towards : (3,) direction the mean normal of each piece shall agree with.
    majority : keep the side of most cells of each piece.

    Returns
    -------
    Surface; given directors are kept and turned with the cells.

    Raises
    ------
    MeshError : if a piece is one-sided (a Moebius strip);
        ValueError if preferences compete or ``towards`` has no length.
    """
    if bool(outward) + (towards is not None) + bool(majority) > 1:
        raise ValueError("give at most one of outward, towards and majority")
    points, cells = surface.points, surface.cells
    check_arrays(points, cells, surface.source)
    check_twins(cells, surface.source)
    turn, piece = _flood(cells, surface.source)

    vectors = np.where(turn[:, None], -1.0, 1.0) * area_vectors(points, cells)
    if majority:
        score = np.bincount(piece, np.where(turn, -1.0, 1.0))
    elif outward:
        areas = np.linalg.norm(vectors, axis=1)
        centres = cell_centres(points, cells)
        total = np.bincount(piece, areas)
        middle = [np.bincount(piece, areas * c) / total for c in centres.T]
        away = centres - np.stack(middle, axis=1)[piece]
        score = np.bincount(piece, np.einsum("mi,mi->m", away, vectors))
    elif towards is not None:
        direction = np.asarray(towards, dtype=np.float64)
        if direction.shape != (3,) or not np.linalg.norm(direction) > 0.0:
            raise ValueError(f"towards must be a vector of three components, not {towards!r}")
        score = np.bincount(piece, vectors @ direction)
    else:
        score = np.ones(piece.max() + 1, float)
    turn ^= (score < 0.0)[piece]
    if seams(cells):
        now = np.where(turn[:, None], cells[:, TURNED[cells.shape[1]]], cells)
        turn ^= turned_to_agree(points, now, piece)[piece]
    if not turn.any():
        return surface
    cells = np.where(turn[:, None], cells[:, TURNED[cells.shape[1]]], cells)
    directors = surface.directors
    if directors is not None:
        along = np.einsum("ni,ni->n", directors, mean_normals(points, cells))
        directors = np.where(along[:, None] < 0.0, -directors, directors)
    flat = None if surface.flat is None else turned_flat(surface.flat, turn)
    return surface.replace(cells=cells, directors=directors, flat=flat)


def turned_flat(flat: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """Flat corners (m, k, 2) of cells of which those of the mask (m,) are turned over: mirrored."""
    mirrored = flat[:, TURNED[flat.shape[1]]] * np.array([1.0, -1.0])
    return np.where(turn[:, None, None], mirrored, flat)


def _flood(cells, source):
    """Whether each cell must turn to agree with the first of its piece, and the piece's number."""
    touching = neighbour_lists(cells)
    turn, piece = [False] * len(cells), [-1] * len(cells)
    pieces = 0
    for seed in range(len(cells)):
        if piece[seed] >= 0:
            continue
        piece[seed] = pieces
        front = [seed]
        while front:
            cell = front.pop()
            for other, opposed in touching[cell]:
                wanted = turn[cell] != opposed
                if piece[other] < 0:
                    piece[other], turn[other] = pieces, wanted
                    front.append(other)
                elif turn[other] != wanted:
                    raise MeshError(
                        f"{source}: the surface has only one side (a way round it comes back to "
                        f"cell {other} turned over), cut it open along a line of edges there."
                    )
        pieces += 1
    return np.array(turn), np.array(piece)


def merge_duplicates(surface: Surface, tolerance: float | None = None) -> Surface:
    """Join points no further apart than ``tolerance`` [m]; default 1e-9 of the bounding box.

    The first point of each group stays where it is and takes the mean director. Joining closes
    slits too. Raises ValueError for a negative tolerance; a cell that would lose an edge is
    reported as a MeshError by the check.
    """
    points = surface.points
    if tolerance is None:
        tolerance = 1e-9 * diagonal(points)
    if not tolerance >= 0.0:
        raise ValueError(f"tolerance must not be negative, is {tolerance}")
    pairs = coincident_pairs(points, tolerance)
    if len(pairs) == 0:
        return surface
    label = np.arange(len(points))
    while True:
        # Chains of close points settle on the lowest index among them.
        lowest = np.minimum(label[pairs[:, 0]], label[pairs[:, 1]])
        before = label.copy()
        np.minimum.at(label, pairs[:, 0], lowest)
        np.minimum.at(label, pairs[:, 1], lowest)
        label = label[label]
        if np.array_equal(label, before):
            break
    directors = surface.directors
    if directors is not None:
        sums = np.stack([np.bincount(label, column, len(points)) for column in directors.T], axis=1)
        lengths = np.linalg.norm(sums, axis=1, keepdims=True)
        directors = np.where(lengths > 1e-8, sums / np.maximum(lengths, 1e-8), directors)
    return _renumbered(surface, label, directors)


def clean(surface: Surface) -> Surface:
    """Drop points that belong to no cell, and the edge segments that name them."""
    return _renumbered(surface, np.arange(len(surface.points)), surface.directors)


def _renumbered(surface, label, directors):
    """The surface with point i replaced by label[i], on the points its cells still use."""
    cells = label[surface.cells]
    used = np.unique(cells)
    number = np.full(len(label), -1)
    number[used] = np.arange(len(used))
    edges = {}
    for name, edge in surface.edges.items():
        moved = number[label[edge]]
        kept = moved[(moved >= 0).all(axis=1) & (moved[:, 0] != moved[:, 1])]
        if len(kept) or len(edge) == 0:
            edges[name] = kept
    return surface.replace(
        points=surface.points[used],
        cells=number[cells],
        directors=None if directors is None else directors[used],
        edges=edges,
    )


def boundary_loops(surface: Surface) -> list[np.ndarray]:
    """Closed boundary lines as ordered point indices, longest first.

    Each is an array (k,) with the surface on its left; the last point joins the first. For 9-node
    cells corners and middles alternate. What is sewn onto a garment has borders that are none of
    the garment: they are left out.
    """
    segments = boundary_segments(_bordered(surface))
    leaving: dict[int, list[int]] = {}
    for row, tail in enumerate(segments[:, 0].tolist()):
        leaving.setdefault(tail, []).append(row)
    loops = []
    for start in list(leaving):
        while leaving[start]:
            rows, point = [], start
            # Where two loops touch in a point, a walk may pass through it; it ends at its start.
            while leaving.get(point):
                rows.append(leaving[point].pop())
                point = int(segments[rows[-1], 1])
                if point == start:
                    break
            columns = [0] if segments.shape[1] == 2 else [0, 2]
            loops.append(segments[rows][:, columns].ravel())

    def length(loop):
        line = surface.points[np.append(loop, loop[0])]
        return np.linalg.norm(np.diff(line, axis=0), axis=1).sum()

    return sorted(loops, key=length, reverse=True)


def _bordered(surface):
    """Cells whose borders are the garment's: of sheets sewn together the largest alone."""
    points, cells = surface.points, surface.cells
    crowded = seams(cells)
    if not crowded:
        return cells
    sheet = sheet_of_cells(points, cells)
    count = corner_count(cells)
    touching = [(rows[0] // count, row // count) for rows in crowded for row in rows[1:]]
    sewn = components(sheet[np.array(touching)], int(sheet.max()) + 1)
    # sheets are numbered from the largest, so the first of each group is the garment
    kept = np.unique(sewn, return_index=True)[1]
    return cells[np.isin(sheet, kept)]


def scaled_jacobian(surface: Surface) -> np.ndarray:
    """Shape quality of each cell (m,): the smallest sine of its corner angles.

    1 for a rectangle, sqrt(3) / 2 for an equilateral triangle, 0 or less for a folded corner;
    angles are measured in the plane of the cell's mean normal.
    """
    onward, back = corner_tangents(surface.points, surface.cells)
    normals = area_vectors(surface.points, surface.cells)
    normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    determinants = np.einsum("mni,mi->mn", np.cross(onward, back), normals)
    sides = np.linalg.norm(onward, axis=2) * np.linalg.norm(back, axis=2)
    return (determinants / sides).min(axis=1)
