# SPDX-License-Identifier: LGPL-3.0-or-later
r"""Contact by impulses that let nothing in, by penalties and augmented Lagrangians, side by side.

The paper's Sec. 3.2 reviews penalties (Hallquist's slidelines) and augmented Lagrangians (Simo and
Laursen). In explicit steps a penalty of k [Pa/m] is a bed of that stiffness under the skin
(flesh_bed.py of contact); in implicit steps both are those of augmented_lagrangian.py, beside nodes
held by an active set with impulses (implicit_contact.py of shellform). Three scenes with exact
answers:

    capstan   T2/T1 = exp(mu phi) of a belt drawn over a cylinder
    sleeve    hoop tension N of a stretched tube on a cylinder: force 2 pi L N
    drape     a square lies on a sphere: force up is its weight

What is printed: error of the answer, how deep the cloth lies below the skin, steps, solves, steps
that failed and were cut in two, and seconds of processor time. A run that does not end is given up,
and its row says where.

    python -m demos.studies.contact_methods.run --out out/contact_methods
"""

import argparse
import time
from pathlib import Path

import numpy as np

from demos import capstan
from demos.studies.contact_methods import implicit, scenes
from demos.studies.drape.figures import print_table, write_table
from shellform import Contact, Flesh, Newmark, console

STIFFNESSES = (1e5, 1e6, 1e7, 1e8)  # Pa/m
AUGMENTED = (1e5, 1e6, 1e7)  # Pa/m
KINDS = ("explicit", "implicit")


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
    shell, limb = scenes.stretched_sleeve()
    stepper = Newmark(shell, 0.9, damping=2e-4, drag=60.0)
    contact = stepper.add(Contact(limb, 0.0, flesh=flesh))
    stepper.advance(0.1)
    contact.reset()
    stepper.advance(0.14)
    window = contact.window
    force = shell.partition.gather(window.impulse / window.seconds)
    return scenes.error_of_sleeve(force, shell.positions()), stepper


def drape(flesh: Flesh | None) -> tuple[float, Newmark]:
    """The same of the weight of a square on a sphere."""
    shell, ball = scenes.square_on_a_ball(6)
    stepper = Newmark(shell, 0.8, drag=8.0, damping=1e-3)
    contact = stepper.add(Contact(ball, 0.3, flesh=flesh))
    stepper.advance(3.0)
    contact.reset()
    stepper.advance(3.5)
    up = shell.comm.allreduce(contact.window.impulse[:, 2].sum()) / contact.window.seconds
    return scenes.error_of_weight(up), stepper


SCENES = {"capstan": belt, "sleeve": sleeve, "drape": drape}


def rows_of(scene: str, stiffnesses: tuple[float, ...]) -> list[dict]:
    """Explicit steps, impulses first, then penalties."""
    rows: list[dict] = []
    for k in (None, *stiffnesses):
        start = time.process_time()
        error, stepper = SCENES[scene](None if k is None else Flesh(k))
        rows.append(
            {
                "scene": scene, "steps are": "explicit", "contact": name_of(k),
                "error %": 100 * error, "depth [mm]": 1e3 * depth_of(stepper),
                "steps": stepper.steps, "solves": 0, "cut back": 0,
                "seconds": time.process_time() - start,
            }
        )  # fmt: skip
    return rows


def implicit_rows_of(
    scene: str, stiffnesses: tuple[float, ...], augmented: tuple[float, ...]
) -> list[dict]:
    """Implicit steps: nodes held by an active set, penalties, augmented Lagrangians."""
    methods: list[tuple[float | None, int]] = [(None, 0), *((k, 0) for k in stiffnesses)]
    methods += [(k, implicit.TURNS) for k in augmented]
    rows: list[dict] = []
    for k, turns in methods:
        start = time.process_time()
        run = implicit.run(scene, k, turns)
        row = {"scene": scene, "steps are": "implicit", "contact": name_of(k, turns)}
        rows.append(row | run | {"seconds": time.process_time() - start})
    return rows


def name_of(stiffness: float | None, turns: int = 0) -> str:
    """Of a method, for the table."""
    if stiffness is None:
        return "impulses"
    return f"{'augmented' if turns else 'penalty'} {stiffness:.0e} Pa/m"


def main(given=None) -> None:
    parser = argparse.ArgumentParser(allow_abbrev=False, description="Contact by several methods.")
    parser.add_argument("--scenes", nargs="+", choices=SCENES, default=list(SCENES))
    parser.add_argument(
        "--stiffness", nargs="+", type=console.positive(float), default=STIFFNESSES, help="Pa/m"
    )
    parser.add_argument(
        "--augmented", nargs="+", type=console.positive(float), default=AUGMENTED, help="Pa/m"
    )
    parser.add_argument("--steps", nargs="+", choices=KINDS, default=list(KINDS))
    parser.add_argument("--out", default="out/contact_methods", help="folder for results")
    options = console.parse(parser, given)
    rows: list[dict] = []
    for scene in options.scenes:
        if "explicit" in options.steps:
            rows += rows_of(scene, tuple(options.stiffness))
        if "implicit" in options.steps:
            rows += implicit_rows_of(scene, tuple(options.stiffness), tuple(options.augmented))
    print_table("Contact by impulses, penalties, augmented Lagrangians", rows, list(rows[0]))
    Path(options.out).mkdir(parents=True, exist_ok=True)
    write_table(f"{options.out}/contact_methods.csv", rows)


if __name__ == "__main__":
    console.run(main)
