# SPDX-License-Identifier: LGPL-3.0-or-later
"""A dressed wearer performs the recorded motion: Sec. 4.2 of the paper, Figs. 7, 8 and 10.

`run` dresses the wearer, plays the motion, and leaves torque.csv, ledger.csv, a series of frames,
summary.json and a checkpoint; `resume` goes on from the checkpoint of a run that was stopped. One
run is one start; ensemble.py runs several. Both are three steps: `_set_up`, `_play`, which keeps
checkpoints, and `_write_results`.
"""

import json
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from mpi4py import MPI

import numpy as np

from shellform.console import progress
from shellform.dressing.fit import stretch_warning
from shellform.dressing.saved_state import save
from shellform.dynamics import checkpoint
from shellform.dynamics.explicit import Newmark
from shellform.errors import Stopped, Unstable
from shellform.motion.gait.strides import counted
from shellform.results import pressure_map
from shellform.results.report import Report
from shellform.results.series import Series
from shellform.scene.scene import Scene
from shellform.scene.scene_file import as_scene, read_scene, write_scene

from .interrupt import Interrupt
from .model import Model
from .motion_lines import motion_lines
from .prediction import accuracy_entry, prediction_lines, tricks
from .recorders import Recorders, dressing_watcher, write_frame
from .summary import describe, settings, summary


@dataclass
class Walk:
    """A dressed wearer under way.

    out : folder of the files; report, series, recorders : what is written there
    fit : report of the dressing; windows : ends [s] of those between records
    done : how many of them are over; watch : function of (stage, model) or None
    """

    model: Model
    out: Path
    report: Report
    series: Series
    recorders: Recorders
    fit: dict
    windows: np.ndarray
    done: int = 0
    watch: Callable | None = None


def run(
    scene: Scene | str | Path,
    out: str | Path,
    comm: MPI.Comm = MPI.COMM_WORLD,
    dressed: str | Path | None = None,
    watch: Callable | None = None,
    lines: bool = True,
) -> dict:
    """Dress, play the motion, leave files in the folder `out`; returns the results.

    Parameters
    ----------
    scene : Scene, or its file; out : path; comm : MPI communicator
    dressed : file of a dressed state (`OUT/dressed.npz` of a run of the same garment and wearer),
        which is then not made anew
    watch : function of (stage, model), called at every frame while dressing and walking
    lines : whether rank 0 prints what was read of a capture, and what is predicted of errors and
        time

    Raises
    ------
    Stopped after Ctrl-C, with a checkpoint in `out`; ValueError, Unstable as the parts do

    Examples
    --------
    >>> import shellform as sf
    >>> scene = sf.Scene(fabric="compliant", belt=20.0)
    >>> results = run(scene, "out/walk")  # doctest: +SKIP
    >>> results["joints"]["right_knee"]["peak_torque"]  # doctest: +SKIP
    """
    scene, out = as_scene(scene), Path(out)
    report, model = _set_up(scene, out, comm)
    # only now, as a scene that does not stand must not cost the files of another run
    if comm.rank == 0:
        for name in ("checkpoint.npz", "summary.json"):
            (out / name).unlink(missing_ok=True)
        write_scene(scene, out / "scene.toml")
        if lines:
            told = [] if scene.motion.file == "synthetic" else motion_lines(model)
            told += model.surface.notes
            print("\n".join([*told, *prediction_lines(model)]), flush=True)
    series = Series(out)
    with report.stage("solve"), Interrupt(model.comm) as interrupt:
        if dressed is None:
            look = dressing_watcher(model, out, watch)
            fit = model.dress(_stopping(look, interrupt))
        else:
            fit = model.put_on(dressed)
        save(out / "dressed.npz", model.stepper, model.wearer)
        if interrupt.asked():
            raise Stopped(
                f"stopped after dressing; go on with: shellform run {out}/scene.toml --out {out} "
                f"--dressed {out}/dressed.npz"
            )
    if comm.rank == 0 and not fit["settled"]:
        print(f"not settled after dressing: the cloth moves with {fit['speed']:.3g} m/s")
    stretched = stretch_warning(fit["stretch"], scene.garment.max_elongation, model.surface.source)
    if stretched and comm.rank == 0:
        print(stretched, flush=True)
    model.contact.reset()
    write_frame(model, series, np.zeros(3))
    recorders = Recorders(model, out)
    walk = Walk(model, out, report, series, recorders, fit, _windows(model), watch=watch)
    return _finish(walk)


