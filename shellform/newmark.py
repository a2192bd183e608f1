# SPDX-License-Identifier: LGPL-3.0-or-later
"""Newmark's method in time, driven by PETSc TS: Sec. 3.1.3 of the paper, Eq. 13.

Explicit (beta = 0, gamma = 1/2): lumped mass, central differences with velocities at half steps,

    v(n+1/2) = v(n-1/2) + dt M^-1 (f_ext - f_int(x_n)),   x(n+1) = x(n) + dt v(n+1/2),

which is Newmark's method written without accelerations. Hooks (contact) see the free velocities
between the two lines and correct them in place.

Damping, both off by default: `damping` [s] takes the internal force at x + damping v, a force
proportional to the rate of strain that leaves every translation undamped; `drag` [1/s] slows all
motion as still air does.

The TS is of Python type, so -shell_ts_monitor, -shell_ts_max_steps, ... act. Its vector is the
nodal field w, brought up to date at the end of each `advance`.
"""

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np

from . import explicit
from .inertia import ROTARY_SCALE, lumped
from .internal_force import InternalForce


class Unstable(RuntimeError):
    """A step produced numbers that are not finite, or energy from nothing."""


class Newmark:
    """Explicit steps of a shell.

    Parameters
    ----------
    shell : Shell, with supports and loads complete; starts from its present state
    time_step_factor : float, of the largest stable step
    hooks : callables (newmark, dt), run with the free half-step velocities in `v`
    damping : float [s]; drag : float [1/s]
    rotary_scale : float, see inertia.py
    prefix : str, of the TS options

    Attributes
    ----------
    w : (n_local, 6), (u, d) with ghosts; v, q : (n_owned, 3), half-step velocities of nodes [m/s]
        and directors [1/s]
    mass, inertia : (n_owned,); points : (n_owned, 3) reference positions [m]
    time, dt : float [s]; steps : int
    work : dict of sums [J]: internal, external, drag, and those the hooks add
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
        self.shell, self.hooks = shell, list(hooks)
        self.damping, self.drag, self.factor = damping, drag, time_step_factor
        partition, n = shell.partition, shell.partition.n_owned
        self.n_owned = n
        self.w = shell.w.x.array.reshape(-1, 6)
        self._owned = self.w[:n]
        self._ahead = self.w if not damping else self.w.copy()
        self.points = partition.surface.points[partition.owned_nodes]
        mass, inertia = lumped(shell.surface, shell.fabric, rotary_scale)
        self.mass, self.inertia = mass[partition.owned_nodes], inertia[partition.owned_nodes]
        self.v, self.q = np.zeros((n, 3)), np.zeros((n, 3))
        self.internal = InternalForce(shell)
        self.force = np.zeros((n, 3))
        self._steady = shell.loads.steady()
        shell.loads.force_at(0.0, self.force, default=1.0)
        self._set_supports()
        self.support_impulse = np.zeros((n, 3))
        self.time, self.steps, self._last_dt = 0.0, 0, 0.0
        self.work = {"internal": 0.0, "external": 0.0, "drag": 0.0}
        self._cell = shell.surface.mean_cell_size
        self.critical_dt = self.find_stable_step()
        self.dt = self.factor * self.critical_dt
        self._create_ts(prefix)

    def _set_supports(self):
        supports, n = self.shell.supports, self.n_owned
        if supports.inclined.any():
            raise ValueError("explicit steps hold displacements along x, y, z only")
        held = supports.held[:n]
        plane = np.nan_to_num(supports.plane[:n])
        self._held = np.column_stack([held[:, :3], held[:, 3] & held[:, 4]])
        self._plane = np.where(held[:, 4:] & ~held[:, 3:4], plane, 0.0)
        self._supported = bool(self._held.any() or self._plane.any())

    def _create_ts(self, prefix):
        self.ts = PETSc.TS().create(self.shell.comm)
        self.ts.setOptionsPrefix(prefix)
        self.ts.setType(PETSc.TS.Type.PYTHON)
        self.ts.setPythonContext(_Context(self))
        self.ts.setExactFinalTime(PETSc.TS.ExactFinalTime.STEPOVER)
        self.ts.setMaxSteps(2**31 - 1)
        # PETSc copies this vector around every step: it must not be the memory of w
        self._ts_vector = self.shell.w.vector.duplicate()
        self.ts.setSolution(self._ts_vector)
        self.ts.setFromOptions()

    def advance(self, until):
        """Step until a time [s] is reached exactly; the last steps share out the rest evenly."""
        if until <= self.time:
            return
        self._until = until
        self.ts.setTime(self.time)
        self.ts.setStepNumber(0)
        self.ts.setMaxTime(until)
        self.ts.setTimeStep(self._next_dt())
        self.ts.solve(self._ts_vector)
        self.time = until
        self.shell.w.vector.copy(self._ts_vector)

    def _next_dt(self):
        rest = self._until - self.time
        count = max(1, int(np.ceil(rest / self.dt * (1 - 1e-12))))
        return rest / count

    def step(self, dt):
        """One step of length dt [s]."""
        n = self.n_owned
        self.kick(0.5 * (self._last_dt + dt))
        for hook in self.hooks:
            hook(self, dt)
        total = explicit.drift(self._owned, self.v, self.q, dt)
        self._scatter()
        self._last_dt, self.time, self.steps = dt, self.time + dt, self.steps + 1
        if not np.isfinite(total):
            bad = np.flatnonzero(~np.isfinite(self._owned).all(axis=1))[0]
            node = self.shell.partition.nodes[bad]
            raise Unstable(
                f"node {node} of {self.shell.surface.source} has left the finite numbers at "
                f"t = {self.time:.6g} s, step {self.steps} of {dt:.3g} s; take a smaller "
                "time_step_factor"
            )
        return n

    def check_step(self):
        """Follow the stable step as the sheet deforms: down at once, up by a tenth at most."""
        self.critical_dt = self.find_stable_step(iterations=12)
        self.dt = min(self.factor * self.critical_dt, 1.1 * self.dt)

    def kick(self, dt):
        """Velocities over dt by the forces at the present configuration, then the supports."""
        r = self.internal_force()
        if not self._steady:
            self.force[:] = 0.0
            self.shell.loads.force_at(self.time, self.force, default=1.0)
        inner, outer, lost = explicit.kick(
            self.v, self.q, r, self.force, self._owned[:, 3:], self.mass, self.inertia, self.drag, dt
        )  # fmt: skip
        self.work["internal"] += inner
        self.work["external"] += outer
        self.work["drag"] += lost
        if self._supported:
            explicit.support(
                self.v, self.q, self._owned[:, 3:], self._held, self._plane, self.mass,
                self.support_impulse,
            )  # fmt: skip

    def internal_force(self):
        """Internal forces (n_owned, 6) [N, N m], damped, at the present configuration."""
        if self.damping:
            explicit.ahead(self._owned, self.v, self.q, self.damping, self._ahead[: self.n_owned])
            self._scatter(self._ahead)
        return self.internal(self._ahead)[: self.n_owned]

    def synchronise(self):
        """Bring velocities from the half step to the present time, for output (n, 3) each."""
        v, q = self.v.copy(), self.q.copy()
        r = self.internal_force()
        half = 0.5 * self._last_dt
        explicit.kick(
            v, q, r, self.force, self._owned[:, 3:], self.mass, self.inertia, self.drag, half
        )
        if self._supported:
            booked = np.empty_like(v)
            explicit.support(v, q, self._owned[:, 3:], self._held, self._plane, self.mass, booked)
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
        base, d = self._owned.copy(), self._owned[:, 3:].copy()
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
                self._owned[:] = base + sign * h * y
                self._scatter()
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
        self._owned[:] = base
        self._scatter()
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

    def _scatter(self, field=None):
        if self.shell.comm.size > 1:
            if field is None:
                self.shell.w.x.scatter_forward()
            else:
                self.shell.before.x.array[:] = field.ravel()
                self.shell.before.x.scatter_forward()
                field[:] = self.shell.before.x.array.reshape(-1, 6)


class _Context:
    """What PETSc's TS of Python type calls."""

    def __init__(self, newmark):
        self.newmark = newmark

    def solveStep(self, ts, t, u):
        newmark = self.newmark
        newmark.step(ts.getTimeStep())
        if newmark.steps % newmark.recheck == 0:
            newmark.check_step()

    def adaptStep(self, ts, t, u):
        return self.newmark._next_dt(), True
