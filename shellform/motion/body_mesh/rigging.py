# SPDX-License-Identifier: LGPL-3.0-or-later
r"""Weights of the segments on a body of triangles, from the centres of its joints alone.

A point turns with the segment below a joint by a part w of the bend t. Seen from the side, in polar
coordinates about the joint, it goes from angle a to a + w t, and its distance stays. So w is made a
function of the angle from the level of the joint,

    a = atan(h / sqrt(f^2 + b^2)),   w = (1 - S((a - a0) / A)) / 2,

h the height over the joint along the straight limb, f how far before or behind it, b a width within
which the sides of the limb count as its axis. Skin then never folds while t dw/da < 1, which steep
weights along the limb violate from some 60 degrees on: with A of 60 degrees up to 108 (1 + b^2 /
f^2)^1/2 degrees, and farther where flesh is pressed flat: knees of the installed bodies at 135.
S is -1 to 1 with a slope that is constant but for its ends. The wider A, the more flesh a bent knee
takes from the calf; a hip's b is wide because the groin is 0.10 m before the joint.

Between the legs a point belongs to the trunk by how far it is from the middle plane along the skin.
"""

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from shellform.motion.proportions import SIGN, STATURE
from shellform.motion.recording import SEGMENTS, SIDES

from .surface import BodySurface

UP = np.array([0.0, 0.0, 1.0])
ROUND = 0.2  # part of the range over which the slope of S comes and goes
# joint: middle a0 and half A of the range [degree]; width b at a stature of STATURE [m]
RANGES = {"hip": (0.0, 75.0, 0.120), "knee": (4.0, 60.0, 0.025), "ankle": (30.0, 45.0, 0.015)}
CROTCH = 0.160  # along the skin from the middle plane to what is a leg's alone [m]


def ramp(u: np.ndarray) -> np.ndarray:
    """(1 - S(u)) / 2: 1 below u = -1, 0 above 1."""
    slope, size = 1.0 / (1.0 - 0.5 * ROUND), np.minimum(np.abs(u), 1.0)
    end = 1.0 - slope * (1.0 - size) ** 2 / (2.0 * ROUND)
    return 0.5 * (1.0 - np.sign(u) * np.where(size < 1.0 - ROUND, slope * size, end))


def below(
    points: np.ndarray, joint: np.ndarray, up: np.ndarray, left: np.ndarray, name: str, scale: float
) -> np.ndarray:
    """Part (n,) of a joint's bend that points (n, 3) follow.

    up : (3,) along the straight limb; left : (3,), the axis that the joint bends about
    """
    middle, half, width = RANGES[name]
    up = up / np.linalg.norm(up)
    ahead = np.cross(left, up)
    arm = points - joint
    across = np.hypot(arm @ (ahead / np.linalg.norm(ahead)), width * scale)
    return ramp((np.degrees(np.arctan2(arm @ up, across)) - middle) / half)


def weights_of(surface: BodySurface) -> np.ndarray:
    """Weights (n, 7) of the segments of a standing body, in the order of SEGMENTS."""
    points, marks, scale = surface.points, surface.landmarks, surface.stature / STATURE
    weights = np.zeros((len(points), len(SEGMENTS)))
    aside = (points - surface.middle) @ surface.left
    u = np.clip(along_skin(points, surface.triangles, aside) / (CROTCH * scale), 0.0, 1.0)
    of_leg = u * u * (3.0 - 2.0 * u)
    for side in SIDES:
        hip, knee, ankle = (marks[f"{side}_{joint}"] for joint in ("hip", "knee", "ankle"))
        thigh = (hip - knee) / np.linalg.norm(hip - knee)
        leg = below(points, hip, UP + thigh, surface.left, "hip", scale) * of_leg
        leg *= SIGN[side] * aside > 0
        shin = below(points, knee, hip - ankle, surface.left, "knee", scale)
        foot = below(points, ankle, knee - ankle, surface.left, "ankle", scale)
        shares = {"thigh": 1.0 - shin, "shank": shin * (1.0 - foot), "foot": shin * foot}
        for part, share in shares.items():
            weights[:, SEGMENTS.index(f"{side}_{part}")] = leg * share
    weights[:, SEGMENTS.index("pelvis")] = 1.0 - weights.sum(axis=1)
    return weights


def along_skin(points: np.ndarray, triangles: np.ndarray, aside: np.ndarray) -> np.ndarray:
    """Distance (n,) [m] along edges from where the skin crosses the plane aside = 0 (n,) [m]."""
    t = triangles
    edges = np.concatenate([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]])
    ends = aside[edges]
    crossing = edges[ends[:, 0] * ends[:, 1] <= 0.0]
    start, n = np.unique(crossing), len(points)
    # one more point stands for the plane itself
    long = np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1)
    rows = np.concatenate([edges[:, 0], np.full(len(start), n)])
    columns = np.concatenate([edges[:, 1], start])
    size = np.concatenate([long, np.abs(aside[start]) + 1e-9])
    # an edge of an open surface stands once, others twice: sums would count them double
    _, first = np.unique(rows * (n + 1) + columns, return_index=True)
    graph = coo_matrix((size[first], (rows[first], columns[first])), shape=(n + 1, n + 1)).tocsr()
    return dijkstra(graph, False, indices=n)[:n]
