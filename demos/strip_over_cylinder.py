# SPDX-License-Identifier: LGPL-3.0-or-later
r"""A strip hung over a cylinder, against the heavy elastica with an arc of contact.

Objective. Where to meet a body: at the nodes, or inside the cells as well?

Equations. A strip of bending stiffness D and weight q per area lies without friction on a cylinder
and hangs down on both sides. With the radius rho of the mid-surface, arc length s from the top to
the end S and slope angle phi below the horizontal, the part beyond the contact obeys

    D phi'' = -q (S - s) cos phi,   phi'(S) = 0,   phi = s/rho and phi' = 1/rho where it lifts off.

On the arc the moment D/rho is constant, so no shear force acts there: the body pushes with
p = T/rho + q cos phi, T being the tension. Just outside, the shear force is -q (S - s) cos phi; the
body balances it by a point force where the strip lifts off, phi = c:

    P = q (S - s_c) cos c,   T = q (S - s_c) sin c + q rho (cos phi - cos c).

The membrane stretches a little (T over its stiffness); that is part of the reference, to first
order. It is solved by shooting, to 1e-10.

What is compared. Half a strip is brought to rest by explicit steps with drag: its tip, where it
lifts off, the sum of the forces, their normal part, moment and spread over the angle.

Source. The heavy elastica as in the theory of rods; derived here.

    python demos/strip_over_cylinder.py --cells 8 16 32 64 --out out/strip_over_cylinder

prints a table and leaves summary.json and strip_over_cylinder.png in the folder.
"""

import argparse
import time
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp, trapezoid
from scipy.optimize import brentq

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
GRAVITY, WIDTH, WINDOW = 9.81, 0.02, 0.05  # m/s^2, m, s


class Scene(NamedTuple):
    """Half a strip on a cylinder; SI units."""

    radius: float = 0.05
    length: float = 0.25
    bending_length: float = 0.03  # (D/q)^(1/3)
    areal_mass: float = 0.2
    thickness: float = 1e-3
    membrane: float = 2000.0  # N/m; longer than inextensible by 1e-4 at the top

    @property
    def rho(self):
        return self.radius + 0.5 * self.thickness

    @property
    def q(self):
        return self.areal_mass * GRAVITY

    @property
    def D(self):
        return self.q * self.bending_length**3


