# SPDX-License-Identifier: LGPL-3.0-or-later
"""Where a surface goes through itself: sides of cells that pierce other cells.

Cells are taken as two triangles. Pairs that are near each other come from a tree of the middles; a
side pierces a triangle if its ends lie on both sides of the plane and its line passes within
(Moeller and Trumbore, J. Graphics Tools 2, 1997). Cells with a common point are left out.
"""

from __future__ import annotations

import numpy as np

from meshes.topology import corner_count, directed_edges, unique_edges


def crossings(points: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """Pairs (k, 3) of a side's two ends and the cell that it pierces.

    Parameters
    ----------
    points : (n, 3); cells : (m, 3) or (m, 4)
    """
    from scipy.spatial import cKDTree

    count = corner_count(cells)
    rows = directed_edges(cells)
    first, *_ = unique_edges(rows, len(points))
    sides = rows[first][:, :2]
    faces = [[0, 1, 2]] if count == 3 else [[0, 1, 2], [0, 2, 3]]
    corners = points[cells[:, :count]]
    middles = corners.mean(axis=1)
    reach = np.linalg.norm(corners - middles[:, None], axis=2).max()
    half = 0.5 * np.linalg.norm(points[sides[:, 1]] - points[sides[:, 0]], axis=1).max()
    tree = cKDTree(middles)
    near = tree.query_ball_point(points[sides].mean(axis=1), reach + half)
    side = np.repeat(np.arange(len(sides)), [len(cell) for cell in near])
    cell = np.concatenate([np.asarray(c, np.int64) for c in near])
    apart = ~(cells[cell][:, :, None] == sides[side][:, None, :]).any(axis=(1, 2))
    side, cell = side[apart], cell[apart]
    hit = np.zeros(len(side), bool)
    for face in faces:
        hit |= _pierced(points[sides[side]], points[cells[cell][:, face]])
    return np.column_stack([sides[side[hit]], cell[hit]])


def _pierced(line, triangle):
    """Whether lines (k, 2, 3) pass through triangles (k, 3, 3)."""
    start, along = line[:, 0], line[:, 1] - line[:, 0]
    one, two = triangle[:, 1] - triangle[:, 0], triangle[:, 2] - triangle[:, 0]
    p = np.cross(along, two)
    size = np.sum(one * p, axis=1)
    level = np.abs(size) < 1e-30
    size = np.where(level, 1.0, size)
    s = start - triangle[:, 0]
    q = np.cross(s, one)
    u, v = np.sum(s * p, axis=1) / size, np.sum(along * q, axis=1) / size
    t = np.sum(two * q, axis=1) / size
    return ~level & (u > 0) & (v > 0) & (u + v < 1) & (t > 0) & (t < 1)
