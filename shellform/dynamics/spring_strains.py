# SPDX-License-Identifier: LGPL-3.0-or-later
"""Strains of a cell as masses tell them: along warp and weft, whatever way the mesh runs.

Yarns slip in the strains of warp and weft, and bent cloth pushes back on both sides of flat, which
the length of a flexion spring does not tell. From the nodes of a cell and its neighbours

    E = B s,    s = (l^2 - L^2)/2 of its four edges and two diagonals (six_lengths.py),
    K = C t,    t of the grid lines through its corners, mean of each direction, and of its twist.

A grid line a - c - b whose neighbours aside are p and q, with l1, l2 its lengths at rest, has

    t = -v.N/|N|,   v = 2 ((b - c)/l2 - (c - a)/l1)/(l1 + l2),   N = (b - a) x (q - p),

and so has a cell 0, 1, 2, 3 (tensor order) with v = 0 - 1 - 2 + 3 and N = (3 - 0) x (2 - 1), less
what they have at rest; N is taken to the side of the directors. Where cloth is folded flat, N is
nothing and t has no slope: |N| is taken as sqrt(N.N + (0.03 |N| at rest)^2), and t larger by what
makes it right at rest.

They are those of the shell's cells (cell_stress.py) to second order in the cell's size, but for
0.001 times the strain, and do not change as the sheet is moved and turned.
"""

from typing import Any

import numpy as np

from contact.kernel import kernel
from meshes.topology import directed_edges, unique_edges
from shellform.fem.quad_rest import lamina
from shellform.fem.six_lengths import FIRST, SECOND, six_lengths
from shellform.fem.strains import voigt_rows
from shellform.material.sheet import Sheet

from .grid_lines import grid_lines

BLUNT = 0.03  # of |N| at rest, see above
LINES = 4  # of a direction that a cell may have, one a corner
CYCLE = [0, 1, 3, 2]  # corners in tensor order, one after another around the cell

# one record per grid line or twist
TURN = np.dtype(
    [
        ("nodes", np.int64, 5),  # N = (x1 - x0) x (x3 - x2)
        ("weights", float, 5),  # of the nodes in v
        ("blunt", float),  # added to N.N [m^4]
        ("scale", float),  # of v.N/|N|, with its sign
        ("rest", float),
    ]
)
# one record per cell
CELL = np.dtype(
    [
        ("nodes", np.int64, 4),
        ("B", float, (3, 6)),
        ("lengths", float, 6),  # L^2/2 [m^2]
        ("C", float, (3, 2 * LINES + 1)),
        ("turns", np.int64, 2 * LINES + 1),
        ("areas", float, 2),  # of membrane, of bending [m^2]
    ]
)


@kernel
def cross(a0: float, a1: float, a2: float, b0: float, b1: float, b2: float) -> tuple:
    """a x b."""
    return a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0


@kernel
def measure(
    points: np.ndarray, w: np.ndarray, turns: np.ndarray, values: np.ndarray, slopes: np.ndarray
) -> None:
    """Values t (f,) of turns (f,) TURN, and their derivatives.

    slopes (f, 3, 3) by v and by the two differences of which N is the product
    """
    for f in range(len(turns)):
        nodes, weights = turns[f].nodes, turns[f].weights
        v0 = v1 = v2 = 0.0
        for i in range(5):
            n, weight = nodes[i], weights[i]
            v0 += weight * (points[n, 0] + w[n, 0])
            v1 += weight * (points[n, 1] + w[n, 1])
            v2 += weight * (points[n, 2] + w[n, 2])
        i, j, k, m = nodes[0], nodes[1], nodes[2], nodes[3]
        a0 = points[j, 0] - points[i, 0] + w[j, 0] - w[i, 0]
        a1 = points[j, 1] - points[i, 1] + w[j, 1] - w[i, 1]
        a2 = points[j, 2] - points[i, 2] + w[j, 2] - w[i, 2]
        b0 = points[m, 0] - points[k, 0] + w[m, 0] - w[k, 0]
        b1 = points[m, 1] - points[k, 1] + w[m, 1] - w[k, 1]
        b2 = points[m, 2] - points[k, 2] + w[m, 2] - w[k, 2]
        N0, N1, N2 = cross(a0, a1, a2, b0, b1, b2)
        square = N0 * N0 + N1 * N1 + N2 * N2 + turns[f].blunt
        product, by = v0 * N0 + v1 * N1 + v2 * N2, turns[f].scale / np.sqrt(square)
        values[f] = by * product - turns[f].rest
        slopes[f, 0, 0], slopes[f, 0, 1], slopes[f, 0, 2] = by * N0, by * N1, by * N2
        along = product / square
        g0, g1, g2 = by * (v0 - along * N0), by * (v1 - along * N1), by * (v2 - along * N2)
        slopes[f, 1, 0], slopes[f, 1, 1], slopes[f, 1, 2] = cross(b0, b1, b2, g0, g1, g2)
        slopes[f, 2, 0], slopes[f, 2, 1], slopes[f, 2, 2] = cross(g0, g1, g2, a0, a1, a2)


@kernel
def push(turns: np.ndarray, slopes: np.ndarray, moments: np.ndarray, r: np.ndarray) -> None:
    """Add to r (n, >= 3) moments (f,) times the derivatives of turns by the nodes."""
    for f in range(len(turns)):
        nodes, weights, moment = turns[f].nodes, turns[f].weights, moments[f]
        for c in range(3):
            v, a, b = moment * slopes[f, 0, c], moment * slopes[f, 1, c], moment * slopes[f, 2, c]
            r[nodes[0], c] += weights[0] * v - a
            r[nodes[1], c] += weights[1] * v + a
            r[nodes[2], c] += weights[2] * v - b
            r[nodes[3], c] += weights[3] * v + b
            r[nodes[4], c] += weights[4] * v


