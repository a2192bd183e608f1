# SPDX-License-Identifier: LGPL-3.0-or-later
"""A closed surface of a body with the centres of its joints.

Axes as everywhere: x forward, y to the left, z up, in metres, of one who stands upright. A surface
is a value; what reads, cuts, fits or places one returns another.
"""

from dataclasses import dataclass, replace

import numpy as np

from shellform.motion.recording import SIDES

JOINTS = tuple(f"{side}_{part}" for side in SIDES for part in ("hip", "knee", "ankle"))


@dataclass(frozen=True, eq=False)
class BodySurface:
    """A body of triangles.

    Parameters
    ----------
    points : (n, 3) float [m]
    triangles : (m, 3) int, counterclockwise seen from outside
    landmarks : dict, name of JOINTS -> centre (3,) [m]
    stature : float [m]
    source : str, for messages
    """

    points: np.ndarray
    triangles: np.ndarray
    landmarks: dict
    stature: float
    source: str = "body"

    @property
    def middle(self) -> np.ndarray:
        """Middle (3,) of the hip centres [m]."""
        return 0.5 * (self.landmarks["right_hip"] + self.landmarks["left_hip"])

    @property
    def left(self) -> np.ndarray:
        """Direction (3,) from the right to the left hip, a unit vector."""
        across = self.landmarks["left_hip"] - self.landmarks["right_hip"]
        return across / np.linalg.norm(across)


def kept_triangles(surface: BodySurface, keep: np.ndarray) -> BodySurface:
    """The surface with some triangles (m,) bool, without the points that none of them has."""
    triangles = surface.triangles[keep]
    used, inverse = np.unique(triangles, return_inverse=True)
    return replace(surface, points=surface.points[used], triangles=inverse.reshape(-1, 3))
