# SPDX-License-Identifier: LGPL-3.0-or-later
"""Thick sheets: two copies of the cloth face each other, a few millimetres apart, closed at rims.

Programs that draw cloth export it so for pictures. As a shell it would be two garments in one, with
twice the weight. What faces each other is found by centres of cells and normals; of each pair of
sheets the larger stays and is moved half-way to the other, the rims go.
"""

from __future__ import annotations

import warnings

import numpy as np

from .geometry import area_vectors, cell_areas, cell_centres, nodal_normals
from .repair import boundary_loops, clean, orient
from .surface import Surface
from .topology import neighbours
from .validity import MeshError

THICKEST = 0.02  # m; sheets farther apart are front and back of a garment
COVERED = 0.7  # of the area that faces another sheet, for a thick one


def facing_cells(surface: Surface) -> tuple[np.ndarray, np.ndarray]:
    """For each cell (m,) the cell behind it that faces the other way, or -1, and its distance [m].

    A cell is behind another if its centre lies against the other's normal, within THICKEST.
    """
    from scipy.spatial import cKDTree

    points, cells = surface.points, surface.cells
    centres, vectors = cell_centres(points, cells), area_vectors(points, cells)
    normals = vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
    tree = cKDTree(centres)
    reach = np.sqrt(THICKEST**2 + 0.25 * cell_areas(points, cells))
    best, distance = np.full(len(cells), -1), np.full(len(cells), np.inf)
    count = min(12, len(cells))
    _, near = tree.query(centres, count)
    for other in near.reshape(len(cells), -1).T:
        step = centres[other] - centres
        depth = -np.einsum("ij,ij->i", step, normals)
        aside = np.linalg.norm(step + depth[:, None] * normals, axis=1)
        opposed = np.einsum("ij,ij->i", normals, normals[other]) < -0.7
        fits = opposed & (np.abs(depth) < THICKEST) & (aside < 0.7 * reach)
        closer = fits & (np.abs(depth) < distance)
        best[closer], distance[closer] = other[closer], np.abs(depth)[closer]
    return best, distance


def thickness(surface: Surface) -> float:
    """Thickness [m] of a thick sheet, 0 for a surface that is none."""
    if surface.degree != 1 or len(surface.cells) < 4 or boundary_loops(surface):
        return 0.0
    other, distance = facing_cells(surface)
    areas = surface.cell_areas
    if areas[other >= 0].sum() < COVERED * areas.sum():
        return 0.0
    return float(np.median(distance[other >= 0]))


def tell_thick(surface: Surface) -> None:
    """Warn of a thick sheet, naming the mend."""
    thick = thickness(surface)
    if thick:
        warnings.warn(
            f"{surface.source}: the mesh is closed and most of it lies {1e3 * thick:.2g} mm before "
            "another part of it, as cloth exported with its thickness: its area counts twice; "
            "midsurface=True in meshes.load, midsurface = true under [garment], takes the surface "
            "between.",
            stacklevel=2,
        )


def middle_surface(surface: Surface) -> Surface:
    """The surface in the middle of a thick sheet, without its rims; named edges are lost.

    Raises
    ------
    MeshError : for a surface that is no thick sheet.
    """
    thick = thickness(surface)
    if not thick:
        raise MeshError(
            f"{surface.source}: there is no middle surface, for the mesh is not a closed sheet of "
            f"even thickness up to {1e3 * THICKEST:g} mm; leave midsurface out."
        )
    other, distance = facing_cells(surface)
    sheet = _sheets(surface.cells, other >= 0)
    areas = np.bincount(sheet[sheet >= 0], surface.cell_areas[sheet >= 0])
    kept = np.zeros(len(areas), bool)
    for number in np.argsort(-areas):
        behind = sheet[other[sheet == number]]
        # the larger of two sheets that face each other comes first
        kept[number] = not kept[np.bincount(behind[behind >= 0], minlength=len(areas)).argmax()]
    cells = surface.cells[(sheet >= 0) & kept[sheet]]
    points = surface.points.copy()
    corners, number = np.unique(cells, return_inverse=True)
    depth = np.repeat(distance[(sheet >= 0) & kept[sheet]], cells.shape[1])
    depth = np.bincount(number.ravel(), depth) / np.bincount(number.ravel())
    normals = nodal_normals(points, surface.cells[sheet >= 0])[corners]
    points[corners] -= 0.5 * depth[:, None] * normals
    where = np.flatnonzero((sheet >= 0) & kept[sheet])
    warp = surface.warp if surface.warp is None or surface.warp.ndim == 1 else surface.warp[where]
    warnings.warn(
        f"{surface.source}: the surface in the middle of a sheet {1e3 * thick:.2g} mm thick is "
        f"taken, {len(cells)} of {len(surface.cells)} cells.",
        stacklevel=2,
    )
    middle = surface.replace(
        points=points, cells=cells, edges={}, panels={}, warp=warp, verify=False
    )
    return orient(clean(middle), majority=True).replace(verify=True)


def _sheets(cells: np.ndarray, faced: np.ndarray) -> np.ndarray:
    """Number of the connected sheet of cells that face another (m,), -1 for rims."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    pairs, _ = neighbours(cells)
    pairs = pairs[faced[pairs].all(axis=1)]
    graph = coo_matrix((np.ones(len(pairs)), pairs.T), shape=(len(cells),) * 2)
    _, number = connected_components(graph, directed=False)
    out = np.full(len(cells), -1)
    out[faced] = np.unique(number[faced], return_inverse=True)[1]
    return out
