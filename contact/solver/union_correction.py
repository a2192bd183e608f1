# SPDX-License-Identifier: LGPL-3.0-or-later
"""A body with both: a closed surface of triangles, and segments whose own shapes are met besides.

Two corrections in turn, first the shapes, then the surface on the velocities that they leave. Each
is exact in momentum and in its works, so their sum is. Where both push a node the surface has the
last word: what it pushes into a shape the next step moves out, at the recovery speed at most.
"""

from collections.abc import Sequence

import numpy as np

from contact.body.segments import Pose

from .contact_ledger import Ledger
from .friction import Friction
from .node_correction import NodeCorrection
from .surface_correction import SurfaceCorrection
from .velocity_correction import LOOKS, VelocityCorrection


class UnionCorrection:
    """Contact with a surface and with shapes of the same body; outward as `SurfaceCorrection`.

    Parameters
    ----------
    shapes : VelocityCorrection of the body; surface : SurfaceCorrection with the same body, nodes
        and friction
    names : segments whose shapes are met

    Raises
    ------
    ValueError for names that the body has not, and a surface without the body
    """

    def __init__(
        self, shapes: VelocityCorrection, surface: SurfaceCorrection, names: Sequence[str]
    ):
        if surface.body is not shapes.body:
            raise ValueError("a surface and shapes that are met together are of one body: name it")
        self.shapes, self.surface, self.body = shapes, surface, shapes.body
        self._parts: tuple[NodeCorrection, ...] = (shapes, surface)
        self._mask = shapes.body.mask(names)
        self.fixed, self.allowed = surface.fixed, surface.allowed
        n, m = shapes.last.impulse.shape[0], len(shapes.last.table)
        self.last, self.window = Ledger(n, m), Ledger(n, m)
        self.segment, self.penetrated = np.full(n, -1), shapes.penetrated
        self._free, self._old = np.zeros((n, 3)), np.zeros((n, 3))

    def __call__(
        self,
        x: np.ndarray,
        v: np.ndarray,
        mass: np.ndarray,
        dt: float,
        t: float,
        v_old: np.ndarray | None = None,
    ) -> None:
        """Correct v for the step from t to t + dt; see `VelocityCorrection.__call__`."""
        shapes, surface, last = self.shapes, self.surface, self.last
        self._limit_shapes()
        np.copyto(self._free, v)
        old = self._free if v_old is None else v_old
        shapes(x, v, mass, dt, t, old)
        # as if contact with the shapes had come before this step: works then add up
        np.subtract(v, self._free, out=self._old)
        self._old += old
        surface(x, v, mass, dt, t, self._old)
        last.clear()
        last.add(surface.last)
        last.add(shapes.last)
        # moments of the shapes are about their centres, those of the surface about its own
        arm = shapes.start_pose.centres - self.start_pose.centres
        last.segment_moment += np.cross(arm, shapes.last.segment_impulse)
        last.seconds = dt
        self.window.add(last)
        np.copyto(self.segment, surface.segment)
        np.copyto(self.segment, shapes.segment, where=surface.segment < 0)

    def _limit_shapes(self):
        """Let the shapes know of changes: nodes that are fixed, and what nodes can touch."""
        np.bitwise_and(self.allowed, self._mask, out=self.shapes.allowed)
        np.copyto(self.shapes.fixed, self.fixed)

    def may_touch(self, nodes: np.ndarray, v: np.ndarray, dt: float, least: float) -> np.ndarray:
        """See `NodeCorrection.may_touch`."""
        return np.logical_or(*(part.may_touch(nodes, v, dt, least) for part in self._parts))

    def preview(
        self,
        nodes: np.ndarray,
        x: np.ndarray,
        v: np.ndarray,
        mass: np.ndarray,
        dt: float,
        t: float,
        friction: Friction | None = None,
    ) -> tuple[np.ndarray, int, int]:
        """See `NodeCorrection.preview`."""
        self._limit_shapes()
        active = sticking = 0
        for part in self._parts:
            v, pushed, stuck = part.preview(nodes, x, v, mass, dt, t, friction)
            active, sticking = active + pushed, sticking + stuck
        return v, active, sticking

    def normal_give(self, nodes: np.ndarray, dt: float) -> np.ndarray:
        """See `NodeCorrection.normal_give`."""
        return np.minimum(*(part.normal_give(nodes, dt) for part in self._parts))

    @property
    def friction(self) -> Friction:
        """The law of friction; may be changed between steps."""
        return self.surface.friction

    @friction.setter
    def friction(self, value: Friction) -> None:
        self.surface.friction = self.shapes.friction = value

    @property
    def start_pose(self) -> Pose:
        """Centres that moments are about, at the start of the last step, as of the surface."""
        pose, own = self.surface.start_pose, self.shapes.start_pose
        centres = own.centres.copy()
        bound = [self.body.index(name) for name in self.surface.surface.names]
        centres[bound] = pose.centres[bound]
        return pose._replace(centres=centres)

    @property
    def evaluated(self) -> int:
        """Closest points computed in the last step."""
        return sum(part.evaluated for part in self._parts)

    @property
    def active(self) -> int:
        """Nodes in contact in the last step, twice where both push."""
        return sum(part.active for part in self._parts)

    @property
    def sticking(self) -> int:
        """Of these in stick."""
        return sum(part.sticking for part in self._parts)

    @property
    def pinched(self) -> int:
        """Nodes to which two parts of the body left no room in the last step."""
        return sum(part.pinched for part in self._parts)

    @property
    def max_depth(self) -> float:
        """Deepest start of the last step below an offset surface [m]."""
        return max(part.max_depth for part in self._parts)

    @property
    def pinch_depth(self) -> float:
        """The same of pinched nodes [m]."""
        return max(part.pinch_depth for part in self._parts)

    def reset(self) -> None:
        """Begin a new window."""
        self.window.clear()

    def looks(self) -> tuple[np.ndarray, np.ndarray]:
        """Those of the shapes and of the surface side by side, see there."""
        (one, body), (other, skin) = self.shapes.looks(), self.surface.looks()
        return np.hstack([one, other]), np.concatenate([body, skin])

    def take_looks(self, table: np.ndarray, body: np.ndarray) -> None:
        """Continue from `looks()`."""
        self.shapes.take_looks(np.ascontiguousarray(table[:, :LOOKS]), body[:2])
        self.surface.take_looks(np.ascontiguousarray(table[:, LOOKS:]), body[2:])
        # what each has touched decides ties only; both take what the node touched
        self.shapes.segment[:] = self.surface.segment[:] = self.segment

    def state(self) -> dict[str, np.ndarray]:
        """What the next step needs to know of this one, for `restore` (copies)."""
        shapes = {f"shapes_{key}": value for key, value in self.shapes.state().items()}
        return {"segment": self.segment.copy()} | shapes | self.surface.state()

    def restore(self, state: dict[str, np.ndarray]) -> None:
        """Continue from `state()`."""
        prefix = "shapes_"
        own = {k.removeprefix(prefix): v for k, v in state.items() if k.startswith(prefix)}
        self.shapes.restore(own)
        self.surface.restore(state)
