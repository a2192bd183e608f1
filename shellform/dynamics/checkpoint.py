# SPDX-License-Identifier: LGPL-3.0-or-later
"""Stopping and going on: the state of explicit steps in one file, for any number of ranks.

Nodal arrays are kept in the surface's own numbering. On the same ranks a run goes on bit for bit;
on others sums run in another order, so it agrees to roundoff while the motion stays smooth.
"""

import os
from pathlib import Path

import numpy as np

from shellform import __version__

from .state import clock, set_clock


def save(path, stepper, touch=None, more=None):
    """Write a checkpoint atomically; all ranks call.

    Parameters
    ----------
    path : .npz file; stepper : Newmark; touch : Touch or None
    more : dict of further arrays, texts and numbers by names of their own, those of rank 0
    """
    comm, gather = stepper.shell.comm, stepper.shell.partition.gather
    state = {
        "w": gather(stepper.owned, root=0),
        "v": gather(stepper.v, root=0),
        "q": gather(stepper.q, root=0),
        "clock": clock(stepper),
        "cut": np.array(stepper.rewind.cut),
        "work": comm.allreduce(stepper.works),
        "totals": comm.allreduce(stepper.totals),
        "version": np.array(__version__),
    } | (more or {})
    if touch is not None:
        window = touch.correction.window
        state |= _contact(stepper, touch)
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

    Returns
    -------
    dict of all arrays in the file

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
    set_clock(stepper, state["clock"])
    stepper.rewind.cut = float(state["cut"])
    # sums over ranks live on the first one
    stepper.works[:] = state["work"] if first else 0.0
    stepper.totals[:] = state["totals"] if first else 0.0
    if touch is None:
        return state
    if "segment" not in state:
        raise ValueError(f"{path} holds no state of contact")
    window = touch.correction.window
    _take_contact(path, stepper, touch, state)
    window.impulse[:] = state["window_impulse"][nodes]
    window.table[:] = state["window_table"] if first else 0.0
    window.seconds = float(state["window_seconds"])
    return state


def _contact(stepper, touch):
    """Segments touched and soft ones lain in, by nodes and by cells that have samples.

    In the surface's numbering: (n, 2) and (cells, samples a cell, 2) int.
    """
    partition = stepper.shell.partition
    # whole numbers travel as the floats of the same bits: sets of segments may need all 64
    nodes = partition.gather(_of(touch.correction).view(float), root=0)
    whole = {"segment": None if nodes is None else nodes.view(np.int64)}
    if touch.inner is not None:
        cells = partition.nodes[touch._cells]
        parts = stepper.shell.comm.gather((cells, _by_cell(touch)), 0)
        if parts is not None:
            whole["sample_cells"] = np.concatenate([part[0] for part in parts])
            whole["sample_segment"] = np.concatenate([part[1] for part in parts])
    return whole


def _take_contact(path, stepper, touch, state):
    """Set this rank's part of `_contact`."""
    partition = stepper.shell.partition
    _set(touch.correction, state["segment"][partition.owned_nodes])
    if touch.inner is None:
        return
    kept, own = state.get("sample_segment"), _by_cell(touch)
    if kept is None or kept.shape[1] != own.shape[1]:
        raise ValueError(
            f"{path} holds no contact of {own.shape[1]} samples a cell: "
            "go on with the samples it was written with"
        )
    rows = {tuple(sorted(cell)): row for row, cell in enumerate(state["sample_cells"].tolist())}
    cells = partition.nodes[touch._cells].tolist()
    _set(touch.inner, kept[[rows[tuple(sorted(cell))] for cell in cells]].reshape(-1, 2))


def _of(correction):
    """Segments touched and soft ones lain in (n, 2)."""
    return np.stack([correction.segment, correction.penetrated], axis=1)


def _set(correction, both):
    correction.segment[:], correction.penetrated[:] = both.T


def _by_cell(touch):
    """`_of` the samples, (cells, samples a cell, 2)."""
    return _of(touch.inner).reshape(len(touch._cells), -1, 2)
