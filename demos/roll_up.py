# SPDX-License-Identifier: LGPL-3.0-or-later
r"""A strip rolled up by an end moment: the validation problem of the paper's Fig. 5.

Objective. How far may a shell turn before its error shows? A flat strip of length L is clamped at
x = 0; a moment M about -y, constant along the other end, bends it in load steps, each solved to
equilibrium by Newton's method (Eq. 13 without inertia).

Equations. The strip is a beam, as nu = 0: its curvature is kappa = M/D, one full turn at
M = 2 pi D/L. In the limit of a thin sheet the exact shape is a circle,

    x(s) = sin(kappa s)/kappa,   z(s) = (1 - cos(kappa s))/kappa.

What is compared. The middle of the loaded end with the end of that circle, at every load step, over
the length. A sheet of finite thickness stretches a little as it bends (by about t^2 kappa^2/12), so
the distance to the circle stops falling there. The long edges slide in their planes: a free strip
would leave the plane sideways beyond three quarters of a turn, a true instability.

Source. The circle is Euler's elastica under a pure moment; the problem is the paper's Fig. 5.

    python demos/roll_up.py --cells 16 --turns 1 --steps 20 --out out/roll_up
    mpirun -n 2 python demos/roll_up.py --turns 2 -shell_snes_monitor

prints a table and leaves summary.json, roll_up.png and a series for ParaView in the folder.
"""

import argparse
import time

import numpy as np

import meshes
from shellform import Fabric, Shell, Statics, console
from shellform.accuracy.choice import accuracy_line, choose
from shellform.accuracy.convergence import companion_cells, companion_error
from shellform.accuracy.measured import seconds, tricks
from shellform.results.report import Report
from shellform.results.series import Series

COMM = console.COMM
FAMILIES = ("quads", "nine-node quads")  # by degree
STEPS = 20  # load steps a turn
STRETCH = 1 / 6  # of (kappa t)^2, measured with 64 cells for t/L from 1/240 to 1/60


def arguments(given):
    parser = argparse.ArgumentParser(
        allow_abbrev=False,
        description="Roll a strip up by an end moment and compare it with the exact circle.",
        epilog="Options with one dash go to PETSc, as -shell_snes_monitor.",
    )
    positive = console.positive
    parser.add_argument("--cells", type=positive(int), help="along the strip (default: accuracy)")
    parser.add_argument("--degree", type=int, choices=(1, 2), default=1, help="of the quads")
    parser.add_argument("--thickness", type=positive(float), default=0.01, help="m")
    parser.add_argument("--length", type=positive(float), default=12.0, help="m")
    parser.add_argument("--turns", type=float, default=1.0, help="at full load")
    parser.add_argument("--steps", type=positive(int), help="load steps (default: 20 a turn)")
    parser.add_argument("--accuracy", type=console.accuracy, default=0.001, metavar="N%")
    parser.add_argument("--out", default="out/roll_up", help="folder for results")
    options = console.parse(parser, given)
    if not np.isfinite(options.turns) or options.turns == 0:
        parser.error("--turns must be a finite number other than zero")
    if options.steps is None:
        options.steps = max(1, int(np.ceil(STEPS * abs(options.turns))))
    return options


def sensitivity(turns):
    """How far the tip moves over the length for a relative error of the curvature: 1 at a turn."""
    angle = 2 * np.pi * abs(turns)
    x = np.cos(angle) - np.sin(angle) / angle
    z = np.sin(angle) - (1 - np.cos(angle)) / angle
    return float(np.hypot(x, z))


def stretch(turns, length, thickness):
    """Tip error over the length of a sheet of finite thickness, however small the cells.

    What the stretch that comes with bending changes acts like an error of the curvature.
    """
    return sensitivity(turns) * STRETCH * (2 * np.pi * turns * thickness / length) ** 2


def cells_for(options):
    """The choice of cells for the accuracy asked for; sets options.cells."""
    radius = options.length / (2 * np.pi * abs(options.turns))
    scales = (
        sensitivity(options.turns),
        stretch(options.turns, options.length, options.thickness),
    )
    choice = choose(
        "roll_up", options.accuracy, radius, *scales, families=[FAMILIES[options.degree - 1]]
    )
    options.cells = max(2, int(np.ceil(options.length / choice.size)))
    return choice.at(options.length / options.cells)


