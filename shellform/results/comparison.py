# SPDX-License-Identifier: LGPL-3.0-or-later
"""Whether two fabrics or garments differ in what they do to the joints.

Run k of one ensemble is paired with run k of the other, which has the same start. Told are the
difference of each number, its 95 % interval (Student's t; of peaks the jackknife's error) and
whether zero lies outside. In 5 of 100 comparisons of equals it does so by chance, and with four
numbers of six joints some of them will: what matters is how far outside.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from .ensemble import Estimate, differ, paired_difference, peak_difference, root_mean_squares
from .mean_torque import Course

NUMBERS = ("peak_torque", "rms_torque", "work")


def differences(one: Course, other: Course) -> dict[str, dict[str, Any]]:
    """Of the numbers NUMBERS of a joint, one less other.

    Parameters
    ----------
    one, other : windows that count, of n and m runs; the longer ensemble gives its first runs

    Returns
    -------
    dict, number -> dict of `difference`, `error`, `low`, `high`, `differ`, `runs`; but for the
    first and the last None for one run
    """
    rms = [root_mean_squares(course.torque, course.widths) for course in (one, other)]
    work = [(course.widths * course.power).sum(axis=1) for course in (one, other)]
    found = (
        peak_difference(one.torque, other.torque),
        paired_difference(*rms),
        paired_difference(*work),
    )
    return {name: _entry(number) for name, number in zip(NUMBERS, found, strict=True)}


def _entry(number: Estimate) -> dict[str, Any]:
    low, high = number.interval()
    several = number.runs > 1
    return {
        "difference": number.value,
        "error": number.error if several else None,
        "low": low if several else None,
        "high": high if several else None,
        "differ": differ(number),
        "runs": number.runs,
    }


def compare(one: Mapping[str, Course], other: Mapping[str, Course]) -> dict[str, dict]:
    """Differences of the joints that both have, see `differences`.

    Raises
    ------
    ValueError where they have none in common
    """
    joints = [joint for joint in one if joint in other]
    if not joints:
        raise ValueError(
            f"there is no joint in both: {', '.join(one) or 'none'}; {', '.join(other) or 'none'}"
        )
    return {joint: differences(one[joint], other[joint]) for joint in joints}


def comparison_lines(found: Mapping[str, dict], one: str, other: str) -> list[str]:
    """Lines for a person: `one` less `other`."""
    runs = next(iter(found.values()))[NUMBERS[0]]["runs"]
    titles = ("peak N m", "rms N m", "work J")
    if runs < 2:
        lines = [f"{one} less {other}, one run each: whether they differ cannot be told"]
    else:
        lines = [f"{one} less {other}, {runs} pairs of runs, with 95 % interval; * they differ"]
    wide = 29 if runs > 1 else 10
    lines.append(f"{'joint':>12}" + "".join(f" {title:>{wide}}" for title in titles))
    for joint, numbers in found.items():
        lines.append(f"{joint:>12}" + "".join(f" {_told(numbers[n]):>{wide}}" for n in NUMBERS))
    return lines


def _told(entry: Mapping[str, Any]) -> str:
    value = f"{np.round(entry['difference'], 3) + 0.0:.3f}"
    if entry["runs"] < 2:
        return value
    mark = "*" if entry["differ"] else " "
    return f"{value} ({entry['low']:.3f} to {entry['high']:.3f}){mark}"
