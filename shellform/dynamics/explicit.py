# SPDX-License-Identifier: LGPL-3.0-or-later
"""Explicit Newmark steps, beta = 0, gamma = 1/2: Sec. 3.1.3 of the paper, Eq. 13.

Explicit (beta = 0, gamma = 1/2): lumped mass, central differences with velocities at half steps,

    v(n+1/2) = v(n-1/2) + dt M^-1 (f_ext - f_int(x_n)),   x(n+1) = x(n) + dt v(n+1/2),

which is Newmark's method written without accelerations. Parts (contact) see the free velocities
between the two lines and correct them in place.

Damping, both off by default: `damping` [s] adds to the stress that of the strains' rates times this
time, which takes energy from every change of strain and leaves rigid motion alone, under whatever
stress (forces taken at x + damping v would feed on a buckling sheet); `drag` [1/s] slows all motion
as still air does.
"""

from typing import Any

import numpy as np

from shellform.errors import Unstable
from shellform.fem.lumped_mass import ROTARY_SCALE
from shellform.fem.shell import Shell

from . import explicit_drift, explicit_kernels
from .books import DAMPING, EXTERNAL, INTERNAL, WORKS, Books
from .explicit_kernels import NODE, Forces
from .explicit_supports import conditions, follow
from .external_force import ExternalForce
from .force_model import ForceModel
from .part import AppliedForce, Part
from .shell_force import ShellForce
from .stable_step import stable_step
from .step_retry import Rewind
from .time_stepper import Stepper, check_time


