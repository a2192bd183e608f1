# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cloth on rods thinner than its cells: does it hang for good, and with its weight?

    python -m demos.studies.thin_rods.run
    python -m demos.studies.thin_rods.run --rods 1 5 --cells 40 --seconds 2

A strip of 0.48 x 0.1 m falls by 1 mm onto a rod across it and hangs over it, in ten alignments:
the rod 0 to 0.9 of a cell off the middle, the last five turned as well, by up to 45 degrees. Arms
of 240 + 36 and 240 - 36 mm are held by friction 0.3, as exp(0.3 pi) = 2.57.

For each rod and size of cells the table gives the alignments in which a row of nodes went through
the rod (passages.py), and those in which the strip slid off over it: with little drag (`--drag 1`)
a strip askew swings, and may do that. Then the mean force of the last second over the weight where
it is farthest from one, the deepest that a node or an edge began a step below the surface at which
it is held (cloth that goes through comes to radius and half thickness), and the time a run took.
"""

import argparse
import time
from pathlib import Path
from typing import NamedTuple

from mpi4py import MPI

import numpy as np

import meshes
from contact.body.segments import Body, Fixed, Segment
from contact.geometry.capsule import Capsule
from shellform import Fabric, Shell, console
from shellform.contact_coupling.contact import Contact
from shellform.dynamics.explicit import Newmark

from .passages import Passages

ANGLES = 0, 0, 0, 0, 0, 5, 15, 25, 35, 45  # degrees, one for each alignment
LENGTH, WIDTH, THICKNESS, AREAL_MASS, G = 0.48, 0.1, 1e-3, 0.2, 9.81
FABRICS = {"stiff": 9.2e-5, "limp": 1e-6}  # bending stiffness [N m]; a solid sheet of 1 MPa; cloth


class Hung(NamedTuple):
    """What became of a strip.

    passed : rows of nodes that went through the rod; off : time at which it was off the rod [s], or
    None; force : of the last second over the weight, NaN where it is off; depth : greatest [m]
    """

    passed: int
    off: float | None
    force: float
    depth: float


def axes_of(angle: float) -> np.ndarray:
    """Axes of a rod across the strip, e1 along it, turned by an angle [rad] about the vertical."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[-s, c, 0.0], [-c, -s, 0.0], [0.0, 0.0, 1.0]])


def rows_of(surface: meshes.Surface) -> list[np.ndarray]:
    """Nodes of a strip along x, row by row in y."""
    x, y, _ = surface.points.T
    width = np.round(y / 1e-6).astype(int)
    return [np.flatnonzero(width == w)[x[width == w].argsort()] for w in np.unique(width)]


def hang(
    rod: float,
    cell: float,
    alignment: int,
    fabric: str,
    seconds: float,
    drag: float,
    width: float = WIDTH,
    modulus: float = 1e6,
) -> Hung:
    """Let a strip hang over a rod.

    rod : diameter [m]; cell : size [m]; alignment : 0 to 9; width : of the strip [m]
    modulus : in the plane [Pa], lower ones allow longer steps
    """
    radius, axes = 0.5 * rod, axes_of(np.radians(ANGLES[alignment]))
    cloth = Fabric.isotropic(
        modulus, 0.3, THICKNESS, AREAL_MASS / THICKNESS, bending_stiffness=FABRICS[fabric]
    )
    counts = round(LENGTH / cell), max(1, round(width / cell))
    shift = cell * alignment / 10
    surface = meshes.rectangle(LENGTH, width, counts).transform(
        translation=(shift - 0.5 * LENGTH, -0.5 * width, radius + 0.5 * THICKNESS + 1e-3)
    )
    shell = Shell(surface, cloth)
    shell.loads.gravity((0.0, 0.0, -G))
    stepper = Newmark(shell, drag=drag, damping=1e-5)
    body = Body([Segment("rod", Capsule(2.0, radius), Fixed((0.0, 0.0, 0.0), axes))])
    touch = stepper.add(Contact(body, friction=0.3))
    passages = Passages(rows_of(surface), lambda t: (np.zeros(3), axes[0]))
    stepper.add(passages)
    deepest = 0.0

    def look(stepper, dt):
        nonlocal deepest
        deepest = max(deepest, touch.max_depth)

    stepper.add(look)
    for until in np.arange(0.1, seconds + 0.05, 0.1):
        stepper.advance(until)
        if shell.positions()[:, 2].max() < -radius:
            return Hung(np.count_nonzero(passages.passed), until, np.nan, deepest)
        if until < seconds - 0.95:
            touch.reset()
    pushed = shell.comm.allreduce(touch.window.table[0, 2]) / touch.window.seconds
    weight = AREAL_MASS * LENGTH * width * G
    return Hung(np.count_nonzero(passages.passed), None, pushed / weight, deepest)


def main(given: list[str] | None = None) -> None:
    """Print the table and leave it as CSV."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", maxsplit=1)[0])
    parser.add_argument("--rods", type=float, nargs="+", default=[1, 2, 3, 5, 10], help="mm")
    parser.add_argument("--cells", type=float, nargs="+", default=[12, 20, 40], help="mm")
    parser.add_argument("--fabric", choices=FABRICS, default="stiff")
    parser.add_argument("--seconds", type=float, default=5.0)
    parser.add_argument("--drag", type=float, default=4.0, help="1/s")
    parser.add_argument("--width", type=float, default=1e3 * WIDTH, help="of the strip, mm")
    parser.add_argument("--modulus", type=float, default=1.0, help="in the plane, MPa")
    parser.add_argument("--out", type=Path, default=Path("out/thin_rods"))
    options = console.parse(parser, given)
    first = MPI.COMM_WORLD.rank == 0
    lines = [
        "rod_mm,cells_mm,alignments,passed,slid_off,force_over_weight,deepest_mm,seconds_a_run"
    ]
    for rod in options.rods:
        for cell in options.cells:
            clock = time.perf_counter()
            runs = [
                hang(
                    1e-3 * rod,
                    1e-3 * cell,
                    alignment,
                    options.fabric,
                    options.seconds,
                    options.drag,
                    1e-3 * options.width,
                    1e6 * options.modulus,
                )
                for alignment in range(len(ANGLES))
            ]
            each = (time.perf_counter() - clock) / len(runs)
            passed = sum(run.passed > 0 for run in runs)
            slid = sum(run.passed == 0 and run.off is not None for run in runs)
            worst = max(
                (run.force for run in runs if run.off is None),
                key=lambda f: abs(f - 1),
                default=np.nan,
            )
            deepest = MPI.COMM_WORLD.allreduce(max(run.depth for run in runs), MPI.MAX)
            figures = f"{passed},{slid},{worst:.4f},{1e3 * deepest:.1e},{each:.1f}"
            lines.append(f"{rod:g},{cell:g},{len(runs)},{figures}")
            if first:
                print(lines[-1], flush=True)
    if first:
        options.out.mkdir(parents=True, exist_ok=True)
        path = options.out / f"thin_rods_{options.fabric}_drag_{options.drag:g}.csv"
        path.write_text("\n".join(lines) + "\n")
        print(f"wrote {path}")


if __name__ == "__main__":
    console.run(main)
