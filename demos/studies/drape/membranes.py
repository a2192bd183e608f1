# SPDX-License-Identifier: LGPL-3.0-or-later
"""Arcs against 2x2 Gauss points: the same cloth with both membranes, errors and cost in tables.

Three parts: `folds`, a curtain with one state, where errors are those of the element; `drape`,
where every figure is a mean over starts and has their spread beside it; `push`, long runs of a
sheet pushed together, where a membrane that buckles below the grid would break down.
"""

import numpy as np

from demos.studies.drape import hanging_folds, square
from demos.studies.drape.figures import COST, draw_membrane, print_table, write_table
from demos.studies.drape.hanging_folds import Curtain
from demos.studies.drape.square import numbers
from shellform.console import progress

CELLS = {"folds": [12, 16, 24, 32], "drape": [12, 16, 24], "push": [12]}
FINE = {"folds": 64, "drape": 48}  # cells of the reference


def membrane(options, report):
    """Arcs and chords on regular and distorted meshes."""
    options.cells = options.cells or CELLS[options.part]
    if options.part == "push":
        return stability(options, report)
    fine = options.reference or (12 if options.quick else FINE[options.part])
    curtain = options.part == "folds"
    keys = ["height", "depth", "hem", "side", "strain", "membrane_energy"]
    keys = keys if curtain else ["height", "force_up", "strain"]

    def one(**settings):
        if not curtain:
            runs = [square.row(options, start=k, **settings) for k in range(options.starts)]
            return merged(runs, keys)
        settings = {"drag": options.drag, "seconds": options.seconds} | settings
        return settings | hanging_folds.run(Curtain(**settings))

    exact, rows = one(cells=fine) | {"membrane": "arcs", "distortion": 0.0}, []
    for kind in ("arcs", "chords"):
        for distortion in (0.0, 0.25):
            for n in progress(options.cells, len(options.cells), kind):
                row = one(cells=n, membrane=kind, distortion=distortion)
                for key in keys:
                    row[f"{key}_error"] = row[key] - exact[key]
                rows.append(row)
    errors = [f"{key}_error" for key in keys]
    spreads = [] if curtain else [f"{key}_spread" for key in keys]
    labels = ["membrane", "distortion", "cells"]
    columns = [*labels, *keys, *spreads, "folds", "kinetic", *COST]
    print_table("The reference first", [exact, *rows], columns)
    print_table("Less the reference", rows, [*labels, *errors])
    # of a drape, folds decide on the strain energy; the height is steadier
    key = "strain" if curtain else "height"
    gains = [gain(rows, exact, key, d, n) for d in (0.0, 0.25) for n in options.cells]
    print_table(f"Chords with the error in {key} of arcs", gains, list(gains[0]))
    write_table(options.out / f"{options.part}.csv", [exact, *rows])
    write_table(options.out / f"{options.part}_gain.csv", gains)
    draw_membrane(options.out / f"{options.part}.png", rows, exact)
    report.write({"reference": numbers([exact])[0], "runs": numbers(rows), "gain": gains})


def merged(runs, keys):
    """Means over runs in the first one's row, with half of their range."""
    row = dict(runs[0])
    for key in (*keys, *COST, "folds", "kinetic"):
        row[key] = float(np.mean([run[key] for run in runs]))
    for key in keys:
        row[f"{key}_spread"] = float(np.ptp([run[key] for run in runs]) / 2)
    return row


def gain(rows, exact, key, distortion, cells):
    """What chords cost for the error that arcs make with a number of cells.

    Errors of chords are a straight line in logarithms, drawn on beyond the last mesh if need be;
    NaN if it does not fall.
    """
    table = {
        kind: np.array(
            [
                (row["cells"], abs(row[key] / exact[key] - 1), row["seconds"], row["us"])
                for row in rows
                if row["membrane"] == kind and row["distortion"] == distortion
            ]
        ).T
        for kind in ("arcs", "chords")
    }
    k = list(table["arcs"][0]).index(cells)
    error = max(table["arcs"][1, k], 1e-12)
    n, e, seconds, _ = table["chords"]
    order, height = np.polyfit(np.log(n), np.log(np.maximum(e, 1e-12)), 1)
    needed = float(np.exp((np.log(error) - height) / order)) if order < 0 else np.nan
    power, start = np.polyfit(np.log(n), np.log(np.maximum(seconds, 1e-12)), 1)
    return {
        "distortion": distortion,
        "arcs_cells": cells,
        "error": error,
        "chords_cells": needed,
        "drawn_on": needed > n.max(),
        "gain_h^-3": (needed / cells) ** 3,
        "gain_measured": float(np.exp(start) * needed**power / table["arcs"][2, k]),
        "us_ratio": table["chords"][3, k] / table["arcs"][3, k],
    }


def stability(options, report):
    """Long runs of a sheet pushed together."""
    steps, rows = (1000 if options.quick else 100_000), []
    # parts of the width, of the stable step, and damping [s]
    cases = [(0.02, 0.9, 0.0), (0.25, 0.9, 0.0), (0.25, 0.45, 0.0), (0.25, 0.9, 2e-4)]
    for kind in ("arcs", "chords"):
        for n in options.cells:
            for gather, factor, damping in cases:
                row = {"membrane": kind, "cells": n, "gather": gather, "factor": factor}
                row |= {"damping": damping}
                rows.append(row | hanging_folds.pushed(kind, n, steps, gather, factor, damping))
    print_table("A sheet pushed together", rows, list(rows[0]))
    write_table(options.out / "push.csv", rows)
    report.write({"runs": rows})
