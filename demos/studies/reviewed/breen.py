# SPDX-License-Identifier: LGPL-3.0-or-later
r"""Breen, House and Wozny: particles whose energies are KES curves, minimised.

A particle sits at each crossing of threads. Of what is stored between neighbours,

    U = sum h^2 [ K e^2/2 + w(gamma) + m(kappa) ] + m g z,

stretch is stiff (theirs is a made-up fifth power, with repulsion where threads are pushed
together), trellis w(gamma) and bending m(kappa) are integrals of measured curves (thread_grid.py
has the strains). A square of cloth that lies on a square table is let hang: U is minimised by
L-BFGS from a slightly pushed flat sheet, in place of their random search. The shell hangs by
explicit steps, from the same curves. Particles know no twist; the shell is hung with the twist of
Huber's formula and with nearly none.

The drape coefficient is that of the shadow of what hangs, of the area of table and cloth.

Source. Textile Res. J. 64(11), 1994, 663-685. Their KES curves are plots; those here are made up,
softening in bending and locking in shear as cloth does.

    python -m demos.studies.reviewed.breen --out out/reviewed
"""

import time
from collections.abc import Sequence

from mpi4py import MPI

import numpy as np
from scipy.optimize import minimize

import meshes
from demos.studies.drape.figures import print_table, write_table
from demos.studies.reviewed.cusick_drape import HARMONICS, folds, options, outline
from demos.studies.reviewed.thread_grid import Grid, grid, on_table
from shellform import Newmark, Shell, console
from shellform.material.measurements import measured_fabric
from shellform.material.sheet import Sheet

G = 9.81  # m/s^2
TABLE, SQUARE = 0.12, 0.24  # m, sides
RISE = 1e-3  # m, root mean square of the push at the rim
CARD = {
    "tensile_warp_N_per_m": 1000.0, "tensile_weft_N_per_m": 1000.0,
    "angle_radians": [0.0, 0.05, 0.15, 0.3, 0.5, 0.7],
    "shear_load_N_per_m": [0.0, 2.0, 6.2, 14.0, 32.0, 75.0],
    "curvature_warp_per_m": [0.0, 25.0, 50.0, 100.0, 250.0],
    "weight_g_per_m2": 200.0, "thickness_mm": 0.5,
}  # fmt: skip
MOMENT = [0.0, 3e-4, 5.6e-4, 10e-4, 21e-4]  # N, slope 1.2e-5 N m at rest


def cloth(**more: float) -> Sheet:
    """A fabric of the curves; other quantities of a measured card may be added."""
    card = CARD | {"curvature_weft_per_m": CARD["curvature_warp_per_m"]}
    card |= {"moment_warp_N": MOMENT, "moment_weft_N": MOMENT}
    return measured_fabric(card | more, name="of curves")


def sheet(cells: int) -> Grid:
    """The square of cloth with that many cells a side, clamped upon the table."""
    square = grid((cells + 1, cells + 1), SQUARE / cells)
    return square.clamped(on_table(square.points, 0.5 * TABLE))


def pushed(points: np.ndarray, start: int) -> np.ndarray:
    """Heights (n,) [m] of a start, none on the table: waves around, growing outward."""
    random, order = np.random.default_rng(start), np.arange(2, HARMONICS + 1)
    angle = np.arctan2(points[:, 1], points[:, 0])
    waves = np.cos(angle[:, None] * order + random.uniform(0, 2 * np.pi, len(order)))
    size = random.standard_normal(len(order))
    out = np.maximum(np.abs(points[:, :2]).max(axis=1) / (0.5 * TABLE) - 1, 0.0)
    return RISE * out * (waves @ size) / np.sqrt(0.5 * size @ size)


def energy(cells: Grid, fabric: Sheet, x: np.ndarray) -> tuple[float, np.ndarray]:
    """U [J] at places x (n, 3) and its derivative (n, 3) [N]."""
    law, K = fabric.law, fabric.membrane[0, 0]
    weight = fabric.areal_mass * G * cells.areas
    total, push = float(weight @ x[:, 2]), np.zeros_like(x)
    push[:, 2] = weight
    stretch, shear = cells.elongations(x), cells.angles(x)
    bends = cells.curvatures(x)
    for strains, stored, stress in (
        (stretch, 0.5 * K * stretch.values**2, K * stretch.values),
        (shear, law.shear_angle(shear.values, 0), law.shear_angle(shear.values)),
        (bends, law.bend_warp(bends.values, 0), law.bend_warp(bends.values)),
    ):
        total += float(strains.areas @ stored)
        push -= strains.forces(stress, len(x))
    return total, push


