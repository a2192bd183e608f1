# SPDX-License-Identifier: LGPL-3.0-or-later
"""Stopping and going on: the state of explicit steps in one file, for any number of ranks.

Nodal arrays are kept in the surface's own numbering. On the same ranks a run goes on bit for bit;
on others sums run in another order, so it agrees to roundoff while the motion stays smooth.
"""

import os
from pathlib import Path

import numpy as np

from . import __version__


def save(path, stepper, touch=None):
    """Write a checkpoint atomically; all ranks call.

    Parameters
    ----------
    path : .npz file; stepper : Newmark; touch : Touch or None
    """
    comm, gather = stepper.shell.comm, stepper.shell.partition.gather
    state = {
        "w": gather(stepper.owned, root=0),
        "v": gather(stepper.v, root=0),
        "q": gather(stepper.q, root=0),
        "clock": np.array([stepper.time, stepper.dt, stepper.last_dt, stepper.critical_dt]),
        "steps": np.array(stepper.steps),
        "work": comm.allreduce(np.array(list(stepper.work.values()))),
        "totals": comm.allreduce(
            np.array([stepper.external_total, stepper.support_total, stepper.drag_total])
        ),
        "version": np.array(__version__),
    }
    if touch is not None:
        correction, window = touch.correction, touch.correction.window
        state["segment"] = gather(correction.segment[:, None].astype(float), root=0)
        state["window_impulse"] = gather(window.impulse, root=0)
        state["window_table"] = comm.allreduce(window.table)
        state["window_seconds"] = np.array(window.seconds)
    if comm.rank == 0:
        path = Path(path)
        part = path.with_name(path.name + ".part")
        with open(part, "wb") as file:
            np.savez(file, **state)
        os.replace(part, path)


def load(path, stepper, touch=None):
    """Continue from a checkpoint of the same scene; all ranks call.

    Raises
    ------
    ValueError if the file belongs to another surface, or has no contact state where one is asked
    """
    partition, first = stepper.shell.partition, stepper.shell.comm.rank == 0
    with np.load(path) as file:
        state = dict(file)
    if len(state["w"]) != len(partition.surface.points):
        raise ValueError(
            f"{path} is of a surface with {len(state['w'])} nodes; {partition.surface.source} has "
            f"{len(partition.surface.points)}"
        )
    stepper.w[:] = state["w"][partition.nodes]
    nodes = partition.owned_nodes
    stepper.v[:], stepper.q[:] = state["v"][nodes], state["q"][nodes]
    stepper.time, stepper.dt, stepper.last_dt, stepper.critical_dt = state["clock"].tolist()
    stepper.steps = int(state["steps"])
    # sums over ranks live on the first one
    for key, value in zip(stepper.work, state["work"], strict=True):
        stepper.work[key] = float(value) if first else 0.0
    totals = state["totals"] if first else np.zeros((3, 3))
    stepper.external_total[:], stepper.support_total[:], stepper.drag_total[:] = totals
    if touch is None:
        return
    if "segment" not in state:
        raise ValueError(f"{path} holds no state of contact")
    correction, window = touch.correction, touch.correction.window
    correction.segment[:] = state["segment"][nodes, 0].astype(np.int64)
    window.impulse[:] = state["window_impulse"][nodes]
    window.table[:] = state["window_table"] if first else 0.0
    window.seconds = float(state["window_seconds"])
