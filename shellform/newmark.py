# SPDX-License-Identifier: LGPL-3.0-or-later
"""Explicit Newmark steps, beta = 0, gamma = 1/2: Sec. 3.1.3 of the paper, Eq. 13.

Explicit (beta = 0, gamma = 1/2): lumped mass, central differences with velocities at half steps,

    v(n+1/2) = v(n-1/2) + dt M^-1 (f_ext - f_int(x_n)),   x(n+1) = x(n) + dt v(n+1/2),

which is Newmark's method written without accelerations. Hooks (contact) see the free velocities
between the two lines and correct them in place.

Damping, both off by default: `damping` [s] takes the internal force at x + damping v, a force
proportional to the rate of strain that leaves every translation undamped; `drag` [1/s] slows all
motion as still air does.
"""

from mpi4py import MPI

import numpy as np

from dolfinx import fem

from . import explicit
from .director import logarithmic_map, tangent_frames
from .inertia import ROTARY_SCALE
from .internal_force import InternalForce
from .stepper import Stepper, Unstable


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
    work : dict of sums [J]: internal, external, drag (lost), support
    external_total, support_total, drag_total : (3,) float, impulses of loads, supports and drag on
        the owned nodes so far [N s]
    critical_dt, last_dt : float [s], largest stable step when last looked at; the last step taken
    """

    recheck = 500  # steps between looks at the stable step

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
        self._field = shell.w if not damping else fem.Function(shell.space)
        self._ahead = self._field.x.array.reshape(-1, 6)
        self._set_supports()
        self._start(InternalForce(shell), time_step_factor, damping, drag)

    def _start(self, internal, time_step_factor, damping, drag):
        """Take over the source of internal forces, set books to zero, find the step."""
        n, loads = self.n_owned, self.shell.loads
        self.internal, self.factor = internal, time_step_factor
        self.damping, self.drag = damping, drag
        self.force, self.support_impulse = np.zeros((n, 3)), np.zeros((n, 3))
        self._steady = loads.steady()
        loads.force_at(0.0, self.force, default=1.0)
        self.support_total, self.external_total = np.zeros(3), np.zeros(3)
        self.drag_total = np.zeros(3)
        self.last_dt = 0.0
        self.work = dict.fromkeys(("internal", "external", "drag", "support"), 0.0)
        self._cell = self.shell.surface.mean_cell_size
        self.critical_dt = self.find_stable_step()
        self.dt = self.factor * self.critical_dt

    def _set_supports(self):
        supports, n = self.shell.supports, self.n_owned
        if self.shell.comm.allreduce(bool(supports.inclined.any()), op=MPI.LOR):
            raise ValueError("explicit steps hold displacements along x, y, z only")
        if supports.steady_goals():
            raise ValueError("in dynamics a prescribed displacement is a function of time")
        self._moving = bool(supports.motions)
        held = supports.held[:n]
        plane = np.nan_to_num(supports.plane[:n])
        self._held = np.column_stack([held[:, :3], held[:, 3] & held[:, 4]])
        self._plane = np.where(held[:, 4:] & ~held[:, 3:4], plane, 0.0)
        self._supported = bool(self._held.any() or self._plane.any())

    def step(self, dt):
        """One step of length dt [s]."""
        if self.v_old is not None:
            np.copyto(self.v_old, self.v)
        self._next = dt
        self.kick(0.5 * (self.last_dt + dt))
        for hook in self.hooks:
            hook(self, dt)
        total = explicit.drift(self.owned, self.v, self.q, dt)
        self.scatter()
        self.last_dt, self.time, self.steps = dt, self.time + dt, self.steps + 1
        self.check_finite(total, dt)
        if self.steps % self.recheck == 0:
            self.check_step()

    def check_step(self):
        """Follow the stable step as the sheet deforms: down at once, up by a tenth at most."""
        self.critical_dt = self.find_stable_step(iterations=12)
        self.dt = min(self.factor * self.critical_dt, 1.1 * self.dt)

    def kick(self, dt):
        """Velocities over dt by the forces at the present configuration, then the supports."""
        r = self.internal_force()
        self._update_loads()
        inner, outer, lost = self._kick(self.v, self.q, r, dt, self.support_impulse)
        self.work["internal"] += inner
        self.work["external"] += outer
        self.work["drag"] += lost
        self.external_total += dt * self.force.sum(axis=0)
        if self._moving:
            self._follow(self._next)
        if self._supported:
            self.support_total += self.support_impulse.sum(axis=0)

    def _kick(self, v, q, r, dt, impulse, slowed=None):
        return explicit.kick(
            v, q, r, self.force, self.owned[:, 3:], self._held, self._plane, self.mass,
            self.inertia, self.drag, dt, impulse, self.drag_total if slowed is None else slowed,
        )  # fmt: skip

    def _follow(self, dt):
        """Velocities that bring nodes of prescribed motion where they are due after dt."""
        for local, u, d in self.shell.supports.prescribed(self.time + dt):
            mine = local < self.n_owned
            nodes = local[mine]
            if u is not None:
                old = self.v[nodes].copy()
                self.v[nodes] = (u[mine] - self.owned[nodes, :3]) / dt
                push = self.support_impulse[nodes] + self.mass[nodes, None] * (self.v[nodes] - old)
                self.support_impulse[nodes] = push
                self.work["support"] += 0.5 * np.vdot(push, self.v[nodes] + old)
            if d is not None:
                now = self.owned[nodes, 3:]
                T = tangent_frames(now)
                turn = logarithmic_map(now, T, d[mine])
                self.q[nodes] = np.einsum("nij,nj->ni", T, turn) / dt

    def _update_loads(self):
        if not self._steady:
            self.force[:] = 0.0
            self.shell.loads.force_at(self.time, self.force, default=1.0)

    def internal_force(self):
        """Internal forces (n_owned, 6) [N, N m], damped, less pressure and moments, at present."""
        if self.damping:
            explicit.ahead(self.owned, self.v, self.q, self.damping, self._ahead[: self.n_owned])
            self.scatter(self._field)
        loads = self.shell.loads
        pressure = loads.pressure_at(self.time, 1.0) if loads.pressures else 0.0
        r = self.internal(self._ahead, pressure)[: self.n_owned]
        if loads.moments:
            nodes, moments = loads.moment_at(self.time, 1.0)
            r[nodes, 3:] -= np.cross(moments, self.owned[nodes, 3:])
        return r

    def velocities(self):
        """Velocities (n, 3) of nodes and directors brought from the half step to the present."""
        v, q = self.v.copy(), self.q.copy()
        r = self.internal_force()
        self._update_loads()
        self._kick(v, q, r, 0.5 * self.last_dt, np.empty_like(v), np.zeros(3))
        return v, q

    def find_stable_step(self, iterations=30):
        """Largest stable step [s] at the present configuration, 2/omega_max with 3 % to spare.

        omega_max is the largest Ritz value of a Lanczos run on M^-1 K; products with K are
        differences of internal forces, so no matrix is made.
        """
        comm, n = self.shell.comm, self.n_owned
        scale = np.concatenate(
            [np.tile(self.mass[:, None], 3), np.tile(self.inertia[:, None], 3)], 1
        )
        root = np.sqrt(scale)
        base, d = self.owned.copy(), self.owned[:, 3:].copy()
        r = self.internal(self.w)[:n].copy()
        pull = np.sum(r[:, 3:] * d, axis=1, keepdims=True)

        def admissible(y):
            y[:, :3][self._held[:, :3]] = 0.0
            y[:, 3:][self._held[:, 3]] = 0.0
            y[:, 3:] -= np.sum(y[:, 3:] * d, axis=1, keepdims=True) * d
            y[:, 3:] -= np.sum(y[:, 3:] * self._plane, axis=1, keepdims=True) * self._plane
            return y

        def dot(a, b):
            return comm.allreduce(float(np.vdot(a, b)))

        def product(y):
            y = y / root
            size = comm.allreduce(
                max(np.abs(y[:, :3]).max() / self._cell, np.abs(y[:, 3:]).max()), MPI.MAX
            )
            h = 1e-6 / size
            sides = []
            for sign in (1, -1):
                self.owned[:] = base + sign * h * y
                self.scatter()
                sides.append(self.internal(self.w)[:n].copy())
            z = (sides[0] - sides[1]) / (2 * h)
            z[:, 3:] -= pull * y[:, 3:]
            return admissible(z) / root

        # the same start on any number of ranks
        whole = np.random.default_rng(0).standard_normal((len(self.shell.surface.points), 6))
        y = admissible(whole[self.shell.partition.owned_nodes])
        y /= np.sqrt(dot(y, y))
        previous, beta, alphas, betas = np.zeros_like(y), 0.0, [], []
        for _ in range(iterations):
            z = product(y) - beta * previous
            alphas.append(dot(y, z))
            z -= alphas[-1] * y
            beta = np.sqrt(dot(z, z))
            if beta <= 1e-12 * abs(alphas[0]):
                break
            betas.append(beta)
            previous, y = y, z / beta
        self.owned[:] = base
        self.scatter()
        k = len(alphas)
        values = np.linalg.eigvalsh(
            np.diag(alphas) + np.diag(betas[: k - 1], 1) + np.diag(betas[: k - 1], -1)
        )
        if not values[-1] > 0:
            raise Unstable(
                f"the stiffness of {self.shell.surface.source} has no positive eigenvalue"
            )
        tau = self.damping
        return 0.97 * float(np.sqrt(tau**2 + 4 / values[-1]) - tau)


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
