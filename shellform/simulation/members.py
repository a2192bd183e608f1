# SPDX-License-Identifier: LGPL-3.0-or-later
"""The runs of an ensemble: one scene from starts a thousandth apart, each run for itself.

Run 0 is the scene as it is and has the folder of the ensemble; run k has `run_k` in it, and its
belt is tighter or looser by a thousandth, two, ...: folds find another course, and nothing else
changes. A scene without a belt has its gravity changed so.

Runs exchange nothing. Ranks form one group a run, and without enough ranks the runs take turns.
One rank alone keeps the cores busy with further processes, each of one run (one_run.py; a process
that has started MPI must not be forked).
"""

import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from mpi4py import MPI

from shellform.errors import NotConverged, Stopped, Unstable
from shellform.scene.scene import Scene
from shellform.scene.scene_file import write_scene
from shellform.scene.shoulders import belt_of

from .run import resume, run

APART = 1e-3  # of the belt's tension, from start to start
STOPPED = 130  # exit code of a run that was interrupted
# what all ranks of a run raise together, and what therefore does not keep the others waiting
TOGETHER = (ValueError, NotConverged, Unstable, Stopped)
RANKS = ("OMPI_", "PMIX_", "PMI_", "PRTE_")  # what mpirun tells its ranks


class Member(NamedTuple):
    """A run of an ensemble.

    scene : of the run; out : its folder; home : folder of the ensemble
    dressed : file of a dressed state to start from, or None
    """

    scene: Scene
    out: Path
    home: Path
    dressed: str | Path | None = None

    @property
    def complete(self) -> bool:
        """Whether the run has ended; its summary is what it writes last."""
        return (self.out / "summary.json").is_file()

    @property
    def begun(self) -> bool:
        """Whether there is a checkpoint to go on from."""
        return (self.out / "checkpoint.npz").is_file()

    def play(self, comm: MPI.Comm, watch: Callable | None = None) -> None:
        """Run what is missing of it; ranks of `comm` call."""
        if self.complete:
            return
        if self.begun:
            resume(self.out, comm, watch)
        else:
            run(self.scene, self.out, comm, self.dressed, watch, lines=self.out == self.home)

    def words(self) -> list[str]:
        """Arguments of Python that do as `play`, once scene.toml is in `out`."""
        dressed = ["--dressed", str(self.dressed)] if self.dressed else []
        return ["-m", "shellform.simulation.one_run", str(self.out), *dressed]


def offset(k: int) -> int:
    """Steps of APART by which the start k is off: 0, 1, -1, 2, -2, ..."""
    return (k + 1) // 2 * (1 if k % 2 else -1)


def members_of(scene: Scene, out: str | Path, dressed: str | Path | None = None) -> list[Member]:
    """Runs of the ensemble of a scene.

    Raises
    ------
    ValueError for several runs of a scene with neither belt nor gravity
    """
    out, runs = Path(out), scene.runs
    first = replace(scene, steps=replace(scene.steps, runs=runs))
    held = belt_of(scene.belt, scene.garment)
    if runs > 1 and not held and not scene.gravity:
        raise ValueError(
            f"steps.runs = {runs}, and starts differ by their belt or their gravity, which both "
            "are 0: ask for 1 run"
        )
    members = [Member(first, out, out, dressed)]
    for k in range(1, runs):
        factor = 1 + APART * offset(k)
        belt, gravity = scene.belt, scene.gravity
        if held:
            belt *= factor
        else:
            gravity *= factor
        alone, title = replace(scene.steps, runs=1), f"{scene.title}, start {k}"
        other = replace(scene, steps=alone, title=title, belt=belt, gravity=gravity)
        members.append(Member(other, out / f"run_{k}", out, dressed))
    return members


def play_all(members: Sequence[Member], comm: MPI.Comm, watch: Callable | None = None) -> None:
    """Run what is missing of all runs; all ranks call.

    A run that fails does not end the others. `watch` sees the first run, where it is played here.

    Raises
    ------
    Stopped if one was interrupted, else the error of the first that failed; with the command that
    computes what is missing
    """
    if comm.size > 1:
        faults = _play_on_ranks(members, comm, watch)
    else:
        faults = _play_on_cores(members, comm, watch)
    if not faults:
        return
    k, fault = min(faults.items(), key=lambda item: (not isinstance(item[1], Stopped), item[0]))
    if len(members) == 1:
        raise fault
    done, home = sum(member.complete for member in members), members[k].home
    what = "stopped" if isinstance(fault, Stopped) else f"{members[k].out}: {fault};"
    raise type(fault)(
        f"{what} with {done} of {len(members)} runs complete; go on with: shellform resume {home}"
    )


