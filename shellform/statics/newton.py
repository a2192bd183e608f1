# SPDX-License-Identifier: LGPL-3.0-or-later
"""One nonlinear solve of the 5-dof equilibrium, Eq. 13, by PETSc SNES.

Options carry a prefix; what the user sets on the command line or in PETSC_OPTIONS wins.
"""

import weakref
from dataclasses import dataclass

from petsc4py import PETSc

from shellform.fem.callback_errors import exceptions_as_raised
from shellform.fem.destroyed_together import destroy_with

from .convergence import Convergence
from .equilibrium import Equilibrium

DEFAULTS = {
    "snes_type": "newtonls",
    # the first residual of a thin sheet rises far above the last before it falls: full steps
    "snes_linesearch_type": "basic",
    "snes_rtol": 1e-8,
    "snes_stol": 1e-10,
    "snes_max_it": 25,
    "ksp_type": "preonly",
    "pc_type": "lu",
    "pc_factor_mat_solver_type": "mumps",
    # room for pivoting: far iterates are indefinite
    "mat_mumps_icntl_14": 100,
}

REASONS = {
    getattr(PETSc.SNES.ConvergedReason, name): name.replace("_", " ").lower()
    for name in dir(PETSc.SNES.ConvergedReason)
    if name.isupper()
}


@dataclass(frozen=True)
class Step:
    """A converged step: load level or time, Newton iterations, residual [N], reason in words."""

    level: float
    iterations: int
    residual: float
    reason: str


class Newton:
    """SNES on an equilibrium.

    Parameters
    ----------
    equilibrium : Equilibrium
    prefix : str, of the PETSc options

    Attributes
    ----------
    reason : str, how the last solve ended, in words
    convergence : Convergence, what iterates are held to
    snes : PETSc.SNES
    """

    def __init__(self, equilibrium: Equilibrium, prefix: str):
        self.equilibrium = eq = equilibrium
        set_defaults(prefix, DEFAULTS)
        eq.start(0.0)
        eq.tangent(eq.x)  # creates K
        eq.assembly_seconds = 0.0  # of solves; forms may have been compiled here
        self.reason, self.convergence = "not yet run", Convergence(eq)
        self.snes = PETSc.SNES().create(eq.shell.comm)
        self.snes.setOptionsPrefix(prefix)
        # PETSc's hold on them is one that Python's collector cannot see: none would ever be freed
        me, its = weakref.proxy(self), weakref.proxy(eq)
        self.snes.setFunction(lambda snes, x, F: its.residual(x, F), eq.F)
        self.snes.setJacobian(lambda snes, x, K, P: its.tangent(x) and None, eq.K)
        self.snes.setUpdate(lambda snes, iteration: me._advance(iteration))
        self.snes.setConvergenceTest(lambda *state: me._converged(*state))
        self.snes.setFromOptions()
        destroy_with(self, self.snes, eq.shell.comm)

    def solve(self, level: float) -> Step | None:
        """Solve at a load level or time from the present state; returns a Step, None if it fails.

        The state after a failure is that of the last iterate: restore it.
        """
        eq = self.equilibrium
        eq.start(level)
        self.convergence.start()
        try:
            with exceptions_as_raised():
                self.snes.solve(None, eq.x)
            reason = self.snes.getConvergedReason()
        except PETSc.Error as error:
            if error.ierr != 76:  # an external library's failure: MUMPS on a singular matrix
                raise
            reason = PETSc.SNES.ConvergedReason.DIVERGED_LINEAR_SOLVE
        self.reason = REASONS.get(reason, str(reason))
        if reason <= 0:
            # a factor that failed would refuse every later matrix
            self.snes.getKSP().getPC().reset()
            return None
        eq.advance(eq.x)
        return Step(level, self.snes.getIterationNumber(), self.snes.getFunctionNorm(), self.reason)

    def _advance(self, iteration):
        if iteration:
            self.equilibrium.advance(self.snes.getSolution())

    def _converged(self, snes, iteration, norms):
        _, step, residual = norms
        return self.convergence.verdict(iteration, step, residual, snes.getTolerances())

    def destroy(self) -> None:
        """Free the SNES."""
        self.snes.destroy()


def set_defaults(prefix: str, values: dict) -> None:
    """Put option values into PETSc's database under a prefix where the user set none."""
    options = PETSc.Options(prefix)
    for key, value in values.items():
        if not options.hasName(key):
            options[key] = value
