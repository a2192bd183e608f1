# SPDX-License-Identifier: LGPL-3.0-or-later
"""Demos and the README's scripts run as a user runs them, on one rank and on two."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

from tests.ranks import launch

ROOT = Path(__file__).resolve().parents[2]
pytestmark = pytest.mark.serial


def run(*words, ranks=1, cwd=ROOT):
    return launch(ranks, *words, cwd=cwd)


def heard(done):
    """Lines on stderr but those on forms, which a cold cache has compiled."""
    return [line for line in done.stderr.splitlines() if not line.startswith("compiled ")]


@pytest.mark.parametrize("ranks", [1, 2])
def test_roll_up(ranks, tmp_path):
    done = run("demos/roll_up.py", "--cells", 12, "--steps", 20, "--out", tmp_path, ranks=ranks)
    assert done.returncode == 0, done.stderr
    summary = json.loads((tmp_path / "summary.json").read_text())
    results = summary["results"]
    assert results["tip_error_over_length"] < 3e-4
    assert len(results["newton_iterations_per_step"]) == 20
    assert max(results["newton_iterations_per_step"]) <= 6
    assert summary["ranks"] == ranks
    assert summary["dofs"] == 5 * summary["nodes"] - 10 - 2 * 2 * 12
    for key in ("setup", "compile", "assemble", "solve", "contact", "output", "total"):
        assert summary["seconds"][key] >= 0
    assert (tmp_path / "roll_up.png").read_bytes()[:4] == b"\x89PNG"
    frames = re.findall(r'file="(.*?)"', (tmp_path / "series.pvd").read_text())
    assert len(frames) == 5
    assert all((tmp_path / name).is_file() for name in frames)
    assert "error/L" in done.stdout
    assert heard(done) == []  # no bar, no compiler's lines, where there is no terminal


def test_roll_up_passes_options_on_to_petsc(tmp_path):
    out = ("--cells", 4, "--turns", 0.2, "--steps", 1, "--out", tmp_path)
    done = run("demos/roll_up.py", *out, "-shell_snes_monitor")
    assert "SNES Function norm" in done.stdout and heard(done) == []
    assert "SNES Function norm" not in run("demos/roll_up.py", *out).stdout


@pytest.mark.parametrize("ranks", [1, 2])
def test_roll_up_warns_of_misspelt_options_of_petsc(ranks, tmp_path):
    """In one line, which names them and no others: not those in use, nor our own defaults."""
    out = ("--cells", 4, "--turns", 0.2, "--steps", 1, "--out", tmp_path)
    options = ("-shell_snes_monitr", "-shell_snes_rtol", "1e-7", "-shell_pc_type", "lu")
    done = run("demos/roll_up.py", *out, *options, ranks=ranks)
    assert done.returncode == 0
    (line,) = heard(done)
    assert line.startswith("warning: ") and line.count("-shell_") == 1
    assert "-shell_snes_monitr:" in line


@pytest.mark.parametrize(("percent", "bar"), [("3%", 0.03), ("0.3%", 0.003)])
def test_roll_up_keeps_the_accuracy_asked_for(percent, bar, tmp_path):
    done = run("demos/roll_up.py", "--accuracy", percent, "--out", tmp_path)
    assert done.returncode == 0, done.stderr
    results = json.loads((tmp_path / "summary.json").read_text())["results"]
    assert bar / 20 < results["tip_error_over_length"] < bar


BAD = {
    "an unknown option": (["--cell", "3"], "unknown argument --cell"),
    "a negative thickness": (["--thickness", "-1"], "must be above zero, not -1"),
    "no turns": (["--turns", "0"], "--turns must be a finite number other than zero"),
    "an accuracy in no unit": (["--accuracy", "0.01"], "draft, standard, fine or a percentage"),
    "one Newton iteration": (["-shell_snes_max_it", "1"], "no equilibrium found"),
}


@pytest.mark.parametrize("name", BAD)
def test_roll_up_refuses(name, tmp_path):
    arguments, words = BAD[name]
    done = run("demos/roll_up.py", *arguments, "--out", tmp_path)
    assert done.returncode == 2
    assert words in done.stderr
    assert "Traceback" not in done.stderr


def test_a_failing_run_ends_all_ranks(tmp_path):
    done = run("demos/roll_up.py", "-shell_snes_max_it", 1, "--out", tmp_path, ranks=2)
    assert done.returncode != 0
    assert done.stderr.count("no equilibrium found") == 1


def blocks():
    return re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.S)


@pytest.mark.parametrize("number", range(len(blocks())))
@pytest.mark.parametrize("ranks", [1, 2])
def test_scripts_of_the_readme(number, ranks, tmp_path):
    script = tmp_path / "script.py"
    script.write_text(blocks()[number])
    done = run(script, ranks=ranks, cwd=tmp_path)  # what they write stays there
    assert done.returncode == 0, done.stderr
    assert done.stdout


def test_reading_a_fabric_starts_no_finite_elements():
    """Names are loaded when used: what a script does not need is not imported."""
    code = (
        "import sys, shellform, meshes, contact; shellform.Fabric; meshes.rectangle(1, 1, (2, 2));"
        "print([m for m in ('dolfinx', 'petsc4py', 'gmsh', 'meshio', 'matplotlib') "
        "if m in sys.modules])"
    )
    done = run("-c", code)
    assert done.stdout.strip() == "[]", done.stderr


@pytest.mark.parametrize(("ranks", "model"), [(1, "shell"), (2, "shell"), (1, "particles")])
def test_drape(ranks, model, tmp_path):
    """Weight is shared between body and pin; the books close; files are there."""
    small = ("--cells", 10, "--seconds", 1.5, "--frames", 6, "--window", 0.25, "--drag", 6)
    done = run("demos/drape.py", *small, "--model", model, "--out", tmp_path, ranks=ranks)
    assert done.returncode == 0, done.stderr
    summary = json.loads((tmp_path / "summary.json").read_text())
    results = summary["results"]
    weight = results["weight"]
    assert weight == pytest.approx(0.2 * 9.81, rel=1e-12)
    header, *rows = (tmp_path / "ledger.csv").read_text().splitlines()
    assert len(rows) == 6
    assert {len(row.split(",")) for row in rows} == {len(header.split(","))}
    # it still swings: what moves is counted, drag takes at most its rate times the momentum, which
    # a kinetic energy K bounds by sqrt(2 m K)
    kinetic = max(float(row.split(",")[header.split(",").index("kinetic")]) for row in rows[-2:])
    drag = 6 * np.sqrt(2 * weight / 9.81 * kinetic)
    assert drag < 0.05 * weight
    up = np.array([0.0, 0.0, weight])
    forces = (results[name] for name in ("contact_force", "pin_force", "inertia_force"))
    contact, pin, inertia = (np.array(force) for force in forces)
    assert np.linalg.norm(contact + pin - inertia - up) < drag
    assert results["momentum_residual"] < 1e-10 * weight
    assert results["max_penetration"] < 1e-9
    assert summary["plan"]["contact"] == ["body"]
    assert summary["seconds"]["contact"] > 0
    assert (tmp_path / "drape.png").read_bytes()[:4] == b"\x89PNG"
    assert (tmp_path / "drape.gif").read_bytes()[:3] == b"GIF"


@pytest.mark.parametrize("ranks", [1, 2])
def test_relaxed_drape_shows_its_wrinkles(ranks, tmp_path):
    short = ("--cells", 8, "--seconds", 0.3, "--frames", 4, "--wrinkles", "relaxed")
    done = run("demos/drape.py", *short, "--out", tmp_path, ranks=ranks)
    assert done.returncode == 0, done.stderr
    assert "wrinkles.png" in done.stdout
    assert (tmp_path / "wrinkles.png").read_bytes()[:4] == b"\x89PNG"
    assert json.loads((tmp_path / "summary.json").read_text())["plan"]["wrinkles"] == "relaxed"
    refused = run("demos/drape.py", *short, "--membrane", "chords", "--out", tmp_path, ranks=ranks)
    assert refused.returncode != 0 and "wrinkles='relaxed' goes with" in refused.stderr


def test_drape_refuses_a_step_beyond_the_stable_one(tmp_path):
    done = run("demos/drape.py", "--cells", 4, "--time-step-factor", 1.5, "--out", tmp_path)
    assert done.returncode == 2
    assert "a part of the largest stable one" in done.stderr
    assert "Traceback" not in done.stderr


def test_drape_is_the_same_on_any_number_of_ranks(tmp_path):
    """Over the first few hundred steps, before a fold may choose its side by roundoff."""
    heights = []
    for ranks in (1, 2, 3):
        out = tmp_path / str(ranks)
        short = ("--cells", 10, "--seconds", 0.12, "--frames", 2, "--window", 0.06, "--out", out)
        assert run("demos/drape.py", *short, ranks=ranks).returncode == 0
        heights.append(json.loads((out / "summary.json").read_text())["results"])
    for other in heights[1:]:
        assert other["mean_height"] == pytest.approx(heights[0]["mean_height"], rel=1e-9)
        assert other["contact_force"] == pytest.approx(heights[0]["contact_force"], rel=1e-7)
        assert other["free_corner"] == pytest.approx(heights[0]["free_corner"], rel=1e-9)


def test_profile_of_a_step(tmp_path):
    """Parts add up to the whole; what a step moves is at least its fields."""
    done = run(
        "-m",
        "demos.studies.performance.profile_step",
        "--cells",
        8,
        "--seconds",
        0.05,
        "--out",
        tmp_path,
    )
    assert done.returncode == 0, done.stderr
    results = json.loads((tmp_path / "summary.json").read_text())["results"]
    for found in results["columns"].values():
        whole = found.pop("all")
        assert sum(found.values()) == pytest.approx(whole, rel=1e-9)
        assert found["internal force"] > 0 and found["contact"] > 0
    assert results["bytes_a_node"] > 3 * 48 and results["bytes_a_second"] > 1e8
    assert done.stdout.splitlines()[0].count("|") == 2 + len(results["columns"])


def test_start_of_a_demo(tmp_path):
    """Less time than the whole run, which is not made: nothing but the table is printed."""
    done = run("-m", "demos.studies.performance.start_up", "--demo", "roll_up", "--out", tmp_path)
    assert done.returncode == 0, done.stderr
    found = json.loads((tmp_path / "summary.json").read_text())
    # the shorter of two starts, both of them in the total
    assert 0 < found["results"]["roll_up"]["warm"] < found["seconds"]["total"] / 2
    assert len(done.stdout.splitlines()) == 3
