# SPDX-License-Identifier: LGPL-3.0-or-later
"""Force and torque of the clothing on each segment of the wearer, from ledger.csv.

A window of the ledger has, for each ellipsoid, the mean force on the cloth and its mean moment
about the ellipsoid's centre. The wearer receives the opposite. It is given at the middle of the
window, with the force at the centre of the segment there. Arms change within a window while forces
do: what that adds to the mean torque about a joint is in torque.csv, and is given to the segment
below the joint as a pure torque. So the torque about each joint, of all that acts below it, is that
of torque.csv.
"""

import csv
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from shellform.motion.recording import JOINTS
from shellform.motion.wearer import Joints, Wearer
from shellform.results.joint_torque import rows_until

AXES = "xyz"


class Loads(NamedTuple):
    """Loads of n windows on the segments of a wearer, in the axes of the scene.

    times : (n,) [s], middles of the windows; segments : m names
    forces : (n, m, 3) [N]; points : (n, m, 3) [m], where they act; torques : (n, m, 3) [N m]
    """

    times: np.ndarray
    segments: tuple[str, ...]
    forces: np.ndarray
    points: np.ndarray
    torques: np.ndarray


def segment_loads(wearer: Wearer, ledgers: Sequence[Path]) -> Loads:
    """Mean loads of the runs that wrote these ledgers, all of one wearer.

    Raises
    ------
    ValueError for a ledger without contact, or of other windows than the first
    """
    tables = [_read(path, wearer) for path in ledgers]
    ends, names = tables[0][:2]
    for path, (times, others, _) in zip(ledgers, tables, strict=True):
        if others != names or times.shape != ends.shape or np.abs(times - ends).max() > 1e-6:
            raise ValueError(f"{path} has other windows or segments than {ledgers[0]}")
    # minus: what the ledger has acts on the cloth
    values = -np.mean([table for *_, table in tables], axis=0)
    times = ends - 0.5 * np.diff(ends, prepend=wearer.start)
    which = [wearer.index(name) for name in names]
    carriers = [wearer.carriers[k] for k in which]
    segments = tuple(dict.fromkeys(carriers))
    shape = len(times), len(segments), 3
    forces, points, torques = np.zeros(shape), np.zeros(shape), np.zeros(shape)
    for i, time in enumerate(times.tolist()):
        points[i] = wearer.segment_pose(time, segments).centres
        centres = wearer.new_pose(time).centres[which]
        for k, carrier in enumerate(carriers):
            s, force = segments.index(carrier), values[i, k, :3]
            forces[i, s] += force
            torques[i, s] += values[i, k, 3:] + np.cross(centres[k] - points[i, s], force)
    return Loads(times, segments, forces, points, torques)


def _read(path, wearer):
    """Ends of windows (n,), names of ellipsoids, forces and moments (n, m, 6)."""
    if not path.is_file():
        raise ValueError(f"there is no {path}: export the folder of a run that is complete")
    with open(path) as file:
        rows = list(csv.DictReader(file))
    names = [name for name in wearer.names if rows and f"force_{name}_x" in rows[0]]
    if not names:
        raise ValueError(f"{path} has no row with a force on this wearer: nothing to export")
    keys = [[f"{kind}_{name}_{axis}" for kind in ("force", "moment") for axis in AXES]
            for name in names]  # fmt: skip
    table = np.array([[[float(row[key]) for key in some] for some in keys] for row in rows])
    return np.array([float(row["time"]) for row in rows]), names, table


def joint_torques(wearer: Wearer, loads: Loads) -> np.ndarray:
    """Torque (n, k, 3) [N m] about the wearer's joints of all that acts below them, Fig. 9."""
    below = {joint: {wearer.carriers[wearer.index(name)] for name in wearer.below(joint)}
             for joint in wearer.joints}  # fmt: skip
    counts = np.array([[s in below[joint] for s in loads.segments] for joint in wearer.joints])
    joints: Joints = wearer.new_joints()
    torques = np.empty((len(loads.times), len(wearer.joints), 3))
    for i, time in enumerate(loads.times.tolist()):
        wearer.joint_state(time, joints)
        arms = loads.points[i] - joints.centres[:, None]
        about = loads.torques[i] + np.cross(arms, loads.forces[i])
        torques[i] = np.einsum("ks,ksc->kc", counts, about)
    return torques


def add_arms(wearer: Wearer, loads: Loads, recorded: np.ndarray) -> None:
    """Add to `loads.torques` what makes the torques about the joints those recorded.

    recorded : (n, k, 3) [N m], of all below each of the wearer's joints
    """
    gaps = recorded - joint_torques(wearer, loads)
    for k, joint in enumerate(wearer.joints):
        above, below, _ = JOINTS[joint]
        if below in loads.segments:
            loads.torques[:, loads.segments.index(below)] += gaps[:, k]
        # what the joint below it has is below the joint above it, too
        if above in loads.segments and above != "pelvis":
            loads.torques[:, loads.segments.index(above)] -= gaps[:, k]


def recorded_torques(wearer: Wearer, tables: Sequence[Path]) -> np.ndarray:
    """Mean torques (n, k, 3) [N m] about the wearer's joints of these torque.csv."""
    found = []
    for path in tables:
        rows = rows_until(path, np.inf)
        by = {j: [[r[f"torque_{a}"] for a in AXES] for r in rows if r["joint"] == j]
              for j in wearer.joints}  # fmt: skip
        found.append(np.stack([np.array(by[j]) for j in wearer.joints], axis=1))
    return np.mean(found, axis=0)
