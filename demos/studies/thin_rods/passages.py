# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cloth that goes through a straight rod, told from cloth that slides off it.

Seen along the axis of the rod a row of nodes is a curve, and the axis a point P. The angle at P,
summed up along the curve from its first end A to its last end B, is

    theta = phi_B - phi_A + 2 pi k,   k a whole number,

with phi_A and phi_B followed through time. An end that goes around the rod, as where cloth slides
off, changes theta and never k. Only an edge that goes through P changes k, by one. So a change of k
is a passage, whatever else the cloth does, as long as no end turns by half a turn about the axis
between two looks.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike


def angles_about(x: ArrayLike, place: ArrayLike, along: ArrayLike) -> np.ndarray:
    """Angles (...,) [rad] of points x (..., 3) about an axis through `place` (3,) [m].

    along : (3,), unit, the direction of the axis
    """
    along = np.asarray(along, float)
    least = np.eye(3)[np.abs(along).argmin()]
    across = np.cross(along, least)
    across /= np.linalg.norm(across)
    arm = np.asarray(x, float) - place
    return np.arctan2(arm @ np.cross(along, across), arm @ across)


def wrapped(angle: np.ndarray) -> np.ndarray:
    """Angles [rad] less whole turns: from -pi to pi."""
    return angle - 2.0 * np.pi * np.round(angle / (2.0 * np.pi))


class Passages:
    """A part of a stepper that counts passages of rows of nodes through the axis of a rod.

    Parameters
    ----------
    rows : sequence of int arrays, numbers of nodes from one end of a row to the other
    axis : function of the time [s]; gives a point of the axis (3,) [m] and its direction (3,)
    every : int, steps between looks

    Attributes
    ----------
    passed : (len(rows),) int, passages of each row
    """

    def __init__(self, rows: Sequence[np.ndarray], axis: Callable, every: int = 5) -> None:
        self.rows = np.array(rows)
        self._axis, self._every, self._count = axis, every, 0
        self.passed = np.zeros(len(self.rows), int)
        self._ends: np.ndarray | None = None
        self._turns = np.zeros(len(self.rows))

    def look(self, x: np.ndarray, time: float) -> None:
        """Compare positions x (n, 3) [m] at a time [s] with those of the look before."""
        place, along = self._axis(time)
        phi = angles_about(x[self.rows], place, along)
        swept = wrapped(np.diff(phi, axis=1)).sum(axis=1)
        ends = phi[:, [0, -1]]
        if self._ends is None:
            self._ends = ends
        self._ends = self._ends + wrapped(ends - self._ends)
        turns = np.round((swept - self._ends[:, 1] + self._ends[:, 0]) / (2.0 * np.pi))
        if self._count > 0:
            self.passed += np.abs(turns - self._turns).astype(int)
        self._turns = turns
        self._count += 1

    def __call__(self, stepper: Any, dt: float) -> None:
        if stepper.steps % self._every == 0:
            self.look(stepper.shell.positions(), stepper.time)
