# SPDX-License-Identifier: LGPL-3.0-or-later
"""Implicit Newmark steps, beta > 0, by SNES: Sec. 3.1.3 of the paper, Eq. 13.

With the constant lumped mass m and rotary inertia I of inertia.py, nodes move in space,

    u(n+1) = u + dt v + dt^2 ((1/2 - beta) a + beta a(n+1)),
    v(n+1) = v + dt ((1 - gamma) a + gamma a(n+1)),     m a = f_ext - f_int,

and directors by the same formulas on the unit sphere: the turn theta takes the place of the
displacement and lies in the plane tangent to the director it starts from, d(n+1) = exp(theta) d.
Director velocity q and acceleration are carried parallel along that arc to the new tangent plane.
The length of a director is kept by construction, so no part of Newmark's formulas acts normal to
the sphere, where it would ring.

Velocities are advanced by nodal forces and not by differences of positions: internal forces sum to
nothing, so linear momentum is that of the loads to roundoff, whatever Newton's tolerance.

(1/4, 1/2) is the average acceleration, of second order without damping. In free flight angular
momentum and energy then swing by O(dt^2); energy is bound to stay only where steps resolve what
moves: stiff modes they do not resolve may feed on a nonlinear motion and grow. gamma > 1/2 damps
them, best with beta = (gamma + 1/2)^2/4, at first order in time.

A step that fails is halved and retried; the step follows the truncation error
(beta - 1/6) dt^2 (a(n+1) - a) and the number of Newton iterations.
"""

from mpi4py import MPI

import numpy as np

from . import director
from .equilibrium import Equilibrium
from .newton import Newton
from .statics import NotConverged
from .stepper import Stepper


class ImplicitNewmark(Stepper):
    """Implicit steps of a shell.

    Parameters
    ----------
    shell, rotary_scale, prefix : see Stepper; the physical rotary inertia by default, as it does
        not bound the step
    dt : float [s], first step and largest
    beta, gamma : float, beta > 0 and gamma >= 1/2; stable on linear problems for
        beta >= (gamma + 1/2)^2/4; None takes that value
    tolerance : float [m], truncation error allowed a step; None: dt changes with failures and
        Newton iterations only
    hooks : callables (stepper, dt), run after each step that has been solved, with positions,
        velocities and `time` at its end. They may look at everything and change `v` and `q` of
        free nodes (an impulse), not positions. Contact by touch.Touch corrects velocities before
        the nodes move: it is for explicit steps only.

    Attributes
    ----------
    v, q : (n_owned, 3), velocities of nodes [m/s] and directors [1/s] at `time`; may be set before
        the first step
    a : (n_owned, 6) or None, accelerations of free nodes [m/s^2] and along the sphere of directors
        [1/s^2]; set it to None after a jump of the loads or a change of positions
    newton_iterations, cutbacks : int, totals

    Raises
    ------
    ValueError for a step, beta or gamma out of range, or a prescribed motion without time
    """

    smallest = 1e-6  # part of the largest step below which a step has failed for good

    def __init__(
        self,
        shell,
        dt,
        beta=None,
        gamma=0.5,
        tolerance=None,
        hooks=(),
        rotary_scale=0.0,
        prefix="shell_",
    ):
        if beta is None:
            beta = 0.25 * (gamma + 0.5) ** 2
        if not beta > 0 or not gamma >= 0.5:
            raise ValueError(
                f"implicit steps need beta > 0 and gamma >= 1/2, not {beta} and {gamma}; "
                "beta = 0 is newmark.Newmark"
            )
        if not 0 < dt < np.inf:
            raise ValueError(f"a time step is a positive number of seconds, not {dt}")
        if tolerance is not None and not tolerance > 0:
            raise ValueError(f"a truncation error is a positive length in m, not {tolerance}")
        if shell.supports.steady_goals():
            raise ValueError("in dynamics a prescribed displacement is a function of time")
        self.equilibrium = _Inertial(shell)
        super().__init__(shell, hooks, rotary_scale, prefix)
        self.equilibrium.load_factor = 1.0
        self.newton = Newton(self.equilibrium, prefix)
        self.beta, self.gamma, self.tolerance = beta, gamma, tolerance
        self.dt = self.largest_dt = dt
        self._mass6 = np.repeat(np.column_stack([self.mass, self.inertia]), 3, axis=1)
        self.a = None
        self.newton_iterations = self.cutbacks = 0

    def velocities(self):
        """Velocities (n_owned, 3) of nodes [m/s] and directors [1/s] at the present time."""
        return self.v.copy(), self.q.copy()

    def step(self, dt):
        """One step of length dt [s], in parts if it must be cut back.

        Raises
        ------
        NotConverged when the smallest part fails too; the shell keeps the state at `time`
        """
        end, part, rest = self.time + dt, dt, dt
        while rest > 1e-9 * dt:
            if self._try(part):
                rest -= part
                part = min(max(part, self.dt), rest)
                continue
            self.cutbacks += 1
            part *= 0.5
            self.dt = min(self.dt, part)
            if part < self.smallest * self.largest_dt:
                raise NotConverged(
                    f"no step of {part:.3g} s from t = {self.time:.6g} s: SNES says "
                    f"{self.newton.reason}. The state at that time is kept"
                )
        self.time = end

    def _try(self, dt):
        """Step over dt [s]; False with the state restored if that fails."""
        if self.a is None:
            self.q -= _along(self.q, self.owned[:, 3:])
            self.a = self._acceleration()
        eq, state, old = self.equilibrium, self.equilibrium.state(), self.owned.copy()
        self._predict(old, dt)
        done = self.newton.solve(self.time + dt)
        if done is None:
            eq.restore(state)
            return False
        before, a = self.a, self._acceleration()
        change = np.abs(a[:, :3] - before[:, :3]).max(initial=0.0)
        error = abs(self.beta - 1 / 6) * dt**2 * self.shell.comm.allreduce(change, MPI.MAX)
        # steps that shrink for an error alone stop at a thousandth: that is not a failure
        if self.tolerance and error > 4 * self.tolerance and dt > 1e-3 * self.largest_dt:
            eq.restore(state)
            return False
        self._finish(old, a, dt)
        self.newton_iterations += done.iterations
        self.time, self.steps = self.time + dt, self.steps + 1
        for hook in self.hooks:
            hook(self, dt)
        self.check_finite(self.owned.sum() + self.v.sum() + self.q.sum(), dt)
        self._choose_step(dt, error, done.iterations)
        return True

    def _predict(self, old, dt):
        """Hand equilibrium the inertia of a step over dt [s] from the field `old` (n_owned, 6)."""
        part = dt**2 * (0.5 - self.beta) * self.a
        eq = self.equilibrium
        eq.start_d = old[:, 3:]
        eq.ahead_u = old[:, :3] + dt * self.v + part[:, :3]
        eq.ahead_d = dt * self.q + part[:, 3:]
        eq.factor = self._mass6 / (self.beta * dt**2)
        eq.predict()

    def _finish(self, old, a, dt):
        """Velocities at the end of a solved step from accelerations a (n_owned, 6) there."""
        velocity = np.hstack([self.v, self.q]) + dt * (1 - self.gamma) * self.a
        start, end = old[:, 3:], self.owned[:, 3:]
        velocity[:, 3:] = _carry(velocity[:, 3:], start, end)
        velocity += dt * self.gamma * a
        velocity = self.equilibrium.free_part(velocity)
        self.v[:], self.q[:], self.a = velocity[:, :3], velocity[:, 3:], a
        if self.equilibrium.has_goal:
            self._follow(self.time + dt, 1e-3 * dt)

    def _follow(self, time, h):
        """Velocities of nodes of prescribed motion: one-sided differences of second order over h.

        Newmark's formula would give them a velocity that rings about the true one.
        """
        places = [self.shell.supports.prescribed(time - k * h) for k in range(3)]
        for (local, u, d), (_, u1, d1), (_, u2, d2) in zip(*places, strict=True):
            mine = local < self.n_owned
            nodes = local[mine]
            if u is not None:
                self.v[nodes] = ((3 * u - 4 * u1 + u2) / (2 * h))[mine]
            if d is not None:
                turn = ((3 * d - 4 * d1 + d2) / (2 * h))[mine]
                self.q[nodes] = turn - _along(turn, self.owned[nodes, 3:])

    def _choose_step(self, dt, error, iterations):
        growth = 1.5 if iterations <= 8 else 0.7
        if self.tolerance is not None:
            growth = min(growth, max(0.3, 0.9 * (self.tolerance / max(error, 1e-300)) ** (1 / 3)))
        self.dt = min(self.largest_dt, growth * dt)

    def _acceleration(self):
        """Accelerations (n_owned, 6) of the present state, zero along held unknowns."""
        eq = self.equilibrium
        if self.a is None:
            eq.adopt()
            eq.level = self.time
        eq.inertia = eq.factor = None
        return eq.free_part(-eq.forces() / self._mass6)

    def destroy(self):
        """Free PETSc's objects; the shell keeps its state."""
        if self.newton is not None:
            self.newton.destroy()
            self.equilibrium.destroy()
            self.newton = None


