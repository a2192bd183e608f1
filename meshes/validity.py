"""What makes an array of points and cells a usable surface, and the sentence for each fault.

Every fault is reported as one sentence that names the mesh, the first item at fault and the mend.
Nothing is guessed about units here: a benchmark may well be ten metres or ten microns large.
"""
# SPDX-License-Identifier: LGPL-3.0-or-later

from __future__ import annotations

import warnings
from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from .geometry import area_vectors, coincident_pairs, diagonal, mean_normals, node_crosses
from .seam_directors import seam_directors
from .sheets import seams
from .topology import corner_count, directed_edges, edge_keys, neighbours, unique_edges

if TYPE_CHECKING:
    from .surface import Surface


STEEPEST = 60.0  # degrees between the director of a seam and the normals of its sheets


class MeshError(ValueError):
    """A mesh that cannot be used; the message names the mesh, the item and the mend.

    Examples
    --------
    >>> import meshes
    >>> corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    >>> meshes.Surface(corners, [(0, 1, 2, 4)])
    Traceback (most recent call last):
    meshes.validity.MeshError: surface: ...
    """


def with_hint(error: ValueError, notes: Iterable[str]) -> ValueError:
    """The error with the first of the notes that says what would mend its likely cause.

    Of points that are not joined come borders within the garment, pieces and one-sided surfaces; of
    thick sheets come garments without an opening.
    """
    for note in notes:
        if "weld_m" in note or "midsurface = true" in note:
            return type(error)(f"{error} First, {note.partition(': ')[2]}")
    return error


def check(surface: Surface) -> None:
    """Raise MeshError for the first fault of a Surface; warn about coincident points.

    Directors that are None are passed over. All tests are vectorised over cells and points.
    """
    points, cells, source = surface.points, surface.cells, surface.source
    check_arrays(points, cells, source)
    _check_unused(points, cells, source)
    _check_shapes(points, cells, source)
    check_twins(cells, source)
    _check_names(surface)
    # before what they may be the cause of
    _warn_coincident(surface)
    _check_sides(cells, source)
    _check_directions(surface)


def check_arrays(points: np.ndarray, cells: np.ndarray, source: str) -> None:
    """Raise MeshError unless points and cells are finite, well shaped and refer to each other."""
    if points.size == 0 or cells.size == 0:
        raise MeshError(
            f"{source}: the mesh is empty ({len(points)} points, {len(cells)} cells), give cells."
        )
    if points.ndim != 2 or points.shape[1] != 3:
        raise MeshError(
            f"{source}: points have the shape {points.shape}, give one row of three coordinates "
            "for each point (add a zero column to a flat mesh)."
        )
    if cells.ndim != 2 or cells.shape[1] not in (3, 4, 9):
        raise MeshError(
            f"{source}: cells have the shape {cells.shape}, give one row of 3, 4 or 9 point "
            "indices for each cell."
        )
    check_indices(points, cells, source)


def check_indices(points: np.ndarray, cells: np.ndarray, source: str) -> None:
    """Raise MeshError unless points are finite and cells (m, k) name points that exist."""
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if bad.size:
        raise MeshError(
            f"{source}: point {bad[0]} has the coordinates {points[bad[0]].tolist()}, all must be "
            f"finite numbers ({bad.size} such points; export the mesh again)."
        )
    bad = np.flatnonzero(((cells < 0) | (cells >= len(points))).any(axis=1))
    if bad.size:
        raise MeshError(
            f"{source}: cell {bad[0]} names the points {cells[bad[0]].tolist()}, indices must "
            f"lie in 0 to {len(points) - 1} (count from zero)."
        )


def _check_unused(points, cells, source):
    unused = np.setdiff1d(np.arange(len(points)), cells)
    if unused.size:
        raise MeshError(
            f"{source}: point {unused[0]} belongs to no cell ({unused.size} such points), drop "
            "them with meshes.clean(Surface(..., verify=False))."
        )


