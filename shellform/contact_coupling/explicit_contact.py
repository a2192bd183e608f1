# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contact of a shell in explicit steps: its turn between the kick and the drift, Eqs. 15 and 16.

Gives the arrays of a stepper's owned nodes to `VelocityCorrection` and books what it did. Cloth is
met at half its thickness from the mid-surface.

Where: at the nodes. The strains of 4-node quads follow the arcs between nodes, so nodes on the body
are the sheet on the body. `samples=k` meets k x k points inside every cell besides, on its chords
(contact/solver/cell_samples.py), at the price of nodes that stand off by h^2/(8 R) where cells bend
around a body. `demos/strip_over_cylinder.py` measures both.

Segments thin enough to pass between nodes are met by edges and cells too (edge_contact.py).

Components of the displacement that a support holds are left to it: what contact would give them
goes to the support. Nodes held in all three are not met.
"""

import time
from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from typing import Any, Self

import numpy as np

from contact.body.flesh_bed import Flesh
from contact.body.segments import Body
from contact.body.surface_motion import SurfaceMotion
from contact.kernel import kernel
from contact.solver.cell_samples import (
    collect,
    midpoints,
    particle_masses,
    shares,
    spread,
)
from contact.solver.contact_ledger import WORK, book_loss
from contact.solver.friction import Friction
from contact.solver.thin_segments import spans, thin_segments
from contact.solver.velocity_correction import VelocityCorrection
from meshes.topology import straight_cells
from shellform.dynamics.part import RunningContact
from shellform.fem.dolfinx_compat import Function, add_ghosts, cell_nodes, vector_space
from shellform.fem.partition import DOLFINX_ORDER

from . import contact_checkpoint
from .pressed_cells import PressedCells


@kernel
def positions(points: np.ndarray, owned: np.ndarray, x: np.ndarray) -> None:
    """Fill x (n, 3) [m] from the points at rest (n, 3) and the dofs (n, 6), displacements first."""
    for i in range(len(x)):
        x[i, 0] = points[i, 0] + owned[i, 0]
        x[i, 1] = points[i, 1] + owned[i, 1]
        x[i, 2] = points[i, 2] + owned[i, 2]


def thin_to(cloth: Any, body: Body, offset: float) -> list[int]:
    """Numbers of the segments of a body that pass between nodes of a sheet's surface."""
    span = spans(cloth.points, straight_cells(cloth.cells)).max()
    return thin_segments(body.shapes, span, offset)


