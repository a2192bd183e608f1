# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cloth on rods thinner than its cells: does it hang for good, and with its weight?

    python -m demos.studies.thin_rods.run
    python -m demos.studies.thin_rods.run --rods 1 5 --cells 40 --seconds 2

A strip of 0.48 x 0.1 m falls by 1 mm onto a rod across it and hangs over it, in ten alignments:
the rod 0 to 0.9 of a cell off the middle, the last five turned as well, by up to 45 degrees. Arms
of 240 + 36 and 240 - 36 mm are held by friction 0.3, as exp(0.3 pi) = 2.57. For each rod and size
of cells the table gives the alignments that fell, the mean force of the last second over the weight
where it is farthest from one, the deepest that a node or an edge began a step below the surface at
which it is held (cloth that goes through comes to radius and half thickness), and the time a run
took. With little drag (`--drag 1`) a strip askew swings, and may slide off over the rod.
"""

import argparse
import time
from pathlib import Path

from mpi4py import MPI

import numpy as np

import meshes
from contact.body.segments import Body, Fixed, Segment
from contact.geometry.capsule import Capsule
from shellform import Fabric, Shell, console
from shellform.contact_coupling.contact import Contact
from shellform.dynamics.explicit import Newmark

ANGLES = 0, 0, 0, 0, 0, 5, 15, 25, 35, 45  # degrees, one for each alignment
LENGTH, WIDTH, THICKNESS, AREAL_MASS, G = 0.48, 0.1, 1e-3, 0.2, 9.81
FABRICS = {"stiff": None, "limp": 1e-6}  # bending stiffness [N m]; None: of the solid sheet


def hang(
    rod: float, cell: float, alignment: int, fabric: str, seconds: float, drag: float
) -> tuple[float | None, float, float]:
    """Time of the fall [s] or None, force over weight in the last second, greatest depth [m].

    rod : diameter [m]; cell : size [m]; alignment : 0 to 9
    """
    radius, angle = 0.5 * rod, np.radians(ANGLES[alignment])
    cloth = Fabric.isotropic(
        1e6, 0.3, THICKNESS, AREAL_MASS / THICKNESS, bending_stiffness=FABRICS[fabric]
    )
    counts = round(LENGTH / cell), max(1, round(WIDTH / cell))
    shift = cell * alignment / 10
    surface = meshes.rectangle(LENGTH, WIDTH, counts).transform(
        translation=(shift - 0.5 * LENGTH, -0.5 * WIDTH, radius + 0.5 * THICKNESS + 1e-3)
    )
    shell = Shell(surface, cloth)
    shell.loads.gravity((0.0, 0.0, -G))
    stepper = Newmark(shell, drag=drag, damping=1e-5)
    c, s = np.cos(angle), np.sin(angle)
    axes = np.array([[-s, c, 0.0], [-c, -s, 0.0], [0.0, 0.0, 1.0]])
    body = Body([Segment("rod", Capsule(2.0, radius), Fixed((0.0, 0.0, 0.0), axes))])
    touch = stepper.add(Contact(body, friction=0.3))
    deepest = 0.0

    def look(stepper, dt):
        nonlocal deepest
        deepest = max(deepest, touch.max_depth)

    stepper.add(look)
    for until in np.arange(0.1, seconds + 0.05, 0.1):
        stepper.advance(until)
        if shell.positions()[:, 2].max() < -radius:
            return until, np.nan, deepest
        if until < seconds - 0.95:
            touch.reset()
    pushed = shell.comm.allreduce(touch.window.table[0, 2])
    return None, pushed / touch.window.seconds / (AREAL_MASS * LENGTH * WIDTH * G), deepest


def main(given: list[str] | None = None) -> None:
    """Print the table and leave it as CSV."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", maxsplit=1)[0])
    parser.add_argument("--rods", type=float, nargs="+", default=[1, 2, 3, 5, 10], help="mm")
    parser.add_argument("--cells", type=float, nargs="+", default=[12, 20, 40], help="mm")
    parser.add_argument("--fabric", choices=FABRICS, default="stiff")
    parser.add_argument("--seconds", type=float, default=5.0)
    parser.add_argument("--drag", type=float, default=4.0, help="1/s")
    parser.add_argument("--out", type=Path, default=Path("out/thin_rods"))
    options = console.parse(parser, given)
    first = MPI.COMM_WORLD.rank == 0
    lines = ["rod_mm,cells_mm,alignments,fell,force_over_weight,deepest_mm,seconds_a_run"]
    for rod in options.rods:
        for cell in options.cells:
            clock, fell, worst, deepest = time.perf_counter(), 0, 1.0, 0.0
            for alignment in range(len(ANGLES)):
                fall, share, depth = hang(
                    1e-3 * rod,
                    1e-3 * cell,
                    alignment,
                    options.fabric,
                    options.seconds,
                    options.drag,
                )
                fell += fall is not None
                deepest = max(deepest, MPI.COMM_WORLD.allreduce(depth, MPI.MAX))
                if fall is None and abs(share - 1.0) > abs(worst - 1.0):
                    worst = share
            each = (time.perf_counter() - clock) / len(ANGLES)
            figures = f"{fell},{worst:.4f},{1e3 * deepest:.1e},{each:.1f}"
            lines.append(f"{rod:g},{cell:g},{len(ANGLES)},{figures}")
            if first:
                print(lines[-1], flush=True)
    if first:
        options.out.mkdir(parents=True, exist_ok=True)
        path = options.out / f"thin_rods_{options.fabric}.csv"
        path.write_text("\n".join(lines) + "\n")
        print(f"wrote {path}")


if __name__ == "__main__":
    console.run(main)
