# SPDX-License-Identifier: LGPL-3.0-or-later
r"""A square of cloth, held at one corner or free, falls onto an ellipsoid: the paper's Fig. 6.

Objective. Does cloth that folds over a body come to rest on it, and do the contact forces carry it?
The sheet lies level above the ellipsoid, its corner at (-size/2, -size/2, 0). It is let go, meets
the body, folds over it and comes to rest.

Equations. Explicit steps (Sec. 3.1.3), with contact between the two lines (Eqs. 15 and 16),

    v(n+1/2) = v(n-1/2) + dt M^-1 (f_ext - f_int(x(n))),   x(n+1) = x(n) + dt v(n+1/2);

or implicit steps of the same shell, or masses and springs (Sec. 2.1).

What is compared. Contact forces are impulses booked in every step; averaged over the last part of
the run they carry the weight, with the pin and what still moves. A run with half the cells tells
what the cells leave of the mean height.

Source. The paper's Fig. 6.

    python demos/drape.py --cells 24 --out out/drape
    mpirun -n 2 python demos/drape.py --pinned none --friction 0.3
    python demos/drape.py --model particles
    python demos/drape.py --stepper implicit --time-step 4e-3
    python demos/drape.py --handover 0.5
    python demos/drape.py --cells 12 --wrinkles relaxed

leaves summary.json, ledger.csv, checkpoint.npz, drape.png, drape.gif and a series for ParaView in
the folder, and wrinkles.png of a relaxed sheet; a run that fails leaves ledger, frames and
checkpoint of its last output time (no checkpoint of implicit steps and particles that hand over).
Default data: E t = 1000 N/m, nu = 0.3, bending of a sheet of 1 mm, 0.2 kg/m2, a sphere of radius
0.25 m whose top is 0.05 m below the sheet.
"""

import argparse
import copy
from dataclasses import dataclass

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
from shellform.fem.wrinkles import KINDS
from shellform.results.ledger import Ledger
from shellform.results.report import Report
from shellform.results.series import Series

COMM = console.COMM
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
    parser.add_argument(
        "--wrinkles",
        choices=KINDS,
        default="resolved",
        help="those smaller than a cell: relaxed, or cells alone fold",
    )
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
        "--damping", type=float, default=1e-5, help="stiffness-proportional, of explicit steps, s"
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
    kinds = {"membrane": options.membrane, "wrinkles": options.wrinkles}
    shell = Shell(square, fabric, COMM, **kinds)
    if options.pinned == "corner":
        shell.supports.hold(np.array([0]))
    shell.loads.gravity((0.0, 0.0, -G))
    return shell


def body_of(options):
    """The ellipsoid whose top is 0.05 m below the sheet."""
    centre = np.array([0.0, 0.0, -0.05 - options.radii[2]])
    return Body([Segment("body", options.radii, Fixed(centre))])


def stepper_of(options, shell, body):
    """Stepper of the model asked for, with its contact with the body."""
    # only the steps asked for are loaded and compiled
    if options.stepper == "implicit":
        from shellform.dynamics.implicit import ImplicitNewmark

        stepper = ImplicitNewmark(shell, options.time_step, alpha=options.alpha, drag=options.drag)
    else:
        if options.model == "particles":
            from shellform.dynamics.mass_spring import Particles as Model
        else:
            Model = Newmark
        stepper = Model(shell, options.time_step_factor, damping=options.damping, drag=options.drag)
    stepper.add(Contact(body, options.friction))
    return stepper


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
    stepper = stepper_of(half, sheet(half), body)
    perturb(half, stepper)
    stepper.advance(options.seconds)
    by = options.cells / half.cells
    error = richardson(height, mean_height(stepper), by, choice.order) / abs(height)
    how = f"run with {half.cells} cells a side; what another start changes added"
    return choice.summary(float(np.hypot(error, choice.power_law.spread)), how)


def perturb(options, stepper):
    """Heights at random, the same on any number of ranks; held nodes stay."""
    shell = stepper.shell
    random = np.random.default_rng(options.seed)
    rise = options.perturb * random.uniform(-1, 1, len(shell.surface.points))
    rise = rise[shell.partition.owned_nodes]
    rise[shell.supports.held[: stepper.n_owned, 2]] = 0.0
    stepper.owned[:, 2] += rise
    stepper.scatter()


@dataclass
class Fall:
    """A sheet that has fallen.

    stepper, contact, ledger : those of the end, when springs have handed over to the shell
    frames : list of (positions, directors), the start and one an output time
    deepest : float [m], a node in the body; steps : int, of springs too
    """

    stepper: object
    contact: object
    ledger: Ledger
    frames: list
    deepest: float = 0.0
    steps: int = 0


