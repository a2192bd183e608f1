# SPDX-License-Identifier: LGPL-3.0-or-later
"""Implicit Newmark steps, beta > 0, by SNES: Sec. 3.1.3 of the paper, Eq. 13.

With the constant lumped mass m and rotary inertia I of fem/lumped_mass.py, nodes move in space,

    u(n+1) = u + dt v + dt^2 ((1/2 - beta) a + beta a(n+1)),
    v(n+1) = v + dt ((1 - gamma) a + gamma a(n+1)),
    m a(n+1) = (1 + alpha) f(n+1) - alpha f(n),     f = f_ext - f_int,

and directors by the same formulas on the unit sphere: the turn theta takes the place of the
displacement and lies in the plane tangent to the director it starts from, d(n+1) = exp(theta) d.
Director velocity q and acceleration are carried parallel along that arc to the new tangent plane.
The length of a director is kept by construction, so no part of Newmark's formulas acts normal to
the sphere, where it would ring.

Velocities are advanced by nodal forces and not by differences of positions: internal forces sum to
nothing, so linear momentum is that of the loads to roundoff, whatever Newton's tolerance.

alpha = 0 with (1/4, 1/2) is the average acceleration, of second order without damping. In free
flight angular momentum and energy then swing by O(dt^2); energy is bound to stay only where steps
resolve what moves: stiff modes they do not resolve may feed on a nonlinear motion and grow. Two
ways to damp them: gamma > 1/2, best with beta = (gamma + 1/2)^2/4, at first order in time; or
-1/3 <= alpha < 0 with gamma = 1/2 - alpha, beta = (1 - alpha)^2/4, at second order (Hilber, Hughes
and Taylor, Earthq. Eng. Struct. Dyn. 5, 1977).

A step that fails is halved and retried; the step follows the truncation error
(beta - 1/6) dt^2 (a(n+1) - a) and the number of Newton iterations.
"""

from typing import Any

from mpi4py import MPI

import numpy as np

from shellform.errors import NotConverged
from shellform.fem.director import along, carry
from shellform.fem.shell import Shell, require_shell
from shellform.statics.newton import Newton

from .books import BY_LOADS, EXTERNAL
from .implicit_equilibrium import Inertial
from .implicit_supports import book_drag, constrain, slowed
from .time_stepper import Stepper


