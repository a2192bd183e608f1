# SPDX-License-Identifier: LGPL-3.0-or-later
"""A scene run from several starts, and the mean of what they tell, with its band.

`run` plays all runs of the ensemble (members.py) and leaves, beside the files of run 0 in the
folder, torque_mean.csv, stride_mean.csv where strides are alike, and in summary.json the numbers of
the mean torque (results/mean_torque.py) in place of those of run 0. `resume` plays what is missing.
Force balance, depths, pressure and frames are those of run 0.
"""

import json
from collections.abc import Callable, Sequence
from itertools import takewhile
from pathlib import Path
from typing import Any

from mpi4py import MPI

from shellform.motion.gait.like_strides import alike
from shellform.motion.gait.strides import counted, side_of, strides
from shellform.motion.recording import SIDES, Recording
from shellform.results.comparison import compare
from shellform.results.files import write_atomically
from shellform.results.mean_torque import (
    Course,
    joint_numbers,
    on_strides,
    read_courses,
    write_mean_strides,
    write_mean_torque,
)
from shellform.scene.garment import garment_of
from shellform.scene.scene import Scene
from shellform.scene.scene_file import as_scene, read_scene
from shellform.scene.wearer import wearer_of

from .members import APART, Member, members_of, play_all
from .summary import summary_of

MEAN = ("torque_mean.csv", "stride_mean.csv")


def run(
    scene: Scene | str | Path,
    out: str | Path,
    comm: MPI.Comm = MPI.COMM_WORLD,
    dressed: str | Path | None = None,
    watch: Callable | None = None,
) -> dict:
    """Run a scene from as many starts as its accuracy needs; returns the results.

    Parameters
    ----------
    scene : Scene, or its file; out : path; comm : MPI communicator
    dressed, watch : see `simulation.run.run`; `watch` sees run 0

    Raises
    ------
    as `simulation.run.run`; runs that are complete stay, and `resume` computes the others

    Examples
    --------
    >>> import shellform as sf
    >>> scene = sf.Scene(fabric="compliant", belt=20.0)
    >>> results = sf.run(scene, "out/walk")  # doctest: +SKIP
    >>> knee = results["joints"]["right_knee"]  # doctest: +SKIP
    >>> knee["peak_torque"], knee["peak_torque_error"], knee["runs"]  # doctest: +SKIP
    """
    return run_all([(as_scene(scene), Path(out))], comm, dressed, watch)[0]


def run_all(
    scenes: Sequence[tuple[Scene, Path]],
    comm: MPI.Comm = MPI.COMM_WORLD,
    dressed: str | Path | None = None,
    watch: Callable | None = None,
) -> list[dict]:
    """Run several scenes, each in its folder, their runs side by side; see `run`."""
    ensembles = [members_of(scene, out, dressed) for scene, out in scenes]
    several = sum(map(len, ensembles)) > 1
    for members in ensembles if several else ():
        # a scene that does not stand must not cost the files of another run
        scene = members[0].scene
        garment_of(scene, wearer_of(scene))
    if comm.rank == 0:
        for members in ensembles:
            _clear(members)
    comm.Barrier()
    play_all(_in_turn(ensembles), comm, watch)
    return [_tell(members, comm) for members in ensembles]


def resume(out: str | Path, comm: MPI.Comm = MPI.COMM_WORLD, watch: Callable | None = None) -> dict:
    """Compute what is missing of the runs in a folder; returns the results.

    Raises
    ------
    ValueError where nothing has been computed; as `run` does

    Examples
    --------
    >>> import shellform as sf
    >>> sf.resume("out/nothing")
    Traceback (most recent call last):
    ValueError: out/nothing holds no checkpoint.npz: nothing has been computed, use `run`
    """
    out = Path(out)
    members = members_of(read_scene(out / "scene.toml"), out) if _has_scene(out) else []
    if not any(member.begun or member.complete for member in members):
        raise ValueError(f"{out} holds no checkpoint.npz: nothing has been computed, use `run`")
    comm.Barrier()
    play_all(members, comm, watch)
    return _tell(members, comm)


