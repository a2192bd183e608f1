# SPDX-License-Identifier: LGPL-3.0-or-later
"""What is recorded while a scene is stepped: torque, ledger, extremes, pressure, frames."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from shellform.contact_coupling.contact import require_contact
from shellform.dressing.procedure import SHOULDER_STAGES, STAGES
from shellform.dynamics.explicit import Newmark
from shellform.dynamics.part import Part
from shellform.motion.gait.strides import counted
from shellform.results.joint_torque import Torque
from shellform.results.ledger import Ledger
from shellform.results.series import Series

from .model import Model

if TYPE_CHECKING:
    from shellform.results.skin_pressure import Pressure
    from shellform.results.surface_pressure import SurfacePressure


class Recorders:
    """All that a walk records, behind its contact.

    Parameters
    ----------
    model : Model; out : folder of torque.csv and ledger.csv
    resumed : arrays of a checkpoint, of a run that is gone on with, or None

    Attributes
    ----------
    joints : Torque; ledger : Ledger; extremes : Extremes
    pressure : Pressure on ellipsoids, SurfacePressure on triangles, or None if not asked for
    crossings : Crossings, None where cloth does not meet cloth
    counted : begin and end [s] of what counts for torque and pressure, see `counted`; depths
    and the ledger are kept throughout
    """

    def __init__(self, model: Model, out: Path, resumed: dict[str, Any] | None = None):
        add, output = model.stepper.add, model.scene.output
        self._window, self.counted = model.contact.window, counted(model.wearer)
        self.joints: Torque = add(Torque(out / "torque.csv", output.parts, resumed))
        self.ledger: Ledger = add(Ledger(out / "ledger.csv", resumed))
        self.extremes: Extremes = add(Extremes(resumed))
        self.crossings: Crossings | None = None
        if model.contact.cloth is not None:
            self.crossings = add(Crossings(resumed))
        self.pressure = _pressure(model, resumed)
        if self.pressure is not None:
            add(self.pressure)

    def record(self, time: float) -> np.ndarray:
        """Rows of the window that ends at `time` [s]; begins a new one.

        Returns
        -------
        force : (n_owned, 3) [N], mean of contact on the nodes in the window
        """
        self.joints.record(time)
        begin, end = self.counted
        whole = time - self._window.seconds >= begin - 1e-6 and time <= end + 1e-6
        if self.pressure is not None:
            self.pressure.record(time, whole)
        if self.crossings is not None:
            self.crossings.count()
        force = self._window.impulse / self._window.seconds
        self.ledger.record()
        return force


def _pressure(model: Model, resumed: dict | None) -> Pressure | SurfacePressure | None:
    """What adds up the pressure on this wearer; None where it is not asked for."""
    # imports here: each compiles kernels of its own
    size = model.scene.output.pressure
    if not size:
        return None
    if model.skin is not None:
        from shellform.results.surface_pressure import SurfacePressure

        return SurfacePressure(resumed)
    from shellform.results.skin_pressure import Pressure

    return Pressure(size, resumed)


class Extremes(Part):
    """Deepest start of a step inside the body, most pinched nodes, how deep they were.

    Parameters
    ----------
    resumed : state of a checkpoint or None
    """

    books_contact = True

    def __init__(self, resumed: dict[str, Any] | None = None) -> None:
        self.values = np.zeros(3) if resumed is None else resumed["extremes"].copy()

    def attach(self, stepper: Newmark) -> Self:
        """Begin to watch a stepper's contact."""
        self.contact = require_contact(stepper, "a record of depths")
        return super().attach(stepper)

    def __call__(self, stepper: Newmark, dt: float) -> None:
        now = self.contact
        self.values[0] = max(self.values[0], now.max_depth)
        self.values[1] = max(self.values[1], now.pinched)
        self.values[2] = max(self.values[2], now.pinch_depth)

    def state(self) -> np.ndarray:
        """Values on this rank, for `restore` (a copy)."""
        return self.values.copy()

    def restore(self, state: np.ndarray) -> None:
        """Continue from `state()`."""
        self.values[:] = state

    def saved(self) -> dict:
        """Largest values over all ranks, for `resumed`."""
        return {"extremes": np.max(self.stepper.shell.comm.allgather(self.values), axis=0)}


class Crossings(Part):
    """Most edges of cloth that passed through its triangles at any record.

    Parameters
    ----------
    resumed : state of a checkpoint or None

    Attributes
    ----------
    most : int
    """

    def __init__(self, resumed: dict[str, Any] | None = None) -> None:
        self.most = 0 if resumed is None else int(resumed["crossings"])

    def count(self) -> None:
        """Look at the present positions; all ranks call."""
        self.most = max(self.most, self.stepper.self_contact.intersections())

    def saved(self) -> dict:
        """See Part."""
        return {"crossings": np.array(self.most)}


def write_frame(model: Model, series: Series, force: np.ndarray) -> None:
    """Write a frame with the contact force [N] on the cloth, its pressure [Pa] and stretch."""
    stepper, shell = model.stepper, model.shell
    gather = shell.partition.gather
    size = np.linalg.norm(force, axis=-1) * np.ones(stepper.n_owned)
    area = stepper.mass / shell.fabric.areal_mass
    data = np.column_stack([np.broadcast_to(force, (stepper.n_owned, 3)), size / area])
    whole = gather(data, root=0)
    fields = {}
    if whole is not None:
        fields = {"contact_force": whole[:, :3], "contact_pressure": whole[:, 3]}
    series.write(shell, stepper.time, stretch=True, **fields)


def dressing_watcher(model: Model, out: Path, watch: Callable | None) -> Callable:
    """Watcher of the dressing that writes a frame of each of its STAGES."""
    series, seen = Series(out, "dressing"), set()

    def look(stage: str, stepper: Newmark) -> None:
        if watch:
            watch(stage, model)
        halfway = stage != "pull" or abs(stepper.owned[:, 2]).max(initial=0.0) < 0.5
        known = stage in STAGES or stage in SHOULDER_STAGES
        if known and stage not in seen and model.comm.allreduce(int(not halfway)) == 0:
            seen.add(stage)
            series.write(model.shell, stepper.time)

    return look
