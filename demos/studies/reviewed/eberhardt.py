# SPDX-License-Identifier: LGPL-3.0-or-later
r"""Eberhardt, Weber and Strasser: particles pushed by piecewise linear curves with hysteresis.

The energies of Breen's particles become forces in Lagrange's equations, curves become piecewise
linear, loading and unloading differ, and a Runge-Kutta method adapts its step. Here the branches of
a loop lie Y to both sides of an elastic curve f, joined by a slope k:

    stress = f(e) + s,   s' = k e' while |s| < Y or where s turns back, 0 else,
    m v' = -sum h^2 stress de/dx + m g - drag m v,

integrated by PETSc's TS of type rk (Dormand and Prince, 5th order) with its adapter. Strains are
those of thread_grid.py. Two cycles as of a KES test, of shear and of bending, end in work per area
that must be the area of the loop, 4 Y (a - Y/k) at the amplitude a; then a square of cloth hangs
from a table as in breen.py, its shell with the same curves and friction beside it.

Source. IEEE Comput. Graph. Appl. 16(5), 1996, 52-59.

    python -m demos.studies.reviewed.eberhardt --out out/reviewed
"""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from petsc4py import PETSc

import numpy as np

from demos.studies.drape.figures import print_table, write_table
from demos.studies.reviewed.breen import (
    TABLE,
    G,
    cloth,
    hung,
    measures,
    pushed,
    sheet,
    summary,
)
from demos.studies.reviewed.cusick_drape import options
from demos.studies.reviewed.thread_grid import Grid, grid, on_table
from shellform import console
from shellform.material.friction import ClothFriction
from shellform.material.sheet import Sheet

SHEAR_SLIDER, BEND_SLIDER = (60.0, 0.6), (6e-5, 3e-4)  # (k, Y): N/m, N/m and N m, N
SLOW = 10.0  # 1/s, drag of the tests
Motion = Callable[[float], tuple[np.ndarray, np.ndarray]]  # places and velocities (k, 3) at a time


