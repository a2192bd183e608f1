# SPDX-License-Identifier: LGPL-3.0-or-later
r"""Trousers on a walking wearer, and the torque they exert: the paper's Figs. 7, 8 and 10.

Objective. What do trousers demand of the joints, and how much more if they are stiff? The wearer is
dressed as in Fig. 7, walks four strides, the third over an obstacle of 0.5 m.

Equations. The body is ellipsoids posed by joint points (Eq. 17); cloth is a director shell (Eqs. 2
to 14) in explicit steps with contact (Eqs. 15 and 16); the torque about the joint J is

    tau_J = sum over AJ of (x_i - J) x f_i,

with f_i the contact force on the body at node i, AJ all of the body below the joint.

What is compared. Torque against time for compliant and for stiff cloth, with its peak, root mean
square and work over a stride, each the mean over several starts with its standard error; whether
the fabrics differ. Forces must balance weight and momentum in every window.

Source. The paper's Sec. 4.2; the synthetic walk is that of shellform/motion/gait.

    python demos/walk.py --out out/walk
    mpirun -n 2 python demos/walk.py                  # runs are shared out over the ranks
    python demos/walk.py --runs 1                     # one start, without a band
    python demos/walk.py --motion walk.c3d --fabric stiff
    python demos/walk.py --motion walk.trc --static standing.trc --start 1.2 --seconds 3.4

leaves report.html, walk.png, torque.png, pressure.png, walk.gif, summary.json and, where cloth
wrinkles below its cells, wrinkles.png in the folder, and a folder a fabric with torque_mean.csv,
torque.csv, ledger.csv, a series for ParaView, the dressed state and a checkpoint (`shellform
resume`), further starts in run_1, run_2, ...
"""

import argparse
from pathlib import Path

from shellform import console
from shellform.accuracy.choice import accuracy_line
from shellform.motion.capture.options import add_options, on_command_line, options_of
from shellform.results.comparison import comparison_lines
from shellform.results.mean_torque import mean_rows
from shellform.results.report import Report
from shellform.scene.parts import Contact, Garment, Motion, Output, Steps
from shellform.scene.scene import Scene
from shellform.scene.wearer import wearer_of
from shellform.simulation.ensemble import compare_runs, run_all
from shellform.simulation.error_study import estimate
from shellform.simulation.figures import dressing_frames
from shellform.simulation.summary import summary_lines, summary_of

COMM = console.COMM
JOINT = "right_knee"
WORDS = on_command_line(window="--start and --seconds")


def arguments(given):
    parser = argparse.ArgumentParser(
        allow_abbrev=False,
        description="Dress a walker in trousers; the torque they exert about the joints.",
        epilog="Options with one dash go to PETSc, as -shell_ts_monitor.",
    )
    positive = console.positive
    parser.add_argument(
        "--motion", default="synthetic", help="'synthetic' or C3D, TRC, CSV, BVH file"
    )
    add_options(parser, positive)
    parser.add_argument("--start", type=float, help="of the motion, s on its clock")
    parser.add_argument(
        "--fabric", nargs="+", default=["compliant", "stiff"], help="names of cards, or files"
    )
    parser.add_argument("--accuracy", default="draft", help="draft, standard, fine or N%%")
    parser.add_argument(
        "--estimate",
        action="store_true",
        help="other cells too, to estimate the error",
    )
    parser.add_argument("--obstacle", type=float, default=0.5, help="height, m; 0 for none")
    parser.add_argument(
        "--seconds", type=positive(float), help="end of the motion, s on its clock (default: all)"
    )
    parser.add_argument("--cell-size", type=positive(float), help="m (default: accuracy)")
    parser.add_argument(
        "--runs", type=positive(int), help="starts whose mean is reported (default: accuracy)"
    )
    parser.add_argument(
        "--wrinkles",
        choices=("relaxed", "resolved"),
        default="auto",
        help="those smaller than a cell: relaxed, or cells alone fold (default: by the cells)",
    )
    parser.add_argument("--belt", type=float, default=20.0, help="tension, N")
    parser.add_argument("--friction", type=float, default=0.3)
    parser.add_argument("--window", type=positive(float), default=0.02, help="of averages, s")
    parser.add_argument("--time-step-factor", type=positive(float), default=0.9)
    parser.add_argument("--frames", type=positive(float), default=15.0, help="pictures a second")
    parser.add_argument("--no-report", action="store_true", help="leave report.html out")
    parser.add_argument("--out", type=Path, default=Path("out/walk"), help="folder for results")
    return console.parse(parser, given)


