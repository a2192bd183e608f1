# SPDX-License-Identifier: LGPL-3.0-or-later
"""Joint torques of an ensemble of runs: mean curves with their band, over time and over strides.

Each run has left a torque.csv, with windows at the same times. Of every joint are reported

    peak of the mean curve, root mean square and work of the runs,

with standard errors (ensemble.py), over what counts of the motion, and the same of the mean stride
where it has two or more that are alike: each run's curves are brought to 101 places from heel
strike to heel strike, averaged over the strides of the run, then over the runs.

torque_mean.csv and stride_mean.csv hold the mean curves with standard error and spread of the runs;
both fields are empty for one run alone.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from .ensemble import Estimate, band, estimate, peak_of_mean, root_mean_squares
from .files import write_atomically
from .joint_torque import rows_until

PLACES = np.linspace(0.0, 100.0, 101)  # of a stride [%]
SLACK = 1e-6  # s, of times in a file


class Course(NamedTuple):
    """Windows of a joint in n runs.

    times : (w,) [s], ends of the windows; widths : (w,) [s]
    torque : (n, w) [N m], about the axis of flexion; power : (n, w) [W]
    """

    times: np.ndarray
    widths: np.ndarray
    torque: np.ndarray
    power: np.ndarray

    def within(self, begin: float, end: float) -> "Course":
        """Windows that end after `begin` and not after `end` [s]."""
        inside = (self.times > begin + SLACK) & (self.times <= end + SLACK)
        return Course(*(field[..., inside] for field in self))


def read_courses(files: Sequence[str | Path], start: float | None = None) -> dict[str, Course]:
    """Courses of all joints in the torque.csv of n runs.

    Parameters
    ----------
    files : one a run; start : begin [s] of the first window, None: it is as long as the second

    Raises
    ------
    ValueError where a file has other joints or windows than the first
    """
    found: dict[str, list] = {}
    times: dict[str, np.ndarray] = {}
    for k, path in enumerate(files):
        rows = rows_until(path, np.inf)
        for joint in dict.fromkeys(row["joint"] for row in rows):
            own = [row for row in rows if row["joint"] == joint]
            ends = np.array([row["time"] for row in own])
            if k == 0:
                times[joint], found[joint] = ends, []
            first = times.get(joint, ends[:0])
            if len(first) != len(ends) or np.abs(first - ends).max(initial=0.0) > 1e-6:
                raise ValueError(f"{path} has other windows of {joint} than {files[0]}")
            found[joint].append([(row["torque_flexion"], row["power"]) for row in own])
        for joint, runs in found.items():
            if len(runs) != k + 1:
                raise ValueError(f"{path} has no torque of {joint}, which {files[0]} has")
    courses = {}
    for joint, runs in found.items():
        values, ends = np.array(runs), times[joint]
        begin = start
        if begin is None:
            begin = 2 * ends[0] - ends[1] if len(ends) > 1 else 0.0
        courses[joint] = Course(ends, np.diff(ends, prepend=begin), values[..., 0], values[..., 1])
    return courses


def joint_numbers(
    course: Course,
    counted: tuple[float, float],
    strides: np.ndarray,
    alike: Sequence[int] = (),
) -> dict[str, Any]:
    """What the clothing does to a joint, with standard errors.

    Parameters
    ----------
    course : of the joint; counted : begin and end [s] of what counts of the motion
    strides : (k, 2) [s], begin and end of each; alike : which of them are alike

    Returns
    -------
    dict with `peak_torque`, `rms_torque` [N m], `work`, `resistance` [J], the standard error of
    each as `..._error`, None for one run; `runs`; `strides`, a list of the same for each stride;
    and, with two or more strides alike, `mean_stride`, the same of the mean stride with `strides`,
    their number
    """
    numbers = _numbers(course.within(*counted))
    numbers["strides"] = [_numbers(course.within(*stride)) for stride in strides]
    if len(alike) > 1:
        numbers["mean_stride"] = _stride_numbers(course, strides[list(alike)])
    return numbers


def on_strides(course: Course, values: np.ndarray, strides: np.ndarray) -> np.ndarray:
    """Values (n, w) by window at PLACES of each stride: (n, k, 101); at middles of the windows."""
    middles = course.times - 0.5 * course.widths
    at = strides[:, :1] + (strides[:, 1:] - strides[:, :1]) * PLACES / 100.0
    return np.array([np.interp(at, middles, own) for own in values])


def _numbers(course):
    """Numbers of the windows given."""
    if not len(course.times):
        none = Estimate(0.0, np.nan, len(course.torque))
        return _entries(none, none, none, none)
    work = (course.widths * course.power).sum(axis=1)
    resisted = -(course.widths * np.minimum(course.power, 0.0)).sum(axis=1)
    rms = root_mean_squares(course.torque, course.widths)
    return _entries(*peak_and_means(course.torque, rms, work, resisted))


def _stride_numbers(course, strides):
    """Numbers of the mean stride: works are means of those of the strides."""
    curves = on_strides(course, course.torque, strides)
    each = [course.within(*stride) for stride in strides]
    works = [(part.widths * part.power).sum(axis=1) for part in each]
    resisted = [-(part.widths * np.minimum(part.power, 0.0)).sum(axis=1) for part in each]
    squares = [root_mean_squares(part.torque, part.widths) for part in each]
    means = (np.mean(numbers, axis=0) for numbers in (squares, works, resisted))
    return _entries(*peak_and_means(curves.mean(axis=1), *means)) | {"strides": len(strides)}


def peak_and_means(curves: np.ndarray, *numbers: np.ndarray) -> list[Estimate]:
    """Peak of the mean of curves (n, w), and means of numbers (n,) of the runs."""
    return [peak_of_mean(curves), *map(estimate, numbers)]


def _entries(*estimates):
    """Estimates as entries of summary.json."""
    out = {}
    names = ("peak_torque", "rms_torque", "work", "resistance")
    for name, found in zip(names, estimates, strict=True):
        out[name] = found.value
        out[f"{name}_error"] = None if np.isnan(found.error) else found.error
    return out | {"runs": estimates[0].runs}


def write_mean_torque(path: str | Path, courses: Mapping[str, Course]) -> None:
    """Mean curves over time, by joint: torque_mean.csv."""
    lines = ["time,joint,torque_flexion,standard_error,spread"]
    bands = {joint: band(course.torque) for joint, course in courses.items()}
    for joint, course in courses.items():
        lines += _lines(course.times, joint, bands[joint])
    write_atomically(path, "\n".join(lines) + "\n")


def write_mean_strides(path: str | Path, curves: Mapping[str, np.ndarray]) -> None:
    """Mean strides, by joint: stride_mean.csv; curves (n, 101) of each run, see `PLACES`."""
    lines = ["percent,joint,torque_flexion,standard_error,spread"]
    for joint, own in curves.items():
        lines += _lines(PLACES, joint, band(own))
    write_atomically(path, "\n".join(lines) + "\n")


def mean_rows(folder: str | Path) -> list[dict[str, Any]]:
    """Rows of torque_mean.csv in the folder of an ensemble; of torque.csv where one run is all."""
    mean = Path(folder) / "torque_mean.csv"
    return rows_until(mean if mean.is_file() else Path(folder) / "torque.csv", np.inf)


def _lines(places, joint, found):
    """Rows of a file; without a band for one run."""
    rows = zip(places, found.mean, found.error, found.spread, strict=True)
    return [
        f"{at:.10g},{joint},{mean:.10g},"
        + ("," if np.isnan(error) else f"{error:.6g},{spread:.6g}")
        for at, mean, error, spread in rows
    ]
