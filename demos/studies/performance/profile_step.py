# SPDX-License-Identifier: LGPL-3.0-or-later
r"""Where the time of an explicit step goes, and how far that is from what the machine can do.

    python -m demos.studies.performance.profile_step           # drapes of 1e3 to 5e4 nodes
    python -m demos.studies.performance.profile_step --walk    # and a walk in trousers
    mpirun -n 2 python -m demos.studies.performance.profile_step         # with what ranks exchange

prints microseconds a node and step and the share of every part, as a table, and leaves
summary.json. The machine's two limits are measured too: a triad a = b + s c for the traffic to
memory, polynomials in vector registers for arithmetic. Against them stand the arrays that a step
must touch at least once, and the operations of the force, counted by running its Python on numbers
that count.
"""

import argparse
import time
from collections import Counter
from contextlib import contextmanager
from pathlib import Path
from types import FunctionType

from mpi4py import MPI

import numba
import numpy as np

from demos.studies.drape.square import Scene as Drape
from demos.studies.drape.square import build
from shellform.console import parse, positive, run
from shellform.contact_coupling.explicit_contact import ExplicitContact
from shellform.dynamics import explicit_kernels
from shellform.dynamics.explicit import Newmark
from shellform.dynamics.external_force import ExternalForce
from shellform.dynamics.time_stepper import Stepper
from shellform.fem.internal_force import InternalForce
from shellform.fem.quad_kernel import add_force
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
    "nodal kernels": [(explicit_kernels, name) for name in ("kick", "book", "drift", "ahead")],
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


@numba.njit(cache=True, fastmath={"contract", "nsz"})
def polynomial(values, x, y):
    """64 times v x + y of every value, which the compiler turns into vector instructions."""
    for i in range(len(values)):
        v = values[i]
        for _ in range(64):
            v = v * x + y
        values[i] = v


def limits(size=8_000_000, rounds=40):
    """Bytes and operations a second of one core, the best of five."""
    a, b, c = np.zeros((3, size))
    few, best = np.ones(4096), [np.inf, np.inf]
    for _ in range(6):  # the first compiles
        start = time.perf_counter()
        triad(a, b, c, 0.5)
        middle = time.perf_counter()
        for _ in range(rounds):
            polynomial(few, 0.999, 0.001)
        end = time.perf_counter()
        best = [min(best[0], middle - start), min(best[1], end - middle)]
    return {"bytes": 24.0 * size / best[0], "operations": 128.0 * len(few) * rounds / best[1]}


class Counting:
    """A number that counts what is done with it."""

    done = 0

    def __init__(self, value):
        self.value = float(value)

    def _do(self, other, result):
        Counting.done += 1
        return Counting(result(self.value, float(getattr(other, "value", other))))

    def __add__(self, other):
        return self._do(other, lambda a, b: a + b)

    def __sub__(self, other):
        return self._do(other, lambda a, b: a - b)

    def __rsub__(self, other):
        return self._do(other, lambda a, b: b - a)

    def __mul__(self, other):
        return self._do(other, lambda a, b: a * b)

    def __truediv__(self, other):
        return self._do(other, lambda a, b: a / b)

    def __rtruediv__(self, other):
        return self._do(other, lambda a, b: b / a)

    def __neg__(self):
        return Counting(-self.value)

    __radd__, __rmul__ = __add__, __mul__


def interpreted(compiled):
    """The Python of a numba function and of all it calls."""
    function = compiled.py_func
    names = dict(function.__globals__)
    for name in function.__code__.co_names:
        if hasattr(names.get(name), "py_func"):
            names[name] = interpreted(names[name])
    return FunctionType(function.__code__, names)


def operations(damped):
    """Sums, products and quotients of the force of one cell."""
    counted = np.vectorize(Counting, otypes=[object])
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0.1]])
    w = np.concatenate([0 * points, np.tile([0.0, 0.0, 1.0], (4, 1))], axis=1)
    cell, r = np.array([[0, 1, 2, 3]]), counted(np.zeros((4, 6)))
    given = [counted(a) for a in (points, np.ones((1, 4, 15)), np.zeros((1, 18)))]
    Counting.done = 0
    force = interpreted(add_force)
    force(counted(w), counted(w + 0.01), damped, given[0], cell, given[1], given[2], r)
    return Counting.done


def traffic(stepper):
    """Bytes a node that a step must move at least once: arrays of the force and the kernels."""
    meter = Meter()
    with meter.watching():
        stepper.advance(stepper.time + stepper.dt)
    quads = sum(a.nbytes for a in stepper.force_model.internal._quads)
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


def table_lines(best, moved, counted):
    """Lines for a person on the machine's limits."""
    rate = best["operations"]
    lines = [
        f"\none core moves {1e-9 * best['bytes']:.1f} GB/s: the {moved:.0f} bytes a node of a step "
        f"take {1e6 * moved / best['bytes']:.3f} us"
    ]
    for name, count in counted.items():
        lines.append(
            f"and does {1e-9 * rate:.1f}e9 operations a second: the {count} of the {name} force of "
            f"a cell take {1e6 * count / rate:.3f} us"
        )
    return lines


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
    best = limits()
    counted = {"undamped": operations(False), "damped": operations(True)}
    results = {
        "columns": columns, "limits": best, "operations_a_cell": counted, "bytes_a_node": moved
    }  # fmt: skip
    report.write(results, steps=stepper.steps, newton_iterations=0)
    if COMM.rank == 0:
        print("\n".join(table(columns)))
        print("\n".join(table_lines(best, moved, counted)))
        print(f"wrote {options.out}/summary.json")


if __name__ == "__main__":
    run(main)