@dataclass
class Particles:
    """Crossings of a fabric, some of them led along a motion.

    Attributes
    ----------
    led : nodes; motion : theirs; gravity [m/s^2]; drag [1/s]
    steps, rejected : of the last run; sizes : list of step [s]
    """

    cells: Grid
    fabric: Sheet
    led: np.ndarray
    motion: Motion
    gravity: float = 0.0
    drag: float = SLOW
    steps: int = 0
    rejected: int = 0
    sizes: list[float] = field(default_factory=list)

    def __post_init__(self):
        law, n = self.fabric.law, len(self.cells.points)
        self.shear = np.array(law.shear_angle.x), np.array(law.shear_angle.y)
        self.bend = np.array(law.bend_warp.x), np.array(law.bend_warp.y)
        sliders = len(self.cells.corners), len(self.cells.bends)
        self.at = np.cumsum([0, 3 * n, 3 * n, *sliders, 1])
        # unknowns of the size of one: lengths, speeds, stresses, work
        yields = SHEAR_SLIDER[1], BEND_SLIDER[1]
        h = self.cells.spacing
        sizes = h, 10.0 * h, *yields, yields[0] * h**2
        self.scale = np.repeat(sizes, np.diff(self.at))
        self.mass = self.fabric.areal_mass * self.cells.areas

    def start(self, x: np.ndarray) -> np.ndarray:
        """Unknowns of particles at rest at x (n, 3)."""
        y = np.zeros(self.at[-1])
        y[: self.at[1]] = x.ravel()
        return y / self.scale

    def places(self, y: np.ndarray) -> np.ndarray:
        """Places (n, 3) [m]."""
        return (y * self.scale)[: self.at[1]].reshape(-1, 3)

    def work(self, y: np.ndarray) -> float:
        """Work [J] done by what leads."""
        return float((y * self.scale)[-1])

    def rates(self, t: float, y: np.ndarray) -> np.ndarray:
        """Time derivative of the unknowns."""
        x, v, s_shear, s_bend, _ = np.split(y * self.scale, self.at[1:-1])
        x, v = x.reshape(-1, 3).copy(), v.reshape(-1, 3).copy()
        x[self.led], v[self.led] = self.motion(t)
        stretch = self.cells.elongations(x)
        force = stretch.forces(self.fabric.membrane[0, 0] * stretch.values, len(x))
        slips = []
        for strains, curve, slider, s in (
            (self.cells.angles(x), self.shear, SHEAR_SLIDER, s_shear),
            (self.cells.curvatures(x, signed=True), self.bend, BEND_SLIDER, s_bend),
        ):
            stress = piecewise(strains.values, *curve) + np.clip(s, -slider[1], slider[1])
            force += strains.forces(stress, len(x))
            pace = strains.rates(v)
            slips.append(np.where((np.abs(s) < slider[1]) | (s * pace < 0), slider[0] * pace, 0.0))
        push = force / self.mass[:, None] - self.drag * v
        push[:, 2] -= self.gravity
        push[self.led] = 0.0
        power = -np.sum(force[self.led] * v[self.led])
        return np.concatenate([v.ravel(), push.ravel(), *slips, [power]]) / self.scale

    def run(self, y: np.ndarray, until: float, tolerance: float, since: float = 0.0) -> np.ndarray:
        """Integrate from `since` [s]; `tolerance` of a step in the scaled unknowns."""
        ts = PETSc.TS().create(PETSc.COMM_SELF)
        vector = PETSc.Vec().createWithArray(y.copy(), comm=PETSc.COMM_SELF)

        def function(ts, t, y, out):
            out.setArray(self.rates(t, y.array_r))

        times = []
        ts.setOptionsPrefix("eberhardt_")
        ts.setType(PETSc.TS.Type.RK)
        ts.setRKType(PETSc.TS.RKType.RK5DP)
        ts.setRHSFunction(function, vector.duplicate())
        ts.setTime(since)
        ts.setTimeStep(1e-5)
        ts.setMaxTime(until)
        ts.setMaxSteps(10**7)
        ts.setExactFinalTime(PETSc.TS.ExactFinalTime.MATCHSTEP)
        ts.setTolerances(rtol=0.0, atol=tolerance)
        ts.setMonitor(lambda ts, k, t, y: times.append(t))
        ts.setFromOptions()
        ts.solve(vector)
        self.steps, self.rejected = ts.getStepNumber(), ts.getStepRejections()
        self.sizes = np.diff(times).tolist()
        found = vector.array_r.copy()
        ts.destroy()
        return found


