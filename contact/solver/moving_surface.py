# SPDX-License-Identifier: LGPL-3.0-or-later
"""A surface of triangles over an implicit step: its places, its velocity at the end, its books.

A surface gives places alone. The velocity at the end of a step is a difference over its last part,
of second order; from it the work of the surface is the virtual power of its segments.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from contact.body.segments import Body
from contact.body.surface_motion import SurfaceMotion
from contact.geometry.triangle_mesh.carried import forget_acting, new_acting
from contact.geometry.triangle_mesh.closest import STACK

from .contact_ledger import BOOKED
from .segment_motion import SEGMENT
from .segment_obstacle import SegmentObstacle, Segments
from .surface_obstacle import KERNELS, SurfaceWorld
from .surface_places import SurfacePlaces

LAST = 1 / 64  # part of a step over which velocities are differences


class SurfaceObstacle:
    """A closed surface of triangles over a step, and shapes of the body that are met besides.

    Parameters
    ----------
    surface : SurfaceMotion; body : Body or None, whose segments it is bound to
    nodes : int, of this rank; offset : float [m]; smooth : bool, see SurfaceCorrection
    shapes : names of segments of the body

    Attributes
    ----------
    names : of the rows of the ledger; met : names and shapes of the segments that are met besides
    kernels : Obstacle; world : SurfaceWorld, after the first `move`

    Raises
    ------
    ValueError for a surface bound to segments that the body has not, and for shapes without a body
    """

    kernels = KERNELS

    def __init__(
        self,
        surface: SurfaceMotion,
        body: Body | None,
        nodes: int,
        offset: float,
        smooth: bool,
        shapes: Sequence[str],
    ) -> None:
        self._surface = surface
        self.names = tuple(surface.names if body is None else body.names)
        for name in surface.names:
            if name not in self.names:
                raise ValueError(
                    f"the surface is bound to a segment '{name}' that the body has not; it has: "
                    f"{', '.join(self.names)}"
                )
        self._rows = np.array([self.names.index(name) for name in surface.names])
        self._shapes: SegmentObstacle | None = None
        self.met: Any = ((), ())
        if shapes:
            if body is None:
                raise ValueError(
                    f"the shapes of {', '.join(shapes)} are those of a body: give it, as "
                    "Contact(body, surface=surface, shapes=...)"
                )
            self._shapes = SegmentObstacle(body, offset, tuple(shapes))
            self.met = self._shapes.met
        self._smooth = smooth
        self._places = SurfacePlaces(surface, np.ones(len(surface.triangles), np.int64), smooth)
        self._acting = new_acting(surface.vertex_count)
        self._book = np.zeros((len(surface.names), BOOKED))
        self._near, self._look = np.full(nodes, -1, np.int64), np.zeros((nodes, 5))
        self._path, self._shift, self._before = (
            np.zeros(2),
            np.zeros(3),
            np.zeros((surface.vertex_count, 3)),
        )
        self._end = np.nan
        self.world: Any = None

    def move(self, t: float, dt: float) -> None:
        """Place the surface at the start and at the end of a step; ValueError if it jumps."""
        places, surface = self._places, self._surface
        if self._shapes is not None:
            self._shapes.move(t, dt)
        if places.mesh is None:
            places.begin(t)
            self.world = self._world()
        elif surface.moves:
            places.restart(t)
        if abs(t - self._end) > 1e-6 * dt:
            self._near[:] = -1  # not where the last step ended
        if surface.moves:
            motion = places.go_on(t, t + dt, self._shift)
            self._path[1] = motion + np.linalg.norm(self._shift)
            rates, last = self.world.rates, LAST * dt
            # (3 x(t + dt) - 4 x(t + dt - h) + x(t + dt - 2 h)) / (2 h)
            np.multiply(places.end.vertices, 1.5 / last, out=rates)
            for back, weight in ((1, -2.0), (2, 0.5)):
                self._before = surface.positions(t + dt - back * last, self._before)
                rates += weight / last * self._before
        self._next = t, t + dt

    def _world(self):
        """What kernels know."""
        places, surface = self._places, self._surface
        rows = np.ascontiguousarray(self._rows[surface.owners], np.int64)
        empty = np.zeros(0, np.int64)
        none, nothing = np.zeros((0, 3)), np.zeros((0, BOOKED))
        shapes = Segments(np.zeros(0, SEGMENT), empty, none, none, nothing, np.zeros(7), none)
        if self._shapes is not None:
            shapes = self._shapes.world
        count = surface.vertex_count
        return SurfaceWorld(
            shapes, places.mesh, places.start, places.end, rows, np.array([self._smooth]),
            np.array([places.highest]), np.zeros((count, 3)), self._acting, self._near, self._look,
            self._path, np.zeros(STACK, np.int64), np.zeros(STACK), np.zeros(7),
            np.zeros(7),
        )  # fmt: skip

    def booked(self, table: np.ndarray, x: np.ndarray) -> None:
        """Take what was booked since the last call into a ledger's table; x (n, 3) : nodes [m]."""
        table[:] = 0.0
        if self._shapes is not None:
            self._shapes.booked(table, x)
        self._book[:] = 0.0
        pushed = self._acting.rows[: self._acting.number[0]]
        if len(pushed):
            if self._smooth:
                self._places.warn_of_sharp(x)
            self._surface.add_to_segments(self._next[1], self._acting.table, self._book, pushed)
            table[self._rows] += self._book
        forget_acting(self._acting)

    def settle(self) -> None:
        """A step is done: what nodes know of the surface is as old as its way."""
        self._end = self._next[1]
        self._path[0] += self._path[1]