class ImplicitNewmark(Stepper):
    """Implicit steps of a shell.

    Parameters
    ----------
    shell, rotary_scale, prefix : see Stepper; the physical rotary inertia by default, as it does
        not bound the step
    dt : float [s], first step and largest
    beta, gamma : float, beta > 0 and gamma >= 1/2; stable on linear problems for
        beta >= (gamma + 1/2)^2/4; None takes that value, gamma = 1/2 - alpha
    tolerance : float [m], truncation error allowed a step; None: dt changes with failures and
        Newton iterations only
    alpha : float, -1/3 to 0, damping of the modes that steps do not resolve
    drag : float [1/s], decay of all velocities as in still air, applied before each step

    Parts run after each step that has been solved, with positions, velocities and `time` at its
    end. They may look at everything and change `v` and `q` of free nodes (an impulse), not
    positions.

    Attributes
    ----------
    v, q : (n_owned, 3), velocities of nodes [m/s] and directors [1/s] at `time`; may be set
    a : (n_owned, 6) or None, accelerations by all forces but contact and supports [m/s^2], of
        directors along the sphere [1/s^2]; set it to None after a jump of the loads or a change of
        positions
    newton_iterations, cutbacks : int, totals; solves : int, of which several a step with contact
    books : see books.py; the work of internal forces is not booked

    Raises
    ------
    ValueError for a step, alpha, beta or gamma out of range, or a prescribed motion without time

    Examples
    --------
    >>> import meshes, shellform as sf
    >>> fabric = sf.Fabric.isotropic(1e5, 0.3, 1e-3, 200.0)
    >>> shell = sf.Shell(meshes.rectangle(0.4, 0.4, (4, 4)), fabric)
    >>> shell.loads.gravity()
    >>> stepper = sf.ImplicitNewmark(shell, 5e-3)
    >>> stepper.advance(0.1)
    >>> f"{shell.displacements()[:, 2].mean():.3f} m"
    '-0.049 m'
    """

    implicit = True
    smallest = 1e-6  # part of the largest step below which a step has failed for good
    instant = 1.0  # part of the step at whose end it is solved
    equilibrium_class = Inertial  # what is solved in a step; other contact derives from it

    def __init__(
        self,
        shell: Shell,
        dt: float,
        beta: float | None = None,
        gamma: float | None = None,
        tolerance: float | None = None,
        rotary_scale: float = 0.0,
        prefix: str = "shell_",
        alpha: float = 0.0,
        drag: float = 0.0,
    ) -> None:
        if not -1 / 3 <= alpha <= 0:
            raise ValueError(f"alpha of Hilber, Hughes and Taylor is from -1/3 to 0, not {alpha}")
        gamma = 0.5 - alpha if gamma is None else gamma
        if beta is None:
            beta = 0.25 * (gamma + 0.5) ** 2
        if not beta > 0 or not gamma >= 0.5:
            raise ValueError(
                f"implicit steps need beta > 0 and gamma >= 1/2, not {beta} and {gamma}; "
                "beta = 0 is explicit, Newmark"
            )
        if not 0 < dt < np.inf:
            raise ValueError(f"a time step is a positive number of seconds, not {dt}")
        if tolerance is not None and not tolerance > 0:
            raise ValueError(f"a truncation error is a positive length in m, not {tolerance}")
        if not 0 <= drag < np.inf:
            raise ValueError(f"drag is a finite number, not negative, not {drag}")
        if require_shell(shell, "ImplicitNewmark").supports.steady_goals():
            raise ValueError("in dynamics a prescribed displacement is a function of time")
        self.equilibrium = self.equilibrium_class(shell)
        super().__init__(shell, rotary_scale, prefix)
        self.equilibrium.load_factor = 1.0
        self.newton = Newton(self.equilibrium, prefix)
        self.beta, self.gamma, self.alpha, self.drag = beta, gamma, alpha, drag
        self.tolerance = tolerance
        self.dt = self.largest_dt = dt
        self._mass6 = np.repeat(np.column_stack([self.mass, self.inertia]), 3, axis=1)
        self.a: np.ndarray | None = None
        self._destroyed = False
        self.newton_iterations = self.cutbacks = self.solves = 0

    @property
    def held(self) -> np.ndarray:
        """Held displacements and wholly held directors (n_owned, 4), bool."""
        held = self.shell.supports.held[: self.n_owned]
        return np.column_stack([held[:, :3], held[:, 3] & held[:, 4]])

    def check_step(self) -> None:
        """Take over positions, velocities and time set from outside (mass_spring.hand_over)."""
        self.a = None

    def describe(self) -> dict[str, Any]:
        """See Stepper."""
        plan = super().describe()
        plan["terms"] += ["drag"] if self.drag else []
        return plan

    def velocities(self) -> tuple[np.ndarray, np.ndarray]:
        """Velocities (n_owned, 3) of nodes [m/s] and directors [1/s] at the present time."""
        return self.v.copy(), self.q.copy()

    def step(self, dt: float) -> None:
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
            self._begin()
        eq, state, old = self.equilibrium, self.equilibrium.state(), self.owned.copy()
        self._predict(old, dt)
        done = self._solve(dt)
        if done is None:
            eq.restore(state)
            return False
        force, outer = self._accelerations(self.time + self.instant * dt)
        change = np.abs(force[:, :3] - self._force[:, :3]).max(initial=0.0)
        error = abs(self.beta - 1 / 6) * dt**2 * self.shell.comm.allreduce(change, MPI.MAX)
        # steps that shrink for an error alone stop at a thousandth: that is not a failure
        if self.tolerance and error > 4 * self.tolerance and dt > 1e-3 * self.largest_dt:
            eq.restore(state)
            return False
        self._finish(old, force, outer, dt)
        self.shell.keep_slips()
        self.newton_iterations += done[0]
        self.clock.time, self.clock.steps = self.time + dt, self.steps + 1
        for part in self.parts:
            part(self, dt)
        self.check_finite(self.owned.sum() + self.v.sum() + self.q.sum(), dt)
        self._choose_step(dt, error, done[1])
        return True

    def _begin(self):
        """Forces of a state set from outside, directors' velocities along the sphere."""
        self.equilibrium.adopt()
        self.q -= along(self.q, self.owned[:, 3:])
        self._force, self._outer = self._accelerations(self.time)
        self.a, self._mean_outer = self._force.copy(), self._outer.copy()
        self._pushed = np.zeros((self.n_owned, 3))

    def _predict(self, old, dt):
        """Hand equilibrium the inertia of a step over dt [s] from the field `old` (n_owned, 6)."""
        eq = self.equilibrium
        ahead = (0.5 - self.beta) * self.a - self.alpha * self.beta * self._force
        ahead[:, :3] += (0.5 - self.beta) * self._pushed
        ahead = dt**2 * eq.free_part(ahead)
        eq.start_d = old[:, 3:]
        velocity = slowed(self, dt)
        eq.ahead_u = old[:, :3] + dt * velocity[:, :3] + ahead[:, :3]
        eq.ahead_d = dt * velocity[:, 3:] + ahead[:, 3:]
        eq.factor = self._mass6 / ((1 + self.alpha) * self.beta * dt**2)
        eq.predict()

    def _solve(self, dt):
        """Newton iterations of a step, in all and in the hardest solve; None if it fails."""
        if self.contact is None:
            self.solves += 1
            done = self.newton.solve(self.time + self.instant * dt)
            return None if done is None else (done.iterations, done.iterations)
        return self.contact.solve(self, dt)

    def _finish(self, old, force, outer, dt):
        """Velocities and books at the end of a solved step from the forces there."""
        start, end = old[:, 3:], self.owned[:, 3:]
        before, past = self.a.copy(), self._force.copy()
        for rates in (before, past):
            rates[:, 3:] = carry(rates[:, 3:], start, end)
        a = (1 + self.alpha) * force - self.alpha * past
        mean = (1 - self.gamma) * before + self.gamma * a
        mean_outer = (1 + self.alpha) * outer - self.alpha * self._outer
        pull = (1 - self.gamma) * self._mean_outer + self.gamma * mean_outer
        free = slowed(self, dt)
        v_old = free[:, :3].copy()
        book_drag(self, free)
        free[:, 3:] = carry(free[:, 3:], start, end)
        free += dt * mean
        self.a, self._force = a, force
        self._mean_outer, self._outer = mean_outer, outer
        moved = self.owned[:, :3] - old[:, :3]
        self.v[:] = free[:, :3]
        constrain(self, free, self.time + dt, dt)
        if self.contact is not None:
            self._pushed = self.contact.push(self, v_old, mean[:, :3], moved, dt)
        self.books.impulses[BY_LOADS] += dt * pull.sum(axis=0)
        self.books.works[EXTERNAL] += np.vdot(pull, moved)

    def _choose_step(self, dt, error, iterations):
        growth = 1.5 if iterations <= 8 else 0.7
        if self.tolerance is not None:
            growth = min(growth, max(0.3, 0.9 * (self.tolerance / max(error, 1e-300)) ** (1 / 3)))
        self.dt = min(self.largest_dt, growth * dt)

    def _accelerations(self, time):
        """Force over inertia (n_owned, 6), contact left out, and the loads (n_owned, 3) [N]."""
        eq = self.equilibrium
        eq.level, eq.inertia, eq.factor, eq.rubbing = time, None, None, None
        rates = -eq.forces() / self._mass6
        rates[:, 3:] = eq.free_part(rates)[:, 3:]
        outer = np.zeros((self.n_owned, 3))
        return rates, self.shell.loads.force_at(time, outer, eq.load_factor)

    def destroy(self) -> None:
        """Free PETSc's objects; the shell keeps its state."""
        if not self._destroyed:
            self.newton.destroy()
            self.equilibrium.destroy()
            self._destroyed = True
