# SPDX-License-Identifier: LGPL-3.0-or-later
"""The hook between steps: velocities corrected so that cloth stays out of the body, Eqs. 15 and 16.

A stepper of leapfrog type has positions x at t and free velocities v, advanced over the step by all
forces but contact; x + dt v would be the positions at t + dt. Where that step would enter the body,
v is changed: first along the normals (supporting_planes.py, nearest_step.py), then by friction
(plane_friction.py). Every change is an impulse m (v_after - v_before) and is booked, per node and
per segment, so that momentum closes to roundoff and the mean of impulse / dt is the contact force.
A node at rest gets its weight times dt in each step.

All impulses booked act on the cloth; the segment receives the opposite.

Work of an impulse J is J . (v_old + v_after) / 2 with v_old the velocity before the forces were
applied (without it: the free velocity). Then the work of forces and contact over a step adds up to
the change of kinetic energy, and nodes at rest dissipate nothing.
"""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from contact.body.pose_check import body_jumps
from contact.body.segment_sets import SETS as BITS
from contact.body.segments import Body, Pose

from .correction_step import correction_kernel
from .friction import Friction
from .node_correction import NodeCorrection
from .segment_motion import move_segments, segment_records
from .step_record import (
    FAR,
    GUARD,
    GUARDS,
    LOOK,
    NODE,
)
from .supporting_planes import PLANE

LOOKS = 1 + LOOK + GUARDS * GUARD  # numbers a node in `VelocityCorrection.looks`


