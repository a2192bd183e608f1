# SPDX-License-Identifier: LGPL-3.0-or-later
"""A closed surface of triangles as skin of several segments, flesh pressed behind bent joints.

Where the skin spans between parts that turn apart, as between the legs, it is drawn smooth
(`smoothing`), which is linear too.

A `surface_motion.SurfaceMotion`: what contact asks of it is where vertices are, and the adjoint.
Weights, place and pose at binding stay; a pose is looked up once for each time, and those of the
two times are kept, as those of the start and the end of a step.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from .bend_planes import BENDS, plane_rates, set_planes
from .bulge import Bulge, BulgeState, Bulging
from .dual_quaternions import set_rate
from .segments import Pose
from .skin_adjoint import add_skin
from .skinning import SKIN, place_skin, set_motions, skin_rates
from .smoothing import Smoothing

LEAST = 2e-3  # weights below are left out
ALONE = 0.9  # weight of two segments above which no other carries a vertex
ROOM = 0.8  # of the margin, the room that is left at most


class Bend(NamedTuple):
    """Two segments whose flesh meets, as behind a joint that bends.

    above, below : its segments
    centre : (3,) at binding [m]
    far_above, far_below : (3,), points that the lines of both segments go to from there [m]
    margin : from the halving plane, within which flesh is pressed at most [m]
    near : the same as a part of the distance at binding
    room : from the halving plane, that is left for cloth [m]
    parts : (n,) float 0 to 1, of the press that the vertices feel, those above 0 in no other bend;
        None: of those vertices that the two alone carry, each is in the bend of the nearest centre
    """

    above: str
    below: str
    centre: np.ndarray
    far_above: np.ndarray
    far_below: np.ndarray
    margin: float = 0.015
    near: float = 0.5
    room: float = 0.0
    parts: np.ndarray | None = None


class _State(NamedTuple):
    """The segments at a time (1,) [s]: pose, motions, matrices and planes as of `skinning`.

    bulge : of the skin
    """

    time: np.ndarray
    pose: Pose
    motions: np.ndarray
    matrices: np.ndarray
    planes: np.ndarray
    bulge: BulgeState


class SkinnedSurface:
    """A closed surface bound to segments.

    Parameters
    ----------
    vertices : (n, 3) float, in the world at binding [m]
    triangles : (nt, 3) int, counterclockwise seen from outside
    weights : (n, m) float, of the segments, rows of sum 1
    names : m segments
    pose : function (t, out Pose) that fills the pose of the m segments at time t [s]
    bound : Pose of the segments at binding
    bends : joints where flesh meets flesh
    smoothing : rows of the matrix (n, n) as starts (n + 1,), columns and parts, or None
    bulge : how it bulges as joints bend, or None

    Raises
    ------
    ValueError for weights of another shape, or whose rows are not of sum 1
    """

    moves = True

    def __init__(
        self,
        vertices: ArrayLike,
        triangles: ArrayLike,
        weights: ArrayLike,
        names: Sequence[str],
        pose: Callable[[float, Pose], Pose],
        bound: Pose,
        bends: Sequence[Bend] = (),
        smoothing: tuple[np.ndarray, np.ndarray, np.ndarray] | None = None,
        bulge: Bulge | None = None,
    ):
        points, table = np.array(vertices, float, order="C"), np.array(weights, float)
        self.triangles, self.names = np.array(triangles, np.int64), tuple(names)
        n, m = len(points), len(self.names)
        if table.shape != (n, m) or not np.allclose(table.sum(axis=1), 1.0, atol=1e-6):
            raise ValueError(
                f"a skin of {n} vertices on {m} segments takes weights ({n}, {m}) whose rows add "
                f"up to 1, not {table.shape}"
            )
        table[table < LEAST] = 0.0
        table /= table.sum(axis=1, keepdims=True)
        width = int((table > 0).sum(axis=1).max())
        order = np.argsort(-table, axis=1, kind="stable")[:, :width]
        self.which = np.ascontiguousarray(order, np.uint32)
        self.weights = np.ascontiguousarray(np.take_along_axis(table, order, axis=1))
        self.owners = np.argmax(table[self.triangles].sum(axis=1), axis=1)
        self.bound = Pose(*(np.array(part) for part in bound))
        self.points, self.skin = points, np.zeros(n, SKIN)
        self.skin["bend"] = -1
        self.bends = np.zeros(len(bends), BENDS)
        nearest = np.full(n, np.inf)
        for k, bend in enumerate(bends):
            self._add_bend(k, bend, points, table, nearest)
        self._smoothing = None if smoothing is None else Smoothing(*smoothing)
        self._shares = table if self._smoothing is None else self._smoothing.drawn(table)
        self._bulging = Bulging(bulge, self.names, self.bound.axes, points)
        self._pose_of, self._every = pose, np.arange(n)
        self._now, self._before = (self._new_state(m, len(bends)) for _ in range(2))
        self._rates, self._sums = np.zeros((m, 8)), np.zeros((m, 8))
        self._of_planes = np.zeros((max(len(bends), 1), 2, 3))

    def _new_state(self, m, bends):
        pose = Pose(*(np.zeros_like(part) for part in self.bound))
        return _State(
            np.full(1, np.nan), pose, np.zeros((m, 8)), np.zeros((m, 3, 4)),
            np.zeros((max(bends, 1), 7, 3)), self._bulging.new_state(),
        )  # fmt: skip

    def _add_bend(self, k, bend, points, table, nearest):
        """Record a bend, and the vertices of its two segments that it presses."""
        a, b = self.names.index(bend.above), self.names.index(bend.below)
        centres, axes = self.bound.centres, self.bound.axes
        along = [far - bend.centre for far in (bend.far_above, bend.far_below)]
        along = [line / np.linalg.norm(line) for line in along]
        self.bends[k] = (
            a, b, axes[a] @ (bend.centre - centres[a]), axes[b] @ (bend.centre - centres[b]),
            axes[a] @ along[0], axes[b] @ along[1],
        )  # fmt: skip
        normal = along[0] - along[1]
        normal /= np.linalg.norm(normal)
        from_plane = (points - bend.centre) @ normal
        if bend.parts is None:
            # what other segments carry as well is far from this bend
            whole = table[:, a] + table[:, b] > ALONE
            main = np.where(from_plane > 0, table[:, a] > table[:, b], table[:, b] > table[:, a])
            far = np.linalg.norm(points - bend.centre, axis=1)
            own = whole & (main | (table[:, [a, b]].min(axis=1) > 0)) & (far < nearest)
            nearest[own] = far[own]
        else:
            own = bend.parts > 0.0
            nearest[own] = 0.0
        margin = np.minimum(bend.near * np.abs(from_plane[own]), bend.margin)
        self.skin["bend"][own] = k
        self.skin["side"][own] = np.sign(from_plane[own])
        self.skin["margin"][own] = margin
        self.skin["room"][own] = np.minimum(bend.room, ROOM * margin)
        self.skin["part"][own] = 1.0 if bend.parts is None else bend.parts[own]

    @property
    def vertex_count(self) -> int:
        return len(self.skin)

    def _set(self, t):
        """What is known of time t [s]: `_now`."""
        if t == self._now.time[0]:
            return self._now
        now, before = self._now.time[0], self._before.time[0]
        # what is farther from t goes: a step asks for its end, and for its start afterwards
        if t == before or not abs(before - t) < abs(now - t):
            self._now, self._before = self._before, self._now
        state, bound = self._now, self.bound
        if t == state.time[0]:
            return state
        state.time[0] = np.nan
        pose = self._pose_of(t, state.pose)
        set_motions(
            pose.centres, pose.axes, bound.centres, bound.axes, state.motions, state.matrices
        )
        set_planes(self.bends, pose.centres, pose.axes, state.planes)
        self._bulging.set(state.bulge, pose.axes)
        state.time[0] = t
        return state

    def positions(self, t: float, out: np.ndarray) -> np.ndarray:
        """See `surface_motion.SurfaceMotion`."""
        now = self._set(t)
        place_skin(
            self.skin, now.bulge.points, self.which, self.weights, now.motions, now.matrices,
            now.planes, out,
        )  # fmt: skip
        return self._smoothed(out)

    def _smoothed(self, out):
        if self._smoothing is not None:
            self._smoothing.draw(out)
        return out

    def centres(self, t: float, out: np.ndarray) -> np.ndarray:
        """See `surface_motion.SurfaceMotion`."""
        out[:] = self._set(t).pose.centres
        return out

    def velocities(self, t: float, out: np.ndarray) -> np.ndarray:
        """Fill the velocities out (n, 3) [m/s] of the vertices at time t [s]; returns it."""
        now = self._set(t)
        pose = now.pose
        for j in range(len(self.names)):
            set_rate(
                self._rates[j], now.motions[j], pose.centres[j], pose.velocities[j], pose.spins[j]
            )
        plane_rates(self.bends, now.planes, pose.velocities, pose.spins, self._of_planes)
        bulging = self._bulging
        bulging.set_rates(now.bulge, pose.spins)
        skin_rates(
            self.skin, now.bulge.points, self.which, self.weights, now.motions, self._rates,
            now.planes, self._of_planes, bulging.fields, bulging.directions, bulging.rates, out,
        )  # fmt: skip
        return self._smoothed(out)

    def add_to_segments(
        self,
        t: float,
        at_vertices: np.ndarray,
        book: np.ndarray,
        pushed: np.ndarray | None = None,
    ) -> None:
        """See `surface_motion.SurfaceMotion`."""
        now, own = self._set(t), self._every if pushed is None else pushed
        reached, impulses = own, at_vertices
        if self._smoothing is not None:
            reached, impulses = self._smoothing.spread(own, at_vertices)
        bulging = self._bulging
        add_skin(
            self.skin, now.bulge.points, self.which, self.weights, now.motions, self.bends,
            now.planes, now.pose.centres, bulging.fields, bulging.directions, bulging.along,
            self._shares, own, at_vertices, reached, impulses, self._sums, book,
        )  # fmt: skip
        bulging.add_to(book, now.bulge)
