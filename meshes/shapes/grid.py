"""Structured meshes: the unit square (a, b), cut into rows of cells, carried onto a surface.

`patch` does it for any mapping; `distorted` and `skewed` give irregular corner parameters for it.
Points and cells are numbered with a running fastest.
"""
# SPDX-License-Identifier: LGPL-3.0-or-later

from __future__ import annotations

import numbers
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from meshes.geometry import diagonal
from meshes.surface import Surface
from meshes.topology import cut_quads, segments_of_line

Mapping = Callable[[np.ndarray, np.ndarray], Any]  # of parameters a, b, shape s -> (3, *s)


def cell_counts(cells: int | Sequence[int]) -> tuple[int, int]:
    """Two positive cell counts from a pair or one number; ValueError otherwise."""
    pair = tuple(cells) if isinstance(cells, Sequence | np.ndarray) else (cells, cells)
    if len(pair) != 2 or not all(isinstance(n, numbers.Integral) and n >= 1 for n in pair):
        raise ValueError(f"cells must be two whole numbers of at least 1, not {cells}")
    return int(pair[0]), int(pair[1])


def positive(**lengths: float) -> None:
    """ValueError naming the first length that is not a positive number."""
    for name, value in lengths.items():
        if not (np.isfinite(value) and value > 0.0):
            raise ValueError(f"{name} must be a positive length in m, not {value}")


def number_cells(
    cells: tuple[int, int], degree: int, closed: tuple[bool, bool] = (False, False)
) -> tuple[np.ndarray, np.ndarray]:
    """Point numbers on the grid and the quads between them.

    Returns ``grid`` (degree * n1 + 1, degree * n2 + 1) of point indices, repeated where closed,
    and ``quads`` (n1 * n2, 4 | 9).
    """
    n1, n2 = cells
    rows = [degree * n + 1 - bool(shut) for n, shut in zip(cells, closed)]
    i, j = np.arange(degree * n1 + 1) % rows[0], np.arange(degree * n2 + 1) % rows[1]
    grid = i[:, None] + rows[0] * j[None, :]
    places = np.array([(0, 0), (1, 0), (1, 1), (0, 1)]) * degree
    if degree == 2:
        places = np.concatenate([places, [(1, 0), (2, 1), (1, 2), (0, 1), (1, 1)]])
    quads = [grid[p::degree, q::degree][:n1, :n2].T.ravel() for p, q in places]
    return grid, np.stack(quads, axis=1)


def uniform(cells: tuple[int, int]) -> np.ndarray:
    """Corner parameters (n1 + 1, n2 + 1, 2) of the regular grid."""
    a, b = (np.linspace(0.0, 1.0, n + 1) for n in cells)
    return np.stack(np.meshgrid(a, b, indexing="ij"), axis=-1)


def distorted(cells: int | Sequence[int], amount: float, seed: int = 0) -> np.ndarray:
    """Corner parameters (n1 + 1, n2 + 1, 2) with the inner corners displaced at random.

    Each inner corner moves by up to ``amount`` (0 to below 0.5) cell sizes in a and in b; the
    boundary stays. The same seed gives the same mesh. Raises ValueError for another amount.
    """
    counts = cell_counts(cells)
    if not 0.0 <= amount < 0.5:
        raise ValueError(f"amount must lie in 0 to below 0.5 of a cell, not {amount}")
    parameters = uniform(counts)
    inner = parameters[1:-1, 1:-1]
    inner += np.random.default_rng(seed).uniform(-amount, amount, inner.shape) / counts
    return parameters


def skewed(cells: int | Sequence[int], shift: float) -> np.ndarray:
    """Corner parameters (n1 + 1, n2 + 1, 2) with the mesh lines a = const leaning.

    From b = 0 to b = 1 a line moves by ``shift`` cells in a at mid length, less towards a = 0 and
    a = 1, where it stays. Raises ValueError if |shift| >= n1 / 2, where cells would fold.
    """
    counts = cell_counts(cells)
    if not abs(shift) < counts[0] / 2.0:
        raise ValueError(f"shift must be below half of the {counts[0]} cells in a, not {shift}")
    parameters = uniform(counts)
    a, b = parameters[..., 0].copy(), parameters[..., 1]
    parameters[..., 0] += shift / counts[0] * (b - 0.5) * 4.0 * a * (1.0 - a)
    return parameters


