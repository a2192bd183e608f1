# SPDX-License-Identifier: LGPL-3.0-or-later
r"""A sleeve around a bending knee: torque against angle, and where its energy goes.

Objective. Is the joint torque, summed from contact forces, the one that energy demands? A stretched
tube sits on a knee of two ellipsoids, held by contact alone: the limb is thinnest at the joint. The
shank bends and straightens in cycles.

Equations. The torque about the joint J is that of all contact forces below it, Fig. 9,

    tau_J = sum over AJ of (x_i - J) x f_i.

Without friction it follows from the strain energy U of the sleeve, and a cycle takes nothing:

    tau = -dU/dtheta.

What is compared. The two sides of that, window by window. With friction the torque opposes the
motion, and the loop it runs through encloses what friction takes in a cycle (less, in the first
one, what stays in the sleeve).

Source. The principle of virtual work; the scene is made for it.

    python demos/hinge_sleeve.py --friction 0 0.2 --cycles 2 --out out/hinge_sleeve
    mpirun -n 2 python demos/hinge_sleeve.py

prints a table and leaves summary.json, torque.csv of the last run and hinge_sleeve.png.
"""

import argparse
import time

import numpy as np

import meshes
from shellform import Fabric, Shell, console
from shellform.accuracy import measured
from shellform.accuracy.choice import accuracy_line, choose
from shellform.accuracy.convergence import companion_cells, companion_error
from shellform.contact_coupling.contact import Contact
from shellform.dynamics.explicit import Newmark
from shellform.fem.lumped_mass import ROTARY_SCALE
from shellform.motion.recording import Recording
from shellform.motion.wearer import Wearer
from shellform.results.joint_torque import Torque
from shellform.results.ledger import Ledger
from shellform.results.report import Report

COMM = console.COMM
LENGTH, APART = 0.3, 0.1  # m: semi-axis along the limb; from the knee to an ellipsoid's middle
REST, HALF = 0.055 / 0.06, 0.06  # radius of the sleeve over the limb's; half its length, m
STILL, WINDOWS = 0.05, 60  # s, to settle; rows a cycle
MEASURED_AT = 25.0  # degrees, to which it bends in the study of error against cost
BELOW = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, -0.4], [0.0, -0.06, -0.4]])  # J1, J2, M of the shank
ABOVE = np.array([[0.0, 0.0, 0.4], [0.0, 0.0, 0.0], [0.0, -0.06, 0.0]])  # of the thigh


def arguments(given):
    parser = argparse.ArgumentParser(
        allow_abbrev=False,
        description="Bend a knee in a sleeve; draw the torque against the angle.",
        epilog="Options with one dash go to PETSc, as -shell_ts_monitor.",
    )
    positive = console.positive
    parser.add_argument("--friction", type=float, nargs="+", default=[0.0, 0.2])
    parser.add_argument("--angle", type=positive(float), default=20.0, help="degrees")
    parser.add_argument("--period", type=positive(float), default=0.3, help="of a cycle, s")
    parser.add_argument("--cycles", type=positive(int), default=2)
    parser.add_argument("--radius", type=positive(float), default=0.06, help="of the limb, m")
    parser.add_argument("--around", type=positive(int), help="cells (default: accuracy)")
    parser.add_argument("--time-step-factor", type=positive(float), default=0.9)
    parser.add_argument("--rotary-scale", type=float, default=ROTARY_SCALE, help="of directors")
    parser.add_argument(
        "--mass-scale", type=positive(float), default=1.0, help="of the sleeve, for larger steps"
    )
    parser.add_argument("--accuracy", type=console.accuracy, default=0.02, metavar="N%")
    parser.add_argument("--out", default="out/hinge_sleeve", help="folder for results")
    options = console.parse(parser, given)
    if not 0.02 <= options.radius <= 0.09:
        parser.error("--radius of a limb lies between 0.02 and 0.09 m")
    if options.rotary_scale < 0:
        parser.error("--rotary-scale is not negative")
    return options


def flexion(options, t):
    """Angle [rad] at times t."""
    cycles = np.maximum(t - STILL, 0.0) / options.period
    return np.radians(options.angle) * np.sin(np.pi * cycles) ** 2


