# SPDX-License-Identifier: LGPL-3.0-or-later
"""Implicit midpoint steps: angular momentum is kept, Sec. 3.1.3 of the paper with other weights.

    u(n+1/2) = u + dt/2 v + dt^2/4 a,    v(n+1) = v + dt a,    u(n+1) = u + dt (v + v(n+1))/2,

with m a = f(n+1/2). Strains do not change when the sheet is turned, so the forces of any one
configuration have no moment about any point, x_mid x f + d_mid x f_d = 0 in the sum: what they add
to the angular momentum in a step is nothing, however long the step and whatever Newton's
tolerance. Directors go through the middle and on along the same great circle. Their own share in
the angular momentum, which is small, is kept to second order.

Of second order, without damping. Energy swings by O(dt^2) where steps resolve what moves. Stiff
modes that they do not resolve feed on the motion and grow within some hundred steps; in a thin
sheet these are directors turning against the sheet, so here their inertia is raised as it is in
explicit steps.
"""

import numpy as np

from shellform.fem.director import along, carry
from shellform.fem.lumped_mass import ROTARY_SCALE
from shellform.fem.shell import Shell

from .books import BY_LOADS, EXTERNAL
from .implicit import ImplicitNewmark
from .implicit_supports import book_drag, constrain, slowed


class ImplicitMidpoint(ImplicitNewmark):
    """Implicit midpoint steps of a shell, without contact.

    Parameters
    ----------
    shell, dt, tolerance, prefix, drag : see ImplicitNewmark
    rotary_scale : float, see fem/lumped_mass.py; that of explicit steps by default, see above

    Attributes and errors as there; `a` is that of the middle of the last step.
    """

    instant = 0.5

    def __init__(
        self,
        shell: Shell,
        dt: float,
        tolerance: float | None = None,
        rotary_scale: float = ROTARY_SCALE,
        prefix: str = "shell_",
        drag: float = 0.0,
    ) -> None:
        super().__init__(shell, dt, 0.25, 0.5, tolerance, rotary_scale, prefix, drag=drag)

    def _predict(self, old, dt):
        eq, velocity = self.equilibrium, slowed(self, dt)
        eq.start_d = old[:, 3:]
        eq.ahead_u = old[:, :3] + 0.5 * dt * velocity[:, :3]
        eq.ahead_d = 0.5 * dt * velocity[:, 3:]
        eq.factor = 4 / dt**2 * self._mass6
        eq.predict()

    def _finish(self, old, force, outer, dt):
        start, middle = old[:, 3:], self.owned[:, 3:].copy()
        free = slowed(self, dt)
        book_drag(self, free)
        v_old = free[:, :3].copy()
        end = 2 * along(start, middle) - start
        end /= np.linalg.norm(end, axis=1, keepdims=True)
        free[:, 3:] = carry(free[:, 3:], start, middle)
        free += dt * force
        free[:, 3:] = carry(free[:, 3:], middle, end)
        self.owned[:, 3:] = end
        self.scatter()
        self.equilibrium.adopt()
        self.v[:] = free[:, :3]
        constrain(self, free, self.time + dt, dt)
        self.owned[:, :3] = old[:, :3] + 0.5 * dt * (v_old + self.v)
        for local, u, d in self.shell.supports.prescribed(self.time + dt):
            for value, part in ((u, slice(0, 3)), (d, slice(3, 6))):
                if value is not None:
                    self.w[local, part] = value
        self.scatter()
        self.equilibrium.adopt()
        self.a, self._force, self._outer = force, force, outer
        self.books.impulses[BY_LOADS] += dt * outer.sum(axis=0)
        self.books.works[EXTERNAL] += np.vdot(outer, self.owned[:, :3] - old[:, :3])
