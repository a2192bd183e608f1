# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a scene would model and cost, for a person, before it is run."""

import resource
import time

import numpy as np

from shellform.motion.stance import stance

from .plan import plan_of, told

TIMED = 200  # steps
CONTACT = 1.35  # of the time of a step without, as in walks measured


def plan(scene, comm):
    """Lines for a person: the plan of a scene and its cost; the same on all ranks, all ranks call.

    Body, garment and stable step are those of the run; seconds are extrapolated from some steps
    timed here and now, the garment still off the body, so they are a guess: contact adds a third.

    Raises
    ------
    as `activity.Activity` does for what is wrong with the scene
    """
    from shellform.dressing.dress import Dressing

    from .model import Activity

    activity = Activity(scene, comm)
    wearer = activity.whole
    surface, stepper = activity.surface, activity.stepper
    recording, fabric = wearer.recording, activity.shell.fabric
    facts, height = recording.facts, stance(wearer)[0]
    dressing = Dressing().seconds
    steps = int((wearer.end - wearer.start + dressing) / stepper.dt)
    cost = _seconds_a_step(activity) * CONTACT
    memory = comm.allreduce(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss) / 1024
    held, size = fabric.bending_length(), surface.mean_cell_size
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
    lines += [f"           {note}" for note in [*recording.notes, *activity.touch.notes]]
    lines += [
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
    return [
        *lines,
        *told(plan_of(scene, wearer, surface, activity.wearer.names)),
        f"steps      {stepper.dt:.3g} s ({scene.steps.time_step_factor:g} of the largest stable "
        f"one), about {steps} with up to {dressing:.1f} s of dressing",
        f"cost       about {steps * cost / 60:.1f} minutes on {comm.size} "
        f"{'rank' if comm.size == 1 else 'ranks'}, {memory:.0f} MB",
    ]


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
