# SPDX-License-Identifier: LGPL-3.0-or-later
r"""Error against cost, measured: what accuracy costs, scene by scene.

    python -m demos.studies.accuracy.run --case roll_up --budget 60 --out out/accuracy
    python -m demos.studies.accuracy.run --case all --budget 1500 --write
    python -m demos.studies.accuracy.run --held-out
    python -m demos.studies.accuracy.run --table

runs each scene with settings of rising cost until the budget [s of the wall clock] is spent, and
leaves error_and_cost.csv (all runs), error_and_cost.png (errors over cost with the best-choice
front: no other setting is both cheaper and better) and summary.json in the folder, and prints the
cheapest setting for errors of 10, 3, 1 and 0.3 %. `--write` puts what was found where `--accuracy`
reads it, the table shellform/accuracy/measured.csv. Cases that were not run keep their rows there,
and so do those of which less was run than the table has, as the budget was short or a run failed.
`--held-out` runs scenes that were not used for the fit and compares the errors predicted with those
reached; `--table` runs nothing and prints the tables from shellform/accuracy/measured.csv.

Costs are seconds of all ranks' processors in the solver alone, compiled before, of walks in all of
the run, and the median of repeats where a run is short; memory is the most resident during the run,
libraries included.
"""

import argparse
import csv
import io
import math
import time
from pathlib import Path

from mpi4py import MPI

import numpy as np

from demos.studies.accuracy.cases import CASES
from demos.studies.accuracy.held_out import HEAD, SCENES, WITHIN, line, measure
from demos.studies.accuracy.ladder import ladder
from demos.studies.accuracy.rows import rows_of
from demos.studies.accuracy.tables import table_lines
from demos.studies.accuracy.walk_case import walk_case
from shellform.accuracy import measured
from shellform.accuracy.asked import WORDS
from shellform.accuracy.choice import LEADING, choose
from shellform.accuracy.convergence import cheapest, pareto_front
from shellform.console import parse, positive, run, say
from shellform.results.files import write_atomically
from shellform.results.report import Report

COMM = MPI.COMM_WORLD
ERRORS = (0.1, 0.03, 0.01, 0.003)
# of a budget for all; what a case leaves goes to those after it
SHARES = {"roll_up": 1, "capstan": 2, "strip": 3, "sleeve": 3, "drape": 8, "walk": 25}
COLUMNS = (
    "case", "quantity", "family", "kind", "settings", "error", "reference", "uncertainty",
    "core_seconds", "memory_mb", "repeats", "relative_cost", "starts", "ratio", "length", "nodes",
    "steps", "time_step",
)  # fmt: skip


def arguments(given):
    parser = argparse.ArgumentParser(
        allow_abbrev=False, description="Measure error against cost, scene by scene."
    )
    parser.add_argument("--case", choices=(*SHARES, "all"), default="roll_up")
    parser.add_argument("--budget", type=positive(float), default=120.0, help="s")
    parser.add_argument("--write", action="store_true", help="keep the table for --accuracy")
    parser.add_argument("--held-out", action="store_true", help="scenes not used for the fit")
    parser.add_argument("--table", action="store_true", help="print what was measured, run nothing")
    parser.add_argument("--out", type=Path, default=Path("out/accuracy"))
    return parse(parser, given)


def table_text(rows, columns):
    """Rows as CSV; numbers short."""
    text = io.StringIO()
    writer = csv.DictWriter(text, columns, extrasaction="ignore", lineterminator="\n")
    writer.writeheader()
    for row in rows:
        writer.writerow({k: _short(v) for k, v in row.items()})
    return text.getvalue()


def _short(value):
    if isinstance(value, float):
        return "" if math.isnan(value) else f"{value:.5g}"
    return value


def keep(rows, names):
    """Write the table that `--accuracy` reads; cases that are not named keep what they had."""
    path, before = measured.TABLE, []
    if path.is_file():
        before = [row for row in measured.read(path) if row["case"] not in names]
    speed = measured.machine()
    machine = [{"case": name, "kind": "machine", "core_seconds": speed} for name in names]
    write_atomically(path, table_text([*before, *machine, *rows], measured.COLUMNS))
    for cached in (measured.read, measured.power_laws, measured.cost):
        cached.cache_clear()


def leading(rows, name):
    """Rows that compete in a case: meshes, in the quantity that an error is asked of."""
    keys = {"case": name, "quantity": LEADING[name], "kind": "mesh"}
    return [row for row in rows if all(row[k] == v for k, v in keys.items())]


def short(row):
    keys = ("settings", "error", "core_seconds", "memory_mb")
    return {key: row[key] for key in keys}


def tell(rows, names):
    """Print the three tables: cheapest settings, all quantities of the front, tricks."""
    print("\nCheapest setting that keeps an error (core-seconds, MB)")
    for name in names:
        mine = leading(rows, name)
        print(f"{name} ({LEADING[name]}; uncertainty {100 * mine[0]['uncertainty']:.2g} %)")
        for error in ERRORS:
            best = cheapest(mine, error)
            said = "not reached" if best is None else (
                f"{best['settings']}: {100 * best['error']:.2g} %, "
                f"{best['core_seconds']:.2g} s, {best['memory_mb']:.0f} MB"
            )  # fmt: skip
            print(f"  {100 * error:4g} %  {said}")
    print("\nSpread, half the step, tricks: what they change, cost over that of the run without")
    for row in rows:
        if row["kind"] in ("spread", "step", "trick"):
            cost = f"{row['relative_cost']:.2f}" if "relative_cost" in row else ""
            what = "half the step" if row["kind"] == "step" else row["settings"]
            changed = f"{100 * row['error']:8.2g} %  {cost}"
            print(f"  {row['case']:8} {row['quantity']:10} {what:34} {changed}")


