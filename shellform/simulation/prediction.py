# SPDX-License-Identifier: LGPL-3.0-or-later
"""Errors and time predicted before a run, and what is entered into its summary afterwards."""

from dataclasses import replace

from shellform.accuracy import measured
from shellform.accuracy.choice import Choice
from shellform.scene.scene import Scene

from .model import Model

ON_TRIANGLES = "errors and time were measured on ellipsoids: on this body they are a guess"
DRESSED = 2.5  # s, that dressing takes if the cloth is soon quiet, as measured


def choice_of(model: Model) -> Choice:
    """`Choice` of the cells that are there; a garment from a file has its own."""
    scene = model.scene
    if not scene.garment.file:
        return scene.choice
    return replace(scene.choice.at(model.surface.mean_cell_size), asked=None, kept=True)


def prediction_lines(model: Model) -> list[str]:
    """Lines before a run: the errors predicted and the time it will take on these ranks."""
    choice, wearer = choice_of(model), model.wearer
    if not choice.power_laws:
        return choice.lines()
    steps = (wearer.end - wearer.start + DRESSED) / model.stepper.dt
    nodes = len(model.surface.points)
    work = measured.seconds(choice.case, choice.family, nodes, steps)
    lines = choice.lines(work / model.comm.size)
    return lines if model.skin is None else [*lines, ON_TRIANGLES]


def accuracy_entry(model: Model) -> dict:
    """`accuracy` of summary.json for a run that no other with other cells accompanies."""
    choice = choice_of(model)
    error = choice.error if choice.power_laws else None
    where = "" if model.skin is None else " on ellipsoids"
    return choice.summary(error, f"from errors measured beforehand{where}, no run beside")


def tricks(scene: Scene) -> dict[str, dict]:
    """Tricks of a scene that buy time, with what they were measured to change."""
    names = ["dressed by particles"] if scene.steps.dressing == "particles" else []
    return measured.tricks("walk", names)