def fall_freely(options, stepper, report, later=None):
    """Step to the end with a ledger, frames and checkpoints at every output time.

    later : stepper that takes over from springs at options.handover, or None
    """
    shell, path = stepper.shell, report.folder / "ledger.csv"
    start = shell.positions(), shell.directors()
    fall = Fall(stepper, stepper.contact, stepper.add(Ledger(path)), [start])
    series = Series(options.out)
    times = output_times(options)
    for time in console.progress(times, len(times), "drape"):
        with report.stage("solve"):
            if later and time > options.handover:
                hand_over(options.handover, fall, later, report)
                fall.ledger, later = later.add(Ledger(path)), None
            fall.stepper.advance(time)
        with report.stage("output"):
            fall.ledger.record()
            if options.stepper == "explicit" and options.handover is None:
                checkpoint.save(report.folder / "checkpoint.npz", fall.stepper)
            shell = fall.stepper.shell
            series.write(shell, time)
            fall.frames.append((shell.positions(), shell.directors()))
            depth = max(COMM.allgather(fall.contact.max_depth))
            fall.deepest = max(fall.deepest, depth)
    fall.steps += fall.stepper.steps
    report.shift(fall.contact.seconds, "solve", "contact")
    return fall


def output_times(options):
    """Times [s] at which rows and frames are written."""
    return np.linspace(0, options.seconds, options.frames + 1)[1:]


def hand_over(time, fall, later, report):
    """Springs go on to a time [s]; the shell takes over from there."""
    from shellform.dynamics import mass_spring

    fall.stepper.advance(time)
    report.shift(fall.contact.seconds, "solve", "contact")
    mass_spring.hand_over(fall.stepper, later)
    fall.steps, fall.stepper, fall.contact = fall.stepper.steps, later, later.contact


def show(options, fall, results):
    """Print what it cost and what carries the weight."""
    cost, n = results["microseconds_per_node_and_step"], options.cells
    print(f"{n} x {n} cells, {fall.steps} steps of {fall.stepper.dt:.2e} s, ", end="")
    print(f"{cost:.2f} microseconds a node and step")
    force = np.round(results["contact_force"], 4)
    print(f"weight {results['weight']:.4f} N, contact {force} N, ", end="")
    print(f"pin {np.round(results['pin_force'], 4)} N over {results['window']:.2f} s")
    print(f"mean height {results['mean_height']:.4f} m, strain energy ", end="")
    print(f"{results['strain_energy']:.3e} J, depth {1e3 * fall.deepest:.4f} mm")


def show_choice(options, choice, stepper):
    """Print the cells chosen, the errors predicted and the time that it will take."""
    took = None  # of implicit steps no time was measured
    if options.stepper == "explicit":
        work = len(stepper.shell.surface.points), options.seconds / stepper.dt
        took = seconds("drape", choice.family, *work) / COMM.size
    console.say(choice.lines(took))


def newton_results(fall, report):
    """What implicit steps add to the results; iterations."""
    stepper = fall.stepper
    report.shift(stepper.equilibrium.assembly_seconds, "solve", "assemble")
    return {
        "solves": stepper.solves,
        "cutbacks": stepper.cutbacks,
        "unsettled_steps": fall.contact.unsettled,
    }, stepper.newton_iterations


def main(given=None):
    options = arguments(given)
    choice = cells_for(options) if options.cells is None else None
    report = Report(options.out, "drape", vars(options), COMM)
    with report.stage("setup"):
        shell, body = sheet(options), body_of(options)
        names = list(body.names)
        report.describe(shell, inertia="lumped", contact=names, friction=options.friction)
    with report.stage("compile"):
        stepper, later = stepper_of(options, shell, body), None
        stepper.strain_energy()
    if choice:
        show_choice(options, choice, stepper)
    if options.handover is not None:
        # springs first, on a sheet of their own
        first = copy.copy(options)
        first.stepper, first.model = "explicit", "particles"
        stepper, later = stepper_of(first, sheet(options), body), stepper
    perturb(options, stepper)
    fall = fall_freely(options, stepper, report, later)

    results, iterations, entries = summarise(options, fall), 0, {}
    if COMM.rank == 0:
        cost = 1e6 * report.seconds["solve"] + 1e6 * report.seconds["contact"]
        cost /= fall.steps * len(shell.surface.points)
        results["microseconds_per_node_and_step"] = cost
        show(options, fall, results)
        with report.stage("output"):
            cells, apart = shell.surface.cells, output_times(options)[0]
            # only here: rank 0 alone draws
            from shellform.pictures.cloth_on_body import draw_cloth_on_body

            draw_cloth_on_body(report.folder, "drape", fall.frames, cells, body, apart)
            if options.wrinkles == "relaxed":
                # only here: nobody else needs it
                from shellform.pictures.wrinkles import draw_drape_wrinkles

                draw_drape_wrinkles(report.folder / "wrinkles.png", body, report.folder)
    if options.stepper == "implicit":
        more, iterations = newton_results(fall, report)
        results |= more
    if choice:
        with report.stage("solve"):
            entries["accuracy"] = reached(options, choice, body, results["mean_height"])
        console.say([accuracy_line(entries["accuracy"])])
    entries |= {"steps": fall.steps, "newton_iterations": iterations}
    report.write(results, time_step=fall.stepper.dt, **entries)
    written = "summary.json, ledger.csv, drape.png, drape.gif, series.pvd"
    written += ", wrinkles.png" if options.wrinkles == "relaxed" else ""
    console.say([f"wrote {report.folder}/{written}"])


def summarise(options, fall):
    """The keys of results in summary.json; forces are means over the window at the end."""
    stepper, ledger, positions = fall.stepper, fall.ledger, fall.frames[-1][0]
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
        "max_penetration": fall.deepest,
        "momentum_residual": max(row["momentum_residual"] for row in rows),
    }


if __name__ == "__main__":
    console.run(main)
