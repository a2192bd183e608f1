# SPDX-License-Identifier: LGPL-3.0-or-later
"""Scripts of the gallery run and say what is true; `make docs` runs them for their pictures.

Those of the capstan and of the walk take longer and are left to `make docs`; the demos they call
have tests of their own.
"""

import runpy
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
pytestmark = pytest.mark.serial


@pytest.fixture
def names_of(monkeypatch):
    """Function: run a script, its names."""
    monkeypatch.setenv("MPLBACKEND", "Agg")
    monkeypatch.syspath_prepend(str(ROOT / "demos"))

    def run(name):
        import matplotlib.pyplot as plt

        plt.close("all")
        names = runpy.run_path(str(ROOT / "docs/gallery" / name))
        assert plt.get_fignums(), "no picture"
        plt.close("all")
        return names

    return run


def test_roll_up(names_of):
    names = names_of("plot_1_roll_up.py")
    assert np.linalg.norm(names["tip"]) < 1e-4 * names["length"]


def test_strip_over_cylinder(names_of):
    found = names_of("plot_2_strip_over_cylinder.py")["found"]
    coarse, fine = (run["tip"] for run in found.values())
    assert fine < 0.3 * coarse < 2e-3


def test_drape(names_of):
    names = names_of("plot_4_drape.py")
    carried = names["push"][-4:].mean() + names["pin"][-4:].mean()
    assert carried == pytest.approx(names["weight"], rel=0.02)
    assert max(row["momentum_residual"] for row in names["ledger"].rows) < 1e-9


@pytest.mark.thorough
def test_hinge_sleeve(names_of):
    """The loop is what friction took and what stayed; without friction the torque is -dU/dtheta."""
    names = names_of("plot_5_hinge_sleeve.py")
    assert names["loop"] == pytest.approx(names["lost"] + names["kept"], rel=0.05)
    free = names["free"]
    off = np.nanmean((free["torque"] - free["slope"]) ** 2) / np.mean(free["torque"] ** 2)
    assert off < 0.02**2  # with 40 cells around


def test_wrinkles(names_of):
    """In the middle crests lie as those of a long strip do."""
    names = names_of("plot_7_wrinkles.py")
    assert names["mean"] == pytest.approx(names["alpha"], abs=0.5)
    assert (names["found"].state[names["inside"]] == 1).all()