def group_of(task: int, groups: int) -> int:
    """Group of ranks that plays a task: there and back again, as costs rise and fall in turns."""
    turn, place = divmod(task, groups)
    return groups - 1 - place if turn % 2 else place


def _play_on_ranks(members, comm, watch):
    """Play the runs on groups of ranks; faults by the number of the run, on all ranks."""
    groups = min(comm.size, len(members))
    mine = comm.rank % groups
    part = comm.Split(mine, comm.rank)
    faults = {}
    for k, member in enumerate(members):
        if group_of(k, groups) != mine:
            continue
        try:
            member.play(part, watch if k == 0 else None)
        except TOGETHER as fault:
            faults[k] = fault
            if isinstance(fault, Stopped):
                break
    # all files are there, and so are they for ranks of the other groups
    gathered = comm.allgather(faults)
    part.Free()
    return {k: fault for own in gathered for k, fault in own.items()}


def _play_on_cores(members, comm, watch):
    """Play the first run here, the others in processes beside it, one a core."""
    missing = [k for k, member in enumerate(members) if not member.complete]
    if not missing:
        return {}
    here, beside = missing[0], Processes(members)
    cores = len(os.sched_getaffinity(0))
    free = threading.Semaphore(max(0, cores - 1))
    faults = {}

    def play(k):
        with free:
            return beside.play(k)

    with ThreadPoolExecutor(max(1, len(missing))) as pool:
        futures = {k: pool.submit(play, k) for k in missing[1:]}
        try:
            try:
                members[here].play(comm, watch)
            except Stopped as fault:
                faults[here] = fault
                beside.stop()
            except TOGETHER as fault:
                faults[here] = fault
            free.release()
            found = {k: future.result() for k, future in futures.items()}
        except BaseException:
            # Ctrl-C while waiting, or an error of the program
            beside.stop()
            free.release()
            raise
    return faults | {k: fault for k, fault in found.items() if fault is not None}


class Processes:
    """Runs in processes of their own."""

    def __init__(self, members: Sequence[Member]) -> None:
        self._members = members
        self._running: dict[int, subprocess.Popen] = {}
        self._lock, self._stopped = threading.Lock(), False

    def play(self, k: int) -> Exception | None:
        """Play the run k; its fault, or None."""
        member = self._members[k]
        member.out.mkdir(parents=True, exist_ok=True)
        if not member.begun:
            write_scene(member.scene, member.out / "scene.toml")
        with self._lock:
            if self._stopped:
                return Stopped("not begun")
            process = subprocess.Popen(
                [sys.executable, *member.words()],
                stdout=subprocess.DEVNULL,
                stderr=subprocess.PIPE,
                text=True,
                errors="backslashreplace",
                env=environment(),
            )
            self._running[k] = process
        said = process.communicate()[1].strip()
        with self._lock:
            del self._running[k]
        if process.returncode == 0:
            return None
        lines = said.splitlines()
        what = lines[-1].removeprefix("one_run.py: ") if lines else f"exit {process.returncode}"
        return (Stopped if process.returncode == STOPPED else Unstable)(what)

    def stop(self) -> None:
        """Interrupt all that run, which leave their checkpoints, and begin no others."""
        with self._lock:
            self._stopped = True
            for process in self._running.values():
                process.send_signal(signal.SIGINT)


def environment() -> dict[str, str]:
    """Environment of a further process, which is no rank of ours, with one thread a run."""
    given = dict(os.environ)
    if "OMPI_COMM_WORLD_SIZE" in given or "PMI_SIZE" in given:
        allowed = "OMPI_ALLOW_RUN_AS_ROOT"
        given = {
            name: value
            for name, value in given.items()
            if not name.startswith(RANKS) or name.startswith(allowed)
        }
    return {"OMP_NUM_THREADS": "1"} | given
