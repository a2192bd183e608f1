# SPDX-License-Identifier: LGPL-3.0-or-later
"""Equilibrium with the inertia of an implicit step, and with nodes held by contact: Eqs. 10, 13.

Directors move along great circles: the turn from the director at the start of the step, a vector in
its tangent plane, takes the place of a displacement. Parallel transport along the circle brings
vectors from one tangent plane to another.

Contact holds nodes in planes that change from solve to solve. So every node has axes of its own for
its displacement (Q of statics/equilibrium.py), the world's until contact turns them.
"""

from collections.abc import Callable
from typing import Any

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np

from shellform.fem import director
from shellform.fem.director import carry, turn_to
from shellform.fem.dolfinx_compat import Function
from shellform.fem.shell import Shell
from shellform.statics.equilibrium import Equilibrium
from shellform.statics.tangent_map import TangentMap

NEGLIGIBLE = 1e-13  # of the scene's length: a held node this near to its place is there


class Inertial(Equilibrium):
    """Equilibrium of a shell with inertia and moving constraints.

    Attributes
    ----------
    factor : (n_owned, 6) or None, inertia over beta dt^2
    start_d : (n_owned, 3), directors at the start of the step
    ahead_u, ahead_d : (n_owned, 3), predicted displacement [m] and predicted turn [rad], a vector
        tangent to start_d
    rubbing : None, or what gives the friction on nodes for displacements (n_owned, 6): forces
        (n_owned, 3) [N] and their stiffnesses (n_owned, 3, 3) [N/m], symmetric
    """

    factor: np.ndarray | None = None
    rubbing: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]] | None = None
    start_d: np.ndarray
    ahead_u: np.ndarray
    ahead_d: np.ndarray
    _in_contact: np.ndarray | None = None
    _contact_goal: np.ndarray

    def __init__(self, shell: Shell) -> None:
        super().__init__(shell)
        supports = shell.supports
        self.moves, self.has_goal = self.has_goal, True
        self.held, self.Q = supports.held.copy(), supports.Q.copy()
        self._Q_owned = self.Q[: self.n_owned]
        self._fixed = supports.held[: self.n_owned, :3].all(axis=1)
        self._axes = Function(shell.space)
        self.P.matrix.destroy()
        self.P = TangentMap(shell, self.length, turning=True)
        self.set_base()

    # -- inertia ----------------------------------------------------------------------------------

    def configure(self, x: PETSc.Vec) -> None:
        """Set w and the frames from the unknowns, and where inertia would have them."""
        super().configure(x)
        if self.factor is not None:
            self.predict()

    def predict(self) -> None:
        """Put the field that inertia pulls the present one to into `inertia`."""
        assert self.factor is not None  # set before the first step
        d = self._w()[: self.n_owned, 3:]
        pull = carry(turn_to(self.start_d, d) - self.ahead_d, self.start_d, d)
        self.inertia = (self.factor, np.hstack([self.ahead_u, d - pull]))

    def forces(self, stress_from: Any = None) -> np.ndarray:
        """See Equilibrium; less the friction on nodes that slip."""
        r6 = super().forces(stress_from)
        if self.rubbing is not None:
            r6[:, :3] -= self.rubbing(self._w()[: self.n_owned])[0]
        return r6

    def _add_moment_tangent(self):
        super()._add_moment_tangent()
        if self.rubbing is None:
            return
        _, stiffness = self.rubbing(self._w()[: self.n_owned])
        nodes = np.flatnonzero(stiffness.any(axis=(1, 2)))
        rows = (6 * nodes[:, None] + np.arange(3)).astype(np.int32)
        starts = np.arange(0, 3 * rows.size + 1, 3, dtype=np.int32)
        columns = np.repeat(rows, 3, axis=0).ravel()
        self.K6.setValuesLocalIJV(
            starts, columns, stiffness[nodes].ravel(), PETSc.InsertMode.ADD_VALUES, rows.ravel()
        )
        self.K6.assemble()

    def free_part(self, rates: np.ndarray) -> np.ndarray:
        """Of rates (n_owned, 6) of w, the part along the unknowns that supports leave free."""
        supports, n = self.shell.supports, self.n_owned
        T, Q = self.T[:n], supports.Q[:n]
        rates = director.pull_back(rates, T, Q)
        rates[supports.held[:n]] = 0.0
        return director.push_forward(rates, T, Q)

    # -- contact ----------------------------------------------------------------------------------

    def hold(self, axes: np.ndarray, held: np.ndarray, goal: np.ndarray) -> None:
        """Hold nodes along axes of their own, until the next call; all ranks call.

        Parameters
        ----------
        axes : (n_owned, 3, 3), rows orthonormal and right-handed
        held : (n_owned, 3) bool; goal : (n_owned, 3), displacement along the axes [m]
            Axes that supports hold stay as they are, and wholly held nodes.
        """
        n, free = self.n_owned, ~self._fixed
        first_two = self._axes.x.array.reshape(-1, 6)
        first_two[:n] = self.Q[:n, :2].reshape(-1, 6)
        first_two[:n][free] = axes[free, :2].reshape(-1, 6)
        if self.shell.comm.size > 1:
            self._axes.x.scatter_forward()
        self.Q[:, :2] = first_two.reshape(-1, 2, 3)
        self.Q[:, 2] = np.cross(self.Q[:, 0], self.Q[:, 1])
        self._in_contact = held & ~self.shell.supports.held[:n, :3]
        self._contact_goal = goal
        self.held[:n, :3] = self.shell.supports.held[:n, :3] | self._in_contact
        self.P.turn(self._Q_owned, ~self.held[:n])

    def contact_force(self) -> np.ndarray:
        """Forces (n_owned, 3) [N] that hold nodes in contact, at the last residual."""
        if self._in_contact is None:
            return np.zeros((self.n_owned, 3))
        along = np.where(self._in_contact, self.reaction[:, :3], 0.0)
        return np.einsum("nji,nj->ni", self._Q_owned, along)

    def _set_goal(self):
        super()._set_goal()
        if self._in_contact is not None:
            goal = self.goal[: self.n_owned, :3]
            goal[self._in_contact] = self._contact_goal[self._in_contact]

    def _lift(self, x, r5):
        held = self.held[: self.n_owned]
        gap = np.where(held, x.array_r.reshape(-1, 5) - self.goal[: self.n_owned], 0.0)
        largest = self.shell.comm.allreduce(np.abs(gap).max(initial=0.0), op=MPI.MAX)
        if largest > NEGLIGIBLE * self.length:
            super()._lift(x, r5)
