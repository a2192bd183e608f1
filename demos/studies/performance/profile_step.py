# SPDX-License-Identifier: LGPL-3.0-or-later
r"""Where the time of an explicit step goes, and how far that is from what the machine can do.

    python -m demos.studies.performance.profile_step           # drapes of 1e3 to 5e4 nodes
    python -m demos.studies.performance.profile_step --walk    # and a walk in trousers
    mpirun -n 2 python -m demos.studies.performance.profile_step         # with what ranks exchange

prints microseconds a node and step and the share of every part, as a table, and leaves
summary.json. The machine's limit is measured too: a triad a = b + s c for the traffic to memory.
Against it stand the arrays that a step must touch at least once.
"""

import argparse
import time
from collections import Counter
from contextlib import contextmanager
from pathlib import Path

from mpi4py import MPI

import numba
import numpy as np

from demos.studies.drape.square import Scene as Drape
from demos.studies.drape.square import build
from shellform.console import parse, positive, run
from shellform.contact_coupling.explicit_contact import ExplicitContact
from shellform.dynamics import explicit_drift, explicit_kernels
from shellform.dynamics.explicit import Newmark
from shellform.dynamics.external_force import ExternalForce
from shellform.dynamics.time_stepper import Stepper
from shellform.fem.internal_force import InternalForce
from shellform.results.joint_torque import Torque
from shellform.results.report import Report
from shellform.results.skin_pressure import Pressure
from shellform.scene.parts import Motion
from shellform.scene.scene import Scene
from shellform.simulation.model import Model

COMM = MPI.COMM_WORLD
GAP = 0.05  # between sheet and sphere there [m]
PARTS = {  # part -> what is timed: (owner, name)
    "internal force": [(InternalForce, "__call__")],
    "contact": [(ExplicitContact, "__call__")],
    "nodal kernels": [
        *((explicit_kernels, name) for name in ("kick", "book", "ahead")),
        (explicit_drift, "drift"),
    ],
    "loads, belt": [(ExternalForce, "update")],
    "torque, pressure": [(Torque, "__call__"), (Pressure, "__call__")],
    "exchange among ranks": [(Stepper, "scatter")],
    "stable step": [(Newmark, "find_stable_step")],
}
REST = "Python of the step"


class Meter:
    """Seconds and bytes of arrays by part, while `watching`; a part inside another counts once.

    Attributes
    ----------
    seconds, calls : Counter by part; bytes : by part, of the arrays handed over in its last call
    """

    def __init__(self):
        self.seconds, self.calls, self.bytes = Counter(), Counter(), {}
        self._stack = []

    def timed(self, part, function):
        def call(*given, **named):
            start, outer = time.perf_counter(), self._stack[-1:] or [[0.0]]
            self._stack.append([0.0])
            try:
                return function(*given, **named)
            finally:
                took, inner = time.perf_counter() - start, self._stack.pop()[0]
                outer[0][0] += took
                self.seconds[part] += took - inner
                self.calls[part] += 1
                self.bytes[part] = self.bytes.get(part, 0) + bytes_of(given)

        return call

    @contextmanager
    def watching(self):
        """Times all PARTS in the block."""
        kept = [
            (owner, name, owner.__dict__[name]) for part in PARTS.values() for owner, name in part
        ]
        for part, places in PARTS.items():
            for owner, name in places:
                setattr(owner, name, self.timed(part, owner.__dict__[name]))
        try:
            yield self
        finally:
            for owner, name, function in kept:
                setattr(owner, name, function)


def bytes_of(given):
    """Bytes of all arrays among arguments, those in records of arrays included."""
    if isinstance(given, np.ndarray):
        return given.nbytes
    return sum(map(bytes_of, given)) if isinstance(given, tuple) else 0


def profile(stepper, until):
    """Advance to `until` [s]; dict of microseconds a node and step, all ranks' time, by part."""
    stepper.advance(stepper.time + 20 * stepper.dt)
    meter, first = Meter(), stepper.steps
    COMM.Barrier()
    with meter.watching():
        start = time.perf_counter()
        stepper.advance(until)
        COMM.Barrier()
        total = time.perf_counter() - start
    work = (stepper.steps - first) * len(stepper.shell.surface.points)
    seconds = {part: COMM.allreduce(meter.seconds[part]) for part in PARTS}
    total = COMM.allreduce(total)
    seconds[REST] = total - sum(seconds.values())
    return {part: 1e6 * s / work for part, s in seconds.items()} | {"all": 1e6 * total / work}