def _check_shapes(points, cells, source):
    ordered = np.sort(cells, axis=1)
    twice = (np.diff(ordered, axis=1) == 0).any(axis=1)
    if twice.any():
        cell = int(np.argmax(twice))
        raise MeshError(
            f"{source}: cell {cell} uses a point twice {cells[cell].tolist()}, remove the cell "
            "or mesh this place again."
        )
    edges = directed_edges(cells)
    lengths = np.linalg.norm(points[edges[:, 1]] - points[edges[:, 0]], axis=1)
    short = np.flatnonzero(lengths <= 1e-12 * diagonal(points))
    if short.size:
        cell = short[0] // corner_count(cells)
        raise MeshError(
            f"{source}: the edge from point {edges[short[0], 0]} to point {edges[short[0], 1]} of "
            f"cell {cell} has no length, join its ends with meshes.merge_duplicates and remove "
            "the cell."
        )
    longest = lengths.reshape(len(cells), -1).max(axis=1)
    vectors = area_vectors(points, cells)
    areas = np.linalg.norm(vectors, axis=1)
    flat = np.flatnonzero(areas <= 1e-10 * longest**2)
    if flat.size:
        raise MeshError(
            f"{source}: cell {flat[0]} has no area or crosses itself (points "
            f"{cells[flat[0]].tolist()}), put its points in cyclic order or mesh this place again."
        )
    along = np.einsum("mni,mi->mn", node_crosses(points, cells), vectors / areas[:, None])
    folded = np.argwhere(along <= 1e-10 * longest[:, None] ** 2)
    if len(folded):
        cell, node = folded[0]
        raise MeshError(
            f"{source}: cell {cell} is concave, crosses itself or is folded at point "
            f"{cells[cell, node]} ({len(np.unique(folded[:, 0]))} such cells), put its points in "
            "cyclic order, move that point, or use smaller cells."
        )


def check_twins(cells: np.ndarray, source: str) -> None:
    """Raise MeshError for two equal cells."""
    ordered = np.sort(cells, axis=1)
    rank = np.lexsort(ordered.T)
    same = (ordered[rank[1:]] == ordered[rank[:-1]]).all(axis=1)
    if same.any():
        place = int(np.argmax(same))
        one, other = sorted((int(rank[place]), int(rank[place + 1])))
        raise MeshError(f"{source}: cells {one} and {other} have the same points, remove one.")


def _check_sides(cells, source):
    pairs, opposed = neighbours(cells)
    if opposed.any():
        one, other = pairs[np.argmax(opposed)]
        raise MeshError(
            f"{source}: neighbouring cells {one} and {other} face opposite sides, turn them with "
            "meshes.orient(Surface(..., verify=False))."
        )
    if cells.shape[1] == 9:
        # Two curved cells that share their corners but not the node between them leave a gap.
        edges = directed_edges(cells)
        first, number, _ = unique_edges(edges, cells.max() + 1)
        torn = np.flatnonzero(edges[first[number], 2] != edges[:, 2])
        if torn.size:
            row, mate = torn[0], first[number[torn[0]]]
            raise MeshError(
                f"{source}: cells {mate // 4} and {row // 4} share an edge but have the middle "
                f"points {edges[mate, 2]} and {edges[row, 2]} on it, use one point for both."
            )


def _check_directions(surface):
    points, cells, source = surface.points, surface.cells, surface.source
    directors, warp = surface.directors, surface.warp
    if directors is None and seams(cells):
        normals = mean_normals(points, cells)
        size = np.linalg.norm(normals, axis=1, keepdims=True)
        middle = seam_directors(points, cells, normals / np.maximum(size, 1e-12))
        _check_seams(points, cells, middle, source)
    if directors is not None:
        if directors.shape != points.shape:
            raise MeshError(
                f"{source}: directors have the shape {directors.shape}, give one unit vector for "
                f"each point {points.shape} or None."
            )
        # Written so that a NaN counts as a fault.
        bad = np.flatnonzero(~(np.abs(np.linalg.norm(directors, axis=1) - 1.0) < 1e-6))
        if bad.size:
            raise MeshError(
                f"{source}: the director {directors[bad[0]].tolist()} of point {bad[0]} has not "
                f"unit length ({bad.size} such points), divide it by its length."
            )
        along = np.einsum("ni,ni->n", directors, mean_normals(points, cells))
        bad = np.flatnonzero(along < 0.0)
        if bad.size:
            raise MeshError(
                f"{source}: the director of point {bad[0]} points against the normals of its "
                f"cells ({bad.size} of {len(points)} points), turn the directors or the cells."
            )
        _check_seams(points, cells, directors, source)
    if surface.flat is not None:
        _check_flat(surface)
    if warp is not None:
        if warp.shape not in ((3,), (len(cells), 3)):
            raise MeshError(
                f"{source}: warp has the shape {warp.shape}, give one direction (3,) or one for "
                f"each cell {(len(cells), 3)}."
            )
        bad = np.flatnonzero(~(np.linalg.norm(np.atleast_2d(warp), axis=1) > 0.0))
        if bad.size or not np.isfinite(warp).all():
            index = bad[0] if bad.size else 0
            raise MeshError(
                f"{source}: the warp direction {index} has no length or is not finite, give a "
                "vector along the warp yarns."
            )


