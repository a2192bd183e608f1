# SPDX-License-Identifier: LGPL-3.0-or-later
"""A short walk, and its files as arrays."""

import csv
from pathlib import Path

import numpy as np

from shellform.results.joint_torque import rows_until
from shellform.scene.parts import Motion, Output, Steps
from shellform.scene.scene import Scene

JOINTS = [f"{side}_{joint}" for side in ("right", "left") for joint in ("hip", "knee", "ankle")]


# without drag of the air, which the ledger books but does not tell by window
WALK = Scene(
    motion=Motion(start=1.5, end=1.7, initiation=0.4),
    steps=Steps(drag=0.0, runs=1),
    output=Output(checkpoint=0.1),
)


def table(path):
    with open(path) as file:
        return [{k: float(v) for k, v in row.items()} for row in csv.DictReader(file)]


def vectors(rows, kind="torque", axes="xyz"):
    return np.array([[row[f"{kind}_{axis}"] for axis in axes] for row in rows])


def torques(out):
    """Windows, joints, (x, y, z, about the axis of flexion) [N m]."""
    rows = rows_until(Path(out) / "torque.csv", np.inf)
    assert [row["joint"] for row in rows] == JOINTS * (len(rows) // 6)
    return vectors(rows, axes=("x", "y", "z", "flexion")).reshape(-1, 6, 4)


def contact_forces(rows, names):
    """(k, 3), of the body on the cloth [N]."""
    return sum(vectors(rows, f"force_{name}") for name in names)
