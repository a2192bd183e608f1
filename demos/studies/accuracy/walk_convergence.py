# SPDX-License-Identifier: LGPL-3.0-or-later
r"""How far the knee torque of a walk is from converged: three meshes and three time steps.

The same walk in the same trousers is run with cells of three sizes at one part of the stable step,
and with the coarsest cells at three parts. Curves are compared over the strides that all have, by
the root mean square of the difference between one level and the next, and by peak and work.

    mpirun -n 2 python -m demos.studies.accuracy.walk_convergence --out out/walk_convergence

leaves walk_convergence.png, table.csv and summary.json in the folder, and a folder a run.
"""

import argparse
from pathlib import Path

from mpi4py import MPI

import numpy as np

from shellform import console
from shellform.results.files import write_atomically
from shellform.results.joint_torque import rows_until
from shellform.results.report import Report
from shellform.scene.parts import Garment, Motion, Output, Steps
from shellform.scene.scene import Scene
from shellform.simulation.run import run
from shellform.simulation.summary import summary_of

COMM = MPI.COMM_WORLD


def arguments(given):
    parser = argparse.ArgumentParser(
        allow_abbrev=False, description="Convergence of the knee torque of a walk."
    )
    positive = console.positive
    sizes, factors = [0.04, 0.028, 0.02], [0.9, 0.45, 0.225]
    parser.add_argument("--motion", default="synthetic", help="'synthetic' or C3D, TRC, CSV file")
    parser.add_argument("--fabric", default="compliant")
    parser.add_argument("--cell-sizes", type=positive(float), nargs="+", default=sizes, help="m")
    parser.add_argument("--factors", type=positive(float), nargs="+", default=factors)
    parser.add_argument("--joints", nargs="+", default=["right_knee", "left_knee"])
    parser.add_argument("--seconds", type=positive(float), help="of the motion (default: all)")
    parser.add_argument("--obstacle", type=float, default=0.5, help="height, m; 0 for none")
    parser.add_argument("--window", type=positive(float), default=0.02, help="of averages, s")
    parser.add_argument("--out", type=Path, default=Path("out/walk_convergence"))
    return console.parse(parser, given)


def main(given=None):
    # ## Runs, the dearest first, shared out over the ranks
    options = arguments(given)
    report = Report(options.out, "walk_convergence", vars(options), COMM)
    coarse, first = max(options.cell_sizes), options.factors[0]
    runs = [(size, first) for size in sorted(options.cell_sizes)]
    runs += [(coarse, factor) for factor in sorted(options.factors[1:])]
    cost = {(size, factor): size**-3 / factor for size, factor in runs}
    load, mine = np.zeros(COMM.size), []
    for level in sorted(runs, key=cost.get, reverse=True):
        rank = int(load.argmin())
        load[rank] += cost[level]
        if rank == COMM.rank:
            mine.append(level)
    results = {}
    with report.stage("solve"):
        for size, factor in mine:
            scene = Scene(
                fabric=options.fabric,
                motion=Motion(options.motion, end=options.seconds, obstacle=options.obstacle),
                garment=Garment(cell_size=size),
                steps=Steps(time_step_factor=factor),
                output=Output(window=options.window, frames=2.0),
                title=f"cells of {1e3 * size:g} mm, {factor:g} of the stable step",
            )
            folder = options.out / f"cells_{1e3 * size:g}_step_{factor:g}"
            run(scene, folder, MPI.COMM_SELF)
            results[size, factor] = summary_of(folder)
    results = {level: part[level] for part in COMM.allgather(results) for level in part}
    if COMM.rank:
        return

    # ## Differences between levels
    curves = {}
    for (size, factor), summary in results.items():
        folder = options.out / f"cells_{1e3 * size:g}_step_{factor:g}"
        rows = rows_until(folder / "torque.csv", np.inf)
        for joint in options.joints:
            own = [(r["time"], r["torque_flexion"]) for r in rows if r["joint"] == joint]
            curves[size, factor, joint] = np.transpose(own)
    table = [
        "joint,cell_size_m,factor,nodes,steps,seconds,rms_torque_Nm,peak_torque_Nm,work_J,"
        "rms_difference_to_next_Nm"
    ]
    levels = [(size, first) for size in sorted(options.cell_sizes, reverse=True)]
    finer = [(coarse, factor) for factor in sorted(options.factors, reverse=True)]
    for joint in options.joints:
        for chain in (levels, finer):
            for level, after in zip(chain, [*chain[1:], None], strict=True):
                summary, part = results[level], results[level]["results"]["joints"][joint]
                difference = ""
                if after:
                    torque, reference = curves[*level, joint], curves[*after, joint]
                    other = np.interp(torque[0], *reference)
                    difference = f"{np.sqrt(np.mean((torque[1] - other) ** 2)):.4g}"
                table.append(
                    f"{joint},{level[0]:g},{level[1]:g},{summary['nodes']},{summary['steps']},"
                    f"{summary['seconds']['total']:.4g},{part['rms_torque']:.4g},"
                    f"{part['peak_torque']:.4g},{part['work']:.4g},{difference}"
                )
    write_atomically(options.out / "table.csv", "\n".join(table) + "\n")
    print("\n".join(line.replace(",", "  ") for line in table))
    draw(options, curves, levels, finer)
    report.summary |= {"plan": {}, "cells": None, "nodes": None, "dofs": None}
    steps = sum(summary["steps"] for summary in results.values())
    report.comm = MPI.COMM_SELF
    report.write({"table": table}, steps=steps, newton_iterations=0)
    print(f"wrote {options.out}/walk_convergence.png, table.csv, summary.json")


def draw(options, curves, levels, finer):
    """walk_convergence.png: meshes above, time steps below, a column a joint."""
    from shellform.pictures.surfaces import new_figure, save_figure

    figure, grid = new_figure(2, (13, 7), "", columns=len(options.joints))
    for row, (chain, kind) in enumerate(((levels, "mesh"), (finer, "step"))):
        for axes, joint in zip(np.reshape(grid, (2, -1))[row], options.joints, strict=True):
            for size, factor in chain:
                label = f"{1e3 * size:g} mm" if kind == "mesh" else f"{factor:g} of stable step"
                axes.plot(*curves[size, factor, joint], lw=0.9, label=label)
            axes.set_title(joint.replace("_", " "), fontsize=10)
            axes.set_xlabel("time [s]")
            axes.set_ylabel("flexion torque [N m]")
            axes.axhline(0, color="0.6", lw=0.6)
            axes.legend(frameon=False, fontsize=8)
    save_figure(figure, options.out / "walk_convergence.png")


if __name__ == "__main__":
    console.run(main)
