# SPDX-License-Identifier: LGPL-3.0-or-later
"""One step along an equilibrium path, F(x, level) = 0, on which the load level is an unknown.

Riks (Int. J. Solids Struct. 15, 1979) adds one equation that says how far the step goes. Crisfield
(Comput. Struct. 13, 1981) takes a sphere of displacements about the last point of the path:

    |u - u_last| = s,   |v|^2 = (1/A) integral of v . v over the sheet,

which a path cannot pass by, however it turns. Rotations are left out: they follow displacements.
Each iteration solves the bordered system by one factorisation of K and two right-hand sides,

    K a = -F,   K b = -dF/dlevel,   dx = a + dlevel b,

and dlevel from the added equation. The step goes on in the sense of the last one, u . b > 0: the
sign of det K, which a path with several modes loses, is not asked.
"""

from typing import Protocol

from petsc4py import PETSc

import numpy as np

from shellform.fem.callback_errors import exceptions_as_raised
from shellform.fem.dolfinx_compat import DIVERGED_NOT_FINITE
from shellform.fem.lumped_mass import nodal_areas

from .equilibrium import Equilibrium
from .newton import REASONS, Newton, Step


class InnerProduct:
    """Mean over the sheet of u . v, of displacements (n_owned, 3) [m]; collective."""

    def __init__(self, equilibrium: Equilibrium):
        partition = equilibrium.shell.partition
        areas = nodal_areas(partition.surface)
        self.weights = areas[partition.owned_nodes, None] / areas.sum()
        self.comm = equilibrium.shell.comm

    def __call__(self, *pairs: tuple[np.ndarray, np.ndarray]) -> list[float]:
        """One product [m^2] for each pair."""
        own = np.array([np.vdot(self.weights * u, v) for u, v in pairs])
        return self.comm.allreduce(own).tolist()


class Constraint(Protocol):
    """The equation that is added to F = 0."""

    def level_change(self, a: np.ndarray, b: np.ndarray, moved: np.ndarray, levels: float) -> float:
        """Change of the level that fulfils it, to first order or better.

        Parameters
        ----------
        a, b : (n_owned, 3) [m], displacements in -F / K and -dF/dlevel / K
        moved : (n_owned, 3) [m], displacements since the last point of the path
        levels : float, change of the level since then
        """
        ...


class Sphere:
    """A step of a length [m] that goes on where `before`, the last one (n_owned, 3) [m], went."""

    def __init__(self, inner: InnerProduct, radius: float, before: np.ndarray):
        self.inner, self.radius, self.before = inner, radius, before

    def level_change(self, a: np.ndarray, b: np.ndarray, moved: np.ndarray, levels: float) -> float:
        """See `Constraint`; where b does not meet the sphere, to the point of b nearest to it."""
        here, before = moved + a, self.before
        bb, hb, hh, mm, mb, sense = self.inner(
            (b, b), (here, b), (here, here), (moved, moved), (moved, b), (before, b)
        )
        if mm > 0.0:
            sense = mb
        inside = hb**2 - bb * (hh - self.radius**2)
        if bb == 0.0 or not np.isfinite(inside):
            return np.nan
        return (np.copysign(np.sqrt(max(inside, 0.0)), sense) - hb) / bb


class Plane:
    """A step to where row . u + weight level has changed by a `distance`, row (n_owned, 3)."""

    def __init__(self, equilibrium: Equilibrium, row: np.ndarray, weight: float, distance: float):
        self.comm = equilibrium.shell.comm
        self.row, self.weight, self.distance = row, weight, distance

    def level_change(self, a: np.ndarray, b: np.ndarray, moved: np.ndarray, levels: float) -> float:
        """See `Constraint`."""
        own = np.array([np.vdot(self.row, moved + a), np.vdot(self.row, b)])
        ahead, slope = self.comm.allreduce(own) + np.array([self.weight * levels, self.weight])
        return np.nan if slope == 0.0 else (self.distance - ahead) / slope


