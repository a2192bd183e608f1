# SPDX-License-Identifier: LGPL-3.0-or-later
"""The director shell as a force model of explicit steps: Eq. 14, with damping of strain rates.

Pressure follows the sheet, so its force is one of the configuration: it is taken off here.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from shellform.fem.dolfinx_compat import Function
from shellform.fem.internal_force import Frozen, InternalForce
from shellform.fem.shell import Shell

from . import explicit_kernels

if TYPE_CHECKING:
    from shellform.fem.cell_stress import CellStress


class ShellForce:
    """Internal forces of a shell, a ForceModel.

    Parameters
    ----------
    shell : Shell, supports and loads complete
    damping : float [s], times the rate of the strains, adds to the stress

    Attributes
    ----------
    internal : InternalForce
    """

    turns_directors = True

    def __init__(self, shell: Shell, damping: float = 0.0) -> None:
        self.shell, self.damping = shell, damping
        self.internal = InternalForce(shell, damped=damping > 0)
        self._n = shell.partition.n_owned
        # w ahead by `damping` seconds; w itself where there is no damping
        self._field = shell.w if not damping else Function(shell.space)
        self._ahead = self._field.x.array.reshape(-1, 6)

    def force(self, w: np.ndarray, v: np.ndarray, q: np.ndarray, time: float) -> np.ndarray:
        """See ForceModel; w is the shell's own field."""
        shell = self.shell
        if self.damping:
            explicit_kernels.ahead(w[: self._n], v, q, self.damping, self._ahead[: self._n])
            if shell.comm.size > 1:
                self._field.x.scatter_forward()
        pressure = shell.loads.pressure_at(time, 1.0) if shell.loads.pressures else 0.0
        return self.internal(w, pressure, self._ahead)[: self._n]

    @property
    def friction(self) -> CellStress | None:
        """See ForceModel."""
        return self.internal.cells if self.shell.fabric.friction is not None else None

    def freeze(self, w: np.ndarray) -> Frozen | None:
        """See ForceModel; None for a sheet whose force is smooth."""
        return self.internal.freeze(w)

    def elastic(self, w: np.ndarray, frozen: Frozen | None) -> np.ndarray:
        """See ForceModel; without pressure."""
        return self.internal(w, frozen=frozen)[: self._n]

    def energy(self, w: np.ndarray) -> dict[str, float]:
        """See ForceModel; w is the shell's own field."""
        return self.shell.energy()

    def damping_loss(self, v_old: np.ndarray, v: np.ndarray, dt: float, last: float) -> float:
        """See ForceModel.

        The damping force R v works with the mean of v before the kick and after it, w:
        v R (v + w)/2 = 3/4 v R v + 1/4 w R w - (w - v) R (w - v)/4. The second part is booked with
        the next kick. The last part is left out: of second order, but for impacts, where the loss
        is booked too high by as much.
        """
        if not self.damping:
            return 0.0
        return self.internal.loss / self.damping * (0.25 * last + 0.75 * dt)

    def describe(self) -> dict[str, Any]:
        """See ForceModel."""
        return self.shell.plan()
