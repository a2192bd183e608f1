# SPDX-License-Identifier: LGPL-3.0-or-later
"""Torque that the clothing exerts about each joint of the wearer, Fig. 9 of the paper.

    tau_J = sum over AJ of (x_i - J) x f_i

f_i is the force on the body at node i and AJ the nodes that count for joint J. The paper leaves AJ
open. Here it is a set of ellipsoids, by default all below the joint (`distal`): for the knee what
acts on shank and foot. Then tau_J . omega_J, with omega_J the turning of the segment below against
the one above, is the power that the clothing gives the joint; its negative part is resistance.

Contact is booked as impulses in every step, so the torque of a step is exact in x_i and f_i. What
is reported is the mean over a window between two records, without any other filter.
"""

import csv
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Self

import numpy as np

from contact.kernel import kernel
from shellform.contact_coupling.contact import require_contact
from shellform.dynamics.explicit import Newmark
from shellform.dynamics.part import Part
from shellform.motion.joint_parts import chosen_parts
from shellform.motion.wearer import Wearer

from .files import check_place, write_atomically

AXES = "xyz"
COLUMNS = ("time", "joint", "torque_x", "torque_y", "torque_z", "torque_flexion", "power")


@kernel
def add_torque(
    table: np.ndarray,
    centres: np.ndarray,
    counts: np.ndarray,
    joints: np.ndarray,
    axes: np.ndarray,
    spins: np.ndarray,
    total: np.ndarray,
) -> None:
    """Add a step's torque impulses on the wearer about all joints.

    Parameters
    ----------
    table : (m, >= 6), impulse [N s] of every segment on the cloth and its moment about the
        segment's centre [N m s]
    centres : (m, 3) [m]; counts : (k, m) bool, segments that count for a joint
    joints, axes : (k, 3), centres [m] and flexion axes; spins : (k, 3) [rad/s]
    total : (k, 5), added to: torque impulse (3), about the flexion axis [N m s], work [J]
    """
    moment = np.empty(3)
    for j in range(len(joints)):
        moment[:] = 0.0
        for b in range(len(centres)):
            if not counts[j, b]:
                continue
            for c in range(3):
                d, e = (c + 1) % 3, (c + 2) % 3
                arm_d, arm_e = centres[b, d] - joints[j, d], centres[b, e] - joints[j, e]
                # minus: the segment receives the opposite of what the cloth does
                moment[c] -= table[b, 3 + c] + arm_d * table[b, e] - arm_e * table[b, d]
        for c in range(3):
            total[j, c] += moment[c]
            total[j, 3] += moment[c] * axes[j, c]
            total[j, 4] += moment[c] * spins[j, c]


class Torque(Part):
    """Joint torques of every step, averaged between records; the body in contact is a Wearer.

    Parameters
    ----------
    path : CSV file for the rows, written by rank 0, or None
    parts : 'distal', all ellipsoids below a joint; 'child', those of the segment just below; or a
        dict, joint -> names of ellipsoids
    resumed : state of a run that is gone on with, see `saved`; rows up to its time stay in the file

    Attributes
    ----------
    joints : tuple of str; rows : list of dict with the keys COLUMNS, a row a joint and record
    parts : dict, joint -> names of the ellipsoids that count

    Raises
    ------
    ValueError, when it is added, for a stepper whose contact is none with a Wearer, for an unknown
    joint, ellipsoid or kind of parts

    Examples
    --------
    >>> import meshes, shellform as sf
    >>> from shellform.motion.anthropometry import ellipsoids
    >>> walk = sf.synthetic_walk(strides=1, obstacle=0.0)
    >>> wearer = sf.Wearer(walk, ellipsoids(walk.lengths()))
    >>> fabric = sf.Fabric.isotropic(1e5, 0.3, 1e-3, 200.0)
    >>> stepper = sf.Newmark(sf.Shell(meshes.rectangle(0.4, 0.4, (4, 4)), fabric))
    >>> contact = stepper.add(sf.Contact(wearer))
    >>> torque = stepper.add(sf.Torque("torque.csv"))
    >>> stepper.advance(0.01)
    >>> [row["joint"] for row in torque.record(stepper.time)][:3]
    ['right_hip', 'right_knee', 'right_ankle']
    """

    books_contact = True

    def __init__(
        self,
        path: str | Path | None = None,
        parts: str | dict[str, list[str]] = "distal",
        resumed: dict[str, Any] | None = None,
    ) -> None:
        self.path, self._asked, self._resumed = path, parts, resumed
        self.rows: list[dict[str, Any]] = []

    def attach(self, stepper: Newmark) -> Self:
        """Begin to add up the torques of a stepper's contact."""
        self.contact = require_contact(stepper, "torque about the joints")
        if self.path is not None:
            check_place(self.path, stepper.shell.comm)
        wearer = self.contact.body
        if not isinstance(wearer, Wearer):
            raise ValueError(
                f"torque acts about the joints of a Wearer; the body in contact is a "
                f"{type(wearer).__name__} of {', '.join(wearer.names)}: give Contact a Wearer"
            )
        self.wearer, self.joints = wearer, wearer.joints
        self.parts = chosen_parts(wearer, self._asked)
        self.counts = np.array(
            [[name in self.parts[joint] for name in wearer.names] for joint in self.joints]
        ).reshape(len(self.joints), len(wearer.names))
        self.total, self.seconds = np.zeros((len(self.joints), 5)), 0.0
        self._joints, self._comm = wearer.new_joints(), stepper.shell.comm
        self._file = None if self.path is None or self._comm.rank else Path(self.path)
        if self._resumed is not None:
            if self.path is not None:
                self.rows = rows_until(self.path, stepper.time)
            self.total[:] = self._resumed["torque"] if self._comm.rank == 0 else 0.0
            self.seconds = float(self._resumed["torque_seconds"])
        if self._file:
            write_atomically(self._file, ",".join(COLUMNS) + "\n" + "".join(map(line, self.rows)))
        return super().attach(stepper)

    def __call__(self, stepper: Newmark, dt: float) -> None:
        now = self.wearer.joint_state(stepper.time, self._joints)
        centres, table = self.contact.start_pose.centres, self.contact.last.table
        add_torque(table, centres, self.counts, *now, self.total)
        self.seconds += dt

    def record(self, time: float) -> list[dict[str, Any]]:
        """Rows of the window that ends at `time` [s], one a joint; begins a new window."""
        total = self._comm.allreduce(self.total) / max(self.seconds, 1e-300)
        rows = [
            dict(zip(COLUMNS, (time, joint, *row), strict=True))
            for joint, row in zip(self.joints, total.tolist(), strict=True)
        ]
        self.rows += rows
        self.total[:], self.seconds = 0.0, 0.0
        if self._file:
            with open(self._file, "a") as file:
                file.write("".join(line(row) for row in rows))
        return rows

    def state(self) -> tuple[np.ndarray, float]:
        """Sums of the open window on this rank, for `restore` (copies)."""
        return self.total.copy(), self.seconds

    def restore(self, state: Any) -> None:
        """Continue from `state()`."""
        self.total[:], self.seconds = state

    def saved(self) -> dict[str, Any]:
        """Sums of the open window over all ranks, for `resumed`; all ranks call."""
        return {"torque": self._comm.allreduce(self.total), "torque_seconds": self.seconds}


