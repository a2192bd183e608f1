# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pieces of the grid lines of quads, two edges long: where springs of flexion lie, Fig. 1."""

from typing import NamedTuple

import numpy as np


class GridLines(NamedTuple):
    """Pieces of grid lines, two edges long.

    ends : (f, 2) int, nodes; edges : (f, 2) int, of the surface; middle : (f,) int, node between
    across : (f, 2) int, the neighbours of the middle aside of the line, at a border it itself
    """

    ends: np.ndarray
    edges: np.ndarray
    middle: np.ndarray
    across: np.ndarray


def grid_lines(edges: np.ndarray, number: np.ndarray, count: np.ndarray, nodes: int) -> GridLines:
    """Where grid lines of quads pass through nodes.

    Parameters
    ----------
    edges : (e, 2) int, nodes; number : (m, 4) int, edges of cells; count : (e,), cells at each
    """
    cells_at: list[set] = [set() for _ in edges]
    for cell, own in enumerate(number.tolist()):
        for e in own:
            cells_at[e].add(cell)
    at: list[list] = [[] for _ in range(nodes)]
    for e, (a, b) in enumerate(edges.tolist()):
        at[a].append((e, b))
        at[b].append((e, a))
    found = []
    for node, meeting in enumerate(at):
        inside = all(count[e] == 2 for e, _ in meeting)
        if len(meeting) != (4 if inside else 3):
            continue  # a corner, or an irregular node: no line passes
        for p, (e, a) in enumerate(meeting):
            for f, b in meeting[p + 1 :]:
                if not cells_at[e] & cells_at[f]:
                    aside = [c for _, c in meeting if c not in (a, b)] + [node]
                    found.append((a, b, e, f, node, *aside[:2]))
    lines = np.array(found, np.int64).reshape(-1, 7)
    return GridLines(lines[:, :2], lines[:, 2:4], lines[:, 4], lines[:, 5:])
