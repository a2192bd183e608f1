# SPDX-License-Identifier: LGPL-3.0-or-later
"""A dressed wearer performs the recorded motion: Sec. 4.2 of the paper, Figs. 7, 8 and 10.

`run` dresses the wearer, plays the motion, and leaves torque.csv, ledger.csv, a series of frames,
summary.json and a checkpoint; `resume` goes on from the checkpoint of a run that was stopped.
"""

import json
import signal
from pathlib import Path

import numpy as np

from . import build, checkpoint, command, dressed_state, torque, trade
from .account import STAGES, describe, settings, summary
from .belt import Belt
from .dressing import Dressing, dress, settle
from .errors import Stopped, Unstable
from .ledger import Ledger
from .newmark import Newmark
from .reach import reach_of
from .results import Report, Series
from .scene_file import read_scene, write_scene
from .shell import Shell
from .touch import Touch


class Activity:
    """A scene ready to be stepped.

    Parameters
    ----------
    scene : Scene; comm : MPI communicator

    Attributes
    ----------
    wearer : Wearer of those ellipsoids that the garment can come to
    surface, shell, stepper, touch : see build.py, Shell, Newmark, Touch
    whole : Wearer of all of them
    """

    def __init__(self, scene, comm):
        self.scene, self.comm = scene, comm
        self.whole = build.wearer_of(scene)
        self.surface = build.garment_of(scene, self.whole)
        self.wearer = build.dressed_wearer(scene, self.whole, self.surface)
        fabric = build.fabric(scene)
        self.shell = Shell(self.surface, fabric, comm)
        if scene.gravity:
            self.shell.loads.gravity((0.0, 0.0, -scene.gravity))
        steps = scene.steps
        self.stepper = Newmark(
            self.shell, steps.time_step_factor, damping=steps.damping, drag=steps.drag
        )
        self.stepper.strain_energy()
        self.touch = self._touch(self.stepper)

    def _touch(self, stepper):
        contact, owned = self.scene.contact, self.shell.partition.owned_nodes
        friction = contact.friction
        if contact.kinetic_friction is not None:
            friction = (friction, contact.kinetic_friction)
        soft = {"flesh_stiffness": contact.flesh_stiffness}
        touch = Touch(stepper, self.wearer, friction, contact.offset, **soft)
        touch.correction.allowed[:] = reach_of(self.surface, self.wearer)[owned]
        return touch

    @property
    def weight(self):
        """Weight of the garment [N]."""
        return self.comm.allreduce(self.stepper.mass.sum()) * self.scene.gravity

    def dress(self, watch=None):
        """Put the garment on; returns the report of `dressing.dress`."""
        tension = self.scene.belt
        if self.scene.steps.dressing == "shell":
            self.belt, report = dress(self.stepper, self.touch, tension, watch=watch)
            return report
        from .particles import Particles, hand_over

        steps = self.scene.steps
        particles = Particles(self.shell, steps.time_step_factor, drag=steps.drag)
        touch = self._touch(particles)
        _, report = dress(particles, touch, tension, watch=watch)
        hand_over(particles, self.stepper, touch, self.touch)
        # the shell bends where springs do not: it settles once more
        plan = Dressing()
        self.belt = Belt(self.stepper, "waist", tension)
        self.stepper.time = self.wearer.start - plan.settle
        self.stepper.advance(self.stepper.time + 0.1)
        again = settle(self.stepper, self.touch, self.belt, plan, lambda *_: None)
        self.stepper.drag = steps.drag
        return again | {"seconds": report["seconds"] + 0.1 + again["seconds"]}


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
    Stopped after Ctrl-C, with a checkpoint in `out`; ValueError, Unstable as the parts do
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
        print("\n".join(trade.foretold(activity)), flush=True)
    series = Series(out)
    with report.stage("solve"):
        if dressed is None:
            fit = activity.dress(_pictured(activity, out, watch))
        else:
            fit = dressed_state.wear(activity, dressed)
        dressed_state.save(out / "dressed.npz", activity)
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
        _frame(activity, series, np.zeros(3))
    else:
        activity.belt = Belt(stepper, "waist", scene.belt)
        resumed = checkpoint.load(state, stepper, touch)
        fit, done = json.loads(str(resumed["fit"])), int(resumed["done"])
    joints = torque.Torque(touch, stepper, scene.output.parts, out / "torque.csv", resumed)
    ledger = Ledger(out / "ledger.csv", stepper, touch, resumed)
    extremes = Extremes(touch, stepper, resumed)
    skin = None
    if scene.output.pressure:
        from . import pressure

        skin = pressure.Pressure(touch, stepper, scene.output.pressure, resumed)
    between = max(1, round(scene.output.checkpoint / scene.output.window))
    picture = max(1, round(1 / (scene.output.frames * scene.output.window)))

    def keep(done):
        parts = [joints.saved(), ledger.saved(), extremes.saved(), skin.saved() if skin else {}]
        more = {"fit": json.dumps(fit), "done": done}
        for part in parts:
            more |= part
        checkpoint.save(out / "checkpoint.npz", stepper, touch, more)

    with Interrupt(comm) as interrupt:
        bar = command.progress(times[done:], count - done, "walk")
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
                    _frame(activity, series, impulse)
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
        accuracy=trade.entry(activity), tricks=trade.tricks(scene),
    )  # fmt: skip
    return results


