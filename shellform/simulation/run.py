# SPDX-License-Identifier: LGPL-3.0-or-later
"""A dressed wearer performs the recorded motion: Sec. 4.2 of the paper, Figs. 7, 8 and 10.

`run` dresses the wearer, plays the motion, and leaves torque.csv, ledger.csv, a series of frames,
summary.json and a checkpoint; `resume` goes on from the checkpoint of a run that was stopped.
"""

import json
from pathlib import Path

import numpy as np

from shellform.accuracy.prediction import entry, foretold, tricks
from shellform.console import progress
from shellform.dressing.belt import Belt
from shellform.dressing.saved_state import save, wear
from shellform.dynamics import checkpoint
from shellform.errors import Stopped, Unstable
from shellform.results.joint_torque import Torque
from shellform.results.ledger import Ledger
from shellform.results.report import Report
from shellform.results.series import Series
from shellform.scene.scene_file import read_scene, write_scene

from .interrupt import Interrupt
from .model import Activity
from .recorders import Extremes, dressing_watcher, write_frame
from .summary import describe, settings, summary


def run(scene, out, comm, dressed=None, watch=None):
    """Dress, play the motion, leave files in the folder `out`; returns the results.

    Parameters
    ----------
    scene : Scene; out : path; comm : MPI communicator
    dressed : file of a dressed state (`OUT/dressed.npz` of a run of the same garment and wearer),
        which is then not made anew
    watch : function of (stage, activity), called at every frame while dressing and walking

    Raises
    ------
    command.Stopped after Ctrl-C, with a checkpoint in `out`; ValueError, Unstable as the parts do
    """
    out = Path(out)
    report = Report(out, "walk", settings(scene), comm)
    with report.stage("setup"):
        activity = Activity(scene, comm)
        describe(report, activity)
    # only now, as a scene that does not stand must not cost the files of another run
    if comm.rank == 0:
        (out / "checkpoint.npz").unlink(missing_ok=True)
        write_scene(scene, out / "scene.toml")
        print("\n".join(foretold(activity)), flush=True)
    series = Series(out)
    with report.stage("solve"):
        if dressed is None:
            fit = activity.dress(dressing_watcher(activity, out, watch))
        else:
            fit = wear(activity, dressed)
        save(out / "dressed.npz", activity)
    if comm.rank == 0 and not fit["settled"]:
        print(f"not settled after dressing: the cloth moves with {fit['speed']:.3g} m/s")
    return _play(activity, report, series, out, watch, fit=fit)


def resume(out, comm, watch=None):
    """Go on with a run from the checkpoint in its folder; returns the results."""
    out = Path(out)
    state = out / "checkpoint.npz"
    if not state.is_file():
        raise ValueError(f"{out} holds no checkpoint.npz: nothing has been computed, use `run`")
    scene = read_scene(out / "scene.toml")
    report = Report(out, "walk", settings(scene), comm)
    with report.stage("setup"):
        activity = Activity(scene, comm)
        describe(report, activity)
    with np.load(state) as file:
        series = Series(out, until=float(file["clock"][0]))
    return _play(activity, report, series, out, watch, state=state)


def _play(activity, report, series, out, watch, fit=None, state=None):
    """Step through the motion from the dressed state or from a checkpoint."""
    scene, wearer, comm = activity.scene, activity.wearer, activity.comm
    stepper, touch = activity.stepper, activity.touch
    count = max(1, round((wearer.end - wearer.start) / scene.output.window))
    times = np.linspace(wearer.start, wearer.end, count + 1)[1:]
    done, resumed = 0, None
    if state is None:
        touch.correction.reset()
        write_frame(activity, series, np.zeros(3))
    else:
        activity.belt = stepper.add(Belt("waist", scene.belt))
        resumed = checkpoint.load(state, stepper)
        fit, done = json.loads(str(resumed["fit"])), int(resumed["done"])
    joints = stepper.add(Torque(out / "torque.csv", scene.output.parts, resumed))
    ledger = stepper.add(Ledger(out / "ledger.csv", resumed))
    extremes = stepper.add(Extremes(resumed))
    skin = None
    if scene.output.pressure:
        from shellform.results import skin_pressure as pressure

        skin = stepper.add(pressure.Pressure(scene.output.pressure, resumed))
    between = max(1, round(scene.output.checkpoint / scene.output.window))
    picture = max(1, round(1 / (scene.output.frames * scene.output.window)))

    def keep(done):
        more = {"fit": json.dumps(fit), "done": done}
        checkpoint.save(out / "checkpoint.npz", stepper, more)

    with Interrupt(comm) as interrupt:
        bar = progress(times[done:], count - done, "walk")
        for k, time in enumerate(bar, start=done + 1):
            with report.stage("solve"):
                try:
                    stepper.advance(time)
                except Unstable:
                    keep(k - 1)  # the last good state, to which the steps have gone back
                    raise
            with report.stage("output"):
                joints.record(time)
                if skin:
                    skin.record(time)
                impulse = touch.correction.window.impulse / touch.correction.window.seconds
                ledger.record()
                if k % picture == 0 or k == count:
                    write_frame(activity, series, impulse)
                    if watch:
                        watch("walk", activity)
                asked = interrupt.asked()
                if asked or k % between == 0 or k == count:
                    keep(k)
            if asked and k < count:
                raise Stopped(
                    f"stopped at t = {time:.3f} s of {wearer.end:.3f} s; go on with: "
                    f"shellform resume {out}"
                )
    report.shift(touch.seconds, "solve", "contact")
    results = summary(activity, joints, ledger, extremes, fit)
    if skin:
        results["pressure"] = pressure.summary(skin.result())
        if comm.rank == 0:
            pressure.save(out / "pressure.npz", skin.result())
    report.write(
        results, steps=stepper.steps, newton_iterations=0, time_step=stepper.dt,
        accuracy=entry(activity), tricks=tricks(scene),
    )  # fmt: skip
    return results
