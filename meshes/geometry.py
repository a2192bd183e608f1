"""Lengths, areas and normals of cells, straight or curved, from their nodes alone.

All rests on one quantity: the cross product of the two surface tangents at each node of a cell,
with the unit square (or the unit right triangle) as reference cell. Nodal quadrature of it gives
the area, its direction the normal, its sign against the mean tells a folded cell.
"""
# SPDX-License-Identifier: LGPL-3.0-or-later

from __future__ import annotations

import numpy as np

from .topology import corner_count

# Trapezoid rule for straight cells (exact for flat ones), Simpson's rule for 9-node cells.
_NODE_WEIGHTS = {
    3: np.full(3, 1.0 / 6.0),
    4: np.full(4, 1.0 / 4.0),
    9: np.array([1.0, 1.0, 1.0, 1.0, 4.0, 4.0, 4.0, 4.0, 16.0]) / 36.0,
}


def corner_tangents(points: np.ndarray, cells: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Tangents at each corner along the edges to the next and to the previous corner.

    Two arrays (m, corners, 3); their lengths are the edge lengths of straight cells.
    """
    count = corner_count(cells)
    corners = points[cells[:, :count]]
    following = np.roll(corners, -1, axis=1)
    previous = np.roll(corners, 1, axis=1)
    if cells.shape[1] == 9:
        middles = points[cells[:, 4:8]]
        onward = 4.0 * middles - 3.0 * corners - following
        back = 4.0 * np.roll(middles, 1, axis=1) - 3.0 * corners - previous
        return onward, back
    return following - corners, previous - corners


def node_crosses(points: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """Cross product of the surface tangents at each node of each cell, (m, nodes, 3)."""
    onward, back = corner_tangents(points, cells)
    crosses = np.cross(onward, back)
    if cells.shape[1] != 9:
        return crosses
    corners, middles = points[cells[:, :4]], points[cells[:, 4:8]]
    centre = points[cells[:, 8:9]]
    along = np.roll(corners, -1, axis=1) - corners
    inward = 4.0 * centre - 3.0 * middles - np.roll(middles, 2, axis=1)
    at_centre = np.cross(middles[:, 1] - middles[:, 3], middles[:, 2] - middles[:, 0])
    return np.concatenate([crosses, np.cross(along, inward), at_centre[:, None]], axis=1)


def widest_corners(points: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """Largest angle [degrees] (cells,) between the straight sides at the corners of each cell."""
    corners = points[cells[:, : 3 if cells.shape[1] == 3 else 4]]
    sides = np.roll(corners, -1, axis=1) - corners
    behind = np.roll(sides, 1, axis=1)  # runs towards the corner
    lengths = np.linalg.norm(sides, axis=2)
    cosine = -np.einsum("mni,mni->mn", sides, behind) / (lengths * np.roll(lengths, 1, axis=1))
    return np.degrees(np.arccos(np.clip(cosine.min(axis=1), -1.0, 1.0)))


def cell_areas(points: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """Area of each cell (m,)."""
    lengths = np.linalg.norm(node_crosses(points, cells), axis=2)
    return lengths @ _NODE_WEIGHTS[cells.shape[1]]


def area_vectors(points: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """Mean normal of each cell times its (projected) area, (m, 3)."""
    return np.einsum("mni,n->mi", node_crosses(points, cells), _NODE_WEIGHTS[cells.shape[1]])


def cell_centres(points: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """Centre point of each cell (m, 3)."""
    return points[cells[:, 8]] if cells.shape[1] == 9 else points[cells].mean(axis=1)


def sum_at_points(values: np.ndarray, cells: np.ndarray, count: int) -> np.ndarray:
    """Sum of cell-node values (m, nodes, 3) at each of ``count`` points, (count, 3)."""
    flat = cells.ravel()
    columns = values.reshape(-1, 3).T
    return np.stack([np.bincount(flat, column, count) for column in columns], axis=1)


def mean_normals(points: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """Angle-weighted sum of the cells' unit normals at each point (n, 3), not normalised."""
    crosses = node_crosses(points, cells)
    lengths = np.linalg.norm(crosses, axis=2, keepdims=True)
    normals = np.divide(crosses, lengths, out=np.zeros_like(crosses), where=lengths > 0.0)
    onward, back = corner_tangents(points, cells)
    count = corner_count(cells)
    # Weighting by the corner angle makes the mean independent of how the faces are cut up.
    # Without gaps: else the last digit of an arc tangent depends on where in memory they lie.
    sines = np.ascontiguousarray(lengths[:, :count, 0])
    angles = np.arctan2(sines, np.einsum("mni,mni->mn", onward, back))
    normals[:, :count] *= angles[:, :, None]
    return sum_at_points(normals, cells, len(points))


def nodal_normals(points: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """Unit normal at each point (n, 3): the angle-weighted mean of the cells' normals there.

    For 9-node cells these are the exact normals of the isoparametric surface at the node. Raises
    ValueError naming a point where the mean vanishes (cells folded flat onto each other).
    """
    normals = mean_normals(points, cells)
    lengths = np.linalg.norm(normals, axis=1)
    flat = np.flatnonzero(lengths < 1e-8)
    if flat.size:
        raise ValueError(
            f"the cells around point {flat[0]} fold back on themselves and have no mean normal"
        )
    return normals / lengths[:, None]


def diagonal(points: np.ndarray) -> float:
    """Length of the diagonal of the bounding box."""
    return float(np.linalg.norm(points.max(axis=0) - points.min(axis=0)))


def coincident_pairs(points: np.ndarray, tolerance: float) -> np.ndarray:
    """All pairs (k, 2) of points no further apart than ``tolerance``."""
    # Sorted along a direction that no mesh line shares, close points are neighbours in the list;
    # comparing at growing distance in the list stops as soon as no projection is close enough.
    heights = points @ np.array([0.5773, 0.6180, 0.5332])
    order = np.argsort(heights, kind="stable")
    heights = heights[order]
    found = [np.empty((0, 2), dtype=np.int64)]
    for lag in range(1, len(points)):
        near = np.flatnonzero(heights[lag:] - heights[:-lag] <= tolerance)
        if near.size == 0:
            break
        pairs = np.stack([order[near], order[near + lag]], axis=1)
        apart = np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1)
        found.append(np.sort(pairs[apart <= tolerance], axis=1))
    return np.concatenate(found)


def joined(points: np.ndarray, tolerance: float) -> np.ndarray:
    """For each point (n,) the lowest of those it is joined to by steps of at most `tolerance`."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    pairs = cKDTree(points).query_pairs(tolerance, output_type="ndarray")
    n = len(points)
    graph = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(n, n))
    _, piece = connected_components(graph, directed=False)
    lowest = np.full(n, n)
    np.minimum.at(lowest, piece, np.arange(n))
    return lowest[piece]