def _frame(activity, series, force):
    """Write a frame with the contact force [N] on the cloth and its pressure [Pa]."""
    stepper, shell = activity.stepper, activity.shell
    gather = shell.partition.gather
    size = np.linalg.norm(force, axis=-1) * np.ones(stepper.n_owned)
    area = stepper.mass / shell.fabric.areal_mass
    data = np.column_stack([np.broadcast_to(force, (stepper.n_owned, 3)), size / area])
    whole = gather(data, root=0)
    fields = {}
    if whole is not None:
        fields = {"contact_force": whole[:, :3], "contact_pressure": whole[:, 3]}
    series.write(shell, stepper.time, **fields)


def _pictured(activity, out, watch):
    """Watcher of the dressing that writes a frame of each of its STAGES."""
    series, seen = Series(out, "dressing"), set()

    def look(stage, stepper):
        if watch:
            watch(stage, activity)
        halfway = stage != "pull" or abs(stepper.owned[:, 2]).max(initial=0.0) < 0.5
        if stage in STAGES and stage not in seen and activity.comm.allreduce(int(not halfway)) == 0:
            seen.add(stage)
            series.write(activity.shell, stepper.time)

    return look


class Extremes:
    """Hook: deepest start of a step inside the body, most pinched nodes, how deep they were.

    Parameters
    ----------
    touch : Touch; stepper : Newmark; resumed : state of a checkpoint or None
    """

    def __init__(self, touch, stepper, resumed=None):
        self.correction, self._comm = touch.correction, stepper.shell.comm
        self.values = np.zeros(3) if resumed is None else resumed["extremes"].copy()
        stepper.hooks.append(self)

    def __call__(self, stepper, dt):
        now = self.correction
        self.values[0] = max(self.values[0], now.max_depth)
        self.values[1] = max(self.values[1], now.pinched)
        self.values[2] = max(self.values[2], now.pinch_depth)

    def state(self):
        """Values on this rank, for `restore` (a copy)."""
        return self.values.copy()

    def restore(self, state):
        """Continue from `state()`."""
        self.values[:] = state

    def saved(self):
        """Largest values over all ranks, for `resumed`."""
        return {"extremes": np.max(self._comm.allgather(self.values), axis=0)}


class Interrupt:
    """Ctrl-C as a question to be asked between windows, the same answer on all ranks."""

    def __init__(self, comm):
        self.comm, self.pressed = comm, False

    def __enter__(self):
        self.before = signal.signal(signal.SIGINT, self._press)
        return self

    def __exit__(self, *_):
        signal.signal(signal.SIGINT, self.before)

    def _press(self, *_):
        self.pressed = True

    def asked(self):
        """True on all ranks once a rank has been interrupted."""
        return bool(self.comm.allreduce(int(self.pressed)))
