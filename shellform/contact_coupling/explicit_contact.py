# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contact of a shell in explicit steps: the hook between the kick and the drift, Eqs. 15 and 16.

Gives the arrays of a stepper's owned nodes to `contact.Correction` and books what it did. Cloth is
met at half its thickness from the mid-surface.

Where: at the nodes. The strains of 4-node quads follow the arcs between nodes, so nodes on the body
are the sheet on the body. `samples=k` meets k x k points inside every cell besides, on its chords
(contact/solver/cell_samples.py): for bodies thin enough to pass between nodes, at the price of
nodes that stand off by h^2/(8 R) where cells bend around a body.
`demos/strip_over_cylinder.py` measures both.

Components of the displacement that a support holds are left to it: what contact would give them
goes to the support. Nodes held in all three are not met.
"""

import time

import numpy as np

from contact.solver.cell_samples import (
    book_loss,
    collect,
    midpoints,
    particle_masses,
    shares,
    spread,
    too_thin,
)
from contact.solver.velocity_correction import Correction
from shellform.fem.dolfinx_compat import Function, add_ghosts, cell_nodes, vector_space
from shellform.fem.partition import DOLFINX_ORDER


class Touch:
    """Hook of a `Stepper`: contact of a sheet with a body.

    Parameters
    ----------
    stepper : Stepper, explicit
    body : contact.body.segments.Body
    friction : float or (mu_s, mu_k)
    offset : float [m] or None: half the fabric's thickness
    samples : "nodes" or 0: the nodes alone; k: also k x k points inside every 4-node cell
    flesh_stiffness : float [Pa/m] or None: of the body where two parts of it press cloth against
        each other (contact/solver/soft_crease.py); None: hard

    Attributes
    ----------
    correction : contact.Correction, with its counters and ledgers, those of samples included
    inner : Correction of the samples, or None
    seconds : float, spent in contact
    notes : list of str, ellipsoids that can pass between the points that are met

    Raises
    ------
    ValueError if samples are asked for in cells that have not four nodes
    """

    def __init__(
        self, stepper, body, friction=0.3, offset=None, samples="nodes", flesh_stiffness=None
    ):
        n = stepper.n_owned
        offset = 0.5 * stepper.shell.fabric.thickness if offset is None else offset
        self._held = np.ascontiguousarray(stepper.shell.supports.held[:n, :3])
        fixed = self._held.all(axis=1)
        self._guided = np.flatnonzero(self._held.any(axis=1) & ~fixed)
        areal = stepper.shell.fabric.areal_mass
        self._pinch = {"flesh": flesh_stiffness / areal} if flesh_stiffness else {}
        self.correction = Correction(body, n, friction, offset, fixed=fixed, **self._pinch)
        self._x, self.seconds = np.empty_like(stepper.points), 0.0
        self.inner = None
        if not (isinstance(samples, str) and samples == "nodes") and samples != 0:
            self._inside(stepper, body, friction, offset, midpoints(samples))
        k = 0 if isinstance(samples, str) else samples
        size = stepper.shell.surface.mean_cell_size
        self.notes = too_thin(body.names, body.radii, size, offset, k)
        stepper.hooks.append(self)
        stepper.keep_old_velocities()

    def _inside(self, stepper, body, friction, offset, weights):
        """Prepare samples in the cells of this rank; some of their nodes may be ghosts."""
        partition, surface = stepper.shell.partition, stepper.shell.surface
        if surface.cells.shape[1] != 4:
            raise ValueError(
                f"samples inside cells need cells of four nodes; those of {surface.source} have "
                f"{surface.cells.shape[1]}: leave `samples` out"
            )
        self._weights = weights
        share = shares(surface.cells[:, DOLFINX_ORDER[4]], weights, len(surface.points))
        self._cells = cell_nodes(partition.space).astype(np.int64)
        # nodal fields that ranks exchange: x, v, v before the forces, and the bits of `allowed`
        self._field = Function(vector_space(partition.mesh, "Lagrange", 1, 10))
        self._nodal = self._field.x.array.reshape(-1, 10)
        self._nodal[: partition.n_owned, 0] = self._held.all(axis=1)
        self._nodal[: partition.n_owned, 1] = stepper.mass
        self._field.x.scatter_forward()
        fixed, mass = self._nodal[:, 0] > 0.5, self._nodal[:, 1]
        self._mass = particle_masses(self._cells, weights, share[partition.nodes], mass, fixed)
        k = len(self._mass)
        still = ~np.isfinite(self._mass)
        self._mass[still] = 1.0
        self._points, self._after = np.empty((k, 9)), np.empty((k, 9))
        self._free = np.empty_like(stepper.v)
        self.inner = Correction(body, k, friction, offset, fixed=still, **self._pinch)

    def __call__(self, stepper, dt):
        start = time.perf_counter()
        v, last = stepper.v, self.correction.last
        np.add(stepper.points, stepper.owned[:, :3], out=self._x)
        if self.inner is not None:
            np.copyto(self._free, v)
        self.correction(self._x, v, stepper.mass, dt, stepper.time, v_old=stepper.v_old)
        if len(self._guided):
            self._give_back(stepper, last.impulse, book=True)
        if self.inner is not None:
            self._meet_inside(stepper, dt)
        self.seconds += time.perf_counter() - start

    def _give_back(self, stepper, impulse, book=False):
        """Held components of guided nodes keep their velocity; the supports take the impulse."""
        g, correction = self._guided, self.correction
        taken = np.where(self._held[g], impulse[g], 0.0)
        if not taken.any():
            return
        met = stepper.v[g]
        stepper.v[g] = met - taken / stepper.mass[g, None]
        stepper.support_impulse[g] -= taken
        if book:
            lost = np.zeros_like(correction.last.table)
            book_loss(taken, met, stepper.v[g], correction.segment[g], lost)
            correction.last.table += lost
            correction.window.table += lost

    def _meet_inside(self, stepper, dt):
        """Contact of the samples, after that of the nodes."""
        outer, inner, n = self.correction, self.inner, stepper.n_owned
        nodal, points, cells, weights = self._nodal, self._points, self._cells, self._weights
        if inner.friction != outer.friction:
            inner.friction = outer.friction
        nodal[:n, :3], nodal[:n, 3:6] = self._x, stepper.v
        # as if contact of the nodes had come before this step: works then add up
        nodal[:n, 6:9] = stepper.v - self._free + stepper.v_old
        nodal[:n, 9] = outer.allowed.view(float)  # copied, never calculated with
        self._field.x.scatter_forward()
        collect(nodal, cells, weights, points)
        allowed = np.bitwise_and.reduce(nodal[:, 9].copy().view(np.int64)[cells], axis=1)
        inner.allowed[:] = np.repeat(allowed, len(weights))
        x, u, old = (np.ascontiguousarray(points[:, c : c + 3]) for c in (0, 3, 6))
        inner(x, u, self._mass, dt, stepper.time, v_old=old)

        # impulses to the nodes, those of ghosts to their owners
        nodal[:] = 0.0
        spread(inner.last.impulse, cells, weights, nodal)
        add_ghosts(self._field)
        impulse = nodal[:n, :3].copy()
        moved = np.where(outer.fixed[:, None], 0.0, impulse)
        stepper.v += moved / stepper.mass[:, None]
        stepper.support_impulse -= impulse - moved
        if len(self._guided):
            self._give_back(stepper, moved)
        nodal[:n, 3:6] = stepper.v
        self._field.x.scatter_forward()
        collect(nodal, cells, weights, self._after)
        book_loss(inner.last.impulse, u, self._after[:, 3:6], inner.segment, inner.last.table)
        for ledger in (outer.last, outer.window):
            ledger.table += inner.last.table
            ledger.impulse += impulse
        outer._counts += inner._counts
        outer.max_depth = max(outer.max_depth, inner.max_depth)
        outer.pinch_depth = max(outer.pinch_depth, inner.pinch_depth)

    def state(self):
        """What the next step needs to know of this one, for `restore` (copies)."""
        inner = None if self.inner is None else self.inner.state()
        return {"nodes": self.correction.state(), "inner": inner}

    def restore(self, state):
        """Continue from `state()`."""
        self.correction.restore(state["nodes"])
        if self.inner is not None:
            self.inner.restore(state["inner"])
