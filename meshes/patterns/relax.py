# SPDX-License-Identifier: LGPL-3.0-or-later
"""The shape of a sewn garment with little strain: particles on springs, each at its length.

Sides and diagonals of the cells are springs of the lengths that they have in the panels; the mean
of a node's neighbours pulls it a little, which stands for bending. Panels that were sewn flat onto
each other are opened by a pressure inside, which is taken away again. Each step gives every spring
its direction, then solves for all nodes at once (projective dynamics, Bouaziz, Martin, Liu, Kavan
and Pauly, ACM Trans. Graph. 33, 2014). Nodes across the plane between the legs of a body are held
to it, and when the pressure is gone (or before) those inside the body to its surface, which grows
from its axes; which these are is looked up every ROUND steps, and the matrix factored.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from meshes.geometry import area_vectors
from meshes.topology import boundary_segments, directed_edges, unique_edges

from .placing import side_of

BENDING = 1.0, 0.02  # stiffness of the curvature, of that of a spring: with pressure, without
INFLATED = 0.6  # part of the steps with pressure inside
PRESSURE = 0.1  # over the stiffness of a spring [1/m]
STILL = 1e-3  # weight of where a node is, of that of a spring: it damps
HELD = 1.0  # weight of the surface of a body for nodes that were inside
ROUND = 20  # steps
APART = 0.004  # of the legs of a garment from the plane between them [m]
GROWN = 0.6  # part of the steps with a body until this has its whole breadth
THIN = 0.2  # breadth that it has at first
THREAD = 0.5  # breadth of a body that is inside from the beginning


class StandingBody(NamedTuple):
    """Ellipsoids of a standing body: centres (b, 3), axes (b, 3, 3) in rows, radii (b, 3) [m].

    The first axis is that of the segment.
    """

    centres: np.ndarray
    axes: np.ndarray
    radii: np.ndarray

    def outside(self, x: np.ndarray, breadth: float = 1.0) -> np.ndarray:
        """Points (n, 3), those inside moved out of it, square to the segment's axis.

        breadth : factor on the radii across the axis
        """
        x, scale = x.copy(), np.array([1.0, breadth, breadth])
        for centre, axes, radii in zip(self.centres, self.axes, self.radii * scale, strict=True):
            y = (x - centre) @ axes.T / radii
            across = y[:, 1] ** 2 + y[:, 2] ** 2
            inside = (y[:, 0] ** 2 + across < 1.0) & (across > 1e-12)
            y = y[inside]
            y[:, 1:] *= np.sqrt((1.0 - y[:, 0] ** 2) / across[inside])[:, None]
            x[inside] = centre + (y * radii) @ axes
        return x


def relax(
    points: np.ndarray,
    cells: np.ndarray,
    flat: np.ndarray,
    steps: int,
    side: np.ndarray | None = None,
    body: StandingBody | None = None,
    threaded: bool = False,
) -> np.ndarray:
    """Points (n, 3) after so many steps.

    Parameters
    ----------
    points : (n, 3); cells : (m, 4), facing outward; flat : (m, 4, 2), corners in their panels [m]
    side : (n,) 1 for nodes that stay at y >= 0, -1 for y <= 0, 0 for others, or None
    body : that the garment goes around, or None; threaded : it is in there from the beginning, of
        the breadth THREAD, so that sleeves cannot leave their arms while they are blown up
    """
    from scipy.sparse import coo_matrix, diags, identity
    from scipy.sparse.linalg import splu

    n = len(points)
    ends, rest = springs(cells, flat)
    rows, one = np.arange(len(ends)), np.ones(len(ends))
    D = coo_matrix(
        (np.concatenate([one, -one]), (np.concatenate([rows, rows]), ends.T[::-1].ravel())),
        shape=(len(ends), n),
    ).tocsr()
    L = _laplacian(cells, n)
    stretch, bend = (D.T @ D + STILL * identity(n)).tocsc(), (L.T @ L).tocsc()
    DT, x, held, stiffness = D.T.tocsr(), points.copy(), np.zeros(n, bool), 0.0
    for step in range(steps):
        blown = step < INFLATED * steps
        grown = (step / steps - INFLATED) / (GROWN * (1.0 - INFLATED))
        thin = THREAD if threaded else THIN
        breadth = thin + (1.0 - thin) * min(max(grown, 0.0), 1.0)
        free = _allowed(x, side, None if blown and not threaded else body, breadth)
        wanted = BENDING[0] if blown else BENDING[1]
        if step % ROUND == 0 or wanted != stiffness:
            now = np.any(free != x, axis=1)
            if wanted != stiffness or np.any(now != held):
                held, stiffness = now, wanted
                solve = splu((stretch + stiffness * bend + diags(HELD * held)).tocsc()).solve
        push = STILL * x
        push[held] += HELD * free[held]
        if blown:
            areas = area_vectors(x, cells)
            inside = [np.bincount(cells.ravel(), np.repeat(a, 4), n) / 4 for a in areas.T]
            push += PRESSURE * (np.stack(inside, axis=1) - areas.sum(axis=0) / n)
        d = D @ x
        d *= (rest / np.maximum(np.linalg.norm(d, axis=1), 1e-12))[:, None]
        x = solve(DT @ d + push)
    return x if body is not None else _moved_back(x, points)


def _allowed(x, side, body, breadth):
    """Where nodes (n, 3) may be, next to where they are."""
    out = x if body is None else body.outside(x, breadth)
    if side is None:
        return out
    out = out.copy()
    out[:, 1] = np.where(side * out[:, 1] < APART * np.abs(side), side * APART, out[:, 1])
    return out


def _moved_back(x, points):
    """x (n, 3) as a body brought to where `points` were, as pressure has moved it."""
    middle, before = x.mean(axis=0), points.mean(axis=0)
    U, _, V = np.linalg.svd((x - middle).T @ (points - before))
    U[:, -1] *= np.sign(np.linalg.det(U @ V))
    return (x - middle) @ (U @ V) + before


def sides_of(points: np.ndarray, panels: list[np.ndarray], cells: np.ndarray) -> np.ndarray:
    """Side (n,) of the plane y = 0 on which nodes stay, 0 for those of neither or of both.

    points : (n, 3), before the relaxation; panels : rows of the cells (m, 4) of each
    """
    side = np.zeros(len(points))
    both = np.zeros(len(points), bool)
    for rows in panels:
        own = np.unique(cells[rows])
        sign = side_of(points[own, 1])
        both[own] |= side[own] * sign < 0
        side[own] = np.where(side[own] == 0, sign, side[own])
        both[own] |= sign == 0
    side[both] = 0
    return side


def springs(cells: np.ndarray, flat: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Ends (s, 2) and lengths (s,) [m] of sides and diagonals; sides of two panels: the mean."""
    rows = directed_edges(cells)
    first, number, count = unique_edges(rows, int(cells.max()) + 1)
    sides = np.linalg.norm(np.roll(flat, -1, axis=1) - flat, axis=2).ravel()
    length = np.bincount(number, sides) / count
    across = np.linalg.norm(flat[:, [2, 3]] - flat[:, [0, 1]], axis=2).T.ravel()
    ends = np.concatenate([rows[first][:, :2], cells[:, [0, 2]], cells[:, [1, 3]]])
    return ends, np.concatenate([length, across])


def _laplacian(cells, n):
    """Mean of the neighbours less the node, rows of inner nodes alone."""
    from scipy.sparse import coo_matrix, diags

    rows = directed_edges(cells)
    first, *_ = unique_edges(rows, n)
    a, b = rows[first][:, :2].T
    i, j = np.concatenate([a, b]), np.concatenate([b, a])
    W = coo_matrix((np.ones(len(i)), (i, j)), shape=(n, n)).tocsr()
    degree = np.asarray(W.sum(axis=1)).ravel()
    inner = np.ones(n)
    inner[np.unique(boundary_segments(cells))] = 0.0
    return diags(inner) @ (diags(1 / degree) @ W - diags(np.ones(n)))
