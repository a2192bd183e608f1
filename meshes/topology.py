"""Which cell touches which: edges, boundary segments and ordered polylines of a cell array.

Everything here sees only integers. Cells are rows of 3, 4 or 9 point indices in cyclic order; an
edge is a row [tail, head] or, for 9-node cells, [tail, head, middle].
"""
# SPDX-License-Identifier: LGPL-3.0-or-later

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike


def corner_count(cells: np.ndarray) -> int:
    """Number of corners of the cells (m, 3 | 4 | 9): 3 or 4."""
    return 3 if cells.shape[1] == 3 else 4


def directed_edges(cells: np.ndarray) -> np.ndarray:
    """Edges of every cell in its own direction of travel.

    Returns (m * corners, 2 | 3); row r belongs to cell r // corners.
    """
    count = corner_count(cells)
    tails = cells[:, :count]
    columns = [tails, np.roll(tails, -1, axis=1)]
    if cells.shape[1] == 9:
        columns.append(cells[:, 4:8])
    return np.stack(columns, axis=-1).reshape(-1, len(columns))


def edge_keys(edges: np.ndarray, size: int) -> np.ndarray:
    """One integer for each undirected edge (k, 2 | 3); ``size`` exceeds every point index."""
    ends = edges[:, :2]
    return ends.min(axis=1) * np.int64(size) + ends.max(axis=1)


def unique_edges(edges: np.ndarray, size: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Undirected edges once each.

    Returns ``first`` (row of the first occurrence), ``number`` (unique edge of each row) and
    ``count`` (occurrences of each unique edge).
    """
    _, first, number, count = np.unique(
        edge_keys(edges, size), return_index=True, return_inverse=True, return_counts=True
    )
    return first, number, count


def boundary_segments(cells: np.ndarray) -> np.ndarray:
    """Edges that belong to one cell only, (k, 2 | 3), directed with the cell on their left."""
    edges = directed_edges(cells)
    first, _, count = unique_edges(edges, cells.max() + 1)
    return edges[np.sort(first[count == 1])]


def neighbours(cells: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of cells with a common edge.

    Returns ``pairs`` (k, 2) and ``opposed`` (k,): True where both travel the edge in the same
    direction, that is, where their sides disagree. Edges of more than two cells are left out.
    """
    edges = directed_edges(cells)
    _, number, count = unique_edges(edges, cells.max() + 1)
    rows = np.argsort(number, kind="stable")
    starts = np.concatenate(([0], np.cumsum(count)[:-1]))[count == 2]
    one, other = rows[starts], rows[starts + 1]
    pairs = np.stack([one, other], axis=1) // corner_count(cells)
    return pairs, edges[one, 0] == edges[other, 0]


def neighbour_lists(cells: np.ndarray) -> list[list[tuple[int, bool]]]:
    """For each cell a list of (neighbour, opposed)."""
    pairs, opposed = neighbours(cells)
    lists: list[list[tuple[int, bool]]] = [[] for _ in range(len(cells))]
    for (one, other), against in zip(pairs.tolist(), opposed.tolist()):
        lists[one].append((other, against))
        lists[other].append((one, against))
    return lists


def segments_of_line(indices: ArrayLike, degree: int = 1) -> np.ndarray:
    """Consecutive point indices of one line as rows [tail, head] or [tail, head, middle]."""
    indices = np.asarray(indices, dtype=np.int64)
    if degree == 1:
        return np.stack([indices[:-1], indices[1:]], axis=1)
    return np.stack([indices[:-2:2], indices[2::2], indices[1:-1:2]], axis=1)


def chain(segments: np.ndarray) -> np.ndarray:
    """Order segments (k, 2 | 3) head to tail, piece after piece.

    Segments that branch (a point with more than two of them) have no such order and are returned
    as they came.
    """
    if len(segments) < 2 or np.array_equal(segments[1:, 0], segments[:-1, 1]):
        return segments
    _, degree = np.unique(segments[:, :2], return_counts=True)
    if degree.max() > 2:
        return segments
    rows_at: dict[int, list[int]] = {}
    for number, (tail, head) in enumerate(segments[:, :2].tolist()):
        rows_at.setdefault(tail, []).append(number)
        rows_at.setdefault(head, []).append(number)
    # Open pieces must be entered at an end; a loop may be entered anywhere, so tails follow.
    open_tails = [t for t in segments[:, 0].tolist() if len(rows_at[t]) == 1]
    open_heads = [h for h in segments[:, 1].tolist() if len(rows_at[h]) == 1]
    ordered, used = [], set()
    for point in open_tails + open_heads + segments[:, 0].tolist():
        row: int | None = next((r for r in rows_at[point] if r not in used), None)
        while row is not None:
            used.add(row)
            segment = segments[row].copy()
            if segment[0] != point:
                segment[:2] = segment[1::-1]
            ordered.append(segment)
            point = int(segment[1])
            row = next((r for r in rows_at[point] if r not in used), None)
    return np.array(ordered)


def cut_quads(cells: np.ndarray, odd: ArrayLike) -> np.ndarray:
    """Two triangles for each quad (m, 4): diagonal 0-2, or 1-3 where ``odd`` (m,) is True."""
    patterns = np.array([[[0, 1, 2], [0, 2, 3]], [[0, 1, 3], [1, 2, 3]]])
    chosen = patterns[np.asarray(odd, dtype=np.int64)]
    return np.take_along_axis(cells[:, None, :], chosen, axis=2).reshape(-1, 3)


def straight_cells(cells: np.ndarray) -> np.ndarray:
    """Cells whose corners are all their points: 9-node cells (m, 9) as four quads each, row by row.

    Row r belongs to cell r // 4; cells (m, 3 | 4) are given back.
    """
    if cells.shape[1] != 9:
        return cells
    quarters = [[0, 4, 8, 7], [4, 1, 5, 8], [8, 5, 2, 6], [7, 8, 6, 3]]
    return cells[:, quarters].reshape(-1, 4)
