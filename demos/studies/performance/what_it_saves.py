# SPDX-License-Identifier: LGPL-3.0-or-later
"""What it saves to model only what a scene requires: each thing with and without, side by side.

    python -m demos.studies.performance.what_it_saves --cells 48 --out out/what_it_saves

prints a table and leaves summary.json. Both of a pair are timed in turns in one run and the medians
compared, so that what else the machine does falls on both. One rank.

The last rows are not savings but errors: what leaving the bending out would do, and why it is not
offered. A strip held level at one end hangs straight down without it; a sheet over a ball folds to
the size of its cells: the angle between neighbouring cells does not fall with their size.
"""

import argparse
import subprocess
import sys
import time

from mpi4py import MPI

import numpy as np

import meshes
from contact.body.segments import Body, Fixed, Segment
from contact.solver.velocity_correction import VelocityCorrection
from shellform import Fabric, Shell, Statics
from shellform.console import parse, positive, run
from shellform.contact_coupling.contact import Contact
from shellform.dynamics.explicit import Newmark
from shellform.fem.internal_force import InternalForce
from shellform.material.friction import ClothFriction
from shellform.results.report import Report

G = 9.81
A = 1000.0 / (1 - 0.3**2) * np.array([[1, 0.3, 0], [0.3, 1, 0], [0, 0, 0.35]])
D = 9.16e-5 * np.array([[1, 0.3, 0], [0.3, 1, 0], [0, 0, 0.35]])
# a process starts, makes a step, then loads contact and makes its first correction
START = """
import time
start = time.perf_counter()
import numpy as np, meshes
from shellform import Fabric, Shell
from shellform.dynamics.explicit import Newmark
cloth = Fabric.isotropic(1e6, 0.3, thickness=1e-3, density=300.0)
stepper = Newmark(Shell(meshes.rectangle(1.0, 1.0, (4, 4)), cloth))
stepper.advance(stepper.dt)
alone = time.perf_counter() - start
from contact.body.segments import Body, Fixed, Segment
from shellform.contact_coupling.contact import Contact
stepper.add(Contact(Body([Segment("ball", (1.0, 1.0, 1.0), Fixed((0.0, 0.0, -1.1)))])))
stepper.advance(2 * stepper.dt)
print(time.perf_counter() - start, alone)
"""


def cloth(bending=1.0, coupling=None):
    """1000 N/m, 0.2 kg/m2; `bending` of the stiffness of 1 mm of solid material."""
    return Fabric.from_stiffness(A, bending * D, 0.2, 1e-3, coupling=coupling, name="cloth")


def sheet(cells, fabric=None, pressure=0.0, size=1.0):
    """Shell of a square around the origin, under its weight."""
    square = meshes.rectangle(size, size, (cells, cells))
    square = square.transform(translation=(-0.5 * size, -0.5 * size, 0.0))
    square = square.replace(warp=(1.0, 0.0, 0.0))
    shell = Shell(square, cloth() if fabric is None else fabric, MPI.COMM_SELF)
    shell.loads.gravity((0.0, 0.0, -G))
    shell.loads.pressure(pressure)
    return shell


def in_turns(with_it, without, turns=9):
    """Median seconds of two functions, called in turns after one call each."""
    with_it(), without()
    seconds = np.empty((turns, 2))
    for row in seconds:
        for k, function in enumerate((with_it, without)):
            start = time.perf_counter()
            function()
            row[k] = time.perf_counter() - start
    return np.median(seconds, axis=0)


def steps(stepper, count=100):
    """Function that makes a number of steps."""
    return lambda: stepper.advance(stepper.time + count * stepper.dt)


# ## Things a scene may do without


def mass(cells):
    """Residual and tangent of a static problem, with the inertia of an implicit step or without."""
    shell = sheet(cells)
    shell.supports.clamp("left")
    with Statics(shell) as statics:
        equations, x = statics.equilibrium, statics.equilibrium.x
        nodes = equations.n_owned
        inertia = np.full((nodes, 6), 1.0), np.zeros((nodes, 6))

        def evaluate(value):
            equations.inertia = value
            equations.forces()
            equations.tangent(x)

        return in_turns(lambda: evaluate(inertia), lambda: evaluate(None))


def contact_code(cells):
    """From the start of Python to the end of the first step, with contact or without."""

    def start():
        done = subprocess.run([sys.executable, "-c", START], capture_output=True, check=True)
        return [float(number) for number in done.stdout.split()]

    return np.median([start() for _ in range(3)], axis=0)


