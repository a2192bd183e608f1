# SPDX-License-Identifier: LGPL-3.0-or-later
"""All that explicit steps change, kept in memory and brought back."""

from typing import Any, Self

import numpy as np


def changing(stepper: Any) -> list[np.ndarray]:
    """The arrays that steps change."""
    friction = stepper.force_model.friction
    inside = [] if friction is None else friction.state
    return [stepper.w, stepper.v, stepper.q, *stepper.books, *inside]


class State:
    """A copy of all that explicit steps change, made once and written over at each `keep`."""

    def __init__(self, stepper: Any) -> None:
        self._stepper = stepper
        self._arrays = changing(stepper)
        self._copies = [np.empty_like(array) for array in self._arrays]

    def keep(self) -> Self:
        """Copy the present state; returns self."""
        for copy, array in zip(self._copies, self._arrays, strict=True):
            np.copyto(copy, array)
        stepper = self._stepper
        self.clock = stepper.clock.numbers()
        self._parts = [(part, part.state()) for part in (*stepper.parts, *stepper.external.applied)]
        return self

    def restore(self) -> None:
        """Bring the kept state back."""
        for copy, array in zip(self._copies, self._arrays, strict=True):
            np.copyto(array, copy)
        self._stepper.set_clock(self.clock)
        for part, state in self._parts:
            part.restore(state)
