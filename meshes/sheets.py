# SPDX-License-Identifier: LGPL-3.0-or-later
"""Sheets that meet at seams of three cells and more: collars, plackets, sewn pockets.

A surface may branch. Cells joined by sides of two cells make a patch; where more meet, the two
patches that go on most smoothly are one sheet, the others are sewn to it. All nodes of a seam have
one director, so the sheets of a seam must lie nearly along each other and face the same side.
"""

from __future__ import annotations

import numpy as np

from .geometry import area_vectors, cell_areas, cell_centres
from .topology import corner_count, directed_edges, neighbours, unique_edges


def seams(cells: np.ndarray) -> list[np.ndarray]:
    """Rows of `directed_edges` at each side of three cells or more, one array for each side."""
    edges = directed_edges(cells)
    _, number, count = unique_edges(edges, int(cells.max()) + 1)
    if not (count > 2).any():
        return []
    order = np.argsort(number, kind="stable")
    starts = np.concatenate(([0], np.cumsum(count)[:-1]))
    return [order[starts[k] : starts[k] + count[k]] for k in np.flatnonzero(count > 2)]


def components(pairs: np.ndarray, count: int) -> np.ndarray:
    """Number of the connected part of each of `count` items joined by pairs (k, 2)."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    pairs = np.reshape(pairs, (-1, 2))
    graph = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    return connected_components(graph, directed=False)[1]


def sheet_of_cells(points: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """Number of the sheet of every cell (m,), the one of the largest area being 0."""
    joins = neighbours(cells)[0]
    crowded = seams(cells)
    if crowded:
        patch = components(joins, len(cells))
        areas = np.bincount(patch, cell_areas(points, cells))
        votes: dict[tuple[int, ...], dict[tuple[int, int], float]] = {}
        for rows in crowded:
            at = rows // corner_count(cells)
            place = votes.setdefault(tuple(sorted(set(patch[at].tolist()))), {})
            for one, other, smooth in _smoothness(points, cells, rows):
                a, b = sorted((int(patch[at[one]]), int(patch[at[other]])))
                # patches that go on equally smoothly: the larger ones are the garment's own
                more = 1e-3 * (areas[a] + areas[b]) / areas.sum()
                place[a, b] = place.get((a, b), 0.0) + smooth + more
        first = np.unique(patch, return_index=True)[1]
        best = [max(found, key=lambda pair: found[pair]) for found in votes.values()]
        more = np.array([(first[a], first[b]) for a, b in best if a != b], np.int64)
        joins = np.concatenate([joins, more.reshape(-1, 2)])
    sheet = components(joins, len(cells))
    rank = np.argsort(-np.bincount(sheet, cell_areas(points, cells)), kind="stable")
    return np.argsort(rank)[sheet]


def _smoothness(points, cells, rows):
    """Pairs of the cells at a seam and how straight the way over it is, 1 for straight on."""
    tail, head = points[directed_edges(cells)[rows[0], :2]]
    along = (head - tail) / np.linalg.norm(head - tail)
    away = cell_centres(points, cells[rows // corner_count(cells)]) - 0.5 * (tail + head)
    away -= (away @ along)[:, None] * along
    away /= np.maximum(np.linalg.norm(away, axis=1, keepdims=True), 1e-300)
    for one in range(len(rows)):
        for other in range(one):
            yield one, other, round(float(-away[one] @ away[other]), 2)


def main_sheet(points: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """Mask (m,) of the cells of the garment itself, without what is sewn onto it."""
    if not seams(cells):
        return np.ones(len(cells), bool)
    return sheet_of_cells(points, cells) == 0


def turned_to_agree(points: np.ndarray, cells: np.ndarray, piece: np.ndarray) -> np.ndarray:
    """Pieces (k,) bool that must turn over to face the side of those they are sewn to.

    piece : (m,) number of the piece of each cell; cells of one piece face one side. The largest
    piece of all that hang together stays.
    """
    turn = np.zeros(int(piece.max()) + 1, bool)
    vectors = area_vectors(points, cells)
    normals = vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-300)
    agree: dict[int, dict[int, float]] = {}
    for rows in seams(cells):
        at = rows // corner_count(cells)
        for one in at.tolist():
            for other in at.tolist():
                a, b = int(piece[one]), int(piece[other])
                if a != b:
                    link = agree.setdefault(a, {})
                    link[b] = link.get(b, 0.0) + float(normals[one] @ normals[other])
    seen = np.zeros(len(turn), bool)
    for start in np.argsort(-np.bincount(piece, np.linalg.norm(vectors, axis=1)), kind="stable"):
        front = [] if seen[start] else [int(start)]
        seen[start] = True
        while front:
            a = front.pop(0)
            # the surest first: sheets across each other say little of which way they face
            for b, along in sorted(agree.get(a, {}).items(), key=lambda item: -abs(item[1])):
                if not seen[b]:
                    seen[b], turn[b] = True, turn[a] ^ (along < 0.0)
                    front.append(b)
    return turn
