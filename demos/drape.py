# SPDX-License-Identifier: LGPL-3.0-or-later
r"""A square of cloth, held at one corner or free, falls onto an ellipsoid: the paper's Fig. 6.

The sheet lies level above the body, its corner at (-size/2, -size/2, 0). It is let go, meets the
ellipsoid, folds over it and comes to rest. The contact forces are impulses booked in every step;
averaged over the last part of the run they carry the weight, with the pin and what still moves.

    python demos/drape.py --cells 24 --out out/drape
    mpirun -n 2 python demos/drape.py --pinned none --friction 0.3
    python demos/drape.py --model particles
    python demos/drape.py --stepper implicit --time-step 4e-3
    python demos/drape.py --handover 0.5

leaves summary.json, ledger.csv, checkpoint.npz, drape.png, drape.gif and a series for ParaView in
the folder; a run that fails leaves ledger, frames and checkpoint of its last output time
(implicit steps and particles that hand over leave no checkpoint).
Default data: E t = 1000 N/m, nu = 0.3, bending of a sheet of 1 mm, 0.2 kg/m2, a sphere of radius
0.25 m whose top is 0.05 m below the sheet.
"""

import argparse
import copy

from mpi4py import MPI

import numpy as np

import meshes
from contact.body.segments import Body, Fixed, Segment
from shellform import Fabric, Shell, console
from shellform.accuracy.choice import accuracy_line, choose
from shellform.accuracy.convergence import richardson
from shellform.accuracy.measured import seconds
from shellform.contact_coupling.contact import Contact
from shellform.dynamics import checkpoint
from shellform.dynamics.explicit import Newmark
from shellform.results.ledger import Ledger
from shellform.results.report import Report
from shellform.results.series import Series

COMM = MPI.COMM_WORLD
G = 9.81


def arguments(given):
    parser = argparse.ArgumentParser(
        allow_abbrev=False,
        description="Drape a square of cloth over an ellipsoid.",
        epilog="Options with one dash go to PETSc, as -shell_ts_monitor.",
    )
    positive = console.positive
    parser.add_argument("--cells", type=positive(int), help="along a side (default: accuracy)")
    parser.add_argument("--degree", type=int, choices=(1, 2), default=1, help="of the quads")
    parser.add_argument("--stepper", choices=("explicit", "implicit"), default="explicit")
    parser.add_argument("--model", choices=("shell", "particles"), default="shell")
    parser.add_argument("--membrane", choices=("arcs", "chords"), default="arcs")
    parser.add_argument("--distort", type=float, default=0.0, help="of the mesh, parts of a cell")
    parser.add_argument("--seed", type=int, default=0, help="of distortion and perturbation")
    parser.add_argument("--perturb", type=float, default=0.0, help="random height at the start, m")
    parser.add_argument(
        "--handover", type=positive(float), help="particles until this time, then the shell, s"
    )
    parser.add_argument("--radii", type=positive(float), nargs=3, default=[0.25] * 3, help="m")
    parser.add_argument("--size", type=positive(float), default=1.0, help="side of the sheet, m")
    parser.add_argument("--pinned", choices=("corner", "none"), default="corner")
    parser.add_argument("--friction", type=float, default=0.3)
    parser.add_argument("--seconds", type=positive(float), default=2.0)
    parser.add_argument("--window", type=positive(float), default=0.2, help="for averages, s")
    parser.add_argument("--membrane-stiffness", type=positive(float), default=1000.0, help="N/m")
    parser.add_argument("--bending-stiffness", type=positive(float), default=9.16e-5, help="N m")
    parser.add_argument("--areal-mass", type=positive(float), default=0.2, help="kg/m2")
    parser.add_argument("--thickness", type=positive(float), default=1e-3, help="m")
    parser.add_argument("--time-step-factor", type=positive(float), default=0.9)
    parser.add_argument("--time-step", type=positive(float), help="of implicit steps, s")
    parser.add_argument(
        "--alpha", type=float, default=-0.1, help="damping of implicit steps, -1/3 to 0"
    )
    parser.add_argument(
        "--damping", type=float, default=2e-4, help="stiffness-proportional, of explicit steps, s"
    )
    parser.add_argument("--drag", type=float, default=0.5, help="of still air, 1/s")
    parser.add_argument("--accuracy", type=console.accuracy, default=0.03, metavar="N%")
    parser.add_argument("--frames", type=positive(int), default=40)
    parser.add_argument("--out", default="out/drape", help="folder for results")
    options = console.parse(parser, given)
    if options.window > options.seconds:
        parser.error("--window must not be longer than --seconds")
    if options.stepper == "implicit" and options.model == "particles":
        parser.error("particles are stepped explicitly; leave out --stepper or --model")
    if options.time_step is not None and options.stepper != "implicit":
        parser.error("--time-step is of --stepper implicit; explicit steps have --time-step-factor")
    if options.time_step is None:
        options.time_step = 4e-3
    if options.handover is not None:
        if options.model == "particles" or options.degree != 1:
            parser.error("--handover goes from particles to the shell of 4-node quads")
        if options.handover > options.seconds - options.window:
            parser.error("--handover must leave --window to the shell")
    return options


