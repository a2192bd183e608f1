# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a scene would model and what it would cost, before it is run: `shellform check`.

Body, garment and stable step are those of the run; seconds are extrapolated from some steps timed
here and now, with the garment still off the body, so they are a guess: contact adds a third.
"""

import resource
import time

import numpy as np

from . import build
from .activity import Activity
from .dressing import Dressing

TIMED = 200  # steps
CONTACT = 1.35  # of the time of a step without, as in walks measured


def plan(scene, comm):
    """Lines for a person, the same on all ranks; all ranks call.

    Raises
    ------
    as `activity.Activity` does for what is wrong with the scene
    """
    activity = Activity(scene, comm)
    wearer, surface, stepper = activity.wearer, activity.surface, activity.stepper
    recording, fabric = wearer.recording, activity.shell.fabric
    facts, height = recording.facts, build.stance(wearer)[0]
    seconds = wearer.end - wearer.start
    dressing = Dressing().seconds
    steps = int((seconds + dressing) / stepper.dt)
    cost = _seconds_a_step(activity) * CONTACT
    memory = comm.allreduce(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss) / 1024
    held = fabric.bending_length()
    size = surface.mean_cell_size
    lines = [
        f"{scene.title}",
        f"motion     {recording.source}: {wearer.start:.3f} to {wearer.end:.3f} s, "
        f"{recording.rate:.4g} frames a second, hips {height:.3f} m high",
    ]
    if facts.get("stride_length"):
        lines.append(
            f"           stride {facts['stride_length']:.3f} m, cadence {facts['cadence']:.1f} "
            "steps/min"
        )
    lines += [f"           {note}" for note in recording.notes]
    lines += [
        f"body       {len(wearer.names)} ellipsoids: {', '.join(wearer.names)}",
        f"           joints: {', '.join(wearer.joints)}",
        f"garment    {surface.source}: {len(surface.cells)} cells of {1e3 * size:.0f} mm, "
        f"{len(surface.points)} nodes, {5 * len(surface.points)} dofs, "
        f"{activity.weight:.3f} N",
        *(f"           {line}" for line in fabric.summary().splitlines()),
    ]
    if size > held:
        lines.append(
            f"           cells of {1e3 * size:.0f} mm are larger than the bending length "
            f"{1e3 * held:.0f} mm: folds of that size are not resolved"
        )
    described = activity.shell.plan()
    lines += [
        f"modelled   {described['element']}: {', '.join(described['terms'])}",
        f"           contact with friction {activity.touch.correction.friction}, "
        + (f"belt of {scene.belt:g} N" if scene.belt else "no belt")
        + ", no contact of cloth with cloth",
        f"steps      {stepper.dt:.3g} s ({scene.steps.time_step_factor:g} of the largest stable "
        f"one), about {steps} with up to {dressing:.1f} s of dressing",
        f"cost       about {steps * cost / 60:.1f} minutes on {comm.size} "
        f"{'rank' if comm.size == 1 else 'ranks'}, {memory:.0f} MB",
    ]
    return lines


def _seconds_a_step(activity):
    """Wall time [s] of a step, the slowest rank's."""
    stepper = activity.stepper
    stepper.time = activity.wearer.start - 10.0
    stepper.owned[:, 2] -= 5.0  # away from the body
    stepper.scatter()
    stepper.advance(stepper.time + 10 * stepper.dt)
    start = time.perf_counter()
    stepper.advance(stepper.time + TIMED * stepper.dt)
    return float(np.max(activity.comm.allgather(time.perf_counter() - start))) / TIMED