def piecewise(e: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """The curve through points, mirrored below zero, by straight lines, the last one prolonged."""
    size = np.abs(e)
    beyond = np.maximum(size - x[-1], 0.0) * (y[-1] - y[-2]) / (x[-1] - x[-2])
    return np.sign(e) * (np.interp(size, x, y) + beyond)


def loop_area(slider: tuple[float, float], amplitude: float) -> float:
    """Area of the closed loop between the branches."""
    k, most = slider
    return 4 * most * (amplitude - most / k)


def shear_test(amplitude: float, period: float) -> tuple[Particles, float]:
    """A piece of 2 x 2 cells in a frame whose upright sides turn; area [m^2] that is sheared.

    With free sides, as in a KES test, the threads across would tilt there: 2 % of so small a piece.
    """
    cells = grid((3, 3), 0.01)
    led = np.delete(np.arange(9), 4)
    height = cells.points[led, 1:2] + 0.01

    def motion(t):
        turn = 2 * np.pi / period
        angle, pace = amplitude * np.sin(turn * t), amplitude * turn * np.cos(turn * t)
        x = cells.points[led] + height * np.array([np.sin(angle), np.cos(angle) - 1, 0.0])
        return x, height * pace * np.array([np.cos(angle), -np.sin(angle), 0.0])

    return Particles(cells, cloth(), led, motion), float(cells.of_corners.sum())


def bending_test(amplitude: float, period: float) -> tuple[Particles, float]:
    """A strip of 4 cells rolled to and fro by its ends; area [m^2] that is bent."""
    cells = grid((5, 2), 0.01)
    s = np.round(cells.points[:, 0] / 0.01).astype(int)
    led = np.flatnonzero(np.abs(s) >= 1)

    def places(angle):
        # a polygon whose sides turn by `angle` from each to the next, the middle node at z = 0
        at = s[led]
        sides = np.sign(at)[:, None] * (np.arange(1, 3) <= np.abs(at)[:, None])
        lean = angle * (np.arange(1, 3) - 0.5) * np.sign(at)[:, None]
        x = cells.points[led].copy()
        x[:, 0] = 0.01 * np.sum(sides * np.cos(lean), axis=1)
        x[:, 2] = 0.01 * np.sum(sides * np.sin(lean), axis=1)
        return x

    def motion(t):
        turn, step = 2 * np.pi / period, 1e-6
        largest = 2 * np.arcsin(0.5 * 0.01 * amplitude)
        angle, pace = largest * np.sin(turn * t), largest * turn * np.cos(turn * t)
        return places(angle), pace * (places(angle + step) - places(angle - step)) / (2 * step)

    weft = cells.of_bends.sum()
    return Particles(cells, cloth(), led, motion), float(weft)


TESTS = {"shear": (shear_test, 0.14, SHEAR_SLIDER), "bending": (bending_test, 60.0, BEND_SLIDER)}


def cycle(kind: str, tolerance: float, period: float = 0.05) -> dict:
    """The second cycle of a test: its work per area beside that of the loop, and its steps."""
    test, amplitude, slider = TESTS[kind]
    particles, area = test(amplitude, period)
    y = particles.run(particles.start(particles.cells.points), period, tolerance)
    before = particles.work(y)
    y = particles.run(y, 2 * period, tolerance, since=period)
    found, wanted = (particles.work(y) - before) / area, loop_area(slider, amplitude)
    sizes = 1e6 * np.array(particles.sizes)[1:-1]  # the first is given, the last ends the cycle
    return {
        "test": kind, "tolerance": f"{tolerance:g}", "loop [J/m2]": found,
        "off %": 100 * (found / wanted - 1), "steps": particles.steps,
        "rejected": particles.rejected, "shortest [us]": sizes.min(), "longest [us]": sizes.max(),
    }  # fmt: skip


def hang(cells: int, start: int, seconds: float, tolerance: float) -> tuple[dict, Particles]:
    """The square of cloth on its table at the end of a fall."""
    square = sheet(cells)
    led = on_table(square.points, 0.5 * TABLE)
    held = square.points[led], np.zeros((len(led), 3))
    particles = Particles(square, cloth(), led, lambda t: held, gravity=G, drag=5.0)
    x = square.points.copy()
    x[:, 2] = pushed(x, start)
    y = particles.run(particles.start(x), seconds, tolerance)
    return measures(particles.places(y), cells), particles


def main(given: Sequence[str] | None = None) -> None:
    asked = options(given, "Piecewise linear forces with hysteresis by adaptive Runge-Kutta.")
    tolerances = (1e-3, 1e-5) if asked.quick else (1e-3, 1e-4, 1e-5, 1e-6, 1e-7)
    rows = [cycle(kind, tolerance) for kind in TESTS for tolerance in tolerances]
    print_table("The second cycle of a test", rows, list(rows[0]))
    write_table(f"{asked.out}/eberhardt_cycles.csv", rows)

    cells, seconds = (8, 0.3) if asked.quick else (12, 1.0)
    begun, found = time.process_time(), []
    for start in range(1, asked.starts + 1):
        measured, particles = hang(cells, start, seconds, 1e-3)
        found.append(measured)
    spent = time.process_time() - begun
    rows = [summary("particles, Runge-Kutta", found, spent, particles.steps)]
    friction = ClothFriction(shear=[SHEAR_SLIDER], bend_warp=[BEND_SLIDER], bend_weft=[BEND_SLIDER])
    for name, fabric in (
        ("shell with the same friction", cloth(B_twist_uN_m=0.05).with_friction(friction)),
        ("shell without", cloth(B_twist_uN_m=0.05)),
    ):
        begun, found = time.process_time(), []
        for start in range(1, asked.starts + 1):
            x, steps = hung(fabric, cells, start, seconds)
            found.append(measures(x, cells))
        rows.append(summary(name, found, time.process_time() - begun, steps))
    print_table(f"A square of cloth on a table, {cells} cells a side", rows, list(rows[0]))
    write_table(f"{asked.out}/eberhardt_drape.csv", rows)


if __name__ == "__main__":
    console.run(main)
