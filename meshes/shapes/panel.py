"""Panels of simple geometry with exact normals: rectangle, disc, annulus, cylinder, sphere.

Each is a `patch` of the unit square with its edges renamed, except the disc (five such grids
joined) and the free-form panel, which are made in `outline` and named here for completeness.
"""
# SPDX-License-Identifier: LGPL-3.0-or-later

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from meshes.surface import Surface

from .grid import distorted, patch, positive, skewed
from .outline import disc, from_outline

__all__ = [
    "annulus",
    "cylinder",
    "disc",
    "distorted",
    "from_outline",
    "patch",
    "rectangle",
    "skewed",
    "spherical_cap",
]

_TURN = 2.0 * np.pi


def _is_full_turn(angle, name="angle"):
    if not 0.0 < angle <= _TURN * (1.0 + 1e-12):
        raise ValueError(f"{name} must lie in 0 to 2 pi rad, not {angle}")
    return angle > _TURN * (1.0 - 1e-12)


def _upward(a, b):
    return 0.0, 0.0, 1.0


def rectangle(
    length: float,
    width: float,
    cells: int | Sequence[int],
    degree: int = 1,
    triangles: bool = False,
    parameters: ArrayLike | None = None,
    warp: str | ArrayLike | None = None,
) -> Surface:
    """Flat rectangle 0 <= x <= length, 0 <= y <= width [m], directors +z.

    Edges 'left' (x = 0), 'right', 'bottom' (y = 0), 'top'; a runs along x, b along y. The other
    arguments are those of `patch`. Raises ValueError for a length that is not positive.
    """
    positive(length=length, width=width)
    return patch(
        lambda a, b: (length * a, width * b, 0.0),
        cells,
        degree,
        triangles,
        normal=_upward,
        warp=warp,
        parameters=parameters,
        source="rectangle",
    )


def annulus(
    inner: float,
    outer: float,
    cells: int | Sequence[int],
    slit: bool = True,
    angle: float = _TURN,
    degree: int = 1,
    triangles: bool = False,
    parameters: ArrayLike | None = None,
    warp: str | ArrayLike | None = None,
) -> Surface:
    """Flat ring between two radii [m] about the origin of the xy plane, directors +z.

    Parameters
    ----------
    inner, outer : radii, 0 < inner < outer.
    cells : (around, across).
    slit : cut a full ring along the positive x axis; its lips 'start' and 'end' have separate
        points. False closes it.
    angle : rad, counter-clockwise from the x axis; below 2 pi the ring is always open.
    degree, triangles, parameters, warp : as in `patch`; a runs around, b from outer to inner.

    Edges 'outer' and 'inner', and 'start' and 'end' unless closed. Raises ValueError.
    """
    positive(inner=inner, outer=outer)
    if not inner < outer:
        raise ValueError(f"inner radius {inner} m must be smaller than the outer {outer} m")

    # From outer to inner, so that the side d/da x d/db is +z with counter-clockwise angles.
    def mapping(a, b):
        radius = outer + (inner - outer) * b
        return radius * np.cos(angle * a), radius * np.sin(angle * a), 0.0

    return patch(
        mapping,
        cells,
        degree,
        triangles,
        closed=(_is_full_turn(angle) and not slit, False),
        normal=_upward,
        names=("start", "end", "outer", "inner"),
        warp=warp,
        parameters=parameters,
        source="annulus",
    )


def cylinder(
    radius: float,
    length: float,
    cells: int | Sequence[int],
    angle: float = _TURN,
    degree: int = 1,
    triangles: bool = False,
    parameters: ArrayLike | None = None,
    warp: str | ArrayLike | None = None,
) -> Surface:
    """Cylinder about the z axis from z = 0 to z = length [m], directors outward.

    Parameters
    ----------
    radius, length : m.
    cells : (around, along).
    angle : rad from the x axis; below 2 pi the wall is open with edges 'start' and 'end'.
    degree, triangles, parameters, warp : as in `patch`; a runs around, b along z.

    Edges 'bottom' (z = 0) and 'top'. Raises ValueError.
    """
    positive(radius=radius, length=length)
    return patch(
        lambda a, b: (radius * np.cos(angle * a), radius * np.sin(angle * a), length * b),
        cells,
        degree,
        triangles,
        closed=(_is_full_turn(angle), False),
        normal=lambda a, b: (np.cos(angle * a), np.sin(angle * a), 0.0),
        names=("start", "end", "bottom", "top"),
        warp=warp,
        parameters=parameters,
        source="cylinder",
    )


def spherical_cap(
    radius: float,
    polar: tuple[float, float],
    longitude: tuple[float, float] = (0.0, _TURN),
    cells: int | Sequence[int] = (16, 16),
    degree: int = 1,
    triangles: bool = False,
    parameters: ArrayLike | None = None,
    warp: str | ArrayLike | None = None,
) -> Surface:
    """Zone of a sphere about the origin, directors outward.

    Parameters
    ----------
    radius : m.
    polar : (from, to) angles from the +z pole in rad, 0 < from < to < pi.
    longitude : (from, to) in rad from the x axis; a full turn is closed.
    cells : (around, along the meridian).
    degree, triangles, parameters, warp : as in `patch`; a runs around, b from the lower edge up.

    Edges 'bottom' (polar 'to') and 'top' (polar 'from', the rim of the hole), and 'start' and
    'end' unless closed. Raises ValueError, also for a pole, where quads would collapse.
    """
    positive(radius=radius)
    (upper, lower), (west, east) = polar, longitude
    if upper == 0.0 or lower == np.pi:
        raise ValueError(
            "a cap with its pole cannot be a grid of quads: leave a hole, or move the points of "
            "disc(...) onto the sphere"
        )
    if not 0.0 < upper < lower < np.pi:
        raise ValueError(f"polar must be rising angles between 0 and pi rad, not {polar}")

    def outward(a, b):
        theta, phi = lower + (upper - lower) * b, west + (east - west) * a
        return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])

    return patch(
        lambda a, b: radius * outward(a, b),
        cells,
        degree,
        triangles,
        closed=(_is_full_turn(east - west, "longitude"), False),
        normal=outward,
        names=("start", "end", "bottom", "top"),
        warp=warp,
        parameters=parameters,
        source="spherical_cap",
    )
