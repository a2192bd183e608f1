# SPDX-License-Identifier: LGPL-3.0-or-later
"""Roundoff of the internal forces, estimated and measured: where Eq. 14 loses its digits.

Strains are differences of numbers of order one, and of displacements over the shorter side h of a
cell: they carry an error eps (1 + u/h). Their force is the stiffness A times the longer side l
times that. A residual below it says nothing; what roundoff makes of a sheet on a processor can be
measured, since a sheet turned as a whole has turned forces.
"""

import functools
from collections.abc import Callable

from mpi4py import MPI

import numpy as np

from shellform.fem import director
from shellform.fem.partition import Partition

# of length 1, along no axis of usual meshes
AXES = ((0.6, 0.64, 0.48), (0.48, -0.6, 0.64), (0.64, 0.48, -0.6))


class Roundoff:
    """Roundoff of the internal forces of a sheet; all methods are collective.

    Parameters
    ----------
    partition : of the sheet's mesh; comm : MPI.Comm of its ranks
    """

    def __init__(self, partition: Partition, comm: MPI.Comm):
        self.partition, self.comm = partition, comm

    @functools.cached_property
    def sides(self) -> tuple[float, float]:
        """Means over the cells of the longer side [m] and of its ratio to area over it."""
        surface = self.partition.surface
        corners = surface.points[surface.cells[:, : 3 if surface.cells.shape[1] == 3 else 4]]
        sides = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2).max(axis=1)
        slender = np.maximum(1.0, sides**2 / surface.cell_areas)
        return max(float(sides.mean()), surface.mean_cell_size), float(slender.mean())

    def largest(self, u: np.ndarray) -> float:
        """Largest component of the displacements (n, 3) [m] of all ranks."""
        return self.comm.allreduce(np.abs(u).max(initial=0.0), op=MPI.MAX)

    def estimated(self, u: np.ndarray, stiffness: float) -> float:
        """Norm of the forces [N] that roundoff of the membrane strain alone can make.

        Parameters
        ----------
        u : (n_owned, 3), displacements [m]; stiffness : of the membrane [N/m]
        """
        longer, ratio = self.sides
        size = longer + ratio * self.largest(u)
        points = self.partition.surface.points
        return np.finfo(float).eps * stiffness * size * np.sqrt(len(points))

    def measured(
        self,
        w: np.ndarray,
        internal_force: Callable[[], np.ndarray],
        in_unknowns: Callable[[np.ndarray], np.ndarray],
    ) -> float:
        """Norm of the forces [N] that roundoff makes at w; 4 assemblies.

        What differs between turned forces and forces of the turned sheet is roundoff, of these
        cells and corners, this compiler and this processor. The turn moves a point by the largest
        displacement, whose last digit the unknowns carry anyway, or by the shorter side of a cell.
        The largest of three turns: equal cells can be rounded alike by luck.

        Parameters
        ----------
        w : (n, 6), nodal field (u, d) that the forces are of; turned, and given back as it was
        internal_force : gives the forces (n_owned, 6) [N, N m] at w
        in_unknowns : takes such forces to the free unknowns [N], at the state before the turn
        """
        here, partition = w.copy(), self.partition
        longer, ratio = self.sides
        points = partition.surface.points - partition.origin
        radius = np.linalg.norm(points, axis=1).max()
        angle = min(1.0, max(self.largest(w[:, :3]), longer / ratio) / radius)
        places = points[partition.nodes] + here[:, :3]
        forces, differences = internal_force().copy(), []
        for axis in AXES:
            turn = director.rotation_matrix(angle * np.array(axis))
            w[:, :3] = here[:, :3] + places @ (turn - np.eye(3)).T
            w[:, 3:] = here[:, 3:] @ turn.T
            change = (internal_force().reshape(-1, 3) @ turn).reshape(-1, 6) - forces
            differences.append(np.sum(in_unknowns(change) ** 2))
        w[:] = here
        return float(np.sqrt(self.comm.allreduce(np.array(differences)).max()))
