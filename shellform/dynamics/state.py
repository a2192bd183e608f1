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
    """A copy of all that explicit steps change, made once and written over at each `keep`."""

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
        self._parts = [(part, part.state()) for part in (*stepper.parts, *stepper.applied_forces)]
        return self

    def restore(self):
        """Bring the kept state back."""
        for copy, array in zip(self._copies, self._arrays, strict=True):
            np.copyto(array, copy)
        set_clock(self._stepper, self.clock)
        for part, state in self._parts:
            part.restore(state)