def knee(options):
    """The wearer: a thigh that stands still and a shank that bends about the origin."""
    end = STILL + options.cycles * options.period
    times = np.linspace(0.0, end, int(np.ceil(400 * end / min(options.period, 1.0))) + 1)
    cos, sin = np.cos(flexion(options, times)), np.sin(flexion(options, times))
    shank = np.stack(
        [np.outer(sin, BELOW[:, 2]), 0 * sin[:, None] + BELOW[:, 1], np.outer(cos, BELOW[:, 2])],
        axis=-1,
    )
    points = {"right_thigh": np.array([ABOVE] * len(times)), "right_shank": shank}
    middle, radii = 0.2 - APART, (LENGTH, options.radius, options.radius)
    ellipsoids = [("thigh", "right_thigh", (middle, 0, 0), radii)]
    ellipsoids += [("shank", "right_shank", (-middle, 0, 0), radii)]
    return Wearer(Recording(times, points, "hinge"), ellipsoids)


def size_of(options):
    """Size of the cells around the limb [m]."""
    return 2 * np.pi * options.radius / options.around


def along(size):
    """Cells along the sleeve, an odd number: a row of nodes in the crease would be caught there."""
    return 2 * max(1, round(HALF / size - 0.5)) + 1


def sleeve(options):
    """The stretched tube, two millimetres off the limb."""
    rest = REST * options.radius
    surface = meshes.cylinder(rest, 2 * HALF, (options.around, along(size_of(options))))
    surface = surface.transform(translation=(0, 0, -HALF)).replace(warp=(0.0, 0.0, 1.0))
    plane = np.diag([1.0, 1.0, 0.5])
    fabric = Fabric.from_stiffness(
        1e3 * plane, 3e-4 * plane, 0.2 * options.mass_scale, thickness=1e-3
    )
    shell = Shell(surface, fabric, COMM)
    X = surface.points[shell.partition.nodes]
    limb = options.radius * np.sqrt(1 - ((APART - np.abs(X[:, 2:])) / LENGTH) ** 2) + 2e-3
    shell.w.x.array.reshape(-1, 6)[:, :2] = (limb / rest - 1) * X[:, :2]
    return shell


def cycles(options, friction, folder=None):
    """Play all cycles; columns angle [rad], torque [N m], strain energy [J]; losses a cycle [J].

    Also nodes, steps and the processors' seconds of the steps.
    """
    stepper = Newmark(
        sleeve(options),
        options.time_step_factor,
        drag=100.0,
        rotary_scale=options.rotary_scale,
    )
    start = time.process_time()
    contact = stepper.add(Contact(knee(options), friction))
    stepper.advance(STILL)
    stepper.drag = 10.0
    contact.reset()
    torque = stepper.add(Torque(folder and folder / "torque.csv"))
    ledger = stepper.add(Ledger())
    count = WINDOWS * options.cycles
    times = STILL + options.period * np.arange(count + 1) / WINDOWS
    strain, lost, found = [ledger.record()["strain"]], [], []
    for t in console.progress(times[1:], count, f"friction {friction:g}"):
        stepper.advance(t)
        row = ledger.record()
        strain.append(row["strain"])
        lost.append(row["friction_loss"])
        found += [r["torque_flexion"] for r in torque.record(t) if r["joint"] == "right_knee"]
    theta = flexion(options, times)
    turned, found, strain = np.diff(theta), np.array(found), np.array(strain)
    by_cycle = (-1, WINDOWS)
    return {
        "angle": 0.5 * (theta[1:] + theta[:-1]),
        "torque": found,
        "loop": -(found * turned).reshape(by_cycle).sum(axis=1),
        "friction": np.reshape(lost, by_cycle).sum(axis=1),
        "kept": np.diff(strain).reshape(by_cycle).sum(axis=1),
        "slope": -np.diff(strain) / np.where(turned == 0, np.nan, turned),
        "strain": strain,
        "core_seconds": COMM.allreduce(time.process_time() - start),
        "nodes": len(stepper.shell.surface.points),
        "steps": stepper.steps,
    }


def apart(one, other):
    """Root mean square of the difference of two runs' torques, over that of the first."""
    a, b = one["torque"], other["torque"]
    return float(np.sqrt(np.mean((a - b) ** 2) / np.mean(a**2)))


