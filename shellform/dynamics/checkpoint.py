# SPDX-License-Identifier: LGPL-3.0-or-later
"""Stopping and going on: the state of explicit steps in one file, for any number of ranks.

Nodal arrays are kept in the surface's own numbering. On the same ranks a run goes on bit for bit;
on others sums run in another order, so it agrees to roundoff while the motion stays smooth.
"""

import os
from pathlib import Path
from typing import Any

import numpy as np

from shellform import __version__

from .explicit import Newmark


def save(path: str | Path, stepper: Newmark, more: dict[str, Any] | None = None) -> None:
    """Write a checkpoint atomically, with what the stepper's parts save; all ranks call.

    Parameters
    ----------
    path : .npz file; stepper : Newmark
    more : dict of further arrays, texts and numbers by names of their own, those of rank 0
    """
    comm, gather = stepper.shell.comm, stepper.shell.partition.gather
    state = {
        "w": gather(stepper.owned, root=0),
        "v": gather(stepper.v, root=0),
        "q": gather(stepper.q, root=0),
        "clock": stepper.clock.numbers(),
        "cut": np.array(stepper.rewind.cut),
        "work": comm.allreduce(stepper.books.works),
        "totals": comm.allreduce(stepper.books.impulses),
        "version": np.array(__version__),
    } | (more or {})
    friction = stepper.force_model.friction
    if friction is not None:
        state["slips"] = stepper.shell.partition.gather_cells(friction.slips)
        state["hysteresis"] = np.array(comm.allreduce(friction.lost))
    for part in stepper.parts:
        state |= part.saved()
    if comm.rank == 0:
        path = Path(path)
        unfinished = path.with_name(path.name + ".part")
        with open(unfinished, "wb") as file:
            np.savez(file, **state)
        os.replace(unfinished, path)


def load(path: str | Path, stepper: Newmark) -> dict[str, np.ndarray]:
    """Continue from a checkpoint of the same scene, its contact too; all ranks call.

    Returns
    -------
    dict of all arrays in the file, for parts that go on (`resumed`)

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
    stepper.set_clock(state["clock"])
    stepper.rewind.cut = float(state["cut"])
    # sums over ranks live on the first one
    stepper.books.works[:] = state["work"] if first else 0.0
    stepper.books.impulses[:] = state["totals"] if first else 0.0
    friction = stepper.force_model.friction
    if friction is not None:
        if "slips" not in state or state["slips"].shape[1:] != friction.slips.shape[1:]:
            raise ValueError(f"{path} holds no state of this cloth's friction")
        friction.set_slips(state["slips"][partition.cells[: len(friction.slips)]])
        friction.lost = float(state["hysteresis"]) if first else 0.0
    if stepper.contact is not None:
        if "segment" not in state:
            raise ValueError(f"{path} holds no state of contact")
        stepper.contact.resume(path, state)
    if stepper.self_contact is not None:
        stepper.self_contact.resume(path, state)
    return state
