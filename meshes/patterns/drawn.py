# SPDX-License-Identifier: LGPL-3.0-or-later
"""Panels from drawn outlines: edges between corners, pieces drawn by half unfolded.

Drawings have no edges with names, only a line around a piece. It is cut where it turns by more than
CORNER, or where the file marks its corners; edges are numbered from 0 in the order of the drawing.
A drawing shows the outside, so outlines drawn clockwise are run the other way, names kept.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from meshes.validity import MeshError

from .pattern import Edge, Panel

CORNER = 20.0  # degrees of turn in a point that make it a corner
NEAR = 1e-4  # of points that are one [m]


def counter_clockwise(panel: Panel) -> Panel:
    """The panel with its edges run counter-clockwise, each with the name it has."""
    if panel.signed_area >= 0.0:
        return panel
    edges = tuple(Edge(e.name, e.points[::-1], e.kind) for e in panel.edges[::-1])
    return _with_edges(panel, edges)


def edges_of_line(line: np.ndarray, corners: np.ndarray | None, where: str) -> list[Edge]:
    """Edges '0', '1', ... of a closed polyline (k, 2) [m].

    Parameters
    ----------
    corners : (c, 2) points that part it, or None: where it turns by more than CORNER
    where : file and panel, for the message

    Raises
    ------
    MeshError for a line that does not close or has no corner
    """
    if len(line) > 1 and np.linalg.norm(line[-1] - line[0]) > NEAR:
        gap = 1e3 * np.linalg.norm(line[-1] - line[0])
        raise MeshError(
            f"{where}: the outline is open, its last point lies {gap:.3g} mm from its first one: "
            "close it."
        )
    line = line[:-1]
    keep = np.linalg.norm(np.roll(line, -1, axis=0) - line, axis=1) > 1e-9
    line = line[keep]
    if len(line) < 3:
        raise MeshError(f"{where}: an outline has at least three points, this has {len(line)}.")
    if corners is not None and len(corners):
        away = np.linalg.norm(line[:, None] - corners[None], axis=2)
        at = np.flatnonzero(away.min(axis=1) < NEAR)
    else:
        after, before = np.roll(line, -1, axis=0) - line, line - np.roll(line, 1, axis=0)
        cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
        turn = np.degrees(np.abs(np.arctan2(cross, np.sum(before * after, axis=1))))
        at = np.flatnonzero(turn > CORNER)
    if len(at) < 2:
        raise MeshError(
            f"{where}: its outline has {len(at)} corners, and edges lie between two at least: mark "
            "them (turn points, layer 2), or draw them sharper than "
            f"{CORNER:g} degrees."
        )
    line = np.roll(line, -at[0], axis=0)
    ends = np.append(at - at[0], len(line))
    closed = np.concatenate([line, line[:1]])
    return [Edge(str(k), closed[a : b + 1], "polyline") for k, (a, b) in enumerate(pairwise(ends))]


def unfolded(panel: Panel, fold: np.ndarray, where: str) -> Panel:
    """The whole of a piece drawn by half, mirrored at a line (2, 2); new edges end in 'm'.

    MeshError where no edge lies on the line
    """
    start, along = fold[0], fold[1] - fold[0]
    along = along / max(np.linalg.norm(along), 1e-12)
    across = np.array([-along[1], along[0]])

    def height(points):
        return (points - start) @ across

    def mirror(points):
        return points - 2.0 * np.outer(height(points), across)

    on = [k for k, e in enumerate(panel.edges) if np.abs(height(e.points)).max() < 10 * NEAR]
    if not on:
        raise MeshError(
            f"{where}: no edge lies on its mirror line: draw the fold as an edge of the piece."
        )
    first = on[-1] + 1
    kept = [panel.edges[(first + k) % len(panel.edges)] for k in range(len(panel.edges))]
    kept = [e for e in kept if e not in [panel.edges[k] for k in on]]
    other = [Edge(f"{e.name}m", mirror(e.points)[::-1], e.kind) for e in kept[::-1]]
    notches = np.concatenate([panel.notches, mirror(panel.notches)])
    lines = (*panel.lines, *(mirror(line) for line in panel.lines))
    whole = _with_edges(panel, (*kept, *other))
    return Panel(whole.name, whole.edges, panel.grain, notches, lines, about=panel.about)


def _with_edges(panel: Panel, edges: Sequence[Edge]) -> Panel:
    return Panel(
        panel.name, tuple(edges), panel.grain, panel.notches, panel.lines, about=panel.about
    )