def _has_scene(out):
    return (out / "scene.toml").is_file()


def _in_turn(ensembles):
    """Runs of all ensembles: the first of each, the second of each, ..."""
    most = max(map(len, ensembles))
    return [members[k] for k in range(most) for members in ensembles if k < len(members)]


def _clear(members):
    """Remove what tells that runs are complete or begun."""
    out = members[0].out
    for member in members:
        for name in ("checkpoint.npz", "summary.json"):
            (member.out / name).unlink(missing_ok=True)
    for name in MEAN:
        (out / name).unlink(missing_ok=True)


def _tell(members: Sequence[Member], comm: MPI.Comm) -> dict:
    """Files of the mean torque and summary.json, by rank 0; the results on all ranks."""
    comm.Barrier()
    fault, results = None, {}
    if comm.rank == 0:
        try:
            results = _write(members)
        except (ValueError, OSError) as error:
            fault = str(error)
    fault, results = comm.bcast((fault, results))
    if fault:
        raise ValueError(fault)
    return results


def _write(members):
    """Write the means of an ensemble whose runs are complete; returns its results."""
    out, recording = members[0].out, wearer_of(members[0].scene).recording
    start = float(recording.times[0])
    courses = read_courses([member.out / "torque.csv" for member in members], start)
    joints, curves = numbers(courses, recording)
    summary = summary_of(out)
    summary["results"] |= {"joints": joints, "counted_s": counted(recording)}
    summary["runs"] = {
        "count": len(members),
        "starts_apart": APART,
        "folders": [str(member.out.relative_to(out)) for member in members],
    }
    if len(members) > 1:
        write_mean_torque(out / MEAN[0], courses)
    if curves:
        write_mean_strides(out / MEAN[1], curves)
    write_atomically(out / "summary.json", json.dumps(summary, indent=2) + "\n")
    return summary["results"]


def compare_runs(one: str | Path, other: str | Path) -> dict[str, dict]:
    """Differences of the joint torques of two ensembles, by their folders.

    Returns
    -------
    dict, joint -> see `results.comparison.differences`

    Raises
    ------
    ValueError for a folder without a run that is complete

    Examples
    --------
    >>> compare_runs("out/nothing", "out/walk")
    Traceback (most recent call last):
    ValueError: out/nothing holds no complete run: compute it with `shellform run`
    """
    return compare(*(counted_courses(folder) for folder in (one, other)))


def complete_of(out: str | Path) -> list[Member]:
    """Runs in the folder of an ensemble, up to the first that is not complete.

    Raises
    ------
    ValueError where run 0 is not complete
    """
    out = Path(out)
    members = members_of(read_scene(out / "scene.toml"), out) if _has_scene(out) else []
    complete = list(takewhile(lambda member: member.complete, members))
    if not complete:
        raise ValueError(f"{out} holds no complete run: compute it with `shellform run`")
    return complete


def counted_courses(out: str | Path) -> dict[str, Course]:
    """Courses of all joints in the folder of an ensemble, over what counts of its motion.

    Raises
    ------
    ValueError where run 0 is not complete; runs from the first that is not are left out
    """
    members = complete_of(out)
    recording = wearer_of(members[0].scene).recording
    files = [member.out / "torque.csv" for member in members]
    courses = read_courses(files, float(recording.times[0]))
    window = counted(recording)
    return {joint: course.within(*window) for joint, course in courses.items()}


def numbers(courses: dict[str, Course], recording: Recording) -> tuple[dict[str, Any], dict]:
    """Numbers of all joints, and curves (n, 101) of the mean strides of each run, by joint."""
    window, found = counted(recording), strides(recording)
    like = {side: alike(recording, found[side]) for side in SIDES}
    joints, curves = {}, {}
    for joint, course in courses.items():
        side = side_of(joint)
        own = found[side]
        joints[joint] = joint_numbers(course, window, own, like[side])
        if len(like[side]) > 1:
            curves[joint] = on_strides(course, course.torque, own[like[side]]).mean(axis=1)
    return joints, curves
