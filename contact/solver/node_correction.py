# SPDX-License-Identifier: LGPL-3.0-or-later
"""What all corrections of nodal velocities share: settings, ledgers, counts, checks of their input.

One is made for each kind of body: `VelocityCorrection` for shapes, `SurfaceCorrection` for surfaces
of triangles. They differ in how they find what bounds a step.
"""

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from contact.kernel import kernel

from .contact_ledger import Ledger
from .friction import Friction, as_friction
from .step_record import (
    ALLOWED,
    LOOK,
    PENETRATED,
    SEGMENT_TOUCHED,
    SETS,
    set_friction,
    step_record,
)

EVERY = 2**63 - 1  # all segments


@kernel(makes_arrays=False)
def mark_touching(
    nodes: np.ndarray,
    v: np.ndarray,
    away: np.ndarray,
    segment: np.ndarray,
    time: float,
    motion: float,
    least: float,
    may: np.ndarray,
) -> None:
    """Fill may (k,) bool, see `NodeCorrection.may_touch`, for a time of 2 dt [s]."""
    for k in range(len(nodes)):
        way = time * np.sqrt(v[k, 0] ** 2 + v[k, 1] ** 2 + v[k, 2] ** 2)
        near = not away[nodes[k]] > way + motion and way > least
        may[k] = near or segment[nodes[k]] >= 0