def strip(options):
    """Shell of the strip with its supports and its end moment; its curvature at full load [1/m].

    One row of cells; nu = 0, so that the strip is a beam. Only the ratio M/D matters. The moment
    grows with the load level from 0 to 1.
    """
    length = options.length
    surface = meshes.rectangle(length, length / 12, (options.cells, 1), degree=options.degree)
    fabric = Fabric.isotropic(1.2e6, 0.0, options.thickness, 1000.0)
    shell = Shell(surface, fabric, COMM)
    kappa = 2 * np.pi * options.turns / length
    shell.supports.clamp("left")
    shell.supports.symmetry("bottom", (0, 1, 0))
    shell.supports.symmetry("top", (0, 1, 0))
    shell.loads.edge_moment("right", (0, -kappa * fabric.bending[0, 0], 0))
    return shell, kappa


def reached(options, choice, tip):
    """`accuracy` of summary.json: what the tip differs by from that of another mesh."""
    fewest = int(np.ceil(2 * np.pi * abs(options.turns) / choice.power_law.coarsest))
    cells = companion_cells(options.cells, fewest)
    shell, _ = strip(argparse.Namespace(**vars(options) | {"cells": cells}))
    with Statics(shell) as statics:
        for _ in statics.march(options.steps):
            pass
        other = tip_of(shell, options.length)
    apart = float(np.linalg.norm(tip - other)) / options.length
    error = companion_error(apart, options.cells, cells, choice.order)
    return choice.summary(error + choice.own, f"run with {cells} cells; stretch of the sheet added")


def circle(kappa, s):
    """Points (k, 3) of the exact shape at arc lengths s (k,)."""
    angle = kappa * s
    x = s * np.sinc(angle / np.pi)
    z = 0.5 * kappa * s**2 * np.sinc(angle / (2 * np.pi)) ** 2
    return np.column_stack([x, 0 * s, z])