def _check_flat(surface):
    flat, cells, source = surface.flat, surface.cells, surface.source
    wanted = (*cells.shape, 2)
    if cells.shape[1] == 9 or flat.shape != wanted:
        raise MeshError(
            f"{source}: flat has the shape {flat.shape}, give two coordinates for each corner of "
            f"each cell {wanted}; 9-node cells have none."
        )
    sides = np.roll(flat, -1, axis=1) - flat
    after = np.roll(sides, -1, axis=1)
    turn = sides[..., 0] * after[..., 1] - sides[..., 1] * after[..., 0]
    bad = np.flatnonzero(~(turn > 0.0).all(axis=1))
    if bad.size:
        raise MeshError(
            f"{source}: cell {bad[0]} is folded, concave or clockwise in its flat panel "
            f"({bad.size} such cells), mesh the panel again or mirror its flat coordinates."
        )


def _check_seams(points, cells, directors, source):
    """Sheets that meet three and more share directors: none may stand across the others."""
    rows = np.concatenate([np.empty(0, np.int64), *seams(cells)])
    if not rows.size:
        return
    at, ends = rows // corner_count(cells), directed_edges(cells)[rows, :2]
    normals = area_vectors(points, cells[at])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    along = np.einsum("kni,ki->kn", directors[ends], normals)
    if along.min() < np.cos(np.radians(STEEPEST)):
        row, end = np.unravel_index(along.argmin(), along.shape)
        angle = np.degrees(np.arccos(np.clip(along.min(), -1.0, 1.0)))
        mend = (
            "it is folded back at a border that both have: join it there to one side alone, by "
            "points of its own"
            if angle > 120.0
            else "lay what is sewn on nearer to a sheet, or give it points of its own"
        )
        raise MeshError(
            f"{source}: at the seam of more than two sheets at point {ends[row, end]} cell "
            f"{at[row]} stands {angle:.0f} degrees off the director that they share, and up to "
            f"{STEEPEST:g} can be computed: {mend}."
        )


def _check_names(surface):
    cells, source = surface.cells, surface.source
    count = len(surface.points)
    width = 3 if cells.shape[1] == 9 else 2
    known = directed_edges(cells)
    known_keys = edge_keys(known, count)
    for name, edge in surface.edges.items():
        if edge.ndim != 2 or edge.shape[1] != width:
            raise MeshError(
                f"{source}: edge '{name}' has the shape {edge.shape}, give one row of {width} "
                "point indices (ends, then the middle of a curved edge) for each segment."
            )
        bad = np.flatnonzero(((edge < 0) | (edge >= count)).any(axis=1))
        if bad.size:
            raise MeshError(
                f"{source}: segment {bad[0]} of edge '{name}' names the points "
                f"{edge[bad[0]].tolist()}, indices must lie in 0 to {count - 1}."
            )
        missing = ~np.isin(edge_keys(edge, count), known_keys)
        if width == 3:
            missing |= ~np.isin(edge[:, 2], known[:, 2])
        if missing.any():
            segment = int(np.argmax(missing))
            raise MeshError(
                f"{source}: segment {segment} of edge '{name}' (points {edge[segment].tolist()}) "
                "is not an edge of any cell, name edges along the sides of cells."
            )
    for name, panel in surface.panels.items():
        bad = np.flatnonzero((panel < 0) | (panel >= len(cells)))
        if panel.ndim != 1 or bad.size:
            found = f"names cell {panel[bad[0]]}" if panel.ndim == 1 else "is not a flat list"
            raise MeshError(
                f"{source}: panel '{name}' {found}, give cell indices in 0 to {len(cells) - 1}."
            )


def _warn_coincident(surface):
    points = surface.points
    pairs = coincident_pairs(points, 1e-9 * diagonal(points))
    if len(pairs) and surface.edges:
        # The lips of an intended slit carry two different names: these need no warning.
        lines = np.zeros((len(surface.edges), len(points)), dtype=bool)
        for line, edge in zip(lines, surface.edges.values()):
            line[edge] = True
        one, other = lines[:, pairs[:, 0]], lines[:, pairs[:, 1]]
        pairs = pairs[~((one & ~other).any(axis=0) & (other & ~one).any(axis=0))]
    if len(pairs):
        warnings.warn(
            f"{surface.source}: {len(np.unique(pairs[:, 1]))} points lie on another point without "
            f"being joined to it (first: points {pairs[0, 0]} and {pairs[0, 1]}); unless this is a "
            "slit, join them with meshes.merge_duplicates(surface), or weld_m = 1e-6 in a scene.",
            stacklevel=5,
        )
