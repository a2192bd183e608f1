# SPDX-License-Identifier: LGPL-3.0-or-later
"""The part of a body that a garment of the lower body comes to: trunk up to the ribs, and legs.

The body is cut level some way above the hips, below the armpits; what then hangs on nothing, as
hands, is left out, and the hole is closed by a dome: the surface stays closed, so
inside and outside stay known.
"""

from dataclasses import replace

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from meshes.topology import boundary_segments, chain
from shellform.motion.proportions import STATURE

from .surface import BodySurface, kept_triangles

ABOVE_HIPS = 0.30  # of the cut, at a stature of STATURE [m]
DOME, RINGS = 0.06, 6  # height of what closes it [m], and its rings


def lower_body(surface: BodySurface) -> BodySurface:
    """The surface without what is more than ABOVE_HIPS above the hips, closed again.

    Raises
    ------
    ValueError where the cut leaves no trunk with both legs
    """
    level = surface.middle[2] + ABOVE_HIPS * surface.stature / STATURE
    low = surface.points[:, 2] <= level
    part = kept_triangles(surface, low[surface.triangles].all(axis=1))
    if len(part.triangles) == 0:
        raise ValueError(f"{surface.source}: nothing of it is below {level:.2f} m")
    pieces = _pieces(part)
    trunk = pieces[np.argmin(np.linalg.norm(part.points - part.middle, axis=1))]
    return capped(kept_triangles(part, pieces[part.triangles[:, 0]] == trunk))


def _pieces(surface):
    """Number (n,) of the connected piece of every point."""
    t = surface.triangles
    pairs = np.concatenate([t[:, [0, 1]], t[:, [1, 2]]])
    n = len(surface.points)
    graph = coo_matrix((np.ones(len(pairs)), pairs.T), shape=(n, n))
    return connected_components(graph, directed=False)[1]


def _holes(triangles):
    """Closed lines of points around the holes, the surface on their left."""
    edges = chain(boundary_segments(triangles))
    ends = np.flatnonzero(edges[1:, 0] != edges[:-1, 1]) + 1
    return [loop[:, 0] for loop in np.split(edges, ends)] if len(edges) else []


def capped(surface: BodySurface) -> BodySurface:
    """The surface with each of its holes made level and closed by a dome upright on it.

    A dome has no sharp edge, near which a smooth surface would be far from its triangles.
    """
    points, triangles = surface.points.copy(), [surface.triangles]
    height = DOME * surface.stature / STATURE
    for loop in _holes(surface.triangles):
        points[loop, 2] = points[loop, 2].mean()
        middle, ring = points[loop].mean(axis=0), loop
        for angle in np.linspace(0.0, 0.5 * np.pi, RINGS + 1)[1:-1]:
            above = middle + np.cos(angle) * (points[loop] - middle)
            above[:, 2] += height * np.sin(angle)
            after = np.arange(len(points), len(points) + len(loop))
            points = np.concatenate([points, above])
            # a hole's edges run with the surface on their left: the dome runs against them
            one, other = np.roll(ring, -1), np.roll(after, -1)
            triangles += [np.stack([one, ring, after], 1), np.stack([one, after, other], 1)]
            ring = after
        top = np.full(len(loop), len(points))
        points = np.concatenate([points, [middle + [0.0, 0.0, height]]])
        triangles.append(np.stack([np.roll(ring, -1), ring, top], axis=1))
    return replace(surface, points=points, triangles=np.concatenate(triangles))
