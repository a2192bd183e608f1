# SPDX-License-Identifier: LGPL-3.0-or-later
"""A sewing pattern in memory: flat panels with curved edges, and which edges are sewn together.

Everything is in m. x of a panel runs to the right and y up as it is drawn; its edges go around it
one after another. Readers of files (garmentcode.py, dxf_file.py, svg_file.py) make such values, the
mesh of panels and the sewing take them, and nothing here computes more than lengths and points.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

_SAMPLES = 401  # parameters at which the length of a curve is taken
Side = tuple[str, str]  # names of a panel and of one of its edges


@dataclass(frozen=True, eq=False)
class Edge:
    """One side of a panel, from corner to corner.

    Parameters
    ----------
    name : of the side, unique in its panel
    points : (2, 2), (3, 2) or (4, 2), control points of a line, a quadratic or cubic Bezier curve;
        (3, 2) start, middle and end of an arc; (k, 2) corners of a polyline [m]
    kind : 'bezier', 'arc' or 'polyline'
    """

    name: str
    points: np.ndarray
    kind: str = "bezier"

    def curve(self, t: ArrayLike) -> np.ndarray:
        """Points (n, 2) at parameters (n,) from 0 to 1, which are not lengths along the edge."""
        t = np.asarray(t, float)[:, None]
        p = self.points
        if self.kind == "bezier":
            between = list(p)
            while len(between) > 1:
                between = [(1 - t) * a + t * b for a, b in pairwise(between)]
            return between[0]
        if self.kind == "arc":
            return _arc(p[0], p[1], p[2], t[:, 0])
        steps = np.linalg.norm(np.diff(p, axis=0), axis=1)
        at = np.concatenate([[0.0], np.cumsum(steps)]) / steps.sum()
        return np.stack([np.interp(t[:, 0], at, x) for x in p.T], axis=1)

    @cached_property
    def _lengths(self) -> tuple[np.ndarray, np.ndarray]:
        t = np.linspace(0.0, 1.0, _SAMPLES)
        if self.kind == "polyline":  # its corners are among the parameters
            steps = np.linalg.norm(np.diff(self.points, axis=0), axis=1)
            t = np.union1d(t, np.minimum(np.cumsum(steps) / steps.sum(), 1.0))
        chords = np.linalg.norm(np.diff(self.curve(t), axis=0), axis=1)
        return t, np.concatenate([[0.0], np.cumsum(chords)])

    @property
    def length(self) -> float:
        """Length [m]."""
        return float(self._lengths[1][-1])

    def at(self, fractions: ArrayLike) -> np.ndarray:
        """Points (n, 2) at fractions (n,) of the length; ends are the corners themselves."""
        t, lengths = self._lengths
        fractions = np.asarray(fractions, float)
        points = self.curve(np.interp(fractions * lengths[-1], lengths, t))
        points[fractions == 0.0], points[fractions == 1.0] = self.points[0], self.points[-1]
        return points

    def fraction_of(self, point: ArrayLike) -> float:
        """Fraction of the length at the place of the edge that is nearest to a point (2,)."""
        line = self.at(np.linspace(0.0, 1.0, _SAMPLES))
        tail, along = line[:-1], np.diff(line, axis=0)
        arms = np.asarray(point, float) - tail
        part = np.clip(np.sum(arms * along, axis=1) / np.sum(along * along, axis=1), 0.0, 1.0)
        nearest = np.linalg.norm(arms - part[:, None] * along, axis=1).argmin()
        return float((nearest + part[nearest]) / len(tail))


def _arc(start, middle, end, t):
    """Points (n, 2) of the circle through three points, at fractions (n,) of its angle."""
    a, b = middle - start, end - start
    twice = 2.0 * (a[0] * b[1] - a[1] * b[0])
    if abs(twice) < 1e-12 * (b @ b):
        return start + t[:, None] * b
    centre = start + np.array([b[1] * (a @ a) - a[1] * (b @ b), a[0] * (b @ b) - b[0] * (a @ a)])
    centre = start + (centre - start) / twice
    first, half, last = (np.arctan2(*(p - centre)[::-1]) for p in (start, middle, end))
    way = 1.0 if (half - first) % (2 * np.pi) < (last - first) % (2 * np.pi) else -1.0
    turn = way * ((way * (last - first)) % (2 * np.pi))
    angle = first + turn * t
    return centre + np.linalg.norm(start - centre) * np.stack([np.cos(angle), np.sin(angle)], 1)


@dataclass(frozen=True, eq=False)
class Panel:
    """A flat piece of cloth.

    Parameters
    ----------
    name : unique in the pattern
    edges : around the panel, each beginning where the one before ends
    grain : (2,), direction of the warp, of any length
    notches : (k, 2), marks on the outline [m]; lines : further lines drawn inside, (k, 2) each
    rotation : (3, 3), translation : (3,) [m], of the panel about a standing body, x forward, y to
        its left, z up, None: not said; its columns are where x, y and the normal of the panel go
    about : name of the segment of the body it goes around, where the place is not said; None: by
        its name

    The outside is seen with the edges counter-clockwise: a panel drawn clockwise shows the inside.
    """

    name: str
    edges: tuple[Edge, ...]
    grain: tuple[float, float] = (0.0, 1.0)
    notches: np.ndarray = field(default_factory=lambda: np.empty((0, 2)))
    lines: tuple[np.ndarray, ...] = ()
    rotation: np.ndarray | None = None
    translation: np.ndarray | None = None
    about: str | None = None

    def edge(self, name: str) -> Edge:
        """The edge of a name; KeyError if there is none."""
        return {edge.name: edge for edge in self.edges}[name]

    def outline(self, samples: int = 32) -> np.ndarray:
        """Closed polygon (k, 2) [m], of `samples` sides an edge, one of straight edges."""
        parts = []
        for edge in self.edges:
            if edge.kind == "polyline":
                parts.append(edge.points[:-1])
            else:
                straight = edge.kind == "bezier" and len(edge.points) == 2
                parts.append(edge.curve(np.linspace(0, 1, 2 if straight else samples + 1)[:-1]))
        return np.concatenate(parts)

    @property
    def signed_area(self) -> float:
        """Area [m^2], negative if the edges run clockwise."""
        x, y = self.outline(200).T
        return float(0.5 * np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))

    @property
    def area(self) -> float:
        """Area [m^2]."""
        return abs(self.signed_area)

    def mirrored(self, name: str) -> Panel:
        """The other one of a pair, of that name: mirrored at the y axis, its sides keep names."""
        flip = np.array([-1.0, 1.0])
        edges = tuple(Edge(e.name, e.points * flip, e.kind) for e in self.edges)
        # run the other way, so that both show the outside
        edges = tuple(Edge(e.name, e.points[::-1], e.kind) for e in edges[::-1])
        lines = tuple(line * flip for line in self.lines)
        grain = (-self.grain[0], self.grain[1])
        return Panel(name, edges, grain, self.notches * flip, lines, about=self.about)


@dataclass(frozen=True)
class Stitch:
    """Two chains of edges sewn together.

    Parameters
    ----------
    first, second : (panel, edge) one after another along the seam
    along : True if both run the same way along the seam, False against each other, None: by where
        they lie, or against each other, as the edges of panels seen from outside do
    """

    first: tuple[Side, ...]
    second: tuple[Side, ...]
    along: bool | None = None


@dataclass(frozen=True)
class SewingPattern:
    """Panels and how they are sewn; `source` names the file in messages.

    `notes` : what was chosen or left out in reading, a sentence each.
    """

    source: str
    panels: tuple[Panel, ...]
    stitches: tuple[Stitch, ...] = ()
    notes: tuple[str, ...] = ()

    def panel(self, name: str) -> Panel:
        """The panel of a name; KeyError if there is none."""
        return {panel.name: panel for panel in self.panels}[name]

    def chain_length(self, chain: Sequence[Side]) -> float:
        """Length [m] of edges one after another."""
        return sum(self.panel(panel).edge(edge).length for panel, edge in chain)

    @property
    def darts(self) -> tuple[Stitch, ...]:
        """Stitches of a panel with itself whose edges meet in a point: wedges taken out of it."""
        found = []
        for stitch in self.stitches:
            if len(stitch.first) == len(stitch.second) == 1:
                (one, a), (other, b) = stitch.first[0], stitch.second[0]
                names = [edge.name for edge in self.panel(one).edges]
                if one == other and abs(names.index(a) - names.index(b)) in (1, len(names) - 1):
                    found.append(stitch)
        return tuple(found)
