# SPDX-License-Identifier: LGPL-3.0-or-later
"""Static solutions by load steps: Eq. 13 without inertia, solved by PETSc SNES.

Options carry the prefix `shell_`; what the user sets on the command line or in PETSC_OPTIONS wins.
A step that does not converge is cut back and retried; later steps grow again.
"""

from dataclasses import dataclass

from petsc4py import PETSc

import numpy as np

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
}

REASONS = {
    getattr(PETSc.SNES.ConvergedReason, name): name.replace("_", " ").lower()
    for name in dir(PETSc.SNES.ConvergedReason)
    if name.isupper()
}


class NotConverged(RuntimeError):
    """No solution at some load level after every cut-back; the last good state is kept."""


@dataclass(frozen=True)
class Step:
    """A converged load step: its level, Newton iterations, residual [N] and reason in words."""

    level: float
    iterations: int
    residual: float
    reason: str


class Statics:
    """Load stepping of a shell.

    Parameters
    ----------
    shell : Shell, with supports and loads complete
    prefix : str, of the PETSc options
    mip : bool, see `Equilibrium`
    """

    def __init__(self, shell, prefix="shell_", mip=True):
        self.shell, self.equilibrium = shell, Equilibrium(shell, mip)
        self.steps, self.cutbacks = [], 0
        self.level = 0.0
        set_defaults(prefix, DEFAULTS)
        eq = self.equilibrium
        eq.start(0.0)
        eq.tangent(eq.x)  # creates K
        self.snes = PETSc.SNES().create(shell.comm)
        self.snes.setOptionsPrefix(prefix)
        self.snes.setFunction(lambda snes, x, F: eq.residual(x, F), eq.F)
        self.snes.setJacobian(lambda snes, x, K, P: eq.tangent(x) and None, eq.K)
        self.snes.setUpdate(lambda snes, iteration: self._advance(iteration))
        self.snes.setConvergenceTest(self._converged)
        self.snes.setFromOptions()

    def _advance(self, iteration):
        if iteration:
            self.equilibrium.advance(self.snes.getSolution())

    def _converged(self, snes, iteration, norms):
        reasons = PETSc.SNES.ConvergedReason
        _, step, residual = norms
        rtol, atol, stol, max_it = snes.getTolerances()
        if not np.isfinite(residual):
            return reasons.DIVERGED_FNORM_NAN
        eq = self.equilibrium
        roundoff = eq.roundoff()
        if residual <= atol or residual <= rtol * eq.force_scale():
            return reasons.CONVERGED_FNORM_RELATIVE
        # roundoff is an estimate: a load as small still deserves one iteration
        if residual == 0.0 or (iteration and residual <= roundoff):
            return reasons.CONVERGED_FNORM_ABS
        scale = eq.length * np.sqrt(len(eq.shell.partition.surface.points))
        if iteration and step <= stol * scale and residual <= 100 * roundoff:
            return reasons.CONVERGED_SNORM_RELATIVE
        if iteration >= max_it:
            return reasons.DIVERGED_MAX_IT
        return reasons.CONVERGED_ITERATING

    def solve_at(self, level):
        """One Newton solve at a load level from the present state; returns a Step or None."""
        eq = self.equilibrium
        eq.start(level)
        self.snes.solve(None, eq.x)
        reason = self.snes.getConvergedReason()
        self.reason = REASONS.get(reason, str(reason))
        if reason <= 0:
            return None
        eq.advance(eq.x)
        self.level = level
        return Step(level, self.snes.getIterationNumber(), self.snes.getFunctionNorm(), self.reason)

    def march(self, levels, smallest=2.0**-10):
        """Solve at each load level in turn, cutting steps back where Newton fails.

        Parameters
        ----------
        levels : int (that many equal steps to 1) or increasing sequence of load levels
        smallest : float, smallest sub-step as a part of a step

        Yields
        ------
        Step, at every level asked for (and not at the sub-steps between; `steps` has them all)

        Raises
        ------
        NotConverged; the shell then holds the last converged state
        """
        if isinstance(levels, int):
            levels = np.linspace(0, 1, levels + 1)[1:]
        for goal in map(float, levels):
            whole = part = goal - self.level
            while self.level != goal:
                state, start = self.equilibrium.state(), self.level
                target = goal if abs(part) > 0.999 * abs(goal - start) else start + part
                step = self.solve_at(target)
                if step is not None:
                    self.steps.append(step)
                    if step.iterations <= 8:
                        part = 2 * part if abs(2 * part) < abs(whole) else whole
                    continue
                self.equilibrium.restore(state)
                self.cutbacks += 1
                part = 0.5 * (target - start)
                if abs(part) < smallest * abs(whole):
                    raise NotConverged(
                        f"no equilibrium between levels {start:.6g} and {start + 2 * part:.6g}: "
                        f"SNES says {self.reason}. The state at {start:.6g} is kept; try smaller "
                        "steps, more inertia (dynamics) or check the supports"
                    )
            yield step

    def solve(self, levels=10):
        """`march` to the end; returns the list of all converged steps."""
        for _ in self.march(levels):
            pass
        return self.steps

    def destroy(self):
        """Free PETSc's objects."""
        self.snes.destroy()
        self.equilibrium.destroy()


def set_defaults(prefix, values):
    """Put option values into PETSc's database under a prefix where the user set none."""
    options = PETSc.Options(prefix)
    for key, value in values.items():
        if not options.hasName(key):
            options[key] = value
