# SPDX-License-Identifier: LGPL-3.0-or-later
"""Static equilibrium in the 5 unknowns of a node, for SNES: Eqs. 10, 13, 14 without inertia.

The unknown vector x holds, node by node, the displacement [m] and two director rotations times the
length of the scene [m], so forces and moments meet in one norm with one unit. Rotations are counted
from a *base* state that moves on before every Newton iteration (`advance`); the frames travel with
the directors, so the residual does not jump when the base does. The matrix P of Eq. 10 carries the
6-component system of UFL to the 5 unknowns:

    F = P^T r,   K = P^T K6 P + diag(0, -(r_d . d)),   columns of held unknowns left out.
"""

import functools
import time
from typing import Any

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np

from shellform.fem import director
from shellform.fem.shell import Linearised, Shell

from .roundoff import Roundoff
from .tangent_map import TangentMap

State = tuple[np.ndarray, np.ndarray]  # of nodes: (u, d) (n, 6) and the frames (n, 3, 2)


def _timed(assemble):
    """Count a method's seconds to `assembly_seconds`."""

    @functools.wraps(assemble)
    def counted(self, *arguments):
        start = time.perf_counter()
        result = assemble(self, *arguments)
        self.assembly_seconds += time.perf_counter() - start
        return result

    return counted


