# SPDX-License-Identifier: LGPL-3.0-or-later
"""A penalty errs by what it gives way, impulses do not."""

import pytest

from demos.studies.contact_methods import implicit, run

pytestmark = pytest.mark.serial


def test_a_sleeve():
    hard, limp, stiff = run.rows_of("sleeve", (1e6, 1e8))
    assert abs(hard["error %"]) < 1 and abs(stiff["error %"]) < 1
    assert limp["error %"] < -20  # the tube has become narrower
    assert hard["depth [mm]"] < 1e-6 < stiff["depth [mm]"] < 0.05 * limp["depth [mm]"]
    # the pressure over the stiffness
    pressure = 43.4 * (1 + stiff["error %"] / 100) / 0.048
    assert stiff["depth [mm]"] == pytest.approx(1e3 * pressure / 1e8, rel=0.05)


@pytest.mark.thorough
def test_the_table(tmp_path, capsys):
    """In implicit steps too a penalty errs by what it gives way; the augmented one does not."""
    options = ["--scenes", "sleeve", "--stiffness", "1e7", "--augmented", "1e6"]
    run.main([*options, "--out", str(tmp_path)])
    assert "augmented 1e+06" in capsys.readouterr().out
    assert len((tmp_path / "contact_methods.csv").read_text().splitlines()) == 6
    held, limp, augmented = run.implicit_rows_of("sleeve", (1e7,), (1e6,))
    assert limp["error %"] < -3
    assert augmented["error %"] == pytest.approx(held["error %"], abs=0.01)
    assert augmented["depth [mm]"] < 1e-3 < 0.05 < limp["depth [mm]"]


@pytest.mark.thorough
def test_an_active_set_gets_through_the_belt():
    """In implicit steps of 2 ms; its quick twin is test_friction_gives_no_energy."""
    row = implicit.run("capstan", None, 0)
    assert abs(row["error %"]) < 1
    assert row["depth [mm]"] < 1e-6


def test_a_run_that_does_not_end_says_so(monkeypatch):
    monkeypatch.setattr(implicit, "MOST_SOLVES", 2)
    row = implicit.run("sleeve", 1e7, 0)
    assert row["error %"] == "after 2 solves, at 0.006 s"
