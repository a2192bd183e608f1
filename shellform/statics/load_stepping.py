# SPDX-License-Identifier: LGPL-3.0-or-later
"""Static solutions by load steps: Eq. 13 without inertia, solved by PETSc SNES.

Options carry the prefix `shell_`; what the user sets on the command line or in PETSC_OPTIONS wins.
A step that does not converge is cut back and retried; later steps grow again.
"""

import operator
import warnings
from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike

from shellform.errors import NotConverged
from shellform.fem.shell import Shell

from .equilibrium import Equilibrium
from .newton import Newton, Step
from .rigid_modes import refuse_free_motions

NEAR = 100.0  # times roundoff: loads below it may be lost in it


class Statics:
    """Load stepping of a shell. Also a context manager, which frees PETSc's objects at its end.

    Parameters
    ----------
    shell : Shell, with supports complete; starts from its reference state
    prefix : str, of the PETSc options
    mip : bool, see `Equilibrium`

    Attributes
    ----------
    level : float, where the shell stands; steps : list of Step; cutbacks : int

    Raises
    ------
    ValueError if the supports leave a rigid motion free

    Examples
    --------
    >>> import meshes, shellform as sf
    >>> surface = meshes.rectangle(0.1, 0.02, (4, 1))
    >>> shell = sf.Shell(surface, sf.Fabric.isotropic(1e6, 0.3, 1e-3, 400.0))
    >>> shell.supports.clamp("left")
    >>> shell.loads.line("right", (0.0, 0.0, 1e-3))
    >>> with sf.Statics(shell) as statics:
    ...     steps = statics.solve(2)
    >>> print(steps[-1].level)
    1.0
    """

    def __init__(self, shell: Shell, prefix: str = "shell_", mip: bool = True):
        refuse_free_motions(shell)
        self.shell, self.equilibrium = shell, Equilibrium(shell, mip)
        self.steps: list[Step] = []
        self.cutbacks, self.level = 0, 0.0
        self.newton: Newton | None = Newton(self.equilibrium, prefix)
        self._pace, self._told = 0.0, False

    def march(self, levels: int | ArrayLike, smallest: float = 2.0**-10) -> Iterator[Step]:
        """Solve at each load level in turn, cutting steps back where Newton fails.

        Parameters
        ----------
        levels : int (that many equal steps to 1) or sequence of load levels, up or down
        smallest : float, smallest sub-step as a part of a step

        Yields
        ------
        Step, at every level asked for (and not at the sub-steps between; `steps` has them all)

        Raises
        ------
        ValueError for levels that are no finite numbers; NotConverged, the shell then holds the
        last converged state and can be marched on from there
        """
        if self.newton is None or self.equilibrium.stale():
            raise ValueError("this solver is destroyed, or a newer one has taken the shell over")
        for goal in _levels(levels):
            part, whole = goal - self.level, abs(goal - self.level)
            step = self._sub_step(goal) if whole == 0 else None
            while self.level != goal:
                start = self.level
                rest = goal - start
                step = self._sub_step(goal if abs(part) > 0.999 * abs(rest) else start + part)
                if step is None:
                    part = 0.5 * (part if abs(part) < abs(rest) else rest)
                    if abs(part) < smallest * whole:
                        break
                elif step.iterations <= 8:
                    part = part * min(2.0, whole / abs(part))
            if step is None:
                raise NotConverged(
                    f"no equilibrium found just beyond level {self.level:.6g} (SNES: "
                    f"{self.newton.reason}), whose state is kept. {self._advice(goal)}"
                )
            yield step

    def _sub_step(self, target):
        """Solve at a level; the Step, or None with the state restored."""
        eq, start, state = self.equilibrium, self.level, self.equilibrium.state()
        step = self.newton.solve(target)
        if step is None:
            eq.restore(state)
            self.cutbacks += 1
            return None
        self.level = target
        self.shell.keep_slips()
        self.steps.append(step)
        self._watch_jumps(step, start, eq.largest_change(state))
        self._watch_loads()
        return step

    def _advice(self, goal):
        """What to do where no step from the present level to a goal converges."""
        eq = self.equilibrium
        eq.level = goal
        loads, roundoff = eq.pushes()[0], eq.roundoff()
        eq.level = self.level
        if 0 < loads < NEAR * roundoff:
            return (
                f"The loads, {loads:.2g} N, are near the roundoff of the membrane's forces, "
                f"{roundoff:.2g} N: a sheet this thin bends under less than its stretch resolves. "
                "Take more thickness, more bending stiffness or less membrane stiffness"
            )
        # only here, as few need it: it brings scipy
        from .path_following import limit_ahead

        turn = limit_ahead(eq, self.newton, np.sign(goal - self.level)) if self.steps else None
        where = "Past a limit point or buckling"
        if turn is not None:
            where = f"The path turns back at level {turn:.4g}, a limit point"
        advice = (
            f"{where}: follow the path (shellform.follow), prescribe a displacement "
            "(supports.move) or use dynamics"
        )
        if not self.steps:
            advice += (
                ". As nothing has converged yet, look too for a part that hangs on one point, "
                "and for needle-like cells"
            )
        return advice

    def _watch_loads(self):
        """Warn once where a solve ends though nothing is solved: the loads are below roundoff."""
        loads, roundoff = self.equilibrium.pushes()[0], self.newton.convergence.roundoff
        if self._told or not 0 < loads <= roundoff:
            return
        self._told = True
        if not self.shell.comm.rank:
            warnings.warn(
                f"at level {self.level:.6g} the loads, {loads:.2g} N, are below the roundoff of "
                f"the membrane's forces, {roundoff:.2g} N: what they do may be lost in it",
                stacklevel=5,
            )

    def _watch_jumps(self, step, start, change):
        if step.level == start:
            return
        pace = change / abs(step.level - start)
        if (
            self._pace
            and step.iterations > 8
            and pace > 5 * self._pace
            and not self.shell.comm.rank
        ):
            warnings.warn(
                f"between levels {start:.6g} and {step.level:.6g} the sheet jumped {change:.3g} m, "
                f"{pace / self._pace:.0f} times its pace before: a snap-through may lie there",
                stacklevel=4,
            )
        self._pace = pace

    def solve(self, levels: int | ArrayLike = 10) -> list[Step]:
        """`march` to the end; returns the list of all converged steps."""
        for _ in self.march(levels):
            pass
        return self.steps

    def reactions(self) -> np.ndarray:
        """Forces (n, 3) [N] of the supports on the sheet, in the surface's numbering.

        All ranks call it, all get them. Their sum is minus that of the loads.
        """
        return self.equilibrium.reactions()

    def reaction_moments(self) -> np.ndarray:
        """Moments (n, 3) [N m] of the supports on held directors, in the surface's numbering.

        All ranks call it, all get them.
        """
        return self.equilibrium.reaction_moments()

    def destroy(self) -> None:
        """Free PETSc's objects; the shell keeps its state."""
        if self.newton is not None:
            self.newton.destroy()
            self.equilibrium.destroy()
            self.newton = None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.destroy()


def _levels(levels):
    if np.ndim(levels) == 0:
        try:
            count = operator.index(levels)
        except TypeError:
            count = 0
        if count < 1:
            raise ValueError(
                f"levels are a number of equal steps to 1, or a sequence of levels, not {levels}"
            )
        levels = np.arange(1, count + 1) / count
    levels = np.asarray(levels, float).ravel()
    if not np.all(np.isfinite(levels)):
        raise ValueError(f"load levels must be finite numbers, not {levels.tolist()}")
    return levels.tolist()
