# SPDX-License-Identifier: LGPL-3.0-or-later
"""Mean torque of made-up runs, from their files, against sums by hand."""

import csv

import numpy as np
import pytest

from shellform.results.comparison import compare, comparison_lines
from shellform.results.ensemble import peak
from shellform.results.joint_torque import COLUMNS, line, resistance, rows_until
from shellform.results.mean_torque import (
    PLACES,
    joint_numbers,
    mean_rows,
    on_strides,
    read_courses,
    write_mean_strides,
    write_mean_torque,
)

pytestmark = pytest.mark.serial
JOINTS = ("right_hip", "right_knee")
ENDS = np.linspace(1.02, 3.0, 100)  # windows of 0.02 s from 1 s on


def write_run(path, torque, power=None, ends=ENDS):
    """A torque.csv whose knee has a torque and whose hip has twice as much."""
    power = -np.abs(torque) if power is None else power
    text = ",".join(COLUMNS) + "\n"
    for row in zip(ends, torque, power, strict=True):
        for size, joint in enumerate(JOINTS):
            time, knee, watt = row
            values = (time, joint, 9.0, 9.0, 9.0, (2 - size) * knee, watt)
            text += line(dict(zip(COLUMNS, values, strict=True)))
    path.write_text(text)
    return path


@pytest.fixture
def courses(tmp_path):
    """Three runs: a wave, with 1, 2 and 3 N m added."""
    wave = np.sin(np.pi * (ENDS - 0.01))  # a period of 2 s, at the middles of the windows
    return read_courses([write_run(tmp_path / f"{k}.csv", 5 * wave + k) for k in (1, 2, 3)])


def test_numbers_of_three_runs(courses):
    """Peak of the mean curve, root mean squares and works of the runs, by hand."""
    knee = courses["right_knee"]
    assert knee.torque.shape == (3, 100) and knee.widths == pytest.approx(np.full(100, 0.02))
    found = joint_numbers(knee, (1.0, 3.0), np.zeros((0, 2)))
    wave = np.sin(np.pi * (ENDS - 0.01))
    curves = [5 * wave + k for k in (1, 2, 3)]
    assert found["peak_torque"] == pytest.approx(peak(5 * wave + 2))
    assert found["peak_torque_error"] == pytest.approx(1 / 3**0.5)
    rms = [np.sqrt(np.mean(curve**2)) for curve in curves]
    assert found["rms_torque"] == pytest.approx(np.mean(rms))
    assert found["rms_torque_error"] == pytest.approx(np.std(rms, ddof=1) / 3**0.5)
    works = [-0.02 * np.abs(curve).sum() for curve in curves]
    assert found["work"] == pytest.approx(np.mean(works)) == -found["resistance"]
    assert found["work_error"] == pytest.approx(np.std(works, ddof=1) / 3**0.5)
    assert found["runs"] == 3 and found["strides"] == [] and "mean_stride" not in found


def test_one_run_has_the_numbers_of_resistance(tmp_path):
    """And no errors, which are no numbers in a JSON file."""
    path = write_run(tmp_path / "torque.csv", np.cos(3 * ENDS), np.sin(4 * ENDS))
    strides = np.array([[1.2, 1.9], [1.9, 2.6]])
    found = joint_numbers(read_courses([path])["right_knee"], (1.2, 2.8), strides)
    single = resistance(rows_until(path, np.inf), "right_knee", strides, 1.0, (1.2, 2.8))
    for mine, other in ((found, single), *zip(found["strides"], single["strides"], strict=True)):
        for name in ("peak_torque", "rms_torque", "work", "resistance"):
            assert mine[name] == pytest.approx(other[name], rel=1e-9)
            assert mine[f"{name}_error"] is None
    assert found["runs"] == 1


def test_only_what_counts(courses):
    """Windows before and after it change nothing."""
    knee = courses["right_knee"].within(1.5, 2.0)
    assert knee.times == pytest.approx(ENDS[25:50]) and knee.torque.shape == (3, 25)
    whole = joint_numbers(courses["right_knee"], (1.5, 2.0), np.zeros((0, 2)))
    assert whole["peak_torque"] == pytest.approx(peak(knee.torque.mean(axis=0)))