def draw(path, rows, names):
    """Errors over cost, log-log, a panel a case, the front of the leading quantity drawn."""
    from shellform.pictures.surfaces import new_figure, save_figure

    columns = min(3, len(names))
    lines = -(-len(names) // columns)
    title = "Error against cost; line: best choices for the quantity asked for"
    figure, grid = new_figure(lines, (4.6 * columns, 3.9 * lines), title, columns=columns)
    panels = np.ravel(grid)
    for axes, name in zip(panels, names, strict=False):
        mine = [row for row in rows if row["case"] == name and row["kind"] == "mesh"]
        kinds = dict.fromkeys((row["quantity"], row["family"]) for row in mine)
        quantities = list(dict.fromkeys(q for q, _ in kinds))
        families = list(dict.fromkeys(f for _, f in kinds))
        for quantity, family in kinds:
            some = [r for r in mine if (r["quantity"], r["family"]) == (quantity, family)]
            colour, mark = f"C{quantities.index(quantity)}", "os^D"[families.index(family)]
            x, y = [r["core_seconds"] for r in some], [r["error"] for r in some]
            axes.loglog(x, y, mark, color=colour, ms=5, mfc="none", label=f"{quantity}, {family}")
        best = pareto_front(leading(rows, name))
        x, y = [r["core_seconds"] for r in best], [r["error"] for r in best]
        axes.loglog(x, y, "k-", lw=1)
        doubt = best[0]["uncertainty"]
        if doubt:
            axes.axhspan(0.5 * min(y[-1], doubt), doubt, color="0.9", label="uncertain")
        axes.set(title=name.replace("_", " "), xlabel="core-seconds", ylabel="relative error")
        axes.legend(fontsize=7, frameon=False)
        axes.grid(True, which="major", lw=0.3)
    for axes in panels[len(names) :]:
        axes.set_axis_off()
    save_figure(figure, path)


def main(given=None):
    options = arguments(given)
    if options.table:
        say(table_lines())
        return
    report = Report(options.out, "accuracy study", vars(options), COMM)
    if options.held_out:
        held_out(options, report)
        return

    # ## Runs, scene by scene
    names = list(SHARES) if options.case == "all" else [options.case]
    rows, left, total = [], options.budget, sum(SHARES[name] for name in names)
    done, whole = [], []
    for name in names:
        case = walk_case(options.out) if name == "walk" else CASES[name]
        budget, start = left * SHARES[name] / total, time.perf_counter()
        say([f"{name}: {budget:.0f} s"])
        with report.stage("solve"):
            runs, all_run = ladder(case, budget)
        if any(settings["kind"] == "mesh" for settings, _ in runs):
            rows += rows_of(case, runs)
            done.append(name)
            whole += [name] * all_run
        left -= COMM.bcast(time.perf_counter() - start)
        total -= SHARES[name]
        if COMM.rank == 0:
            write_atomically(options.out / "error_and_cost.csv", table_text(rows, COLUMNS))
    if not done:
        raise ValueError(f"no setting of {', '.join(names)} was run: give a larger --budget")

    # ## Tables, picture, and what is kept
    best = {name: pareto_front(leading(rows, name)) for name in done}
    within = {
        name: {
            f"{100 * error:g} %": row and short(row)
            for error in ERRORS
            for row in [cheapest(leading(rows, name), error)]
        }
        for name in done
    }
    results = {
        "front": [{"case": name} | short(row) for name in done for row in best[name]],
        "cheapest": within if options.case == "all" else within[names[0]],
    }
    if COMM.rank == 0:
        tell(rows, done)
        with report.stage("output"):
            draw(options.out / "error_and_cost.png", rows, done)
        if options.write:
            write(rows, names, whole)
            results["words"] = {name: words(name) for name in done}
    COMM.Barrier()
    report.summary |= {"plan": {}, "cells": None, "nodes": None, "dofs": None}
    report.write(results, steps=sum(int(row["steps"]) for row in rows), newton_iterations=0)
    say([f"wrote {options.out}/error_and_cost.csv, error_and_cost.png, summary.json"])


def write(rows, names, whole):
    """Keep the cases of which all was run, or at least as much as the table has of them."""
    path = measured.TABLE
    before = measured.read(path) if path.is_file() else []

    def count(table, name):
        return sum(row["case"] == name and row["kind"] != "machine" for row in table)

    kept = [n for n in names if n in whole or count(rows, n) >= max(1, count(before, n))]
    if kept:
        keep([row for row in rows if row["case"] in kept], kept)
    print(f"wrote {measured.TABLE}: {', '.join(kept) or 'nothing'}")
    if len(kept) < len(names):
        others = ", ".join(name for name in names if name not in kept)
        print(f"{others}: not all settings were run, the rows of before stay; give more --budget")


def held_out(options, report):
    """The table of scenes that were not used for the fit."""
    say([HEAD])
    rows = []
    for scene in SCENES:
        with report.stage("solve"):
            rows.append(measure(*scene))
        say([line(rows[-1])])
    good = sum(row["within"] for row in rows)
    say([f"{good} of {len(rows)} within a factor {WITHIN:g}"])
    report.summary |= {"plan": {}, "cells": None, "nodes": None, "dofs": None}
    report.write({"held_out": rows}, steps=0, newton_iterations=0)


def words(name):
    """What the words stand for in a case: size over length, and all errors predicted."""
    found = {}
    for word in WORDS:
        choice = choose(name, word, 1.0)
        found[word] = {"ratio": choice.ratio, "promised": choice.promised} | choice.predicted
    return found


if __name__ == "__main__":
    run(main)
