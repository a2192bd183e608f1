# SPDX-License-Identifier: LGPL-3.0-or-later
r"""Walks that were not used for the fit: the error predicted of their torques, and that reached.

Two public captures, another garment size, another fabric, another obstacle, another stature. Each
is run as a draft is by default, cells and runs, and held against an ensemble with finer cells.
The error reached is the root mean square, over hips and knees, of the relative differences of the
torques' root mean squares; the reference is itself known to its standard error only, whose share
is told and not taken off.

    python -m demos.studies.accuracy.held_out_walks --data ../shared/data --out out/held_out_walks

A walk that is complete in its folder is not run again. Captures are left out without `--data`.
"""

import argparse
import math
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from mpi4py import MPI

import numpy as np

from demos.studies.accuracy.walk_numbers import QUANTITIES, apart, numbers_of, scatter_of, walked
from shellform import Fabric, console
from shellform.accuracy.asked import percent, relative_error
from shellform.accuracy.choice import LEADING
from shellform.results.report import Report
from shellform.scene.parts import Garment, Motion, Output, Person, Steps
from shellform.scene.scene import Scene
from shellform.simulation.ensemble import run

COMM = MPI.COMM_WORLD
ASKED, WITHIN = "draft", 1.5  # factor between errors predicted and reached
FINER, RUNS = 0.0245, 2  # m, cells of the references, and their runs
SECONDS = 2.2  # of level walks: standing, the first step and a stride
DENIM = Fabric.from_kes(
    tensile_warp_N_per_m=8000.0,
    tensile_weft_N_per_m=6000.0,
    shear_N_per_m_per_radian=300.0,
    bending_warp_N_m=8e-5,
    bending_weft_N_m=6e-5,
    areal_mass_kg_per_m2=0.33,
    thickness_m=0.6e-3,
    name="between the two shipped",
)
LEVEL = Motion(obstacle=0.0, end=SECONDS)
WALKS = {
    "capture, TRC": {"motion": Motion("bmc_walk2.trc")},
    "capture, C3D": {"motion": Motion("biomechzoo_HC038A11.c3d")},
    "another size, medium-regular": {"motion": LEVEL, "garment": Garment(size="medium-regular")},
    "another fabric": {"motion": LEVEL, "fabric": DENIM},
    "obstacle of 0.25 m": {"motion": Motion(obstacle=0.25, strides=3)},
    "stature of 1.90 m": {"motion": LEVEL, "person": Person(stature=1.90)},
}


class Reached(NamedTuple):
    """A walk: {quantity: relative} of what was predicted, reached, and how the reference is known.

    cell_size [m] and runs of the choice; promised : whether `ASKED` was
    """

    name: str
    cell_size: float
    runs: int
    promised: bool
    predicted: dict
    reached: dict
    known: dict


def scenes(name: str, data: Path | None) -> tuple[Scene, Scene]:
    """Scene as chosen, and that of the reference."""
    scene = Scene(output=Output(frames=2.0, pressure=0.0), steps=Steps(accuracy=ASKED))
    scene = replace(scene, **WALKS[name], title=name)
    if scene.motion.file != "synthetic" and data is not None:
        scene = replace(scene, motion=replace(scene.motion, file=data / scene.motion.file))
    finer = replace(
        scene,
        garment=replace(scene.garment, cell_size=FINER),
        steps=replace(scene.steps, runs=RUNS),
    )
    return scene, finer


def measure(name: str, data: Path | None, out: Path) -> Reached:
    """Run a walk as chosen and finer, and compare."""
    found = []
    for scene, part in zip(scenes(name, data), ("chosen", "finer"), strict=True):
        folder = out / name.replace(" ", "_").replace(",", "") / part
        if not (folder / "summary.json").is_file():
            run(scene, folder, COMM)
        COMM.Barrier()  # rank 0's files are there
        found.append(walked(folder))
    choice = scenes(name, data)[0].choice
    chosen, finer = found
    one, other = numbers_of(chosen), numbers_of(finer)
    scatter = scatter_of(finer)
    return Reached(
        name,
        choice.size,
        choice.runs,
        bool(choice.promised),
        choice.predicted,
        {q: apart(one[q], other[q]) for q in QUANTITIES},
        {q: scatter[q] / math.sqrt(len(finer.curves)) for q in QUANTITIES},
    )


def lines(rows: list[Reached]) -> list[str]:
    """A table in Markdown, and whether all was kept."""
    quantity, asked = LEADING["walk"], relative_error(ASKED, "walk")
    said = [
        f"| walk not used for the fit | cells, runs | {quantity}: predicted | reached | "
        "reference known to | reached/predicted | peak: predicted | reached |",
        "|---|---|---|---|---|---|---|---|",
    ]
    ratios = [row.reached[quantity] / row.predicted[quantity] for row in rows]
    for row, ratio in zip(rows, ratios, strict=True):
        numbers = [
            row.predicted[quantity], row.reached[quantity], row.known[quantity],
            row.predicted["torque peak"], row.reached["torque peak"],
        ]  # fmt: skip
        a, b, c, d, e = (f"{100 * value:.2g} %" for value in numbers)
        said.append(
            f"| {row.name} | {1e3 * row.cell_size:.3g} mm, {row.runs} | {a} | {b} | {c} | "
            f"{ratio:.2f} | {d} | {e} |"
        )
    kept = sum(row.reached[quantity] <= asked for row in rows)
    near = sum(1 / WITHIN <= ratio <= WITHIN for ratio in ratios)
    over = sum(ratio <= WITHIN for ratio in ratios)
    mean = np.sqrt(np.mean(np.square(ratios)))
    return [
        *said,
        f"{percent(asked)} kept by {kept} of {len(rows)}; reached at most {WITHIN:g} times "
        f"what was predicted by {over}, within a factor {WITHIN:g} both ways by {near}; root "
        f"mean square of reached/predicted {mean:.2f}",
    ]


def main(given=None):
    parser = argparse.ArgumentParser(allow_abbrev=False, description="Walks held out.")
    parser.add_argument("--data", type=Path, help="folder of the public captures")
    parser.add_argument("--walks", nargs="+", choices=list(WALKS), default=list(WALKS))
    parser.add_argument("--out", type=Path, default=Path("out/held_out_walks"))
    options = console.parse(parser, given)
    names = [n for n in options.walks if options.data or "capture" not in n]
    report = Report(options.out, "held-out walks", vars(options), COMM)
    with report.stage("solve"):
        rows = [measure(name, options.data, options.out) for name in names]
    console.say(lines(rows))
    report.summary |= {"plan": {}, "cells": None, "nodes": None, "dofs": None}
    found = [row._asdict() for row in rows]
    report.write({"held_out_walks": found}, steps=0, newton_iterations=0)


if __name__ == "__main__":
    console.run(main)