class Equilibrium:
    """Residual, tangent and update of a shell under its loads at a level.

    Parameters
    ----------
    shell : Shell, with its supports and loads complete
    mip : bool, geometric tangent from the linearised stress (shell.py)

    Attributes
    ----------
    x : PETSc.Vec, the unknowns; F : PETSc.Vec; K : PETSc.Mat
    level : float, load level or time; load_factor : see Loads.force_at
    inertia : None or (factor, predicted), both (n_owned, 6): adds factor (w - predicted), the
        inertia of an implicit time step, to the forces
    reaction : (n_owned, 5), forces of the held unknowns at the last residual [N]
    assembly_seconds : float, spent in residuals and tangents
    """

    def __init__(self, shell: Shell, mip: bool = True):
        self.shell, self.mip, self.level = shell, mip, 0.0
        self.assembly_seconds = 0.0
        self.load_factor: float | None = None
        self.inertia: tuple[np.ndarray, np.ndarray] | None = None
        partition, supports = shell.partition, shell.supports
        supports.freeze()
        shell.claim(self)
        shell.rest()  # supports may have moved reference directors into their planes
        self.n, self.n_owned = partition.n_local, partition.n_owned
        self.length = partition.length
        self.x = shell.partition.petsc_vector(5)
        self.F, self._direct = self.x.duplicate(), self.x.duplicate()
        self.r6 = shell.partition.petsc_vector(6)
        self._lift6, self._product6 = self.r6.duplicate(), self.r6.duplicate()
        self.held = supports.held
        # axes of the nodes (n, 3, 3), None: those of the world
        self.Q: Any = supports.Q if supports.inclined.any() else None
        self._Q_owned: Any = None if self.Q is None else self.Q[: self.n_owned]
        self.T = director.tangent_frames(self._w()[:, 3:], supports.plane)
        self.K6 = shell.create_tangent()
        self.P = TangentMap(shell, self.length)
        self._roundoff = Roundoff(partition, shell.comm)
        self.K: PETSc.Mat = None  # made with the first tangent
        self.goal = np.zeros((self.n, 5))
        self.has_goal = bool(supports.motions) and bool(shell.comm.allreduce(len(supports.motions)))
        self.set_base()

    def destroy(self) -> None:
        """Free PETSc's objects (petsc4py collects them late)."""
        for item in (self.x, self.F, self._direct, self.r6, self._lift6, self._product6):
            item.destroy()
        for matrix in (self.K6, self.P.matrix, self.K):
            if matrix is not None:
                matrix.destroy()

    # -- state ------------------------------------------------------------------------------------

    def _w(self):
        return self.shell.w.x.array.reshape(-1, 6)

    def state(self) -> State:
        """Copy of the configuration: (u, d) and the frames, to come back to."""
        return self._w().copy(), self.T.copy()

    def restore(self, state: State) -> None:
        """Return to a configuration of `state()`."""
        self._w()[:], self.T[:] = state
        self.set_base()

    def stale(self) -> bool:
        """True once another equilibrium of the same shell has been made."""
        return not self.shell.is_claimed_by(self)

    def largest_change(self, state: State) -> float:
        """Largest displacement [m] of a node since a `state()`."""
        change = np.linalg.norm(self._w()[:, :3] - state[0][:, :3], axis=1).max(initial=0.0)
        return self.shell.comm.allreduce(float(change), op=MPI.MAX)

    def adopt(self) -> None:
        """Take the shell's field, set from outside, as the present configuration."""
        self.T = director.tangent_frames(self._w()[:, 3:], self.shell.supports.plane)
        self.set_base()

    def set_base(self) -> None:
        """Make the present configuration the base, with no change before it."""
        self.w_base, self.T_base = self.state()
        self.stress_from: Linearised | None = None
        self._write_x(self.x)

    def _write_x(self, x):
        local = np.zeros((self.n_owned, 5))
        local[:, :3] = director.along_axes(self._Q_owned, self.w_base[: self.n_owned, :3])
        x.setArray(local.ravel())

    def configure(self, x: PETSc.Vec) -> None:
        """Set w and the frames from the unknowns, ghosts included."""
        x.ghostUpdate(addv=PETSc.InsertMode.INSERT, mode=PETSc.ScatterMode.FORWARD)
        with x.localForm() as local:
            values = local.array_r.reshape(-1, 5)
            w = self._w()
            u = values[:, :3]
            w[:, :3] = u if self.Q is None else np.einsum("nji,nj->ni", self.Q, u)
            theta = values[:, 3:] / self.length
        w[:, 3:], self.T[:] = director.exponential_map(self.w_base[:, 3:], self.T_base, theta)

    def advance(self, x: PETSc.Vec) -> None:
        """Move the base to x, remembering the change for the linearised stress; resets x."""
        self.configure(x)
        with x.localForm() as local:
            change = local.array_r.reshape(-1, 5).copy()
        change[:, 3:] /= self.length
        step = director.push_forward(change, self.T_base, self.Q)
        step[:, :3] -= self.w_base[:, :3]
        if self.mip and np.isfinite(step).all():
            stress_from = (self.w_base.ravel().copy(), step.ravel())
        else:
            stress_from = None
        self.set_base()
        self.stress_from = stress_from
        self._write_x(x)
        if self.has_goal:
            self._set_goal()

    # -- equations --------------------------------------------------------------------------------

    def start(self, level: float) -> None:
        """Prepare a solve at a load level from the present configuration."""
        self.level = level
        self.set_base()
        if self.has_goal:
            self._set_goal()

    @_timed
    def residual(self, x: PETSc.Vec, F: PETSc.Vec) -> None:
        """F(x) [N], zero on held unknowns that have reached their prescribed value."""
        self.configure(x)
        r5 = self._pull_back(self.forces(None))
        held = self.held[: self.n_owned]
        self.reaction = np.where(held, r5, 0.0)
        r5[held] = 0.0
        if self.has_goal:
            self._lift(x, r5)
        F.setArray(r5.ravel())

    @_timed
    def tangent(self, x: PETSc.Vec) -> PETSc.Mat:
        """K at x, symmetric unless a moment or pressure makes it otherwise."""
        self.configure(x)
        shell = self.shell
        shell.tangent(self.K6, self.pressure, self.stress_from)
        self.K6.assemble()
        self._add_moment_tangent()
        if self.inertia is not None:
            self._lift6.setArray(self.inertia[0].ravel())
            self.K6.setDiagonal(self._lift6, addv=PETSc.InsertMode.ADD_VALUES)
        P = self.P.at(self.T)
        if self.K is None:
            self.K = self.K6.ptap(P)
        else:
            self.K6.ptap(P, result=self.K)
        r6 = self.forces(self.stress_from)
        d = self._w()[: self.n_owned, 3:]
        diagonal = np.zeros((self.n_owned, 5))
        diagonal[:, 3:] = -np.einsum("ni,ni->n", r6[:, 3:], d)[:, None] / self.length**2
        diagonal[self.held[: self.n_owned]] = self.stiffness
        self._direct.setArray(diagonal.ravel())
        self.K.setDiagonal(self._direct, addv=PETSc.InsertMode.ADD_VALUES)
        return self.K

    def level_derivative(self, out: PETSc.Vec) -> None:
        """dF/dlevel [N] at the configuration of the last `tangent`, which is used where supports
        move.

        Amplitudes and prescribed motions are functions of the user's: their slopes are central
        differences, exact to roundoff where they are linear.
        """
        loads, w = self.shell.loads, self._w()
        step = np.cbrt(np.finfo(float).eps) * max(1.0, abs(self.level))
        r6 = self._pressure_derivative(step)
        for level, weight in ((self.level + step, 0.5 / step), (self.level - step, -0.5 / step)):
            force = loads.force_at(level, np.zeros((self.n_owned, 3)), self.load_factor)
            r6[:, :3] -= weight * force
            nodes, moments = loads.moment_at(level, self.load_factor)
            r6[nodes, 3:] -= weight * np.cross(moments, w[nodes, 3:])
        r5 = self._pull_back(r6)
        held = self.held[: self.n_owned]
        r5[held] = 0.0
        if self.has_goal:
            pace = np.where(held, self._goal_derivative(step)[: self.n_owned], 0.0)
            r5 += np.where(held, -pace * self.stiffness, self._pulled_along(pace))
        out.setArray(r5.ravel())

    def _pressure_derivative(self, step):
        """Forces (n_owned, 6) that a pressure adds to `forces` as the level grows."""
        loads = self.shell.loads
        slope = loads.pressure_at(self.level + step, self.load_factor)
        slope = (slope - loads.pressure_at(self.level - step, self.load_factor)) / (2 * step)
        if slope == 0.0:
            return np.zeros((self.n_owned, 6))
        # linear in the pressure: one as large as the internal forces loses no digits
        unit = self.stiffness / self.length
        without = self._internal(pressure=0.0).copy()
        return (self._internal(pressure=unit) - without) * (slope / unit)

    @property
    def pressure(self) -> float:
        """Pressure [Pa] at the present level."""
        return self.shell.loads.pressure_at(self.level, self.load_factor)

    @property
    def stiffness(self) -> float:
        """Scale of the sheet's stiffness [N/m]."""
        return float(np.abs(self.shell.fabric.membrane).max())

    def force_scale(self) -> float:
        """Norm of the loads [N], what a residual is small against; of the reactions without loads.

        Reactions of an iterate off the solution can exceed the loads by many orders.
        """
        loads, reactions = self.pushes()
        return loads or reactions

    def pushes(self) -> tuple[float, float]:
        """Norms [N] of the loads, inertia among them, and of the reactions."""
        external = np.zeros((self.n_owned, 5))
        self.shell.loads.force_at(self.level, external[:, :3], self.load_factor)
        nodes, moments = self.shell.loads.moment_at(self.level, self.load_factor)
        external[nodes, 3:] += np.linalg.norm(moments, axis=1)[:, None] / self.length
        if self.inertia is not None:
            factor, predicted = self.inertia
            external -= self._pull_back(factor * (self._w()[: self.n_owned] - predicted))
            external[self.held[: self.n_owned]] = 0.0
        parts = np.array([np.sum(external**2), np.sum(self.reaction**2)])
        parts[0] += (self.pressure * self.shell.surface.area) ** 2 / len(self.shell.surface.points)
        loads, reactions = np.sqrt(self.shell.comm.allreduce(parts)).tolist()
        return loads, reactions

    def roundoff(self) -> float:
        """Norm of the residual [N] that roundoff can make here, estimated: see roundoff.py."""
        return self._roundoff.estimated(self._w()[: self.n_owned, :3], self.stiffness)

    def measured_roundoff(self) -> float:
        """Norm of the residual [N] that roundoff makes here, measured by 4 assemblies."""

        def on_free_unknowns(r6):
            return np.where(self.held[: self.n_owned], 0.0, self._pull_back(r6))

        return self._roundoff.measured(self._w(), self._internal, on_free_unknowns)

    def reactions(self) -> np.ndarray:
        """Forces (n, 3) [N] of the supports at the last residual, in the surface's numbering.

        All ranks call it, all get them.
        """
        return self.shell.partition.gather(self.in_world(self.reaction[:, :3]))

    def reaction_moments(self) -> np.ndarray:
        """Moments (n, 3) [N m] of the supports on directors at the last residual, as `reactions`.

        All ranks call it, all get them.
        """
        along = np.einsum("nij,nj->ni", self.T[: self.n_owned], self.reaction[:, 3:])
        moments = np.cross(self._w()[: self.n_owned, 3:], along * self.length)
        return self.shell.partition.gather(moments)

    def in_world(self, vectors: np.ndarray) -> np.ndarray:
        """Vectors (n_owned, 3) along the axes of the nodes, along those of the world."""
        return vectors if self.Q is None else np.einsum("nji,nj->ni", self._Q_owned, vectors)

    def along_axes(self, vectors: np.ndarray) -> np.ndarray:
        """Vectors (n_owned, 3) of the world along the axes of the nodes."""
        return director.along_axes(self._Q_owned, vectors)

    def forces(self, stress_from: Linearised | None = None) -> np.ndarray:
        """Internal less external nodal forces (n_owned, 6) [N, N m], of inertia too if there is."""
        r6 = self._internal(stress_from)
        external = self.shell.loads.force_at(
            self.level, np.zeros((self.n_owned, 3)), self.load_factor
        )
        r6[:, :3] -= external
        nodes, moments = self.shell.loads.moment_at(self.level, self.load_factor)
        w = self._w()
        r6[nodes, 3:] -= np.cross(moments, w[nodes, 3:])
        if self.inertia is not None:
            factor, predicted = self.inertia
            r6 += factor * (w[: self.n_owned] - predicted)
        return r6

    def _internal(self, stress_from=None, pressure=None):
        """Internal nodal forces (n_owned, 6) [N, N m] less those of a pressure, in `r6`."""
        with self.r6.localForm() as local:
            local.set(0.0)
        pressure = self.pressure if pressure is None else pressure
        self.shell.internal_force(self.r6, pressure, stress_from)
        self.r6.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)
        return self.r6.array.reshape(-1, 6)

    def _pull_back(self, r6):
        r5 = director.pull_back(r6, self.T[: self.n_owned], self._Q_owned)
        r5[:, 3:] /= self.length
        return r5

    def _add_moment_tangent(self):
        nodes, moments = self.shell.loads.moment_at(self.level, self.load_factor)
        for node, (m1, m2, m3) in zip(nodes, moments, strict=True):
            rows = (6 * node + np.arange(3, 6)).astype(np.int32)
            minus_cross = np.array([[0, m3, -m2], [-m3, 0, m1], [m2, -m1, 0]])
            self.K6.setValuesLocal(rows, rows, minus_cross, addv=PETSc.InsertMode.ADD_VALUES)
        self.K6.assemble()

    # -- prescribed motion ------------------------------------------------------------------------

    def _set_goal(self):
        self._write_goal(self.level, self.goal)

    def _write_goal(self, level, goal):
        """Unknowns (n, 5) that the supports prescribe at a level; of others those of the base."""
        goal[:, :3] = director.along_axes(self.Q, self.w_base[:, :3])
        goal[:, 3:] = 0.0
        for local, u, d in self.shell.supports.prescribed(level):
            if u is not None:
                goal[local, :3] = u
            if d is not None:
                theta = director.logarithmic_map(self.w_base[local, 3:], self.T_base[local], d)
                goal[local, 3:] = theta * self.length

    def _lift(self, x, r5):
        """Rows of held unknowns: x - goal; its effect on the free rows to first order."""
        held = self.held[: self.n_owned]
        gap = np.where(held, x.array_r.reshape(-1, 5) - self.goal[: self.n_owned], 0.0)
        if self.shell.comm.allreduce(np.abs(gap).max(initial=0.0), op=MPI.MAX) == 0.0:
            return  # the usual case: K is assembled below for the first residual of a step only
        self.shell.tangent(self.K6, self.pressure, self.stress_from)
        self.K6.assemble()
        r5 -= np.where(held, 0.0, self._pulled_along(gap))
        r5[held] = gap[held] * self.stiffness

    def _pulled_along(self, held5):
        """Forces (n_owned, 5) of `K6` on all unknowns as the held ones change by `held5`."""
        change = held5 / [1, 1, 1, self.length, self.length]
        change = director.push_forward(change, self.T[: self.n_owned], self._Q_owned)
        self._lift6.setArray(change.ravel())
        self.K6.mult(self._lift6, self._product6)
        return self._pull_back(self._product6.array_r.reshape(-1, 6))

    def _goal_derivative(self, step):
        ahead, behind = np.empty_like(self.goal), np.empty_like(self.goal)
        self._write_goal(self.level + step, ahead)
        self._write_goal(self.level - step, behind)
        return (ahead - behind) / (2 * step)
