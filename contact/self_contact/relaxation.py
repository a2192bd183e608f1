# SPDX-License-Identifier: LGPL-3.0-or-later
"""Impulses of the rows of a step: sweeps, which take turns with a body.

Where nodes touch a body as well, the body says what it makes of the velocities (`respond`). Nodes
that it holds are then fixed in the sweeps, those that slide on it move along it only; body and
sweeps take turns until the body changes nothing any more. Where they do not agree, as of layers
that two parts of the body leave no room, impulses without an end, or that would give energy, are
replaced by such that only take it; and when the body has had its turn, layers that it pushes into
each other have the last word (`keep_apart`).
"""

from collections.abc import Callable

import numpy as np

from contact.solver.friction import Friction

from .row_impulses import book, bound_closing, speed_up
from .rows import ROW
from .sweeps import LEFT, turn_kernel

SWEEPS = 300  # at most, between two answers of the body
TURNS = 6  # of the body, at most
LEFT_BY_BODY = 1e-2  # as LEFT: what a turn of the body may change
FAST = 2.0  # m/s: impulses that change less are not suspected to run away
# times the greatest speed before, that impulses change: where energy is looked at, as those of
# many layers add up; and at most
MUCH, RUNAWAY = 4.0, 100.0
CLOSING = 0.5  # of the way between layers that a body pushes, in a step: `keep_apart`

# nodes (k,) that touch a body, their velocities (k, 3) by it, mobilities (k, 3, 3) that it leaves
Answer = tuple[np.ndarray, np.ndarray, np.ndarray]
NO_BODY: Answer = np.empty(0, np.int64), np.empty((0, 3)), np.empty((0, 3, 3))
# (velocities (n, 3) by the impulses so far, whether nodes are in rows) -> answer, None without such
Respond = Callable[[np.ndarray, np.ndarray], Answer | None]


class Relaxation:
    """Impulses of rows, and what is counted of how they were found.

    Parameters
    ----------
    mass : (n,) [kg]; held : (n, 3) bool, components that supports hold; friction : Friction

    Attributes
    ----------
    friction : Friction, may be changed; mobility : (n, 3, 3) [1/kg], without a body
    live : (n,) bool, nodes of rows that want an impulse, to be filled before `relax`
    solved : bool, whether the sweeps of the last step came to an end
    sweeps : int, in the last step; limited : int, steps that ended with more than LEFT
    parted : int, steps in which layers were kept from passing that a body pushed
    """

    def __init__(self, mass: np.ndarray, held: np.ndarray, friction: Friction):
        n = len(mass)
        self._mass, self.friction = mass, friction
        free = np.where(held, 0.0, 1.0) / mass[:, None]
        self.mobility = free[:, :, None] * np.eye(3)
        self.live = np.zeros(n, bool)
        self._work = np.empty((n, 3)), np.empty((n, 3))
        self._last = np.zeros(64, ROW)
        self.solved = True
        self.sweeps = self.limited = self.parted = 0

    def relax(self, rows: np.ndarray, v: np.ndarray, respond: Respond | None) -> None:
        """Find the impulses of rows (k,) ROW for velocities v (n, 3) without them [m/s]."""
        one_turn = turn_kernel(self.friction.kinetic_coefficient)
        parameters = np.array(self.friction.parameters, float)
        now, swept = self._work
        limited = self.limited
        self.sweeps, left, scale = 0, 0.0, 0.0
        for turn in range(1 if respond is None else TURNS):
            now, swept = swept, now
            speed_up(rows, self.mobility, v, now)
            held = None if respond is None else respond(now, self.live)
            done, settled, left, scale = one_turn(
                rows, now, self.mobility, self._mass, *(held or NO_BODY), swept, turn, left, scale,
                parameters, SWEEPS, LEFT_BY_BODY,
            )  # fmt: skip
            self.sweeps += done
            if held is None or settled:
                break
        else:
            self.limited += left <= LEFT * scale
        runs_away = self._runs_away(rows, v, scale, respond)
        self.solved = bool(left <= LEFT * scale) and not runs_away
        self.limited += not self.solved
        if runs_away or (
            self.limited > limited
            and respond is not None
            and (not self.solved or self._gains(rows, v, respond))
        ):
            self.solved = False
            self._stop(rows, v, one_turn)

    def _runs_away(self, rows, v, scale, respond):
        """Whether impulses feed each other, as of rows that contradict each other."""
        if scale <= FAST:
            return False
        most = np.abs(v[rows["nodes"]]).max()
        if not scale <= RUNAWAY * most:
            return True
        return scale > MUCH * most and self._gains(rows, v, respond)

    def _gains(self, rows, v, respond):
        """Whether impulses give the layers more than moves apart those that start too close."""
        after = self._work[0]
        speed_up(rows, self.mobility, v, after)
        answer = None if respond is None else respond(after, self.live)
        nodes, held, _ = answer or NO_BODY
        after[nodes] = held
        taken = np.zeros(2)
        book(rows, v, after, taken)
        return not -taken.sum() <= rows["push"] @ np.maximum(rows["bound"], 0.0)

    def _stop(self, rows, v, one_turn):
        """Impulses that only take energy, for a step in which body and layers do not agree.

        From none, without friction and recovery, and as if there were no body, every sweep is a
        projection onto n . v >= min(bound, 0), which v = 0 fulfils: with pushes p >= 0 the kinetic
        energy changes by at most sum p min(bound, 0), wherever sweeps end. The body comes after it.
        """
        now, swept = self._work
        rows["push"], rows["rub"] = 0.0, 0.0
        rows["bound"] = np.minimum(rows["bound"], 0.0)
        speed_up(rows, self.mobility, v, now)
        done, *_ = one_turn(
            rows, now, self.mobility, self._mass, *NO_BODY, swept, 0, 0.0, 0.0,
            np.zeros(len(self.friction.parameters)), SWEEPS, LEFT_BY_BODY,
        )  # fmt: skip
        self.sweeps += done

    def keep_apart(
        self, rows: np.ndarray, v: np.ndarray, least: float, dt: float
    ) -> np.ndarray | None:
        """Rows (k,) ROW of what keeps layers from passing that a body pushes, None where none is.

        rows : (k,) ROW of the step; v : (n, 3), velocities when body and layers have had their say
            [m/s]; least : distance that is left at least [m]

        Layers that have passed are never parted; a node in the body is moved out later. So no pair
        closes by more than CLOSING of what lies between it and the least. Each sweep is a
        projection as in `_stop`, which v = 0 fulfils: energy is only taken.
        """
        last = self._last
        if len(last) < len(rows):
            last = self._last = np.zeros(2 * len(rows), ROW)
        last = last[: len(rows)]
        if not bound_closing(rows, v, least, CLOSING, dt, last):
            return None
        one_turn = turn_kernel(self.friction.kinetic_coefficient)
        now, swept = self._work
        now[:] = v
        one_turn(
            last, now, self.mobility, self._mass, *NO_BODY, swept, 0, 0.0, 0.0,
            np.zeros(len(self.friction.parameters)), SWEEPS, LEFT_BY_BODY,
        )  # fmt: skip
        self.parted += 1
        return last