class ExplicitContact(RunningContact):
    """Contact of a sheet with a body in explicit steps; `stepper.add(Contact(body))` makes it.

    Parameters
    ----------
    stepper : Stepper, explicit
    body, friction, offset, samples, flesh_stiffness, recovery, flesh, surface, smooth,
        shapes : see Contact
    self_contact : SelfContact or None

    Attributes
    ----------
    body, last, window, ... : see RunningContact
    correction : VelocityCorrection, SurfaceCorrection or UnionCorrection, with its counters and
        ledgers, those of samples included
    inner : VelocityCorrection of the samples, or None; cells : (k, 4), the nodes of their cells
    pressed : PressedCells of a relaxed sheet on several segments, or None
    edges : EdgeContact, or None where no segment can pass between nodes
    cloth : ExplicitSelfContact, or None where the sheet does not meet itself

    Raises
    ------
    ValueError if samples are asked for in cells that have not four nodes
    """

    def __init__(
        self,
        stepper: Any,
        body: Any,
        friction: Any,
        offset: float | None,
        samples: int | str,
        flesh_stiffness: float | None,
        recovery: float,
        flesh: Flesh | None = None,
        surface: SurfaceMotion | None = None,
        smooth: bool = True,
        shapes: Sequence[str] = (),
        self_contact: Any = None,
    ) -> None:
        n = stepper.n_owned
        offset = 0.5 * stepper.shell.fabric.thickness if offset is None else offset
        self._held = np.ascontiguousarray(stepper.shell.supports.held[:n, :3])
        fixed = self._held.all(axis=1)
        self._guided = np.flatnonzero(self._held.any(axis=1) & ~fixed)
        areal = stepper.shell.fabric.areal_mass
        self._flesh = flesh_stiffness or np.inf
        self.watches_beds = False
        thin = [] if surface is not None else thin_to(stepper.shell.surface, body, offset)
        self._how: dict[str, Any] = {"recovery": recovery}
        if flesh_stiffness:
            self._how["flesh"] = flesh_stiffness / areal
        self.flesh = flesh
        self.correction: Any
        if surface is not None:
            # its kernels are loaded for surfaces only
            from .surface_contact import correction_of

            self.correction = correction_of(
                surface, body, n, friction, offset, fixed, recovery, smooth, samples,
                flesh_stiffness, shapes, flesh, areal,
            )  # fmt: skip
        elif flesh is not None:
            # its kernels are loaded for flesh only
            from contact.solver.flesh_correction import FleshCorrection

            self.correction = FleshCorrection(
                body, n, friction, offset, fixed=fixed, flesh=flesh, areal_mass=areal, hard=thin,
                **self._how,
            )  # fmt: skip
        else:
            self.correction = VelocityCorrection(
                body, n, friction, offset, fixed=fixed, **self._how
            )
        self.body, self.last, self.window = body, self.correction.last, self.correction.window
        self.segment = self.correction.segment
        self._x, self.seconds = np.empty_like(stepper.points), 0.0
        self._free = np.empty_like(stepper.v)
        self.inner = None
        k: Any = 0 if samples == "nodes" else samples
        self.edges = self.pressed = None
        self.cloth = None
        if self_contact is not None:
            # only here: its kernels are loaded for those who ask for it
            from .explicit_self_contact import ExplicitSelfContact

            self.cloth = ExplicitSelfContact(stepper, self_contact)
        if surface is not None:
            return
        if k != 0:
            self._inside(stepper, body, friction, offset, midpoints(k))
        if thin:
            # its kernels are loaded for thin segments only
            from .edge_contact import EdgeContact

            self.edges = EdgeContact(stepper, self.correction, offset, recovery)
        if stepper.shell.relaxed and stepper.force_model.turns_directors and len(body.names) > 1:
            self.pressed = PressedCells(stepper)

    def attach(self, stepper: Any) -> Self:
        """Start to meet the sheet of a stepper; returns self."""
        if self.cloth is not None:
            self.cloth.join(stepper)
        elif stepper.self_contact is not None:
            raise ValueError(
                "the cloth of this stepper meets itself already: both go together, say "
                "Contact(body, self_contact=True) alone"
            )
        return super().attach(stepper)

    @property
    def active(self) -> int:
        return self.correction.active + (0 if self.edges is None else self.edges.active)

    @property
    def sticking(self) -> int:
        return self.correction.sticking

    @property
    def pinched(self) -> int:
        return self.correction.pinched

    @property
    def max_depth(self) -> float:
        depth = self.correction.max_depth
        return depth if self.edges is None else max(depth, self.edges.max_depth)

    @property
    def pinch_depth(self) -> float:
        return self.correction.pinch_depth

    @property
    def start_pose(self) -> Any:
        """Pose of the body at the start of the last step."""
        return self.correction.start_pose

    @cached_property
    def bed_stiffness(self) -> np.ndarray:
        """What nodes are bedded on where two parts of the body press them between each other.

        (n_owned,) float [Pa/m], the sum of the `flesh_stiffness` of these parts, infinite for hard
        ones; zero where a node is free or pressed from one side only. Filled in every step from
        when it is first asked for; then it is zero, or what the checkpoint says.
        """
        self.watches_beds = True
        return self.correction.watch_beds(self._flesh)

    @property
    def friction(self) -> Friction:
        """Its law; may be changed between steps."""
        return self.correction.friction

    @friction.setter
    def friction(self, value: Any) -> None:
        self.correction.friction = value

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
        self.cells = cell_nodes(partition.space).astype(np.int64)
        # nodal fields that ranks exchange: x, v, v before the forces, and the bits of `allowed`
        self._field = Function(vector_space(partition.mesh, "Lagrange", 1, 10))
        self._nodal = self._field.x.array.reshape(-1, 10)
        self._nodal[: partition.n_owned, 0] = self._held.all(axis=1)
        self._nodal[: partition.n_owned, 1] = stepper.mass
        self._field.x.scatter_forward()
        fixed, mass = self._nodal[:, 0] > 0.5, self._nodal[:, 1]
        self._mass = particle_masses(self.cells, weights, share[partition.nodes], mass, fixed)
        k = len(self._mass)
        still = ~np.isfinite(self._mass)
        self._mass[still] = 1.0
        self._points, self._after = np.empty((k, 9)), np.empty((k, 9))
        self.inner = VelocityCorrection(body, k, friction, offset, fixed=still, **self._how)

    def __call__(self, stepper: Any, dt: float) -> None:
        start = time.perf_counter()
        v, last = stepper.v, self.correction.last
        positions(stepper.points, stepper.owned, self._x)
        layers = False
        if self.cloth is not None:
            layers = self.cloth.push(stepper, self._x, dt, self.correction)
        if self.inner is not None or self.edges is not None:
            np.copyto(self._free, v)
        self.correction(self._x, v, stepper.mass, dt, stepper.time, v_old=stepper.v_old)
        if len(self._guided):
            self._give_back(stepper, last.impulse, book=True)
        if self.inner is not None:
            self._meet_inside(stepper, dt)
        if self.edges is not None:
            self._meet_edges(stepper, dt)
        if self.pressed is not None:
            work = self.pressed.look(stepper, self.bed_stiffness)
            for ledger in (last, self.window):
                ledger.table[0, WORK] += work
        if layers and self.cloth is not None:
            self.cloth.book(stepper, dt, last.impulse)
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
        nodal, points, cells, weights = self._nodal, self._points, self.cells, self._weights
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
        outer.add_counts(inner)

    def _meet_edges(self, stepper, dt):
        """Contact of edges with thin segments, after that of nodes and samples."""
        met = self.edges.meet(stepper, self._x, self._free, dt)
        if met is None:
            return
        impulse, table = met
        for ledger in (self.last, self.window):
            ledger.table += table
            ledger.impulse += impulse

    def touched(self) -> Any:
        """What the next step needs to know of this one (copies)."""
        inner = None if self.inner is None else self.inner.state()
        pressed = None if self.pressed is None else self.pressed.beds.copy()
        return {"nodes": self.correction.state(), "inner": inner, "pressed": pressed}

    def set_touched(self, touched: Any) -> None:
        """Continue from `touched()`."""
        self.correction.restore(touched["nodes"])
        if self.inner is not None:
            self.inner.restore(touched["inner"])
        if self.pressed is not None:
            # None of particles, whose springs know no wrinkles below their cells
            beds = touched["pressed"]
            self.pressed.restore(self.stepper, 0.0 if beds is None else beds)

    def state(self) -> Any:
        """What is touched and what the window holds, for `restore` (copies)."""
        window, cloth = self.window, None if self.cloth is None else self.cloth.state()
        return self.touched(), window.impulse.copy(), window.table.copy(), window.seconds, cloth

    def restore(self, state: Any) -> None:
        """Continue from `state()`."""
        touched, self.window.impulse[:], self.window.table[:], self.window.seconds, cloth = state
        self.set_touched(touched)
        if self.cloth is not None:
            self.cloth.restore(cloth)

    def saved(self) -> dict[str, Any]:
        """See Part."""
        cloth = {} if self.cloth is None else self.cloth.saved()
        return contact_checkpoint.saved(self) | cloth

    def resume(self, path: str | Path, state: dict[str, np.ndarray]) -> None:
        """See RunningContact; ValueError for other samples than the file has, other versions."""
        contact_checkpoint.resume(self, path, state)
