# SPDX-License-Identifier: LGPL-3.0-or-later
"""Panels sewn into one surface: one node where a seam joins two, and a shape with little strain.

Stitched nodes become one at the middle of the places of their panels about the body; the strain of
that is relaxed by particles on springs (relax.py). What a cell is like without stress stays that of
its panel, in `Surface.flat`, turned so that the grain line is its first axis.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from meshes.repair import TURNED, orient, turned_flat
from meshes.sheets import components
from meshes.surface import Surface
from meshes.topology import segments_of_line
from meshes.validity import MeshError

from .check_pattern import check_pattern
from .crossings import crossings
from .panel_mesh import mesh_panel
from .pattern import Panel, SewingPattern, Stitch
from .placing import Axis, place_panels
from .relax import StandingBody, relax, sides_of
from .seams import along_or_against, ease_notes, spacings


def sew(
    pattern: SewingPattern,
    cell_size: float = 0.025,
    axes: Mapping[str, Axis] | None = None,
    body: StandingBody | None = None,
    steps: int = 600,
    top: float | None = None,
    threaded: bool = False,
) -> Surface:
    """Surface of the sewn garment, about where its panels are placed.

    Parameters
    ----------
    pattern : SewingPattern; cell_size : wanted side of the quads [m]
    axes : cylinders about segments of the body, for panels without a place of their own; None: of
        a standing person, see `placing.STANDING`
    body : a standing body that the garment is sewn around, None: around nothing
    steps : of the relaxation, 0 for none
    threaded : whether the body is inside from the beginning, see `relax.relax`
    top : height [m] to which the highest point of the panels is brought before they are sewn

    Returns
    -------
    Surface of quads with `flat`, `panels`, and the edges 'seam_0', ... in the order of the
    stitches, and 'PANEL.EDGE' of every edge that is not sewn. Its `notes` tell eased seams.

    Raises
    ------
    MeshError : in one sentence for a pattern that cannot be sewn
    """
    check_pattern(pattern)
    if not 1e-3 <= cell_size <= 0.5:
        raise ValueError(f"cell_size is a length in m, as 0.025, not {cell_size}")
    places = place_panels(pattern, axes)
    stitches = [
        Stitch(s.first, s.second, along_or_against(pattern, s, places.flat))
        for s in pattern.stitches
    ]
    fractions, seams = spacings(pattern, stitches, 2.0 * cell_size)
    made, first, total = {}, {}, 0
    for panel in pattern.panels:
        own = {edge.name: fractions[panel.name, edge.name] for edge in panel.edges}
        mesh = mesh_panel(panel, own, 2.0 * cell_size, pattern.source)
        made[panel.name], first[panel.name] = mesh, total
        total += len(mesh.points)
    pairs = [_mates(one, other, made, first, pattern.source) for one, other in seams]
    joined = np.concatenate([np.empty((0, 2), np.int64), *(p for pair in pairs for p in pair)])
    label = components(joined, total)
    _, label = np.unique(label, return_inverse=True)
    count = int(label.max()) + 1
    space = np.concatenate([places.put(panel, made[panel.name].points) for panel in pattern.panels])
    if top is not None:
        space[:, 2] += top - space[:, 2].max()
    often = np.bincount(label, minlength=count)[:, None]
    points = np.stack([np.bincount(label, x, count) for x in space.T], axis=1) / often
    cells, flat, panels = _cells(pattern, made, first, label)
    _check_folded(pattern, cells, panels)
    lines = _lines(pattern, made, first, label, [main for main, _ in pairs])
    surface = Surface(points, cells, lines, panels=panels, source=pattern.source, verify=False)
    turned = orient(surface, majority=True)
    flipped = (turned.cells != cells).any(axis=1)
    if flipped.any():
        flat = turned_flat(flat, flipped)
    shape = points
    if steps:
        side = sides_of(points, list(panels.values()), cells)
        shape = relax(points, turned.cells, flat, steps, side, body, threaded)
    notes = *pattern.notes, *ease_notes(pattern), *_crossing_note(pattern, shape, turned.cells)
    return turned.replace(
        points=shape,
        flat=flat,
        warp=warp_in_space(shape, turned.cells, flat),
        directors=None,
        verify=True,
        notes=notes,
    )


def _lines(pattern, made, first, label, seams):
    """Segments of the seams, and of every edge that is not sewn, by name."""
    edges = {f"seam_{k}": label[main[:, 0]] for k, main in enumerate(seams)}
    sewn = {side for s in pattern.stitches for side in (*s.first, *s.second)}
    for panel in pattern.panels:
        for edge in panel.edges:
            if (panel.name, edge.name) not in sewn:
                nodes = first[panel.name] + made[panel.name].edges[edge.name]
                edges[f"{panel.name}.{edge.name}"] = label[nodes]
    return {name: segments_of_line(nodes) for name, nodes in edges.items()}


def _crossing_note(pattern, points, cells):
    """A sentence where the sewn cloth goes through itself."""
    through = crossings(points, cells)
    if not len(through):
        return ()
    place = np.round(points[through[0, 0]], 3).tolist()
    return (
        f"{pattern.source}: the sewn cloth goes through itself at {len(through)} sides, first at "
        f"{place} m: take smaller cells, or place the panels further apart.",
    )


def warp_in_space(points: np.ndarray, cells: np.ndarray, flat: np.ndarray) -> np.ndarray:
    """Unit vectors (m, 3) along the warp, the first axis of the flat cells (m, 4, 2)."""
    G, X = (
        np.stack(
            [
                0.5 * (c[:, 1] - c[:, 0] + c[:, 2] - c[:, 3]),
                0.5 * (c[:, 3] - c[:, 0] + c[:, 2] - c[:, 1]),
            ],
            axis=2,
        )
        for c in (flat, points[cells])
    )
    along = np.einsum("mia,ma->mi", X, np.linalg.inv(G)[:, :, 0])
    return along / np.linalg.norm(along, axis=1, keepdims=True)


def _chain_nodes(chain, made, first):
    """Nodes of each part of a chain, in the chain's direction."""
    nodes: list[np.ndarray] = []
    for part in chain:
        panel, edge = part.side
        own = first[panel] + made[panel].edges[edge]
        nodes.append(own[::-1] if part.back else own)
    return nodes


