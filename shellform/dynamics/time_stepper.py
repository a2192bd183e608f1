# SPDX-License-Identifier: LGPL-3.0-or-later
"""Stepping in time under PETSc TS: what explicit and implicit Newmark steps share.

The TS is of Python type, so -shell_ts_monitor, -shell_ts_max_steps, ... act. Its vector is the
nodal field w, brought up to date at the end of each `advance`.
"""

from petsc4py import PETSc

import numpy as np

from shellform.errors import Unstable
from shellform.fem.dolfinx_compat import petsc_view
from shellform.fem.lumped_mass import lumped

from . import explicit_kernels


class Stepper:
    """State of a shell in motion and the clock that drives it.

    Parameters
    ----------
    shell : Shell, with supports and loads complete; starts from its present state, at rest
    hooks : callables (stepper, dt), run with the free velocities in `v` before nodes move
    rotary_scale : float, see inertia.py
    prefix : str, of the TS options

    Attributes
    ----------
    w : (n_local, 6), (u, d) with ghosts; v, q : (n_owned, 3), velocities of nodes [m/s] and of
        directors [1/s]
    mass, inertia : (n_owned,) [kg, kg m^2]; points : (n_owned, 3), reference positions [m]
    v_old : (n_owned, 3) or None, node velocities before the last kick
    time, dt : float [s]; steps : int
    """

    def __init__(self, shell, hooks, rotary_scale, prefix):
        self.shell, self.hooks = shell, list(hooks)
        partition, n = shell.partition, shell.partition.n_owned
        self.n_owned = n
        shell.supports.frozen = True
        shell.take_directors()
        self.w = shell.w.x.array.reshape(-1, 6)
        self.owned = self.w[:n]
        self.points = partition.surface.points[partition.owned_nodes]
        mass, inertia = lumped(shell.surface, shell.fabric, rotary_scale)
        self.mass, self.inertia = mass[partition.owned_nodes], inertia[partition.owned_nodes]
        self.v, self.q = np.zeros((n, 3)), np.zeros((n, 3))
        self.v_old = None
        self.time, self.steps = 0.0, 0
        self.ts = PETSc.TS().create(shell.comm)
        self.ts.setOptionsPrefix(prefix)
        self.ts.setType(PETSc.TS.Type.PYTHON)
        self.ts.setPythonContext(_Context(self))
        self.ts.setExactFinalTime(PETSc.TS.ExactFinalTime.STEPOVER)
        self.ts.setMaxSteps(2**31 - 1)
        # PETSc copies this vector around every step: it must not be the memory of w
        self._ts_vector = petsc_view(shell.w).duplicate()
        self.ts.setSolution(self._ts_vector)
        self.ts.setFromOptions()

    def keep_old_velocities(self):
        """Keep the velocities of the step before in `v_old`, for hooks that book work."""
        if self.v_old is None:
            self.v_old = self.v.copy()

    def advance(self, until):
        """Step until a time [s] is reached exactly; the steps left share out the rest evenly."""
        check_time(until)
        if until <= self.time:
            return
        self._until = until
        self.ts.setTime(self.time)
        self.ts.setStepNumber(0)
        self.ts.setMaxTime(until)
        self.ts.setTimeStep(self.next_dt())
        self.ts.solve(self._ts_vector)
        self.time = until
        petsc_view(self.shell.w).copy(self._ts_vector)

    def next_dt(self):
        """Step [s] that brings `until` nearer without leaving a crumb."""
        rest = self._until - self.time
        return rest / max(1, int(np.ceil(rest / self.dt * (1 - 1e-9))))

    def momenta(self):
        """Momentum (3,), angular momentum about the origin (3,), kinetic energy, on every rank."""
        v, q = self.velocities()
        out = np.empty(7)
        explicit_kernels.momenta(self.owned, self.points, v, q, self.mass, self.inertia, out)
        out = self.shell.comm.allreduce(out)
        return out[:3], out[3:6], out[6]

    def strain_energy(self):
        """Strain energy [J] by kind of term, on every rank."""
        return self.shell.energy()

    def balance(self):
        """Energies and works so far [J] at the present time, on every rank.

        Keys: kinetic, strain; work done by external forces and supports; what drag and damping
        took, the latter up to a constant.
        """
        kinetic, strain = self.momenta()[2], sum(self.strain_energy().values())
        work = {kind: self.shell.comm.allreduce(value) for kind, value in self.work.items()}
        return {"damping": 0.0} | work | {"kinetic": kinetic, "strain": strain}

    def check_finite(self, total, dt, fault=None):
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

    def scatter(self, field=None):
        """Bring ghosts of w, or of another Function, up to date."""
        if self.shell.comm.size > 1:
            (field or self.shell.w).x.scatter_forward()


def check_time(until):
    """ValueError for a time that no number of steps reaches."""
    if not np.isfinite(until):
        raise ValueError(f"steps lead to a finite time in s, not to {until}")


class _Context:
    """What PETSc's TS of Python type calls."""

    def __init__(self, stepper):
        self.stepper = stepper

    def solveStep(self, ts, t, u):
        self.stepper.step(ts.getTimeStep())

    def adaptStep(self, ts, t, u):
        return self.stepper.next_dt(), True