class VelocityCorrection(NodeCorrection):
    """Contact and friction with a body, applied between steps.

    Parameters
    ----------
    body : Body
    nodes : int, owned nodes n
    friction : float, (mu_s, mu_k) or a law, see `contact.solver.friction`
    offset : float, distance from the skin at which cloth is held: half its thickness [m]
    fixed : (n,) bool or None, nodes of prescribed motion: left alone
    recovery : float, greatest speed at which a node that starts a step inside is moved out [m/s]
    allowed : (n,) int or None, segments each node can touch, see `Body.mask`; None: all
    flesh : float, stiffness of the segments where they press cloth against each other, over the
        areal mass of the cloth [1/s^2], see soft_contact.py; infinite: hard ones

    Attributes
    ----------
    last, window, fixed, allowed, penetrated, active, ... : see NodeCorrection
    segment : (n,) int, segment touched in the last step, where two hold the node the one that
        pushes more; -1 without contact

    Raises
    ------
    ValueError
        For an offset, a recovery, a stiffness or a friction out of range, arrays of wrong shapes,
        and more segments than soft ones can be told apart.
    """

    def __init__(
        self,
        body: Body,
        nodes: int,
        friction: Friction | ArrayLike = 0.0,
        offset: float = 0.0,
        fixed: ArrayLike | None = None,
        recovery: float = 0.1,
        allowed: ArrayLike | None = None,
        flesh: float = np.inf,
    ):
        if not flesh > 0:
            raise ValueError(f"the stiffness of soft segments is positive, not {flesh}")
        super().__init__(nodes, len(body.shapes), friction, offset, fixed, recovery, allowed)
        self._guards = np.zeros((nodes, GUARDS, GUARD))
        self.body = body
        self._segments = segment_records(body)
        if flesh < np.inf and self._segments["bit"].max() == BITS:
            raise ValueError(
                f"of {len(body.shapes)} segments that move by themselves only {BITS} can be told "
                "apart as soft ones; give several one carrier, or leave them hard"
            )
        self._step["flesh"] = flesh
        self._planes = np.zeros(2 * len(self._segments), PLANE)
        self._gaps, self._node = np.zeros(len(self._segments)), np.zeros(1, NODE)
        self._beds = np.zeros(0)
        self._extents = np.array([shape.half_extents for shape in body.shapes], float)
        self._start, self._end = body.new_pose(), body.new_pose()
        self._scratch: tuple | None = None  # of `preview`

    def __call__(
        self,
        x: np.ndarray,
        v: np.ndarray,
        mass: np.ndarray,
        dt: float,
        t: float,
        v_old: np.ndarray | None = None,
    ) -> None:
        """Correct v for the step from t to t + dt.

        Parameters
        ----------
        x : (n, 3) float, positions at t [m]
        v : (n, 3) float, free velocities [m/s], changed in place; x + dt v is then admissible
        mass : (n,) float [kg]
        dt, t : float [s]
        v_old : (n, 3) float or None, velocities of the last step [m/s]; for work and losses only

        Raises
        ------
        ValueError
            For arrays of wrong shapes, a step or a mass that is none, a body that jumps.
        FloatingPointError
            When a position or velocity is not finite, with the node; v is then partly corrected,
            and the window partly booked.
        """
        old = v if v_old is None else v_old
        self._check(x, v, mass, old, dt, t)
        self._move(t, t + dt)
        bad = self._run(x, v, old, mass, dt)
        if bad:
            self._refuse(bad - 1, x, v, mass, t)
        self.last.seconds = dt
        self.window.seconds += dt

    def _run(self, x, v, old, mass, dt):
        """Correct v; 0, or the number + 1 of a node that is not finite."""
        last, window = self.last, self.window
        return self._correct(
            x, v, old, mass, dt, self.fixed, self._sets, self._look, self._guards, self._away,
            self._gaps, self._node, self._step, self._segments, self._planes, self._beds,
            last.impulse, last.table, window.impulse, window.table,
        )  # fmt: skip

    def _kernel_of(self, friction: Friction) -> Any:
        return correction_kernel(friction.kinetic_coefficient)

    def _scratch_of(self, k):
        """Guards, looks and books for k nodes that are asked in advance, as they are at first."""
        scratch = self._scratch
        if scratch is None or len(scratch[0]) < k:
            scratch = self._scratch = (
                np.zeros((2 * k, GUARDS, GUARD)), np.zeros((LOOK, 2 * k)), np.zeros(2 * k),
                np.zeros((2, 2 * k, 3)), np.zeros((2, *self.last.table.shape)), np.zeros(0),
            )  # fmt: skip
        guards, look, away, impulse, table, beds = scratch
        guards[:k], look[:] = 0.0, 0.0
        look[3] = -1.0
        return guards[:k], np.ascontiguousarray(look[:, :k]), away[:k], impulse[:, :k], table, beds

    def _ask(self, nodes, x, v, old, mass, dt, step, correct):
        guards, look, away, impulse, table, beds = self._scratch_of(len(nodes))
        sets = np.take(self._sets, nodes, axis=1)
        correct(
            x, v, old, mass, dt, self.fixed[nodes], sets, look,
            guards, away, self._gaps, self._node, step, self._segments, self._planes, beds,
            impulse[0], table[0], impulse[1], table[1],
        )  # fmt: skip

    def _move(self, start, end):
        """Poses at the two times; the end of one step usually is the start of the next."""
        if start == self._start_time and end == self._end_time:
            return  # the same step once more, with other velocities
        if start == self._end_time:
            self._start, self._end = self._end, self._start
        else:
            self._look[3] = -1.0
            if start != self._start_time:
                self.body.pose(start, self._start)
        self.body.pose(end, self._end)
        self._start_time, self._end_time = start, end
        jumping, jump = move_segments(
            *self._start, *self._end, self._extents, end - start, self._offset, self._segments
        )
        if jumping >= 0:
            raise body_jumps(self.body.names[jumping], jump, start, end)

    @property
    def segments(self) -> np.ndarray:
        """Records (m,) SEGMENT of the body and its motion over the last step; to be read only."""
        return self._segments

    @property
    def start_pose(self) -> Pose:
        """Pose of the body at the start of the last step."""
        return self._start

    def add_counts(self, other: "VelocityCorrection") -> None:
        """Add the counts of the last step of another correction, and take the greater depths."""
        for name in ("evaluated", "active", "sticking", "pinched"):
            self._work[name] += other._work[name]
        for name in ("max_depth", "pinch_depth"):
            self._work[name] = max(self._work[name], other._work[name])

    def watch_beds(self, stiffness: float = np.inf) -> np.ndarray:
        """Array (n,) [Pa/m], filled in every step from now on; zero until the next one.

        What each node is bedded on where segments press it from opposite sides: the sum of their
        `stiffness` [Pa/m], that of soft ones; without flesh they are hard and it is infinite. Zero
        where a node is free or pressed from one side only.
        """
        if not len(self._beds):
            self._beds = np.zeros(len(self.segment))
        self._step["bed"] = stiffness if self._work["flesh"] < np.inf else np.inf
        return self._beds

    def looks(self) -> tuple[np.ndarray, np.ndarray]:
        """What steps so far have found out of reach: (n, LOOKS), way [m] and time [s] of the body.

        It leaves out planes that do not push, which changes last digits at most: who goes on bit
        for bit needs it. Sets of segments stand as the floats of the same bits.
        """
        time = np.nan if self._end_time is None else self._end_time
        far = self._sets[FAR].view(float)
        guards = self._guards.reshape(len(far), GUARDS * GUARD)
        table = np.column_stack([self._look[:3].T, far, self._look[3:].T, guards])
        return table, np.array([self._work["path"], time])

    def take_looks(self, table: np.ndarray, body: np.ndarray) -> None:
        """Continue from `looks()`."""
        self._look[:3], self._look[3:] = table[:, :3].T, table[:, 4:6].T
        self._sets[FAR] = np.ascontiguousarray(table[:, 3]).view(np.int64)
        self._guards.reshape(len(table), GUARDS * GUARD)[:] = table[:, 6:]
        self._work["path"], time = body.tolist()
        if not np.isnan(time):
            self._end_time = time
            self.body.pose(time, self._end)

    def state(self) -> dict[str, np.ndarray]:
        """What the next step needs to know of this one, for `restore` (copies)."""
        return {
            "segment": self.segment.copy(),
            "penetrated": self.penetrated.copy(),
            "beds": self._beds.copy(),
        }

    def restore(self, state: dict[str, np.ndarray]) -> None:
        """Continue from `state()`."""
        self.segment[:] = state["segment"]
        self.penetrated[:] = state["penetrated"]
        self._beds[:] = state["beds"] if len(state["beds"]) else 0.0
