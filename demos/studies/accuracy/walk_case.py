# SPDX-License-Identifier: LGPL-3.0-or-later
"""The walk of the study of error against cost: level walking in compliant trousers.

Folds choose among many states, so two runs that differ by next to nothing end up with folds of
their own. Other starts are runs, dressed anew, with a belt of a tension 0.1 % away: what these
differ by is the spread, below which no torque of a walk can be predicted.
"""

import csv
import time
from dataclasses import replace
from pathlib import Path

from mpi4py import MPI

import numpy as np

from demos.studies.accuracy.cases import MESH, Case
from shellform.accuracy.choice import garment_length
from shellform.material.card import fabric_of
from shellform.results.joint_torque import rows_until
from shellform.scene.parts import Garment, Motion, Output, Steps
from shellform.scene.scene import Scene
from shellform.simulation.error_study import curves
from shellform.simulation.run import run
from shellform.simulation.summary import summary_of

COMM = MPI.COMM_WORLD
SECONDS, KNEES = 2.0, ("right_knee", "left_knee")
FIRST = 0.035  # m, cells of the runs that change something else


def walk_case(folder, sizes=(0.04, FIRST, 0.0245, 0.02, 0.0175), seconds=SECONDS):
    """Case of the walk; runs leave their files in `folder`."""
    folder = Path(folder) / "walk"
    length = garment_length(fabric_of("compliant"))

    def run_with(settings):
        size = settings["cell_size"]
        scene = scene_of(settings, seconds)
        name = settings.get("name", settings["kind"]).replace(" ", "_")
        out = folder / f"{name}_{settings.get('start', 0)}_{1e3 * size:g}_mm"
        start = time.process_time()
        run(scene, out, COMM)
        spent = COMM.allreduce(time.process_time() - start)
        COMM.Barrier()  # rank 0's files are there
        summary = summary_of(out)
        return {
            "ratio": size / length,
            "values": figures(out),
            "nodes": summary["nodes"],
            "steps": summary["steps"],
            "time_step": summary["time_step"],
            "core_seconds": spent,
        }

    first = MESH | {"cell_size": FIRST}
    ladder = [MESH | {"cell_size": size} for size in sizes]
    at = sizes.index(FIRST) + 1
    ladder[at:at] = [
        first | {"kind": "start", "start": 1},
        first | {"kind": "start", "start": -1},
        first | {"kind": "step", "factor": 0.45},
        first | {"kind": "trick", "name": "dressed by particles", "dressing": "particles"},
        first | {"kind": "trick", "name": "mass 4", "mass": 4.0},
    ]
    return Case("walk", ladder, run_with, length)


def scene_of(settings, seconds):
    """Scene of the settings of a run."""
    mass, cloth = settings.get("mass", 1.0), fabric_of("compliant")
    return Scene(
        fabric=replace(cloth, areal_mass=mass * cloth.areal_mass),
        gravity=9.81 / mass,
        motion=Motion(end=seconds, obstacle=0.0),
        garment=Garment(cell_size=settings["cell_size"]),
        steps=Steps(
            time_step_factor=settings.get("factor", 0.9),
            dressing=settings.get("dressing", "shell"),
        ),
        output=Output(frames=2.0, pressure=0.0),
        belt=20.0 * (1 + 1e-3 * settings.get("start", 0)),
    )


def figures(out):
    """Torques about all joints in time, about the knees, their root mean square; energy, force."""
    torque, rows = curves(out), rows_until(out / "torque.csv", np.inf)
    joints = list(dict.fromkeys(row["joint"] for row in rows))
    knees = torque[[joints.index(knee) for knee in KNEES]]
    with open(out / "ledger.csv") as file:
        ledger = list(csv.DictReader(file))
    up = [key for key in ledger[0] if key.startswith("force_") and key.endswith("_z")]
    force = [sum(float(row[key]) for key in up) for row in ledger]
    return {
        "torque": np.ravel(torque),
        "torque rms": float(np.sqrt(np.mean(np.square(torque)))),
        "knee torque": np.ravel(knees),
        "knee torque rms": float(np.sqrt(np.mean(np.square(knees)))),
        "energy": float(np.mean([float(row["strain"]) for row in ledger])),
        "force": float(np.mean(force)),
    }
