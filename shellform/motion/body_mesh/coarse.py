# SPDX-License-Identifier: LGPL-3.0-or-later
"""Fewer triangles where no garment of the lower body comes close: soles, toes and the upper end.

Each triangle of a skin is placed in every step, and toes have half of all. Short edges there are
drawn together one after the other, the one that moves the surface least first: by the sum of
squared distances to the planes of the triangles that went into a point (M. Garland and P. S.
Heckbert, SIGGRAPH 97, 209), at an end of the edge or its middle. The surface stays closed: an edge
goes only where its ends have no neighbours in common but the two across from it, and where no
triangle turns over.
"""

import heapq
from dataclasses import replace

import numpy as np

from shellform.motion.proportions import STATURE
from shellform.motion.recording import SIDES

from .lower_body import ABOVE_HIPS
from .surface import BodySurface

EDGE = 0.015  # up to which edges are drawn together, at a stature of STATURE [m]
BELOW_ANKLES, BELOW_CUT = 0.015, 0.03  # where that begins [m]
TURNED = 0.5  # cosine by which a triangle may turn


def coarse_ends(surface: BodySurface) -> BodySurface:
    """The surface of a standing lower body with few triangles on its feet and its upper end."""
    scale = surface.stature / STATURE
    z, top = surface.points[:, 2], surface.middle[2] + (ABOVE_HIPS - BELOW_CUT) * scale
    ankle = min(surface.landmarks[f"{side}_ankle"][2] for side in SIDES)
    return coarsened(surface, (z < ankle - BELOW_ANKLES * scale) | (z > top), EDGE * scale)


def coarsened(surface: BodySurface, part: np.ndarray, size: float) -> BodySurface:
    """The surface, edges shorter than `size` [m] between points of a `part` (n,) bool gone."""
    points = [np.array(point) for point in surface.points]
    faces = {k: list(map(int, face)) for k, face in enumerate(surface.triangles)}
    around: list[set[int]] = [set() for _ in points]
    for k, face in faces.items():
        for i in face:
            around[i].add(k)
    quadrics = _quadrics(surface)
    heap: list[tuple[float, int, int, int]] = []
    age = [0] * len(points)

    def neighbours(i):
        return {j for k in around[i] for j in faces[k]} - {i}

    def offer(i, j):
        if part[i] and part[j] and np.linalg.norm(points[i] - points[j]) < size:
            heapq.heappush(heap, (_place(points, quadrics, i, j)[0], i, j, age[i] + age[j]))

    for a, b in {
        (min(e), max(e)) for f in faces.values() for e in zip(f, f[1:] + f[:1], strict=True)
    }:
        offer(a, b)
    while heap:
        _, i, j, when = heapq.heappop(heap)
        both = around[i] & around[j]
        # an edge that is gone, or was offered before its ends moved
        if len(both) != 2 or when != age[i] + age[j]:
            continue
        if len(neighbours(i) & neighbours(j)) != 2:
            continue
        place = _place(points, quadrics, i, j)[1]
        if _turns(points, [faces[k] for k in (around[i] | around[j]) - both], (i, j), place):
            continue
        points[i], quadrics[i] = place, quadrics[i] + quadrics[j]
        for k in both:
            for other in faces.pop(k):
                around[other].discard(k)
        for k in around[j]:
            faces[k][faces[k].index(j)] = i
        around[i], around[j] = around[i] | around[j], set()
        age[i] += 1
        for other in sorted(neighbours(i)):
            offer(*sorted((i, other)))
    triangles = np.array([faces[k] for k in sorted(faces)])
    used, inverse = np.unique(triangles, return_inverse=True)
    return replace(surface, points=np.array(points)[used], triangles=inverse.reshape(-1, 3))


def _quadrics(surface):
    """Matrices (n, 4, 4) of the sums of squared distances to the planes around the points."""
    a, b, c = (surface.points[surface.triangles[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    area = np.linalg.norm(normal, axis=1, keepdims=True)
    plane = np.column_stack([normal, -np.sum(normal * a, axis=1)]) / np.sqrt(area)
    out = np.zeros((len(surface.points), 4, 4))
    for k in range(3):
        np.add.at(out, surface.triangles[:, k], plane[:, :, None] * plane[:, None, :])
    return out / surface.stature**2


def _place(points, quadrics, i, j):
    """What it costs to draw an edge together, and where that is least."""
    matrix = quadrics[i] + quadrics[j]
    places = [0.5 * (points[i] + points[j]), points[i], points[j]]
    costs = [float(p @ matrix[:3, :3] @ p + 2 * matrix[:3, 3] @ p + matrix[3, 3]) for p in places]
    least = int(np.argmin(costs))
    return costs[least], places[least]


def _turns(points, faces, moved, place):
    """Whether a face turns by too much as its corner out of `moved` comes to a place."""
    before = np.array([[points[i] for i in face] for face in faces])
    after = np.array([[place if i in moved else points[i] for i in face] for face in faces])
    one, other = (np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]) for p in (before, after))
    sizes = np.linalg.norm(one, axis=1) * np.linalg.norm(other, axis=1)
    return bool((np.sum(one * other, axis=1) <= TURNED * sizes).any())
