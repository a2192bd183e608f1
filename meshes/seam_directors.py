# SPDX-License-Identifier: LGPL-3.0-or-later
"""Directors at seams of three cells and more: in the middle between the sheets that meet there.

The sheets of a seam share its points and directors, so that what is sewn on at an angle keeps it,
as the parts of a welded tee. The strains measure changes against the rest state, so a director that
leans against a sheet's normal makes no strain of its own; what the cells at the seam feel of
bending goes with the cosine. The mean of the normals, which is right for one sheet, leans 63
degrees against a flap at right angles (two cells of one sheet against one of the other); the axis
of the narrowest cone that holds all normals, their smallest enclosing cap, leans 45.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np

from .geometry import area_vectors
from .sheets import seams
from .topology import directed_edges


def seam_directors(points: np.ndarray, cells: np.ndarray, directors: np.ndarray) -> np.ndarray:
    """The directors (n, 3), those at the ends of seams' sides in the middle between the sheets.

    Parameters
    ----------
    points : (n, 3); cells : (m, k), facing one side sheet by sheet; directors : (n, 3), unit
    """
    crowded = seams(cells)
    if not crowded:
        return directors
    out = directors.copy()
    edges = directed_edges(cells)
    # ends, and the middles of curved sides
    at_seams = np.unique(edges[np.concatenate(crowded)])
    normals = area_vectors(points, cells)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    flat, cell = cells.ravel(), np.repeat(np.arange(len(cells)), cells.shape[1])
    order = np.argsort(flat, kind="stable")
    starts = np.searchsorted(flat[order], [at_seams, at_seams + 1])
    for point, first, last in zip(at_seams, *starts):
        out[point] = cone_axis(normals[cell[order[first:last]]], directors[point])
    return out


def cone_axis(normals: np.ndarray, otherwise: np.ndarray) -> np.ndarray:
    """Axis (3,) of the narrowest cone that holds unit vectors (k, 3).

    It is the middle of two of them, or as far from three; `otherwise` (3,) where they have none.
    """
    found = [normals[:1], (normals[:, None] + normals).reshape(-1, 3)]
    if len(normals) > 2:
        a, b, c = (normals[list(row)] for row in zip(*combinations(range(len(normals)), 3)))
        across = np.cross(b - a, c - a)
        found += [across, -across]
    axes = np.concatenate(found)
    length = np.linalg.norm(axes, axis=1)
    axes = axes[length > 1e-9] / length[length > 1e-9, None]
    widest = (axes @ normals.T).min(axis=1)
    best = int(np.argmax(np.round(widest, 12)))
    return axes[best] if widest[best] > 1e-6 else otherwise