# ## What the machine can do


@numba.njit(cache=True, fastmath=True)
def triad(a, b, c, scale):
    for i in range(len(a)):
        a[i] = b[i] + scale * c[i]


def bandwidth(size=8_000_000):
    """Bytes a second that one core moves, the best of five."""
    a, b, c = np.zeros((3, size))
    best = np.inf
    for _ in range(6):  # the first compiles
        start = time.perf_counter()
        triad(a, b, c, 0.5)
        best = min(best, time.perf_counter() - start)
    return 24.0 * size / best


def traffic(stepper):
    """Bytes a node that a step must move at least once: arrays of the force and the kernels."""
    meter = Meter()
    with meter.watching():
        stepper.advance(stepper.time + stepper.dt)
    quads = stepper.force_model.internal.quads.nbytes
    nodal = meter.bytes["nodal kernels"]
    return (quads + 3 * stepper.owned.nbytes + nodal) / len(stepper.mass)


# ## Tables


def drape(cells, damping, seconds):
    """Profile of a sheet let go where it touches the sphere of drape.py."""
    stepper, _ = build(Drape(cells=cells, damping=damping, pinned=False))
    stepper.owned[:, 2] -= GAP
    stepper.scatter()
    steps = max(100, int(seconds / (1e-6 * cells**2)))
    stepper.advance(0.3 * steps * stepper.dt)
    return profile(stepper, stepper.time + steps * stepper.dt), stepper


def walk():
    """Profile of a walk at draft, after dressing."""
    model = Model(Scene(motion=Motion(end=1.6)), COMM)
    model.dress()
    stepper = model.stepper
    stepper.add(Torque())
    stepper.add(Pressure())
    stepper.advance(0.6)
    return profile(stepper, 1.4), stepper


def table(columns):
    """Markdown: parts in rows, scenes in columns, microseconds a node and step (share)."""
    lines = ["| part | " + " | ".join(columns) + " |", "|---" * (len(columns) + 1) + "|"]
    for part in [*PARTS, REST, "all"]:
        cells = []
        for found in columns.values():
            share = "" if part == "all" else f" ({100 * found[part] / found['all']:.0f} %)"
            cells.append(f"{found[part]:.3f}{share}")
        lines.append(f"| {part} | " + " | ".join(cells) + " |")
    return lines


def limit_line(best, moved):
    """Line for a person on the machine's limit."""
    return (
        f"\none core moves {1e-9 * best:.1f} GB/s: the {moved:.0f} bytes a node of a step "
        f"take {1e6 * moved / best:.3f} us"
    )


def arguments(given):
    parser = argparse.ArgumentParser(allow_abbrev=False, description=__doc__.split("\n")[0])
    parser.add_argument("--cells", type=int, nargs="+", default=[32, 100, 224], help="a side")
    parser.add_argument("--walk", action="store_true", help="a walk in trousers too")
    parser.add_argument("--seconds", type=positive(float), default=3.0, help="of each run")
    parser.add_argument("--out", type=Path, default=Path("out/profile_step"))
    return parse(parser, given)


def main(given=None):
    options = arguments(given)
    report = Report(options.out, "profile_step", vars(options), COMM)
    columns, moved = {}, 0.0
    with report.stage("solve"):
        for cells in options.cells:
            for damping in (0.0, 2e-4):
                name = f"drape {cells} x {cells}" + (", damped" if damping else "")
                columns[name], stepper = drape(cells, damping, options.seconds)
                moved = moved if damping else traffic(stepper)
        if options.walk:
            columns["walk"], stepper = walk()
    report.describe(stepper.shell)
    best = bandwidth()
    results = {"columns": columns, "bytes_a_second": best, "bytes_a_node": moved}
    report.write(results, steps=stepper.steps, newton_iterations=0)
    if COMM.rank == 0:
        print("\n".join(table(columns)))
        print(limit_line(best, moved))
        print(f"wrote {options.out}/summary.json")


if __name__ == "__main__":
    run(main)
