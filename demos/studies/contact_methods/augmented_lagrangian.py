# SPDX-License-Identifier: LGPL-3.0-or-later
r"""Implicit steps against a penalty or an augmented Lagrangian (Simo and Laursen, 1992).

A node at the signed distance d from the body, h of which it has to keep, is pushed along the normal
n by p, and rubbed by t,

    p = max(0, l - k (d - h)),    t = r cut to |t| <= mu P,   r = s - k (1 - n n) (x - x_0),

k being a stiffness per area times the area of the node [N/m], x_0 where the step began and P the
push that the last solve has found. A penalty has l = 0, and for s the friction of the step before.
An augmented Lagrangian solves a step again with l = p and s = t, until a turn changes neither by
more than k times a tolerance (Uzawa): then nothing is deeper than that, and what sticks has moved
by no more, at any k (Comput. Struct. 42, 97, eqs. 2.21 to 2.24). That P is the push of the turn
before is their nested form: the tangent stays symmetric,

    k n n + k (1 - n n)                                        where it sticks,
    k n n + k mu P/|r| (1 - n n - r r/|r|^2)                   where it slips.

The body is one ellipsoid at rest. One rank.
"""

from typing import Any

from petsc4py import PETSc

import numpy as np

from contact.geometry.ellipsoid import closest_points
from shellform import ImplicitNewmark, Shell
from shellform.dynamics.implicit_equilibrium import Inertial
from shellform.fem.lumped_mass import nodal_areas


class Pressed(Inertial):
    """Equilibrium of an implicit step with the forces of contact.

    Attributes
    ----------
    stiffnesses : (n,) k [N/m]; push, rub : (n,), (n, 3), l and s [N]; origin : (n, 3), x_0 [m]
    cone : (n,), mu P [N]; radii, centre : (3,), of the ellipsoid [m]; kept : float, h [m]
    """

    stiffnesses: np.ndarray | None = None
    push: np.ndarray
    rub: np.ndarray
    origin: np.ndarray
    cone: np.ndarray
    radii: np.ndarray
    centre: np.ndarray
    kept: float

    def places(self) -> np.ndarray:
        """Positions (n, 3) of the nodes [m]."""
        shell = self.shell
        rest = shell.surface.points[shell.partition.owned_nodes]
        return rest + shell.w.x.array.reshape(-1, 6)[: self.n_owned, :3]

    def meet(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Pushes (n,) and frictions (n, 3) [N] of this state, normals and trial frictions r."""
        x = self.places()
        _, normal, distance = closest_points(x, self.radii, self.centre)
        push = np.maximum(0.0, self.push - self.stiffnesses * (distance - self.kept))
        trial = self.rub - self.stiffnesses[:, None] * (x - self.origin)
        trial -= np.einsum("ni,ni->n", trial, normal)[:, None] * normal
        size = np.linalg.norm(trial, axis=1)
        cone = np.where(push > 0.0, self.cone, 0.0)
        part = np.minimum(1.0, cone / np.maximum(size, 1e-300))
        return push, part[:, None] * trial, normal, trial

    def forces(self, stress_from: Any = None) -> np.ndarray:
        """See Equilibrium; less those of contact."""
        r6 = super().forces(stress_from)
        if self.stiffnesses is not None:
            push, rub, normal, _ = self.meet()
            r6[:, :3] -= push[:, None] * normal + rub
        return r6

    def tangent(self, x: PETSc.Vec) -> PETSc.Mat:
        """See Equilibrium; with the stiffness of contact."""
        K = super().tangent(x)
        if self.stiffnesses is None:
            return K
        push, _, normal, trial = self.meet()
        across = np.eye(3) - np.einsum("ni,nj->nij", normal, normal)
        size = np.maximum(np.linalg.norm(trial, axis=1), 1e-300)
        along = trial / size[:, None]
        slip = self.cone / size
        still = np.where(slip >= 1.0, 1.0, slip)[:, None, None] * across
        still -= np.where(slip >= 1.0, 0.0, slip)[:, None, None] * np.einsum(
            "ni,nj->nij", along, along
        )
        block = np.eye(3) - across + still
        block = self.stiffnesses[:, None, None] * self._along_axes(block)
        for i in np.flatnonzero(push > 0.0):
            free = np.flatnonzero(~self.held[i, :3]).astype(np.int32)
            rows = 5 * np.int32(i) + free
            K.setValues(rows, rows, block[i][np.ix_(free, free)], PETSc.InsertMode.ADD_VALUES)
        K.assemble()
        return K

    def _along_axes(self, block):
        """Blocks (n, 3, 3) of the world in the axes of the nodes."""
        Q = self.Q[: self.n_owned]
        return np.einsum("nai,nij,nbj->nab", Q, block, Q)


class AugmentedNewmark(ImplicitNewmark):
    """Implicit steps that meet an ellipsoid at rest by a penalty or an augmented Lagrangian.

    Parameters
    ----------
    shell, dt, options : see ImplicitNewmark
    radii, centre : (3,) of the ellipsoid [m]; friction : float, mu
    stiffness : float, k per area [Pa/m]; turns : int, most augmentations of a step; 0: a penalty
    tolerance_of_turns : float [m]

    Attributes
    ----------
    turns_done, unsettled : int, augmentations so far, steps that ended with their turns used up
    impulse : (n, 3), of the body on the nodes so far [N s]
    """

    equilibrium_class = Pressed
    equilibrium: Pressed

    def __init__(
        self,
        shell: Shell,
        dt: float,
        radii: Any,
        centre: Any,
        friction: float,
        stiffness: float,
        turns: int,
        tolerance_of_turns: float = 1e-6,
        **options: Any,
    ) -> None:
        super().__init__(shell, dt, **options)
        eq, n = self.equilibrium, self.n_owned
        areas = nodal_areas(shell.surface)[shell.partition.owned_nodes]
        eq.radii, eq.centre = np.asarray(radii, float), np.asarray(centre, float)
        eq.kept = 0.5 * shell.fabric.thickness
        eq.push, eq.rub, eq.cone = np.zeros(n), np.zeros((n, 3)), np.zeros(n)
        eq.origin, eq.stiffnesses = eq.places(), stiffness * areas
        self._mu, self._turns, self._tolerance = friction, turns, tolerance_of_turns
        self._found = eq.push.copy(), eq.rub.copy()
        self.turns_done = self.unsettled = 0
        self.impulse = np.zeros((n, 3))

    def _solve(self, dt):
        eq, iterations, most = self.equilibrium, 0, 0
        push, rub = self._found
        eq.push, eq.rub = push * bool(self._turns), rub
        eq.cone, eq.origin = self._mu * push, eq.places()
        for turn in range(self._turns + 1):
            self.solves += 1
            done = self.newton.solve(self.time + self.instant * dt)
            if done is None:
                return None
            iterations, most = iterations + done.iterations, max(most, done.iterations)
            push, rub, normal, _ = eq.meet()
            change = np.abs(push - eq.push) + np.linalg.norm(rub - eq.rub, axis=1)
            if not self._turns or (change <= self._tolerance * eq.stiffnesses).all():
                break
            if turn == self._turns:
                self.unsettled += 1
                break
            eq.push, eq.rub, eq.cone = push, rub, self._mu * push
            self.turns_done += 1
        self._found = push, rub
        self.impulse += dt * (push[:, None] * normal + rub)
        return iterations, most
