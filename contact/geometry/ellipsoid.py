# SPDX-License-Identifier: LGPL-3.0-or-later
"""The ellipsoid: implicit surface, closest point and normal, Eq. 15.

Eq. 15 is level(x) = sum_i (x_i / r_i)^2 - 1 (the paper prints the -1 inside the sum), x in the axes
of the ellipsoid. Its gradient gives the normal; the level itself is no distance.

A point y has its foot x where y - x is along the gradient: with q_i = r_i / r_min,
x_i = q_i^2 y_i / (w + q_i^2 - 1), w the largest root of sum (x_i / r_i)^2 = 1 (D. Eberly, "Distance
from a point to an ellipse, an ellipsoid, or a hyperellipsoid", with s = w - 1). The unknown w has
the pole next to the root at zero, so it keeps its relative precision however close to the symmetry
plane the point lies; that holds the level error at roundoff for every aspect. In that plane, inside
the focal curve, w = 0 and there are two feet; the one on the positive side is taken, for a sphere's
centre the one on the last axis.

`Ellipsoid` is the shape of a segment (shape.py).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from contact.kernel import kernel

SLENDER = 1e9  # longest over shortest semi-axis: from there on roundoff of one exceeds the other
MAX_ITERATIONS = 200  # below 20 are needed, log-bisections included
CLOSE = 0.1  # of w: steps that get their term of second order
NEARLY = 3e-6  # of w: the cube of it is below roundoff


@kernel(makes_arrays=False)
def level(x: np.ndarray, radii: np.ndarray) -> float:
    """Left side of Eq. 15: negative inside, zero on the surface.

    Parameters
    ----------
    x : (3,) float, point in the axes of the ellipsoid [m]
    radii : (3,) float, semi-axes [m]
    """
    return (x[0] / radii[0]) ** 2 + (x[1] / radii[1]) ** 2 + (x[2] / radii[2]) ** 2 - 1.0


@kernel(makes_arrays=False)
def _root(p0, p1, p2, e0, e1, e2):
    """Root w > 0 of S(w) = sum_i (p_i / (w + e_i))^2 = 1, one e_i = 0, all >= 0.

    S falls for w > 0: a positive root is the only one, wherever the search began. With weights
    u_i^2 = (p_i / (w + e_i))^2 and means <.> over them, f = 1/sqrt(S) - 1 has

        f' = <1/(w + e)> / sqrt(S),   f'' / f' = -3 Var(1/(w + e)) / <1/(w + e)>,

    so f is concave and nearly straight, also near a pole: Newton from the left never overshoots.
    The search begins at w = 1, the root of points on the surface, unless the bounds are far from
    it. Near the root a term with f'' is added; the error is then of third order in the step, below
    roundoff for steps below NEARLY. A step that leaves the bracket, or that did not bring the
    residual down to a quarter, gives way to a bisection in log w.
    """
    low = max(p0 if e0 == 0.0 else 0.0, p1 if e1 == 0.0 else 0.0, p2 if e2 == 0.0 else 0.0)
    high = np.sqrt(p0 * p0 + p1 * p1 + p2 * p2)
    # every single term puts the root above p - e; those with e > 0 lose digits: a start, no bound
    start = max(low, p0 - e0, p1 - e1, p2 - e2)
    w = 1.0 if start < 1.0 < high else start
    before = np.inf
    for _ in range(MAX_ITERATIONS):
        # a term without numerator may have no denominator either
        r0 = 1.0 / (w + e0 if p0 > 0.0 else 1.0)
        r1 = 1.0 / (w + e1 if p1 > 0.0 else 1.0)
        r2 = 1.0 / (w + e2 if p2 > 0.0 else 1.0)
        u0, u1, u2 = p0 * r0, p1 * r1, p2 * r2
        u0, u1, u2 = u0 * u0, u1 * u1, u2 * u2
        total = u0 + u1 + u2
        if total >= 1.0:
            low = max(low, w)
        else:
            high = min(high, w)
        residual = abs(total - 1.0)
        if residual <= 4e-16 or high <= low * (1.0 + 3e-16):
            break
        u0, u1, u2 = u0 * r0, u1 * r1, u2 * r2
        slope = u0 + u1 + u2
        step = total * (np.sqrt(total) - 1.0) / slope
        if abs(step) < CLOSE * w:
            spread = (u0 * r0 + u1 * r1 + u2 * r2) / slope - slope / total
            ahead = w + step * (1.0 + 1.5 * spread * step)
            if abs(step) < NEARLY * w and low <= ahead <= high:
                return ahead
        else:
            ahead = w + step
        before, poor = residual, residual > 0.25 * before
        if poor or not low <= ahead <= high:
            ahead = np.sqrt(low) * np.sqrt(high) if low > 0.0 else 0.5 * high
            before = np.inf
        if ahead == w:
            break
        w = ahead
    return w


@kernel(makes_arrays=False)
def foot_and_normal(
    y0: float, y1: float, y2: float, r0: float, r1: float, r2: float
) -> tuple[float, float, float, float, float, float, float]:
    """Closest point of the surface; scalars in and out, as the contact loop needs no arrays.

    Returns
    -------
    distance, x0, x1, x2, n0, n1, n2 : signed distance [m] (negative inside), foot [m], unit normal
    """
    shortest = min(r0, r1, r2)
    e0, e1, e2 = _excess(r0, shortest), _excess(r1, shortest), _excess(r2, shortest)
    return _foot(y0, y1, y2, r0, r1, r2, shortest, e0, e1, e2)


@kernel(makes_arrays=False)
def _excess(r, shortest):
    """q^2 - 1 of q = r / shortest, exactly zero for the shortest."""
    return (r - shortest) / shortest * (r / shortest + 1.0)


@kernel(makes_arrays=False)
def _foot(y0, y1, y2, r0, r1, r2, shortest, e0, e1, e2):
    """`foot_and_normal` from semi-axes, the shortest of them and their `_excess`."""
    z0, z1, z2 = abs(y0) / r0, abs(y1) / r1, abs(y2) / r2
    p0, p1, p2 = z0 + e0 * z0, z1 + e1 * z1, z2 + e2 * z2
    # below this an offset from the symmetry plane would only underflow
    plane = 1e-150
    u0, u1, u2 = 0.0, 0.0, 0.0
    # on the level of the symmetry plane, w -> 0: no term of the shortest axes
    in_plane = (e0 > 0.0 or z0 < plane) and (e1 > 0.0 or z1 < plane) and (e2 > 0.0 or z2 < plane)
    if in_plane:
        u0 = p0 / e0 if e0 > 0.0 else 0.0
        u1 = p1 / e1 if e1 > 0.0 else 0.0
        u2 = p2 / e2 if e2 > 0.0 else 0.0
    rest = 1.0 - (u0 * u0 + u1 * u1 + u2 * u2)
    w = 0.0
    if in_plane and rest >= 0.0:
        if e2 == 0.0:
            u2 = np.sqrt(rest)
        elif e1 == 0.0:
            u1 = np.sqrt(rest)
        else:
            u0 = np.sqrt(rest)
    else:
        w = _root(p0, p1, p2, e0, e1, e2)
        u0 = p0 / (w + e0) if z0 > 0.0 else 0.0
        u1 = p1 / (w + e1) if z1 > 0.0 else 0.0
        u2 = p2 / (w + e2) if z2 > 0.0 else 0.0
    u0 = -u0 if y0 < 0.0 else u0
    u1 = -u1 if y1 < 0.0 else u1
    u2 = -u2 if y2 < 0.0 else u2
    g0, g1, g2 = u0 * shortest / r0, u1 * shortest / r1, u2 * shortest / r2
    gradient = np.sqrt(g0 * g0 + g1 * g1 + g2 * g2)
    # y - x = (w - 1) r_min g: no difference of nearby points
    return (
        (w - 1.0) * shortest * gradient,
        u0 * r0,
        u1 * r1,
        u2 * r2,
        g0 / gradient,
        g1 / gradient,
        g2 / gradient,
    )


@kernel(makes_arrays=False)
def closest_point(y: np.ndarray, radii: np.ndarray, foot: np.ndarray, normal: np.ndarray) -> float:
    """Closest point of the surface of one ellipsoid to a point.

    Parameters
    ----------
    y : (3,) float, point in the axes of the ellipsoid [m]
    radii : (3,) float, semi-axes [m]
    foot, normal : (3,) float, filled: the foot [m], the unit outward normal there

    Returns
    -------
    signed distance [m], negative inside
    """
    distance, foot[0], foot[1], foot[2], normal[0], normal[1], normal[2] = foot_and_normal(
        y[0], y[1], y[2], radii[0], radii[1], radii[2]
    )
    return distance


@kernel(makes_arrays=False)
def _closest_points(points, radii, feet, normals, distances):
    for i in range(len(points)):
        distances[i] = closest_point(points[i], radii, feet[i], normals[i])


def closest_points(
    points: ArrayLike,
    radii: ArrayLike,
    centre: ArrayLike = (0.0, 0.0, 0.0),
    axes: ArrayLike | None = None,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Closest points of the surface of one ellipsoid to many points.

    Parameters
    ----------
    points : (n, 3) float [m]
    radii : (3,) float, semi-axes [m]
    centre : (3,) float [m]
    axes : (3, 3) float or None, rows are the unit axes; None: the world's

    Returns
    -------
    feet (n, 3) [m], normals (n, 3) unit and outward, distances (n,) [m], negative inside
    """
    radii, centre = np.asarray(radii, float), np.asarray(centre, float)
    axes = np.eye(3) if axes is None else np.asarray(axes, float)
    local = np.ascontiguousarray((np.atleast_2d(np.asarray(points, float)) - centre) @ axes.T)
    feet, normals, distances = np.empty_like(local), np.empty_like(local), np.empty(len(local))
    _closest_points(local, radii, feet, normals, distances)
    return feet @ axes + centre, normals @ axes, distances