def _mates(one, other, made, first, source):
    """Pairs (k, 2) of nodes of two chains that become one."""
    lists = [_chain_nodes(chain, made, first) for chain in (one, other)]
    # parts of a chain may meet at two nodes of two panels: both count
    places = []
    for parts in lists:
        number, out = 0, []
        for nodes in parts:
            out.append(np.arange(number, number + len(nodes)))
            number += len(nodes) - 1
        places.append((np.concatenate(out), np.concatenate(parts), number + 1))
    if places[0][2] != places[1][2]:
        raise MeshError(
            f"{source}: the seam of {one[0].side[0]}.{one[0].side[1]} has {places[0][2]} nodes on "
            f"one side and {places[1][2]} on the other: move notches or corners further apart."
        )
    at = [[[] for _ in range(places[0][2])] for _ in range(2)]
    for k, (where, nodes, _) in enumerate(places):
        for place, node in zip(where.tolist(), nodes.tolist(), strict=True):
            at[k][place].append(node)
    # the first of each place makes the seam; of panels side by side both have a node there
    main, more = [], []
    for ones, others in zip(*at, strict=True):
        main.append((ones[0], others[0]))
        more += [(ones[0], n) for n in ones[1:]] + [(others[0], n) for n in others[1:]]
    return np.array(main, np.int64), np.array(more, np.int64).reshape(-1, 2)


def _cells(pattern, made, first, label):
    """Cells (m, 4) of all panels, their flat corners (m, 4, 2), rows of each panel."""
    cells, flat, panels, row = [], [], {}, 0
    for panel in pattern.panels:
        mesh = made[panel.name]
        own, corners = mesh.cells, mesh.points[mesh.cells]
        corners = corners @ _to_grain(panel)
        if panel.signed_area < 0.0:  # drawn from the inside
            own, corners = own[:, TURNED[4]], corners[:, TURNED[4]] * np.array([1.0, -1.0])
        cells.append(label[first[panel.name] + own])
        flat.append(corners)
        panels[panel.name] = np.arange(row, row + len(own))
        row += len(own)
    return np.concatenate(cells), np.concatenate(flat), panels


def _to_grain(panel: Panel) -> np.ndarray:
    """Matrix that takes rows of points to axes along and across the grain line."""
    x, y = np.asarray(panel.grain) / np.hypot(*panel.grain)
    return np.array([[x, -y], [y, x]])


def _check_folded(pattern, cells, panels):
    """MeshError where sewing leaves a cell with two corners in one point."""
    twice = (np.diff(np.sort(cells, axis=1), axis=1) == 0).any(axis=1)
    if not twice.any():
        return
    bad = int(np.argmax(twice))
    name = next(name for name, rows in panels.items() if bad in rows)
    raise MeshError(
        f"{pattern.source}: panel '{name}' is sewn so that a cell of it has two corners in one "
        "point: check the direction of its stitches, or take smaller cells."
    )
