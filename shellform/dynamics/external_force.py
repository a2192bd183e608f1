# SPDX-License-Identifier: LGPL-3.0-or-later
"""External forces of explicit steps: loads, and applied forces that depend on the motion."""

from typing import Any

import numpy as np

from shellform.fem.loads import Loads

from .part import AppliedForce


class ExternalForce:
    """External forces on the owned nodes, brought up to date at every kick.

    Attributes
    ----------
    force : (n_owned, 3) [N], of the last update
    applied : list of AppliedForce
    """

    def __init__(self, loads: Loads, n_owned: int) -> None:
        self._loads, self._steady = loads, loads.steady()
        self.force = np.zeros((n_owned, 3))
        self.applied: list[AppliedForce] = []
        self._dead = loads.force_at(0.0, self.force, default=1.0).copy()
        self._changed = False  # applied forces are still in `force`

    def update(self, stepper: Any) -> np.ndarray:
        """`force` at the positions, velocities and time of a stepper."""
        if not self._steady:
            self.force[:] = 0.0
            self._loads.force_at(stepper.time, self.force, default=1.0)
        elif self.applied or self._changed:
            np.copyto(self.force, self._dead)
        for part in self.applied:
            part.add_force(stepper, self.force)
        self._changed = bool(self.applied)
        return self.force
