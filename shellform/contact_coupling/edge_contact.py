# SPDX-License-Identifier: LGPL-3.0-or-later
"""Edges and cells that meet segments thin enough to pass between nodes: rods, blades, tips.

Explicit steps only. Which segments these are: contact/solver/thin_segments.py.

After the contact of nodes: every edge and cell near such a segment meets it at its nearest point
(contact/solver/cell_pairs.py), all edges at once (contact/solver/pair_impulses.py). Nothing is kept
from step to step but the list of what is near. An edge of two ranks' cells is met by the rank that
has the first of them.
"""

from typing import Any

from mpi4py import MPI

import numpy as np

from contact.solver.broad_phase import surface_motion
from contact.solver.cell_pairs import CORNERS, PAIR, farthest, find_pairs, list_near
from contact.solver.pair_impulses import (
    LEFT,
    PASSES,
    add_shares,
    book_pairs,
    pass_kernel,
    set_masses,
)
from contact.solver.thin_segments import STRETCH, spans
from contact.solver.velocity_correction import VelocityCorrection
from meshes import Surface
from meshes.topology import directed_edges, straight_cells
from shellform.fem.dolfinx_compat import Function, add_ghosts, vector_space

SKIN = 0.5  # of the mean size of the cells: pairs within it are listed
OLD, ALLOWED = slice(6, 9), 9  # places among a node's numbers, after x and v
WIDTH = 10


