"""Changes of cell type that keep the mesh conforming: triangles to quads, quads to triangles,
straight quads to 9-node ones. Named edges, panels and warp directions are carried over.
"""
# SPDX-License-Identifier: LGPL-3.0-or-later

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from .topology import cut_quads, directed_edges, edge_keys, neighbour_lists, unique_edges

if TYPE_CHECKING:
    from .surface import Surface


def _unit_mean(vectors):
    """Normalised mean over the second axis of (k, j, 3); the first vector where it vanishes."""
    sums = vectors.sum(axis=1)
    lengths = np.linalg.norm(sums, axis=1, keepdims=True)
    return np.where(lengths > 1e-8, sums / np.maximum(lengths, 1e-8), vectors[:, 0])


def halve(segments: np.ndarray, edges: np.ndarray, middles: np.ndarray, size: int) -> np.ndarray:
    """Rows [tail, middle, head] of segments (k, 2), looked up among edges (j, 2) with middles (j,).

    Segments that are not among the edges get the middle -1.
    """
    if len(segments) == 0:
        return np.empty((0, 3), dtype=np.int64)
    keys = edge_keys(edges, size)
    order = np.argsort(keys, kind="stable")
    wanted = edge_keys(segments, size)
    place = order[np.minimum(np.searchsorted(keys[order], wanted), len(order) - 1)]
    found = np.where(keys[place] == wanted, middles[place], -1)
    return np.stack([segments[:, 0], found, segments[:, 1]], axis=1)


def add_middles(
    points: np.ndarray, blocks: list[np.ndarray], directors: np.ndarray | None = None
) -> tuple[
    np.ndarray,
    np.ndarray | None,
    list[np.ndarray],
    list[np.ndarray],
    Callable[[np.ndarray], np.ndarray],
]:
    """New points in the middle of every edge and every cell.

    Parameters
    ----------
    points : (n, 3).
    blocks : list of straight cells (m, 3 | 4) of one conforming mesh.
    directors : None or (n, 3), averaged at the new points.

    Returns
    -------
    points, directors, middles and centres (lists over blocks: (m, corners) and (m,)), and a
    function that maps segments (k, 2) to rows [tail, middle, head].
    """
    size = len(points)
    edges = np.concatenate([directed_edges(block) for block in blocks])
    first, number, _ = unique_edges(edges, size)
    ends = edges[first]
    new_points = [points, points[ends].mean(axis=1)]
    turned = [] if directors is None else [directors, _unit_mean(directors[ends])]
    middles, centres = [], []
    row, next_centre = 0, size + len(first)
    for block in blocks:
        middles.append(size + number[row : row + block.size].reshape(block.shape))
        centres.append(next_centre + np.arange(len(block)))
        new_points.append(points[block].mean(axis=1))
        if directors is not None:
            turned.append(_unit_mean(directors[block]))
        row += block.size
        next_centre += len(block)

    def cut(segments):
        return halve(segments, ends, size + np.arange(len(ends)), size)

    new_directors = None if directors is None else np.concatenate(turned)
    return np.concatenate(new_points), new_directors, middles, centres, cut


def split_blocks(
    points: np.ndarray,
    blocks: list[np.ndarray],
    edges: dict[str, np.ndarray],
    directors: np.ndarray | None = None,
) -> tuple[np.ndarray, np.ndarray, dict[str, np.ndarray], np.ndarray | None, np.ndarray]:
    """Cut every cell of a conforming mesh into quads through its edge middles and its centre.

    A triangle gives three quads, a quad four. Returns points, quads, edges, directors and
    ``parents``, the cell (counted through the blocks) each quad comes from.
    """
    points, directors, middles, centres, cut = add_middles(points, blocks, directors)
    quads, parents, before = [], [], 0
    for block, middle, centre in zip(blocks, middles, centres):
        count = block.shape[1]
        inner = np.broadcast_to(centre[:, None], block.shape)
        corner_quads = np.stack([block, middle, inner, np.roll(middle, 1, axis=1)], axis=-1)
        quads.append(corner_quads.reshape(-1, 4))
        parents.append(before + np.repeat(np.arange(len(block)), count))
        before += len(block)
    edges = {name: cut(edge)[:, [0, 1, 1, 2]].reshape(-1, 2) for name, edge in edges.items()}
    return points, np.concatenate(quads), edges, directors, np.concatenate(parents)


