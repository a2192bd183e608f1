# SPDX-License-Identifier: LGPL-3.0-or-later
r"""Torques of the study's walks by the size of the cells, and what a run of them takes.

    python -m demos.studies.accuracy.walk_table --out out/accuracy

prints, from the walks that `run.py --case walk` has left complete in the folder, a line for each
walk and size: root mean square and peak of the mean curve of each hip and knee, their standard
errors where there are several starts, what they differ by from the finest, and nodes times steps.
"""

import argparse
import math
from pathlib import Path

from demos.studies.accuracy.walk_case import STARTS, WALKS, folder_of
from demos.studies.accuracy.walk_numbers import apart, numbers_of, scatter_of, walked
from shellform import console
from shellform.simulation.summary import summary_of

HEAD = (
    "| walk, fabric | cells [mm], runs | node-steps | rms: right hip, knee, left hip, knee [N m] | "
    "known to | differs from the finest | peaks [N m] | known to | differ from the finest |"
)


def lines(folder: Path) -> list[str]:
    """The table in Markdown; ValueError where no walk is complete."""
    said = [HEAD, "|" + 9 * "---|"]
    for fabric, ground in WALKS:
        found = {
            size: out
            for size in sorted(STARTS, reverse=True)
            for out in [folder_of(folder / "walk", fabric, ground, "mesh", size)]
            if (out / "summary.json").is_file()
        }
        runs = {size: walked(out) for size, out in found.items()}
        for size, own in runs.items():
            finest = numbers_of(runs[min(runs)])
            said.append(_line(f"{ground}, {fabric}", size, own, finest, summary_of(found[size])))
    if len(said) == 2:
        raise ValueError(f"no walk is complete in {folder}/walk: run.py --case walk runs them")
    return said


def _line(name, size, own, finest, summary):
    numbers, n = numbers_of(own), len(own.curves)
    scatter = scatter_of(own) if n > 1 else {}
    cells = [name, f"{1e3 * size:g}, {n}", f"{summary['nodes'] * summary['steps']:.2g}"]
    for quantity in ("torque rms", "torque peak"):
        known = scatter.get(quantity, math.nan) / math.sqrt(n)
        off = apart(numbers[quantity], finest[quantity])
        cells += [
            ", ".join(f"{value:.3g}" for value in numbers[quantity]),
            "" if math.isnan(known) else f"{100 * known:.2g} %",
            f"{100 * off:.2g} %" if off else "",
        ]
    return f"| {' | '.join(cells)} |"


def main(given=None):
    parser = argparse.ArgumentParser(allow_abbrev=False, description="Torques by cells.")
    parser.add_argument("--out", type=Path, default=Path("out/accuracy"), help="of run.py")
    console.say(lines(console.parse(parser, given).out))


if __name__ == "__main__":
    console.run(main)