def pieces_of(surface: Surface) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Edges of all cells, once each, and the cells; 9-node cells are met as their quarters.

    Returns
    -------
    pieces (e, 4) int, nodes, then -1; the first cell (e,) int that has each; the largest span (e,)
    of the cells, or quarters, that have it [m], see thin_segments.py
    """
    cells = straight_cells(surface.cells)
    span, corners = spans(surface.points, cells), cells.shape[1]
    ends = np.sort(directed_edges(cells), axis=1)
    edges, first, number = np.unique(ends, axis=0, return_index=True, return_inverse=True)
    widest = np.zeros(len(edges))
    np.maximum.at(widest, number.ravel(), np.repeat(span, corners))
    pieces = np.full((len(edges) + len(cells), CORNERS), -1)
    pieces[: len(edges), :2], pieces[len(edges) :, :corners] = edges, cells
    cell = np.concatenate([first // corners, np.arange(len(cells))])
    return pieces, cell // (len(cells) // len(surface.cells)), np.concatenate([widest, span])


class EdgeContact:
    """Contact of the edges of a stepper's sheet.

    Parameters
    ----------
    stepper : explicit; nodes : VelocityCorrection of its nodes; offset, recovery : see Contact

    Attributes
    ----------
    active : int, pieces that were pushed in the last step; max_depth : float [m], deepest start
    pairs : (k,) PAIR of the last step, those of this rank; impulse : (n_owned, 3), what all ranks'
        gave to the nodes [N s]
    """

    def __init__(
        self, stepper: Any, nodes: VelocityCorrection, offset: float, recovery: float
    ) -> None:
        shell = stepper.shell
        partition, surface = shell.partition, shell.surface
        self.active, self.max_depth = 0, 0.0
        self.pairs, self.impulse = np.zeros(0, PAIR), np.zeros((stepper.n_owned, 3))
        self._comm, self._nodes = shell.comm, nodes
        self._offset, self._recovery = float(offset), float(recovery)
        pieces, first, widest = pieces_of(surface)
        own = np.isin(first, partition.cells)
        numbers = np.append(partition.local_numbers, -1)  # of no node: -1 again
        self._pieces = np.ascontiguousarray(numbers[pieces[own]])
        self._widths, self._skin = STRETCH * widest[own], SKIN * surface.mean_cell_size
        n, m = partition.n_owned, partition.n_local
        self._held = np.ascontiguousarray(shell.supports.held[:n, :3])
        self._numbers = Function(vector_space(partition.mesh, "Lagrange", surface.degree, WIDTH))
        self._change = Function(vector_space(partition.mesh, "Lagrange", surface.degree, 3))
        self._share = Function(vector_space(partition.mesh, "Lagrange", surface.degree, 1))
        values = self._numbers.x.array.reshape(m, WIDTH)
        values[:n, 0], values[:n, 1] = self._held.all(axis=1), stepper.mass
        self._numbers.x.scatter_forward()
        self._fixed, self._mass = values[:, 0] > 0.5, values[:, 1].copy()
        self._place = np.full((m, 3), np.inf)  # where the list was made
        self._listed, self._near = np.empty((64, 2), np.int64), 0
        self._pairs, self._way, self._time = np.zeros(64, PAIR), 0.0, np.nan

    def meet(self, stepper: Any, x: np.ndarray, free: np.ndarray, dt: float) -> np.ndarray | None:
        """Contact of a step; changes and books as that of nodes does; all ranks call.

        x, free : (n_owned, 3), positions [m], velocities before any contact [m/s]

        Returns the impulses on the nodes (n_owned, 3) [N s] and the table of the segments, None
        where no edge is near.
        """
        n, numbers = stepper.n_owned, self._numbers
        values = numbers.x.array.reshape(-1, WIDTH)
        values[:n, :3], values[:n, 3:6] = x, stepper.v
        # as if contact of the nodes had come before this step: works then add up
        values[:n, OLD] = stepper.v - free + stepper.v_old
        # sets of segments are copied, never calculated with
        values[:n, ALLOWED] = (self._nodes.allowed & ~self._nodes.penetrated).view(float)
        numbers.x.scatter_forward()
        pairs = self._find(values, stepper.time, dt)
        self.active, self.max_depth = 0, 0.0
        self.pairs, self.impulse[:] = pairs, 0.0
        if self._comm.allreduce(len(pairs)) == 0:
            return None
        return self._push(stepper, pairs, values, dt)

    def _find(self, values, time, dt):
        """Pairs that can meet in this step."""
        segments = self._nodes.segments
        x, v = np.ascontiguousarray(values[:, :3]), np.ascontiguousarray(values[:, 3:6])
        motion = surface_motion(segments, self._offset)[0]
        reach = dt * farthest(v, np.zeros_like(v)) + motion
        if time != self._time or not farthest(x, self._place) + self._way + reach <= self._skin:
            self._list(x, max(self._skin, 2.0 * reach), segments)
        self._way += motion
        self._time = time + dt
        allowed = values[:, ALLOWED].copy().view(np.int64)
        found = find_pairs(
            x, v, allowed, self._pieces, self._listed[: self._near], segments, dt, self._offset,
            self._recovery * dt, self._pairs,
        )  # fmt: skip
        return self._pairs[:found]

    def _list(self, x, skin, segments):
        while True:
            near = list_near(
                x, self._pieces, self._widths, segments, self._offset, min(skin, 1e9), self._listed
            )
            if near <= len(self._listed):
                break
            self._listed, self._pairs = np.empty((2 * near, 2), np.int64), np.zeros(2 * near, PAIR)
        self._near, self._way = near, 0.0
        self._place[:] = x

    def _push(self, stepper, pairs, values, dt):
        """Passes over all pairs, and what they gave."""
        n, friction = stepper.n_owned, self._nodes.friction
        one_pass = pass_kernel(friction.kinetic_coefficient)
        parameters = np.array(friction.parameters, float)
        change, impulse = self._change.x.array.reshape(-1, 3), self.impulse
        v = np.ascontiguousarray(values[:, 3:6])
        share, lacked = self._share.x.array, 0.0
        least = PASSES[0] if friction.parameters[0] > 0.0 else 1
        for done in range(PASSES[1]):
            share[:] = 0.0
            worst = self._comm.allreduce(add_shares(pairs, v, dt, share), MPI.MAX)
            lacked = max(lacked, worst)
            if done >= least and worst <= LEFT * lacked:
                break
            add_ghosts(self._share)
            self._share.x.scatter_forward()
            set_masses(pairs, share, self._mass, self._fixed)
            change[:] = 0.0
            one_pass(pairs, v, dt, parameters, change)
            add_ghosts(self._change)
            impulse += change[:n]
            change[:n] = np.where(self._held, 0.0, change[:n])
            self._change.x.scatter_forward()
            v += change / self._mass[:, None]
        stepper.v[:] = v[:n]
        stepper.support_impulse -= np.where(self._held, impulse, 0.0)
        table = np.zeros_like(self._nodes.last.table)
        old = np.ascontiguousarray(values[:, OLD])
        self.active, self.max_depth = book_pairs(pairs, old, v, dt, self._nodes.segments, table)
        return impulse, table
