# SPDX-License-Identifier: LGPL-3.0-or-later
"""Explicit Newmark steps, beta = 0, gamma = 1/2: Sec. 3.1.3 of the paper, Eq. 13.

Explicit (beta = 0, gamma = 1/2): lumped mass, central differences with velocities at half steps,

    v(n+1/2) = v(n-1/2) + dt M^-1 (f_ext - f_int(x_n)),   x(n+1) = x(n) + dt v(n+1/2),

which is Newmark's method written without accelerations. Hooks (contact) see the free velocities
between the two lines and correct them in place.

Damping, both off by default: `damping` [s] adds to the stress that of the strains' rates times this
time, which takes energy from every change of strain and leaves rigid motion alone, under whatever
stress (forces taken at x + damping v would feed on a buckling sheet); `drag` [1/s] slows all motion
as still air does.
"""

import numpy as np

from shellform.errors import Unstable
from shellform.fem.dolfinx_compat import Function
from shellform.fem.internal_force import InternalForce
from shellform.fem.lumped_mass import ROTARY_SCALE

from . import explicit_kernels
from .explicit_supports import conditions, follow
from .stable_step import stable_step
from .step_retry import Rewind
from .time_stepper import Stepper, check_time

WORKS = ("internal", "external", "drag", "support", "damping")


