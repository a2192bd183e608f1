# SPDX-License-Identifier: LGPL-3.0-or-later
"""Demos choose their cells by the error asked for and say what they reached."""

import importlib
import json
import subprocess
import sys

import pytest

from tests.ranks import ROOT, outside

pytestmark = pytest.mark.serial


def run(*arguments):
    return subprocess.run(
        [sys.executable, *map(str, arguments)], cwd=ROOT, env=outside(), capture_output=True,
        text=True, timeout=300, check=False,
    )  # fmt: skip


def test_a_demo_tells_what_it_reached(tmp_path):
    done = run("demos/roll_up.py", "--accuracy", "1%", "--turns", 0.75, "--out", tmp_path)
    assert done.returncode == 0, done.stderr
    summary = json.loads((tmp_path / "summary.json").read_text())
    entry, error = summary["accuracy"], summary["results"]["tip_error_over_length"]
    assert {"asked", "predicted", "estimated", "how"} <= set(entry)
    assert entry["asked"] == 0.01 and error < 0.01 and entry["promised"] is True
    assert 0.5 < error / entry["predicted"] < 2
    assert 0.5 < entry["estimated"] / error < 2
    assert "accuracy 1 %: quads" in done.stdout and "predicted" in done.stdout


@pytest.mark.parametrize("wrong", ["0%", "banana"])
@pytest.mark.parametrize("demo", ["roll_up", "drape", "hinge_sleeve", "strip_over_cylinder"])
def test_demos_refuse_an_accuracy_that_is_none(demo, wrong, capsys):
    main = importlib.import_module(f"demos.{demo}").main
    with pytest.raises(SystemExit) as stop:
        main(["--accuracy", wrong])
    assert stop.value.code == 2
    assert (
        f"draft, standard, fine or a percentage as '2%', not '{wrong}'" in capsys.readouterr().err
    )


@pytest.mark.thorough
def test_a_heavier_sleeve_takes_larger_steps(tmp_path):
    """Steps go with the root of the mass; the demo says which trick was used."""
    given = ("--around", 12, "--friction", 0, "--cycles", 1)
    seen = {}
    for mass in (1, 16):
        done = run("demos/hinge_sleeve.py", *given, "--mass-scale", mass, "--out", tmp_path)
        assert done.returncode == 0, done.stderr
        seen[mass] = json.loads((tmp_path / "summary.json").read_text())
    assert seen[1]["steps"] / seen[16]["steps"] == pytest.approx(4, rel=0.05)
    assert seen[1]["tricks"] == {} and set(seen[16]["tricks"]) == {"mass 16"}
