# SPDX-License-Identifier: LGPL-3.0-or-later
"""Whether two ensembles differ at all, told from their differences together.

Each difference has its own 95 % interval (comparison.py), which leaves out zero in 5 of 100 equals.
Of the twelve of six joints some does so in a quarter to a half of all comparisons of equals.
For one answer the p-values of Student's t are therefore judged together by Holm's rule (Scand. J.
Stat. 6, 1979): in rising order, p_1 <= ... <= p_m, number k differs while

    p_k <= 0.05 / (m - k + 1),

up to the first that does not. Two equals are then called different in at most 5 of 100 comparisons,
however the numbers hang together.

Root mean square and work are judged, means of numbers of the runs. Peaks are not: a largest value
jumps where two places of a curve are almost as large, which no error of a few runs foretells.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from scipy.special import stdtr

from .ensemble import LEVEL

WORDS = {"rms_torque": "root mean square torque", "work": "work"}
JUDGED = ("rms_torque", "work")
UNITS = {"peak_torque": "N m", "rms_torque": "N m", "work": "J"}


class Verdict(NamedTuple):
    """Whether two ensembles differ (None: one run each, it cannot be told), in which numbers.

    apart : (joint, number) pairs that differ, the clearest first; compared : how many
    """

    differ: bool | None
    apart: tuple[tuple[str, str], ...]
    compared: int


def p_value(entry: Mapping[str, Any]) -> float:
    """Chance of a difference at least this large between equals; see `comparison.differences`."""
    size, error = abs(entry["difference"]), entry["error"]
    if error == 0.0:
        return 1.0 if size == 0.0 else 0.0
    return float(2.0 * stdtr(entry["runs"] - 1, -size / error))


def verdict(found: Mapping[str, dict]) -> Verdict:
    """Answer from the differences of `comparison.compare`, by Holm's rule.

    Examples
    --------
    >>> equal = {"difference": 0.1, "error": 0.2, "runs": 3}
    >>> apart = {"difference": 9.0, "error": 0.1, "runs": 3}
    >>> verdict({"right_knee": {"rms_torque": equal, "work": equal}}).differ
    False
    >>> verdict({"right_knee": {"rms_torque": apart, "work": equal}}).apart
    (('right_knee', 'rms_torque'),)
    """
    pairs = [(joint, number) for joint in found for number in JUDGED]
    entries = [found[joint][number] for joint, number in pairs]
    if min(entry["runs"] for entry in entries) < 2:
        return Verdict(None, (), len(pairs))
    chances = np.array([p_value(entry) for entry in entries])
    order = np.argsort(chances, kind="stable")
    limits = (1.0 - LEVEL) / np.arange(len(pairs), 0, -1)
    beyond = chances[order] > limits
    kept = order[: int(beyond.argmax())] if beyond.any() else order
    return Verdict(len(kept) > 0, tuple(pairs[k] for k in kept), len(pairs))


def verdict_sentence(found: Mapping[str, dict], one: str, other: str) -> str:
    """A sentence for a person: whether `one` and `other` differ, and where most clearly."""
    answer = verdict(found)
    if answer.differ is None:
        return (
            f"Whether {one} and {other} differ cannot be told from one run each: run both with "
            "--runs 3 or more."
        )
    runs = next(iter(found.values()))[JUDGED[0]]["runs"]
    if not answer.differ:
        return (
            f"{one} and {other} do not differ: in {runs} pairs of runs none of {answer.compared} "
            "differences is larger than chance explains (5 % for all of them together)."
        )
    joint, number = answer.apart[0]
    entry = found[joint][number]
    return (
        f"{one} and {other} differ, in {len(answer.apart)} of {answer.compared} numbers of {runs} "
        f"pairs of runs. Clearest is the {WORDS[number]} about the {joint.replace('_', ' ')}: "
        f"{one} less {other} is {entry['difference']:.3g} {UNITS[number]} (95 % interval "
        f"{entry['low']:.3g} to {entry['high']:.3g})."
    )
