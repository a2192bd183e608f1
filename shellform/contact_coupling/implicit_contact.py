# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contact under implicit steps: nodes held at the body while it pushes, Eqs. 15 and 16.

The solve of a step finds positions. A node in contact is held in it: in the plane tangent to the
body at its foot (slip, with kinetic friction as a force against it, slip_friction.py) or at its
place on the body (stick). Which nodes are held, and how, is an active set: solved, judged by the
reactions R, solved again until nothing changes. A node that ends inside, or has passed through, is
held; one with R . n <= 0 is released; one that sticks slips where R leaves the cone of static
friction; one that slips sticks where it has not moved. Directions that supports hold are left to
them; their part of the impulses goes to the supports.

The body is one of segments or a surface of triangles (contact/solver/obstacle.py).

The force of contact enters positions as in backward Euler: what stopped a node in one step is not
in the acceleration that the next step starts from, which would make the force ring at +-2 dt. It is
carried on where contact persists, so a node at rest is predicted to rest.

Velocities follow by impulses: v_free, advanced over the step by all forces but contact, becomes
admissible against the velocity of the surface at the end of the step, normals first, then friction
(contact/solver/friction.py). These impulses are booked: momentum closes to roundoff, a node at rest
gets its weight times dt. Positions that were not moved by velocities (the way out, the part of a
step before a node is met) carry no momentum, but forces do work on that way; it is booked with the
impact loss.
"""

import time
from collections.abc import Sequence
from typing import Any

from mpi4py import MPI

import numpy as np

from contact.body.surface_motion import SurfaceMotion
from contact.solver import active_set, held_nodes
from contact.solver.contact_ledger import Ledger
from contact.solver.friction import Friction, as_friction
from contact.solver.held_nodes import FIXED, OPEN, SolvedStep
from contact.solver.node_constraints import constrain
from contact.solver.segment_obstacle import SegmentObstacle
from contact.solver.slip_friction import slip_friction
from contact.solver.step_record import step_record
from contact.solver.thin_segments import refusal, spans
from meshes.topology import straight_cells
from shellform.dynamics.books import BY_SUPPORTS, SUPPORT
from shellform.dynamics.part import RunningContact

ROUNDS = 30  # solves of a step before it counts as failed
NEAR = 1e-6  # of the scene's length: error of the place of a node on a curved surface
SOFT = 0.02  # relative change of friction at which it is settled
STILL = 1e-3  # m/s: slower slip is none, see slip_friction.py
SOFTER = 5  # solves after which it is taken as it is
SMALLEST = 1 / 64  # part of the largest step from which on unsettled contact is taken as it is


class ImplicitContact(RunningContact):
    """Contact of a sheet with a body in implicit steps; `stepper.add(Contact(body))` makes it.

    Parameters
    ----------
    stepper : ImplicitNewmark
    body, friction, offset, recovery, surface, smooth, shapes : see Contact

    Attributes
    ----------
    body, last, window, ... : see RunningContact; active, sticking : nodes held after the last step
    rounds : int, active sets tried so far; unsettled : int, steps taken with a set still changing
    seconds : float, spent outside the solves

    Raises
    ------
    ValueError for midpoint steps, for recovery or offset out of range, and for segments that can
    pass between nodes (contact/solver/thin_segments.py)
    """

    active: int = 0
    sticking: int = 0
    pinched: int = 0
    max_depth: float = 0.0
    pinch_depth: float = 0.0

    def __init__(
        self,
        stepper: Any,
        body: Any,
        friction: Any,
        offset: float | None,
        recovery: float,
        surface: SurfaceMotion | None = None,
        smooth: bool = True,
        shapes: Sequence[str] = (),
    ) -> None:
        n, shell = stepper.n_owned, stepper.shell
        if stepper.instant != 1.0:
            raise ValueError("midpoint steps know no contact; take ImplicitNewmark")
        if not recovery > 0:
            raise ValueError(f"the recovery speed is positive, not {recovery} m/s")
        offset = 0.5 * shell.fabric.thickness if offset is None else float(offset)
        if not 0 <= offset < np.inf:
            raise ValueError(f"the contact offset is a length >= 0, not {offset} m")
        self.body = body
        self._obstacle: Any
        if surface is None:
            self._obstacle = SegmentObstacle(body, offset)
        else:
            # its kernels are loaded for surfaces only
            from contact.solver.moving_surface import SurfaceObstacle

            owner = None if body is surface else body
            self._obstacle = SurfaceObstacle(surface, owner, n, offset, smooth, shapes)
        sheet = shell.surface
        span = spans(sheet.points, straight_cells(sheet.cells)).max()
        names, shapes_met = self._obstacle.met
        thin = refusal(names, shapes_met, span, sheet.mean_cell_size, offset)
        if thin is not None:
            raise ValueError(thin)
        self._kernels = self._obstacle.kernels
        self._friction, self._recovery = as_friction(friction), float(recovery)
        self._step = step_record(self._friction, offset)
        coefficient = self._friction.kinetic_coefficient
        self._judge = active_set.judge_kernel(coefficient)
        self._push = held_nodes.push_kernel(coefficient)
        self._changed = np.zeros(n, bool)
        self._surface, self._impulses, self._energies = (np.zeros((n, 3, 3)) for _ in range(3))
        self._set = held_nodes.new(n)
        self._guided = np.ascontiguousarray(shell.supports.held[:n, :3])
        self._own_axes = np.ascontiguousarray(shell.supports.Q[:n])
        self._set.state[self._guided.all(axis=1)] = FIXED
        self._kept = held_nodes.copy(self._set)
        self._near = NEAR * shell.partition.length
        self._axes, self._held = np.empty((n, 3, 3)), np.empty((n, 3), bool)
        self._goal, self._points = np.empty((n, 3)), stepper.points
        self._force, self._stiffness = np.empty((n, 3)), np.empty((n, 3, 3))
        rows = len(self._obstacle.names)
        self.last, self.window = Ledger(n, rows), Ledger(n, rows)
        self.seconds, self.rounds, self.unsettled = 0.0, 0, 0

    @property
    def segment(self) -> np.ndarray:
        return np.where(self._set.state > OPEN, self._set.owner[:, 0], -1)

    @property
    def friction(self) -> Friction:
        """Its law."""
        return self._friction

    def solve(self, stepper: Any, dt: float) -> tuple[int, int] | None:
        """Solve a step for positions with its set; Newton iterations, in all and in the
        hardest solve, or None if it fails.
        """
        eq, comm, total = stepper.equilibrium, stepper.shell.comm, 0
        most, clock = 0, time.perf_counter()
        self._obstacle.move(stepper.time, dt)
        self._least = STILL * dt
        world = self._obstacle.world
        x0 = stepper.points + stepper.owned[:, :3]
        held_nodes.take(self._kept, self._set)
        self._step["dt"], self._step["recovery"] = dt, self._recovery * dt
        work, changed = self._step[0], self._changed
        _, self.max_depth = self._kernels.locate(True, x0, x0, changed, work, world, self._set)
        for k in range(ROUNDS):
            self._constrain(stepper)
            self.seconds += time.perf_counter() - clock
            done = stepper.newton.solve(stepper.time + dt)
            clock = time.perf_counter()
            stepper.solves += 1
            self.rounds += 1
            if done is None:
                return None
            total, most = total + done.iterations, max(most, done.iterations)
            x1 = stepper.points + stepper.owned[:, :3]
            soft = self._judge(x1, eq.contact_force(), self._least, changed, work, self._set)
            changes, gap = self._kernels.locate(False, x0, x1, changed, work, world, self._set)
            changes = comm.allreduce(changes)
            gap, soft = comm.allreduce(gap, MPI.MAX), comm.allreduce(soft, MPI.MAX)
            if not changes and gap <= self._near and (soft <= SOFT or k >= SOFTER):
                break
        else:
            if dt > SMALLEST * stepper.largest_dt:
                stepper.newton.reason = "contact changed in every solve"
                return None
            self.unsettled += 1
        self.seconds += time.perf_counter() - clock
        return total, most

    def _constrain(self, stepper):
        constrain(
            self._points, stepper.owned, self._set, self._own_axes, self._guided, self._axes,
            self._held, self._goal,
        )  # fmt: skip
        stepper.equilibrium.hold(self._axes, self._held, self._goal)
        stepper.equilibrium.rubbing = self._rub if self._friction.parameters[0] > 0.0 else None

    def _rub(self, owned):
        """Friction of the nodes that slip, see `Inertial`."""
        slip_friction(
            self._points, owned, self._set, self._axes, self._held | self._guided, self._least,
            self._force, self._stiffness,
        )  # fmt: skip
        return self._force, self._stiffness

    def push(
        self, stepper: Any, v_old: np.ndarray, mean: np.ndarray, moved: np.ndarray, dt: float
    ) -> np.ndarray:
        """Impulses of a solved step, booked; `stepper.v` is changed.

        Parameters
        ----------
        v_old : (n_owned, 3), velocities at the start; mean : (n_owned, 3), acceleration over the
            step by all forces but contact; moved : (n_owned, 3) [m], the step's displacement

        Returns
        -------
        (n_owned, 3), part of contact in the acceleration that the next step starts from [m/s^2]
        """
        clock = time.perf_counter()
        last, window = self.last, self.window
        last.clear()
        pushed = np.zeros_like(v_old)
        x = stepper.points + stepper.owned[:, :3]
        world, work, nodes = self._obstacle.world, self._step[0], self._set
        self._kernels.velocities(x, world, nodes, self._surface)
        self.active, self.sticking = self._push(
            SolvedStep(x, stepper.v, v_old, mean, moved, stepper.a, stepper.mass),
            self._surface, work, self._kept.state, nodes, last.impulse, self._impulses,
            self._energies, pushed,
        )  # fmt: skip
        self._kernels.book(x, self._impulses, self._energies, world, nodes)
        self._obstacle.booked(last.table, x)
        self._obstacle.settle()
        self._give_back(stepper, pushed, dt)
        held_nodes.take(self._set, self._kept)
        last.seconds = dt
        window.add(last)
        self.seconds += time.perf_counter() - clock
        return pushed

    def _give_back(self, stepper, pushed, dt):
        """What supports hold keeps its velocity: they take that part of the impulses."""
        g = np.flatnonzero(self._guided.any(axis=1) & (self._set.state > OPEN))
        if not len(g):
            return
        Q, mass = self._own_axes[g], stepper.mass[g, None]
        along = np.where(self._guided[g], np.einsum("nij,nj->ni", Q, self.last.impulse[g]), 0.0)
        taken = np.einsum("nji,nj->ni", Q, along)
        pushed[g] -= taken / (mass * dt)
        before = stepper.v[g]
        stepper.v[g] = before - taken / mass
        stepper.books.impulses[BY_SUPPORTS] -= taken.sum(axis=0)
        stepper.books.works[SUPPORT] -= 0.5 * np.vdot(taken, before + stepper.v[g])