def semi_axes(name: str, radii: ArrayLike) -> np.ndarray:
    """Checked semi-axes (3,) [m] of the segment `name`; ValueError if they make no ellipsoid."""
    radii = np.array(radii, float)
    if radii.shape != (3,) or not (np.isfinite(radii).all() and (radii > 0).all()):
        raise ValueError(f"segment '{name}' needs three finite radii > 0 [m], not {radii}")
    if radii.max() > SLENDER * radii.min():
        raise ValueError(
            f"segment '{name}' has radii from {radii.min():.3g} to {radii.max():.3g} m, more than "
            f"{SLENDER:.0g} apart; make the longest shorter"
        )
    return radii


@kernel(makes_arrays=False)
def _foot_and_normal(size, y0, y1, y2):
    return _foot(y0, y1, y2, size[0], size[1], size[2], size[3], size[4], size[5], size[6])


@kernel(makes_arrays=False)
def _least_distance(size, y0, y1, y2):
    """|y / r| - 1 in shortest radii is never more than the distance."""
    return (np.sqrt((y0 / size[0]) ** 2 + (y1 / size[1]) ** 2 + (y2 / size[2]) ** 2) - 1.0) * size[
        3
    ]


@dataclass(frozen=True)
class Ellipsoid:
    """The shape of a segment with semi-axes along e1, e2, e3 [m]; see `contact.geometry.shape`."""

    radii: tuple[float, float, float]

    foot_and_normal = staticmethod(_foot_and_normal)
    least_distance = staticmethod(_least_distance)

    @property
    def size(self) -> tuple[float, ...]:
        """The semi-axes and the shortest of them [m], and what `_excess` gives for each."""
        shortest = min(self.radii)
        return (*self.radii, shortest, *(_excess(r, shortest) for r in self.radii))

    @property
    def half_extents(self) -> tuple[float, float, float]:
        """The semi-axes [m]."""
        return self.radii

    @property
    def bounding_radius(self) -> float:
        """Longest semi-axis [m]."""
        return max(self.radii)

    @property
    def inner_radius(self) -> float:
        """Shortest semi-axis [m]."""
        return min(self.radii)

    @property
    def curvature_radius(self) -> float:
        """Smallest radius of curvature [m], at the ends of the longest axis."""
        return min(self.radii) * min(self.radii) / max(self.radii)


def ellipsoid(name: str, radii: ArrayLike) -> Ellipsoid:
    """The ellipsoid of the segment `name` from its semi-axes (3,) [m], checked by `semi_axes`."""
    r0, r1, r2 = semi_axes(name, radii).tolist()
    return Ellipsoid((r0, r1, r2))
