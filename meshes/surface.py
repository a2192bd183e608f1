"""The Surface: points, cells, unit directors and names of a garment before any finite element.

A Surface is a value. Every way of making one ends in the same check, so whatever holds a Surface
may rely on an oriented manifold of good cells. Repairs start from ``verify=False``.
"""
# SPDX-License-Identifier: LGPL-3.0-or-later

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from . import geometry
from .geometry import nodal_normals
from .seam_directors import seam_directors
from .subdivide import halve
from .topology import boundary_segments, chain, directed_edges
from .validity import MeshError, check

Locator = Callable[[np.ndarray], np.ndarray]  # points (n, 3) -> True for those that are chosen (n,)

__all__ = ["MeshError", "Surface", "check", "nodal_normals"]


@dataclass(frozen=True, eq=False, repr=False)
class Surface:
    """A shell's middle surface.

    Parameters
    ----------
    points : (n, 3) coordinates in m.
    cells : (m, 3), (m, 4) or (m, 9) point indices in cyclic order; 9-node cells list corners 0-3,
        the middles of edges 01, 12, 23, 30 and the centre.
    edges : named lines of cell edges, each (k, 2) or, for 9-node cells, (k, 3) [end, end, middle];
        kept head to tail where a line does not branch.
    directors : (n, 3) unit vectors; None takes `nodal_normals`, at seams of three
        cells and more the middle between the sheets.
    warp : None, (3,) or (m, 3) direction of the warp yarns.
    panels : named groups of cell indices.
    flat : None, or (m, corners, 2) where the corners of each straight cell lie in the flat pattern
        it was cut from, in m, counter-clockwise, warp along the first axis. It is the shape without
        stress; a sewn point has one place in space and one in each panel.
    source : file or generator, for messages.
    verify : False leaves out the check and the directors, for a mesh still to be repaired.
    notes : what was chosen or mended where it comes from a file, a sentence each.

    Raises
    ------
    MeshError : as described in `check`.

    Examples
    --------
    >>> import meshes
    >>> corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    >>> meshes.Surface(corners, [(0, 1, 2, 3)], {"hem": [(0, 1)]}, source="square")
    Surface(square: 4 points, 1 quadrilateral of degree 1; edges hem)
    """

    points: np.ndarray
    cells: np.ndarray
    edges: dict = field(default_factory=dict)
    directors: np.ndarray | None = None
    warp: np.ndarray | None = None
    panels: dict = field(default_factory=dict)
    flat: np.ndarray | None = field(default=None, kw_only=True)
    source: str = "surface"
    verify: bool = field(default=True, repr=False)
    notes: tuple[str, ...] = field(default=(), repr=False)

    def __post_init__(self):
        put = object.__setattr__
        put(self, "points", self._floats("points", self.points))
        put(self, "cells", self._indices("cells", self.cells))
        for name in ("directors", "warp", "flat"):
            value = getattr(self, name)
            put(self, name, None if value is None else self._floats(name, value))
        edges = {k: self._indices(f"edge '{k}'", v) for k, v in dict(self.edges).items()}
        edges = {k: chain(v) if v.ndim == 2 and v.shape[1] >= 2 else v for k, v in edges.items()}
        put(self, "edges", edges)
        panels = {k: self._indices(f"panel '{k}'", v) for k, v in dict(self.panels).items()}
        put(self, "panels", panels)
        if self.verify:
            check(self)
            if self.directors is None:
                try:
                    normals = nodal_normals(self.points, self.cells)
                except ValueError as error:
                    raise MeshError(
                        f"{self.source}: {error}; give the directors or separate the points."
                    ) from None
                put(self, "directors", seam_directors(self.points, self.cells, normals))

    def __repr__(self):
        count = len(self.cells)
        kind = f"{count} {self.kind}{'' if count == 1 else 's'} of degree {self.degree}"
        edges = f"; edges {', '.join(self.edges)}" if self.edges else ""
        panels = f"; panels {', '.join(self.panels)}" if self.panels else ""
        return f"Surface({self.source}: {len(self.points)} points, {kind}{edges}{panels})"

    def _floats(self, name, value):
        try:
            return np.array(value, dtype=np.float64, order="C")
        except (TypeError, ValueError):
            raise MeshError(f"{self.source}: {name} must be an array of numbers.") from None

    def _indices(self, name, value):
        try:
            array = np.array(value, order="C")
            # An empty list has no integer type of its own.
            if array.size and array.dtype.kind not in "iu":
                raise TypeError
            return array.astype(np.int64)
        except (TypeError, ValueError):
            raise MeshError(f"{self.source}: {name} must be an array of whole numbers.") from None

    @property
    def degree(self) -> int:
        """1 for straight cells, 2 for 9-node cells."""
        return 2 if self.cells.shape[1] == 9 else 1

    @property
    def kind(self) -> str:
        """'triangle' or 'quadrilateral'."""
        return "triangle" if self.cells.shape[1] == 3 else "quadrilateral"

    @property
    def cell_areas(self) -> np.ndarray:
        """Area of each cell (m,) in m^2."""
        return geometry.cell_areas(self.points, self.cells)

    @property
    def corners_at_rest(self) -> np.ndarray:
        """Points of each cell without stress (m, nodes, 3) in m, those of `flat` at height 0."""
        if self.flat is None:
            return self.points[self.cells]
        return np.concatenate([self.flat, np.zeros((*self.cells.shape, 1))], axis=2)

    @property
    def area(self) -> float:
        """Area of the surface in m^2."""
        return float(self.cell_areas.sum())

    @property
    def mean_cell_size(self) -> float:
        """Square root of the mean cell area, in m."""
        return float(np.sqrt(self.cell_areas.mean()))

    @property
    def bounds(self) -> np.ndarray:
        """Lowest and highest coordinates (2, 3) in m."""
        return np.stack([self.points.min(axis=0), self.points.max(axis=0)])

    def replace(self, **changes: Any) -> Surface:
        """A copy with other fields; new points or cells without directors get new directors."""
        if ("points" in changes or "cells" in changes) and "directors" not in changes:
            changes["directors"] = None
        if "cells" in changes and self.flat is not None and "flat" not in changes:
            raise MeshError(
                f"{self.source}: new cells of a garment cut from flat panels need their places in "
                "these: give flat, or flat=None for the shape it has now."
            )
        return dataclasses.replace(self, **changes)

    def with_edges(self, **lines: ArrayLike | Locator) -> Surface:
        """A copy with further named edges.

        Parameters
        ----------
        lines : name = array of segments (k, 2 | 3), or name = locator; a locator takes the points
            (n, 3) and returns a mask (n,), and selects the boundary segments with all their points
            in it. Segments (k, 2) of 9-node cells get their middle points filled in.

        Raises
        ------
        MeshError : if a locator selects nothing or a segment is not an edge of a cell.
        """
        edges = dict(self.edges)
        boundary = None
        for name, line in lines.items():
            if callable(line):
                if boundary is None:
                    boundary = boundary_segments(self.cells)
                mask = np.asarray(line(self.points))
                if mask.shape != (len(self.points),) or mask.dtype != bool:
                    raise MeshError(
                        f"{self.source}: the locator of edge '{name}' must return one True or "
                        f"False for each of the {len(self.points)} points."
                    )
                edges[name] = boundary[mask[boundary].all(axis=1)]
                if len(edges[name]) == 0:
                    raise MeshError(
                        f"{self.source}: the locator of edge '{name}' selects no boundary segment "
                        f"({int(mask.sum())} points satisfy it), widen its tolerance."
                    )
            else:
                edges[name] = self._with_middles(self._indices(f"edge '{name}'", line))
        return self.replace(edges=edges)

    def _with_middles(self, line):
        if self.degree == 1 or line.ndim != 2 or line.shape[1] != 2 or len(line) == 0:
            return line
        # A segment that is no cell edge gets the middle -1, which the check then reports.
        known = directed_edges(self.cells)
        size = int(max(len(self.points), line.max() + 1))
        return halve(line, known, known[:, 2], size)[:, [0, 2, 1]]

    def transform(
        self,
        rotation: ArrayLike | None = None,
        translation: ArrayLike | None = None,
        scale: float | None = None,
    ) -> Surface:
        """A copy at scale * rotation @ x + translation.

        Parameters
        ----------
        rotation : (3, 3) proper rotation matrix; turns directors and warp too.
        translation : (3,) in m.
        scale : positive number.

        Raises
        ------
        ValueError : if the rotation is not a proper rotation or the scale is not positive.
        """
        turn = np.eye(3) if rotation is None else np.asarray(rotation, dtype=np.float64)
        if turn.shape != (3, 3) or not np.allclose(turn @ turn.T, np.eye(3), atol=1e-9):
            raise ValueError("rotation must be an orthogonal 3 x 3 matrix")
        if np.linalg.det(turn) < 0.0:
            raise ValueError("rotation must not mirror: its determinant must be +1")
        factor = 1.0 if scale is None else float(scale)
        if not (np.isfinite(factor) and factor > 0.0):
            raise ValueError(f"scale must be a positive number, not {scale}")
        shift = np.zeros(3) if translation is None else np.asarray(translation, dtype=np.float64)
        if shift.shape != (3,):
            raise ValueError(f"translation must have three components, not shape {shift.shape}")
        return self.replace(
            points=factor * self.points @ turn.T + shift,
            directors=None if self.directors is None else self.directors @ turn.T,
            warp=None if self.warp is None else self.warp @ turn.T,
            flat=None if self.flat is None else factor * self.flat,
        )
