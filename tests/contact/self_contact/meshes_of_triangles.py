# SPDX-License-Identifier: LGPL-3.0-or-later
"""Small sheets of triangles as arrays, and a checker of intersections that knows none of ours."""

import numpy as np

from contact.self_contact.features import features


def sheet(cells, size=1.0, height=0.0, turn=0.0, wave=0.0):
    """Points (n, 3) and triangles (m, 3) of a square around the origin."""
    k = cells + 1
    s = np.linspace(-0.5, 0.5, k) * size
    x, y = (a.ravel() for a in np.meshgrid(s, s, indexing="ij"))
    z = height + wave * np.sin(9 * x) * np.cos(7 * y)
    points = np.stack([np.cos(turn) * x - np.sin(turn) * y, np.sin(turn) * x + np.cos(turn) * y, z])
    corner = (np.arange(cells)[:, None] * k + np.arange(cells)).ravel()
    quads = np.stack([corner, corner + k, corner + k + 1, corner + 1], axis=1)
    return points.T.copy(), np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])


def together(*sheets):
    """Points and triangles of several sheets."""
    points, cells, n = [], [], 0
    for x, triangles in sheets:
        points.append(x)
        cells.append(triangles + n)
        n += len(x)
    return np.concatenate(points), np.concatenate(cells)


def featured(points, triangles):
    return features(triangles, np.arange(len(points)))


def edges_of(triangles):
    ends = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    return np.unique(np.sort(ends, axis=1), axis=0)


def crossings(points, triangles):
    """Edges through triangles without a common node: by solving for the point, all with all."""
    edges, count = edges_of(triangles), 0
    a, b, c = (points[triangles[:, k]] for k in range(3))
    for p, q in edges:
        other = ~((triangles == p) | (triangles == q)).any(axis=1)
        low, high = np.minimum(points[p], points[q]), np.maximum(points[p], points[q])
        corners = points[triangles]
        other &= (corners.min(axis=1) <= high).all(axis=1)
        other &= (corners.max(axis=1) >= low).all(axis=1)
        for f in np.flatnonzero(other):
            way = points[q] - points[p]
            system = np.stack([-way, b[f] - a[f], c[f] - a[f]], axis=1)
            if abs(np.linalg.det(system)) < 1e-30:
                continue
            t, u, w = np.linalg.solve(system, points[p] - a[f])
            count += 0 < t < 1 and u > 0 and w > 0 and u + w < 1
    return count