def resume(out: str | Path, comm: MPI.Comm = MPI.COMM_WORLD, watch: Callable | None = None) -> dict:
    """Go on with a run from the checkpoint in its folder; returns the results.

    Raises
    ------
    ValueError where there is no checkpoint; as `run` does

    Examples
    --------
    >>> resume("out/nothing")
    Traceback (most recent call last):
    ValueError: out/nothing holds no checkpoint.npz: nothing has been computed, use `run`
    """
    out = Path(out)
    state = out / "checkpoint.npz"
    if not state.is_file():
        raise ValueError(f"{out} holds no checkpoint.npz: nothing has been computed, use `run`")
    report, model = _set_up(read_scene(out / "scene.toml"), out, comm)
    with np.load(state) as file:
        series = Series(out, until=float(file["clock"][0]))
    model.lay_belt()
    resumed = checkpoint.load(state, model.stepper)
    recorders = Recorders(model, out, resumed)
    fit, done = json.loads(str(resumed["fit"])), int(resumed["done"])
    return _finish(Walk(model, out, report, series, recorders, fit, _windows(model), done, watch))


def _set_up(scene: Scene, out: Path, comm: MPI.Comm) -> tuple[Report, Model]:
    """The model of a scene, and the report that says what is in it."""
    report = Report(out, "walk", settings(scene), comm)
    with report.stage("setup"):
        model = Model(scene, comm)
        describe(report, model)
    return report, model


def _stopping(look: Callable, interrupt: Interrupt) -> Callable:
    """Watcher of the dressing that ends it on all ranks after Ctrl-C."""

    def look_and_ask(stage: str, stepper: Newmark) -> None:
        look(stage, stepper)
        if interrupt.asked():
            raise Stopped("stopped while dressing, of which nothing is kept: run the scene again")

    return look_and_ask


def _windows(model: Model) -> np.ndarray:
    """Times [s] at which rows are recorded; a window begins, and one ends, with what counts."""
    wearer, ends = model.wearer, []
    edges = [wearer.start, *counted(wearer), wearer.end]
    for begin, end in pairwise(edges):
        if end - begin > 1e-9:
            count = max(1, round((end - begin) / model.scene.output.window))
            ends.append(np.linspace(begin, end, count + 1)[1:])
    return np.concatenate(ends)


def _finish(walk: Walk) -> dict:
    _play(walk)
    return _write_results(walk)


def _play(walk: Walk) -> None:
    """Step through the windows that are left, with records, frames and checkpoints."""
    model, output, report = walk.model, walk.model.scene.output, walk.report
    between = max(1, round(output.checkpoint / output.window))
    picture = max(1, round(1 / (output.frames * output.window)))
    last = len(walk.windows)
    with Interrupt(model.comm) as interrupt:
        for time in progress(walk.windows[walk.done :], last - walk.done, "walk"):
            with report.stage("solve"):
                try:
                    model.stepper.advance(time)
                except Unstable:
                    _save_checkpoint(walk)  # the last good state, to which the steps have gone back
                    raise
            walk.done += 1
            with report.stage("output"):
                force = walk.recorders.record(time)
                if walk.done % picture == 0 or walk.done == last:
                    write_frame(model, walk.series, force)
                    if walk.watch:
                        walk.watch("walk", model)
                asked = interrupt.asked()
                if asked or walk.done % between == 0 or walk.done == last:
                    _save_checkpoint(walk)
            if asked and walk.done < last:
                raise Stopped(
                    f"stopped at t = {time:.3f} s of {model.wearer.end:.3f} s; go on with: "
                    f"shellform resume {walk.out}"
                )


def _save_checkpoint(walk: Walk) -> None:
    """The state of the stepper and its parts, for `resume`; all ranks call."""
    more = {"fit": json.dumps(walk.fit), "done": walk.done}
    checkpoint.save(walk.out / "checkpoint.npz", walk.model.stepper, more)


def _write_results(walk: Walk) -> dict:
    """summary.json, and maps of pressure where they were asked for; returns the results."""
    model, report, recorders = walk.model, walk.report, walk.recorders
    report.shift(model.contact.seconds, "solve", "contact")
    results = summary(model, recorders, walk.fit)
    if recorders.pressure is not None:
        found = recorders.pressure.result()
        results["pressure"] = pressure_map.summary(found)
        if model.comm.rank == 0:
            pressure_map.save(walk.out / "pressure.npz", found)
            if isinstance(found, pressure_map.VertexPressure):
                pressure_map.write(walk.out / "pressure.vtu", found)
    report.write(
        results,
        steps=model.stepper.steps,
        newton_iterations=0,
        time_step=model.stepper.dt,
        accuracy=accuracy_entry(model),
        tricks=tricks(model.scene),
    )
    return results
