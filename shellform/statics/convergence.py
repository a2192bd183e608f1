# SPDX-License-Identifier: LGPL-3.0-or-later
"""When an iterate is a solution of Eq. 13, to the tolerances asked for or to roundoff.

Thin sheets mix a stiff membrane with a soft bending: the roundoff of the membrane force can exceed
any fixed tolerance of the loads. A solve has converged when the residual is small against the
loads, or no larger than that roundoff. Roundoff is first estimated from sizes, which costs nothing
and knows no corners: cells that lean, or are long and narrow, make up to a thousand times more of
it. Where the updates have become nothing and the residual is above the estimate, roundoff is
measured (roundoff.py).
"""

from petsc4py import PETSc

import numpy as np

from shellform.fem.dolfinx_compat import DIVERGED_NOT_FINITE

from .equilibrium import Equilibrium

# Residual and measurement are two samples of one noise: on cells of all kinds, up to 1000 times as
# long as wide with corners up to 179 degrees, one is 0.03 to 3.2 times the other while the noise
# spans ten decades.
SAMPLES_APART = 10.0


class Convergence:
    """The test of the iterates of an equilibrium's solves.

    Attributes
    ----------
    roundoff : float [N], of the residual at the last iterate; measured where that was needed
    """

    def __init__(self, equilibrium: Equilibrium):
        self.equilibrium, self.roundoff = equilibrium, 0.0
        self._best: list[float] = []

    def start(self) -> None:
        """Begin a solve."""
        self._best = []

    def verdict(
        self,
        iteration: int,
        step: float,
        residual: float,
        tolerances: tuple[float, float, float, int],
        loads: float | None = None,
    ) -> PETSc.SNES.ConvergedReason:
        """Reason to end the solve at an iterate, or CONVERGED_ITERATING.

        Parameters
        ----------
        iteration : from 0; step : norm of the last update [m]; residual : norm of F [N]
        tolerances : (rtol, atol, stol, max_it) as `SNES.getTolerances` gives them
        loads : norm [N] that rtol counts from; None: of the loads at the present level
        """
        reasons = PETSc.SNES.ConvergedReason
        rtol, atol, stol, max_it = tolerances
        if not np.isfinite(residual):
            return DIVERGED_NOT_FINITE
        eq = self.equilibrium
        self.roundoff = roundoff = eq.roundoff()
        if residual <= atol or residual <= rtol * (eq.force_scale() if loads is None else loads):
            return reasons.CONVERGED_FNORM_RELATIVE
        # roundoff is an estimate: a load as small still deserves one iteration
        if residual == 0.0 or (iteration and residual <= roundoff):
            return reasons.CONVERGED_FNORM_ABS
        scale = eq.length * np.sqrt(len(eq.shell.partition.surface.points))
        if iteration and step <= stol * scale:
            if residual > 100 * roundoff:
                self.roundoff = eq.measured_roundoff()
            if residual <= max(100 * roundoff, SAMPLES_APART * self.roundoff):
                return reasons.CONVERGED_SNORM_RELATIVE
        # beyond a limit point the residual wanders: no use in spending all iterations there
        self._best.append(min([residual, *self._best[-1:]]))
        if iteration >= max_it or (iteration >= 16 and self._best[-1] > 0.1 * self._best[-13]):
            return reasons.DIVERGED_MAX_IT
        return reasons.CONVERGED_ITERATING
