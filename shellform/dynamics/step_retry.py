# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cutting back explicit steps that diverge: the last good state and the watch on energy.

At every look (`Newmark.recheck` steps) the state is judged, then kept in memory. Internal forces
cannot give more than they were given: with E = kinetic + strain energy and the excess

    R = (change of strain energy) + (work of internal forces on the nodes)

E - R is what the sheet had, got from loads, supports and body, and lost. R is the error of the time
steps, or minus what damping took. Central differences let both energies swing by up to
1/(1 - (omega dt/2)^2) in a vibration of frequency omega; more than `margin` times that is
divergence. Excess of earlier looks counts, fading by `fading` a look, so that slow growth is seen
too.

Two states are kept: at a divergence steps go on from the earlier, in which a growing error that
the later look could not yet see is small. A call of `advance` begins with a fresh one, since what
was written meanwhile cannot be taken back.
"""

from typing import Any

import numpy as np

from shellform.errors import Unstable

from .stable_step import SPARE
from .state import State


class Rewind:
    """Judge of a Newmark stepper's steps.

    Attributes
    ----------
    cut : float, part of the step factor in force: halved at a divergence, recovers by `recovery` at
        each good look
    retries : int, divergences without getting past the first of them, after which `Unstable` is
        raised
    cutbacks : int, divergences so far
    excess : float [J], energy from nowhere by the last looks
    """

    margin, fading, recovery = 1.5, 0.8, 1.05

    def __init__(self, stepper: Any, retries: int = 4) -> None:
        self._stepper, self.retries = stepper, retries
        self.cut, self.cutbacks, self.excess = 1.0, 0, 0.0
        self._tried: list[float] = []
        self._states: list[State] = []
        self._spare: list[State] = []
        self._base, self._seen, self._looked, self._failed = None, None, 0, 0.0

    def begin(self, steps: float) -> None:
        """Keep the state at the start of an `advance` of some steps."""
        stepper = self._stepper
        # what was written since the last call cannot be taken back
        self._spare, self._states = self._spare + self._states, []
        self._keep()
        if stepper.shell.comm.allreduce(self._seen != self._mark()):
            # someone has moved the sheet: what energy it has now is given
            self._base, self.excess = None, 0.0
            if 2 * steps >= stepper.recheck:
                self._judge()

    def end(self) -> None:
        """Look once more if the last look is long ago, and remember the places."""
        stepper = self._stepper
        stepper.check()
        if 2 * (stepper.steps - self._looked) >= stepper.recheck:
            self._judge()
        self._seen = self._mark()

    def look(self) -> None:
        """Judge the present state and keep it; raises Unstable, on all ranks."""
        self._judge()
        if self._stepper.time > self._failed:
            self._tried.clear()
        self.cut = min(1.0, self.recovery * self.cut)

    def keep(self) -> None:
        """Keep the present state and the one before."""
        if len(self._states) > 1:
            self._spare.append(self._states.pop(0))
        self._keep()

    def back(self, fault: Unstable) -> None:
        """Go back to a good state with half the step; raises Unstable if that was tried enough."""
        stepper, failed = self._stepper, self._stepper.dt
        self._failed = max(self._failed, stepper.time)
        state = self._states[0]
        state.restore()
        self._spare += self._states[1:]
        self._states, self._base, self.excess = [state], None, 0.0
        self._seen = self._mark()
        self._judge()
        self._tried.append(failed)
        if len(self._tried) > self.retries:
            steps = ", ".join(f"{dt:.3g}" for dt in self._tried)
            self._tried.clear()
            raise Unstable(
                f"{fault}. Tried from t = {stepper.time:.6g} s with steps of {steps} s; the state "
                "at that time is kept and can be saved"
            ) from fault
        self.cut *= 0.5
        self.cutbacks += 1
        stepper.clock.critical_dt = stepper.find_stable_step()
        stepper.dt = min(0.5 * failed, self.cut * stepper.factor * stepper.critical_dt)

    def _keep(self):
        state = self._spare.pop() if self._spare else State(self._stepper)
        self._states.append(state.keep())

    def _mark(self):
        owned = self._stepper.owned
        return self._stepper.steps, float(owned.sum()), float(np.vdot(owned, owned))

    def _judge(self):
        stepper = self._stepper
        self._looked = stepper.steps
        if stepper.shell.loads.pressures:
            return  # their work is booked with that of internal forces
        now = stepper.balance()
        base, self._base = self._base, now
        if base is None:
            return
        gained = now["strain"] - base["strain"] + now["internal"] - base["internal"]
        energy = now["kinetic"] + now["strain"]
        self.excess = max(0.0, self.fading * self.excess + gained)
        part = SPARE * min(1.0, self.cut * stepper.factor)
        allowed = self.margin / (1 - part**2) * max(energy - self.excess, stepper.smallest_energy)
        if not energy <= allowed:
            raise Unstable(
                f"energy from nothing at t = {stepper.time:.6g} s, step {stepper.steps} of "
                f"{stepper.clock.last_dt:.3g} s: {stepper.shell.surface.source} has "
                f"{energy:.3g} J, "
                f"{self.excess:.3g} J of it neither from loads nor supports nor body"
            )
