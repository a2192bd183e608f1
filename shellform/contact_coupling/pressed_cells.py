# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cells of a relaxed sheet that lie pressed between two parts of the body, as calf and thigh.

Flesh on both sides holds the sheet flat: it wrinkles in shorter waves and bears more before it does
(fem/wrinkles.py). Every few steps the stiffness of these beds follows what presses the nodes; a
cell has the mean of its four. That changes the energy stored in it, which the body does as work.

A node in a narrow crease is pressed from both sides in some steps and from one in others. Beds that
came and went with it would stiffen a cell while it is pushed together, let it spring open, and be
gone when it is pushed together again: the body would do work on the cloth in each turn. So beds
follow by a first-order lag of the root of k, as a cell bears N_c = 2 (k D)^(1/2): slow against such
turns, which they see the mean of, and fast against limbs that close.
"""

from typing import Any

import numpy as np

from shellform.fem.cell_membrane import CellMembrane
from shellform.fem.dolfinx_compat import Function, cell_nodes, vector_space

EVERY = 10  # steps
FOLLOW = 0.02  # s, time in which beds follow what presses the nodes
GONE = 0.1  # Pa/m: a softer bed is none


class PressedCells:
    """What beds the cells of a stepper's sheet, from step to step.

    Parameters
    ----------
    stepper : Newmark of a sheet with a `cell_membrane` that is relaxed

    Attributes
    ----------
    beds : (n_owned,) float, stiffness [Pa/m] of the beds of the nodes, as cells have them
    """

    def __init__(self, stepper: Any):
        partition = stepper.shell.partition
        self._membrane: CellMembrane = stepper.shell.cell_membrane
        self._stiffest = stepper.shell.wrinkles.stiffest
        self._field = Function(vector_space(partition.mesh, "Lagrange", 1, 1))
        self._cells = cell_nodes(partition.space)
        self.beds = self._field.x.array[: partition.n_owned]

    def look(self, stepper: Any, beds: np.ndarray) -> float:
        """Follow the beds (n_owned,) that press the nodes, if it is time; all ranks call.

        Returns
        -------
        Work [J] that this does on this rank's cells
        """
        if stepper.steps % EVERY:
            return 0.0
        part = 1.0 - np.exp(-EVERY * stepper.clock.last_dt / FOLLOW)
        goal = np.sqrt(np.minimum(beds, self._stiffest))
        now = (self.beds**0.5 + part * (goal - self.beds**0.5)) ** 2
        now[(goal == 0.0) & (now < GONE)] = 0.0
        return self._set(stepper, now)

    def restore(self, stepper: Any, beds: np.ndarray | float) -> None:
        """Go back to an earlier state of `beds`, or a number for all; all ranks call."""
        self._set(stepper, beds)

    def _set(self, stepper, beds):
        self.beds[:] = beds
        self._field.x.scatter_forward()
        stiffness = self._field.x.array[self._cells].mean(axis=1)
        return self._membrane.set_beds(stiffness, stepper.w)
