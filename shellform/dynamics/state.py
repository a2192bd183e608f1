# SPDX-License-Identifier: LGPL-3.0-or-later
"""All that explicit steps change, kept in memory and brought back."""

import numpy as np


def changing(stepper):
    """The arrays that steps change."""
    return [stepper.w, stepper.v, stepper.q, stepper.works, stepper.totals]


def clock(stepper):
    """The numbers that steps change, (6,)."""
    times = stepper.time, stepper.dt, stepper.last_dt, stepper.critical_dt
    return np.array([*times, stepper.steps, stepper.last_kick])


def set_clock(stepper, numbers):
    """Bring back what `clock` gave."""
    stepper.time, stepper.dt, stepper.last_dt, stepper.critical_dt = numbers[:4].tolist()
    stepper.steps, stepper.last_kick = int(numbers[4]), float(numbers[5])
    stepper.fault, stepper.moved_sum = None, 0.0


class State:
    """A copy of all that explicit steps change, made once and written over at each `keep`.

    Hooks and pulls that have `state()` and `restore(state)` are kept too.
    """

    def __init__(self, stepper):
        self._stepper = stepper
        self._arrays = changing(stepper)
        self._copies = [np.empty_like(array) for array in self._arrays]

    def keep(self):
        """Copy the present state; returns self."""
        for copy, array in zip(self._copies, self._arrays, strict=True):
            np.copyto(copy, array)
        stepper = self._stepper
        self.clock = clock(stepper)
        self._others = [(one, one.state()) for one in _others(stepper)]
        self._windows = [(c, _window(c)) for c in corrections(stepper)]
        return self

    def restore(self):
        """Bring the kept state back."""
        for copy, array in zip(self._copies, self._arrays, strict=True):
            np.copyto(array, copy)
        set_clock(self._stepper, self.clock)
        for one, state in self._others:
            one.restore(state)
        for correction, (impulse, table, seconds) in self._windows:
            window = correction.window
            window.impulse[:], window.table[:], window.seconds = impulse, table, seconds


def corrections(stepper):
    """The contact corrections of a stepper's hooks."""
    return [hook.correction for hook in stepper.hooks if hasattr(hook, "correction")]


def _others(stepper):
    """Objects with a state of their own: hooks, pulls and, where a hook has none, its contact."""
    found = []
    for one in (*stepper.hooks, *stepper.pulls):
        one = one if hasattr(one, "state") else getattr(one, "correction", None)
        if hasattr(one, "state") and hasattr(one, "restore"):
            found.append(one)
    return found


def _window(correction):
    window = correction.window
    return window.impulse.copy(), window.table.copy(), window.seconds
