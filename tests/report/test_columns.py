# SPDX-License-Identifier: LGPL-3.0-or-later
"""docs/results.md names every column of the tables that a run writes, and none that it does not."""

import csv
import re

import pytest

from tests.ranks import ROOT

pytestmark = pytest.mark.serial
PAGE = ROOT / "docs/results.md"
# columns of what this cloth does not do
SOME = ("hysteresis_loss", "self_impact_loss", "self_friction_loss")


def described(title):
    """Names in the first column of a section's table, `_y` and `_z` in full."""
    section = PAGE.read_text(encoding="utf-8").partition(f"### {title}\n")[2].partition("\n### ")[0]
    names = []
    for cell in re.findall(r"^\| (`[^|]*) \|", section, re.M):
        for name in re.findall(r"`([^`]+)`", cell):
            names.append(name if name[0] != "_" else re.sub("_[xyz]$", "", names[-1]) + name)
    return names


def header(path):
    with open(path) as file:
        return next(csv.reader(file))


def test_torque(two_runs):
    assert described("torque.csv") == header(two_runs[0] / "torque.csv")
    mean = described("torque_mean.csv and stride_mean.csv")
    assert [name for name in mean if name != "percent"] == header(two_runs[0] / "torque_mean.csv")


def test_ledger(two_runs):
    """Parts of the body stand for one another; some columns are of cloth that has them."""
    found = header(two_runs[0] / "ledger.csv")
    parts = sorted({re.sub("^force_|_x$", "", name) for name in found if name.startswith("force_")})
    assert "right_thigh" in "".join(parts) and len(parts) > 6
    inside = re.compile("^(force|moment)_.*_([xyz])$")
    kinds = list(dict.fromkeys(inside.sub(r"\1_PART_\2", name) for name in found))
    names = [name for name in described("ledger.csv") if name not in SOME]
    assert sorted(names) == sorted(kinds)
