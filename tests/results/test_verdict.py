# SPDX-License-Identifier: LGPL-3.0-or-later
"""One answer from many differences: equals differ in 5 of 100 comparisons, others are found."""

import numpy as np
import pytest

from shellform.results.comparison import compare
from shellform.results.mean_torque import Course
from shellform.results.verdict import JUDGED, p_value, verdict, verdict_sentence

JOINTS = ("right_hip", "right_knee", "right_ankle", "left_hip", "left_knee", "left_ankle")
WINDOWS = 40


def courses(draw, runs, more=0.0):
    """Torques of equal runs with a scatter of a tenth; `more` is added to all."""
    ends = np.arange(1.0, WINDOWS + 1)
    mean = np.sin(ends / 5)
    found = {}
    for joint in JOINTS:
        torque = (1 + more) * mean + 0.1 * draw.standard_normal((runs, WINDOWS))
        found[joint] = Course(ends, np.ones(WINDOWS), torque, 0.3 * torque**2)
    return found


def test_equals_differ_by_chance_alone():
    """Of 400 pairs of equals at most 5 %, with a margin of three standard deviations.

    Far more have some number whose own interval leaves out zero: in all, 1 - 0.95^6 = 26 %.
    """
    draw = np.random.default_rng(7)
    together = alone = 0
    for _ in range(400):
        found = compare(courses(draw, 4), courses(draw, 4))
        together += verdict(found).differ
        alone += any(own[number]["differ"] for own in found.values() for number in JUDGED)
    assert together <= 20 + 3 * np.sqrt(20 * 0.95)
    assert alone > 400 * (1 - 0.95**6) - 3 * np.sqrt(400 * 0.26 * 0.74)


def test_others_are_found():
    draw = np.random.default_rng(8)
    found = compare(courses(draw, 4, more=0.5), courses(draw, 4))
    answer = verdict(found)
    assert answer.differ and len(answer.apart) >= 6 and answer.compared == 12
    chances = [p_value(found[joint][number]) for joint, number in answer.apart]
    assert chances == sorted(chances)
    joint, number = answer.apart[0]
    said = verdict_sentence(found, "stiff", "soft")
    assert said.startswith("stiff and soft differ, in ") and joint.replace("_", " ") in said
    entry = found[joint][number]
    assert f"{entry['low']:.3g} to {entry['high']:.3g}" in said


def test_holm_stops_at_the_first_that_does_not():
    """p of about 0.02, 0.02 and 0.3: none is below 0.05 / 4, though two are below 0.05 / 2."""

    def entry(error):
        return {"difference": 1.0, "error": error, "runs": 1000, "low": 0.0, "high": 0.0}

    found = {
        "knee": {"rms_torque": entry(1 / 2.33), "work": entry(1 / 2.3)},
        "hip": {"rms_torque": entry(1.0), "work": entry(1.0)},
    }
    chances = [p_value(found["knee"][name]) for name in JUDGED]
    assert 0.05 / 4 < chances[0] < chances[1] < 0.05 / 2
    assert verdict(found).differ is False
    found["knee"]["rms_torque"] = entry(1 / 2.6)
    assert verdict(found).apart == (("knee", "rms_torque"),)
    found["knee"]["work"] = entry(1 / 2.5)
    assert verdict(found).apart == (("knee", "rms_torque"), ("knee", "work"))


def test_peaks_are_not_judged():
    """A curve with two extremes alike: its peak jumps from one sign to the other."""
    draw = np.random.default_rng(7)
    found = compare(courses(draw, 4), courses(draw, 4))
    assert max(abs(own["peak_torque"]["difference"]) for own in found.values()) > 1.5
    assert verdict(found).differ is False


def test_one_run_cannot_tell():
    draw = np.random.default_rng(9)
    found = compare(courses(draw, 1), courses(draw, 1))
    assert verdict(found).differ is None
    assert "cannot be told from one run each" in verdict_sentence(found, "a", "b")


@pytest.mark.parametrize(("difference", "chance"), [(0.0, 1.0), (2.0, 0.0)])
def test_runs_without_scatter(difference, chance):
    assert p_value({"difference": difference, "error": 0.0, "runs": 3}) == chance
