# SPDX-License-Identifier: LGPL-3.0-or-later
"""The walk in the trade between error and cost: level walking in compliant trousers.

Folds choose among many states, so that two runs from slightly different starts differ: the wearer
is dressed once a mesh, and other starts are runs from that dressed state, let settle once more.
"""

import csv
import time
from pathlib import Path

from mpi4py import MPI

import numpy as np
from trade_cases import MESH, Case

from shellform import account, accuracy, activity
from shellform.build import fabric
from shellform.scene import Garment, Motion, Output, Scene, Steps
from shellform.torque import rows_until

COMM = MPI.COMM_WORLD
SECONDS, KNEES = 2.0, ("right_knee", "left_knee")
FIRST = 0.035  # m, cells of the runs that change something else


def walk_case(folder, sizes=(0.04, FIRST, 0.0245, 0.0175), seconds=SECONDS):
    """Case of the walk; runs leave their files in `folder`."""
    folder = Path(folder) / "walk"
    length = accuracy.garment_length(fabric(Scene(fabric="compliant")))

    def run(settings):
        size, kind = settings["cell_size"], settings["kind"]
        scene = Scene(
            fabric="compliant",
            motion=Motion(end=seconds, obstacle=0.0),
            garment=Garment(cell_size=size),
            steps=Steps(
                time_step_factor=settings.get("factor", 0.9),
                dressing=settings.get("dressing", "shell"),
            ),
            output=Output(frames=2.0, pressure=0.0),
        )
        dressed = None
        if kind in ("start", "step"):
            dressed = folder / f"mesh_{1e3 * size:g}_mm" / "dressed.npz"
        out = folder / f"{settings.get('name', kind).replace(' ', '_')}_{1e3 * size:g}_mm"
        start = time.process_time()
        activity.run(scene, out, COMM, dressed)
        spent = COMM.allreduce(time.process_time() - start)
        COMM.Barrier()  # rank 0's files are there
        summary = account.summary_of(out)
        return {
            "ratio": size / length,
            "values": figures(out),
            "nodes": summary["nodes"],
            "steps": summary["steps"],
            "time_step": summary["time_step"],
            "core_seconds": spent,
        }

    first = MESH | {"cell_size": FIRST}
    # the time of what changes one thing is compared with that of the run before
    ladder = [MESH | {"cell_size": size} for size in sizes]
    at = sizes.index(FIRST) + 1
    ladder[at:at] = [
        first | {"kind": "start"},
        first | {"kind": "step", "factor": 0.45},
        first | {"kind": "trick", "name": "dressed by particles", "dressing": "particles"},
    ]
    return Case("walk", ladder, run, length)


def figures(out):
    """Torques about the knees in time, their root mean square, mean strain energy and force."""
    rows = rows_until(out / "torque.csv", np.inf)
    curves = [[row["torque_flexion"] for row in rows if row["joint"] == knee] for knee in KNEES]
    with open(out / "ledger.csv") as file:
        ledger = list(csv.DictReader(file))
    up = [key for key in ledger[0] if key.startswith("force_") and key.endswith("_z")]
    force = [sum(float(row[key]) for key in up) for row in ledger]
    return {
        "torque": np.ravel(curves),
        "torque rms": float(np.sqrt(np.mean(np.square(curves)))),
        "energy": float(np.mean([float(row["strain"]) for row in ledger])),
        "force": float(np.mean(force)),
    }