def sensitivity(angle):
    """Error by cells of a given part of the radius, over that at the angle it was measured at.

    With 24 and 32 cells around, bent by 10, 15, 20, 25, 30 degrees, the torque differs from that
    with 48 by 1.8, 2.5, 3.9, 8.8, 17 and 1.1, 1.4, 1.3, 4.4, 7.9 %: about as the angle squared.
    """
    return (angle / MEASURED_AT) ** 2


def cells_for(options):
    """The choice of cells for the accuracy asked for; sets options.around."""
    choice = choose("sleeve", options.accuracy, options.radius, sensitivity(options.angle))
    options.around = max(12, int(np.ceil(2 * np.pi * options.radius / choice.size)))
    choice = choice.at(size_of(options))
    nodes = options.around * (along(choice.size) + 1)
    # steps as long as those measured with cells of this size: all scale with the size alike
    until = (STILL + options.cycles * options.period) * len(options.friction)
    # the step goes with the root of the mass
    steps = until / measured.step_of("sleeve", choice.size) / np.sqrt(options.mass_scale)
    took = measured.seconds("sleeve", choice.family, nodes, steps) / COMM.size
    console.say(choice.lines(took))
    return choice


def tricks(options):
    """What of the options buys time, and what it was measured to change."""
    used = []
    if options.mass_scale != 1:
        used.append(f"mass {options.mass_scale:g}")
    if options.rotary_scale != ROTARY_SCALE:
        used.append(f"rotary {options.rotary_scale:g}")
    return measured.tricks("sleeve", used)


def replace_around(options, around):
    """The same options with another number of cells."""
    return argparse.Namespace(**vars(options) | {"around": around})


def draw(path, runs):
    """Torque against angle, and -dU/dtheta where there is no friction."""
    # only here: rank 0 alone draws
    from shellform.pictures.surfaces import new_figure, save_figure

    figure, axes = new_figure(1, (6.5, 4.5), "A sleeve around a bending knee")
    for friction, run in runs.items():
        angle = np.degrees(run["angle"])
        axes.plot(angle, run["torque"], lw=1.3, label=f"friction {friction:g}")
        if friction == 0:
            axes.plot(angle, run["slope"], "k.", ms=4, label="$-dU/d\\theta$")
    axes.set_xlabel("flexion [degrees]")
    axes.set_ylabel("torque on the shank [N m]")
    axes.legend(frameon=False)
    save_figure(figure, path)


def show(runs):
    """Print the table of cycles."""
    print("friction  cycle  loop of torque [J]  friction took [J]  stayed [J]  peak [N m]")
    for friction, run in runs.items():
        peaks = np.abs(run["torque"]).reshape(-1, WINDOWS).max(axis=1)
        table = zip(run["loop"], run["friction"], run["kept"], peaks, strict=True)
        for k, (loop, lost, kept, peak) in enumerate(table, start=1):
            print(f"{friction:8g}  {k:5d}  {loop:18.5f}  {lost:17.5f}  {kept:10.5f}  {peak:.4f}")


def main(given=None):
    options = arguments(given)
    report = Report(options.out, "hinge_sleeve", vars(options), COMM)
    choice, runs, entries = None, {}, {}
    if options.around is None:
        choice = cells_for(options)
    for friction in options.friction:
        with report.stage("solve"):
            runs[friction] = cycles(options, friction, report.folder)

    if choice:
        first = options.friction[0]
        fewest = int(np.ceil(2 * np.pi / choice.power_law.coarsest))
        other = replace_around(options, companion_cells(options.around, fewest))
        with report.stage("solve"):
            difference = apart(runs[first], cycles(other, first))
        error = companion_error(difference, options.around, other.around, choice.order)
        entries["accuracy"] = choice.summary(error, f"run with {other.around} cells around")

    if COMM.rank == 0:
        show(runs)
        with report.stage("output"):
            draw(report.folder / "hinge_sleeve.png", runs)
    keys = ("loop", "friction", "kept")
    if choice:
        console.say([accuracy_line(entries["accuracy"])])
    results = {f"friction {f:g}": {k: r[k].tolist() for k in keys} for f, r in runs.items()}
    entries["tricks"] = tricks(options)
    steps = sum(run["steps"] for run in runs.values())
    report.write(results, steps=steps, newton_iterations=0, **entries)
    if COMM.rank == 0:
        print(f"wrote {report.folder}/summary.json, torque.csv, hinge_sleeve.png")


if __name__ == "__main__":
    console.run(main)
