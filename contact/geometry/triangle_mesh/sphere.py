# SPDX-License-Identifier: LGPL-3.0-or-later
"""Spheres of triangles: octahedra divided again and again, or as fine as a sagitta asks."""

import numpy as np


def sphere(radius: float, divisions: int) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (nv, 3) [m] on a sphere, triangles (nt, 3) int, outward.

    divisions : each triangle of an octahedron is divided into 4, so often

    Examples
    --------
    >>> vertices, triangles = sphere(0.1, 2)
    >>> len(vertices), len(triangles)
    (66, 128)
    """
    eye = np.eye(3)
    points = [*eye, *-eye]
    faces = [
        (0, 1, 2), (1, 3, 2), (3, 4, 2), (4, 0, 2), (1, 0, 5), (3, 1, 5), (4, 3, 5), (0, 4, 5),
    ]  # fmt: skip
    vertices, triangles = np.array(points), np.array(faces)
    for _ in range(divisions):
        ends = np.sort(
            np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2), axis=1
        )
        edges, which = np.unique(ends, axis=0, return_inverse=True)
        middles = (len(vertices) + which).reshape(-1, 3)
        vertices = np.vstack([vertices, vertices[edges].mean(axis=1)])
        (a, b, c), (ab, bc, ca) = triangles.T, middles.T
        parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        triangles = np.concatenate([np.column_stack(part) for part in parts])
        vertices /= np.linalg.norm(vertices, axis=1, keepdims=True)
    return radius * vertices, triangles
