# SPDX-License-Identifier: LGPL-3.0-or-later
"""Panels drafted for tests: polygons, a sheet to be rolled, a sector to be a cone."""

from pathlib import Path

import numpy as np

from meshes.patterns import Edge, Panel, SewingPattern, Stitch

FILES = Path(__file__).parents[3] / "demos" / "patterns"


def polygon(name, corners, names=None, **more):
    """Panel of straight edges through corners, counter-clockwise; edges '0', '1' ... or `names`."""
    corners = np.array(corners, float)
    names = [str(k) for k in range(len(corners))] if names is None else names
    ends = zip(names, corners, np.roll(corners, -1, axis=0), strict=True)
    return Panel(name, tuple(Edge(n, np.stack([a, b])) for n, a, b in ends), **more)


def rectangle(name, length, width, **more):
    """Panel with the edges bottom, right, top, left."""
    corners = [(0, 0), (length, 0), (length, width), (0, width)]
    return polygon(name, corners, ["bottom", "right", "top", "left"], **more)


def sewn(*pairs):
    """Stitches of pairs 'panel.edge', chains with '+'."""
    return tuple(
        Stitch(*(tuple(tuple(s.split(".")) for s in chain.split("+")) for chain in pair))
        for pair in pairs
    )


def tube(length, width, **more):
    """A sheet whose ends are sewn together."""
    sheet = rectangle("sheet", length, width, **more)
    return SewingPattern("tube", (sheet,), sewn(("sheet.left", "sheet.right")))


def cone(inner, outer, angle):
    """A sector of a ring [m], its straight edges sewn together; angle [rad]."""
    low, high = 0.5 * (np.pi - angle), 0.5 * (np.pi + angle)

    def at(radius, turn):
        return radius * np.array([np.cos(turn), np.sin(turn)])

    def arc(name, radius, start, end):
        points = [at(radius, t) for t in (start, 0.5 * (start + end), end)]
        return Edge(name, np.stack(points), "arc")

    edges = (
        arc("hem", outer, low, high),
        Edge("left", np.stack([at(outer, high), at(inner, high)])),
        arc("waist", inner, high, low),
        Edge("right", np.stack([at(inner, low), at(outer, low)])),
    )
    return SewingPattern("cone", (Panel("sector", edges),), sewn(("sector.left", "sector.right")))
