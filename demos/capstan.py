# SPDX-License-Identifier: LGPL-3.0-or-later
r"""A belt that slides around a cylinder: Euler's and Eytelwein's capstan, a test of Eq. 16.

Objective. Does friction at nodes add up to what it is along a line? A belt lies over the angle phi
on a cylinder. One end is held back with the tension T1, the other is drawn along with a steady
speed.

Equations. With friction mu everywhere at its limit, dT/dphi = mu T, so that

    T2/T1 = exp(mu phi).

What is compared. The ratio of the tensions while the belt travels by one cell. Nodes that turn the
belt by alpha each are small capstans of their own; by equilibrium of two straight pieces and a node
between them

    T2/T1 = (1 + mu tan(alpha/2)) / (1 - mu tan(alpha/2)),

so that cells leave a relative error of mu phi (1 + mu^2) alpha^2/12 (a series of the above).

Source. Euler's and Eytelwein's formula, as in any book of mechanics.

    python demos/capstan.py --cells 8 16 24 --friction 0.3 --out out/capstan
    python demos/capstan.py --accuracy 1%

prints a table and leaves summary.json in the folder.
"""

import argparse
import time

import numpy as np

import meshes
from contact.body.segments import Body, Fixed, Segment
from shellform import Fabric, Shell, console
from shellform.accuracy import measured
from shellform.accuracy.choice import accuracy_line, choose
from shellform.accuracy.convergence import richardson
from shellform.contact_coupling.contact import Contact
from shellform.dynamics.explicit import Newmark
from shellform.results.report import Report

COMM = console.COMM
WIDTH, TAIL, HELD, SPEED = 0.02, 0.15, 2.0, 0.1  # m, m, N, m/s
RAMP, BEFORE, WINDOW = 0.05, 0.3, 0.02  # s: until the full speed; until all slides; of a mean
DAMPING, DRAG = 5e-5, 5.0  # s, 1/s


def arguments(given):
    parser = argparse.ArgumentParser(
        allow_abbrev=False,
        description="Draw a belt over a cylinder; tensions against exp(mu phi).",
        epilog="Options with one dash go to PETSc, as -shell_ts_monitor.",
    )
    positive = console.positive
    parser.add_argument("--cells", type=positive(int), nargs="+", help="on the arc")
    parser.add_argument("--friction", type=positive(float), default=0.3)
    parser.add_argument("--radius", type=positive(float), default=0.1, help="m")
    parser.add_argument("--angle", type=positive(float), default=180.0, help="degrees, below 360")
    parser.add_argument("--time-step-factor", type=positive(float), default=0.9)
    parser.add_argument("--accuracy", type=console.accuracy, default=0.01, metavar="N%")
    parser.add_argument("--out", default="out/capstan", help="folder for results")
    options = console.parse(parser, given)
    if options.angle >= 360:
        parser.error("--angle is below 360 degrees: the belt does not meet itself")
    return options


def exact(friction, angle):
    """T2/T1; angle in rad."""
    return float(np.exp(friction * angle))


def sensitivity(friction, angle):
    """What the error of a cell is multiplied by: mu phi (1 + mu^2)."""
    return friction * angle * (1 + friction**2)


def belt_alone(cells, radius=0.1, angle=np.pi):
    """Shell of a belt with `cells` on an arc [rad], and where its two ends draw (2, 3)."""
    rho = radius + 5e-4
    arc = angle * rho

    def place(a, b):
        s = a * (arc + 2 * TAIL) - TAIL
        on = np.clip(s, 0, arc)
        phi, off = on / rho - 0.5 * angle, s - on
        x, z = rho * np.sin(phi) + off * np.cos(phi), rho * np.cos(phi) - off * np.sin(phi)
        return x, WIDTH * (b - 0.5), z

    # nodes on both tangent points: a whole number of cells on the arc and on the tails
    ends = max(2, round(cells * TAIL / arc))
    tail = np.linspace(0, TAIL, ends + 1)
    s = np.concatenate([tail[:-1] - TAIL, np.linspace(0, arc, cells + 1)[:-1], arc + tail])
    a = (s + TAIL) / (arc + 2 * TAIL)
    parameters = np.stack(np.meshgrid(a, [0.0, 1.0], indexing="ij"), axis=-1)
    surface = meshes.patch(place, (len(a) - 1, 1), parameters=parameters)
    plane = np.diag([1, 1, 0.5])
    shell = Shell(surface, Fabric.from_stiffness(1e4 * plane, 1e-6 * plane, 0.2, 1e-3), COMM)
    half = 0.5 * angle
    out = np.array([[-np.cos(half), 0.0, -np.sin(half)], [np.cos(half), 0.0, -np.sin(half)]])
    for edge in ("bottom", "top"):
        shell.supports.symmetry(edge, (0, 1, 0))
    shell.loads.line("left", HELD / WIDTH * out[0], lambda t: min(1.0, t / 0.02))
    shell.supports.hold("right")
    shell.supports.move("right", lambda t: travel(t) * out[1])
    return shell, out