class Elastica(NamedTuple):
    """The reference; forces per width."""

    scene: Scene
    angle: float  # c, where the strip lifts off
    lift_off: float  # s_c
    shape: object  # s -> phi, M, x, z beyond s_c

    @property
    def tip(self):
        return self.shape(self.scene.length)[2:]

    @property
    def point_force(self):
        return self.scene.q * (self.scene.length - self.lift_off) * np.cos(self.angle)

    def pushed(self, phi):
        """Sum of the body's normal force from the top to the angle phi (k,) [N/m]."""
        q, rho = self.scene.q, self.scene.rho
        T = q * (self.scene.length - self.lift_off) * np.sin(self.angle)
        a = np.minimum(phi, self.angle)
        arc = T * a + q * rho * (2 * np.sin(a) - a * np.cos(self.angle))
        return arc + np.where(phi >= self.angle, self.point_force, 0.0)

    def profile(self, points=400):
        """Mid-surface (points, 2), x and z [m]."""
        a = np.linspace(0, self.angle, points // 2)[:, None]
        s = np.linspace(self.lift_off, self.scene.length, points - len(a))
        return np.vstack([self.scene.rho * np.hstack([np.sin(a), np.cos(a)]), self.shape(s)[2:].T])


def elastica(scene):
    """Solve for the angle at which the strip lifts off, by shooting from there to the end.

    Of several solutions the one with the largest angle hangs down; others fold back on themselves.
    """
    q, D, rho, S, K = scene.q, scene.D, scene.rho, scene.length, scene.membrane

    def beyond(angle):
        s = rho * angle
        for _ in range(20):  # stretched: ds = rho dphi / (1 + T/K)
            T = q * (S - s) * np.sin(angle)
            stretch = T * angle + q * rho * (np.sin(angle) - angle * np.cos(angle))
            s = rho * (angle - stretch / K)

        def rates(s, y):
            phi, M = y[:2]
            longer = 1 + q * (S - s) * np.sin(phi) / K
            bend = -longer * q * (S - s) * np.cos(phi)
            return M / D, bend, longer * np.cos(phi), -longer * np.sin(phi)

        start = angle, D * (1 + T / K) / rho, rho * np.sin(angle), rho * np.cos(angle)
        return s, solve_ivp(rates, (s, S), start, rtol=1e-10, atol=1e-13, dense_output=True)

    def moment(angle):
        return beyond(angle)[1].y[1, -1]

    trials = np.linspace(0.5 * np.pi - 1e-3, 0.02, 40)
    for high, low in pairwise(trials):
        if moment(high) * moment(low) < 0:
            angle = brentq(moment, low, high, xtol=1e-12)
            s, solution = beyond(angle)
            return Elastica(scene, angle, s, solution.sol)
    raise ValueError(
        f"a strip of {S} m and bending length {scene.bending_length} m does not lie on a cylinder "
        f"of radius {scene.radius} m along an arc: make it longer or softer"
    )


def strip(scene, cells, samples, drag=12.0, friction=0.0):
    """Stepper and contact of half a strip, bent over the cylinder, its end straight."""
    surface = meshes.rectangle(scene.length, WIDTH, (cells, 1))
    surface = surface.transform(translation=(0, -0.5 * WIDTH, scene.rho))
    ones = np.diag([1, 1, 0.5])
    fabric = Fabric.from_stiffness(
        scene.membrane * ones,
        scene.D * ones,
        areal_mass=scene.areal_mass,
        thickness=scene.thickness,
    )
    shell = Shell(surface, fabric, COMM)
    shell.supports.symmetry("left", (1, 0, 0))
    shell.supports.symmetry(lambda points: np.full(len(points), True), (0, 1, 0))
    shell.loads.gravity((0, 0, -GRAVITY))
    s = surface.points[shell.partition.nodes, 0]
    phi = np.minimum(s / scene.rho, 1.2)
    tail = s - scene.rho * phi
    x = scene.rho * np.sin(phi) + tail * np.cos(phi)
    z = scene.rho * (np.cos(phi) - 1) - tail * np.sin(phi)
    w = shell.w.x.array.reshape(-1, 6)
    w[:, 0], w[:, 2] = x - s, z
    w[:, 3:] = np.column_stack([np.sin(phi), 0 * phi, np.cos(phi)])
    stepper = Newmark(shell, 0.9, drag=drag)
    body = Body([Segment("cylinder", (scene.radius, 100.0, scene.radius), Fixed())])
    return stepper, stepper.add(Contact(body, friction, samples=samples))


def measure(exact, stepper, contact, until=2.0):
    """Errors at rest against the reference.

    Returns
    -------
    dict: tip (distance over the length), angle (last node pushed) [rad], weight (vertical force
    over the weight, less 1), normal (sum of normal forces, relative), moment (its mean angle,
    relative), spread (mean error of the sum of forces up to the middle of each cell, over the
    whole), speed [m/s]; microseconds a step; nodes (k, 2), forces (k,)
    """
    shell, scene = stepper.shell, exact.scene
    start, before = time.perf_counter(), contact.seconds
    stepper.advance(until - WINDOW)
    # drag acts on free velocities: with it the body pushes less by drag dt/2
    stepper.drag = 0.0
    contact.reset()
    stepper.advance(until)
    seconds, in_contact = time.perf_counter() - start, contact.seconds - before
    force = shell.partition.gather(contact.window.impulse / contact.window.seconds)
    place, rest = shell.positions(), shell.surface.points
    order = np.lexsort((rest[:, 1], rest[:, 0])).reshape(-1, 2)
    nodes = place[order].mean(axis=1)[:, [0, 2]]
    force = force[order].sum(axis=1)[:, [0, 2]] / WIDTH
    phi = np.arctan2(nodes[:, 0], nodes[:, 1])
    push = np.sum(force * nodes, axis=1) / np.linalg.norm(nodes, axis=1)
    total = exact.pushed(np.array([np.pi]))[0]
    angles = np.linspace(0, exact.angle, 2001)
    mean = trapezoid(total - exact.pushed(angles), angles)  # the sum of angle times force
    middle = 0.5 * (phi[1:] + phi[:-1])
    error = np.abs(np.cumsum(push)[:-1] - exact.pushed(middle)) / total
    speed = max(shell.comm.allgather(np.abs(stepper.v).max()))
    return {
        "tip": np.linalg.norm(nodes[-1] - exact.tip) / scene.length,
        "angle": phi[push > 1e-6 * push.max()].max() - exact.angle,
        "weight": force[:, 1].sum() / (scene.q * scene.length) - 1,
        "normal": push.sum() / total - 1,
        "moment": push @ phi / mean - 1,
        "spread": error[middle < 0.5 * np.pi].mean(),
        "speed": speed,
        "us_per_step": 1e6 * seconds / stepper.steps,
        "us_contact": 1e6 * in_contact / stepper.steps,
        "nodes": nodes,
        "force": push,
        "phi": phi,
    }


def order(cells, errors):
    """Order of convergence: slope of log error over log cells, by least squares."""
    return -np.polyfit(np.log(cells), np.log(np.abs(errors)), 1)[0]


def arguments(given):
    parser = argparse.ArgumentParser(
        allow_abbrev=False,
        description="Hang a strip over a cylinder and compare it with the exact elastica.",
        epilog="Options with one dash go to PETSc.",
    )
    positive = console.positive
    parser.add_argument("--cells", type=positive(int), nargs="+", help="on half the strip")
    parser.add_argument("--samples", type=int, nargs="+", default=[0, 1], help="0: nodes; k: k x k")
    parser.add_argument("--seconds", type=positive(float), default=2.0, help="to come to rest")
    parser.add_argument("--radius", type=positive(float), default=0.05, help="m")
    parser.add_argument("--length", type=positive(float), default=0.25, help="of half a strip, m")
    parser.add_argument("--bending-length", type=positive(float), default=0.03, help="m")
    parser.add_argument("--accuracy", type=console.accuracy, default=0.001, metavar="N%")
    parser.add_argument("--out", default="out/strip_over_cylinder", help="folder for results")
    options = console.parse(parser, given)
    if options.seconds <= 2 * WINDOW:
        parser.error(f"--seconds must be more than {2 * WINDOW}")
    if min(options.samples) < 0:
        parser.error("--samples must be 0 or more")
    return options


def cells_for(options):
    """The choice of cells for the accuracy asked for; sets options.cells, half as many first."""
    length = min(options.radius, options.bending_length)
    choice = choose("strip", options.accuracy, length)
    count = max(6, int(np.ceil(options.length / choice.size)))
    options.cells = [max(3, count // 2), count]
    return choice.at(options.length / count)


def reached(choice, coarse, fine, length):
    """`accuracy` of summary.json, from runs with half the cells and with all."""
    by = (len(fine["nodes"]) - 1) / (len(coarse["nodes"]) - 1)
    apart = np.linalg.norm(fine["nodes"][-1] - coarse["nodes"][-1]) / length
    how = f"tips of {len(coarse['nodes']) - 1} and {len(fine['nodes']) - 1} cells"
    return choice.summary(richardson(float(apart), 0.0, by, choice.order), how)


QUANTITIES = ("tip", "angle", "weight", "normal", "moment", "spread")


def show_reference(exact):
    """Print the elastica and the head of the table."""
    x, z = exact.tip
    total = exact.pushed(np.array([9.0]))[0]
    print(
        f"elastica: lifts off at {np.degrees(exact.angle):.2f} degrees, tip {x:.5f} {z:.5f} m, "
        f"point force {exact.point_force:.4f} of {total:.4f} N/m"
    )
    print(f"{'':14}{'cells':>6}" + "".join(f"{q:>11}" for q in QUANTITIES) + "   speed  us/step")


def show(label, cells, found):
    """Print a row of the table."""
    errors = "".join(f"{found[name]:11.1e}" for name in QUANTITIES)
    cost = f"{found['speed']:8.0e} {found['us_per_step']:8.0f}"
    print(f"{label:14}{cells:6d}{errors}{cost}", flush=True)


def show_orders(cells, runs):
    """Print the order of convergence of every quantity."""
    slopes = (order(cells, [found[name] for found in runs]) for name in QUANTITIES)
    print(f"{'  order':20}" + "".join(f"{slope:11.1f}" for slope in slopes))


def main(given=None):
    options = arguments(given)
    choice = cells_for(options) if options.cells is None else None
    report = Report(options.out, "strip_over_cylinder", vars(options), COMM)
    scene = Scene(options.radius, options.length, options.bending_length)
    exact = elastica(scene)
    if COMM.rank == 0:
        show_reference(exact)

    runs, steps = {}, 0
    for k in options.samples:
        label = f"{k} x {k} inside" if k else "nodes"
        runs[label] = []
        for cells in options.cells:
            with report.stage("setup"):
                stepper, contact = strip(scene, cells, k)
            if choice and (k, cells) == (options.samples[0], options.cells[-1]):
                work = len(stepper.shell.surface.points), options.seconds / stepper.dt
                took = measured.seconds("strip", choice.family, *work) / COMM.size
                console.say(choice.lines(took))
            with report.stage("solve"):
                found = measure(exact, stepper, contact, options.seconds)
            report.shift(contact.seconds, "solve", "contact")
            steps += stepper.steps
            runs[label].append(found)
            if COMM.rank == 0:
                show(label, cells, found)
        if COMM.rank == 0 and len(options.cells) > 1:
            show_orders(options.cells, runs[label])
    report.describe(stepper.shell, inertia=True, contact=True)

    with report.stage("output"):
        if COMM.rank == 0:
            draw(report.folder / "strip_over_cylinder.png", exact, options.cells, runs)
    entries = {}
    if choice:
        entries["accuracy"] = reached(choice, *next(iter(runs.values())), options.length)
        console.say([accuracy_line(entries["accuracy"])])
    results = results_of(exact, options.cells, runs)
    report.write(results, steps=steps, newton_iterations=0, **entries)
    console.say([f"wrote {report.folder}/summary.json, strip_over_cylinder.png"])


def results_of(exact, cells, runs):
    """The keys of results in summary.json."""
    columns = (*QUANTITIES, "us_per_step")
    return {
        "angle_exact": exact.angle,
        "tip_exact": exact.tip,
        "point_force_exact": exact.point_force,
        "runs": {
            label: [
                {"cells": n} | {name: float(one[name]) for name in columns}
                for n, one in zip(cells, found, strict=True)
            ]
            for label, found in runs.items()
        },
    }


def draw(path, exact, cells, runs):
    """The strip at rest, forces summed over the angle, and errors over cells."""
    # only here: rank 0 alone draws
    from shellform.pictures.surfaces import new_figure, save_figure

    title = "A strip over a cylinder: contact at nodes, and inside cells as well"
    figure, (left, middle, right) = new_figure(1, (12, 4.4), title, columns=3)
    line, scene = exact.profile(), exact.scene
    turn = np.linspace(0, 2 * np.pi, 200)
    left.fill(scene.radius * np.sin(turn), scene.radius * np.cos(turn), color="#d8a48f")
    left.plot(*line.T, "k", lw=0.8, label="elastica")
    angles = np.linspace(0, 0.6 * np.pi, 1000)
    middle.plot(np.degrees(angles), exact.pushed(angles), "k", lw=0.8, label="elastica")
    shown = min(range(len(cells)), key=lambda i: abs(cells[i] - 32))
    for mark, (label, found) in zip("os^Dv", runs.items(), strict=False):
        (drawn,) = left.plot(*found[0]["nodes"].T, mark, ms=4, mfc="none", label=label)
        colour, one = drawn.get_color(), found[shown]
        half = 0.5 * (one["phi"][1:] + one["phi"][:-1])
        near = half < angles[-1]
        at = np.degrees(half[near]), np.cumsum(one["force"])[:-1][near]
        middle.plot(*at, mark, ms=4, mfc="none", color=colour, label=label)
        for name, style in (("tip", "-"), ("spread", "--")):
            values = [abs(f[name]) for f in found]
            right.loglog(cells, values, mark + style, ms=4, color=colour, label=f"{name}, {label}")
    guide = np.array(cells, float)
    right.loglog(guide, 3e-3 * (guide / guide[0]) ** -2, ":", color="grey", label="order 2")
    left.set_aspect("equal")
    left.set(xlabel="x [m]", ylabel="z [m]", title=f"{cells[0]} cells")
    middle.set(xlabel="angle from the top [degrees]", title=f"{cells[shown]} cells")
    middle.set_ylabel("sum of normal forces [N/m]")
    right.set(xlabel="cells", ylabel="relative error")
    right.set_xticks(cells, [str(n) for n in cells])
    right.minorticks_off()
    for axes in (left, middle, right):
        axes.legend(fontsize=7)
    save_figure(figure, path)


if __name__ == "__main__":
    console.run(main)
