# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a contact of explicit steps needs to go on, in the surface's own numbering.

Segments touched, soft ones lain in, and what is out of reach, by nodes and by cells that have
samples; the window of the books.
"""

from pathlib import Path
from typing import Any

import numpy as np

from contact.solver.velocity_correction import LOOKS

SIDES = 5  # numbers a node on flesh, see contact/solver/flesh_step.py


def saved(contact: Any) -> dict[str, Any]:
    """Arrays of a contact for a checkpoint, those of rank 0 complete; all ranks call.

    By nodes (n, 2) and by cells (cells, samples a cell, 2) int: segment touched, set of soft ones.
    Looks (n, LOOKS) and (cells, samples a cell, LOOKS) float, see `VelocityCorrection.looks`.
    """
    shell, window = contact.stepper.shell, contact.window
    partition, comm = shell.partition, shell.comm
    # whole numbers travel as the floats of the same bits: sets of segments may need all 64
    nodes = partition.gather(_of(contact.correction).view(float), root=0)
    whole = {"segment": None if nodes is None else nodes.view(np.int64)}
    looks, whole["look_body"] = contact.correction.looks()
    whole["look"] = partition.gather(looks, root=0)
    if contact.watches_beds:
        whole["bed_stiffness"] = partition.gather(contact.bed_stiffness[:, None], root=0)
    if contact.flesh is not None:
        sides = contact.correction.sides.view(float).reshape(-1, SIDES)
        whole["flesh"] = partition.gather(sides, root=0)
    if contact.pressed is not None:
        whole["pressed_beds"] = partition.gather(contact.pressed.beds[:, None], root=0)
    if contact.inner is not None:
        cells = partition.nodes[contact.cells]
        looks, whole["sample_look_body"] = contact.inner.looks()
        looks = looks.reshape(len(cells), -1, LOOKS)
        parts = comm.gather((cells, _by_cell(contact), looks), 0)
        if parts is not None:
            names = "sample_cells", "sample_segment", "sample_look"
            whole |= {k: np.concatenate(part) for k, part in zip(names, zip(*parts), strict=True)}
    whole["window_impulse"] = partition.gather(window.impulse, root=0)
    whole["window_table"] = comm.allreduce(window.table)
    whole["window_seconds"] = np.array(window.seconds)
    return whole


def resume(contact: Any, path: str | Path, state: dict[str, np.ndarray]) -> None:
    """Set this rank's part of what `saved` gave, read from the file `path`."""
    shell, window = contact.stepper.shell, contact.window
    partition, nodes = shell.partition, shell.partition.owned_nodes
    width = contact.correction.looks()[0].shape[1]
    if state["look"].shape[1] != width:
        raise ValueError(
            f"{path} holds {state['look'].shape[1]} numbers a node of contact, not {width}: it is "
            "of another version or of a body of another kind, start anew"
        )
    _set(contact.correction, state["segment"][nodes])
    contact.correction.take_looks(state["look"][nodes], state["look_body"])
    if "bed_stiffness" in state:
        contact.bed_stiffness[:] = state["bed_stiffness"][nodes, 0]
    if contact.flesh is not None:
        if "flesh" not in state:
            raise ValueError(f"{path} is of a contact without flesh: leave `flesh` out to go on")
        sides = contact.correction.sides.view(float).reshape(-1, SIDES)
        sides[:] = state["flesh"][nodes]
    if contact.pressed is not None:
        contact.pressed.restore(contact.stepper, state["pressed_beds"][nodes, 0])
    if contact.inner is not None:
        kept, own = state.get("sample_segment"), _by_cell(contact)
        if kept is None or kept.shape[1] != own.shape[1]:
            raise ValueError(
                f"{path} holds no contact of {own.shape[1]} samples a cell: "
                "go on with the samples it was written with"
            )
        rows = {tuple(sorted(cell)): row for row, cell in enumerate(state["sample_cells"].tolist())}
        cells = partition.nodes[contact.cells].tolist()
        order = [rows[tuple(sorted(cell))] for cell in cells]
        _set(contact.inner, kept[order].reshape(-1, 2))
        looks = state["sample_look"][order].reshape(-1, LOOKS)
        contact.inner.take_looks(looks, state["sample_look_body"])
    window.impulse[:] = state["window_impulse"][nodes]
    # sums over ranks live on the first one
    window.table[:] = state["window_table"] if shell.comm.rank == 0 else 0.0
    window.seconds = float(state["window_seconds"])


def _of(correction):
    """Segments touched and soft ones lain in (n, 2)."""
    return np.stack([correction.segment, correction.penetrated], axis=1)


def _set(correction, both):
    correction.segment[:], correction.penetrated[:] = both.T


def _by_cell(contact):
    """`_of` the samples, (cells, samples a cell, 2)."""
    return _of(contact.inner).reshape(len(contact.cells), -1, 2)
