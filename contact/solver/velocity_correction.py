# SPDX-License-Identifier: LGPL-3.0-or-later
"""The hook between steps: velocities corrected so that cloth stays out of the body, Eqs. 15 and 16.

A stepper of leapfrog type has positions x at t and free velocities v, advanced over the step by all
forces but contact; x + dt v would be the positions at t + dt. Where that step would enter the body,
v is changed: first along the normals (planes.py, wedge.py), then by friction (friction.py). Every
change is an impulse m (v_after - v_before) and is booked, per node and per segment, so that
momentum closes to roundoff and the mean of impulse / dt is the contact force. A node at rest gets
its weight times dt in each step.

All impulses booked act on the cloth; the segment receives the opposite.

Work of an impulse J is J . (v_old + v_after) / 2 with v_old the velocity before the forces were
applied (without it: the free velocity). Then the work of forces and contact over a step adds up to
the change of kinetic energy, and nodes at rest dissipate nothing.
"""

import numpy as np

from contact.body.pose_check import require_no_jump
from contact.body.segment_sets import SETS, bits_of, mates_of
from contact.kernel import kernel

from .broad_phase import CLEAR, LEAST, STEPS, left_of, look, surface_motion
from .contact_ledger import Ledger
from .friction import coefficients
from .node_contact import ACTIVE, COUNTS, EVALUATED, PINCHES, STICKING, meet_body
from .segment_motion import TRAVEL, in_reach, set_travel
from .supporting_planes import PLANE

EVERY = 2**63 - 1  # all segments


@kernel
def _correct(
    x, v, old, mass, fixed, allowed, dt, law, start, start_axes, end, end_axes, radii, travel,
    planes, room, clear, path, segment, sunk, impulse, book, window, window_book, counts,
):  # fmt: skip
    """One step of contact for all points; number + 1 of one not finite; depths; body's motion."""
    offset = law[2]
    set_travel(start, start_axes, end, end_axes, radii, offset, travel)
    motion, shortest = surface_motion(travel, offset)
    counts[:] = 0
    book[:] = 0.0
    deepest = pinched = 0.0
    kick, change = room[4], room[5]
    for i in range(len(x)):
        total = x[i, 0] + x[i, 1] + x[i, 2] + v[i, 0] + v[i, 1] + v[i, 2]
        if not (np.isfinite(total) and 0.0 < mass[i] < np.inf):
            return i + 1, deepest, pinched, motion
        for c in range(3):
            impulse[i, c] = 0.0
        reach = dt * np.sqrt(v[i, 0] ** 2 + v[i, 1] ** 2 + v[i, 2] ** 2)
        if fixed[i]:
            segment[i], sunk[i] = -1, 0
            continue
        left = left_of(x[i], path, motion, clear[i])
        if left < reach and motion < np.inf:
            margin = max(STEPS * (reach + motion), LEAST * shortest)
            counts[EVALUATED] += look(
                x[i], path, margin, allowed[i], travel, offset, clear[i]
            )  # fmt: skip
            left = left_of(x[i], path, motion, clear[i])
        far = clear[i].far if left >= reach else 0
        may = allowed[i] & ~far
        if not may or not in_reach(x[i], reach, travel, may):
            segment[i], sunk[i] = -1, 0
            continue
        for c in range(3):
            kick[c] = v[i, c] - old[i, c]
        segment[i], sunk[i], depth, pinch = meet_body(
            x[i], v[i], kick, mass[i], dt, law, segment[i], allowed[i], sunk[i], far, left, travel,
            planes, room, book, counts, change,
        )  # fmt: skip
        deepest, pinched = max(deepest, depth), max(pinched, pinch)
        if segment[i] >= 0:
            for c in range(3):
                v[i, c] += change[c]
                impulse[i, c] = mass[i] * change[c]
                window[i, c] += impulse[i, c]
    window_book += book
    return 0, deepest, pinched, motion