class _Inertial(Equilibrium):
    """Equilibrium with the inertia of a step whose directors move along great circles.

    Attributes
    ----------
    factor : (n_owned, 6) or None, inertia over beta dt^2
    start_d : (n_owned, 3), directors at the start of the step
    ahead_u, ahead_d : (n_owned, 3), predicted displacement [m] and predicted turn [rad], a vector
        tangent to start_d
    """

    factor = None

    def configure(self, x):
        """Set w and the frames from the unknowns, and where inertia would have them."""
        super().configure(x)
        if self.factor is not None:
            self.predict()

    def predict(self):
        """Put the field that inertia pulls the present one to into `inertia`."""
        d = self._w()[: self.n_owned, 3:]
        pull = _carry(_turn(self.start_d, d) - self.ahead_d, self.start_d, d)
        self.inertia = (self.factor, np.hstack([self.ahead_u, d - pull]))

    def free_part(self, rates):
        """Of rates (n_owned, 6) of w, the part along the unknowns that are not held."""
        T = self.T[: self.n_owned]
        rates = director.pull_back(rates, T, self._Q_owned)
        rates[self.held[: self.n_owned]] = 0.0
        return director.push_forward(rates, T, self._Q_owned)


def _along(vectors, d):
    """Part of vectors (n, 3) along unit vectors d (n, 3)."""
    return np.sum(vectors * d, axis=1, keepdims=True) * d


def _turn(start, end):
    """Turns (n, 3) [rad], tangent to `start`, that lead along great circles to `end`."""
    across = end - _along(end, start)
    sine = np.linalg.norm(across, axis=1, keepdims=True)
    angle = np.arctan2(sine, np.sum(start * end, axis=1, keepdims=True))
    return across * np.where(sine > 0, angle / np.where(sine > 0, sine, 1.0), 1.0)


def _carry(vectors, start, end):
    """Vectors (n, 3) tangent to `start`, carried parallel along the great circle to `end`."""
    both = start + end
    return vectors - np.sum(vectors * end, axis=1, keepdims=True) * both / (
        1 + np.sum(start * end, axis=1, keepdims=True)
    )