@kernel
def strain(
    points: np.ndarray,
    w: np.ndarray,
    cell: Any,
    values: np.ndarray,
    sides: np.ndarray,
    e: np.ndarray,
) -> None:
    """Strains e (6,) of a CELL, and its segments (6, 3) [m] into `sides`; values : of `measure`."""
    nodes, B, lengths, turns, C = cell.nodes, cell.B, cell.lengths, cell.turns, cell.C
    e0 = e1 = e2 = k0 = k1 = k2 = 0.0
    for i in range(6):
        a, b, square = nodes[FIRST[i]], nodes[SECOND[i]], 0.0
        for c in range(3):
            sides[i, c] = points[b, c] - points[a, c] + w[b, c] - w[a, c]
            square += sides[i, c] * sides[i, c]
        s = 0.5 * square - lengths[i]
        e0, e1, e2 = e0 + B[0, i] * s, e1 + B[1, i] * s, e2 + B[2, i] * s
    if len(values):
        for i in range(2 * LINES + 1):
            t = values[turns[i]]
            k0, k1, k2 = k0 + C[0, i] * t, k1 + C[1, i] * t, k2 + C[2, i] * t
    e[0], e[1], e[2], e[3], e[4], e[5] = e0, e1, e2, k0, k1, k2


def turns_of(
    points: np.ndarray, directors: np.ndarray, cells: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Grid lines and twists, (f,) TURN, and of each cell its own, (m, 9) int, -1 where none is.

    points, directors : (n, 3), reference state; cells : (m, 4) int in tensor order
    """
    m = len(cells)
    places = np.full((m, 2 * LINES + 1), -1)
    rows = directed_edges(cells[:, CYCLE])
    first, number, count = unique_edges(rows, len(points))
    number = number.reshape(-1, 4)
    ends, edges, middle, across = grid_lines(rows[first], number, count, len(points))
    turns = np.zeros(len(ends) + m, TURN)
    line, twist = turns[: len(ends)], turns[len(ends) :]
    line["nodes"] = np.column_stack([ends, across, middle])
    l1, l2 = (np.linalg.norm(points[ends[:, i]] - points[middle], axis=1) for i in (0, 1))
    mean = 0.5 * (l1 + l2)
    line["weights"][:, :2] = np.stack([1 / (l1 * mean), 1 / (l2 * mean)], axis=1)
    line["weights"][:, 4] = -line["weights"][:, :2].sum(axis=1)
    twist["nodes"] = cells[:, [0, 3, 1, 2, 0]]
    twist["weights"] = [1, 1, -1, -1, 0]
    x = points[turns["nodes"]]
    N = np.cross(x[:, 1] - x[:, 0], x[:, 3] - x[:, 2])
    out = np.concatenate([directors[middle], directors[cells].mean(axis=1)])
    turns["blunt"] = BLUNT**2 * np.sum(N * N, axis=1)
    turns["scale"] = -np.sqrt(1 + BLUNT**2) * np.sign(np.sum(N * out, axis=1))
    values = np.zeros(len(turns))
    measure(points, np.zeros_like(points), turns, values, np.zeros((len(turns), 3, 3)))
    turns["rest"] = values
    places[:, -1] = len(ends) + np.arange(m)
    _to_cells(edges, number, places)
    return turns, places


def _to_cells(edges, number, places):
    """Enter lines, by the edges (f, 2) that they follow, into the cells that these belong to."""
    at: dict[int, list] = {}
    for cell, own in enumerate(number.tolist()):
        for side, e in enumerate(own):
            at.setdefault(e, []).append((cell, side % 2))
    taken = np.zeros((len(number), 2), int)
    for line, pair in enumerate(edges.tolist()):
        for e in pair:
            for cell, axis in at[e]:
                places[cell, LINES * axis + taken[cell, axis]] = line
                taken[cell, axis] += 1


def cells_of(
    points: np.ndarray,
    cells: np.ndarray,
    warp: np.ndarray | None,
    fabric: Sheet,
    places: np.ndarray | None,
    flat: np.ndarray | None = None,
) -> np.ndarray:
    """Records (m,) CELL; warp : (3,), (m, 3) or None; places : of `turns_of`, None: no K.

    flat : (m, 4, 3), corners of cells cut from flat panels; None: those of the points
    """
    X = points[cells] if flat is None else flat
    records = np.zeros(len(cells), CELL)
    sides = X[:, SECOND] - X[:, FIRST]
    G1, G2 = 0.5 * (sides[:, 0] + sides[:, 1]), 0.5 * (sides[:, 2] + sides[:, 3])
    M, area = lamina(G1, G2, warp)
    V = np.moveaxis(np.array(voigt_rows(*np.moveaxis(M.reshape(-1, 4), -1, 0))), -1, 0)
    records["nodes"] = cells
    records["B"], _, stretched = six_lengths(X, warp, fabric.membrane)
    records["lengths"] = 0.5 * np.sum(sides**2, axis=2)
    records["areas"] = np.stack([stretched, area], axis=1)
    if places is None:
        return records
    there = places >= 0
    records["turns"] = np.maximum(places, 0)
    for axis, G in enumerate((G1, G2)):
        own = slice(LINES * axis, LINES * (axis + 1))
        share = there[:, own] / np.maximum(there[:, own].sum(axis=1, keepdims=True), 1)
        size = np.sum(G * G, axis=1)[:, None, None]
        records["C"][:, :, own] = V[:, :, [axis]] * size * share[:, None, :]
    records["C"][:, :, -1] = V[:, :, 2] * there[:, [-1]]
    return records