class Correction:
    """Contact and friction with a body, applied between steps.

    Parameters
    ----------
    body : Body
    nodes : int, owned nodes n
    friction : float or (mu_s, mu_k)
    offset : float, distance from the skin at which cloth is held: half its thickness [m]
    fixed : (n,) bool or None, nodes of prescribed motion: left alone
    recovery : float, greatest speed at which a point that starts a step inside is moved out [m/s]
    allowed : (n,) int or None, segments each node can touch, see `Body.mask`; None: all
    flesh : float, stiffness of the segments where they press cloth against each other, over the
        areal mass of the cloth [1/s^2], see pinch.py; infinite: hard ones

    Attributes
    ----------
    last : Ledger of the last step
    window : Ledger of all steps since the last `reset`
    segment : (n,) int, segment touched in the last step, where two hold the node the one that
        pushes more; -1 without contact
    sunk : (n,) int, set of the soft segments that each node lies in
    evaluated : closest points computed in the last step
    active, sticking : points in contact in the last step, of these in stick
    pinched : points in soft segments, or to which hard ones left no room, in the last step
    max_depth : float, deepest start of the last step below the offset surface [m]
    pinch_depth : float, the same of pinched points, which are not counted there [m]
    """

    def __init__(
        self, body, nodes, friction=0.0, offset=0.0, fixed=None, recovery=0.1, allowed=None,
        flesh=np.inf,
    ):  # fmt: skip
        mu_s, mu_k = coefficients(friction)
        if not (np.isfinite(offset) and offset >= 0):
            raise ValueError(f"the contact offset is a length >= 0, not {offset} m")
        if not recovery > 0:
            raise ValueError(f"the recovery speed is positive, not {recovery} m/s")
        if not flesh > 0:
            raise ValueError(f"the stiffness of soft segments is positive, not {flesh}")
        self.fixed = np.zeros(nodes, bool) if fixed is None else np.array(fixed, bool)
        if self.fixed.shape != (nodes,):
            raise ValueError(f"fixed has shape {self.fixed.shape}, not ({nodes},)")
        self.allowed = np.full(nodes, EVERY) if allowed is None else np.array(allowed, np.int64)
        if self.allowed.shape != (nodes,):
            raise ValueError(f"allowed has shape {self.allowed.shape}, not ({nodes},)")
        bits = bits_of(body)
        if flesh < np.inf and bits.max() == SETS:
            raise ValueError(
                f"of {len(bits)} segments that move by themselves only {SETS} can be told apart "
                "as soft ones; give several one carrier, or leave them hard"
            )
        self.body = body
        self._law = (mu_s, mu_k, float(offset), float(recovery), float(flesh))
        m = len(body.radii)
        self.last, self.window = Ledger(nodes, m), Ledger(nodes, m)
        self.segment = np.full(nodes, -1, np.int64)
        self.sunk = np.zeros(nodes, np.int64)
        self.max_depth, self.pinch_depth, self._counts = 0.0, 0.0, np.zeros(COUNTS, np.int64)
        self._radii = np.ascontiguousarray(body.radii, float)
        self._scratch = np.zeros(m, TRAVEL), np.zeros(2 * m, PLANE), np.zeros((6, 3))
        self._scratch[0]["bit"], self._scratch[0]["mates"] = bits, mates_of(body)
        self._clear, self._path = np.zeros(nodes, CLEAR), 0.0
        self._clear["room"] = -1.0
        self._start, self._end = body.new_pose(), body.new_pose()
        self._start_time = self._end_time = None

    def __call__(self, x, v, mass, dt, t, v_old=None):
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
        FloatingPointError
            When a position or velocity is not finite, with the node; v is then partly corrected.
        """
        for name, array, shape in (
            ("x", x, self.last.impulse.shape),
            ("v", v, self.last.impulse.shape),
            ("mass", mass, self.segment.shape),
            ("v_old", x if v_old is None else v_old, self.last.impulse.shape),
        ):
            if array.shape != shape:
                raise ValueError(f"{name} has shape {array.shape}, not {shape}")
        if not (0 < dt < np.inf and np.isfinite(t)):
            raise ValueError(
                f"contact needs a time step above 0 s at a finite time, not {dt} s at {t}"
            )
        self._move(t, t + dt)
        last, window = self.last, self.window
        bad, self.max_depth, self.pinch_depth, motion = _correct(
            x, v, v if v_old is None else v_old, mass, self.fixed, self.allowed, dt, self._law,
            self._start.centres, self._start.axes, self._end.centres, self._end.axes, self._radii,
            *self._scratch, self._clear, self._path, self.segment, self.sunk, last.impulse,
            last.table, window.impulse, window.table, self._counts,
        )  # fmt: skip
        self._path += motion
        if motion == np.inf:
            self._path, self._clear["room"] = 0.0, -1.0
        if bad:
            i = bad - 1
            if not 0 < mass[i] < np.inf:
                raise ValueError(f"node {i} has a mass of {mass[i]} kg; contact needs one above 0")
            raise FloatingPointError(
                f"node {i} has position {x[i]} m and velocity {v[i]} m/s at t = {t:.6g} s: "
                "the step has exploded; take a smaller one"
            )
        last.seconds = dt
        window.seconds += dt

    def _move(self, start, end):
        """Poses at the two times; the end of one step usually is the start of the next."""
        if start == self._end_time:
            self._start, self._end = self._end, self._start
        else:
            self._clear["room"] = -1.0
            if start != self._start_time:
                self.body.pose(start, self._start)
        self.body.pose(end, self._end)
        self._start_time, self._end_time = start, end
        names = self.body.names
        require_no_jump(names, self._radii, self._start, self._end, start, end - start)

    @property
    def friction(self):
        """(mu_s, mu_k); may be changed between steps."""
        return self._law[:2]

    @friction.setter
    def friction(self, value):
        self._law = (*coefficients(value), *self._law[2:])

    @property
    def start_pose(self):
        """Pose of the body at the start of the last step."""
        return self._start

    @property
    def evaluated(self):
        return int(self._counts[EVALUATED])

    @property
    def active(self):
        return int(self._counts[ACTIVE])

    @property
    def sticking(self):
        return int(self._counts[STICKING])

    @property
    def pinched(self):
        return int(self._counts[PINCHES])

    def reset(self):
        """Begin a new window."""
        self.window.clear()

    def looks(self):
        """What steps so far have found out of reach: (n, 6), way [m] and time [s] of the body.

        It leaves out planes that do not push, which changes last digits at most: who goes on bit
        for bit needs it. Sets of segments stand as the floats of the same bits.
        """
        time = np.nan if self._end_time is None else self._end_time
        return self._clear.view(float).reshape(-1, 6).copy(), np.array([self._path, time])

    def take_looks(self, records, body):
        """Continue from `looks()`."""
        self._clear[:] = np.ascontiguousarray(records).view(CLEAR).ravel()
        self._path, time = body.tolist()
        if not np.isnan(time):
            self._end_time = time
            self.body.pose(time, self._end)

    def state(self):
        """What the next step needs to know of this one, for `restore` (copies)."""
        return {"segment": self.segment.copy(), "sunk": self.sunk.copy()}

    def restore(self, state):
        """Continue from `state()`."""
        self.segment[:] = state["segment"]
        self.sunk[:] = state["sunk"]
