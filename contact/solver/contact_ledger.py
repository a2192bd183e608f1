# SPDX-License-Identifier: LGPL-3.0-or-later
"""What the body gave to points and took from them: impulses, work, friction and impact losses."""

import numpy as np

from .node_contact import BOOKED, FRICTION, IMPACT, WORK


class Ledger:
    """What contact did to n nodes and m segments, as acting on the cloth.

    Attributes
    ----------
    impulse : (n, 3) float, on every node [N s]
    segment_impulse : (m, 3) float, by every segment [N s]
    segment_moment : (m, 3) float, about the segment's centre at the start of each step [N m s]
    work : (m,) float, work of the segment's motion on the cloth [J]
    friction_loss, impact_loss : (m,) float, energy taken by friction and by normal impulses [J];
        the latter is negative where a point that starts inside is moved out, and holds what soft
        parts have stored and not yet given back
    seconds : float, time covered [s]
    """

    def __init__(self, n, m):
        self.impulse, self.table, self.seconds = np.zeros((n, 3)), np.zeros((m, BOOKED)), 0.0
        self.segment_impulse, self.segment_moment = self.table[:, :3], self.table[:, 3:6]
        self.work = self.table[:, WORK]
        self.friction_loss, self.impact_loss = self.table[:, FRICTION], self.table[:, IMPACT]

    def clear(self):
        """Set everything to zero."""
        self.impulse[:] = 0.0
        self.table[:] = 0.0
        self.seconds = 0.0
