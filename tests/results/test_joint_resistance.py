# SPDX-License-Identifier: LGPL-3.0-or-later
"""What clothing costs a joint, from rows of torque and power; which parts count."""

import numpy as np
import pytest

from shellform.results.joint_torque import COLUMNS, resistance


def history(torques, powers, joint="right_knee", width=0.5):
    """Rows of a made-up run that begins at 1 s."""
    return [
        dict(zip(COLUMNS, (1.0 + width * (k + 1), joint, 9, 9, 9, *pair), strict=True))
        for k, pair in enumerate(zip(torques, powers, strict=True))
    ]


def test_resistance_of_a_made_up_history():
    """Sums over windows of half a second, by hand."""
    rows = history([1, -2, -4, 2, 0], [2, -4, 1, -3, 0])
    rows += history([7] * 5, [8] * 5, "right_hip")
    found = resistance(rows, "right_knee", [(1.0, 2.0), (2.0, 3.0), (2.0, 3.5)])
    first, second, rest = found.pop("strides")
    assert found == pytest.approx(
        {"peak_torque": -4, "rms_torque": 5**0.5, "work": -2, "resistance": 3.5}
    )
    assert first == pytest.approx(
        {"peak_torque": -2, "rms_torque": 2.5**0.5, "work": -1, "resistance": 2}
    )
    assert second == pytest.approx(
        {"peak_torque": -4, "rms_torque": 10**0.5, "work": -1, "resistance": 1.5}
    )
    assert rest["rms_torque"] == pytest.approx((20 / 3) ** 0.5)
    # the first window longer than the others
    assert resistance(rows, "right_knee", start=0.0)["work"] == pytest.approx(-2 + 2 * 1.0)
    assert resistance(rows[:1], "right_knee", start=1.0)["work"] == pytest.approx(1)
    with pytest.raises(ValueError, match="give its start"):
        resistance(rows[:1], "right_knee")
    with pytest.raises(ValueError, match="no torque about a joint 'knee'; there are: right_hip, "):
        resistance(rows, "knee")


def test_standing_counts_for_nothing():
    """Windows not wholly within what counts: neither in peak nor sums, nor in a stride."""
    rows = history([90, 1, -3, 2, 80], [90, 2, -4, 1, 80])
    found = resistance(rows, "right_knee", [(1.0, 2.5), (2.5, 3.5)], counted=(1.5, 3.0))
    first, last = found.pop("strides")
    assert found == pytest.approx(
        {"peak_torque": -3, "rms_torque": (14 / 3) ** 0.5, "work": -0.5, "resistance": 2}
    )
    assert first["peak_torque"] == -3 and last["peak_torque"] == 2
    inner = resistance(rows, "right_knee", counted=(1.6, 3.0))
    assert inner["rms_torque"] == pytest.approx((13 / 2) ** 0.5)
    assert resistance(rows, "right_knee", counted=(5.0, 6.0))["peak_torque"] == 0.0


def test_resistance_of_a_power_that_changes_sign():
    """sin t over a period gives 2; a window that hides a zero loses at most width^2/8."""
    for n in (40, 80):
        edges = np.linspace(0, 2 * np.pi, n + 1) + 0.03
        power = -np.diff(np.cos(edges)) / np.diff(edges)
        found = resistance(history(0 * power, power, width=2 * np.pi / n), "right_knee")
        assert 1e-5 < 2.0 - found["resistance"] < 2 * (2 * np.pi / n) ** 2 / 8
        assert found["work"] == pytest.approx(0, abs=1e-12)
