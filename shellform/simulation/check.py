# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a scene would model and cost, for a person, before it is run."""

import resource
import time
from pathlib import Path

from mpi4py import MPI

import numpy as np

from shellform.dressing.procedure import Dressing
from shellform.fem.wrinkles import folds_resolved
from shellform.scene.scene import Scene
from shellform.scene.scene_file import as_scene

from .model import Model
from .motion_lines import motion_lines
from .plan import plan_lines, plan_of

TIMED = 200  # steps
CONTACT = 1.35  # of the time of a step without, as in walks measured


def check(scene: Scene | str | Path, comm: MPI.Comm = MPI.COMM_WORLD) -> list[str]:
    """Lines for a person: what a scene, or that of a file, models and costs; all ranks call.

    Body, garment and stable step are those of the run; seconds are extrapolated from some steps
    timed here and now, the garment still off the body, so they are a guess: contact adds a third.

    Raises
    ------
    as `Model` does for what is wrong with the scene; ValueError for cells no springs stand for,
    where the garment is dressed by particles

    Examples
    --------
    >>> import shellform as sf
    >>> scene = sf.Scene(title="trousers of 20 N")
    >>> print(sf.check(scene)[0])
    trousers of 20 N
    """
    scene = as_scene(scene)
    model = Model(scene, comm)
    if scene.steps.dressing == "particles":
        # only here: springs have kernels of their own
        from shellform.dynamics.springs import Springs

        surface = model.surface
        Springs(surface, surface.cells, surface.points, model.shell.fabric, flat=surface.flat)
    return [
        scene.title,
        *motion_lines(model),
        *_garment_lines(model),
        *plan_lines(plan_of(scene, model.whole, model.surface, model.wearer.names)),
        *_cost_lines(model),
    ]


def _garment_lines(model: Model) -> list[str]:
    """Cells and fabric of the garment, and whether these resolve its folds."""
    surface, fabric = model.surface, model.shell.fabric
    held, size = fabric.bending_length(), surface.mean_cell_size
    lines = [
        f"garment    {surface.source}: {len(surface.cells)} cells of {1e3 * size:.0f} mm, "
        f"{len(surface.points)} nodes, {5 * len(surface.points)} dofs, "
        f"{model.weight:.3f} N",
        *(f"           {note}" for note in surface.notes),
        *(f"           {line}" for line in fabric.summary().splitlines()),
    ]
    if model.shell.relaxed:
        lines.append(
            f"           wrinkles are smaller than cells of {1e3 * size:.0f} mm (bending length "
            f"{1e3 * held:.0f} mm): the membrane is relaxed"
        )
    elif not folds_resolved(surface, fabric):
        lines.append(
            f"           cells of {1e3 * size:.0f} mm do not resolve folds (bending length "
            f'{1e3 * held:.0f} mm): wrinkles = "relaxed" gives way as the cloth does'
        )
    return lines


def _cost_lines(model: Model) -> list[str]:
    """Steps, minutes and memory of a run on these ranks."""
    wearer, comm, dt = model.whole, model.comm, model.stepper.dt
    dressing = Dressing().seconds
    steps = int((wearer.end - wearer.start + dressing) / dt)
    cost = _seconds_a_step(model) * CONTACT
    memory = comm.allreduce(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss) / 1024
    return [
        f"steps      {dt:.3g} s ({model.scene.steps.time_step_factor:g} of the largest stable "
        f"one), about {steps} with up to {dressing:.1f} s of dressing",
        f"cost       about {steps * cost / 60:.1f} minutes on {comm.size} "
        f"{'rank' if comm.size == 1 else 'ranks'}, {memory:.0f} MB",
    ]


def _seconds_a_step(model: Model) -> float:
    """Wall time [s] of a step, the slowest rank's."""
    stepper = model.stepper
    stepper.time = model.wearer.start - 10.0
    stepper.owned[:, 2] -= 5.0  # away from the body
    stepper.scatter()
    stepper.advance(stepper.time + 10 * stepper.dt)
    start = time.perf_counter()
    stepper.advance(stepper.time + TIMED * stepper.dt)
    return float(np.max(model.comm.allgather(time.perf_counter() - start))) / TIMED