class Newmark(Stepper):
    """Explicit steps of a sheet, by default of a shell.

    Parameters
    ----------
    shell, rotary_scale, prefix : see Stepper
    time_step_factor : float, of the largest stable step
    damping : float [s]; drag : float [1/s]
    force_model : ForceModel or None: the shell's own, with `damping`

    Attributes
    ----------
    v, q : velocities at the last half step; v_old : (n_owned, 3), before the last kick
    clock, books : see books.py; balances are given at the present time, see `balance`
    force_model : ForceModel, what pushes nodes from inside
    external : ExternalForce, loads and forces that depend on the motion
    forces : Forces of the last kick; nodes : (n_owned,) NODE, for kernels, with copies of `mass`
        and `inertia`
    drag : float [1/s], may be changed between calls of `advance`
    factor : float, `time_step_factor`
    rewind : Rewind, which cuts back steps that diverge in `advance`

    Examples
    --------
    >>> import meshes, shellform as sf
    >>> fabric = sf.Fabric.isotropic(1e5, 0.3, 1e-3, 200.0)
    >>> shell = sf.Shell(meshes.rectangle(0.4, 0.4, (4, 4)), fabric)
    >>> shell.loads.gravity()
    >>> stepper = sf.Newmark(shell)
    >>> stepper.advance(0.1)
    >>> f"{shell.displacements()[:, 2].mean():.3f} m"
    '-0.049 m'
    """

    recheck = 500  # steps between looks at the stable step and at the energy
    watch = 50  # steps between questions among ranks whether all are finite

    def __init__(
        self,
        shell: Shell,
        time_step_factor: float = 0.9,
        damping: float = 0.0,
        drag: float = 0.0,
        rotary_scale: float = ROTARY_SCALE,
        prefix: str = "shell_",
        force_model: ForceModel | None = None,
    ) -> None:
        check_settings(time_step_factor, damping, drag)
        super().__init__(shell, rotary_scale, prefix)
        shell.loads.freeze()
        shell.claim(self)
        n = self.n_owned
        held, plane = conditions(shell.supports, n, shell.comm)
        model = ShellForce(shell, damping) if force_model is None else force_model
        if not model.turns_directors:
            held[:, 3], plane[:] = True, 0.0
        self.force_model, self.factor = model, time_step_factor
        self.damping, self.drag = damping, drag
        self.nodes = np.zeros(n, NODE)
        self.nodes["mass"], self.nodes["inertia"] = self.mass, self.inertia
        self.nodes["held"], self.nodes["plane"] = held, plane
        self._directors = self.owned[:, 3:]
        self.external = ExternalForce(shell.loads, n)
        self.support_impulse = np.zeros((n, 3))
        self.forces = Forces(np.zeros((n, 6)), self.external.force, self.support_impulse)
        self.v_old, self._free = self.v.copy(), self.v.copy()
        self.fault: str | None = None
        self.moved_sum = 0.0
        self.rewind = Rewind(self)
        self.clock.critical_dt = self.find_stable_step()
        self.dt = self.factor * self.critical_dt
        # motion far below what any step resolves: energies below this are not judged
        speed = 1e-6 * shell.surface.mean_cell_size / self.critical_dt
        self.smallest_energy = 0.5 * shell.comm.allreduce(self.mass.sum()) * speed**2

    @property
    def held(self) -> np.ndarray:
        """Held components (n_owned, 4) bool: u_x, u_y, u_z and the whole director."""
        return self.nodes["held"].view(bool)

    @property
    def critical_dt(self) -> float:
        """Largest stable step [s] when last looked at."""
        return self.clock.critical_dt

    def set_clock(self, numbers: np.ndarray) -> None:
        """Go back or on to the numbers of a clock, see `Clock.numbers`."""
        self.clock.set(numbers)
        self.fault, self.moved_sum = None, 0.0

    def add_applied_force(self, part: AppliedForce) -> None:
        """Let forces that depend on the motion push the nodes from now on."""
        self.external.applied.append(part)

    def remove(self, part: Part) -> None:
        """Let a part run no longer."""
        if isinstance(part, AppliedForce):
            self.external.applied.remove(part)
        else:
            super().remove(part)

    def describe(self) -> dict[str, Any]:
        """See Stepper."""
        plan = self.force_model.describe()
        plan["terms"] += ["inertia", "rotary inertia"][: 1 + self.force_model.turns_directors]
        plan["terms"] += [name for name in ("drag", "damping") if getattr(self, name)]
        return plan | self.describe_contact()

    def advance(self, until: float) -> None:
        """Step until a time [s] is reached exactly; steps that diverge are cut back.

        Raises
        ------
        Unstable, on all ranks, when smaller steps diverge too; the last good state is restored
        ValueError for a time that is not finite, or once a newer solver has taken the shell over
        """
        check_time(until)
        if not self.shell.is_claimed_by(self):
            raise ValueError(
                "a newer solver has taken this shell over: give each stepper a Shell of its own"
            )
        if until <= self.time:
            return
        self.rewind.begin((until - self.time) / self.dt)
        while self.time < until:
            try:
                super().advance(until)
                self.rewind.end()
            except Unstable as fault:
                self.rewind.back(fault)

    def step(self, dt: float) -> None:
        """One step of length dt [s]."""
        clock = self.clock
        kicked = 0.5 * (clock.last_dt + dt)
        self.kick(kicked, dt)
        for part in self.parts:
            try:
                part(self, dt)
            except FloatingPointError as fault:
                self.fault = str(fault)  # other ranks learn of it at the next `check`
        self._book(kicked)
        clock.last_kick = kicked
        self.moved_sum = explicit_drift.drift(self.owned, self.v, self.q, dt)
        self.scatter()
        clock.last_dt, clock.time, clock.steps = dt, clock.time + dt, clock.steps + 1
        if clock.steps % self.recheck == 0:
            self.check()
            self.rewind.look()
            self.check_step()
            self.rewind.keep()
        elif self.shell.comm.size == 1:
            if self.fault or not np.isfinite(self.moved_sum):
                self.check()
        elif clock.steps % self.watch == 0:
            self.check()

    def check(self) -> None:
        """Raise Unstable on all ranks if one has left the finite numbers; all ranks call."""
        fault, self.fault = self.fault, None
        self.check_finite(self.moved_sum, self.clock.last_dt, fault)

    def check_step(self) -> None:
        """Follow the stable step as the sheet deforms: down at once, up by a tenth at most."""
        self.clock.critical_dt = self.find_stable_step(iterations=12)
        self.dt = min(self.rewind.cut * self.factor * self.critical_dt, 1.1 * self.dt)

    def kick(self, kicked: float, dt: float) -> None:
        """Velocities by the forces acting for `kicked` [s], then the supports; dt [s], the step."""
        self.forces = self._push(
            self.v, self.q, self.v_old, self._free, kicked, self.support_impulse, self.books
        )
        if self.shell.supports.motions:
            follow(self, dt, kicked, self.forces)
            if not self.force_model.turns_directors:
                self.q[:] = 0.0

    def _push(self, v, q, v_old, free, dt, impulse, books):
        """Change velocities v, q by the present forces acting for dt [s]; returns the forces.

        v_old, free : filled with v before and after
        """
        r = self.internal_force()
        turning = self._add_moments(r, q)
        forces = Forces(r, self.external.update(self), impulse)
        explicit_kernels.kick(
            v, q, v_old, free, *forces, self._directors, self.nodes, self.drag, dt, books.works
        )
        if turning:
            _book_moments(*turning, q, dt, books.works)
        return forces

    def _book(self, kicked):
        """Book the last kick once all parts have had their say."""
        explicit_kernels.book(
            self.v_old, self._free, self.v, *self.forces, self.nodes, self.drag, kicked, *self.books
        )
        self.books.works[DAMPING] += self.force_model.damping_loss(
            self.v_old, self.v, kicked, self.clock.last_kick
        )

    def internal_force(self) -> np.ndarray:
        """Internal forces (n_owned, 6) [N, N m] at present, damped, less those of pressure."""
        return self.force_model.force(self.w, self.v, self.q, self.time)

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

    def velocities(self) -> tuple[np.ndarray, np.ndarray]:
        """Velocities (n, 3) of nodes and directors brought from the half step to the present."""
        v, q, _ = self._present()
        return v, q

    def _present(self):
        """Velocities and works (5,) at the present time: half a kick further."""
        v, q = self.v.copy(), self.q.copy()
        books, dt = Books(self.books.works.copy(), np.zeros((3, 3))), 0.5 * self.clock.last_dt
        v_old, free, impulse = np.empty((3, *v.shape))
        forces = self._push(v, q, v_old, free, dt, impulse, books)
        explicit_kernels.book(v_old, free, v, *forces, self.nodes, self.drag, dt, *books)
        books.works[DAMPING] += self.force_model.damping_loss(self.v, v, dt, self.clock.last_kick)
        return v, q, books.works

    def strain_energy(self) -> dict[str, float]:
        """Strain energy [J] by kind of term, on every rank."""
        return self.force_model.energy(self.w)

    def balance(self) -> dict[str, float]:
        """See Stepper; internal: the work of internal forces on nodes and directors.

        What friction inside the cloth has lost, where there is any, is that up to the present.

        Damping is booked kick by kick, see `ForceModel.damping_loss`.
        """
        v, q, works = self._present()
        comm, owned = self.shell.comm, self.owned
        moving = np.empty(7)
        explicit_kernels.momenta(owned, self.points, v, q, self.mass, self.inertia, moving)
        sums = comm.allreduce(np.array([*works, moving[6]]))
        now = dict(zip((*WORKS, "kinetic"), sums.tolist(), strict=True))
        now["strain"] = sum(self.strain_energy().values())
        if self.force_model.friction is not None:
            now["hysteresis"] = comm.allreduce(self.force_model.friction.lost)
        return now

    def find_stable_step(self, iterations: int = 30) -> float:
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
    works[INTERNAL] -= work
    works[EXTERNAL] += work


def check_settings(time_step_factor: float, damping: float, drag: float) -> None:
    """ValueError for a step beyond the stable one or a negative damping."""
    if not 0 < time_step_factor <= 1:
        raise ValueError(
            f"an explicit step is a part of the largest stable one, 0 to 1, not "
            f"{time_step_factor} of it"
        )
    for name, value in (("damping", damping), ("drag", drag)):
        if isinstance(value, str) or not 0 <= value < np.inf:
            raise ValueError(f"{name} is a finite number, not negative, not {value}")
