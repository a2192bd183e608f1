# SPDX-License-Identifier: LGPL-3.0-or-later
"""Torque against time and against the phase of gait, as a report draws them.

The curve over time is the mean of the runs with its standard error and spread, as torque_mean.csv
has it. Over the phase of gait, from heel strike (0 %) to the next of the same foot (100 %), there
are the mean stride with the same, as in stride_mean.csv, and every stride of its own.
"""

from typing import Any

import numpy as np

from shellform.motion.gait.like_strides import alike
from shellform.motion.gait.strides import side_of
from shellform.results.ensemble import Band, band, estimate
from shellform.results.mean_torque import PLACES, Course, on_strides

from .finished_run import FinishedRun


def torque_curves(run: FinishedRun) -> dict[str, dict[str, Any]]:
    """Curves of a run's joints: joint -> `time`, `torque`, `error`, `spread` (lists, by window),

    `percent`, `strides` (a list of lists at those places), `names` of the strides and, where two or
    more are alike, `mean`, `mean_error`, `mean_spread`. Errors and spreads of one run are nan.
    """
    found = {}
    for joint, course in run.courses.items():
        over_time = band(course.torque)
        entry = {"time": course.times} | _named(over_time, "torque", "error", "spread")
        found[joint] = entry | _over_phase(run, joint, course)
    return found


def _over_phase(run, joint, course):
    strides = np.array(run.results["strides"].get(side_of(joint), []), float).reshape(-1, 2)
    entry = {"percent": PLACES, "strides": [], "names": []}
    if not len(strides):
        return entry
    each = on_strides(course, course.torque, strides)
    like = alike(run.wearer.recording, strides)
    entry["strides"] = each.mean(axis=0)
    entry["names"] = [
        f"{begin:.2f} to {end:.2f} s" + ("" if k in like or not like else ", unlike the others")
        for k, (begin, end) in enumerate(strides)
    ]
    if like:
        mean = band(each[:, like].mean(axis=1))
        entry |= _named(mean, "mean", "mean_error", "mean_spread")
    return entry


def _named(found: Band, mean: str, error: str, spread: str) -> dict[str, np.ndarray]:
    return {mean: found.mean, error: found.error, spread: found.spread}


def mean_and_band(course: Course, counted: tuple[float, float]) -> tuple[float, float, float]:
    """Mean torque over what counts, its standard error, and the band of the curve [N m].

    The band is the root mean square in time of the curve's standard error; nan for one run.
    """
    part = course.within(*counted)
    if not len(part.times):
        return 0.0, np.nan, np.nan
    share = part.widths / part.widths.sum()
    mean = estimate(part.torque @ share)
    error = band(part.torque).error
    return mean.value, mean.error, float(np.sqrt(share @ error**2))
