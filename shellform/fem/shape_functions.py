# SPDX-License-Identifier: LGPL-3.0-or-later
"""Shape functions on the surface's own arrays: integrals and values at a point, Eq. 4.

For what is done once on the whole surface (nodal weights of a load, reading a value at a point)
plain arrays serve; the weak form itself is UFL's.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike

from meshes import Surface

from .element import GAUSS2, GAUSS3


def shape_functions(width: int, p: float, q: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Shape functions and their two derivatives at (p, q) of a 3-, 4- or 9-node cell, cyclic."""
    if width == 3:
        return np.array([1 - p - q, p, q]), np.array([-1.0, 1, 0]), np.array([-1.0, 0, 1])
    if width == 4:
        f, df = lambda x: np.array([1 - x, x]), lambda x: np.array([-1.0, 1.0])
        order = [(0, 0), (1, 0), (1, 1), (0, 1)]
    else:
        f = lambda x: np.array([(1 - x) * (1 - 2 * x), 4 * x * (1 - x), x * (2 * x - 1)])  # noqa: E731
        df = lambda x: np.array([4 * x - 3, 4 - 8 * x, 4 * x - 1])  # noqa: E731
        order = [(0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1), (1, 1)]
    i, j = np.array(order).T
    return f(p)[i] * f(q)[j], df(p)[i] * f(q)[j], f(p)[i] * df(q)[j]


def surface_rule(surface: Surface) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Quadrature over the reference surface, exact for the nodal weights of its element.

    Yields
    ------
    shape : (nodes of a cell,), shape functions; weights : (cells,) [m^2]; at : (cells, 3) points
    """
    corners = surface.points[surface.cells]
    width = surface.cells.shape[1]
    if width == 3:
        rule = [(0.5, 0.0, 1 / 6), (0.5, 0.5, 1 / 6), (0.0, 0.5, 1 / 6)]
    else:
        line = GAUSS2 if width == 4 else GAUSS3
        rule = [(p, q, a * b) for p, a in line for q, b in line]
    for p, q, w in rule:
        shape, slope1, slope2 = shape_functions(width, p, q)
        g1, g2 = (np.einsum("i,kij->kj", s, corners) for s in (slope1, slope2))
        area = np.linalg.norm(np.cross(g1, g2), axis=1)
        yield shape, w * area, np.einsum("i,kij->kj", shape, corners)


def locate(surface: Surface, point: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Where a point lies on a surface.

    Parameters
    ----------
    surface : meshes.Surface; point : (3,) [m]

    Returns
    -------
    nodes : (nodes of a cell,) int; shape : their weights at the surface point next to `point`

    Raises
    ------
    ValueError if the surface is further away than a tenth of its mean cell size: cells with
    straight sides lie that far inside a curved surface
    """
    point = np.asarray(point, float)
    if point.shape != (3,) or not np.all(np.isfinite(point)):
        raise ValueError(f"a point is three finite numbers, not {point.tolist()}")
    width = surface.cells.shape[1]
    corners = 3 if width == 3 else 4
    # the cells whose ball of corners reaches the point
    centre = surface.points[surface.cells[:, :corners]].mean(axis=1)
    reach = np.linalg.norm(surface.points[surface.cells] - centre[:, None], axis=2).max(axis=1)
    distance = np.linalg.norm(centre - point, axis=1)
    candidates = np.flatnonzero(distance <= 1.001 * reach + 0.1 * surface.mean_cell_size)
    best: tuple = (np.inf, None, None)
    for cell in candidates[np.argsort(distance[candidates])]:
        nodes = surface.cells[cell]
        at = np.full(2, 1 / 3 if width == 3 else 0.5)
        for _ in range(30):
            shape, slope1, slope2 = shape_functions(width, *at)
            slopes = np.column_stack([slope1, slope2]).T @ surface.points[nodes]
            gap = point - shape @ surface.points[nodes]
            move = np.linalg.lstsq(slopes.T, gap, rcond=None)[0]
            inside = np.clip(at + move, 0, 1)
            if width == 3 and inside.sum() > 1:
                inside /= inside.sum()
            if np.abs(inside - at).max() < 1e-14:
                break
            at = inside
        off = np.linalg.norm(gap)
        if off < best[0]:
            best = (off, nodes, shape)
        if off < 1e-9 * surface.mean_cell_size:
            break
    if not best[0] <= 0.1 * surface.mean_cell_size:
        gap = min(best[0], np.linalg.norm(surface.points - point, axis=1).min())
        raise ValueError(f"{point.tolist()} is not on {surface.source}: it is {gap:.3g} m away")
    return best[1], best[2]
