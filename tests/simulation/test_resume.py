# SPDX-License-Identifier: LGPL-3.0-or-later
"""A dressed walk that is killed or stopped goes on as if it had not been."""

import json
import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from shellform.__main__ import main
from shellform.scene.scene_file import write_scene
from shellform.scene.wearer import wearer_of
from tests.dressing.test_dress import dressed
from tests.ranks import launch, needs_mpirun
from tests.simulation.short_walk import WALK, contact_forces, table, torques

PATIENCE = 300  # seconds for a program that compiles first


@pytest.fixture(scope="module")
def scene_file(tmp_path_factory):
    path = tmp_path_factory.mktemp("scenes") / "scene.toml"
    write_scene(WALK, path)
    return path


# a run that signals itself at a frame: when is not left to the speed of the machine
SIGNALLED = """
import os, signal, sys
from mpi4py import MPI
from shellform import console
from shellform.scene.scene_file import read_scene
from shellform.simulation.run import run

scene, out, dressed, name, needed = sys.argv[1:]

def look(stage, _):
    if stage == "walk" and os.path.exists(needed):
        os.kill(os.getpid(), getattr(signal, name))

console.run(lambda _: run(read_scene(scene), out, MPI.COMM_WORLD, dressed, look))
"""


def signalled(scene, out, name, needed):
    """A run that gets a signal at its first frame with a file there; the completed process."""
    words = [sys.executable, "-c", SIGNALLED, scene, out, dressed("compliant").path, name, needed]
    return subprocess.run([*map(str, words)], capture_output=True, text=True, timeout=PATIENCE)


@pytest.fixture(scope="module")
def killed(scene_file, tmp_path_factory):
    """Folder of a run that was killed some time after its first checkpoint."""
    out = tmp_path_factory.mktemp("killed")
    done = signalled(scene_file, out, "SIGKILL", out / "checkpoint.npz")
    assert done.returncode == -signal.SIGKILL and not (out / "summary.json").exists()
    return out


def copied(folder, to):
    return Path(shutil.copytree(folder, to / "copy"))


def same_as_uninterrupted(out, whole, bar=1e-6):
    """Torques of all windows, forces and frames of a run that was stopped and gone on with."""
    one, other = torques(whole), torques(out)
    off = np.abs(one - other).max() / np.abs(one).max()
    print(f"gone on with: torques differ by {off:.1e} of the largest")
    assert one.shape == other.shape and off <= bar
    rows, again = table(whole / "ledger.csv"), table(out / "ledger.csv")
    names = wearer_of(WALK).names
    forces, others = contact_forces(rows, names), contact_forces(again, names)
    assert np.abs(forces - others).max() <= bar * np.abs(forces).max()
    frames = [re.findall('timestep="(.*?)"', (f / "series.pvd").read_text()) for f in (whole, out)]
    assert frames[0] == frames[1]
    one, other = (json.loads((f / "summary.json").read_text())["results"] for f in (whole, out))
    assert set(one) == set(other) and one["dressing"] == other["dressing"]
    assert one["max_penetration"] == pytest.approx(other["max_penetration"], rel=bar)
    for joint, numbers in one["joints"].items():
        for key in ("peak_torque", "rms_torque", "work", "resistance"):
            assert other["joints"][joint][key] == pytest.approx(numbers[key], rel=1e-6, abs=bar)


@pytest.mark.serial
@pytest.mark.slow
def test_killed_run_goes_on(walked, killed, tmp_path):
    """As if it had not been killed; a run without pictures loads nothing that draws."""
    out = copied(killed, tmp_path)
    code = (
        "import sys\n"
        "from shellform import console\n"
        "from shellform.__main__ import main\n"
        "console.run(main, ['resume', sys.argv[1], '--no-pictures'])\n"
        "unasked = ['matplotlib', 'PIL', 'ezc3d', 'gmsh', 'shellform.pictures.walk']\n"
        "unasked += ['shellform.dynamics.mass_spring', 'shellform.dynamics.implicit']\n"
        "unasked += ['shellform.motion.capture.read_motion']\n"
        "print('unasked:', [name for name in unasked if name in sys.modules])\n"
    )
    words = [sys.executable, "-c", code, str(out)]
    done = subprocess.run(words, capture_output=True, text=True, timeout=PATIENCE)
    assert done.returncode == 0, done.stderr
    assert "unasked: []" in done.stdout
    assert "right_knee" in done.stdout and not list(out.glob("*.png"))
    same_as_uninterrupted(out, walked[0])
    # on one rank bit for bit, of a sheet that wrinkles
    assert json.loads((out / "summary.json").read_text())["plan"]["wrinkles"] == "relaxed"
    frames = sorted(path.relative_to(out) for path in out.glob("series/*.vtu"))
    assert len(frames) > 2
    for name in ("torque.csv", *frames):
        assert (out / name).read_bytes() == (walked[0] / name).read_bytes(), name


