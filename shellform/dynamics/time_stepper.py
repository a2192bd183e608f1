# SPDX-License-Identifier: LGPL-3.0-or-later
"""Stepping in time under PETSc TS: what explicit and implicit Newmark steps share.

The TS is of Python type, so -shell_ts_monitor, -shell_ts_max_steps, ... act. Its vector is the
nodal field w, brought up to date at the end of each `advance`.
"""

import weakref
from collections.abc import Callable
from numbers import Real
from typing import Any

from petsc4py import PETSc

import numpy as np

from shellform.errors import Unstable
from shellform.fem.callback_errors import exceptions_as_raised
from shellform.fem.destroyed_together import destroy_with
from shellform.fem.dolfinx_compat import Function, petsc_view
from shellform.fem.lumped_mass import lumped
from shellform.fem.shell import Shell, require_shell

from . import explicit_kernels
from .books import BY_DRAG, BY_LOADS, BY_SUPPORTS, Clock, new_books
from .part import AppliedForce, Attachable, Part, PlainFunction, RunningContact


class Stepper:
    """State of a shell in motion and the clock that drives it.

    Parameters
    ----------
    shell : Shell, with supports and loads complete; starts from its present state, at rest
    rotary_scale : float, see fem/lumped_mass.py
    prefix : str, of the TS options

    Attributes
    ----------
    w : (n_local, 6), (u, d) with ghosts; v, q : (n_owned, 3), velocities of nodes [m/s] and of
        directors [1/s]
    mass, inertia : (n_owned,) [kg, kg m^2]; points : (n_owned, 3), reference positions [m]
    clock : Clock, of which `time`, `dt` and `steps` are; books : Books
    parts : list of Part, in the order of their turns in a step, see `add`
    contact : RunningContact or None, the one among them; self_contact : that of the sheet with
        itself, or None
    """

    implicit = False

    def __init__(self, shell: Shell, rotary_scale: float, prefix: str) -> None:
        self.shell = require_shell(shell, type(self).__name__)
        self.parts: list[Part] = []
        self.contact: RunningContact | None = None
        self.self_contact: Any = None
        partition, n = shell.partition, shell.partition.n_owned
        self.n_owned = n
        shell.supports.freeze()
        shell.take_directors()
        self.w = shell.w.x.array.reshape(-1, 6)
        self.owned = self.w[:n]
        self.points = partition.surface.points[partition.owned_nodes]
        mass, inertia = lumped(shell.surface, shell.fabric, rotary_scale)
        self.mass, self.inertia = mass[partition.owned_nodes], inertia[partition.owned_nodes]
        self.v, self.q = np.zeros((n, 3)), np.zeros((n, 3))
        self.clock, self.books = Clock(), new_books()
        self.ts = PETSc.TS().create(shell.comm)
        self.ts.setOptionsPrefix(prefix)
        self.ts.setType(PETSc.TS.Type.PYTHON)
        # PETSc's hold on it is one that Python's collector cannot see: the two would never be freed
        self.ts.setPythonContext(_Context(weakref.proxy(self)))
        destroy_with(self, self.ts, shell.comm)
        self.ts.setExactFinalTime(PETSc.TS.ExactFinalTime.STEPOVER)
        self.ts.setMaxSteps(2**31 - 1)
        # PETSc copies this vector around every step: it must not be the memory of w
        self._ts_vector = petsc_view(shell.w).duplicate()
        self.ts.setSolution(self._ts_vector)
        self.ts.setFromOptions()

    @property
    def time(self) -> float:
        """Present time [s]; may be set between calls of `advance`."""
        return self.clock.time

    @time.setter
    def time(self, value: float) -> None:
        self.clock.time = value

    @property
    def dt(self) -> float:
        """Step [s] to take next; may be set between calls of `advance`."""
        return self.clock.dt

    @dt.setter
    def dt(self, value: float) -> None:
        self.clock.dt = value

    @property
    def steps(self) -> int:
        """Steps taken so far."""
        return self.clock.steps

    @property
    def work(self) -> dict[str, float]:
        """Works [J] on this rank by kind, see books.py."""
        return self.books.by_kind()

    @property
    def external_total(self) -> np.ndarray:
        """Impulse (3,) [N s] of the loads on this rank's nodes so far."""
        return self.books.impulses[BY_LOADS]

    @property
    def support_total(self) -> np.ndarray:
        """Impulse (3,) [N s] of the supports on this rank's nodes so far."""
        return self.books.impulses[BY_SUPPORTS]

    @property
    def drag_total(self) -> np.ndarray:
        """Impulse (3,) [N s] of drag on this rank's nodes so far."""
        return self.books.impulses[BY_DRAG]

    def describe(self) -> dict[str, Any]:
        """What is modelled, for the plan of a run: element, terms, loads, contact."""
        plan = self.shell.plan()
        plan["terms"] += ["inertia", "rotary inertia"]
        return plan | self.describe_contact()

    def describe_contact(self) -> dict[str, Any]:
        """Names of the segments in contact and coefficients of friction, where there are any."""
        itself = {} if self.self_contact is None else {"self_contact": True}
        if self.contact is None:
            return itself
        plan: dict[str, Any] = itself | {"contact": list(self.contact.body.names)}
        friction = self.contact.friction
        if friction.static > 0:
            plan["friction"] = [friction.static, friction.kinetic]
        return plan

    def add(self, part: Attachable | Callable[[Any, float], object]) -> Any:
        """Let a part run with the steps, see part.py; returns the running part.

        Raises
        ------
        TypeError for what is no part; ValueError as the part's `attach` does
        """
        if isinstance(part, Attachable):
            return part.attach(self)
        if not callable(part):
            raise TypeError(
                f"a stepper takes parts, as Contact(body), and functions of (stepper, dt), "
                f"not {part!r}"
            )
        return PlainFunction(part).attach(self)

    def remove(self, part: Part) -> None:
        """Let a part run no longer."""
        self.parts.remove(part)
        if part is self.self_contact:
            self.self_contact = None
        if part is self.contact:
            self.contact = None
            if self.self_contact not in self.parts:  # it had its turn with the body's
                self.self_contact = None

    def set_contact(self, contact: RunningContact) -> None:
        """Take over a contact; ValueError if there is one, or if its books came first."""
        if self.contact is not None:
            raise ValueError("this stepper has a body already; give all segments to one Body")
        for part in self.parts:
            if part.books_contact:
                raise ValueError(
                    f"add the contact before {type(part).__name__}, which books what it does"
                )
        self.contact = contact

    def set_self_contact(self, contact: Part) -> None:
        """Take over a contact of the sheet with itself; ValueError as `set_contact`."""
        if self.self_contact is not None:
            raise ValueError("the cloth of this stepper meets itself already")
        for part in self.parts:
            if part.books_contact:
                raise ValueError(
                    f"add the contact before {type(part).__name__}, which books what it does"
                )
        self.self_contact = contact

    def add_applied_force(self, part: AppliedForce) -> None:
        """ValueError: only explicit steps take forces that depend on the motion."""
        raise ValueError(
            f"{type(part).__name__} pushes nodes by where they are and how they move: explicit "
            "steps only, take Newmark"
        )

    def advance(self, until: float) -> None:
        """Step until a time [s] is reached exactly; the steps left share out the rest evenly."""
        check_time(until)
        if until <= self.time:
            return
        self._until = until
        self.ts.setTime(self.time)
        self.ts.setStepNumber(0)
        self.ts.setMaxTime(until)
        self.ts.setTimeStep(self.next_dt())
        with exceptions_as_raised():
            self.ts.solve(self._ts_vector)
        self.time = until
        petsc_view(self.shell.w).copy(self._ts_vector)

    def next_dt(self) -> float:
        """Step [s] that brings `until` nearer without leaving a crumb."""
        rest = self._until - self.time
        return rest / max(1, int(np.ceil(rest / self.dt * (1 - 1e-9))))

    def velocities(self) -> tuple[np.ndarray, np.ndarray]:
        """Velocities (n_owned, 3) of nodes [m/s] and directors [1/s] at the present time."""
        raise NotImplementedError

    def step(self, dt: float) -> None:
        """One step of length dt [s]."""
        raise NotImplementedError

    def momenta(self) -> tuple[np.ndarray, np.ndarray, float]:
        """Momentum (3,), angular momentum about the origin (3,), kinetic energy, on every rank."""
        v, q = self.velocities()
        out = np.empty(7)
        explicit_kernels.momenta(self.owned, self.points, v, q, self.mass, self.inertia, out)
        out = self.shell.comm.allreduce(out)
        return out[:3], out[3:6], out[6]

    def strain_energy(self) -> dict[str, float]:
        """Strain energy [J] by kind of term, on every rank."""
        return self.shell.energy()

    def balance(self) -> dict[str, float]:
        """Energies and works so far [J] at the present time, on every rank.

        Keys: kinetic, strain; work done by external forces and supports; what drag and damping
        took, the latter up to a constant; hysteresis, what friction inside the cloth lost, where
        there is any.
        """
        kinetic, strain = self.momenta()[2], sum(self.strain_energy().values())
        work = {kind: self.shell.comm.allreduce(value) for kind, value in self.work.items()}
        if self.shell.fabric.friction is not None:
            work["hysteresis"] = self.shell.friction_loss()
        return work | {"kinetic": kinetic, "strain": strain}

    def check_finite(self, total: float, dt: float, fault: str | None = None) -> None:
        """Raise Unstable on all ranks if the sum of any rank's coordinates is not finite.

        `fault` is a sentence of what else a rank found, or None. All ranks call.
        """
        comm, surface = self.shell.comm, self.shell.surface
        if not np.isfinite(total):
            state = np.hstack([self.owned, self.v, self.q])
            bad = np.flatnonzero(~np.isfinite(state).all(axis=1))
            node = self.shell.partition.nodes[bad[0]] if len(bad) else "?"
            fault = (
                f"node {node} of {surface.source} has left the finite numbers at "
                f"t = {self.time:.6g} s, step {self.steps} of {dt:.3g} s; take a smaller time step"
            )
        faults = [fault] if comm.size == 1 else comm.allgather(fault)
        for fault in faults:
            if fault:
                raise Unstable(fault)

    def scatter(self, field: Function | None = None) -> None:
        """Bring ghosts of w, or of another Function, up to date."""
        if self.shell.comm.size > 1:
            (field or self.shell.w).x.scatter_forward()


def check_time(until: float) -> None:
    """ValueError for a time that no number of steps reaches."""
    if not isinstance(until, Real) or not np.isfinite(until):
        raise ValueError(f"steps lead to a finite time in s, not to {until!r}")


class _Context:
    """What PETSc's TS of Python type calls."""

    def __init__(self, stepper):
        self.stepper = stepper

    def solveStep(self, ts, t, u):
        dt = ts.getTimeStep()
        # the traceback of an error that somebody keeps would keep them beyond the end of PETSc
        del ts, u
        self.stepper.step(dt)

    def adaptStep(self, ts, t, u):
        return self.stepper.next_dt(), True
