# SPDX-License-Identifier: LGPL-3.0-or-later
"""Do other versions of dolfinx, PETSc and numpy give the same digits, and at what speed?

    .venv/bin/python -m demos.studies.platforms.run --out out/debian12
    .venv-wheel/bin/python -m demos.studies.platforms.run --out out/wheel --against out/debian12

The first leaves numbers and times in out/debian12/summary.json; the second, under other versions,
prints its own beside them. Times are told as ratios; only those taken side by side, on one machine
with nothing else to do, mean much. One rank.

Digits are those of the demos and oracles: the tip of a strip rolled up, a drape (its strain energy,
height and the weight that the sphere bears), the tensions of a capstan, the torque and the friction
loss of a sleeve on a knee. A sheet that folds freely, as the drape does, multiplies roundoff as it
goes; --seconds tells how far it is followed.
"""

import argparse
import json
import time
from collections.abc import Callable
from pathlib import Path

from mpi4py import MPI

import numpy as np

import meshes
from demos import capstan, drape, hinge_sleeve, roll_up
from shellform import Fabric, Shell
from shellform.console import parse, positive, run
from shellform.fem.internal_force import InternalForce
from shellform.results.report import Report

DEMOS: dict[str, tuple[Callable, list[str]]] = {
    "roll_up": (roll_up.main, ["--cells", "16"]),
    "drape": (drape.main, ["--cells", "16"]),
    "capstan": (capstan.main, ["--cells", "8"]),
    "sleeve": (hinge_sleeve.main, ["--around", "24", "--friction", "0.2", "--cycles", "1"]),
}


def arguments(given):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", default="out/platforms", help="folder for results")
    parser.add_argument("--against", help="folder of another platform's results")
    parser.add_argument("--seconds", type=positive(float), default=0.5, help="of the drape")
    return parse(parser, given)


def numbers(value, name=""):
    """Every number in the results of a demo, by the path that leads to it."""
    if isinstance(value, dict):
        return {k: v for key, x in value.items() for k, v in numbers(x, f"{name}.{key}").items()}
    if isinstance(value, list):
        return {k: v for i, x in enumerate(value) for k, v in numbers(x, f"{name}.{i}").items()}
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    return {name: float(value)} if is_number else {}


def digits(options) -> dict[str, float]:
    """Results of the demos, times left out."""
    found = {}
    for name, (main, words) in DEMOS.items():
        folder = Path(options.out, name)
        more = ["--seconds", str(options.seconds)] if name == "drape" else []
        main([*words, *more, "--out", str(folder)])
        results = json.loads((folder / "summary.json").read_text())["results"]
        found |= numbers(results, name)
    timed = "second", "step_time", "core"
    return {key: value for key, value in found.items() if not any(t in key for t in timed)}


def best_of(function: Callable[[], object], turns: int = 7) -> float:
    """Least seconds that a call takes, after one that is not counted."""
    function()
    taken = []
    for _ in range(turns):
        start = time.perf_counter()
        function()
        taken.append(time.perf_counter() - start)
    return min(taken)


def times() -> dict[str, float]:
    """Seconds of a tangent and of an explicit force, 40 x 40 quads and as many triangles."""
    fabric = Fabric.isotropic(1e6, 0.3, thickness=1e-3, density=300.0)
    taken = {}
    for kind, triangles in (("quads", False), ("triangles", True)):
        shell = Shell(meshes.rectangle(1.0, 1.0, (40, 40), triangles=triangles), fabric)
        matrix, force = shell.create_tangent(), InternalForce(shell)
        w = shell.w.x.array.reshape(-1, 6)
        taken[f"tangent, {kind}"] = best_of(lambda s=shell, m=matrix: (s.tangent(m), m.assemble()))
        taken[f"explicit force, {kind}"] = best_of(lambda f=force, w=w: [f(w) for _ in range(50)])
    return taken


def show(mine, other):
    """Lines that set one platform's results beside another's."""
    lines = [
        f"{name}: {mine['versions'][name]}, there {v}" for name, v in other["versions"].items()
    ]
    own, theirs = mine["results"]["digits"], other["results"]["digits"]
    for name in DEMOS:
        keys = [key for key in theirs if key.startswith(f"{name}.") and key in own]
        # a component by the largest of its vector: one that is nought has roundoff alone
        largest: dict[str, float] = {}
        for k in keys:
            vector = k.rpartition(".")[0]
            largest[vector] = max(largest.get(vector, 1e-12), abs(theirs[k]))
        gaps = [abs(own[k] - theirs[k]) / largest[k.rpartition(".")[0]] for k in keys]
        worst = int(np.argmax(gaps))
        lines.append(
            f"{name}: {len(keys)} numbers, farthest apart {gaps[worst]:.1e} of {keys[worst]}"
        )
    for name, there in other["results"]["times"].items():
        lines.append(f"{name}: {mine['results']['times'][name] / there:.2f} of the time there")
    return lines


def main(given=None):
    """Numbers and times here, beside those of another platform if there are any."""
    options = arguments(given)
    report = Report(options.out, "platforms", vars(options), MPI.COMM_WORLD)
    report.write({"digits": digits(options), "times": times()})
    if options.against:
        here, there = (
            json.loads(Path(folder, "summary.json").read_text())
            for folder in (options.out, options.against)
        )
        print("\n".join(show(here, there)))


if __name__ == "__main__":
    run(main)
