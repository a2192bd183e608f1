# SPDX-License-Identifier: LGPL-3.0-or-later
r"""How far a drape can be trusted: refinement, stable states, membranes and methods compared.

    python -m demos.studies.drape.run refinement   # meshes and time steps
    python -m demos.studies.drape.run refinement --bending 2.29e-3 --damping 2e-5 --cells 12 16 24
    python -m demos.studies.drape.run starts       # states found from slightly different starts
    python -m demos.studies.drape.run membrane     # arcs and chords; --part folds|drape|push
    python -m demos.studies.drape.run methods      # explicit and implicit steps, particles, others
    mpirun -n 2 python -m demos.studies.drape.run starts --quick

Each prints tables and leaves them as CSV with summary.json and a picture in the folder; `--quick`
runs small sheets for a short while, to see that all is in order. The sheet is that of drape.py;
drag of 3 1/s brings it to rest in 3 s, so that what differs is not what still moves. The second
command takes a sheet 25 times as stiff, whose bending length (D/(rho t g))^(1/3) is 0.1 m: it has
one state where cloth has many. Costs are seconds of processor time: other programs on the machine
lengthen them less than they do the wait.
"""

import argparse
from pathlib import Path

from mpi4py import MPI

import numpy as np

from demos.studies.drape import square
from demos.studies.drape.figures import (
    COST,
    draw_methods,
    draw_refinement,
    draw_starts,
    print_table,
    write_table,
)
from demos.studies.drape.membranes import membrane
from shellform import console
from shellform.results.report import Report

COMM = MPI.COMM_WORLD
LEADING = ["height", "corner_z", "force_up", "strain"]
# measured once with the versions and settings named: the same scene, pinned at a corner
OTHERS = [
    {"method": "MuJoCo 4.0.0, discrete, 1 ms", "cells": 20, "height": -0.2407, "force_up": 1.606},
    {"method": "MuJoCo 4.0.0, discrete, 0.5 ms", "cells": 20, "height": -0.2431, "force_up": 1.680},
    {"method": "MuJoCo 4.0.0, discrete, 1 ms", "cells": 40, "height": -0.2417, "force_up": 1.661},
    {"method": "MuJoCo 4.0.0, Euler, 0.1 ms", "cells": 20, "height": -0.2402, "force_up": 1.586},
    {"method": "Newton 1.8.0 VBD, 10 iterations", "cells": 20, "height": -0.2452},
    {"method": "Newton 1.8.0 VBD, 40 iterations", "cells": 20, "height": -0.2341},
    {"method": "Newton 1.8.0 VBD, 10 iterations", "cells": 40, "height": -0.2493},
    {"method": "Newton 1.8.0 Style3D, 10 iterations", "cells": 20, "height": -0.2360},
]


def arguments(given):
    parser = argparse.ArgumentParser(allow_abbrev=False, description="Studies of a drape.")
    positive = console.positive
    studies = parser.add_subparsers(dest="study", required=True)
    for name, function, cells in STUDIES:
        sub = studies.add_parser(name, allow_abbrev=False, help=function.__doc__.replace("%", "%%"))
        sub.set_defaults(function=function, default_cells=cells)
        # the other simulators were run for 2 s with little drag
        drag, seconds = (0.5, 2.0) if name == "methods" else (3.0, 3.0)
        sub.add_argument("--cells", type=positive(int), nargs="+", help="a side, coarse to fine")
        sub.add_argument("--seconds", type=positive(float), default=seconds)
        sub.add_argument("--drag", type=float, default=drag, help="1/s")
        sub.add_argument("--quick", action="store_true", help="small sheets, a short while")
        sub.add_argument("--out", help="folder (default out/drape_study/STUDY)")
        if name == "refinement":
            sub.add_argument("--bending", type=positive(float), default=9.16e-5, help="N m")
            sub.add_argument("--damping", type=float, default=2e-4, help="s")
        if name != "methods":
            starts = 5 if name == "starts" else 3
            sub.add_argument("--starts", type=positive(int), default=starts)
        if name == "membrane":
            sub.add_argument("--part", choices=("folds", "drape", "push"), default="folds")
            sub.add_argument("--reference", type=positive(int), help="cells of the reference")
    options = console.parse(parser, given)
    options.out = Path(options.out or Path("out/drape_study") / options.study)
    options.cells = options.cells or ([4, 6, 8] if options.quick else options.default_cells)
    if options.quick:
        options.seconds = min(options.seconds, 0.25)
    if options.seconds <= square.WINDOW:
        parser.error(f"--seconds must be longer than the {square.WINDOW} s of the means")
    return options


def refinement(options, report):
    """Meshes, each from several starts, then time steps."""
    rows, steps = [], []
    cloth = {"bending": options.bending, "damping": options.damping}
    for n in console.progress(options.cells, len(options.cells), "meshes"):
        few = options.starts if n <= 32 else 1
        runs = [square.row(options, cells=n, start=k, **cloth) for k in range(few)]
        row = {"cells": n, "starts": few} | {k: np.mean([r[k] for r in runs]) for k in LEADING}
        for key in LEADING:
            row[f"{key}_spread"] = np.ptp([r[key] for r in runs]) / 2 if few > 1 else np.nan
        rows.append(row | {k: np.mean([r[k] for r in runs]) for k in ["folds", "kinetic", *COST]})
        if n in options.cells[1:3]:
            steps.append(runs[0])
            for factor in (0.45, 0.225):
                steps.append(square.row(options, cells=n, factor=factor, **cloth))
    spread = [f"{k}_spread" for k in LEADING]
    columns = ["cells", "starts", *[k for pair in zip(LEADING, spread, strict=True) for k in pair]]
    print_table("Meshes, means over the starts", rows, [*columns, "folds", "kinetic", *COST])
    verdicts = [verdict(rows, key) for key in LEADING]
    print_table("Orders", verdicts, list(verdicts[0]))
    times = ["cells", "factor", *LEADING, "folds", "kinetic", *COST]
    print_table("Time steps, from rest", steps, times)
    write_table(options.out / "meshes.csv", rows)
    write_table(options.out / "orders.csv", verdicts)
    write_table(options.out / "time_steps.csv", steps)
    draw_refinement(options.out / "refinement.png", rows, steps, LEADING)
    report.write({"meshes": rows, "orders": verdicts, "time_steps": square.numbers(steps)})


