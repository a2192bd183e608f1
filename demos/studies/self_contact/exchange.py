# SPDX-License-Identifier: LGPL-3.0-or-later
"""What ranks pay for knowing all of a sheet that meets itself: an exchange beside a step.

    mpirun -n 2 python -m demos.studies.self_contact.exchange --cells 36 140

prints the least time of an exchange of 9 numbers a node, and of a step of a sheet at rest without
self-contact, of square sheets of so many cells a side [us].
"""

import argparse
import time
from collections.abc import Callable

from mpi4py import MPI

import meshes
from shellform import Fabric, Newmark, SelfContact, Shell
from shellform.console import parse, positive, run, say

COMM = MPI.COMM_WORLD


def least(call: Callable[[], object], rounds: int = 12, times: int = 10) -> float:
    """Least mean time of calls of all ranks [us]."""
    found = []
    for _ in range(rounds):
        COMM.Barrier()
        start = time.perf_counter()
        for _ in range(times):
            call()
        found.append(COMM.allreduce(time.perf_counter() - start, MPI.MAX) / times)
    return 1e6 * min(found)


def stepper_of(cells: int) -> Newmark:
    """Explicit steps of a square sheet."""
    fabric = Fabric.isotropic(1e5, 0.3, thickness=1e-3, density=200.0)
    return Newmark(Shell(meshes.rectangle(1.0, 1.0, (cells, cells)), fabric))


def main(given=None) -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cells", type=positive(int), nargs="+", default=[36, 140])
    for cells in parse(parser, given).cells:
        stepper = stepper_of(cells)
        step = least(lambda stepper=stepper: stepper.step(stepper.dt))
        cloth = stepper.add(SelfContact())
        own = stepper.owned[:, :3].copy()
        exchange = least(lambda cloth=cloth, own=own: cloth.everywhere(own, own, own))
        nodes = len(stepper.shell.surface.points)
        say([f"{nodes:8d} nodes: exchange {exchange:8.1f} us, step {step:8.1f} us"])


if __name__ == "__main__":
    run(main)
