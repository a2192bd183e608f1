# SPDX-License-Identifier: LGPL-3.0-or-later
"""Errors and time predicted before a run, and what is entered into its summary afterwards."""

from dataclasses import replace

from . import measured

DRESSED = 2.5  # s, that dressing takes if the cloth is soon quiet, as measured


def choice_of(activity):
    """`accuracy.Choice` of the cells that are there; a garment from a file has its own."""
    scene = activity.scene
    if not scene.garment.file:
        return scene.choice
    return replace(scene.choice.at(activity.surface.mean_cell_size), asked=None, kept=True)


def foretold(activity):
    """Lines before a run: the errors predicted and the time it will take on these ranks."""
    choice, wearer = choice_of(activity), activity.wearer
    if not choice.laws:
        return choice.lines()
    steps = (wearer.end - wearer.start + DRESSED) / activity.stepper.dt
    nodes = len(activity.surface.points)
    work = measured.seconds(choice.case, choice.family, nodes, steps)
    return choice.lines(work / activity.comm.size)


def entry(activity):
    """`accuracy` of summary.json for a run with no other beside."""
    choice = choice_of(activity)
    error = choice.error if choice.laws else None
    return choice.summary(error, "from errors measured beforehand, no run beside")


def tricks(scene):
    """Tricks of a scene that buy time, with what they were measured to change."""
    names = ["dressed by particles"] if scene.steps.dressing == "particles" else []
    return measured.tricks("walk", names)