def belt(cells, friction=0.3, radius=0.1, angle=np.pi, factor=0.9, flesh=None):
    """Stepper of a belt over a cylinder, and where its two ends draw (2, 3).

    flesh : of the cylinder, or None
    """
    shell, out = belt_alone(cells, radius, angle)
    stepper = Newmark(shell, factor, damping=DAMPING, drag=DRAG)
    body = Body([Segment("cylinder", (radius, 100.0, radius), Fixed())])
    contact = stepper.add(Contact(body, friction, flesh=flesh))
    # the sides are held in their planes, which is no reason for contact to leave them alone
    contact.correction.fixed[:] = False
    return stepper, out


def travel(t):
    """How far [m] the belt's end has been drawn."""
    return SPEED * (0.5 * t**2 / RAMP if t < RAMP else t - 0.5 * RAMP)


def seconds(size):
    """Time [s] of a run with cells of this size [m]: the mean is over the travel of one cell."""
    return BEFORE + size / SPEED


def ratios(stepper, out, size):
    """T2/T1 (k,) while the belt travels by a cell of `size` [m], means over about `WINDOW`."""
    comm, found = stepper.shell.comm, []
    stepper.advance(BEFORE)
    count = max(2, round(size / SPEED / WINDOW))
    for until in np.linspace(BEFORE, seconds(size), count + 1)[1:]:
        start, impulse = stepper.time, comm.allreduce(stepper.support_total).copy()
        stepper.advance(until)
        pull = (comm.allreduce(stepper.support_total) - impulse) / (stepper.time - start)
        found.append(float(pull @ out[1]) / HELD)
    return np.array(found)


def deviation(found, goal):
    """Relative error: root mean square over the travel of a cell."""
    return float(np.sqrt(np.mean((found / goal - 1) ** 2)))


def cells_for(options):
    """The choice of cells for the accuracy asked for; sets options.cells, half as many first."""
    angle = np.radians(options.angle)
    arc, factor = angle * options.radius, sensitivity(options.friction, angle)
    choice = choose("capstan", options.accuracy, options.radius, sensitivity=factor)
    count = max(4, int(np.ceil(arc / choice.size)))
    # the difference to the coarser one is what the finer one leaves
    options.cells = [max(2, round(count / 2)), count]
    return choice.at(arc / count)


def reached(choice, options, rows, last):
    """`accuracy` of summary.json; last : ratios (k,) of the finest belt.

    The exact value is not looked at: how the fine ones swing, and what halving leaves.
    """
    swing = np.std(last) / last.mean()
    apart = richardson(*(row[1] for row in rows), 2.0, 2.0)
    error = float(np.hypot(swing, apart / last.mean()))
    coarse, fine = options.cells
    how = f"swing of {fine} cells and difference of their mean from that of {coarse}"
    return choice.summary(error, how)


def show(goal, rows):
    """Print the table."""
    print(f"exact T2/T1 {goal:.5f}\n cells     T2/T1   of mean       rms  seconds")
    for n, mean, error, rms, took in rows:
        print(f"{n:6d}  {mean:8.5f}  {error:8.1e}  {rms:8.1e}  {took:7.1f}")


def main(given=None):
    options = arguments(given)
    report = Report(options.out, "capstan", dict(vars(options)), COMM)
    mu, angle = options.friction, np.radians(options.angle)
    arc, goal = angle * options.radius, exact(mu, angle)
    choice = cells_for(options) if options.cells is None else None

    rows, steps = [], 0
    for n in options.cells:
        with report.stage("setup"):
            stepper, out = belt(n, mu, options.radius, angle, options.time_step_factor)
        if choice and n == options.cells[-1]:
            work = len(stepper.shell.surface.points), seconds(arc / n) / stepper.dt
            took = measured.seconds("capstan", choice.family, *work) / COMM.size
            console.say(choice.lines(took))
        start = time.perf_counter()
        with report.stage("solve"):
            found = ratios(stepper, out, arc / n)
        took = time.perf_counter() - start
        rows.append((n, found.mean(), found.mean() / goal - 1, deviation(found, goal), took))
        steps += stepper.steps
    report.describe(stepper.shell, inertia="lumped", contact=["cylinder"])

    entries = {"accuracy": reached(choice, options, rows, found)} if choice else {}
    if COMM.rank == 0:
        show(goal, rows)
    if choice:
        console.say([accuracy_line(entries["accuracy"])])
    keys = ("cells", "ratio", "error_of_mean", "error", "seconds")
    results = {"exact": goal, "runs": [dict(zip(keys, row, strict=True)) for row in rows]}
    report.write(results, steps=steps, newton_iterations=0, **entries)
    console.say([f"wrote {report.folder}/summary.json"])


if __name__ == "__main__":
    console.run(main)