def sheet(options):
    """The square of cloth with its support and its weight."""
    size, n, nu = options.size, options.cells, 0.3
    corners = meshes.distorted((n, n), options.distort, seed=options.seed)
    square = meshes.rectangle(size, size, (n, n), degree=options.degree, parameters=corners)
    square = square.transform(translation=(-0.5 * size, -0.5 * size, 0.0))
    plane = np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])
    fabric = Fabric.from_stiffness(
        options.membrane_stiffness / (1 - nu**2) * plane,
        options.bending_stiffness * plane,
        options.areal_mass,
        options.thickness,
        name="drape",
    )
    shell = Shell(square, fabric, COMM, membrane=options.membrane)
    if options.pinned == "corner":
        shell.supports.hold(np.array([0]))
    shell.loads.gravity((0.0, 0.0, -G))
    return shell


def stepper_of(options, shell, body):
    """Stepper of the model asked for, and its contact with the body."""
    if options.stepper == "implicit":
        from shellform.dynamics.implicit import ImplicitNewmark

        stepper = ImplicitNewmark(shell, options.time_step, alpha=options.alpha, drag=options.drag)
        return stepper, stepper.add(Contact(body, options.friction))
    model = Newmark
    if options.model == "particles":
        from shellform.dynamics.mass_spring import Particles as model
    stepper = model(shell, options.time_step_factor, damping=options.damping, drag=options.drag)
    return stepper, stepper.add(Contact(body, options.friction))


def cells_for(options):
    """The choice of cells for the accuracy asked for; sets options.cells."""
    held = (options.bending_stiffness / (options.areal_mass * G)) ** (1 / 3)
    family = ["particles" if options.model == "particles" else "quads"]
    choice = choose("drape", options.accuracy, min([held, *options.radii]), families=family)
    options.cells = max(4, int(np.ceil(options.size / choice.size)))
    return choice.at(options.size / options.cells)


def mean_height(stepper):
    """Height of the centre of mass [m]; all ranks call."""
    mass = COMM.allreduce(stepper.mass.sum())
    z = (stepper.points + stepper.owned[:, :3])[:, 2]
    return COMM.allreduce(stepper.mass @ z) / mass


