# SPDX-License-Identifier: LGPL-3.0-or-later
"""The dressed wearer as a file, to be used again for other motions of the same wearer.

Positions and directors are kept as the standing wearer sees them: from the middle of the hips, with
axes forward, left and up. Worn again, the cloth settles once more on the body it then meets.
"""

import os
from pathlib import Path

import numpy as np

from shellform.motion.stance import stance

from .belt import Belt
from .dress import Dressing, settle


def _axes(wearer):
    """Middle of the hips (3,) and axes (3, 3) of the standing wearer, rows forward, left, up."""
    _, middle, heading = stance(wearer)
    up = np.array([0.0, 0.0, 1.0])
    return middle, np.array([heading, np.cross(up, heading), up])


def save(path, activity):
    """Write the present state atomically; all ranks call."""
    positions, directors = activity.shell.positions(), activity.shell.directors()
    if activity.comm.rank:
        return
    middle, axes = _axes(activity.wearer)
    path = Path(path)
    part = path.with_name(path.name + ".part")
    with open(part, "wb") as file:
        np.savez(
            file,
            positions=(positions - middle) @ axes.T,
            directors=directors @ axes.T,
            rest=activity.surface.points - activity.surface.points.mean(axis=0),
            radii=activity.wearer.radii,
        )
    os.replace(part, path)


def wear(activity, path, plan=None):
    """Put on the garment of a file and let it settle; returns the report of `dressing.settle`.

    Raises
    ------
    ValueError if the file is of another garment; FileNotFoundError
    """
    plan = Dressing() if plan is None else plan
    stepper, partition = activity.stepper, activity.shell.partition
    with np.load(path) as file:
        state = dict(file)
    n = len(activity.surface.points)
    if "positions" not in state or len(state["positions"]) != n:
        raise ValueError(
            f"{path} is of a garment with {len(state.get('positions', ()))} nodes; "
            f"{activity.surface.source} has {n}: dress anew, without it"
        )
    middle, axes = _axes(activity.wearer)
    own = partition.owned_nodes
    stepper.owned[:, :3] = middle + state["positions"][own] @ axes - stepper.points
    stepper.owned[:, 3:] = state["directors"][own] @ axes
    stepper.v[:], stepper.q[:] = 0.0, 0.0
    stepper.scatter()
    drag = stepper.drag
    stepper.time = activity.wearer.start - plan.settle
    activity.belt = stepper.add(Belt("waist", activity.scene.belt))
    # at least once, as the wearer may be another
    stepper.advance(stepper.time + 0.1)
    report = settle(stepper, activity.touch, activity.belt, plan, lambda *_: None)
    stepper.drag = drag
    return report