def march(shell, kappa, options, report):
    """Raise the moment step by step; what is seen on the way.

    Returns
    -------
    rows : list of (level, x, z, exact x, exact z, error over the length, Newton iterations)
    frames, exact : five shapes for `draw`, and the circles they should be
    statics : Statics, done
    """
    length, turns = options.length, options.turns
    with report.stage("setup"):
        statics = Statics(shell)
    levels = np.linspace(0, 1, options.steps + 1)[1:]
    shown = {options.steps * k // 5 for k in range(1, 6)}
    rows, frames, exact, series = [], [], [], Series(options.out)
    steps = console.progress(statics.march(levels), options.steps, "roll-up")
    start = time.perf_counter()
    for k, step in enumerate(steps, start=1):
        report.seconds["solve"] += time.perf_counter() - start
        with report.stage("output"):
            tip = tip_of(shell, length)
            goal = circle(kappa * step.level, np.array([length]))[0]
            error = np.linalg.norm(tip - goal) / length
            rows.append((step.level, *tip[[0, 2]], *goal[[0, 2]], error, step.iterations))
            if k in shown:
                label = f"{step.level * turns:g} turn"
                frames.append((label, shell.positions(), shell.directors(), shell.surface.cells))
                exact.append(circle(kappa * step.level, np.linspace(0, length, 400)))
                series.write(shell, step.level)
        start = time.perf_counter()
    report.shift(statics.equilibrium.assembly_seconds, "solve", "assemble")
    return rows, frames, exact, statics


def tip_of(shell, length):
    """Position (3,) [m] of the middle of the end that the moment turns."""
    return shell.displacement_at((length, 0, 0)) + (length, 0, 0)


def show(options, rows):
    """Print the table of load steps."""
    print(f"{options.cells} x 1 cells of degree {options.degree}, t = {options.thickness:g} m")
    print(f"{'turns':>8} {'x':>10} {'z':>10} {'x exact':>10} {'z exact':>10}  error/L  Newton")
    for level, x, z, x_exact, z_exact, error, newton in rows:
        turns = level * options.turns
        shape = f"{turns:8.3f} {x:10.5f} {z:10.5f} {x_exact:10.5f} {z_exact:10.5f}"
        print(f"{shape}  {error:.1e}  {newton:6d}")


def draw(path, frames, exact, title):
    """Strips side by side at several load levels and their profiles over the exact circles.

    Parameters
    ----------
    path : PNG file
    frames : list of (label, points (n, 3), directors (n, 3), cells); node 0 at the clamp
    exact : list of curves (k, 3), one a frame
    title : str
    """
    # only here: a run on rank 1 draws nothing
    from shellform.pictures.surfaces import (
        BACK,
        CLOTH,
        draw_surfaces,
        facets_and_sides,
        new_figure,
        save_figure,
        view_axes,
    )

    figure, (above, below) = new_figure(2, (9, 8.5), title, height_ratios=(3, 2))
    width = np.ptp(frames[0][1][:, 1])
    view = (-78, 16)
    strips = []
    right, up, _ = view_axes(*view)
    spacing = np.array([0.0, 5 * width, 0.0])
    for i, (label, points, directors, cells) in enumerate(frames):
        facets, sides = facets_and_sides(points + i * spacing, directors, cells)
        strips.append((facets, sides, CLOTH, BACK, 0.0))
        root = points[0] + i * spacing - [0.4 * width, 0, 0]
        above.text(root @ right, root @ up, label, ha="right", va="center", fontsize=9)
    draw_surfaces(above, strips, *view)
    for (label, points, *_), curve in zip(frames, exact, strict=True):
        side = points[np.isclose(points[:, 1], points[:, 1].min(), atol=1e-6 * width)]
        (line,) = below.plot(curve[:, 0], curve[:, 2], lw=0.8)
        below.plot(side[:, 0], side[:, 2], "o", ms=3, color=line.get_color(), label=label)
    below.set_aspect("equal")
    below.set_xlabel("x [m]")
    below.set_ylabel("z [m]")
    place = {"loc": "center left", "bbox_to_anchor": (1, 0.5)}
    below.legend(title="nodes; lines: exact", fontsize=8, **place)
    save_figure(figure, path)


def main(given=None):
    options = arguments(given)
    choice = cells_for(options) if options.cells is None else None
    report = Report(options.out, "roll_up", vars(options), COMM)
    with report.stage("setup"):
        shell, kappa = strip(options)
        report.describe(shell, inertia=False, contact=False)
    if choice:
        work = len(shell.surface.points), options.steps
        took = seconds("roll_up", choice.family, *work) / COMM.size
        console.say(choice.lines(took))
    with report.stage("compile"):
        shell.forms()
    rows, frames, exact, statics = march(shell, kappa, options, report)

    usual = int(np.ceil(STEPS * abs(options.turns)))
    used = [f"{options.steps} load steps"] if options.steps < usual else []
    entries = {"tricks": tricks("roll_up", used)}
    tip, error = tip_of(shell, options.length), rows[-1][5]
    if choice:
        with report.stage("solve"):
            entries["accuracy"] = reached(options, choice, tip)
    if COMM.rank == 0:
        show(options, rows)
        with report.stage("output"):
            title = f"Roll-up, {options.cells} cells, tip within {error:.1e} of the length"
            draw(report.folder / "roll_up.png", frames, exact, title)
    results = {
        "tip": tip,
        "tip_exact": circle(kappa, np.array([options.length]))[0],
        "tip_error_over_length": error,
        "newton_iterations_per_step": [row[-1] for row in rows],
    }
    iterations = sum(step.iterations for step in statics.steps)
    entries |= {"newton_iterations": iterations, "cutbacks": statics.cutbacks}
    report.write(results, steps=len(statics.steps), **entries)
    if choice:
        console.say([accuracy_line(entries["accuracy"])])
    console.say([f"wrote {report.folder}/summary.json, roll_up.png, series.pvd"])


if __name__ == "__main__":
    console.run(main)
