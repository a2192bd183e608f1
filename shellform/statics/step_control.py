# SPDX-License-Identifier: LGPL-3.0-or-later
"""How long the steps along an equilibrium path are, and which of its ends a step meets.

A step is as long as the last one times sqrt(desired / needed iterations) (Crisfield, Comput.
Struct. 13, 1981), halved where it does not converge or where the path turns too far in it.
"""

from typing import NamedTuple

import numpy as np

from shellform.errors import NotConverged

from .arc_length import ArcLength, Plane, Sphere
from .equilibrium import Equilibrium

SMALLEST = 1e-6  # of the longest step so far: below it the path is given up
LEAST_COSINE = 0.5  # between a step and the tangent it began with


class End(NamedTuple):
    """The path ends where row . u + weight level = value; row (n_owned, 3), on the nodes' axes."""

    name: str
    row: np.ndarray
    weight: float
    value: float

    def ahead(self, equilibrium: Equilibrium) -> float:
        """How much is missing at the present point; collective."""
        u = equilibrium.x.array_r.reshape(-1, 5)[:, :3]
        here = equilibrium.shell.comm.allreduce(float(np.vdot(self.row, u)))
        return self.value - here - self.weight * equilibrium.level

    def crossed(self, before: float, arc: ArcLength) -> bool:
        """True if the last step has met the end: by its last point, or by a parabola to there.

        A path may reach a level and come back below it, over a limit point, in one step.
        """
        towards, rate = arc.tangent
        across = arc.equilibrium.shell.comm.allreduce(float(np.vdot(self.row, towards)))
        (size,) = arc.inner((arc.moved, arc.moved))
        after = self.ahead(arc.equilibrium)
        slope = -np.sqrt(size) * (across + self.weight * rate)
        if before * after <= 0.0:
            return True
        roots = np.roots([after - before - slope, slope, before])
        return bool(np.any((roots.imag == 0.0) & (roots.real > 0.0) & (roots.real < 1.0)))


class StepControl:
    """How long the steps are, and which end a step meets.

    Parameters
    ----------
    arc : ArcLength, at a point of the path
    first : float, change of the level in the first step; iterations, longest : see `follow`
    """

    def __init__(self, arc: ArcLength, first: float, iterations: int, longest: float):
        self.arc, self.iterations, self.longest = arc, iterations, longest
        (size,) = arc.inner((arc.moved, arc.moved))
        self.first, self.least_first = first, SMALLEST * abs(first)
        # of the next step and of the longest so far [m]; none before the first step
        self.radius = self.most = min(float(np.sqrt(size)), longest)

    def next(self, ends: list[End]) -> str:
        """Take a step; the name of the end that it met, or "".

        Raises
        ------
        NotConverged where no step is short enough
        """
        eq = self.arc.equilibrium
        level, before, state = eq.level, self.arc.moved, eq.state()
        missing = [end.ahead(eq) for end in ends]
        while True:
            step = self._try(before)
            crossed = []
            if step:
                pairs = zip(ends, missing, strict=True)
                crossed = [(end, ahead) for end, ahead in pairs if end.crossed(ahead, self.arc)]
                if not crossed:
                    self._adapt(step)
                    return ""
                eq.level = level
                eq.restore(state)
            for end, ahead in crossed:
                if self._meet(end, ahead):
                    return end.name
            self.arc.moved = before
            self._shorten(level)

    def _try(self, before):
        """A step of the present length; None, with the point restored, if it will not do."""
        arc, eq = self.arc, self.arc.equilibrium
        level, state = eq.level, eq.state()
        if self.radius == 0.0:
            still = np.zeros_like(before)
            step = arc.step(Plane(eq, still, 1.0, self.first), 3 * self.iterations)
        else:
            step = arc.step(Sphere(arc.inner, self.radius, before), 3 * self.iterations)
        if step and self._turned():
            eq.level = level
            eq.restore(state)
            return None
        return step

    def _turned(self):
        """True if the step leads elsewhere than its beginning promised."""
        moved, (towards, _) = self.arc.moved, self.arc.tangent
        ahead, length = self.arc.inner((moved, towards), (moved, moved))
        return ahead < LEAST_COSINE * np.sqrt(length)

    def _meet(self, end, ahead):
        """A step to an end that a step of the present length has crossed."""
        arc, eq = self.arc, self.arc.equilibrium
        level, state = eq.level, eq.state()
        step = arc.step(Plane(eq, end.row, end.weight, ahead), 3 * self.iterations)
        if step is None:
            return None
        (size,) = arc.inner((arc.moved, arc.moved))
        if self.radius and np.sqrt(size) > 1.01 * self.radius:  # another point of the path
            eq.level = level
            eq.restore(state)
            return None
        return step

    def _adapt(self, step):
        (size,) = self.arc.inner((self.arc.moved, self.arc.moved))
        self.most = max(self.most, float(np.sqrt(size)))
        change = np.clip(np.sqrt(self.iterations / step.iterations), 0.5, 2.0)
        self.radius = min(float(np.sqrt(size)) * change, self.longest)

    def _shorten(self, level):
        if self.radius == 0.0:
            self.first *= 0.25
            given_up = abs(self.first) < self.least_first
        else:
            self.radius *= 0.5
            given_up = self.radius < SMALLEST * self.most
        if given_up:
            raise NotConverged(
                f"the path cannot be followed beyond level {level:.6g} (Newton: "
                f"{self.arc.newton.reason}), whose state is kept: it may branch there, or leave "
                "the numbers that the fabric's law knows. Look at the sheet there, begin with a "
                "shorter first step, or disturb its symmetry by a small load"
            )