def resting(cells):
    """Positions and velocities of a cap of cloth that presses on the unit ball."""
    flat = sheet(cells).surface.points
    x = flat / np.sqrt(1.0 + np.sum(flat**2, axis=1, keepdims=True))
    x[:, 2] = np.sqrt(1.0 - x[:, 0] ** 2 - x[:, 1] ** 2)
    v = np.full_like(x, (0.01, 0.0, -0.01))
    return x, v, np.ones(len(x))


def ball(far=0):
    """A ball of radius 1 m at the origin, and others 10 m away and more."""
    places = [(0.0, 0.0, 0.0), *((10.0 + 3 * k, 0.0, 0.0) for k in range(far))]
    return Body([Segment(f"ball {k}", (1.0, 1.0, 1.0), Fixed(c)) for k, c in enumerate(places)])


def corrections(cells, settings, above=0.0):
    """Contact of the same step of the same cloth under two settings (body, friction)."""
    x, v, m = resting(cells)
    x[:, 2] += above

    def correct(body, friction):
        correction, now = VelocityCorrection(body, len(x), friction), np.empty_like(v)

        def call():
            for _ in range(20):
                np.copyto(now, v)
                correction(x, now, m, 1e-4, 0.0)

        return call

    return in_turns(*(correct(*one) for one in settings))


def friction(cells):
    """Contact of cloth that presses everywhere, with friction 0.3 or 0."""
    return corrections(cells, [(ball(), 0.3), (ball(), 0.0)])


def unreachable(cells):
    """The same contact with seven more ellipsoids that are far away, or not built."""
    return corrections(cells, [(ball(far=7), 0.3), (ball(), 0.3)])


def unreachable_in_air(cells):
    """As `unreachable`, of cloth that touches nothing."""
    return corrections(cells, [(ball(far=7), 0.3), (ball(), 0.3)], above=1.0)


def coupling(cells):
    """Internal force of a sheet whose bending stretches it, or not."""
    forces = []
    for fabric in (cloth(coupling=1e-6 * A), cloth()):
        shell = sheet(cells, fabric)
        force = InternalForce(shell)
        forces.append(lambda f=force, w=shell.w.x.array: [f(w) for _ in range(20)])
    return in_turns(*forces)


def inside(cells):
    """Steps of cloth whose yarns rub on each other in shear and bending, or do not."""
    friction = ClothFriction(
        shear=[(60.0, 0.5, 8.5)], bend_warp=[(6e-5, 3e-4)], bend_weft=[(5e-5, 2.4e-4)]
    )
    fabrics = cloth().with_friction(friction), cloth()
    return in_turns(*(steps(Newmark(sheet(cells, fabric))) for fabric in fabrics))


def damping(cells):
    """Steps with stiffness-proportional damping or without."""
    return in_turns(steps(Newmark(sheet(cells), damping=1e-6)), steps(Newmark(sheet(cells))))


def pressure_load(cells):
    """Steps with a pressure that follows the sheet or without."""
    return in_turns(steps(Newmark(sheet(cells, pressure=0.1))), steps(Newmark(sheet(cells))))


def pressure_map(cells):
    """Steps of cloth that lies on a ball, with a map of the pressure on the skin or without."""
    from shellform.results.skin_pressure import Pressure

    steppers = []
    for mapped in (True, False):
        stepper = Newmark(sheet(cells), drag=5.0)
        body = Body([Segment("ball", (0.5, 0.5, 0.5), Fixed((0.0, 0.0, -0.5005)))])
        stepper.add(Contact(body))
        if mapped:
            stepper.add(Pressure(0.03))
        stepper.advance(0.1)
        steppers.append(stepper)
    return in_turns(*map(steps, steppers))


THINGS = {
    "mass in statics": (mass, "residual and tangent"),
    "contact code": (contact_code, "start to first step"),
    "friction": (friction, "contact of all nodes"),
    "7 bodies out of reach": (unreachable, "contact of all nodes"),
    "the same, cloth in the air": (unreachable_in_air, "contact of no node"),
    "bending-stretching coupling": (coupling, "internal force"),
    "friction inside the cloth": (inside, "step"),
    "damping": (damping, "step"),
    "follower pressure": (pressure_load, "step"),
    "map of pressure on the skin": (pressure_map, "step with contact"),
}


# ## What leaving the bending out would do