def minimised(
    cells: Grid, fabric: Sheet, start: int, iterations: int = 6000
) -> tuple[np.ndarray, int, float]:
    """Places (n, 3) [m] of least energy near a start, iterations, largest force left [N]."""
    x = cells.points.copy()
    free = np.ones(len(x), bool)
    free[on_table(x, 0.5 * TABLE)] = False
    x[:, 2] = pushed(x, start)
    unit = fabric.areal_mass * G * cells.areas.sum() * cells.spacing

    def function(unknown):
        x[free] = cells.spacing * unknown.reshape(-1, 3)
        total, push = energy(cells, fabric, x)
        return total / unit, (push[free] * cells.spacing / unit).ravel()

    found = minimize(
        function,
        x[free].ravel() / cells.spacing,
        jac=True,
        method="L-BFGS-B",
        options={"maxiter": iterations, "maxfun": 2 * iterations, "ftol": 1e-13, "gtol": 1e-7,
                 "maxcor": 30},
    )  # fmt: skip
    left = float(np.abs(function(found.x)[1]).max() * unit / cells.spacing)
    return x, int(found.nit), left


def hung(fabric: Sheet, cells: int, start: int, seconds: float = 1.5) -> tuple[np.ndarray, int]:
    """Places (n, 3) [m] of the shell's nodes at rest, numbered as the crossings, and steps."""
    surface = meshes.rectangle(SQUARE, SQUARE, (cells, cells)).replace(warp=(1.0, 0.0, 0.0))
    surface = surface.transform(translation=(-0.5 * SQUARE, -0.5 * SQUARE, 0.0))
    shell = Shell(surface, fabric, MPI.COMM_SELF)
    shell.supports.clamp(on_table(surface.points, 0.5 * TABLE))
    shell.loads.gravity((0.0, 0.0, -G))
    stepper = Newmark(shell, damping=2e-5, drag=5.0)
    stepper.owned[:, 2] += pushed(stepper.points, start)
    stepper.scatter()
    stepper.advance(seconds)
    x = np.round(surface.points / (SQUARE / cells), 6)
    return shell.positions()[np.lexsort((x[:, 1], x[:, 0]))], stepper.steps


def measures(x: np.ndarray, cells: int) -> dict[str, float]:
    """Drape coefficient [%], folds and mean height [mm] of places numbered as the crossings."""
    square = x.reshape(cells + 1, cells + 1, 3)
    rim = np.concatenate([square[:-1, 0], square[-1, :-1], square[:0:-1, -1], square[0, :0:-1]])
    radii = outline(rim)
    shadow = np.pi * np.mean(radii**2)
    return {
        "DC %": 100 * (shadow - TABLE**2) / (SQUARE**2 - TABLE**2),
        "folds": folds(radii),
        "mean height [mm]": 1e3 * float(grid((cells + 1,) * 2, 1.0).areas @ x[:, 2]) / cells**2,
    }


def summary(name: str, found: Sequence[dict], seconds: float, work: float) -> dict:
    """A line of a table: means of several starts, their scatter, work and time of one."""
    mean = {key: float(np.mean([one[key] for one in found])) for key in found[0]}
    many = len(found) > 1
    spread = float(np.std([one["DC %"] for one in found], ddof=1)) if many else 0.0
    low = float(np.std([one["mean height [mm]"] for one in found], ddof=1)) if many else 0.0
    line = {"model": name, "DC %": mean["DC %"], "SD": spread, "folds": mean["folds"]}
    line |= {"mean height [mm]": mean["mean height [mm]"], "its SD": low}
    return line | {"iterations or steps": int(work), "seconds": seconds / len(found)}


def particles_row(fabric: Sheet, cells: int, starts: int) -> dict:
    """Particles of least energy, over starts."""
    found, begun = [], time.process_time()
    for start in range(1, starts + 1):
        x, iterations, left = minimised(sheet(cells), fabric, start)
        found.append(measures(x, cells))
    spent = time.process_time() - begun
    return summary("particles, least energy", found, spent, iterations) | {"force left [N]": left}


def shell_row(name: str, fabric: Sheet, cells: int, starts: int) -> dict:
    """The shell at rest, over starts."""
    found, begun = [], time.process_time()
    for start in range(1, starts + 1):
        x, steps = hung(fabric, cells, start)
        found.append(measures(x, cells))
    return summary(name, found, time.process_time() - begun, steps)


def main(given: Sequence[str] | None = None) -> None:
    asked = options(given, "Particles of least energy beside the shell of the same curves.")
    cells = 12 if asked.quick else 16
    rows = [
        particles_row(cloth(), cells, asked.starts),
        shell_row("shell, next to no twist", cloth(B_twist_uN_m=0.05), cells, asked.starts),
        shell_row("shell, Huber's twist", cloth(), cells, asked.starts),
    ]
    columns = list(dict.fromkeys(key for row in rows for key in row))
    print_table(f"A square of cloth on a table, {cells} cells a side", rows, columns)
    write_table(f"{asked.out}/breen.csv", rows)


if __name__ == "__main__":
    console.run(main)
