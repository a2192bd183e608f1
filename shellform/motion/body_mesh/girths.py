# SPDX-License-Identifier: LGPL-3.0-or-later
"""Girths of a body of triangles: what a tape measures, the convex hull of a level slice.

The wearer stands upright, so the slice is level. Heights of the measures are those of ANSUR II
(Gordon et al., NATICK/TR-15/007): omphalion, buttock point, gluteal fold, the thigh just above the
kneecap, and where calf and ankle are thickest and thinnest.
"""

from collections.abc import Mapping

import numpy as np
from scipy.spatial import ConvexHull

from shellform.motion.anthropometry import THIGH, WAIST
from shellform.motion.proportions import STATURE
from shellform.motion.recording import SIDES

from .surface import BodySurface

NAMES = ("waist", "hip", "thigh", "knee", "calf", "ankle")
HIP = -0.035  # buttock point, up from the hip centres, which stand 0.92 m above the floor [m]
KNEE = 0.045  # upper edge of the kneecap, up from the knee centre [m]
CALF, ANKLE = (0.15, 0.50), (0.70, 0.95)  # where on the shank they are looked for, of its length
ON_TRUNK = ("waist", "hip")


def slice_points(surface: BodySurface, level: float, keep: np.ndarray) -> np.ndarray:
    """Points (k, 2), x and y, where the plane z = level [m] cuts edges of some triangles (m,)."""
    triangles = surface.triangles[keep]
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    ends = surface.points[edges]
    up = ends[:, :, 2] - level
    cut = up[:, 0] * up[:, 1] < 0
    part = (up[cut, 0] / (up[cut, 0] - up[cut, 1]))[:, None]
    return (ends[cut, 0] + part * (ends[cut, 1] - ends[cut, 0]))[:, :2]


def leg_triangles(surface: BodySurface, side: str) -> np.ndarray:
    """Triangles (m,) bool of a leg: those nearer to it than to the other one."""
    outward = surface.landmarks[f"{side}_hip"] - surface.middle
    return ((surface.points - surface.middle) @ outward > 0)[surface.triangles].any(axis=1)


def levels(surface: BodySurface) -> dict[str, float]:
    """Heights z [m] of the measures on a standing body."""
    scale = surface.stature / STATURE
    at = {name: _mean(surface, name) for name in ("hip", "knee", "ankle")}
    out = {
        "waist": at["hip"] + WAIST * scale,
        "hip": at["hip"] + HIP * scale,
        "thigh": at["hip"] + THIGH * scale,
        "knee": at["knee"] + KNEE * scale,
    }
    for name, (first, last), pick in (("calf", CALF, np.argmax), ("ankle", ANKLE, np.argmin)):
        part = np.linspace(first, last, 36)
        heights = at["knee"] + part * (at["ankle"] - at["knee"])
        around = [girth(surface, name, float(height)) for height in heights]
        out[name] = float(heights[pick(around)])
    return out


def _mean(surface, joint):
    """Height [m] of a joint, of both sides."""
    return float(np.mean([surface.landmarks[f"{side}_{joint}"][2] for side in SIDES]))


def girth(surface: BodySurface, name: str, level: float) -> float:
    """Girth [m] at a height z [m]: of the trunk for waist and hip, else the mean of both legs.

    Raises
    ------
    ValueError where the plane does not cut the body
    """
    if name in ON_TRUNK:
        parts = [np.ones(len(surface.triangles), bool)]
    else:
        parts = [leg_triangles(surface, side) for side in SIDES]
    around = []
    for part in parts:
        points = slice_points(surface, level, part)
        if len(points) < 3:
            raise ValueError(f"{surface.source} has no {name} at a height of {level:.3f} m")
        around.append(ConvexHull(points).area)  # of a plane hull: its perimeter
    return float(np.mean(around))


def girths(surface: BodySurface, at: Mapping[str, float]) -> dict[str, float]:
    """Girths [m] at the heights of `levels`."""
    return {name: girth(surface, name, level) for name, level in at.items()}
