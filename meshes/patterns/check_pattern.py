# SPDX-License-Identifier: LGPL-3.0-or-later
"""What makes panels and stitches a pattern that can be sewn, and the sentence for each fault.

All of it is looked at before anything is meshed; every sentence names file, panel and edge.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from meshes.validity import MeshError

from .pattern import Panel, SewingPattern, Side, Stitch

EASE = 2.5  # longer over shorter side of a seam; a gathered skirt has 1.5 to 2
SHORTEST = 1e-4  # of an edge [m]
LAYERS = ("facing", "interfacing", "lining", "pocket")  # words of names of panels
SIZES = (0.01, 5.0)  # of the largest panel [m]; a pocket, a ball gown


def check_pattern(pattern: SewingPattern) -> None:
    """MeshError for the first fault of a pattern."""
    source = pattern.source
    if not pattern.panels:
        raise MeshError(f"{source}: there is no panel in it, export the outlines of the pieces.")
    names = [panel.name for panel in pattern.panels]
    for name in names:
        if names.count(name) > 1:
            raise MeshError(
                f"{source}: {names.count(name)} panels are called '{name}': name one otherwise, as "
                "'right_sleeve' beside 'left_sleeve'."
            )
    for panel in pattern.panels:
        _check_outline(panel, f"{source}: panel '{panel.name}'")
    widest = max(float(np.ptp(panel.outline(), axis=0).max()) for panel in pattern.panels)
    if not SIZES[0] <= widest <= SIZES[1]:
        raise MeshError(
            f"{source}: its largest panel is {widest:.3g} m long, which no garment has: give the "
            "file's unit (unit under [garment]: m, cm, mm or in)."
        )
    _check_layers(pattern)
    check_stitches(pattern, pattern.stitches)
    _check_pairs(pattern)


def _check_layers(pattern: SewingPattern) -> None:
    """MeshError for a panel that lies on another one: layers are not placed apart."""
    for panel in pattern.panels:
        layer = next((w for w in re.findall("[a-z]+", panel.name.lower()) if w in LAYERS), None)
        if layer is not None:
            raise MeshError(
                f"{pattern.source}: panel '{panel.name}' is a {layer}, which lies on another "
                "layer, and layers of a pattern are not placed apart here: leave it out, or name "
                "it otherwise if it is none."
            )


def _check_outline(panel: Panel, where: str) -> None:
    if len(panel.edges) < 2:
        raise MeshError(f"{where} has {len(panel.edges)} edges: give an outline that closes.")
    names = [edge.name for edge in panel.edges]
    for edge in panel.edges:
        if names.count(edge.name) > 1:
            raise MeshError(f"{where} has two edges '{edge.name}': name one of them otherwise.")
        if not np.isfinite(edge.points).all():
            raise MeshError(
                f"{where}, edge '{edge.name}': a point of it is {edge.points.tolist()}, give "
                "finite numbers."
            )
    for edge, after in zip(panel.edges, panel.edges[1:] + panel.edges[:1], strict=True):
        gap = float(np.linalg.norm(edge.points[-1] - after.points[0]))
        if gap > SHORTEST:
            raise MeshError(
                f"{where}, edge '{edge.name}': it ends {1e3 * gap:.3g} mm before edge "
                f"'{after.name}' begins: the outline is open, close it there."
            )
        if edge.length < SHORTEST:
            raise MeshError(
                f"{where}, edge '{edge.name}': it has no length, leave it out and join its ends."
            )
    if not np.isfinite(panel.grain).all() or np.hypot(*panel.grain) < 1e-9:
        raise MeshError(f"{where}: its grain line has no direction, draw it longer.")
    crossed = _crossing(panel)
    if crossed is not None:
        one, other = crossed
        raise MeshError(
            f"{where}: its outline crosses itself, edge '{one}' meets edge '{other}': draw it so "
            "that it goes around once."
        )


def _crossing(panel):
    """Names of two edges of an outline that cross, None if none do."""
    lines = [
        edge.points
        if edge.kind == "polyline" or len(edge.points) == 2
        else edge.curve(np.linspace(0.0, 1.0, 33))
        for edge in panel.edges
    ]
    tails = np.concatenate([line[:-1] for line in lines])
    heads = np.concatenate([line[1:] for line in lines])
    owner = np.repeat(np.arange(len(lines)), [len(line) - 1 for line in lines])
    count = len(tails)

    def side_of(points):
        line, offset = (heads - tails)[:, None], points[None] - tails[:, None]
        area = line[..., 0] * offset[..., 1] - line[..., 1] * offset[..., 0]
        return np.sign(np.where(np.abs(area) < 1e-12, 0.0, area))

    apart = side_of(tails) * side_of(heads)
    low, high = np.minimum(tails, heads), np.maximum(tails, heads)
    crossing = (apart <= 0) & (apart.T <= 0)
    # those in one line pass the test of sides wherever they lie
    crossing &= ((low[:, None] <= high[None]) & (low[None] <= high[:, None])).all(axis=2)
    steps = (np.arange(count)[:, None] - np.arange(count)[None]) % count
    crossing &= (steps > 1) & (steps < count - 1)
    if not crossing.any():
        return None
    one, other = np.argwhere(crossing)[0]
    return panel.edges[owner[one]].name, panel.edges[owner[other]].name


def check_stitches(pattern: SewingPattern, stitches: Sequence[Stitch]) -> None:
    """MeshError for stitches of what is not there, twice, or of lengths that do not fit."""
    source = pattern.source
    seen: dict[Side, int] = {}
    for number, stitch in enumerate(stitches):
        for chain in (stitch.first, stitch.second):
            if not chain:
                raise MeshError(f"{source}: stitch {number} has a side without edges: name one.")
            for side in chain:
                check_side(pattern, side, f"stitch {number}")
                if side in seen:
                    raise MeshError(
                        f"{source}: edge '{side[1]}' of panel '{side[0]}' is in stitch "
                        f"{seen[side]} and in stitch {number}: an edge is sewn once, cut it in two "
                        "or leave one stitch out."
                    )
                seen[side] = number
        one, other = (pattern.chain_length(chain) for chain in (stitch.first, stitch.second))
        ratio = max(one, other) / min(one, other)
        if ratio > EASE:
            (a, b), (c, d) = stitch.first[0], stitch.second[0]
            raise MeshError(
                f"{source}: stitch {number} sews edge '{b}' of panel '{a}' ({one:.3f} m) to edge "
                f"'{d}' of panel '{c}' ({other:.3f} m), {ratio:.2f} to 1, and up to {EASE:g} to 1 "
                "can be gathered: sew it to all edges that meet it, or mend the lengths."
            )


def check_side(pattern: SewingPattern, side: Side, where: str) -> None:
    """MeshError if there is no such panel or edge; `where` says who names it."""
    panel, edge = side
    known = {p.name: p for p in pattern.panels}
    if panel not in known:
        raise MeshError(
            f"{pattern.source}: {where} names panel '{panel}', which is not there: there are "
            f"{', '.join(known)}."
        )
    names = [e.name for e in known[panel].edges]
    if edge not in names:
        raise MeshError(
            f"{pattern.source}: {where} names edge '{edge}' of panel '{panel}', which is not "
            f"there: it has {', '.join(names)}."
        )


def _check_pairs(pattern):
    """Panels 'left...' and 'right...' are each other's mirror image, not twice the same."""
    panels = {panel.name: panel for panel in pattern.panels}
    for name, panel in panels.items():
        mate = panels.get(name.replace("left", "right")) if "left" in name else None
        if mate is None or len(mate.edges) != len(panel.edges):
            continue
        same, mirrored = (_unlike(panel, mate, flip) for flip in (False, True))
        size = float(np.ptp(panel.outline(), axis=0).max())
        if same < 1e-3 * size and mirrored > 1e-2 * size:
            raise MeshError(
                f"{pattern.source}: panel '{mate.name}' is panel '{name}' once more, so that there "
                f"are two left ones: mirror it, edge '{mate.edges[0].name}' and all others."
            )


def _unlike(one, other, flip):
    """Distance [m] of two outlines, as seen from outside, laid onto each other at best."""
    a, b = (_seen_from_outside(panel) for panel in (one, other))
    if flip:
        b = (b * [-1.0, 1.0])[::-1, ::-1]
    best = np.inf
    for k in range(len(b)):
        p, q = a.reshape(-1, 2), np.roll(b, k, axis=0).reshape(-1, 2)
        p, q = p - p.mean(axis=0), q - q.mean(axis=0)
        cosine, sine = np.sum(p * q), np.sum(q[:, 0] * p[:, 1] - q[:, 1] * p[:, 0])
        angle = np.arctan2(sine, cosine)
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        best = min(best, float(np.abs(p - q @ turn.T).max()))
    return best


def _seen_from_outside(panel):
    """Points (edges, 9, 2) along the edges, counter-clockwise."""
    points = np.stack([edge.at(np.linspace(0.0, 1.0, 9)) for edge in panel.edges])
    if panel.signed_area < 0.0:  # drawn from the inside
        return points * [-1.0, 1.0]
    return points
