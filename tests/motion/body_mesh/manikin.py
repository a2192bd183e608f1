# SPDX-License-Identifier: LGPL-3.0-or-later
"""A made-up body for tests: elliptic rings of trunk and legs, closed, legs a little apart.

Axes and unit are ours: x forward, y left, z up, in metres, the floor at 0.
"""

import itertools

import numpy as np

from shellform.motion.body_mesh.surface import BodySurface

ROUND, CROTCH = 24, 3  # points around the trunk; between the legs in a row
HIP, KNEE, ANKLE, TOP, FORK = 0.92, 0.495, 0.075, 1.75, 0.84
APART = 0.10, 0.14, 0.17  # of hip, knee and ankle from the middle


def manikin() -> BodySurface:
    """The body with its joints, of a stature of 1.75 m."""
    points, faces = [], []

    def ring(rows):
        first = len(points)
        points.extend(rows)
        return np.arange(first, len(points))

    angle = 2 * np.pi * np.arange(ROUND) / ROUND  # from the front to the left
    trunk = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    rings = []
    for z in np.linspace(FORK, TOP - 0.1, 28):
        depth = np.interp(z, [FORK, 0.92, 1.05, 1.4, TOP], [0.11, 0.125, 0.105, 0.12, 0.09])
        width = np.interp(z, [FORK, 0.92, 1.05, 1.4, TOP], [0.185, 0.175, 0.15, 0.17, 0.09])
        rings.append(ring(np.column_stack([trunk * [depth, width], np.full(ROUND, z)])))
    _close(points, faces, rings, up=True)
    # between front and back of the lowest ring, shared by both legs
    x = np.linspace(1, -1, CROTCH + 2)[1:-1, None] * [0.11, 0.0]
    middle = ring(np.column_stack([x, np.full(CROTCH, FORK + 0.01)]))
    marks = {}
    for side, sign in (("right", -1.0), ("left", 1.0)):
        half = rings[0][: ROUND // 2 + 1] if sign > 0 else rings[0][ROUND // 2 :]
        half = half if sign > 0 else np.append(half, rings[0][0])
        top = np.append(half, middle[::-1] if sign > 0 else middle)
        legs = [top]
        around = 2 * np.pi * np.arange(len(top)) / len(top)
        turn = around if sign > 0 else around + np.pi
        unit = np.stack([np.cos(turn), np.sin(turn)], axis=1)
        for z in np.concatenate([np.linspace(0.80, 0.10, 46), [0.06, 0.025, 0.0]]):
            y = sign * np.interp(z, [ANKLE, KNEE, HIP], APART[::-1])
            size = np.interp(z, [0.1, 0.35, 0.495, 0.82], [0.037, 0.06, 0.06, 0.096])
            ahead, long = (0.0, size) if z >= 0.1 else (0.07, 0.135)
            wide = size if z >= 0.1 else 0.045
            level = unit * [long, wide] + [ahead, y]
            legs.append(ring(np.column_stack([level, np.full(len(top), z)])))
        _close(points, faces, legs, up=False)
        for name, z, y in zip(("hip", "knee", "ankle"), (HIP, KNEE, ANKLE), APART, strict=True):
            marks[f"{side}_{name}"] = np.array([0.0, sign * y, z])
    return BodySurface(np.array(points), np.array(faces), marks, TOP, "manikin")


def _close(points, faces, rings, up):
    """Triangles between rings, and a fan over the last one."""
    for low, high in itertools.pairwise(rings):
        low, high = (low, high) if up else (high, low)
        for a, b, c, d in zip(low, np.roll(low, -1), np.roll(high, -1), high, strict=True):
            faces.extend([(a, b, c), (a, c, d)])
    last = rings[-1]
    points.append(np.mean([points[i] for i in last], axis=0))
    for a, b in zip(last, np.roll(last, -1), strict=True):
        faces.append((a, b, len(points) - 1) if up else (b, a, len(points) - 1))
