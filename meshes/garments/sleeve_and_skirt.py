"""Tubes of one row of rings: sleeves and skirts, with girths exact on the mesh.

Both stand upright about the z axis, x forward and y left; girths between the given ones follow a
monotone cubic (Fritsch and Carlson, SIAM J. Numer. Anal. 17, 1980), which between two is a cone.
"""
# SPDX-License-Identifier: LGPL-3.0-or-later

from __future__ import annotations

from itertools import pairwise

import numpy as np

from meshes.shapes.grid import patch
from meshes.surface import Surface

from .ring import count_cells, ring

_GIRTHS = (0.05, 5.0)  # m; a bracelet and a hoop skirt


def check_girths(garment: str, **girths: float) -> None:
    """ValueError for the first girth that no garment has; most such girths are a slip of unit."""
    for name, value in girths.items():
        # Written so that a NaN counts as a fault.
        if not _GIRTHS[0] <= value <= _GIRTHS[1]:
            raise ValueError(
                f"{garment}: {name} = {value} is no girth of a garment, give it in m, between "
                f"{_GIRTHS[0]} and {_GIRTHS[1]}."
            )


def check_cell_size(garment: str, cell_size: float, most: float) -> None:
    """ValueError for cells larger than ``most`` [m] or too small to be meant."""
    if not 1e-3 <= cell_size <= most:
        raise ValueError(
            f"{garment}: cell_size = {cell_size} does not fit, give it in m, 0.001 to {most:.3g}."
        )


def sleeve(
    length: float,
    girth_top: float,
    girth_bottom: float,
    girth_middle: float | None = None,
    ratio: float = 1.0,
    cell_size: float = 0.025,
) -> Surface:
    """A tube from z = length down to z = 0, directors outward, warp down along it.

    Parameters
    ----------
    length : m.
    girth_top, girth_bottom, girth_middle : m, exact on the mesh; None makes a plain cone.
    ratio : breadth (y) over depth (x) of the rings.
    cell_size : m.

    Returns
    -------
    Surface of quads with the edges 'top' and 'bottom' and the line 'seam' (in the xz plane, x > 0).

    Raises
    ------
    ValueError : for a measure out of range.
    """
    heights, girths = [length, 0.0], [girth_top, girth_bottom]
    named = {"girth_top": girth_top, "girth_bottom": girth_bottom}
    if girth_middle is not None:
        heights.insert(1, 0.5 * length)
        girths.insert(1, girth_middle)
        named["girth_middle"] = girth_middle
    check_girths("sleeve", **named)
    if not 0.02 <= length <= 3.0:
        raise ValueError(f"sleeve: length = {length} m does not fit, give 0.02 to 3 m.")
    return _tube("sleeve", heights, girths, [ratio] * len(girths), cell_size, ("top", "bottom"))


def skirt(
    waist: float = 0.74,
    hip: float = 1.02,
    hem: float = 1.30,
    length: float = 0.60,
    hip_depth: float = 0.20,
    waist_height: float = 1.04,
    waist_ratio: float = 1.30,
    hem_ratio: float = 1.10,
    cell_size: float = 0.025,
) -> Surface:
    """A skirt on a body that stands on z = 0, directors outward, warp down along it.

    Parameters
    ----------
    waist, hip, hem : girths in m, exact on the mesh.
    length : from waist to hem, in m.
    hip_depth : height of the waist over the hip line, in m.
    waist_height : over the floor, in m.
    waist_ratio, hem_ratio : breadth (y) over depth (x) at waist and hem; between them linear.
    cell_size : m.

    Returns
    -------
    Surface of quads with the edges 'waist' and 'hem' and the line 'seam' (in the xz plane, x > 0).

    Raises
    ------
    ValueError : for a measure out of range.
    """
    check_girths("skirt", waist=waist, hip=hip, hem=hem)
    if not 0.0 < hip_depth < length <= waist_height <= 3.0:
        raise ValueError(
            f"skirt: hip_depth = {hip_depth}, length = {length} and waist_height = {waist_height} "
            "m must rise in this order, the waist at most 3 m high: hip line above hem above floor."
        )
    heights = waist_height - np.array([0.0, hip_depth, length])
    ratios = waist_ratio + (hem_ratio - waist_ratio) * (waist_height - heights) / length
    return _tube("skirt", heights, [waist, hip, hem], ratios, cell_size, ("waist", "hem"))


def _tube(garment, heights, girths, ratios, cell_size, names):
    """Surface of the rings at falling ``heights`` with monotone cubics between them."""
    from scipy.interpolate import PchipInterpolator

    if not np.all((np.array(ratios) >= 0.2) & (np.array(ratios) <= 5.0)):
        raise ValueError(
            f"{garment}: breadth over depth of a ring must lie in 0.2 to 5, not {list(ratios)}."
        )
    check_cell_size(garment, cell_size, min(girths) / 6.0)
    around = count_cells(np.mean(girths), cell_size, least=6)
    rows = [count_cells(upper - lower, cell_size) for upper, lower in pairwise(heights)]
    # Equal steps within each part put a row of points on every ring whose girth is given.
    levels = [np.linspace(*pair, n + 1)[:-1] for n, pair in zip(rows, pairwise(heights))]
    levels = np.append(np.concatenate(levels), heights[-1])
    depths = -np.asarray(heights, dtype=np.float64)
    girth = PchipInterpolator(depths, girths)(-levels)
    ratio = PchipInterpolator(depths, ratios)(-levels)
    # Clockwise seen from above, so that with the rows running down the cells face outward.
    rings = np.stack([ring(g, r, around, turn=-2.0 * np.pi) for g, r in zip(girth, ratio)], axis=1)
    rings[..., 2] = levels
    rings = np.concatenate([rings, rings[:1]])
    surface = patch(
        lambda a, b: np.moveaxis(rings, -1, 0),
        (around, sum(rows)),
        closed=(True, False),
        names=(None, None, *names),
        warp="b",
        source=garment,
    )
    seam = around * np.arange(sum(rows) + 1)
    return surface.with_edges(seam=np.stack([seam[:-1], seam[1:]], axis=1))
