# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a bed of flesh under the skin changes of the torque of trousers: why it is off by default.

    python -m demos.studies.bodies.flesh --out out/flesh

The walk of `run.py` on the body of triangles, from the same starts, with hard skin and with a
Winkler bed everywhere (contact/body/flesh_bed.py). Printed are root mean squares of the torque
about the axis of flexion with their standard errors, the 95 % interval of the difference, and the
depth to which the mean pressure of a window presses the bed, pressure over stiffness.
"""

import argparse
from dataclasses import replace
from pathlib import Path

from shellform import console
from shellform.scene.scene import Scene
from shellform.simulation.ensemble import run
from shellform.simulation.summary import summary_of

from .run import scene_of, torque_lines

SKINS = ("hard", "flesh")


def on_flesh(scene: Scene, stiffness: float) -> Scene:
    """The scene with a bed of that stiffness [Pa/m] under all skin."""
    return replace(scene, contact=replace(scene.contact, flesh_bed={"body": stiffness}))


def depth_line(folder: Path, stiffness: float) -> str:
    """How deep the pressure of a run presses such a bed."""
    pressed = summary_of(folder)["results"]["pressure"]
    words = ", ".join(f"{name} {value:.3g}" for name, value in pressed.items())
    return f"{folder.name}: pressure {words}; 1 kPa is {1e6 / stiffness:.2f} mm deep"


def main(given: list[str] | None = None) -> None:
    """Run both and print the table."""
    parser = argparse.ArgumentParser(allow_abbrev=False, description="A walk on flesh.")
    parser.add_argument("--out", type=Path, default=Path("out/flesh"))
    parser.add_argument("--strides", type=console.positive(int), default=4)
    parser.add_argument("--obstacle", type=float, default=0.5, help="height [m], 0 for none")
    parser.add_argument("--runs", type=console.positive(int), default=3)
    parser.add_argument("--stiffness", type=console.positive(float), default=6.7e5, help="[Pa/m]")
    parser.add_argument("--table", action="store_true", help="of runs that are there")
    options = console.parse(parser, given)
    scene, folders = scene_of("mesh", options), [options.out / skin for skin in SKINS]
    scene = replace(scene, output=replace(scene.output, pressure=0.03))
    if not options.table:
        for one, folder in zip((scene, on_flesh(scene, options.stiffness)), folders, strict=True):
            run(one, folder, console.COMM)
    lines = [depth_line(folder, options.stiffness) for folder in folders]
    console.say([*torque_lines(folders, SKINS), *lines])


if __name__ == "__main__":
    console.run(main)
