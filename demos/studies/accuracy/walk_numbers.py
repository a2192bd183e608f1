# SPDX-License-Identifier: LGPL-3.0-or-later
"""Numbers of an ensemble of walks, how far two ensembles are apart, and how a single run scatters.

Of the hips and knees, over what counts of the motion,

    torque rms     root mean square of each joint's torque, mean over the runs
    torque peak    size of the peak of each joint's mean curve
    torque curve   each joint's mean curve

and of the whole walk the means of strain energy and of the vertical force. Two ensembles are apart
by the root mean square, over the joints, of relative differences; two curves by the root mean
square of their difference over that of the second. The scatter of a single run is sqrt(n) times
the jackknife error of the number that n runs make (shellform/results/ensemble.py): of a mean, the
standard deviation of the runs.
"""

import csv
from pathlib import Path
from typing import NamedTuple

import numpy as np

from shellform.results.ensemble import peak, root_mean_squares
from shellform.simulation.ensemble import complete_of, counted_courses
from shellform.simulation.summary import summary_of

JOINTS = ("right_hip", "right_knee", "left_hip", "left_knee")
QUANTITIES = ("torque rms", "torque peak", "torque curve", "energy", "force")


class Walked(NamedTuple):
    """What n runs of a walk left.

    curves : (n, j, w) [N m], torques of the JOINTS in windows of widths (w,) [s]
    energy : (n,) [J], mean strain energy; force : (n,) [N], mean vertical force on the body
    """

    curves: np.ndarray
    widths: np.ndarray
    energy: np.ndarray
    force: np.ndarray

    def without(self, k: int) -> "Walked":
        """All runs but the run k."""
        one = (np.delete(part, k, axis=0) for part in (self.curves, self.energy, self.force))
        curves, energy, force = one
        return Walked(curves, self.widths, energy, force)


def walked(folder: str | Path) -> Walked:
    """The complete runs in the folder of an ensemble."""
    courses = counted_courses(folder)
    curves = np.stack([courses[joint].torque for joint in JOINTS], axis=1)
    begin, end = summary_of(folder)["results"]["counted_s"]
    files = [member.out / "ledger.csv" for member in complete_of(folder)]
    means = [ledger_means(file, begin, end) for file in files]
    energy, force = np.transpose(means)
    return Walked(curves, courses[JOINTS[0]].widths, energy, force)


def ledger_means(path: Path, begin: float, end: float) -> tuple[float, float]:
    """Strain energy [J] and vertical force [N], means over the rows from begin to end [s]."""
    with open(path) as file:
        rows = [row for row in csv.DictReader(file) if begin < float(row["time"]) <= end + 1e-6]
    up = [key for key in rows[0] if key.startswith("force_") and key.endswith("_z")]
    force = [sum(float(row[key]) for key in up) for row in rows]
    return float(np.mean([float(row["strain"]) for row in rows])), float(np.mean(force))


def numbers_of(runs: Walked) -> dict[str, np.ndarray]:
    """{quantity: (j,) or (j, w) or (1,)} of an ensemble."""
    mean = runs.curves.mean(axis=0)
    return {
        "torque rms": root_mean_squares(runs.curves, runs.widths).mean(axis=0),
        "torque peak": np.array([abs(peak(curve)) for curve in mean]),
        "torque curve": mean,
        "energy": np.array([runs.energy.mean()]),
        "force": np.array([runs.force.mean()]),
    }


def apart(one: np.ndarray, other: np.ndarray) -> float:
    """How far numbers or curves are from others, relative to these; see the header."""
    square = (one - other) ** 2, other**2
    if one.ndim == 2:
        square = square[0].mean(axis=1), square[1].mean(axis=1)
    return float(np.sqrt(np.mean(square[0] / square[1])))


def scatter_of(runs: Walked) -> dict[str, float]:
    """{quantity: relative scatter of a single run}; ValueError for one run alone."""
    n = len(runs.curves)
    if n < 2:
        raise ValueError("one run alone shows no scatter: two at least are needed")
    parts = [numbers_of(runs.without(k)) for k in range(n)]
    mean = {name: np.mean([part[name] for part in parts], axis=0) for name in QUANTITIES}
    return {
        name: float(np.sqrt((n - 1) * sum(apart(part[name], mean[name]) ** 2 for part in parts)))
        for name in QUANTITIES
    }
