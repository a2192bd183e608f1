# SPDX-License-Identifier: LGPL-3.0-or-later
r"""A strip let down onto a table: contact by penalty, and the exact curve.

The strip is clamped level at the height h above a smooth table, bends down under its weight q per
area and lies on the table beyond its arc length s*. With the angle phi below the level and the
force R per width with which the table holds it where it touches down,

    B phi'' = -(q (s* - s) - R) cos(phi),   phi = phi' = 0 and z = -h at s*,   phi(0) = 0,

two conditions more than the equation takes, which give s* and R (h small: s*^4 = 72 B h/q, R =
q s*/3). On the table the moment is nothing.

By penalty a node below the table is pushed up by k times its depth and its area, which stands in
residual and tangent. The table then gives way by q/k under the flat part, and R is
spread over a length of about (4 B/k)^(1/4).

By an augmented Lagrangian (Simo and Laursen, Comput. Struct. 42, 97, 1992) the pressure is max(0, l
+ k d), d the depth, negative above the table. At rest l is set to it, and the strip solved for
again: d falls with each turn, at any k.
"""

from dataclasses import dataclass

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np
from scipy.integrate import solve_bvp

import meshes
from shellform import Body, Contact, Fixed, Newmark, Segment, Shell
from shellform.fem.lumped_mass import lumped
from shellform.fem.shell import Linearised
from shellform.material.sheet import Sheet
from shellform.statics.equilibrium import Equilibrium
from shellform.statics.newton import Newton

G = 9.81  # m/s^2
LENGTH, WIDTH = 0.12, 0.01  # m
TABLE = 1000.0  # m, radius of the sphere that stands for a table where contact takes ellipsoids
SHORTEST = 1e-5  # load step, of the whole weight


@dataclass(frozen=True)
class Laid:
    """How a strip lies.

    Attributes
    ----------
    clamp : force up of the clamp [N/m], per width; table : that of the table
    touch : distance from the clamp [m] at which the first node touches
    depth : deepest node below the table [m]; solves : int
    """

    clamp: float
    table: float
    touch: float
    depth: float
    solves: int


def exact(bending: float, weight: float, height: float) -> dict[str, float]:
    """Curve of a strip of `bending` [N m], `weight` [N/m^2] at a height [m].

    Arc length `s` [m] up to where it touches, distance `x` [m] of that place, forces per width
    [N/m] of the table where it touches, `R`, and of the clamp, `clamp`.
    """
    s0 = (72 * bending * height / weight) ** 0.25
    t = np.linspace(0.0, 1.0, 201)
    # h small: w = q (s^4 - 8/3 s* s^3 + 2 s*^2 s^2)/(24 B), in t = s/s*
    scale = weight * s0**3 / (24 * bending)
    slope, bend = scale * (4 * t**3 - 8 * t**2 + 4 * t), scale * (12 * t**2 - 16 * t + 4)
    start = np.array([np.arctan(slope), bend, s0 * t, -height * (3 * t**4 - 8 * t**3 + 6 * t**2)])

    def slopes(t, y, p):
        turn = -(weight * p[0] * (1 - t) - p[1]) * p[0] ** 2 / bending
        return np.array([y[1], turn * np.cos(y[0]), p[0] * np.cos(y[0]), -p[0] * np.sin(y[0])])

    def ends(a, b, p):
        return np.array([a[0], a[2], a[3], b[0], b[1], (b[3] + height) / height])

    found = solve_bvp(slopes, ends, t, start, [s0, weight * s0 / 3], tol=1e-8, max_nodes=50000)
    if not found.success:
        raise ArithmeticError(f"no curve of the strip found: {found.message}")
    s, R = found.p
    return {"s": s, "x": found.y[2, -1], "R": R, "clamp": weight * s - R}


def strip(fabric: Sheet, cells: int) -> Shell:
    """The strip, level, its clamp at x = 0, z = 0; it bends in a plane."""
    surface = meshes.rectangle(LENGTH, WIDTH, (cells, 1)).replace(warp=(1.0, 0.0, 0.0))
    shell = Shell(surface, fabric, MPI.COMM_SELF)
    shell.supports.clamp("left")
    for edge in ("bottom", "top"):
        shell.supports.symmetry(edge, (0.0, 1.0, 0.0))
    shell.loads.gravity((0.0, 0.0, -G))
    return shell