class Newmark(Stepper):
    """Explicit steps of a shell.

    Parameters
    ----------
    shell, hooks, rotary_scale, prefix : see Stepper
    time_step_factor : float, of the largest stable step
    damping : float [s]; drag : float [1/s]

    Attributes
    ----------
    v, q : velocities at the last half step
    pulls : list of callables (stepper, force), run at every kick and whenever velocities are asked
        for, with positions and `time` of the kick: they add forces that depend on them to `force`
        (n_owned, 3) [N] and change nothing else. Booked as external.
    work : dict of sums [J] on this rank to the last half step: internal, external, drag (lost),
        support, damping (lost, see `balance`)
    external_total, support_total, drag_total : (3,) float, impulses of loads, supports and drag on
        the owned nodes so far [N s]
    works (5,), totals (3, 3) : the memory of `work` and of the three impulses
    r : (n_owned, 6), internal forces of the last kick [N, N m]
    critical_dt, last_dt : float [s], largest stable step when last looked at; the last step taken
    rewind : Rewind, which cuts back steps that diverge in `advance`
    held : (n_owned, 4) bool, u_x, u_y, u_z and the whole director
    plane : (n_owned, 3), normal a director may not turn towards, zero where none
    """

    recheck = 500  # steps between looks at the stable step and at the energy
    watch = 50  # steps between questions among ranks whether all are finite

    def __init__(
        self,
        shell,
        time_step_factor=0.9,
        hooks=(),
        damping=0.0,
        drag=0.0,
        rotary_scale=ROTARY_SCALE,
        prefix="shell_",
    ):
        check_settings(time_step_factor, damping, drag)
        super().__init__(shell, hooks, rotary_scale, prefix)
        self._field = shell.w if not damping else Function(shell.space)
        self._ahead = self._field.x.array.reshape(-1, 6)
        self._set_supports()
        internal = InternalForce(shell, damped=damping > 0)
        self._start(internal, time_step_factor, damping, drag)

    def _start(self, internal, time_step_factor, damping, drag):
        """Take over the source of internal forces, set books to zero, find the step."""
        n, loads = self.n_owned, self.shell.loads
        self.internal, self.factor = internal, time_step_factor
        self.damping, self.drag = damping, drag
        self.force, self.support_impulse = np.zeros((n, 3)), np.zeros((n, 3))
        self._steady, self.pulls, self._pulled = loads.steady(), [], False
        self._dead = loads.force_at(0.0, self.force, default=1.0).copy()
        self.totals, self.works = np.zeros((3, 3)), np.zeros(5)
        self.external_total, self.support_total, self.drag_total = self.totals
        self.v_old, self._free = self.v.copy(), self.v.copy()
        self.last_dt = self.last_kick = 0.0
        self.fault, self.moved_sum = None, 0.0
        self.rewind = Rewind(self)
        self.critical_dt = self.find_stable_step()
        self.dt = self.factor * self.critical_dt
        # motion far below what any step resolves: energies below this are not judged
        speed = 1e-6 * self.shell.surface.mean_cell_size / self.critical_dt
        self.smallest_energy = 0.5 * self.shell.comm.allreduce(self.mass.sum()) * speed**2

    def _set_supports(self):
        supports = self.shell.supports
        self.held, self.plane = conditions(supports, self.n_owned, self.shell.comm)
        self._moving = bool(supports.motions)

    @property
    def work(self):
        return dict(zip(WORKS, self.works.tolist(), strict=True))

    def advance(self, until):
        """Step until a time [s] is reached exactly; steps that diverge are cut back.

        Raises
        ------
        Unstable, on all ranks, when smaller steps diverge too; the last good state is restored
        ValueError for a time that is not finite
        """
        check_time(until)
        if until <= self.time:
            return
        self.rewind.begin((until - self.time) / self.dt)
        while self.time < until:
            try:
                super().advance(until)
                self.rewind.end()
            except Unstable as fault:
                self.rewind.back(fault)

    def step(self, dt):
        """One step of length dt [s]."""
        np.copyto(self.v_old, self.v)
        self._next, length = dt, 0.5 * (self.last_dt + dt)
        self.kick(length)
        for hook in self.hooks:
            try:
                hook(self, dt)
            except FloatingPointError as fault:
                self.fault = str(fault)  # other ranks learn of it at the next `check`
        self._book(length)
        self.last_kick = length
        self.moved_sum = explicit_kernels.drift(self.owned, self.v, self.q, dt)
        self.scatter()
        self.last_dt, self.time, self.steps = dt, self.time + dt, self.steps + 1
        if self.steps % self.recheck == 0:
            self.check()
            self.rewind.look()
            self.check_step()
            self.rewind.keep()
        elif self.shell.comm.size == 1:
            if self.fault or not np.isfinite(self.moved_sum):
                self.check()
        elif self.steps % self.watch == 0:
            self.check()

    def check(self):
        """Raise Unstable on all ranks if one has left the finite numbers; all ranks call."""
        fault, self.fault = self.fault, None
        self.check_finite(self.moved_sum, self.last_dt, fault)

    def check_step(self):
        """Follow the stable step as the sheet deforms: down at once, up by a tenth at most."""
        self.critical_dt = self.find_stable_step(iterations=12)
        self.dt = min(self.rewind.cut * self.factor * self.critical_dt, 1.1 * self.dt)

    def kick(self, dt):
        """Velocities over dt by the forces at the present configuration, then the supports."""
        r = self.internal_force()
        self.works[4] += self._damping_loss(dt)
        turning = self._add_moments(r, self.q)
        self._update_loads()
        self.r = r
        self._kick(self.v, self.q, r, dt, self.support_impulse, self.works)
        if turning:
            _book_moments(*turning, self.q, dt, self.works)
        np.copyto(self._free, self.v)
        if self._moving:
            self._follow(self._next, dt)

    def _kick(self, v, q, r, dt, impulse, work):
        explicit_kernels.kick(
            v, q, r, self.force, self.owned[:, 3:], self.held, self.plane, self.mass,
            self.inertia, self.drag, dt, impulse, work,
        )  # fmt: skip

    def _book(self, dt):
        explicit_kernels.book(
            self.v_old, self._free, self.v, self.r, self.force, self.held, self.mass, self.drag,
            dt, self.support_impulse, self.works, self.totals,
        )  # fmt: skip

    def _damping_loss(self, dt):
        """What damping takes in a kick of length dt [J], with what the kick before left to book.

        The damping force R v works with the mean of v before the kick and after it, w:
        v R (v + w)/2 = 3/4 v R v + 1/4 w R w - (w - v) R (w - v)/4. The last part is left out: of
        second order, but for impacts, where the loss is booked too high by as much.
        """
        if not self.damping:
            return 0.0
        return self.internal.loss / self.damping * (0.25 * self.last_kick + 0.75 * dt)

    def _follow(self, dt, kicked):
        follow(self, dt, kicked)

    def _update_loads(self):
        if not self._steady:
            self.force[:] = 0.0
            self.shell.loads.force_at(self.time, self.force, default=1.0)
        elif self.pulls or self._pulled:
            np.copyto(self.force, self._dead)
        for pull in self.pulls:
            pull(self, self.force)
        self._pulled = bool(self.pulls)

    def internal_force(self):
        """Internal forces (n_owned, 6) [N, N m] at present, damped, less those of pressure."""
        if self.damping:
            explicit_kernels.ahead(
                self.owned, self.v, self.q, self.damping, self._ahead[: self.n_owned]
            )
            self.scatter(self._field)
        loads = self.shell.loads
        pressure = loads.pressure_at(self.time, 1.0) if loads.pressures else 0.0
        return self.internal(self.w, pressure, self._ahead)[: self.n_owned]

    def _add_moments(self, r, q):
        """Take moments, fixed in space, off the internal forces r; what `_book_moments` needs."""
        loads = self.shell.loads
        if not loads.moments:
            return None
        nodes, moments = loads.moment_at(self.time, 1.0)
        push = np.cross(moments, self.owned[nodes, 3:])
        r[nodes, 3:] -= push
        push[self.held[nodes, 3]] = 0.0
        return nodes, push, q[nodes]

    def velocities(self):
        """Velocities (n, 3) of nodes and directors brought from the half step to the present."""
        v, q, _ = self._present()
        return v, q

    def _present(self):
        """Velocities and works (5,) at the present time: half a kick further."""
        v, q, works = self.v.copy(), self.q.copy(), self.works.copy()
        r = self.internal_force()
        impulse, dt = np.empty_like(v), 0.5 * self.last_dt
        works[4] += self._damping_loss(dt)
        turning = self._add_moments(r, q)
        self._update_loads()
        self._kick(v, q, r, dt, impulse, works)
        if turning:
            _book_moments(*turning, q, dt, works)
        explicit_kernels.book(
            self.v, v, v, r, self.force, self.held, self.mass, self.drag, dt, impulse, works,
            np.zeros((3, 3)),
        )  # fmt: skip
        return v, q, works

    def balance(self):
        """See Stepper; internal: the work of internal forces on nodes and directors.

        Damping is booked kick by kick, see `_damping_loss`.
        """
        v, q, works = self._present()
        comm, owned = self.shell.comm, self.owned
        moving = np.empty(7)
        explicit_kernels.momenta(owned, self.points, v, q, self.mass, self.inertia, moving)
        sums = comm.allreduce(np.array([*works, moving[6]]))
        now = dict(zip((*WORKS, "kinetic"), sums.tolist(), strict=True))
        now["strain"] = sum(self.strain_energy().values())
        return now

    def find_stable_step(self, iterations=30):
        """Largest stable step [s] at the present configuration, see stable_step.py."""
        try:
            return stable_step(self, iterations)
        except ArithmeticError:
            raise Unstable(
                f"the stiffness of {self.shell.surface.source} has no positive eigenvalue"
            ) from None


def _book_moments(nodes, push, old, q, dt, works):
    """Take the work of moments on directors (push, force-like (k, 3)) off that of the sheet."""
    work = 0.5 * dt * np.vdot(push, old + q[nodes])
    works[0] -= work
    works[1] += work


def check_settings(time_step_factor, damping, drag):
    """ValueError for a step beyond the stable one or a negative damping."""
    if not 0 < time_step_factor <= 1:
        raise ValueError(
            f"an explicit step is a part of the largest stable one, 0 to 1, not "
            f"{time_step_factor} of it"
        )
    for name, value in (("damping", damping), ("drag", drag)):
        if not 0 <= value < np.inf:
            raise ValueError(f"{name} is a finite number, not negative, not {value}")
