# SPDX-License-Identifier: LGPL-3.0-or-later
"""The clock and the books of a stepper: what every step adds to."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

WORKS = ("internal", "external", "drag", "support", "damping")
INTERNAL, EXTERNAL, DRAG, SUPPORT, DAMPING = range(len(WORKS))
BY_LOADS, BY_SUPPORTS, BY_DRAG = range(3)


class Books(NamedTuple):
    """Works and impulses on the owned nodes of this rank, from the start to the last half step.

    works : (5,) [J], by the order of WORKS: done by internal forces, loads, and supports; taken by
        drag and damping
    impulses : (3, 3) [N s], rows: of loads, supports and drag
    """

    works: np.ndarray
    impulses: np.ndarray

    def by_kind(self) -> dict[str, float]:
        """Works [J] by name."""
        return dict(zip(WORKS, self.works.tolist(), strict=True))


def new_books() -> Books:
    """Books with nothing in them."""
    return Books(np.zeros(len(WORKS)), np.zeros((3, 3)))


@dataclass
class Clock:
    """Time and steps.

    time : float [s], present time; dt : float [s], step to take where nothing shortens it
    last_dt : float [s], the last step taken; last_kick : the time its forces acted
    critical_dt : float [s], largest stable step when last looked at
    steps : int, taken so far
    """

    time: float = 0.0
    dt: float = 0.0
    last_dt: float = 0.0
    last_kick: float = 0.0
    critical_dt: float = 0.0
    steps: int = 0

    def numbers(self) -> np.ndarray:
        """All of it, (6,), for `set`."""
        times = self.time, self.dt, self.last_dt, self.critical_dt
        return np.array([*times, self.steps, self.last_kick])

    def set(self, numbers: np.ndarray) -> None:
        """Bring back what `numbers` gave."""
        self.time, self.dt, self.last_dt, self.critical_dt = numbers[:4].tolist()
        self.steps, self.last_kick = int(numbers[4]), float(numbers[5])
