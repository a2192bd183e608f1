# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cells of a relaxed sheet that lie pressed between two parts of the body, as calf and thigh.

Flesh on both sides holds the sheet flat: it wrinkles in shorter waves and bears more before it does
(fem/wrinkles.py). Every few steps the stiffness of these beds is taken over from the nodes; a cell
has the mean of its four. That changes the energy stored in it, which the body does as work.
"""

from typing import Any

import numpy as np

from shellform.fem.cell_membrane import CellMembrane
from shellform.fem.dolfinx_compat import Function, cell_nodes, vector_space

EVERY = 10  # steps


class PressedCells:
    """What beds the cells of a stepper's sheet, from step to step.

    Parameters
    ----------
    stepper : Newmark of a sheet with a `cell_membrane` that is relaxed

    Attributes
    ----------
    beds : (n_owned,) float, stiffness [Pa/m] of the beds of the nodes when last looked at
    """

    def __init__(self, stepper: Any):
        partition = stepper.shell.partition
        self._membrane: CellMembrane = stepper.shell.cell_membrane
        self._field = Function(vector_space(partition.mesh, "Lagrange", 1, 1))
        self._cells = cell_nodes(partition.space)
        self.beds = self._field.x.array[: partition.n_owned]

    def look(self, stepper: Any, beds: np.ndarray) -> float:
        """Take over the beds (n_owned,) of the nodes, if it is time; all ranks call.

        Returns
        -------
        Work [J] that this does on this rank's cells
        """
        if stepper.steps % EVERY:
            return 0.0
        return self._set(stepper, beds)

    def restore(self, stepper: Any, beds: np.ndarray | float) -> None:
        """Go back to an earlier state of `beds`, or a number for all; all ranks call."""
        self._set(stepper, beds)

    def _set(self, stepper, beds):
        self.beds[:] = beds
        self._field.x.scatter_forward()
        stiffness = self._field.x.array[self._cells].mean(axis=1)
        return self._membrane.set_beds(stiffness, stepper.w)
