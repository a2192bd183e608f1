# SPDX-License-Identifier: LGPL-3.0-or-later
r"""Gan, Ly and Steven: a nonlinear shell whose bending is measured apart from its tension.

Their curved degenerated shell takes the bending rigidity of a KES test instead of E t^3/12 from the
tensile modulus. Two questions are asked of the director shell with the same freedom.

Cantilever. A strip hangs over an edge under its own weight. With the arc length s in parts of the
overhang L, the angle phi below the horizontal and Gamma = rho g L^3/B,

    phi'' = -Gamma (1 - s) cos(phi),   phi(0) = 0,   phi'(1) = 0,

and the fall of the tip over its reach is compared, with 4-node and with 9-node quads (theirs are
curved, of second order).

Drape. Cusick's coefficient with the measured B, and with the E t^3/12 of Chen and Govindaraj.

Source. Textile Res. J. 65(11), 1995, 660-668; their fabrics' numbers could not be had: the cloth
is that of cusick_drape.py.

    python -m demos.studies.reviewed.gan --out out/reviewed
"""

from collections.abc import Sequence

from mpi4py import MPI

import numpy as np
from scipy.integrate import solve_bvp

import meshes
from demos.studies.drape.figures import print_table, write_table
from demos.studies.reviewed.cusick_drape import SUITING, drapes, options
from shellform import Fabric, Shell, Statics, console
from shellform.material.measurements import measured_fabric

GAMMAS = (1.0, 3.0, 10.0, 30.0, 100.0, 1000.0)
OVERHANG, WIDTH = 0.2, 0.02  # m


def elastica(gammas: Sequence[float]) -> np.ndarray:
    """Fall of the tip over its reach at rising Gammas, by collocation."""
    s, last = np.linspace(0.0, 1.0, 101), 1e-3
    y, found = np.zeros((4, len(s))), []
    for gamma in gammas:
        # each load begins with the shape of the one before
        for load in np.geomspace(last, gamma, 2 + int(abs(np.log2(gamma / last))))[1:]:

            def slopes(s, y, load=load):
                return np.array([y[1], -load * (1 - s) * np.cos(y[0]), np.cos(y[0]), np.sin(y[0])])

            def ends(a, b):
                return np.array([a[0], b[1], a[2], a[3]])

            solved = solve_bvp(slopes, ends, s, y, tol=1e-8, max_nodes=20000)
            if not solved.success:
                raise ArithmeticError(f"no elastica at Gamma = {load:g}: {solved.message}")
            s, y = solved.x, solved.y
        last = gamma
        found.append(abs(y[3, -1] / y[2, -1]))
    return np.array(found)


def strip(fabric: Fabric, cells: tuple[int, int], degree: int) -> Shell:
    """A strip clamped at one end that bends in a plane; cells finer towards the clamp."""

    def place(a, b):
        return OVERHANG * (0.2 * a + 0.8 * a**2), WIDTH * b, 0 * a

    surface = meshes.patch(place, cells, degree).replace(warp=(1.0, 0.0, 0.0))
    shell = Shell(surface, fabric, MPI.COMM_SELF)
    shell.supports.clamp("left")
    for edge in ("bottom", "top"):
        shell.supports.symmetry(edge, (0.0, 1.0, 0.0))
    return shell


def cantilever(
    fabric: Fabric, gammas: Sequence[float], cells: tuple[int, int] = (32, 2), degree: int = 1
) -> np.ndarray:
    """Fall of the tip over its reach at rising Gammas of the warp."""
    shell = strip(fabric, cells, degree)
    unit = fabric.bending[0, 0] / OVERHANG**3 / fabric.areal_mass
    shell.loads.gravity((0.0, 0.0, -unit))
    tip, found = shell.partition.find("right"), []
    with Statics(shell) as statics:
        for _ in statics.march(gammas):
            u = shell.displacements()[tip].mean(axis=0)
            found.append(-u[2] / (OVERHANG + u[0]))
    return np.array(found)


def bending_from_tension(fabric: Fabric) -> Fabric:
    """The same cloth taken for a solid sheet: D = A t^2/12."""
    A, t = fabric.membrane, fabric.thickness
    return Fabric.from_stiffness(A, A * t**2 / 12, fabric.areal_mass, t, name="as a solid sheet")


def main(given: Sequence[str] | None = None) -> None:
    asked = options(given, "Independent bending and tension: a cantilever and a drape.")
    cloth = measured_fabric(SUITING, name="suiting")
    gammas = GAMMAS[:3] if asked.quick else GAMMAS
    exact = elastica(gammas)
    rows = [{"Gamma": gamma, "fall/reach": value} for gamma, value in zip(gammas, exact)]
    for name, cells, degree in (("4-node", (32, 2), 1), ("9-node", (16, 1), 2)):
        for row, value in zip(rows, cantilever(cloth, gammas, cells, degree) / exact - 1):
            row[f"{name}, off %"] = 100 * value
    print_table("Cantilever under its own weight against the elastica", rows, list(rows[0]))
    write_table(f"{asked.out}/gan_cantilever.csv", rows)

    rows = []
    for bending, fabric in (("measured", cloth), ("E t^3/12", bending_from_tension(cloth))):
        D = fabric.bending[0, 0]
        gamma = fabric.areal_mass * 9.81 * 0.1**3 / D
        fall = elastica([gamma])[0]
        row = {"bending": bending, "D [uN m]": 1e6 * D, "fall/reach of 10 cm": fall}
        rows.append(row | drapes(fabric, asked))
    print_table("The same cloth with its bending measured and from tension", rows, list(rows[0]))
    write_table(f"{asked.out}/gan_drape.csv", rows)


if __name__ == "__main__":
    console.run(main)