def patch(
    mapping: Mapping,
    cells: int | Sequence[int],
    degree: int = 1,
    triangles: bool = False,
    closed: tuple[bool, bool] = (False, False),
    normal: Mapping | None = None,
    names: Sequence[str | None] = ("left", "right", "bottom", "top"),
    warp: str | ArrayLike | None = None,
    parameters: ArrayLike | None = None,
    source: str = "patch",
) -> Surface:
    """Structured mesh of the unit square carried by ``mapping``.

    Parameters
    ----------
    mapping : function of arrays a, b returning x, y, z in m, (3,) + shape; d/da x d/db is the
        side the cells face.
    cells : (n1, n2) cells along a and b.
    degree : 1 or 2 (9-node cells on the mapped surface).
    triangles : cut each 4-node cell in two, diagonals alternating.
    closed : whether a = 1 is the same line as a = 0, and b = 1 as b = 0.
    normal : function of a, b returning the exact unit normal; None takes nodal normals.
    names : of the edges a = 0, a = 1 (directed along b), b = 0, b = 1 (along a); None leaves one
        out, as does a closed direction.
    warp : None, (3,), one vector a quad (n1 * n2, 3), or 'a' or 'b' for along that parameter.
    parameters : (n1 + 1, n2 + 1, 2) corner parameters in place of the regular grid; middle nodes
        lie half-way in them.

    Raises
    ------
    ValueError : for arguments out of range; MeshError if the mapped cells fold.
    """
    counts = cell_counts(cells)
    if degree not in (1, 2):
        raise ValueError(f"degree must be 1 or 2, not {degree}")
    if triangles and degree == 2:
        raise ValueError("triangles are available with degree 1 only")
    for count, shut, axis in zip(counts, closed, "ab"):
        if shut and count < 3:
            raise ValueError(f"a direction closed in {axis} needs at least 3 cells, not {count}")
    nodes = _node_parameters(counts, degree, parameters, closed)
    grid, quads = number_cells(counts, degree, closed)
    all_points = evaluate(mapping, nodes, "mapping")
    _check_closure(all_points, closed)

    # Keeping the first grid place of every point number drops the repeated line of a closed grid.
    _, keep = np.unique(grid, return_index=True)
    points = all_points.reshape(-1, 3)[keep]
    directors = None
    if normal is not None:
        directors = evaluate(normal, nodes, "normal").reshape(-1, 3)[keep]
        directors = directors / np.linalg.norm(directors, axis=1, keepdims=True)

    lines = (grid[0], grid[-1], grid[:, 0], grid[:, -1])
    if len(names) != 4:
        raise ValueError(f"names must be four, for a = 0, a = 1, b = 0 and b = 1, not {names}")
    edges = {
        name: segments_of_line(line, degree)
        for name, line, shut in zip(names, lines, np.repeat(closed, 2))
        if name is not None and not shut
    }
    yarns = None if warp is None or isinstance(warp, str) else np.asarray(warp)
    if isinstance(warp, str):
        if warp not in ("a", "b"):
            raise ValueError(f"warp must be a vector, vectors, 'a' or 'b', not '{warp}'")
        corners = points[quads[:, :4]]
        ahead = np.array([-1, 1, 1, -1] if warp == "a" else [-1, -1, 1, 1])
        yarns = np.einsum("mni,n->mi", corners, ahead)
        yarns = yarns / np.linalg.norm(yarns, axis=1, keepdims=True)
    if triangles:
        i, j = np.arange(len(quads)) % counts[0], np.arange(len(quads)) // counts[0]
        quads = cut_quads(quads, (i + j) % 2 == 1)
        if yarns is not None and yarns.ndim == 2:
            yarns = np.repeat(yarns, 2, axis=0)
    return Surface(points, quads, edges, directors, yarns, source=source)


def evaluate(function: Mapping, nodes: np.ndarray, what: str) -> np.ndarray:
    """Values (..., 3) of a function of a and b at parameters (..., 2)."""
    values = function(nodes[..., 0], nodes[..., 1])
    try:
        x, y, z = (np.broadcast_to(v, nodes.shape[:-1]) for v in values)
    except (TypeError, ValueError):
        raise ValueError(f"{what}(a, b) must return three arrays of the shape of a and b") from None
    return np.stack([x, y, z], axis=-1).astype(np.float64)


def _node_parameters(counts, degree, parameters, closed):
    nodes = uniform(counts)
    if parameters is not None:
        given = np.asarray(parameters, dtype=np.float64)
        if given.shape != nodes.shape:
            raise ValueError(f"parameters must have the shape {nodes.shape}, not {given.shape}")
        if not (np.isfinite(given).all() and given.min() > -1e-9 and given.max() < 1.0 + 1e-9):
            raise ValueError("parameters must lie in 0 to 1")
        seams = (given[-1] - given[0] - (1, 0), given[:, -1] - given[:, 0] - (0, 1))
        if any(shut and np.abs(seam).max() > 1e-9 for shut, seam in zip(closed, seams)):
            raise ValueError("parameters must agree on the two lines joined by a closed direction")
        nodes = given
    if degree == 2:
        for axis in (0, 1):
            nodes = np.moveaxis(nodes, axis, 0)
            finer = np.empty((2 * len(nodes) - 1, *nodes.shape[1:]))
            finer[0::2] = nodes
            finer[1::2] = 0.5 * (nodes[1:] + nodes[:-1])
            nodes = np.moveaxis(finer, 0, axis)
    return nodes


def _check_closure(points, closed):
    limit = 1e-9 * diagonal(points.reshape(-1, 3))
    gaps = (points[-1] - points[0], points[:, -1] - points[:, 0])
    for shut, gap, axis in zip(closed, gaps, "ab"):
        if shut and np.abs(gap).max() > limit:
            raise ValueError(
                f"closed in {axis}, but the mapping leaves a gap of {np.abs(gap).max():.3g} m "
                f"between {axis} = 0 and {axis} = 1"
            )