def scene_of(options, fabric):
    """Scene of one fabric."""
    return Scene(
        fabric=fabric,
        motion=Motion(
            file=options.motion,
            start=options.start,
            end=options.seconds,
            obstacle=options.obstacle,
            **options_of(options),
        ),
        garment=Garment(cell_size=options.cell_size, wrinkles=options.wrinkles),
        steps=Steps(
            accuracy=options.accuracy,
            runs=options.runs,
            time_step_factor=options.time_step_factor,
        ),
        output=Output(window=options.window, frames=options.frames),
        contact=Contact(friction=options.friction),
        belt=options.belt,
        title=f"walk in {Path(fabric).stem} trousers",
    )


def walk_all(options, names, scenes):
    """Results by name; runs of all fabrics are shared out over the ranks."""
    folders = [options.out / name for name in names]
    results = run_all(list(zip(scenes, folders, strict=True)), COMM)
    for scene, folder in zip(scenes, folders, strict=True):
        if options.estimate:
            estimate(scene, folder, COMM)
    return dict(zip(names, results, strict=True))


def compare_all(options, names):
    """Differences of the fabrics from the first, by name."""
    first, *others = names
    return {other: compare_runs(options.out / other, options.out / first) for other in others}


def main(given=None):
    options = arguments(given)
    report = Report(options.out, "walk", vars(options), COMM)
    names = [Path(fabric).stem for fabric in options.fabric]
    scenes = [scene_of(options, fabric) for fabric in options.fabric]
    with report.stage("solve"):
        results = walk_all(options, names, scenes)
    summaries = [summary_of(options.out / name) for name in names]
    report.summary["comparison"] = compare_all(options, names)
    if COMM.rank == 0:
        with report.stage("output"):
            draw(options, names, scenes[0])
        for name, summary in zip(names, summaries, strict=True):
            print(f"\n{name} trousers")
            print("\n".join(summary_lines(results[name])))
            print(accuracy_line(summary["accuracy"]))
        for name, found in report.summary["comparison"].items():
            print("\n" + "\n".join(comparison_lines(found, name, names[0])))
    keys = ("cells", "nodes", "dofs", "plan", "accuracy", "tricks", "runs")
    report.summary |= {key: summaries[0][key] for key in keys}
    report.write(
        results[names[0]] | {"fabrics": results},
        steps=sum(summary["steps"] for summary in summaries),
        newton_iterations=0,
    )
    written = "walk.png, torque.png, pressure.png, wrinkles.png, walk.gif, summary.json"
    console.say([f"\nwrote {options.out}/{written}"])
    if COMM.rank == 0 and not options.no_report:
        print(report_line(options, names))


def report_line(options, names):
    """Write report.html of all fabrics; a line that says so, or why there is none."""
    # only here: rank 0 alone writes it, and its drawing library is an option
    from shellform.report import plotly_library
    from shellform.report.page import write_report

    if not plotly_library.is_there():
        return f"no report.html: {plotly_library.HOW}"
    folders = [options.out / name for name in names]
    return f"wrote {write_report(folders, options.out / 'report.html')}"


def draw(options, names, scene):
    """walk.png, torque.png, walk.gif, pressure.png and, of relaxed cloth, wrinkles.png."""
    # only here: rank 0 alone draws
    from shellform.pictures.skin_pressure import pressure_figure
    from shellform.pictures.walk import draw_all
    from shellform.pictures.wrinkles import draw_walk_wrinkles
    from shellform.results.pressure_map import load

    first = options.out / names[0]
    rows = {name: mean_rows(options.out / name) for name in names}
    title = f"Trousers of {names[0]} cloth; torque of the clothing on the wearer"
    dressing = dressing_frames(first)
    wearer = wearer_of(scene)
    draw_all(options.out, wearer, dressing, first, rows, JOINT, title)
    about = f"Wrinkles smaller than a cell, trousers of {names[0]} cloth"
    draw_walk_wrinkles(options.out / "wrinkles.png", wearer, first, about)
    skin = load(first / "pressure.npz")
    pressure_figure(
        options.out / "pressure.png", wearer, skin, wearer.start, f"{names[0]} trousers"
    )


if __name__ == "__main__":
    console.run(main, words=WORDS)
