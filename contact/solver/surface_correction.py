# SPDX-License-Identifier: LGPL-3.0-or-later
"""The hook between steps for a body that is a moving closed surface of triangles, Eqs. 15 and 16.

The same outward face as `VelocityCorrection`, for any `SurfaceMotion`: velocities are corrected,
every change is an impulse and is booked. Impulses act on the vertices of the triangle touched, as
its surroundings carry the node (geometry/triangle_mesh/carried.py), and from the vertices on the
segments by the adjoint of the skinning: momentum, moments and virtual power are exact.
"""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from contact.body.segment_sets import bits_of
from contact.body.segments import Body, Pose
from contact.body.surface_motion import SurfaceMotion
from contact.geometry.triangle_mesh.carried import forget_acting, new_acting
from contact.geometry.triangle_mesh.closest import STACK

from .contact_ledger import BOOKED, take_book
from .friction import Friction
from .node_correction import NodeCorrection
from .step_record import FAR, LOOK
from .supporting_planes import PLANE
from .surface_looks import ROOM
from .surface_places import SurfacePlaces
from .surface_planes import PLANES
from .surface_step import surface_kernel

SAME = 1e-6  # of a step, that the end of the last one and the start of this may differ


class SurfaceCorrection(NodeCorrection):
    """Contact and friction with a closed surface of triangles, applied between steps.

    Parameters
    ----------
    surface : SurfaceMotion
    nodes : int, owned nodes n
    body : Body or None, whose segments the surface is bound to: rows of the ledgers are its
        segments then, and moments are about the centres that the surface gives
    friction, offset, fixed, recovery : as of `VelocityCorrection`
    allowed : (n,) int or None, segments each node can touch: triangles of these owners; None: all
    smooth : bool, meet the smooth surface (geometry/triangle_mesh/smooth.py), or the flat
        triangles: for bodies with sharp edges

    Attributes
    ----------
    last, window, fixed, allowed, active, ... : see NodeCorrection
    segment : (n,) int, owner of the triangle that pushed most in the last step; -1 without contact
    at_vertices : (nv, SHARED), what acted on the cloth at the vertices in the last step

    Raises
    ------
    ValueError
        For settings out of range and arrays of wrong shapes.
    """

    def __init__(
        self,
        surface: SurfaceMotion,
        nodes: int,
        body: Body | None = None,
        friction: Friction | ArrayLike = 0.0,
        offset: float = 0.0,
        fixed: ArrayLike | None = None,
        recovery: float = 0.1,
        allowed: ArrayLike | None = None,
        smooth: bool = True,
    ):
        self.surface, self.body = surface, body
        names = surface.names if body is None else body.names
        for name in surface.names:
            if name not in names:
                raise ValueError(
                    f"the surface is bound to a segment '{name}' that the body has not; it has: "
                    f"{', '.join(names)}"
                )
        self._rows = np.array([names.index(name) for name in surface.names])
        super().__init__(nodes, len(names), friction, offset, fixed, recovery, allowed)
        self._near = np.full(nodes, -1, np.int64)  # triangle last found
        self._sheet, self._room = np.zeros((LOOK, nodes)), np.zeros((nodes, ROOM))
        self._sheet[3] = -1.0
        self._planes, self._over = np.zeros(PLANES, PLANE), np.zeros(PLANES, np.int64)
        self._stack, self._bounds = np.zeros(STACK, np.int64), np.zeros(STACK)
        self._smooth = bool(smooth)
        self._acting = new_acting(surface.vertex_count)
        self.at_vertices, self._most = self._acting.table, 0
        self._book = np.zeros((len(surface.names), BOOKED))
        self._owners = np.ascontiguousarray(self._rows[surface.owners], np.int64)
        bits = bits_of(names if body is None else body.carriers)
        self._places = SurfacePlaces(surface, 1 << bits[self._owners], self._smooth)
        self._frame, self._shift = self._step["frame"][0], self._step["shift"][0]
        self._scratch: Any = None  # of `_ask`

    def _kernel_of(self, friction: Friction) -> Any:
        return surface_kernel(friction.kinetic_coefficient)

    def __call__(
        self,
        x: np.ndarray,
        v: np.ndarray,
        mass: np.ndarray,
        dt: float,
        t: float,
        v_old: np.ndarray | None = None,
    ) -> None:
        """Correct v for the step from t to t + dt; see `VelocityCorrection.__call__`.

        Raises
        ------
        ValueError
            For arrays of wrong shapes, a step or a mass that is none, a surface that jumps or has
            no finite places.
        FloatingPointError
            When a position or velocity is not finite, with the node.
        """
        old = v if v_old is None else v_old
        self._check(x, v, mass, old, dt, t)
        self._move(t, t + dt)
        last, window = self.last, self.window
        bad = self._correct_all(x, v, old, mass, dt)
        if bad:
            self._refuse(bad - 1, x, v, mass, t)
        if self.active > self._most:
            self._most = self.active
            self._places.warn_of_sharp(x)
        if self.active:
            pushed = self._acting.rows[: self._acting.number[0]]
            self.surface.add_to_segments(self._places.time, self.at_vertices, self._book, pushed)
        take_book(self._book, self._rows, last.table, window.table)
        last.seconds = dt
        window.seconds += dt

    def _correct_all(self, x, v, old, mass, dt):
        """Correct v of all nodes; 0, or the number + 1 of a node that is not finite."""
        last, window, at = self.last, self.window, self._places
        return self._correct(
            x, v, old, mass, dt, self.fixed, self._sets, self._look, self._sheet, self._near,
            self._room, self._away, self._step, self._smooth, at.highest, at.mesh, at.start, at.end,
            self._planes, self._over, self._stack, self._bounds, self._owners, last.impulse,
            window.impulse, self._acting, self._beds_of(slice(None)),
        )  # fmt: skip

    def _beds_of(self, nodes):
        """What the kernel of a node wants besides, of some nodes."""
        return ()

    def _ask(self, nodes, x, v, old, mass, dt, step, correct):
        k, scratch, at = len(nodes), self._scratch, self._places
        if scratch is None or len(scratch[0]) < k:
            scratch = self._scratch = (
                np.zeros(2 * k), np.zeros((2 * k, ROOM)), np.zeros((2, 2 * k, 3)),
                new_acting(self.surface.vertex_count),
            )  # fmt: skip
        away, room, impulse, acting = scratch
        room[:k, 0] = 0.0
        look = np.take(self._look, nodes, axis=1)
        look[3] = -1.0
        sets = np.take(self._sets, nodes, axis=1)
        correct(
            x, v, old, mass, dt, self.fixed[nodes], sets, look,
            np.take(self._sheet, nodes, axis=1), self._near[nodes], room[:k], away[:k],
            step, self._smooth, at.highest, at.mesh, at.start, at.end, self._planes, self._over,
            self._stack, self._bounds, self._owners, impulse[0, :k], impulse[1, :k], acting,
            self._beds_of(nodes),
        )  # fmt: skip
        forget_acting(acting)

    def _move(self, start, end):
        """Surfaces at the two times; the end of one step usually is the start of the next."""
        if start == self._start_time and end == self._end_time:
            return  # the same step once more, with other velocities
        places = self._places
        if places.mesh is None:
            places.begin(start)
        elif not self.surface.moves:
            return
        elif self._end_time is not None and abs(start - self._end_time) < SAME * (end - start):
            places.turn_over()
            self._frame += self._shift
        elif start != self._start_time:
            self._forget()
            places.restart(start)
        if self.surface.moves:
            self._work["motion"] = places.go_on(start, end, self._shift)
        self._start_time, self._end_time = start, end

    @property
    def start_pose(self) -> Pose:
        """Centres of the segments at the start of the last step; no axes, velocities and spins."""
        centres, nothing = np.zeros((len(self.last.table), 3)), np.zeros((0, 3))
        centres[self._rows] = self.surface.centres(
            self._places.time, np.zeros((len(self._rows), 3))
        )
        return Pose(centres, np.zeros((0, 3, 3)), nothing, nothing)

    @property
    def placed(self) -> tuple[Any, Any]:
        """`Mesh` and `Placed` of the surface at the start of the last step; to be read only."""
        return self._places.mesh, self._places.start

    @property
    def nearest(self) -> np.ndarray:
        """Triangle (n,) int last found under each node, -1 for none; to be read only."""
        return self._near

    @property
    def vertices(self) -> np.ndarray:
        """Places (nv, 3) [m] of the vertices at the start of the last step; to be read only."""
        return self._places.start.vertices

    def looks(self) -> tuple[np.ndarray, np.ndarray]:
        """What steps so far have found, (n, k); way [m], time [s] and `highest` of the surface,
        and the frame (3,) [m].

        Whole numbers stand as the floats of the same bits; see `VelocityCorrection.looks`.
        """
        time = np.nan if self._end_time is None else self._end_time
        whole = [self._sets[FAR].view(float), self._near.view(float)]
        table = np.column_stack([self._look.T, self._sheet.T, *whole, self._room])
        frame = self._frame + self._shift
        return table, np.array([self._work["path"], time, self._places.highest, *frame])

    def take_looks(self, table: np.ndarray, body: np.ndarray) -> None:
        """Continue from `looks()`."""
        self._look[:], self._sheet[:] = table[:, :LOOK].T, table[:, LOOK : 2 * LOOK].T
        self._sets[FAR], self._near[:] = np.ascontiguousarray(
            table[:, 2 * LOOK : 2 * LOOK + 2].T
        ).view(np.int64)
        self._room[:] = table[:, 2 * LOOK + 2 :]
        self._work["path"], time, highest, *frame = body.tolist()
        self._frame[:], self._shift[:] = frame or 0.0, 0.0
        if not np.isnan(time):
            self._places.resume(time, highest)
            self._start_time, self._end_time = None, time

    def state(self) -> dict[str, np.ndarray]:
        """What the next step needs to know of this one, for `restore` (copies)."""
        return {"segment": self.segment.copy()}

    def restore(self, state: dict[str, np.ndarray]) -> None:
        """Continue from `state()`; nodes look anew where the surface is."""
        self.segment[:] = state["segment"]
        self._forget()

    def _forget(self):
        """Let nodes look anew where the surface is."""
        self._look[3], self._sheet[3], self._room[:, 0] = -1.0, -1.0, 0.0
