# SPDX-License-Identifier: LGPL-3.0-or-later
"""The membrane law of a sheet that wrinkles below its cells, see material/wrinkling.py."""

import numpy as np

from shellform.material.relaxed_stress import relax
from shellform.material.wrinkling import trial_angles

from .membrane_law import Answer
from .wrinkles import Wrinkles


class Relaxed:
    """A sheet that wrinkles.

    Parameters
    ----------
    membrane : (3, 3), stiffness A of the fabric [N/m]; wrinkles : Wrinkles

    Attributes
    ----------
    state, direction : (m,), of the strains of all cells asked for last, see `relax`
    """

    def __init__(self, membrane: np.ndarray, wrinkles: Wrinkles):
        self._membrane, self._compliance = membrane, np.linalg.inv(membrane)
        self._angles, self._wrinkles = trial_angles(membrane), wrinkles
        self.state = np.zeros(len(wrinkles.load), np.int64)
        self.direction = np.zeros(len(wrinkles.load))

    def __call__(self, E: np.ndarray, cells: np.ndarray | None = None) -> Answer:
        m, load = len(E), self._wrinkles.load
        answer = np.empty(m), np.empty((m, 3)), np.empty((m, 3, 3))
        kept = self.state, self.direction
        if cells is not None:
            load, kept = load[cells], (np.empty(m, np.int64), np.empty(m))
        fixed = self._membrane, self._compliance, self._angles
        relax(np.ascontiguousarray(E), *fixed, load, *answer, *kept)
        return answer
