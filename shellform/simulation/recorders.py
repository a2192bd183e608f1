# SPDX-License-Identifier: LGPL-3.0-or-later
"""What is written and watched while a scene is stepped: frames, extremes of contact."""

import numpy as np

from shellform.dressing.dress import STAGES
from shellform.dynamics.part import Part
from shellform.results.series import Series


def write_frame(activity, series, force):
    """Write a frame with the contact force [N] on the cloth and its pressure [Pa]."""
    stepper, shell = activity.stepper, activity.shell
    gather = shell.partition.gather
    size = np.linalg.norm(force, axis=-1) * np.ones(stepper.n_owned)
    area = stepper.mass / shell.fabric.areal_mass
    data = np.column_stack([np.broadcast_to(force, (stepper.n_owned, 3)), size / area])
    whole = gather(data, root=0)
    fields = {}
    if whole is not None:
        fields = {"contact_force": whole[:, :3], "contact_pressure": whole[:, 3]}
    series.write(shell, stepper.time, **fields)


def dressing_watcher(activity, out, watch):
    """Watcher of the dressing that writes a frame of each of its STAGES."""
    series, seen = Series(out, "dressing"), set()

    def look(stage, stepper):
        if watch:
            watch(stage, activity)
        halfway = stage != "pull" or abs(stepper.owned[:, 2]).max(initial=0.0) < 0.5
        if stage in STAGES and stage not in seen and activity.comm.allreduce(int(not halfway)) == 0:
            seen.add(stage)
            series.write(activity.shell, stepper.time)

    return look


class Extremes(Part):
    """Deepest start of a step inside the body, most pinched nodes, how deep they were.

    Parameters
    ----------
    resumed : state of a checkpoint or None
    """

    books_contact = True

    def __init__(self, resumed=None):
        self.values = np.zeros(3) if resumed is None else resumed["extremes"].copy()

    def __call__(self, stepper, dt):
        now = stepper.contact
        self.values[0] = max(self.values[0], now.max_depth)
        self.values[1] = max(self.values[1], now.pinched)
        self.values[2] = max(self.values[2], now.pinch_depth)

    def state(self):
        """Values on this rank, for `restore` (a copy)."""
        return self.values.copy()

    def restore(self, state):
        """Continue from `state()`."""
        self.values[:] = state

    def saved(self):
        """Largest values over all ranks, for `resumed`."""
        return {"extremes": np.max(self.stepper.shell.comm.allgather(self.values), axis=0)}