def verdict(rows, key):
    """Order of a quantity from the meshes that double, if it has one."""
    found = {row["cells"]: row[key] for row in rows}
    orders = [
        (n, order(found[n], found[2 * n], found[4 * n]))
        for n in found
        if 2 * n in found and 4 * n in found
    ]
    spreads = [row[f"{key}_spread"] for row in rows if row["starts"] > 1]
    last = abs(rows[-1][key] - rows[-2][key])
    noise = float(np.max(spreads[-2:])) if spreads else np.nan
    clear = [o for _, o in orders if np.isfinite(o)]
    # one triple of meshes shows a ratio, not that it stays
    sure = len(clear) == len(orders) > 1 and np.ptp(clear) < 1 and not last < noise
    return {
        "quantity": key,
        "orders": "  ".join(f"{n}-{2 * n}-{4 * n}: {o:.2f}" for n, o in orders) or "-",
        "last_change": last,
        "spread_of_starts": noise,
        "says": f"order {np.mean(clear):.1f}" if sure else "none shown",
    }


def order(coarse, middle, fine):
    """Observed order from three meshes of halved cells; NaN if the differences change sign."""
    ratio = (coarse - middle) / (middle - fine) if middle != fine else np.nan
    return float(np.log2(ratio)) if ratio > 0 else np.nan


def starts(options, report):
    """States found from pushes of 2 % of the speed at which the sheet meets the sphere."""
    rows, groups = [], []
    for pinned in (True, False):
        for n in console.progress(options.cells, len(options.cells), "meshes"):
            for k in range(1, options.starts + 1):
                rows.append(square.row(options, cells=n, pinned=pinned, start=k))
        mine = [row for row in rows if row["pinned"] == pinned]
        rims = [row["rim"] for row in mine]
        for row, state in zip(mine, square.states(rims, pinned), strict=True):
            row["state"] = int(state)
        for n in options.cells:
            runs = [row for row in mine if row["cells"] == n]
            gaps = [
                square.difference(a["rim"], b["rim"], pinned)
                for i, a in enumerate(runs)
                for b in runs[:i]
            ]
            group = {"pinned": pinned, "cells": n, "states": len({r["state"] for r in runs})}
            group["folds"] = "-".join(map(str, sorted({r["folds"] for r in runs})))
            group |= {"nearest": min(gaps, default=0.0), "farthest": max(gaps, default=0.0)}
            for key in [*LEADING, "force_side"]:
                values = [r[key] for r in runs]
                group |= {key: np.mean(values), f"{key}_spread": np.ptp(values) / 2}
            groups.append(group)
    columns = ["pinned", "cells", "start", "state", "folds", *LEADING, "force_side", "kinetic"]
    print_table("Runs", rows, columns)
    print_table("Spread (half of the range) over the starts", groups, list(groups[0]))
    write_table(options.out / "starts.csv", rows)
    write_table(options.out / "spread.csv", groups)
    draw_starts(options.out / "starts.png", rows, options.cells)
    report.write({"runs": square.numbers(rows), "spread": groups})


def methods(options, report):
    """One drape by every method; implicit steps, the dearest, on the first mesh only."""
    first, rows = options.cells[0], []
    for n in console.progress(options.cells, len(options.cells), "meshes"):
        rows.append(square.row(options, {"method": "shell, explicit"}, cells=n))
        if n == first:
            label = {"method": "shell, implicit"}
            rows.append(square.row(options, label, cells=n, model="implicit", factor=4.0))
        if COMM.size == 1:
            label = {"method": "particles"}
            rows.append(square.row(options, label, cells=n, model="particles"))
    if COMM.rank == 0 and COMM.size > 1:
        print("particles are left out: they run on one rank only")
    others = [row | {"source": "other simulator"} for row in OTHERS]
    columns = ["method", "cells", *LEADING, "pin_up", "folds", "kinetic", *COST, "source"]
    rows = [row | {"source": "here"} for row in rows]
    print_table("Methods", [*rows, *others], columns)
    write_table(options.out / "methods.csv", [*rows, *others])
    draw_methods(options.out / "methods.png", [row for row in rows if row["cells"] == first])
    report.write({"runs": square.numbers(rows), "others": others})


STUDIES = (
    ("refinement", refinement, [12, 16, 24, 32, 48, 64]),
    ("starts", starts, [16, 24, 32]),
    ("membrane", membrane, None),
    ("methods", methods, [12, 24]),
)


def main(given=None):
    options = arguments(given)
    settings = {k: v for k, v in vars(options).items() if k != "function"}
    report = Report(options.out, f"drape study, {options.study}", settings, COMM)
    options.function(options, report)
    if COMM.rank == 0:
        print(f"wrote {options.out}/")


if __name__ == "__main__":
    console.run(main)
