# SPDX-License-Identifier: LGPL-3.0-or-later
"""Ensembles: starts a thousandth apart, runs side by side, what is missing computed later."""

import json
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

from mpi4py import MPI

import numpy as np
import pytest

import shellform as sf
from shellform.__main__ import main
from shellform.errors import Unstable
from shellform.results.mean_torque import Course, mean_rows, read_courses
from shellform.scene.parts import Steps
from shellform.scene.scene_file import write_scene
from shellform.simulation import members
from shellform.simulation.ensemble import compare_runs, counted_courses, resume, run
from shellform.simulation.ensemble import numbers as numbers_of
from shellform.simulation.members import (
    APART,
    Member,
    Processes,
    group_of,
    members_of,
    offset,
    play_all,
)
from tests.dressing.test_dress import dressed
from tests.ranks import launch, needs_mpirun
from tests.simulation.short_walk import JOINTS, WALK

pytestmark = pytest.mark.serial
COMM = MPI.COMM_SELF
PATIENCE = 300  # seconds for a program that compiles first
THREE = replace(WALK, steps=replace(WALK.steps, runs=3))


def test_starts(tmp_path):
    """Run 0 is the scene itself; the others have a belt tighter and looser by thousandths."""
    assert [offset(k) for k in range(6)] == [0, 1, -1, 2, -2, 3]
    scene = sf.Scene(steps=Steps(runs=5))
    found = members_of(scene, tmp_path)
    assert found[0].scene == scene and found[0].out == tmp_path
    belts = [20.0 * (1 + APART * offset(k)) for k in range(5)]
    assert [member.scene.belt for member in found] == pytest.approx(belts)
    assert [member.out.name for member in found[1:]] == ["run_1", "run_2", "run_3", "run_4"]
    for member in found[1:]:
        same = replace(member.scene, belt=20.0, title="walk", steps=scene.steps)
        assert same == scene and member.scene.runs == 1
    loose = members_of(replace(scene, belt=0.0), tmp_path)
    assert loose[1].scene.gravity == pytest.approx(9.81 * 1.001) and loose[1].scene.belt == 0.0
    with pytest.raises(ValueError, match=r"steps\.runs = 5, .* both are 0: ask for 1 run"):
        members_of(replace(scene, belt=0.0, gravity=0.0), tmp_path)


def test_runs_by_the_accuracy():
    assert sf.Scene().runs == 3 and sf.Scene(steps=Steps(runs=1)).runs == 1
    with pytest.raises(ValueError, match=r"steps\.runs = 0 lies outside 1 to 1000"):
        sf.Scene(steps=Steps(runs=0))
    with pytest.raises(ValueError, match=r"steps\.runs is a whole number, not 2\.5"):
        sf.Scene(steps=Steps(runs=2.5))


@pytest.mark.parametrize(("tasks", "groups"), [(6, 2), (3, 2), (8, 3), (2, 2), (5, 1)])
def test_runs_are_shared_out(tasks, groups):
    """No group plays two runs more than another."""
    counts = np.bincount([group_of(k, groups) for k in range(tasks)], minlength=groups)
    assert counts.sum() == tasks and np.ptp(counts) <= 1


@pytest.fixture
def pretended(monkeypatch, tmp_path):
    """Ensemble of four whose runs only write their files; function to let some fail."""
    failing, played = {}, []

    def play(member, *_):
        k = int(member.out.name.removeprefix("run_")) if member.out != tmp_path else 0
        played.append(k)
        if k in failing:
            raise failing[k]
        member.out.mkdir(exist_ok=True)
        (member.out / "summary.json").write_text("{}")

    def beside(processes, k):
        try:
            play(processes._members[k])
        except Exception as fault:
            return fault
        return None

    monkeypatch.setattr(Member, "play", play)
    monkeypatch.setattr(members.Processes, "play", beside)
    return members_of(sf.Scene(steps=Steps(runs=4)), tmp_path), failing, played


@pytest.mark.parametrize("bad", [0, 2])
def test_a_failing_run_does_not_end_the_others(pretended, bad):
    """All others are played; afterwards what is missing alone."""
    runs, failing, played = pretended
    failing[bad] = Unstable("node 7 has left the finite numbers")
    with pytest.raises(Unstable, match=r"node 7 .* with 3 of 4 runs complete; go on with: "):
        play_all(runs, COMM)
    assert sorted(played) == [0, 1, 2, 3]
    assert [member.complete for member in runs] == [k != bad for k in range(4)]
    failing.clear()
    played.clear()
    play_all(runs, COMM)
    assert played == [bad]
    play_all(runs, COMM)
    assert played == [bad]


@pytest.fixture(scope="module")
def ensemble(tmp_path_factory):
    """Folder and results of three runs, from one dressed state."""
    out = tmp_path_factory.mktemp("ensemble")
    return out, run(THREE, out, COMM, dressed("compliant").path)


