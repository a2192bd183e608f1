# SPDX-License-Identifier: LGPL-3.0-or-later
r"""Terzopoulos and others, Carignan and others: energies of metric and curvature, implicit steps.

    psi = sum over i, j of  eta_ij (G_ij - G0_ij)^2 + xi_ij (B_ij - B0_ij)^2

of the first and the second fundamental form G, B of the surface. They discretised it by finite
differences and stepped implicitly. Here it is a law of the director shell (surface_energy.py).

Energy. A rectangle is stretched, sheared and rolled up into a cylinder; the energy of the shell is
compared with the formula above, whose forms are taken from the exact surface.

Pull. A strip is pulled: with this energy it does not contract, whatever the weights.

Drape. Cusick's test by implicit steps, beside explicit steps of the St. Venant sheet that has the
same A and D without Poisson's ratio, which is the same energy, and of one with it.

Source. Computer Graphics 21(4), 1987, 205-214; 26(2), 1992, 99-104. Weights are not given in units
of cloth there: the cloth is that of cusick_drape.py.

    python -m demos.studies.reviewed.terzopoulos_carignan --out out/reviewed
"""

import time
from collections.abc import Sequence

from mpi4py import MPI

import numpy as np

import meshes
from demos.studies.drape.figures import print_table, write_table
from demos.studies.reviewed.cusick_drape import (
    SUITING,
    Hanging,
    hang,
    options,
    push,
    read,
    ring_shell,
)
from shellform import ImplicitNewmark, Shell, Statics, console
from shellform.material.measurements import measured_fabric
from shellform.material.sheet import Sheet
from shellform.material.surface_energy import MetricAndCurvature
from shellform.statics.path import PathState

LENGTH, WIDTH = 0.1, 0.06  # m, of the rectangle and the strip
STRETCH, SLIDE, RADIUS = (1.05, 0.98), 0.1, 0.05  # stretches, shear, radius of the cylinder [m]
STEP = 4e-3  # s, of the implicit drape


def forms() -> tuple[np.ndarray, np.ndarray]:
    """G - G0 and B - B0 [1/m] (2, 2) of the rectangle rolled up, in its own coordinates.

    x(X, Y): along the arc p = STRETCH_0 X + SLIDE Y, along the axis q = STRETCH_1 Y.
    """
    along, across = np.array([STRETCH[0], SLIDE]), np.array([0.0, STRETCH[1]])
    return np.outer(along, along) + np.outer(across, across) - np.eye(2), (
        np.outer(along, along) / RADIUS
    )


def exact(fabric: Sheet) -> dict[str, float]:
    """Energies [J/m^2] of metric and curvature by the formula, with the weights of a fabric.

    A = 8 diag(eta_11, eta_22, eta_12/2), D = 2 diag(xi_11, xi_22, xi_12/2).
    """
    A, D = np.diag(fabric.membrane), np.diag(fabric.bending)
    eta = np.array([[A[0] / 8, A[2] / 4], [A[2] / 4, A[1] / 8]])
    xi = np.array([[D[0] / 2, D[2]], [D[2], D[1] / 2]])
    metric, curvature = forms()
    return {
        "membrane": float(np.sum(eta * metric**2)),
        "bending": float(np.sum(xi * curvature**2)),
    }


def cloth(**more: float) -> Sheet:
    """The suiting; `poisson_ratio` and other quantities of a measured card."""
    return measured_fabric(SUITING | more, name="suiting")


def rolled_up(fabric: Sheet, cells: int) -> dict[str, float]:
    """Energies [J/m^2] of a shell laid upon the cylinder."""
    surface = meshes.rectangle(LENGTH, WIDTH, (2 * cells, cells)).replace(warp=(1.0, 0.0, 0.0))
    shell = Shell(surface, fabric, MPI.COMM_SELF)
    x, y = surface.points[:, 0], surface.points[:, 1]
    angle = (STRETCH[0] * x + SLIDE * y) / RADIUS
    place = [RADIUS * np.sin(angle), STRETCH[1] * y, RADIUS * (1 - np.cos(angle))]
    directors = np.column_stack([-np.sin(angle), 0 * y, np.cos(angle)])
    field = np.hstack([np.column_stack(place) - surface.points, directors])
    PathState(0.0, field, np.zeros_like(surface.points)).put(shell)
    return {kind: value / surface.area for kind, value in shell.energy().items()}


