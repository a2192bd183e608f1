# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contact of a shell in explicit steps: the hook between the kick and the drift, Eqs. 15 and 16.

Gives the arrays of a stepper's owned nodes to `contact.Correction` and books what it did. Cloth is
met at half its thickness from the mid-surface.
"""

import time

import numpy as np

from contact.correction import Correction


class Touch:
    """Hook of a `Stepper`: contact of the owned nodes with a body.

    Parameters
    ----------
    stepper : Stepper, explicit
    body : contact.body.Body
    friction : float or (mu_s, mu_k)
    offset : float [m] or None: half the fabric's thickness

    Attributes
    ----------
    correction : contact.Correction, with its counters and ledgers
    seconds : float, spent in contact
    """

    def __init__(self, stepper, body, friction=0.3, offset=None):
        thickness = stepper.shell.fabric.thickness
        held = stepper.shell.supports.held[: stepper.n_owned, :3].any(axis=1)
        self.correction = Correction(
            body,
            stepper.n_owned,
            friction,
            0.5 * thickness if offset is None else offset,
            fixed=held,
        )
        self._x, self.seconds = np.empty_like(stepper.points), 0.0
        stepper.hooks.append(self)
        stepper.keep_old_velocities()

    def __call__(self, stepper, dt):
        start = time.perf_counter()
        np.add(stepper.points, stepper.owned[:, :3], out=self._x)
        self.correction(self._x, stepper.v, stepper.mass, dt, stepper.time, v_old=stepper.v_old)
        self.seconds += time.perf_counter() - start