class NodeCorrection:
    """Contact and friction with a body, applied between steps.

    Parameters
    ----------
    nodes : int, owned nodes n; segments : int, rows m of the ledgers
    friction, offset, fixed, recovery, allowed : see `VelocityCorrection`

    Attributes
    ----------
    last, window : Ledger of the last step, and of all since `reset`
    fixed, allowed : (n,), as given; may be changed in place between steps
    segment : (n,) int, segment that pushed most in the last step; -1 without contact
    penetrated : (n,) int, set of the soft segments that each node lies in

    Raises
    ------
    ValueError
        For an offset or a recovery out of range, and arrays of wrong shapes.
    """

    def __init__(
        self,
        nodes: int,
        segments: int,
        friction: Friction | ArrayLike,
        offset: float,
        fixed: ArrayLike | None,
        recovery: float,
        allowed: ArrayLike | None,
    ):
        if not (np.isfinite(offset) and offset >= 0):
            raise ValueError(f"the contact offset is a length >= 0, not {offset} m")
        if not recovery > 0:
            raise ValueError(f"the recovery speed is positive, not {recovery} m/s")
        self._sets, self._look = np.zeros((SETS, nodes), np.int64), np.zeros((LOOK, nodes))
        self._look[3], self._away = -1.0, np.zeros(nodes)
        self.fixed, self.allowed = np.zeros(nodes, bool), self._sets[ALLOWED]
        self.segment, self.penetrated = self._sets[SEGMENT_TOUCHED], self._sets[PENETRATED]
        self.segment[:] = -1
        for name, array, given in (
            ("fixed", self.fixed, False if fixed is None else fixed),
            ("allowed", self.allowed, EVERY if allowed is None else allowed),
        ):
            if np.shape(given) not in ((), (nodes,)):
                raise ValueError(f"{name} has shape {np.shape(given)}, not ({nodes},)")
            array[:] = given
        self._friction, self._offset = as_friction(friction), float(offset)
        self._correct = self._kernel_of(self._friction)
        self._step = step_record(self._friction, self._offset)
        self._step["recovery_speed"] = recovery
        self._work = self._step[0]
        self._asked: tuple | None = None  # of `preview`
        self.last, self.window = Ledger(nodes, segments), Ledger(nodes, segments)
        self._start_time: float | None = None
        self._end_time: float | None = None

    def _kernel_of(self, friction: Friction) -> Any:
        """Kernel of a step for a law of friction."""
        raise NotImplementedError

    def _move(self, start, end):
        """Place the body at the two times of a step; nothing where that has been done."""
        raise NotImplementedError

    def _ask(self, nodes, x, v, old, mass, dt, step, correct):
        """Correct v (k, 3) of some nodes by a kernel of `_kernel_of`, and keep nothing.

        Arrays are to be of the order that a step has: another one would be compiled for.
        """
        raise NotImplementedError

    def may_touch(self, nodes: np.ndarray, v: np.ndarray, dt: float, least: float) -> np.ndarray:
        """Whether nodes (k,) int with velocities v (k, 3) touch the body or may, in a step dt [s].

        By what the last step has found: a node that the body reaches suddenly is missed, and one
        that does not touch it yet and goes by less than `least` [m] in two steps.
        """
        may = np.empty(len(nodes), np.bool_)
        motion = float(self._work["motion"]) + float(np.linalg.norm(self._work["shift"]))
        mark_touching(nodes, v, self._away, self.segment, 2.0 * dt, motion, least, may)
        return may

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
        """What a call would make of velocities v (k, 3) of some nodes (k,) int; nothing is kept.

        x, mass : (k, 3), (k,), of these; friction : in place of that of the contact

        Returns their velocities (k, 3), how many are pushed and how many of them stick.
        """
        self._move(t, t + dt)
        if self._asked is None:
            # records are copied as bytes: field by field it takes longer than all else
            copied = self._step.copy()
            self._asked = copied, copied.view(np.uint8), self._step.view(np.uint8)
        step, asked, own = self._asked
        asked[:] = own
        correct = self._correct
        if friction is not None:
            set_friction(step, friction)
            correct = self._kernel_of(friction)
        after = v.copy()
        self._ask(nodes, x, after, v, mass, dt, step, correct)
        return after, int(step[0]["active"]), int(step[0]["sticking"])

    def normal_give(self, nodes: np.ndarray, dt: float) -> np.ndarray:
        """Part (k,) of a change of their velocity along its normal that the body leaves to nodes.

        None where it is hard.
        """
        return np.zeros(len(nodes))

    def _check(self, x, v, mass, old, dt, t):
        nodes, shape = self.segment.shape, self.last.impulse.shape
        if not (x.shape == v.shape == old.shape == shape and mass.shape == nodes):
            for name, array, wanted in (
                ("x", x, shape), ("v", v, shape), ("mass", mass, nodes), ("v_old", old, shape),
            ):  # fmt: skip
                if array.shape != wanted:
                    raise ValueError(f"{name} has shape {array.shape}, not {wanted}")
        if not (0 < dt < math.inf and math.isfinite(t)):
            raise ValueError(
                f"contact needs a time step above 0 s at a finite time, not {dt} s at {t}"
            )

    def _refuse(self, i, x, v, mass, t):
        if not 0 < mass[i] < np.inf:
            raise ValueError(f"node {i} has a mass of {mass[i]} kg; contact needs one above 0")
        raise FloatingPointError(
            f"node {i} has position {x[i]} m and velocity {v[i]} m/s at t = {t:.6g} s: "
            "the step has exploded; take a smaller one"
        )

    @property
    def friction(self) -> Friction:
        """The law of friction; may be changed between steps, to a number or a pair as well."""
        return self._friction

    @friction.setter
    def friction(self, value: Friction | ArrayLike) -> None:
        self._friction = as_friction(value)
        self._correct = self._kernel_of(self._friction)
        set_friction(self._step, self._friction)

    @property
    def evaluated(self) -> int:
        """Closest points computed in the last step."""
        return int(self._work["evaluated"])

    @property
    def active(self) -> int:
        """Nodes in contact in the last step."""
        return int(self._work["active"])

    @property
    def sticking(self) -> int:
        """Nodes in contact that stuck in the last step."""
        return int(self._work["sticking"])

    @property
    def pinched(self) -> int:
        """Nodes in soft segments, or to which hard parts of the body left no room."""
        return int(self._work["pinched"])

    @property
    def max_depth(self) -> float:
        """Deepest start of the last step below the offset surface [m]."""
        return float(self._work["max_depth"])

    @property
    def pinch_depth(self) -> float:
        """The same of pinched nodes, which are not counted there [m]."""
        return float(self._work["pinch_depth"])

    def reset(self) -> None:
        """Begin a new window."""
        self.window.clear()