@pytest.mark.slow
def test_ensemble_of_a_short_walk(ensemble):
    """Numbers are those of its files; each run is what it would be alone."""
    out, results = ensemble
    files = [out / "torque.csv", out / "run_1/torque.csv", out / "run_2/torque.csv"]
    courses, rows = read_courses(files), mean_rows(out)
    assert list(results["joints"]) == JOINTS
    for joint, numbers in results["joints"].items():
        own = [row for row in rows if row["joint"] == joint]
        torque = courses[joint].torque
        assert [row["torque_flexion"] for row in own] == pytest.approx(torque.mean(axis=0))
        spread = torque.std(axis=0, ddof=1)
        assert [row["spread"] for row in own] == pytest.approx(spread, rel=1e-5, abs=1e-12)
        within = counted_courses(out)[joint]
        rms = np.sqrt(np.mean(within.torque**2, axis=1))
        assert numbers["runs"] == 3 and numbers["rms_torque"] == pytest.approx(rms.mean(), rel=1e-6)
        error = rms.std(ddof=1) / 3**0.5
        assert numbers["rms_torque_error"] == pytest.approx(error, rel=1e-4)
        assert abs(numbers["peak_torque"]) == pytest.approx(np.abs(within.torque.mean(0)).max())
        touched = numbers["peak_torque"] != 0.0  # the hem may hang free of a foot
        assert (numbers["peak_torque_error"] > 0) == (numbers["work_error"] > 0) == touched
        assert touched or joint.endswith("ankle")
    begin, end = results["counted_s"]
    assert within.times[0] > begin and within.times[-1] == pytest.approx(end)
    summary = json.loads((out / "summary.json").read_text())
    assert summary["results"]["joints"] == results["joints"]
    assert summary["runs"]["count"] == summary["plan"]["runs"] == 3
    assert summary["runs"]["folders"] == [".", "run_1", "run_2"]


@pytest.mark.slow
def test_a_process_plays_its_run_alone(ensemble, tmp_path):
    """The first of several too, whose scene asks for all: as the second ensemble of `run_all`."""
    first = members_of(THREE, tmp_path / "out", dressed("compliant").path)[0]
    fault = Processes([first._replace(dressed=tmp_path / "none.npz")]).play(0)
    assert "none.npz" in str(fault) and "one_run" not in str(fault) and not first.complete
    assert Processes([first]).play(0) is None
    assert not list(first.out.glob("run_*"))
    assert (first.out / "torque.csv").read_bytes() == (ensemble[0] / "torque.csv").read_bytes()


@pytest.mark.slow
def test_only_what_is_missing_is_computed(ensemble, tmp_path):
    """A run whose files are lost is computed again; the others are not touched."""
    out = Path(shutil.copytree(ensemble[0], tmp_path / "copy"))
    kept = (out / "run_1/torque.csv").stat().st_mtime_ns
    shutil.rmtree(out / "run_2")
    found = resume(out, COMM)
    assert (out / "run_1/torque.csv").stat().st_mtime_ns == kept
    assert found["joints"]["right_knee"]["runs"] == 3
    # dressed anew, as the state it started from is not among its files
    assert len(mean_rows(out)) == len(mean_rows(ensemble[0]))


@pytest.mark.slow
def test_equal_ensembles_do_not_differ(ensemble, capsys):
    out = ensemble[0]
    for numbers in compare_runs(out, out).values():
        assert not any(entry["differ"] for entry in numbers.values())
    main(["compare", str(out), str(out)])
    said = capsys.readouterr().out
    assert "3 pairs of runs" in said
    assert said.splitlines()[-1].startswith(f"{out} and {out} do not differ: in 3 pairs of runs")
    with pytest.raises(ValueError, match="run_7 holds no complete run"):
        compare_runs(out, out / "run_7")


@pytest.mark.thorough
@pytest.mark.slow
def test_interrupted_ensemble_goes_on(ensemble, tmp_path):
    """Ctrl-C to the program alone stops the processes beside it too, and leaves what they have."""
    write_scene(THREE, tmp_path / "scene.toml")
    out = tmp_path / "out"
    words = ["run", tmp_path / "scene.toml", "--out", out, "--dressed", dressed("compliant").path]
    words = [sys.executable, "-m", "shellform", *words, "--no-pictures"]
    program = subprocess.Popen([*map(str, words)], stderr=subprocess.PIPE, text=True)
    end = time.monotonic() + PATIENCE
    while not (out / "checkpoint.npz").is_file() and time.monotonic() < end:
        time.sleep(0.05)
    program.send_signal(signal.SIGINT)
    said = program.communicate(timeout=PATIENCE)[1]
    assert program.returncode == 130
    assert f"runs complete; go on with: shellform resume {out}" in said
    main(["resume", str(out), "--no-pictures"])
    # whoever had begun went on from the same dressed state; run 0 had
    assert (out / "torque.csv").read_bytes() == (ensemble[0] / "torque.csv").read_bytes()
    assert len(mean_rows(out)) == len(mean_rows(ensemble[0]))


@pytest.mark.thorough
@needs_mpirun
@pytest.mark.slow
def test_ensemble_on_two_ranks(ensemble, tmp_path):
    """A rank a run: each has the same bits as in a process of its own."""
    write_scene(THREE, tmp_path / "scene.toml")
    out = tmp_path / "out"
    words = ("run", tmp_path / "scene.toml", "--out", out, "--dressed", dressed("compliant").path)
    program = launch(2, "-m", "shellform", *words, "--no-pictures", timeout=PATIENCE)
    assert program.returncode == 0, program.stderr[-2000:]
    for name in ("torque.csv", "torque_mean.csv", "run_1/torque.csv", "run_2/torque.csv"):
        assert (out / name).read_bytes() == (ensemble[0] / name).read_bytes()


def test_joints_of_the_trunk_have_strides_too():
    """Those of the right foot; whoever has no arms has no such joints."""
    recording = sf.synthetic_walk(strides=2, obstacle=0.0)
    times = recording.times[1:]
    torque = np.array([np.sin(3.0 * times), np.sin(3.1 * times)])
    course = Course(times, np.diff(recording.times), torque, torque**2)
    joints, _ = numbers_of(
        dict.fromkeys(("lumbar", "right_elbow", "left_elbow"), course), recording
    )
    assert joints["lumbar"] == joints["right_elbow"]
    assert joints["left_elbow"]["rms_torque"] == joints["lumbar"]["rms_torque"] > 0.5