def contraction(fabric: Sheet, stretch: float = 0.02) -> float:
    """How much a strip narrows in the middle over its stretch, pulled along the warp."""
    surface = meshes.rectangle(LENGTH, 0.2 * LENGTH, (20, 4)).replace(warp=(1.0, 0.0, 0.0))
    shell = Shell(surface, fabric, MPI.COMM_SELF)
    shell.supports.hold(np.arange(len(surface.points)), "z")
    shell.supports.clamp("left")
    shell.supports.move("right", (stretch * LENGTH, 0.0, 0.0))
    shell.supports.hold_director("right")
    with Statics(shell) as statics:
        statics.solve(1)
    half, width = (0.5 * LENGTH, 0.0, 0.0), 0.2 * LENGTH
    low = shell.displacement_at(half)
    high = shell.displacement_at((half[0], width, 0.0))
    return float((low[1] - high[1]) / width / stretch)


def hang_implicitly(
    fabric: Sheet, start: int, cells: tuple[int, int], seconds: float = 1.5, drag: float = 5.0
) -> tuple[Hanging, int]:
    """Cusick's drape by implicit steps; Newton iterations."""
    shell = ring_shell(fabric, cells)
    stepper = ImplicitNewmark(shell, STEP, alpha=-0.1, drag=drag)
    stepper.v[:, 2] = push(stepper.points, start)
    stepper.advance(seconds)
    balance = stepper.balance()
    motion = balance["kinetic"] / balance["strain"]
    hangs = read(shell, motion, stepper.steps, seconds / stepper.steps)
    return hangs, stepper.newton_iterations


def row_of(law: str, stepping: str, drape: Hanging, seconds: float) -> dict:
    """A drape as a line of a table."""
    return {
        "law": law, "steps of": stepping, "DC %": 100 * drape.coefficient, "folds": drape.folds,
        "step [ms]": 1e3 * drape.dt, "steps": drape.steps, "seconds": seconds,
    }  # fmt: skip


def main(given: Sequence[str] | None = None) -> None:
    asked = options(given, "Energy of metric and curvature: a cylinder, a pull, implicit steps.")
    plain = cloth()
    law = plain.with_law(MetricAndCurvature())
    wanted = exact(plain)
    rows = []
    for cells in (4, 8, 16, 32):
        found, row = rolled_up(law, cells), {"cells": cells}
        for kind, value in wanted.items():
            row[f"{kind} [J/m2]"] = found[kind]
            row[f"{kind}, off %"] = 100 * (found[kind] / value - 1)
        rows.append(row)
    print_table("A rectangle rolled up, against the formula", rows, list(rows[0]))
    write_table(f"{asked.out}/terzopoulos_carignan_energy.csv", rows)

    rows = [
        {"law": name, "contraction over stretch": contraction(fabric)}
        for name, fabric in (
            ("metric and curvature", law),
            ("St. Venant, nu = 0.3", cloth(poisson_ratio=0.3)),
        )
    ]
    print_table("A strip pulled along the warp", rows, list(rows[0]))

    rows = []
    for start in range(1, asked.starts + 1):
        begun = time.process_time()
        drape, iterations = hang_implicitly(law, start, asked.cells)
        spent = time.process_time() - begun
        row = row_of("metric and curvature", "implicit", drape, spent)
        rows.append(row | {"iterations": iterations})
        for name, fabric in (
            ("St. Venant, nu = 0", plain),
            ("St. Venant, nu = 0.3", cloth(poisson_ratio=0.3)),
        ):
            begun = time.process_time()
            drape = hang(fabric, start, asked.cells)
            rows.append(row_of(name, "explicit", drape, time.process_time() - begun))
    print_table("Cusick's drape, a start a block", rows, list(rows[0]))
    write_table(f"{asked.out}/terzopoulos_carignan_drape.csv", rows)


if __name__ == "__main__":
    console.run(main)
