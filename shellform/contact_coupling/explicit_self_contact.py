# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contact of a sheet with itself in explicit steps: its turn between the kick and the drift.

Gives the nodes of all ranks to `SelfContactSolver` and books what it did. Cells of four nodes are
two triangles each, cut along the diagonal that is shorter at rest (the first of equal ones), those
of nine nodes their four quarters.

Ranks: every rank finds and solves all pairs, in the user's numbering, so that the result is the
same on any number of them. A step in which nothing can touch costs one reduction; any other gathers
nine numbers a node, and three more for the books; its pairs are not shared out.

With a body (`meet`): self-contact first, which knows what the body makes of it (body_response.py),
then the body, which has the last word.
"""

import time
from pathlib import Path
from typing import Any, Self

from mpi4py import MPI

import numpy as np

from contact.self_contact.features import features
from contact.self_contact.intersections import count_intersections
from contact.self_contact.row_impulses import give
from contact.self_contact.rows import ROW
from contact.self_contact.solver import SelfContactSolver
from contact.solver.friction import Friction, as_friction
from meshes import Surface
from meshes.topology import cut_quads, straight_cells
from shellform.dynamics.part import Part

from .body_response import response


def triangles_of(surface: Surface) -> np.ndarray:
    """Triangles (m, 3) int of the cells of a surface, in their order."""
    cells = straight_cells(surface.cells)
    if cells.shape[1] == 3:
        return cells
    x = surface.points[cells]
    one, other = (np.linalg.norm(x[:, k] - x[:, k + 2], axis=1) for k in range(2))
    return cut_quads(cells, other < one * (1 - 1e-9))


class ExplicitSelfContact(Part):
    """Contact of a sheet with itself; `stepper.add(SelfContact())` makes it.

    Parameters
    ----------
    stepper : Stepper, explicit; how : SelfContact

    Attributes
    ----------
    pairs : int, in the last step; most_pairs : in any; limited : steps whose impulses were left
        with more than a thousandth of the speeds they change; listings : searches so far
    closest : float [m], least distance of a pair that was near the thickness, inf without one
    thickness : float [m]; friction : Friction, may be changed
    losses : (2,) float [J], of impact and of friction so far, the same on every rank
    seconds : float, time it has cost
    held : (n_owned, 3) bool, components that supports hold
    own : slice, of this rank's nodes among those of all ranks
    """

    def __init__(self, stepper: Any, how: Any):
        shell = stepper.shell
        surface, partition = shell.surface, shell.partition
        thickness = shell.fabric.thickness if how.thickness is None else float(how.thickness)
        self._comm = shell.comm
        held = np.ascontiguousarray(shell.supports.held[: stepper.n_owned, :3])
        self.held = held
        counts = self._comm.allgather(stepper.n_owned)
        begin = sum(counts[: self._comm.rank])
        self.own = slice(begin, begin + stepper.n_owned)
        self._counts = np.array(counts)
        order = np.concatenate(self._comm.allgather(partition.owned_nodes))
        whole = self.whole(np.column_stack([stepper.mass, held]))
        self.solver = SelfContactSolver(
            features(triangles_of(surface), order), surface.points[order], whole[:, 0].copy(),
            whole[:, 1:] > 0.5, thickness, as_friction(how.friction), how.recovery,
            surface.mean_cell_size, self.own,
        )  # fmt: skip
        self.thickness = thickness
        self._x = np.empty((stepper.n_owned, 3))
        self._before = self._x  # velocities of all nodes in the last step, while rows are solved
        n = 0 if self._comm.size == 1 else len(order)
        # kept: memory that is new in every step costs ten times the exchange of large meshes
        self._exchanged = np.empty((3, len(self._x), 3)), np.empty(9 * n), np.empty((3, n, 3))
        self.pairs = self.most_pairs = 0
        self.losses, self.seconds = np.zeros(2), 0.0

    @property
    def friction(self) -> Friction:
        """Its law; may be changed between steps."""
        return self.solver.friction

    @friction.setter
    def friction(self, value: Any) -> None:
        self.solver.friction = as_friction(value)

    @property
    def limited(self) -> int:
        return self.solver.limited

    @property
    def listings(self) -> int:
        return self.solver.listings

    @property
    def closest(self) -> float:
        return self.solver.closest

    def attach(self, stepper: Any) -> Self:
        """Start to run with a stepper; returns self."""
        self.join(stepper)
        stepper.parts.append(self)
        return self

    def join(self, stepper: Any) -> None:
        """Belong to a stepper without a turn of its own; ValueError if it has such a contact."""
        self._take(stepper)
        stepper.set_self_contact(self)

    def __call__(self, stepper: Any, dt: float) -> None:
        np.add(stepper.points, stepper.owned[:, :3], out=self._x)
        if self.push(stepper, self._x, dt):
            self.book(stepper)

    def push(self, stepper: Any, x: np.ndarray, dt: float, body: Any = None) -> bool:
        """Change the velocities so that layers keep their distance; whether any came near.

        x : (n_owned, 3), positions [m]; body : VelocityCorrection of the nodes, or None; all
        ranks call
        """
        start, comm, solver = time.perf_counter(), self._comm, self.solver
        v, region, met = stepper.v, solver.region, False
        moved = region.measure(x, stepper.v_old)
        if comm.size > 1:
            comm.Allreduce(MPI.IN_PLACE, moved, MPI.MAX)
        if solver.needs(dt):
            respond = None if body is None else response(body, self, stepper, x, dt)
            places, free, before = self.everywhere(x, v, stepper.v_old)
            self._before = before
            met = solver.solve(places, free, before, dt, respond)
        self.pairs = len(solver.rows)
        self.most_pairs = max(self.most_pairs, self.pairs)
        if met:
            give(solver.rows, self.own.start, self.held, stepper.mass, v, stepper.support_impulse)
        self.seconds += time.perf_counter() - start
        return met

    def book(self, stepper: Any) -> None:
        """Add the losses of the last step, once all have had their say; all ranks call."""
        start = time.perf_counter()
        self.solver.book(self._before, self.whole(stepper.v), self.losses)
        self.seconds += time.perf_counter() - start

    def everywhere(self, *owned: np.ndarray) -> Any:
        """Three vectors (n, 3) of all nodes from those (n_owned, 3) of each rank, in one exchange.

        The next call overwrites them.
        """
        if self._comm.size == 1:
            return owned
        mine, gathered, together = self._exchanged
        np.stack(owned, out=mine)
        self._comm.Allgatherv(mine, [gathered, 9 * self._counts, MPI.DOUBLE])
        begin = 0
        for count in self._counts:
            end = begin + count
            together[:, begin:end] = gathered[9 * begin : 9 * end].reshape(3, count, 3)
            begin = end
        return together

    def whole(self, owned: np.ndarray) -> np.ndarray:
        """Values (n, k) of all nodes, rank after rank, from those (n_owned, k) of each.

        All ranks call. On one rank they are given back.
        """
        if self._comm.size == 1:
            return owned
        width = owned.shape[1]
        gathered = np.empty((self._counts.sum(), width))
        self._comm.Allgatherv(
            np.ascontiguousarray(owned, float), [gathered, self._counts * width, MPI.DOUBLE]
        )
        return gathered

    def intersections(self) -> int:
        """Edges that pass through triangles at present; all ranks call."""
        stepper, f = self.stepper, self.solver.features
        x = np.ascontiguousarray(self.whole(stepper.points + stepper.owned[:, :3]))
        return count_intersections(x, f.triangles, f.edges, f.sides, f.owns)

    def state(self) -> Any:
        """See Part."""
        return self.solver.kept.copy(), self.losses.copy()

    def restore(self, state: Any) -> None:
        """Continue from `state()`."""
        rows, self.losses[:] = state
        self.solver.restore(rows)

    def saved(self) -> dict[str, Any]:
        """See Part."""
        rows = self.solver.kept
        counts = [self.most_pairs, self.limited, self.listings, self.closest]
        return {
            "self_contact_keys": rows["key"].copy(),
            "self_contact_push": rows["push"].copy(),
            "self_contact_rub": np.concatenate(
                [rows["rub"], rows["tangents"].reshape(len(rows), 6)], axis=1
            ),
            "self_contact_losses": self.losses.copy(),
            "self_contact_counts": np.array(counts, float),
        }

    def resume(self, path: str | Path, state: dict[str, np.ndarray]) -> None:
        """Go on from what `saved` has put into a file; all ranks call.

        Raises
        ------
        ValueError where it holds nothing of self-contact
        """
        if "self_contact_keys" not in state:
            raise ValueError(
                f"{path} holds no state of cloth on cloth: go on with the scene it was written with"
            )
        rows = np.zeros(len(state["self_contact_keys"]), ROW)
        rows["key"], rows["push"] = state["self_contact_keys"], state["self_contact_push"]
        rub = state["self_contact_rub"]
        rows["rub"], rows["tangents"] = rub[:, :2], rub[:, 2:].reshape(-1, 2, 3)
        self.solver.restore(rows)
        self.losses[:] = state["self_contact_losses"]
        most, limited, listings, closest = state["self_contact_counts"].tolist()
        self.most_pairs, self.solver.closest = int(most), closest
        self.solver.limited, self.solver.listings = int(limited), int(listings)
