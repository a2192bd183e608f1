# SPDX-License-Identifier: LGPL-3.0-or-later
"""The scenes of contact in implicit steps: nodes held by an active set, penalty, augmented one.

A run is given up where a step fails for good, and after a number of solves.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from contact.geometry.ellipsoid import closest_points
from demos import capstan
from demos.studies.contact_methods import scenes
from demos.studies.contact_methods.augmented_lagrangian import AugmentedNewmark
from shellform import Body, Contact, Fixed, ImplicitNewmark, Segment, Shell
from shellform.errors import NotConverged

TURNS = 10
MOST_SOLVES = 5000
COLUMNS = ("error %", "depth [mm]", "steps", "solves", "cut back")


class GivenUp(Exception):
    """A run that does not end."""


def stepper_of(
    shell: Shell, body: Body, friction: float, dt: float, drag: float, stiffness: float | None,
    turns: int,
) -> tuple[Any, Callable[[], np.ndarray]]:  # fmt: skip
    """Stepper, and what gives the impulses (n, 3) of the body so far [N s].

    stiffness : float [Pa/m], or None for an active set; turns : int, 0 for a penalty
    """
    options = {"alpha": -0.3, "drag": drag}
    if stiffness is None:
        held = ImplicitNewmark(shell, dt, **options)
        contact = held.add(Contact(body, friction))
        return held, lambda: contact.window.impulse.copy()
    centre = body.new_pose()[0][0]
    pressed = AugmentedNewmark(
        shell, dt, body.radii[0], centre, friction, stiffness, turns, **options
    )
    return pressed, lambda: pressed.impulse.copy()


def advance(stepper: Any, until: float) -> None:
    """Steps of the greatest length, parts of them where they fail."""
    dt = stepper.largest_dt
    for _ in range(round((until - stepper.time) / dt)):
        stepper.step(dt)
        if stepper.solves > MOST_SOLVES:
            raise GivenUp(f"after {MOST_SOLVES} solves, at {stepper.time:.3f} s")


def depth_of(stepper: Any, body: Body) -> float:
    """How deep the deepest node lies [m]."""
    shell = stepper.shell
    radii, centre = body.radii[0], body.new_pose()[0][0]
    distance = closest_points(shell.positions(), radii, centre)[2]
    return float(max(0.0, 0.5 * shell.fabric.thickness - distance.min()))


def belt(method: Any) -> tuple[float, Any, Body]:
    """Relative error of the ratio of tensions, the stepper, the body."""
    shell, out = capstan.belt_alone(16)
    body = Body([Segment("cylinder", (0.1, 100.0, 0.1), Fixed())])
    stepper, _ = stepper_of(shell, body, 0.3, 2e-3, 5.0, *method)
    advance(stepper, 0.3)
    before, since = stepper.support_total.copy(), stepper.time
    advance(stepper, 0.3 + np.pi * 0.1 / 16 / capstan.SPEED)
    pull = (stepper.support_total - before) / (stepper.time - since)
    ratio = float(pull @ out[1]) / capstan.HELD
    return ratio / capstan.exact(0.3, np.pi) - 1, stepper, body


def sleeve(method: Any) -> tuple[float, Any, Body]:
    """The same of the force of a sleeve."""
    shell, body = scenes.stretched_sleeve()
    stepper, impulse = stepper_of(shell, body, 0.0, 2e-3, 60.0, *method)
    advance(stepper, 0.1)
    before, since = impulse(), stepper.time
    advance(stepper, 0.14)
    force = shell.partition.gather((impulse() - before) / (stepper.time - since))
    return scenes.error_of_sleeve(force, shell.positions()), stepper, body


def drape(method: Any) -> tuple[float, Any, Body]:
    """The same of the weight of a square on a ball."""
    shell, body = scenes.square_on_a_ball(6)
    stepper, impulse = stepper_of(shell, body, 0.3, 5e-3, 20.0, *method)
    advance(stepper, 0.8)
    before, since = impulse(), stepper.time
    advance(stepper, 1.0)
    up = (impulse() - before)[:, 2].sum() / (stepper.time - since)
    return scenes.error_of_weight(float(up)), stepper, body


SCENES = {"capstan": belt, "sleeve": sleeve, "drape": drape}


def run(scene: str, stiffness: float | None, turns: int) -> dict[str, Any]:
    """Row of the table: see `stepper_of`; the error says where a run was given up."""
    try:
        error, stepper, body = SCENES[scene]((stiffness, turns))
    except (GivenUp, NotConverged) as ended:
        said = str(ended).partition(": SNES")[0]
        return dict.fromkeys(COLUMNS, np.nan) | {COLUMNS[0]: said}
    numbers = (
        100 * error, 1e3 * depth_of(stepper, body), stepper.steps, stepper.solves, stepper.cutbacks
    )  # fmt: skip
    return dict(zip(COLUMNS, numbers, strict=True))