def carry(
    panels: dict[str, np.ndarray], warp: np.ndarray | None, parents: np.ndarray
) -> tuple[dict[str, np.ndarray], np.ndarray | None]:
    """Panels and warp of new cells, each of which lies in the old cell ``parents`` (k,)."""
    panels = {name: np.flatnonzero(np.isin(parents, cells)) for name, cells in panels.items()}
    return panels, warp if warp is None or warp.ndim != 2 else warp[parents]


def split_triangles(surface: Surface) -> Surface:
    """Cut each triangle into three quads through its edge middles and its centre.

    The surface stays the same, the named edges get twice as many segments. Raises ValueError for
    a surface of quads.
    """
    if surface.kind != "triangle":
        raise ValueError(f"{surface.source}: the cells are quads already")
    points, quads, edges, directors, parents = split_blocks(
        surface.points, [surface.cells], surface.edges, surface.directors
    )
    panels, warp = carry(surface.panels, surface.warp, parents)
    return surface.replace(
        points=points, cells=quads, edges=edges, directors=directors, panels=panels, warp=warp
    )


def to_triangles(surface: Surface, pattern: str = "alternating") -> Surface:
    """Cut each 4-node quad into two triangles; points and named edges stay.

    Parameters
    ----------
    pattern : diagonal to cut along: 'alternating' from cell to cell, 'first' (corners 0-2),
        'second' (corners 1-3) or 'shortest'.

    Raises
    ------
    ValueError : for cells other than 4-node quads or an unknown pattern.
    """
    cells = surface.cells
    if cells.shape[1] != 4:
        raise ValueError(f"{surface.source}: only 4-node quads can be cut into triangles")
    if pattern == "alternating":
        odd = _checkerboard(cells)
    elif pattern in ("first", "second"):
        odd = np.full(len(cells), pattern == "second")
    elif pattern == "shortest":
        corners = surface.points[cells]
        diagonals = np.linalg.norm(corners[:, 2:] - corners[:, :2], axis=2)
        odd = diagonals[:, 1] < diagonals[:, 0] * (1.0 - 1e-9)
    else:
        raise ValueError(
            f"pattern must be 'alternating', 'first', 'second' or 'shortest', not {pattern!r}"
        )
    panels, warp = carry(surface.panels, surface.warp, np.repeat(np.arange(len(cells)), 2))
    return surface.replace(
        cells=cut_quads(cells, odd), directors=surface.directors, panels=panels, warp=warp
    )


def _checkerboard(cells):
    """Whether each quad cuts along 1-3, so that neighbours' diagonals meet where they can."""
    touching = neighbour_lists(cells)
    corners = cells.tolist()
    # A point on a diagonal is a hub of eight triangles: all quads around it shall cut through it.
    odd = [None] * len(cells)
    for seed in range(len(cells)):
        if odd[seed] is not None:
            continue
        odd[seed] = False
        front = [seed]
        while front:
            cell = front.pop()
            hubs = {corners[cell][k] for k in ((1, 3) if odd[cell] else (0, 2))}
            for other, _ in touching[cell]:
                if odd[other] is None:
                    odd[other] = corners[other][1] in hubs or corners[other][3] in hubs
                    front.append(other)
    return np.array(odd)


def elevate(surface: Surface, project: Callable[[np.ndarray], ArrayLike] | None = None) -> Surface:
    """Turn 4-node quads into 9-node cells.

    Parameters
    ----------
    project : function that moves the new points (k, 3) onto the true surface and returns them;
        None leaves them in the middle of edges and cells. With it directors are computed afresh.

    Raises
    ------
    ValueError : for other cells, or if ``project`` returns another shape.
    """
    cells = surface.cells
    if cells.shape[1] != 4:
        raise ValueError(f"{surface.source}: only 4-node quads can be made 9-node cells")
    points, directors, (middles,), (centres,), cut = add_middles(
        surface.points, [cells], surface.directors
    )
    if project is not None:
        count = len(surface.points)
        moved = np.asarray(project(points[count:].copy()), dtype=np.float64)
        if moved.shape != points[count:].shape:
            raise ValueError(
                f"project must return points of shape {points[count:].shape}, not {moved.shape}"
            )
        points[count:] = moved
        directors = None
    return surface.replace(
        points=points,
        cells=np.column_stack([cells, middles, centres]),
        edges={name: cut(edge)[:, [0, 2, 1]] for name, edge in surface.edges.items()},
        directors=directors,
    )