class OnTable(Equilibrium):
    """Equilibrium of a sheet above a table of `stiffness` [N/m^3] at z = -height."""

    def __init__(self, shell: Shell, height: float, stiffness: float):
        area = lumped(shell.surface, shell.fabric, 1.0)[0] / shell.fabric.areal_mass
        self.springs = stiffness * area[shell.partition.owned_nodes]
        self.height, self.place = height, np.zeros((len(self.springs), 6))
        self.multiplier = np.zeros(len(self.springs))  # l/k [m]
        super().__init__(shell)

    def depths(self) -> np.ndarray:
        """Depths of the nodes below the table [m], negative above it."""
        return -self.height - self.shell.w.x.array.reshape(-1, 6)[: self.n_owned, 2]

    def table_forces(self) -> np.ndarray:
        """Forces of the table on the nodes [N]."""
        return self.springs * np.maximum(0.0, self.multiplier + self.depths())

    def augment(self) -> None:
        """Set the multipliers to the pressures of this state."""
        self.multiplier = np.maximum(0.0, self.multiplier + self.depths())

    def _touch(self):
        # springs to fixed places have the form of an implicit step's inertia
        factor = np.zeros_like(self.place)
        self.place[:, 2] = self.multiplier - self.height
        factor[:, 2] = self.springs * (self.multiplier + self.depths() > 0.0)
        self.inertia = (factor, self.place)

    def forces(self, stress_from: Linearised | None = None) -> np.ndarray:
        """See Equilibrium; with the force of the table."""
        self._touch()
        return super().forces(stress_from)

    def tangent(self, x: PETSc.Vec) -> PETSc.Mat:
        """See Equilibrium; with the stiffness of the table."""
        self.configure(x)
        self._touch()
        return super().tangent(x)


def by_penalty(
    fabric: Sheet, height: float, stiffness: float, cells: int = 100, augmented: int = 0
) -> Laid:
    """Lay the strip down in load steps, shorter ones where Newton's method fails.

    augmented : turns of the augmented Lagrangian after them; 0: a penalty alone

    ArithmeticError where no step is short enough, and where a turn is not solved.
    """
    shell = strip(fabric, cells)
    eq = OnTable(shell, height, stiffness)
    newton = Newton(eq, "table_")
    level, part, solves = 0.0, 0.05, 0
    try:
        while level < 1.0:
            state, goal = eq.state(), min(1.0, level + part)
            step = newton.solve(goal)
            solves += newton.snes.getIterationNumber()
            if step is None:
                eq.restore(state)
                part *= 0.5
                if part < SHORTEST:
                    raise ArithmeticError(f"stuck at {level:.4f} of the weight: {newton.reason}")
            else:
                level, part = goal, 1.5 * part
        for _ in range(augmented):
            eq.augment()
            if newton.solve(1.0) is None:
                raise ArithmeticError(f"stuck at an augmented turn: {newton.reason}")
            solves += newton.snes.getIterationNumber()
        held, depth = eq.reactions()[:, 2].sum() / WIDTH, eq.depths()
        pushes = eq.table_forces()
        pushed = pushes.sum() / WIDTH
        touch = shell.positions()[shell.partition.owned_nodes][pushes > 0, 0].min()
    finally:
        newton.destroy()
        eq.destroy()
    return Laid(float(held), float(pushed), float(touch), float(depth.max()), solves)


def kept_out(fabric: Sheet, height: float, cells: int = 40, seconds: float = 1.5) -> Laid:
    """The same by explicit steps, and contact that lets no node in (Eqs. 15 and 16)."""
    shell = strip(fabric, cells)
    stepper = Newmark(shell, damping=1e-5, drag=4.0)
    table = Body([Segment("table", (TABLE,) * 3, Fixed((0.0, 0.0, -height - TABLE)))])
    contact = stepper.add(Contact(table, 0.0, offset=0.0))
    stepper.advance(0.8 * seconds)
    contact.reset()
    before, since = stepper.support_total[2], stepper.time
    stepper.advance(seconds)
    force = (stepper.support_total[2] - before) / (seconds - since) / WIDTH
    on_table = contact.window.impulse.sum(axis=0)[2] / (seconds - since) / WIDTH
    x = shell.positions()[shell.partition.owned_nodes]
    touch = x[contact.segment >= 0, 0].min()
    depth = np.maximum(-height - x[:, 2], 0.0).max()
    return Laid(float(force), float(on_table), float(touch), float(depth), stepper.steps)