class ArcLength:
    """Newton's iterations on an equilibrium and its level.

    Of a `Newton` it takes the KSP, the tolerances and the monitors, hence the user's options.

    Attributes
    ----------
    moved : (n_owned, 3) [m], displacements in the last step, along the axes of the nodes
    tangent : (n_owned, 3) and float [1/m], of the path where the last step began: displacements and
        level for each metre of the path
    factorisations : int, of the tangent so far, those of steps that failed among them
    """

    def __init__(self, equilibrium: Equilibrium, newton: Newton):
        self.equilibrium, self.newton = equilibrium, newton
        self.inner = InnerProduct(equilibrium)
        self.moved = np.zeros((equilibrium.n_owned, 3))
        self.tangent: tuple[np.ndarray, float] = np.zeros_like(self.moved), 0.0
        self.factorisations = 0
        x = equilibrium.x
        self._a, self._b, self._right = x.duplicate(), x.duplicate(), x.duplicate()
        newton.snes.setSolution(x)  # its monitors look at it
        self._ksp = newton.snes.getKSP()
        self._ksp.setFromOptions()
        # norm [N] of the loads, the largest on the path: where they pass zero it still is a scale
        self._loads: float | None = None

    def step(self, constraint: Constraint, most: int) -> Step | None:
        """A step from the present point; its Step, or None with the point restored.

        `most` : int, iterations after which it is given up, if `snes_max_it` is not less
        """
        eq = self.equilibrium
        level, state = eq.level, eq.state()
        eq.start(level)
        self.newton.convergence.start()
        moved, size, iteration = np.zeros_like(self.moved), np.inf, 0
        rtol, atol, stol, max_it = self.newton.snes.getTolerances()
        while True:
            eq.residual(eq.x, eq.F)
            residual = eq.F.norm()
            self.newton.snes.monitor(iteration, residual)
            if iteration:
                reason = self.newton.convergence.verdict(
                    iteration, size, residual, (rtol, atol, stol, min(most, max_it)), self._loads
                )
                if reason > 0:
                    break
            else:
                reason = PETSc.SNES.ConvergedReason.CONVERGED_ITERATING
            if reason == 0 and not self._solve():
                reason = PETSc.SNES.ConvergedReason.DIVERGED_LINEAR_SOLVE
            if reason == 0:
                a, b = (v.array_r.reshape(-1, 5)[:, :3] for v in (self._a, self._b))
                change = constraint.level_change(a, b, moved, eq.level - level)
                if not np.isfinite(change):
                    reason = DIVERGED_NOT_FINITE
            if reason < 0:
                self.newton.reason = REASONS.get(reason, str(reason))
                eq.level = level
                eq.restore(state)
                return None
            if not iteration:
                self._take_tangent(b, np.sign(change))
            self._a.axpy(change, self._b)
            moved += self._a.array_r.reshape(-1, 5)[:, :3]
            size = self._a.norm()
            eq.x.axpy(1.0, self._a)
            eq.level += change
            eq.advance(eq.x)
            iteration += 1
        self.newton.reason = REASONS.get(reason, str(reason))
        self.moved = moved
        self._loads = max(self._loads or 0.0, eq.force_scale())
        return Step(eq.level, iteration, residual, self.newton.reason)

    def find_tangent(self, sense: float | None = None) -> bool:
        """Set `tangent` at the present point, by one factorisation; False if K is singular there.

        sense : sign of the level's change; None: goes on as the last step
        """
        eq = self.equilibrium
        eq.start(eq.level)
        eq.residual(eq.x, eq.F)
        if not self._solve():
            return False
        b = self._b.array_r.reshape(-1, 5)[:, :3]
        self._take_tangent(b, sense or np.sign(self.inner((self.moved, b))[0]))
        return True

    def _take_tangent(self, b, sign):
        rate = sign / np.sqrt(self.inner((b, b))[0] or 1.0)
        self.tangent = rate * b, float(rate)

    def _solve(self) -> bool:
        """Set a and b at the present iterate; False if the tangent is singular."""
        eq = self.equilibrium
        self.factorisations += 1
        self._ksp.setOperators(eq.tangent(eq.x))
        eq.level_derivative(self._right)
        try:
            with exceptions_as_raised():
                for right, solution in ((eq.F, self._a), (self._right, self._b)):
                    right.scale(-1.0)
                    self._ksp.solve(right, solution)
                    if self._ksp.getConvergedReason() < 0:
                        break
                else:
                    return True
        except PETSc.Error as error:
            if error.ierr != 76:  # an external library's failure: MUMPS on a singular matrix
                raise
        self._ksp.getPC().reset()  # a factor that failed would refuse every later matrix
        return False

    def destroy(self) -> None:
        """Free PETSc's vectors."""
        for vector in (self._a, self._b, self._right):
            vector.destroy()
