# SPDX-License-Identifier: LGPL-3.0-or-later
"""The capsule: all points within a radius of a segment of a straight line.

Its axis is e1, its middle the origin. With a the half of the segment's length, the closest point c
of the segment to y has c_1 = y_1 cut to [-a, a]; the normal is along y - c and the distance is
|y - c| - radius, inside and outside alike. On the segment itself every direction across it leads to
the skin as fast; e3 is taken, at the ends as well.
"""

from dataclasses import dataclass

import numpy as np

from contact.kernel import kernel


@kernel(makes_arrays=False)
def _foot_and_normal(size, y0, y1, y2):
    half, radius = size[0], size[1]
    c0 = min(max(y0, -half), half)
    d0 = y0 - c0
    # largest part first: no square underflows or overflows
    large = max(abs(d0), abs(y1), abs(y2))
    if large == 0.0:
        return -radius, c0, 0.0, radius, 0.0, 0.0, 1.0
    n0, n1, n2 = d0 / large, y1 / large, y2 / large
    length = np.sqrt(n0 * n0 + n1 * n1 + n2 * n2)
    n0, n1, n2 = n0 / length, n1 / length, n2 / length
    return large * length - radius, c0 + radius * n0, radius * n1, radius * n2, n0, n1, n2


@kernel(makes_arrays=False)
def _least_distance(size, y0, y1, y2):
    """Distance from the endless cylinder or from the planes at both ends: whichever is more."""
    across = np.sqrt(y1 * y1 + y2 * y2) - size[1]
    return max(across, abs(y0) - size[0] - size[1])


@dataclass(frozen=True)
class Capsule:
    """The shape of a segment: a cylinder along e1 with half spheres as its ends.

    Parameters
    ----------
    length : float, of the cylinder, without its ends [m]
    radius : float [m]

    Raises
    ------
    ValueError for a radius that is not finite and positive, a length not finite or below zero
    """

    length: float
    radius: float

    foot_and_normal = staticmethod(_foot_and_normal)
    least_distance = staticmethod(_least_distance)

    def __post_init__(self):
        if not 0 < self.radius < np.inf:
            raise ValueError(f"a capsule needs a finite radius > 0 [m], not {self.radius}")
        if not 0 <= self.length < np.inf:
            raise ValueError(f"a capsule needs a finite length >= 0 [m], not {self.length}")

    @property
    def size(self) -> tuple[float, ...]:
        """Half the length and the radius [m]."""
        return 0.5 * self.length, self.radius

    @property
    def half_extents(self) -> tuple[float, float, float]:
        """Of the box around it along e1, e2, e3 [m]."""
        return self.bounding_radius, self.radius, self.radius

    @property
    def bounding_radius(self) -> float:
        """From its middle to the tips [m]."""
        return 0.5 * self.length + self.radius

    @property
    def inner_radius(self) -> float:
        """Radius of the largest sphere inside [m]."""
        return self.radius

    @property
    def curvature_radius(self) -> float:
        """Smallest radius of curvature [m]."""
        return self.radius
