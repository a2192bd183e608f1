# SPDX-License-Identifier: LGPL-3.0-or-later
"""The dressed wearer as a file, to be used again for other motions of the same wearer.

Positions and directors are kept as the standing wearer sees them: from the middle of the hips, with
axes forward, left and up. Put on from there, the cloth settles once more on the body it then meets.
What friction inside the cloth bears is kept too, as it holds folds where they are. Cloth with
another number of sliders begins with unloaded ones: nothing is known of how it came to lie so.
"""

import os
from pathlib import Path

import numpy as np

from shellform.contact_coupling.contact import require_contact
from shellform.dynamics.explicit import Newmark
from shellform.motion.stance import stance
from shellform.motion.wearer import Wearer

from .belt import Belt
from .procedure import Dressing
from .settings import borrowed
from .settle import settle_again


def save(path: str | Path, stepper: Newmark, wearer: Wearer) -> None:
    """Write the present state atomically; all ranks call."""
    shell = stepper.shell
    positions, directors = shell.positions(), shell.directors()
    friction, borne = stepper.force_model.friction, {}
    if friction is not None:
        borne["borne"] = shell.partition.gather_cells(friction.borne(stepper.w))
    if shell.comm.rank:
        return
    middle, axes = _axes(wearer)
    path = Path(path)
    part = path.with_name(path.name + ".part")
    with open(part, "wb") as file:
        np.savez(
            file,
            positions=(positions - middle) @ axes.T,
            directors=directors @ axes.T,
            rest=shell.surface.points - shell.surface.points.mean(axis=0),
            radii=wearer.radii,
            **borne,
        )
    os.replace(part, path)


def put_on(
    path: str | Path,
    stepper: Newmark,
    tension: float | None,
    dressing: Dressing | None = None,
) -> tuple[Belt | None, dict]:
    """Put on the garment of a file and let it settle on the wearer in contact.

    Returns
    -------
    belt : Belt of `tension` [N], which stays, None without one; report : of `settle`

    Raises
    ------
    ValueError if the file is of another garment; FileNotFoundError
    """
    dressing = Dressing() if dressing is None else dressing
    surface, own = stepper.shell.surface, stepper.shell.partition.owned_nodes
    with np.load(path) as file:
        state = dict(file)
    n = len(surface.points)
    if "positions" not in state or len(state["positions"]) != n:
        raise ValueError(
            f"{path} is of a garment with {len(state.get('positions', ()))} nodes; "
            f"{surface.source} has {n}: dress anew, without it"
        )
    middle, axes = _axes(require_contact(stepper, "dressing").body)
    with borrowed(stepper):
        stepper.owned[:, :3] = middle + state["positions"][own] @ axes - stepper.points
        stepper.owned[:, 3:] = state["directors"][own] @ axes
        stepper.v[:], stepper.q[:] = 0.0, 0.0
        stepper.scatter()
        _bear(stepper, state.get("borne"))
        return settle_again(stepper, tension, dressing)


def _bear(stepper, borne):
    """Let sliders inside the cloth bear stresses (m, s) of all cells; None: none."""
    if stepper.shell.fabric.friction is None:
        return
    cells, partition = stepper.shell.cell_stress, stepper.shell.partition
    if borne is not None and borne.shape[1] != cells.slips.shape[1]:
        borne = None
    cells.bear(stepper.w, None if borne is None else borne[partition.cells[: cells.count]])


def _axes(wearer: Wearer) -> tuple[np.ndarray, np.ndarray]:
    """Middle of the hips (3,) and axes (3, 3) of the standing wearer, rows forward, left, up."""
    _, middle, heading = stance(wearer)
    up = np.array([0.0, 0.0, 1.0])
    return middle, np.array([heading, np.cross(up, heading), up])
