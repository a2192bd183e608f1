# SPDX-License-Identifier: LGPL-3.0-or-later
"""Held and guided nodes: edge conditions on displacement and director.

An edge of a shell holds its displacement (any of three directions), its director (wholly, or to a
plane), or both. Conditions add up: two symmetry planes that meet at a node hold its director.
"""

from collections.abc import Callable, Iterator

from mpi4py import MPI

import numpy as np
from numpy.typing import ArrayLike

from .partition import Partition, Place

# (3,) or (k, 3), or a function of the load level or time that gives it
Goal = ArrayLike | Callable[[float], ArrayLike]

AXES = {"x": 0, "y": 1, "z": 2}


class Supports:
    """Conditions on the nodes of a partition, in local numbering (owned and ghost).

    Attributes
    ----------
    Q : (n, 3, 3), rows are the axes of each node's displacement unknowns
    held : (n, 5) bool, unknowns with a prescribed value
    inclined : (n,) bool, nodes whose axes are not the world's
    plane : (n, 3), normal of the plane that guides a director, NaN where none
    frozen : bool, set once a solver has taken the supports over: then none can be added
    """

    def __init__(self, partition: Partition):
        self.partition = partition
        n = partition.n_local
        self.Q = np.tile(np.eye(3), (n, 1, 1))
        self.held = np.zeros((n, 5), bool)
        self.inclined = np.zeros(n, bool)
        self.plane = np.full((n, 3), np.nan)
        self.frozen = False
        self.motions: list[
            tuple
        ] = []  # (local nodes, components, displacement(level), director(level))

    def clamp(self, where: Place) -> None:
        """Hold displacement and director."""
        self.hold(where)
        self.hold_director(where)

    def symmetry(self, where: Place, normal: ArrayLike) -> None:
        """Edge on a plane of symmetry: neither nodes nor directors leave it."""
        self.hold_normal(where, normal)
        self.hold_director(where, plane=normal)

    def hold(self, where: Place, components: str = "xyz") -> None:
        """Hold displacement components, 'x', 'yz', ... of the nodes at a place."""
        if not isinstance(components, str):
            raise ValueError(f"displacement components are a string as 'xz', not {components!r}")
        unknown = set(components) - set(AXES)
        if unknown or not components:
            raise ValueError(f"displacement components are x, y, z, not '{components}'")
        local = self._local(where)
        upright, inclined = local[~self.inclined[local]], local[self.inclined[local]]
        for c in components:
            self.held[upright, AXES[c]] = True
            for node in inclined:
                self._hold_direction(node, np.eye(3)[AXES[c]])

    def hold_normal(self, where: Place, normal: ArrayLike) -> None:
        """Hold the displacement along one direction (3,) of any inclination."""
        normal = unit(normal)
        for node in self._local(where):
            self._hold_direction(node, normal)

    def hold_director(self, where: Place, plane: ArrayLike | None = None) -> None:
        """Hold the director, or with `plane` (3,) a normal: let it turn in that plane only."""
        local = self._local(where)
        if plane is None:
            self.held[local, 3:] = True
            return
        plane = unit(plane)
        partition = self.partition
        # on the whole surface, so that every rank raises or none does
        nodes = partition.find(where)
        lean = np.abs(np.asarray(partition.surface.directors)[nodes] @ plane)
        if lean.max() > 0.3:
            worst = int(lean.argmax())
            raise ValueError(
                f"node {nodes[worst]} of {partition.surface.source} cannot keep its director in "
                f"the plane with normal {plane.tolist()}: it leans out by "
                f"{np.degrees(np.arcsin(min(1.0, lean[worst]))):.0f} degrees"
            )
        for node in local:
            known = self.plane[node]
            if np.isfinite(known[0]) and abs(abs(known @ plane) - 1) > 1e-12:
                self.held[node, 3:] = True  # two planes leave one direction
            else:
                self.plane[node], self.held[node, 4] = plane, True
            d = partition.directors[node]
            off = d @ plane
            # directors averaged over one side of the plane only lean a little: put them in it
            d = d - off * plane
            partition.directors[node] = d / np.linalg.norm(d)

    def move(
        self, where: Place, displacement: Goal | None = None, director: Goal | None = None
    ) -> None:
        """Hold all displacements of nodes, or their directors, to functions of the load level.

        A displacement holds x, y and z: an edge that is pulled cannot narrow by itself.

        Parameters
        ----------
        where : as in `Partition.find`
        displacement : (3,), (k, 3) float or callable(level or time) returning such [m]
            An array is reached in proportion to the load level: for statics only. Rows follow the
            sorted node numbers.
        director : callable(level) -> (3,) or (k, 3) unit vectors, or None (stays)
        """
        self._check_open()
        if displacement is None and director is None:
            raise ValueError("move needs a displacement, a director, or both")
        partition = self.partition
        nodes = partition.find(where)
        rows = np.flatnonzero(partition.local_numbers[nodes] >= 0)
        local = partition.local_numbers[nodes[rows]]
        if partition.comm.allreduce(bool(self.inclined[local].any()), op=MPI.LOR):
            raise ValueError(
                "a node that slides in an inclined plane cannot also follow a prescribed motion"
            )
        if director is not None and not callable(director):
            raise ValueError("a prescribed director is a function of the level, not a constant")
        if displacement is not None and not callable(displacement):
            goal = np.array(displacement, float)
            if goal.shape not in ((3,), (len(nodes), 3)) or not np.all(np.isfinite(goal)):
                raise ValueError(
                    f"a prescribed displacement is (3,) or ({len(nodes)}, 3) finite numbers in m, "
                    f"not {goal.tolist()}"
                )
            displacement = _Proportional(goal)
        if displacement is not None:
            self.held[local, :3] = True
        if director is not None:
            self.held[local, 3:] = True
        self.motions.append((local, rows, displacement, director))

    def prescribed(self, level: float) -> Iterator[tuple]:
        """Yield (local nodes, displacements or None, directors or None) at a load level.

        ValueError, on all ranks, where a function gives what is no finite number.
        """
        for local, rows, displacement, director in self.motions:
            u = None if displacement is None else _rows(displacement, level, rows)
            d = None if director is None else _rows(director, level, rows)
            yield local, u, d

    def steady_goals(self) -> bool:
        """True if some displacement is given as an array, which says nothing about time."""
        return any(isinstance(motion[2], _Proportional) for motion in self.motions)

    def freeze(self) -> None:
        """Take no more supports: a solver has taken these over."""
        self.frozen = True

    def _check_open(self):
        if self.frozen:
            raise ValueError("give all supports before the solver is made; it has taken these over")

    def _local(self, where):
        self._check_open()
        return self.partition.local(self.partition.find(where))

    def _hold_direction(self, node, direction):
        held = self.held[node, :3]
        fixed = self.Q[node][held]
        rest = direction - fixed.T @ (fixed @ direction)
        size = np.linalg.norm(rest)
        if size < 1e-9:
            return
        rest /= size
        axis = int(np.abs(rest).argmax())
        if not self.inclined[node] and abs(abs(rest[axis]) - 1) < 1e-12:
            held[axis] = True
            return
        # rows: what was held, the new direction, then any completion
        rows = [*fixed, rest]
        basis = np.linalg.qr(np.column_stack([*rows, np.eye(3)]))[0][:, :3].T
        basis[: len(rows)] = rows
        self.Q[node], self.inclined[node] = basis, True
        self.held[node, :3] = np.arange(3) < len(rows)


class _Proportional:
    """A displacement reached in proportion to the load level."""

    def __init__(self, goal):
        self.goal = goal

    def __call__(self, level):
        return level * self.goal


def unit(vector: ArrayLike) -> np.ndarray:
    """Unit vector (3,) along `vector`; ValueError unless it has three finite numbers, not all 0."""
    vector = np.asarray(vector, float)
    if vector.shape != (3,) or not np.all(np.isfinite(vector)) or not vector.any():
        raise ValueError(f"a direction is three finite numbers, not all zero, not {vector}")
    return vector / np.linalg.norm(vector)


def _rows(motion, level, rows):
    values = np.asarray(motion(level), float)
    if not np.isfinite(values).all():  # of all nodes, so that all ranks raise or none does
        raise ValueError(f"a prescribed motion gives no finite numbers at level or time {level:g}")
    return np.broadcast_to(values, (len(rows), 3)) if values.ndim == 1 else values[rows]
