# SPDX-License-Identifier: LGPL-3.0-or-later
"""What makes triangles the skin of a body, and the sentence for each fault.

A skin has an inside: every edge belongs to two triangles that run along it in opposite senses, and
the volume within is positive. Triangles that are inside-out are turned, and that is told, as it is
told where the skin passes through itself.
"""

import warnings

import numpy as np
from numpy.typing import ArrayLike

from .crossings import crossings

SMALLEST, LARGEST = 5e-3, 50.0  # m: sizes beyond are taken for another unit
MANY = 400_000  # triangles above which a warning tells what they cost
FLAT = 1e-10  # of the area of a triangle over the square of its longest edge


def closed_surface(
    vertices: ArrayLike, triangles: ArrayLike, name: str
) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (nv, 3) float [m] and triangles (nt, 3) int, outward, of a closed surface.

    Raises
    ------
    ValueError
        With the first fault: no numbers, indices without a vertex, triangles without an area,
        edges of one or of more than two triangles, neighbours of opposite senses, a size that is
        of another unit, no volume.

    Warns
    -----
    UserWarning
        Where all triangles were inside-out and are turned, where the surface passes through
        itself, and for more than MANY triangles.
    """
    points = np.array(vertices, float)
    corners = np.array(triangles)
    who = f"surface '{name}'"
    if points.ndim != 2 or points.shape[1] != 3 or len(points) < 4:
        raise ValueError(f"{who} has vertices of the shape {points.shape}, not rows of x, y, z")
    if corners.ndim != 2 or corners.shape[1] != 3 or corners.dtype.kind not in "iu":
        raise ValueError(
            f"{who} has triangles of the shape {corners.shape} and type {corners.dtype}, not rows "
            "of three whole numbers; split larger polygons into triangles"
        )
    corners = corners.astype(np.int64)
    _require_numbers(points, corners, who)
    _require_unit(points, corners, who)
    _require_areas(points, corners, who)
    _require_closed(points, corners, who)
    if volume(points, corners) < 0.0:
        corners = np.ascontiguousarray(corners[:, ::-1])
        warnings.warn(f"{who} was inside-out: all its triangles are turned", stacklevel=4)
    count, (i, j, k) = crossings(points, corners)
    if count:
        place = ", ".join(f"{p:.4g}" for p in 0.5 * (points[i] + points[j]))
        warnings.warn(
            f"{who} passes through itself: {count} edges cross triangles, first that of vertices "
            f"{i} and {j} triangle {k} at ({place}) m; cloth there is held by the nearest part. "
            "If that is near the garment, unite or remesh the surface",
            stacklevel=4,
        )
    if len(corners) > MANY:
        warnings.warn(
            f"{who} has {len(corners)} triangles, and each costs time in every step: reduce them "
            "to 20,000 or so, unless finer folds of the skin matter",
            stacklevel=4,
        )
    return points, corners


def volume(points: np.ndarray, corners: np.ndarray) -> float:
    """Volume [m^3] within closed triangles (nt, 3), negative if they are inside-out."""
    middle = points[corners[0, 0]]
    a, b, c = (points[corners[:, k]] - middle for k in range(3))
    return float(np.sum(a * np.cross(b, c)) / 6.0)


def _require_numbers(points, corners, who):
    bad = ~np.isfinite(points).all(axis=1)
    if bad.any():
        i = int(bad.argmax())
        raise ValueError(
            f"vertex {i} of {who} is at {points[i].tolist()}: mend or remove it in the file"
        )
    if not len(corners):
        raise ValueError(f"{who} has no triangles: export its faces too")
    if corners.min() < 0 or corners.max() >= len(points):
        k = int(((corners < 0) | (corners >= len(points))).any(axis=1).argmax())
        raise ValueError(
            f"triangle {k} of {who} names vertices {corners[k].tolist()}, and there are 0 to "
            f"{len(points) - 1}: mend the file"
        )


def _require_unit(points, corners, who):
    size = float(np.ptp(points[np.unique(corners)], axis=0).max())
    if not SMALLEST <= size <= LARGEST:
        raise ValueError(
            f"{who} is {size:.4g} m long, which tells of another unit: give vertices in metres "
            "(times 0.001 from millimetres)"
        )


def _require_areas(points, corners, who):
    p = points[corners]
    edges = np.roll(p, -1, axis=1) - p
    longest = np.sum(edges**2, axis=2).max(axis=1)
    area = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
    flat = ~(area > FLAT * longest) | (longest == 0.0)
    if flat.any():
        k = int(flat.argmax())
        raise ValueError(
            f"triangle {k} of {who} has no area (vertices {corners[k].tolist()}), as {flat.sum()} "
            "do: merge vertices that coincide and remove such triangles"
        )


def _require_closed(points, corners, who):
    a, b = corners, np.roll(corners, -1, axis=1)
    count = len(points)
    keys = (np.minimum(a, b) * count + np.maximum(a, b)).ravel()
    forward = (a < b).ravel()
    found, which, uses = np.unique(keys, return_inverse=True, return_counts=True)
    for wrong, said in (
        (
            uses == 1,
            "belongs to one triangle only, as {n} do: the surface is open; close its holes, or "
            "merge vertices that coincide",
        ),
        (
            uses > 2,
            "belongs to more than two triangles, as {n} do: remove sheets inside and triangles "
            "that stand twice",
        ),
        (
            np.bincount(which, forward, len(found)) * 2 != uses,
            "is run along in one sense by both its triangles, as {n} are: orient all triangles "
            "alike (recalculate normals)",
        ),
    ):
        if wrong.any():
            first, last = divmod(int(found[wrong.argmax()]), count)
            place = ", ".join(f"{p:.4g}" for p in points[first])
            raise ValueError(
                f"the edge of vertices {first} and {last} of {who}, at ({place}) m, "
                + said.format(n=int(wrong.sum()))
            )