def test_mean_stride(tmp_path):
    """A torque that repeats with the strides, of two lengths, in each percent of them.

    One run alone has peaks of both signs, of one size: the error is that of the mean's own.
    """
    strides = np.array([[1.1, 1.8], [1.8, 2.9]])
    middles = ENDS - 0.01
    percent = np.where(middles < 1.8, (middles - 1.1) / 0.7, (middles - 1.8) / 1.1)
    course = 3 * np.sin(2 * np.pi * percent)
    files = [write_run(tmp_path / f"{k}.csv", course + k) for k in (0.0, 0.4)]
    knee = read_courses(files)["right_knee"]
    curves = on_strides(knee, knee.torque, strides)
    assert curves.shape == (2, 2, 101)
    # between windows of a 35th and a 55th of a stride straight lines miss the curvature
    expected = 3 * np.sin(2 * np.pi * PLACES / 100)
    assert np.abs(curves[0] - expected)[:, 3:-3].max() < 3 * (2 * np.pi / 35) ** 2 / 8 * 1.1
    found = joint_numbers(knee, (1.0, 3.0), strides, alike=[0, 1])["mean_stride"]
    assert found["strides"] == 2 and found["runs"] == 2
    assert found["peak_torque"] == pytest.approx(peak(curves.mean(axis=(0, 1))))
    assert found["peak_torque_error"] == pytest.approx(0.2, rel=1e-6)
    both = (ENDS > 1.1 + 1e-6) & (ENDS < 2.9 + 1e-6)
    assert found["work"] == pytest.approx(-0.02 * np.abs(knee.torque[:, both]).sum() / 4)


def test_files(courses, tmp_path):
    """Mean, standard error and spread of every window; rows as those of torque.csv."""
    write_mean_torque(tmp_path / "torque_mean.csv", courses)
    rows = mean_rows(tmp_path)
    knee = [row for row in rows if row["joint"] == "right_knee"]
    assert [row["time"] for row in knee] == pytest.approx(ENDS)
    assert [row["spread"] for row in knee] == pytest.approx(np.ones(100), rel=1e-5)
    assert [row["standard_error"] for row in knee] == pytest.approx(np.full(100, 3**-0.5), rel=1e-5)
    mean = courses["right_knee"].torque.mean(axis=0)
    assert [row["torque_flexion"] for row in knee] == pytest.approx(mean)
    # one run has none of both
    write_mean_strides(tmp_path / "stride_mean.csv", {"right_knee": 0 * PLACES[None]})
    with open(tmp_path / "stride_mean.csv") as file:
        rows = list(csv.DictReader(file))
    assert rows[0]["percent"] == "0" and rows[0]["spread"] == rows[0]["standard_error"] == ""
    assert not list(tmp_path.glob("*.part"))


def test_runs_of_other_scenes_are_refused(tmp_path):
    one = write_run(tmp_path / "a.csv", 0 * ENDS)
    other = write_run(tmp_path / "b.csv", 0 * ENDS[:-1], ends=ENDS[:-1])
    with pytest.raises(ValueError, match=r"b\.csv has other windows of right_hip than .*a\.csv"):
        read_courses([one, other])
    (tmp_path / "c.csv").write_text(
        "".join(row for row in one.read_text().splitlines(True) if "knee" not in row)
    )
    with pytest.raises(ValueError, match=r"c\.csv has no torque of right_knee"):
        read_courses([one, tmp_path / "c.csv"])


def test_comparison_of_two_ensembles(courses, tmp_path):
    """Equals do not differ; half a N m more in each run does."""
    found = compare(courses, courses)
    assert list(found) == list(JOINTS)
    for numbers in found.values():
        for entry in numbers.values():
            assert entry["difference"] == 0 and entry["differ"] is False and entry["runs"] == 3
    wave = np.sin(np.pi * (ENDS - 0.01))
    files = [write_run(tmp_path / f"m{k}.csv", 5 * wave + k + 0.5 + 0.01 * k) for k in (1, 2, 3)]
    more = compare(read_courses(files), courses)["right_knee"]["peak_torque"]
    assert more["difference"] == pytest.approx(0.52) and more["differ"] is True
    assert more["low"] < 0.52 < more["high"] and more["low"] > 0.4
    lines = comparison_lines(compare(read_courses(files), courses), "a", "b")
    assert "a less b, 3 pairs of runs" in lines[0] and lines[-1].count("*") >= 1
    alone = compare(read_courses(files[:1]), courses)
    assert alone["right_hip"]["work"]["differ"] is None
    assert "cannot be told" in comparison_lines(alone, "a", "b")[0]
    with pytest.raises(ValueError, match="there is no joint in both: right_hip; right_knee"):
        compare({"right_hip": courses["right_hip"]}, {"right_knee": courses["right_knee"]})