@pytest.mark.thorough
@needs_mpirun
@pytest.mark.serial
@pytest.mark.slow
def test_killed_run_goes_on_on_two_ranks(walked, killed, tmp_path):
    """Sums in another order: 1e-6 of the largest torque for 60 ms, then chaos."""
    out = copied(killed, tmp_path)
    with np.load(out / "checkpoint.npz") as state:
        done = int(state["done"])
    program = launch(2, "-m", "shellform", "resume", out, "--no-pictures", timeout=PATIENCE)
    assert program.returncode == 0, program.stderr[-2000:]
    one, two = torques(walked[0]), torques(out)
    off = np.abs(one - two).max(axis=(1, 2)) / np.abs(one).max()
    print("two ranks: windows differ by", *(f"{x:.0e}" for x in off[done:]))
    assert one.shape == two.shape
    assert np.array_equal(one[:done], two[:done])  # rows of the file
    assert off[done : done + 3].max() < 1e-6
    found = json.loads((out / "summary.json").read_text())
    assert found["ranks"] == 2 and found["results"]["force_balance_error"] < 1e-6


# a run on ranks of which one gets Ctrl-C, or all get what mpirun makes of it, at a stage
ON_RANKS = """
import os, signal, sys
from mpi4py import MPI
from shellform import console
from shellform.scene.scene_file import read_scene
from shellform.simulation.run import run

scene, out, dressed, stage, whom = sys.argv[1:]
seen = set()

def look(now, _):
    if now == stage and now not in seen and MPI.COMM_WORLD.rank == 1:
        number = signal.SIGINT if whom == "rank" else signal.SIGTERM
        for process in [os.getpid()] if whom == "rank" else PROCESSES:
            os.kill(process, number)
    seen.add(now)

PROCESSES = MPI.COMM_WORLD.allgather(os.getpid())
console.run(
    lambda _: run(read_scene(scene), out, dressed=None if stage == "pull" else dressed, watch=look)
)
"""


@needs_mpirun
@pytest.mark.serial
@pytest.mark.slow
@pytest.mark.parametrize("whom", ["rank", "all by mpirun"])
@pytest.mark.parametrize("stage", ["pull", pytest.param("walk", marks=pytest.mark.thorough)])
def test_stopped_on_ranks(stage, whom, scene_file, tmp_path):
    """Ctrl-C at one rank, or SIGTERM at all as mpirun sends it: one line, 130, what is kept."""
    words = ("-c", ON_RANKS, scene_file, tmp_path, dressed("compliant").path, stage, whom)
    done = launch(2, *words)
    assert done.returncode == 130, done.stderr
    kept = "nothing is kept" if stage == "pull" else f"go on with: shellform resume {tmp_path}"
    assert done.stderr.count(kept) == 1 and "Traceback" not in done.stderr
    assert (tmp_path / "checkpoint.npz").exists() == (stage == "walk")


@pytest.mark.serial
def test_sigterm_is_told_before_there_is_a_walk():
    script = (
        "import os, signal\n"
        "from shellform import console\n"
        "console.run(lambda _: os.kill(os.getpid(), signal.SIGTERM))\n"
    )
    done = launch(1, "-c", script)
    assert (done.returncode, done.stderr) == (130, "-c: interrupted\n")


@pytest.mark.serial
@pytest.mark.slow
def test_stopped_run_goes_on(walked, scene_file, tmp_path, capsys):
    """Ctrl-C ends a run with a sentence, a checkpoint and exit code 130; `resume` ends the rest."""
    out = tmp_path / "stopped"

    done = signalled(scene_file, out, "SIGINT", out / "torque.csv")
    assert done.returncode == 130
    said = done.stderr
    assert said.count("\n") == 1 and f"go on with: shellform resume {out}" in said
    assert (out / "checkpoint.npz").exists() and not (out / "summary.json").exists()
    main(["resume", str(out), "--no-pictures"])
    assert "torque.csv" in capsys.readouterr().out
    same_as_uninterrupted(out, walked[0])
