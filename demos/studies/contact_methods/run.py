# SPDX-License-Identifier: LGPL-3.0-or-later
r"""Contact by impulses that let nothing in, and by penalties, in explicit steps, side by side.

The paper's Sec. 3.2 reviews penalties (Hallquist's slidelines) and augmented Lagrangians (Simo and
Laursen). A penalty of k [Pa/m] is a bed of that stiffness under the skin (flesh_bed.py of contact).
Three scenes with exact answers:

    capstan   T2/T1 = exp(mu phi) of a belt drawn over a cylinder
    sleeve    hoop tension N of a stretched tube on a cylinder: force 2 pi L N
    drape     a square lies on a sphere: force up is its weight

What is printed: error of the answer, how deep the cloth lies below the skin, steps, and the time a
step takes beside that of the impulses. The augmented Lagrangian, of statics, stands beside these
in demos/studies/reviewed (eischen), on a strip laid on a table.

    python -m demos.studies.contact_methods.run --out out/contact_methods
"""

import argparse
import time
from pathlib import Path

import numpy as np

import meshes
from demos import capstan
from demos.studies.drape.figures import print_table, write_table
from shellform import Body, Contact, Fabric, Fixed, Flesh, Newmark, Segment, Shell, console

STIFFNESSES = (1e5, 1e6, 1e7, 1e8)  # Pa/m
CLOTH = Fabric.isotropic(1e6, 0.0, 1e-3, 200.0)
G = 9.81


def depth_of(stepper) -> float:
    """Deepest node in the flesh [m]; of a hard body the deepest start of a step."""
    correction = stepper.contact.correction
    if stepper.contact.flesh is None:
        return correction.max_depth
    pressed = correction.sides["owner"] >= 0
    return float(correction.sides["depth"][pressed].max(initial=0.0))


def belt(flesh: Flesh | None, cells: int = 16) -> tuple[float, Newmark]:
    """Relative error of the ratio of tensions, and the stepper."""
    stepper, out = capstan.belt(cells, flesh=flesh)
    found = capstan.ratios(stepper, out, np.pi * 0.1 / cells)
    return found.mean() / capstan.exact(0.3, np.pi) - 1, stepper


def sleeve(flesh: Flesh | None) -> tuple[float, Newmark]:
    """The same of the force of a sleeve, on a cylinder without friction."""
    rest, radius, long = 0.048, 0.05, 0.1
    surface = meshes.cylinder(rest, long, (40, 6)).transform(translation=(0, 0, -0.5 * long))
    shell = Shell(surface.replace(warp=(0.0, 0.0, 1.0)), CLOTH)
    points = surface.points[shell.partition.nodes]
    shell.w.x.array.reshape(-1, 6)[:, :3] = (radius / rest - 1) * points * [1.0, 1.0, 0.0]
    stepper = Newmark(shell, 0.9, damping=2e-4, drag=60.0)
    limb = Body([Segment("arm", (radius - 5e-4, radius - 5e-4, 200.0), Fixed())])
    contact = stepper.add(Contact(limb, 0.0, flesh=flesh))
    stepper.advance(0.1)
    contact.reset()
    stepper.advance(0.14)
    window = contact.window
    force = shell.partition.gather(window.impulse / window.seconds)
    outward = np.sum(force * surface.points * [1, 1, 0] / rest)
    tension = 1e3 * 0.5 * ((radius / rest) ** 2 - 1) * radius / rest
    return outward / (2 * np.pi * long * tension) - 1, stepper


def drape(flesh: Flesh | None) -> tuple[float, Newmark]:
    """The same of the weight of a square on a sphere."""
    surface = meshes.rectangle(0.5, 0.5, (12, 12)).transform(translation=(-0.24, -0.255, 2e-3))
    shell = Shell(surface, CLOTH)
    shell.loads.gravity((0.0, 0.0, -G))
    stepper = Newmark(shell, 0.8, drag=8.0, damping=1e-3)
    ball = Body([Segment("ball", [0.25] * 3, Fixed((0.0, 0.0, -0.25)))])
    contact = stepper.add(Contact(ball, 0.3, flesh=flesh))
    stepper.advance(3.0)
    contact.reset()
    stepper.advance(3.5)
    up = shell.comm.allreduce(contact.window.impulse[:, 2].sum()) / contact.window.seconds
    return up / (CLOTH.areal_mass * 0.25 * G) - 1, stepper


SCENES = {"capstan": belt, "sleeve": sleeve, "drape": drape}


def rows_of(scene: str, stiffnesses: tuple[float, ...]) -> list[dict]:
    """Impulses first, then penalties."""
    rows: list[dict] = []
    for k in (None, *stiffnesses):
        start = time.process_time()
        error, stepper = SCENES[scene](None if k is None else Flesh(k))
        step = (time.process_time() - start) / stepper.steps
        rows.append(
            {
                "scene": scene, "contact": "impulses" if k is None else f"penalty {k:.0e} Pa/m",
                "error %": 100 * error, "depth [mm]": 1e3 * depth_of(stepper),
                "steps": stepper.steps, "time a step, ratio": step,
            }
        )  # fmt: skip
    first = rows[0]["time a step, ratio"]
    return [row | {"time a step, ratio": row["time a step, ratio"] / first} for row in rows]


def main(given=None) -> None:
    parser = argparse.ArgumentParser(allow_abbrev=False, description="Contact by several methods.")
    parser.add_argument("--scenes", nargs="+", choices=SCENES, default=list(SCENES))
    parser.add_argument(
        "--stiffness", nargs="+", type=console.positive(float), default=STIFFNESSES, help="Pa/m"
    )
    parser.add_argument("--out", default="out/contact_methods", help="folder for results")
    options = console.parse(parser, given)
    rows = [row for scene in options.scenes for row in rows_of(scene, tuple(options.stiffness))]
    print_table("Contact by impulses and by penalties, explicit steps", rows, list(rows[0]))
    Path(options.out).mkdir(parents=True, exist_ok=True)
    write_table(f"{options.out}/contact_methods.csv", rows)


if __name__ == "__main__":
    console.run(main)