def rows_until(path: str | Path, time: float) -> list[dict[str, Any]]:
    """Rows of a torque.csv up to a time [s]."""
    with open(path) as file:
        read = list(csv.DictReader(file))
    rows: list[dict[str, Any]] = [
        {k: v if k == "joint" else float(v) for k, v in row.items()} for row in read
    ]
    return [row for row in rows if row["time"] <= time + 1e-9]


def line(row: dict[str, Any]) -> str:
    """A row of torque.csv."""
    values = (row[key] for key in COLUMNS)
    return ",".join(v if isinstance(v, str) else f"{v:.10g}" for v in values) + "\n"


def resistance(
    rows: list[dict[str, Any]],
    joint: str,
    strides: Sequence[tuple[float, float]] = (),
    start: float | None = None,
    counted: tuple[float, float] = (-np.inf, np.inf),
) -> dict[str, Any]:
    """What the clothing costs a joint, integrated over time.

    Parameters
    ----------
    rows : see `Torque`; joint : str
    strides : (start, end) times [s] of the strides to report one by one; a window belongs to the
        stride in which it ends
    start : float [s] or None, begin of the first window; None: it is as long as the second
    counted : begin and end [s]; windows that are not within, as of standing, count for nothing

    Returns
    -------
    dict with `peak_torque`, `rms_torque` [N m] of the flexion component, `work` [J] given to the
    joint, `resistance` [J], the sum of its negative parts by window, and `strides`, a list of the
    same for each stride

    Raises
    ------
    ValueError when there is no row of the joint, or one only and no `start`
    """
    own = [row for row in rows if row["joint"] == joint]
    if not own:
        known = sorted({row["joint"] for row in rows})
        raise ValueError(f"no torque about a joint '{joint}'; there are: {', '.join(known)}")
    time = np.array([row["time"] for row in own])
    torque = np.array([row["torque_flexion"] for row in own])
    power = np.array([row["power"] for row in own])
    if start is None:
        if len(time) == 1:
            raise ValueError(
                f"one window of '{joint}' does not tell how long it is: give its start"
            )
        start = 2 * time[0] - time[1]
    width = np.diff(time, prepend=start)

    def summary(mask):
        if not mask.any():
            return {"peak_torque": 0.0, "rms_torque": 0.0, "work": 0.0, "resistance": 0.0}
        t, p, w = torque[mask], power[mask], width[mask]
        return {
            "peak_torque": float(t[np.abs(t).argmax()]),
            "rms_torque": float(np.sqrt(np.sum(w * t * t) / np.sum(w))),
            "work": float(np.sum(w * p)),
            "resistance": float(-np.sum(w * np.minimum(p, 0.0))),
        }

    within = (time - width >= counted[0] - 1e-6) & (time <= counted[1] + 1e-6)
    return summary(within) | {
        "strides": [summary(within & (time > a + 1e-9) & (time <= b + 1e-9)) for a, b in strides]
    }