def hanging_tip(length, cells=96):
    """Tip's distance from straight down, over the length, of a strip held level at one end.

    With it the length in bending lengths l, and what the elastica under its weight as a constant
    tension leaves: 4 sin(pi/8) (l/L)^(3/2), from its solution 4 atan(tan(pi/8) exp(-s/lambda)),
    lambda^2 = D/(m g L).
    """
    fabric = cloth()
    strip = meshes.rectangle(length, 0.1 * length, (cells, 1))
    shell = Shell(strip, fabric, MPI.COMM_SELF)
    shell.supports.clamp("left")
    shell.loads.gravity((0.0, 0.0, -G))
    with Statics(shell) as statics:
        statics.solve(20)
    tip = shell.positions()[np.unique(strip.edges["right"])].mean(axis=0)
    down = np.array([0.0, 0.05 * length, -length])
    ratio = length / fabric.bending_length()
    return float(np.linalg.norm(tip - down) / length), ratio, 4 * np.sin(np.pi / 8) * ratio**-1.5


def fold_angle(cells, bending, seconds=1.5):
    """Root mean square angle [degrees] between neighbouring cells of a sheet over a ball."""
    shell = sheet(cells, cloth(bending))
    stepper = Newmark(shell, damping=2e-4, drag=2.0)
    random = np.random.default_rng(0)
    stepper.owned[:, 2] += 1e-3 * random.uniform(-1, 1, stepper.n_owned)
    stepper.add(Contact(Body([Segment("ball", (0.25,) * 3, Fixed((0.0, 0.0, -0.3)))])))
    stepper.advance(seconds)
    points = shell.positions()[shell.surface.cells]
    normal = np.cross(points[:, 2] - points[:, 0], points[:, 3] - points[:, 1])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    normal = normal.reshape(cells, cells, 3)
    cosines = [np.sum(normal[1:] * normal[:-1], axis=2), np.sum(normal[:, 1:] * normal[:, :-1], 2)]
    angles = np.arccos(np.clip(np.concatenate([c.ravel() for c in cosines]), -1, 1))
    return float(np.degrees(np.sqrt(np.mean(angles**2))))


def main(given=None):
    parser = argparse.ArgumentParser(
        allow_abbrev=False,
        description="Measure what it saves to leave out what a scene does not need.",
        epilog="Options with one dash go to PETSc.",
    )
    parser.add_argument("--cells", type=positive(int), default=48, help="along a side")
    parser.add_argument("--folds", type=positive(int), default=16, help="coarse cells")
    parser.add_argument("--out", default="out/what_it_saves", help="folder for results")
    options = parse(parser, given)
    if MPI.COMM_WORLD.size > 1:
        raise ValueError("two things are timed side by side on one rank: leave mpirun out")
    report = Report(options.out, "what it saves", vars(options), MPI.COMM_WORLD)
    shell = sheet(options.cells)
    report.describe(shell)
    rows = {}
    print(f"{'left out':28} {'of':22} {'with':>10} {'without':>10} {'ratio':>6}")
    for name, (measure, what) in THINGS.items():
        with report.stage("solve"):
            there, gone = map(float, measure(options.cells))
        rows[name] = {"of": what, "with": there, "without": gone, "ratio": there / gone}
        print(f"{name:28} {what:22} {there:8.4f} s {gone:8.4f} s {there / gone:6.2f}", flush=True)
    with report.stage("solve"):
        tips = [hanging_tip(length) for length in (0.1, 0.2, 0.4)]
        meshes_of = (options.folds, 2 * options.folds)
        angles = {b: [fold_angle(n, b) for n in meshes_of] for b in (1.0, 1e-3)}
    for error, ratio, law in tips:
        print(f"a strip of {ratio:.1f} bending lengths: tip off by {100 * error:.1f} % ", end="")
        print(f"without it, by the elastica {100 * law:.1f} %")
    for bending, (coarse, fine) in angles.items():
        print(f"{bending:g} of the bending stiffness: cells {coarse:.1f} degrees apart; ", end="")
        print(f"half as large, {fine:.1f}: {fine / coarse:.2f} of it")
    results = {
        "savings": rows,
        "tip_error_without_bending": [
            {"error": e, "bending_lengths": r, "law": law} for e, r, law in tips
        ],
        "fold_angles": [{"bending": b, "degrees": a} for b, a in angles.items()],
    }
    report.write(results, steps=0, newton_iterations=0)
    print(f"wrote {report.folder}/summary.json")


if __name__ == "__main__":
    run(main)