def reached(options, choice, body, height):
    """`accuracy` of summary.json: a run with half the cells tells what these leave."""
    if options.stepper == "implicit" or options.handover is not None:
        return choice.summary(None, "measured beforehand; implicit steps have no companion")
    half = argparse.Namespace(**vars(options) | {"cells": max(2, options.cells // 2)})
    stepper, _ = stepper_of(half, sheet(half), body)
    perturb(half, stepper)
    stepper.advance(options.seconds)
    by = options.cells / half.cells
    left = richardson(height, mean_height(stepper), by, choice.order) / abs(height)
    how = f"run with {half.cells} cells a side; what another start changes added"
    return choice.summary(float(np.hypot(left, choice.power_law.spread)), how)


def perturb(options, stepper):
    """Heights at random, the same on any number of ranks; held nodes stay."""
    shell = stepper.shell
    random = np.random.default_rng(options.seed)
    rise = options.perturb * random.uniform(-1, 1, len(shell.surface.points))
    rise = rise[shell.partition.owned_nodes]
    rise[shell.supports.held[: stepper.n_owned, 2]] = 0.0
    stepper.owned[:, 2] += rise
    stepper.scatter()


def main(given=None):
    # ## The sheet and the body
    options = arguments(given)
    choice = cells_for(options) if options.cells is None else None
    report = Report(options.out, "drape", vars(options), COMM)
    with report.stage("setup"):
        shell, n = sheet(options), options.cells
        square = shell.surface
        centre = np.array([0.0, 0.0, -0.05 - options.radii[2]])
        body = Body([Segment("body", options.radii, Fixed(centre))])
        report.describe(
            shell, inertia="lumped", contact=list(body.names), friction=options.friction
        )

    # ## Steps
    with report.stage("compile"):
        stepper, touch = stepper_of(options, shell, body)
        stepper.strain_energy()
    if choice:
        work = len(square.points), options.seconds / stepper.dt
        took = None  # of implicit steps no time was measured
        if options.stepper == "explicit":
            took = seconds("drape", choice.family, *work) / COMM.size
        console.say(choice.lines(took))
    later = None
    if options.handover is not None:
        # particles first, on a sheet of their own
        first = copy.copy(options)
        first.stepper, first.model = "explicit", "particles"
        later = stepper, touch
        stepper, touch = stepper_of(first, sheet(options), body)
    perturb(options, stepper)
    ledger, series = stepper.add(Ledger(report.folder / "ledger.csv")), Series(options.out)
    times = np.linspace(0, options.seconds, options.frames + 1)[1:]
    shown = stepper.shell
    frames, deepest = [(shown.positions(), shown.directors())], 0.0
    particle_steps = 0
    for time in console.progress(times, len(times), "drape"):
        with report.stage("solve"):
            if later and time > options.handover:
                from shellform.dynamics.mass_spring import hand_over

                stepper.advance(options.handover)
                report.shift(touch.seconds, "solve", "contact")
                hand_over(stepper, later[0])
                particle_steps, (stepper, touch), later = stepper.steps, later, None
                ledger = stepper.add(Ledger(report.folder / "ledger.csv"))
            stepper.advance(time)
        with report.stage("output"):
            ledger.record()
            if options.stepper == "explicit" and options.handover is None:
                checkpoint.save(report.folder / "checkpoint.npz", stepper)
            shown = stepper.shell
            series.write(shown, time)
            frames.append((shown.positions(), shown.directors()))
            deepest = max(deepest, COMM.allreduce(touch.correction.max_depth, MPI.MAX))
    steps = stepper.steps + particle_steps
    report.shift(touch.seconds, "solve", "contact")

    # ## Results
    #
    # Forces are means over the window at the end.
    results = summarise(options, stepper, ledger, frames[-1][0], deepest)
    if COMM.rank == 0:
        force, weight = results["contact_force"], results["weight"]
        cost = 1e6 * report.seconds["solve"] + 1e6 * report.seconds["contact"]
        cost /= steps * len(square.points)
        results["microseconds_per_node_and_step"] = cost
        print(f"{n} x {n} cells, {steps} steps of {stepper.dt:.2e} s, ", end="")
        print(f"{cost:.2f} microseconds a node and step")
        print(f"weight {weight:.4f} N, contact {np.round(force, 4)} N, ", end="")
        print(f"pin {np.round(results['pin_force'], 4)} N over {results['window']:.2f} s")
        print(f"mean height {results['mean_height']:.4f} m, strain energy ", end="")
        print(f"{results['strain_energy']:.3e} J, depth {1e3 * deepest:.4f} mm")
        with report.stage("output"):
            from shellform.pictures.surfaces import drape_pictures

            drape_pictures(report.folder, frames, square.cells, body, times[0])
    iterations = 0
    if options.stepper == "implicit":
        iterations = stepper.newton_iterations
        results |= {
            "solves": stepper.solves,
            "cutbacks": stepper.cutbacks,
            "unsettled_steps": touch.unsettled,
        }
        assembly = stepper.equilibrium.assembly_seconds
        report.shift(assembly, "solve", "assemble")
    entries = {}
    if choice:
        with report.stage("solve"):
            entries["accuracy"] = reached(options, choice, body, results["mean_height"])
        console.say([accuracy_line(entries["accuracy"])])
    report.write(
        results, steps=steps, newton_iterations=iterations, time_step=stepper.dt, **entries
    )
    if COMM.rank == 0:
        print(f"wrote {report.folder}/summary.json, ledger.csv, drape.png, drape.gif, series.pvd")


def summarise(options, stepper, ledger, positions, deepest):
    """The keys of results in summary.json."""
    rows = ledger.rows
    count = max(1, round(options.window / options.seconds * len(rows)))
    late = rows[-count:]
    before = rows[-count - 1] if count < len(rows) else None
    window = late[-1]["time"] - (before["time"] if before else 0.0)
    contact = [np.mean([row[f"force_body_{a}"] for row in late]) for a in "xyz"]
    pin = [
        (late[-1][f"support_impulse_{a}"] - (before[f"support_impulse_{a}"] if before else 0.0))
        / window
        for a in "xyz"
    ]
    # a sheet that still moves is carried by more or less than its weight: by this and by drag
    inertia = [
        (late[-1][f"momentum_{a}"] - (before[f"momentum_{a}"] if before else 0.0)) / window
        for a in "xyz"
    ]
    shell = stepper.shell
    mass = COMM.allreduce(stepper.mass.sum())
    corner = shell.surface.points[:, :2].sum(axis=1).argmax()
    return {
        "weight": mass * G,
        "contact_force": contact,
        "pin_force": pin,
        "inertia_force": inertia,
        "window": window,
        "mean_height": mean_height(stepper),
        "free_corner": positions[corner],
        "strain_energy": late[-1]["strain"],
        "kinetic_energy": late[-1]["kinetic"],
        "max_penetration": deepest,
        "momentum_residual": max(row["momentum_residual"] for row in rows),
    }


if __name__ == "__main__":
    console.run(main)
