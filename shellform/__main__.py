# SPDX-License-Identifier: LGPL-3.0-or-later
"""The command `shellform`: new, check, trade, run, resume, compare, report, export, fabric.

Also as `python -m shellform`.

    shellform new scene.toml        writes a commented scene to start from
    shellform check scene.toml      says what would be modelled and what it would cost
    shellform trade scene.toml      says what errors cost: cells, step, time, memory for each
    shellform run scene.toml        dresses the wearer, plays the motion, reports torques
    shellform resume out/scene      goes on with a run that was stopped
    shellform compare out/a out/b   says whether two runs differ in their torques
    shellform export out/a --to opensim     writes its forces and torques for OpenSim
    shellform report out/a out/b    writes a page with all of it, which opens without a network
    shellform fabric card.toml      pulls, shears, bends, hangs, loops and drapes a fabric

Under mpirun every rank calls it: `mpirun -n 2 python -m shellform run scene.toml`.
"""

import argparse
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from mpi4py import MPI

from . import console

TESTS = ("pull", "shear", "bend", "hang", "loop", "drape")
TEMPLATE = """\
# A scene of shellform. Everything left out has the value shown; paths are relative to this file.
# SI units; x is forward, y to the wearer's left, z up, the floor at 0.
title = "trousers over an obstacle"
fabric = "compliant"        # or stiff, suiting, field_cloth, denim, canvas, aramid, knit; or a
                            # card.toml, or a table as in a card
belt_N = 20                 # tension of the belt; 0 for none

[motion]
file = "synthetic"          # or a capture: walk.c3d, walk.trc, walk.csv, walk.bvh, of any heading,
                            # y or z up, mm, cm or m; left and right are the wearer's
# static = "standing.trc"   # static trial, with markers that are taken off for the walk
# map = "..."               # segment map of its markers, where none fits by itself
# unit = "mm"               # and up = "z": of the capture, where it does not tell
# max_gap_s = 0.1           # longest gap of a marker that is filled
# start_s = 0.0             # part of the capture to use
# end_s = 2.0
obstacle_m = 0.5            # of the synthetic walk, in its third stride; 0 for none

[person]
# stature_m = 1.76          # where the recording does not tell
# girths_m = { waist = 0.94, hip = 1.02, thigh = 0.62, calf = 0.39, ankle = 0.23 }

[garment]
# size = "large-regular"
# file = "trousers.obj"     # or .glb, .gltf, .ply, .stl, .off, .vtu, .vtk, .msh
# unit = "m"                # of its coordinates: m, cm, mm or in
# waist = "waist"           # its edge of that name (.msh, .vtu, .vtk carry names); where there are
                            # none (.obj, .ply, .stl, .glb, .off) found by its shape, or "highest";
                            # to name one: surface.with_edges(waist=...), meshes.save to a .vtu file
# turn_deg = [0, 0, 90]     # about x, y, z, and
# place_m = [0, 0, -0.3]    # then moved: where its shape does not tell
# weld_m = 0.0              # joins seams that miss each other by less
# midsurface = false        # of cloth exported with its thickness
# max_elongation = 0.18     # of the dressed cloth; beyond it the run ends
# measures_m = { waist = 1.0, hip = 1.17, thigh = 0.78, knee = 0.58, hem = 0.44 }
# hangs = "shoulders"       # of a sewing pattern without sleeves; "waist"; by itself where it has
# seam_bending = 4.0        # of cells beside the seams of a sewing pattern, over that of the cloth
# wrinkles = "auto"         # those smaller than a cell: "relaxed", or "resolved" by cells alone

[contact]
friction = 0.3
# self_contact = true       # cloth meets cloth too, see docs/self_contact.md
# flesh_bed_Pa_per_m = { body = 6.7e5, left_shank = 1e6 }  # skin gives way where cloth presses it

[steps]
accuracy = "draft"          # standard, fine, or a percentage
# runs = 3                  # starts whose mean is reported; by the accuracy

[output]
window_s = 0.02             # torques are means over this time
frames_per_s = 10
parts = "distal"            # AJ: which parts count for a joint; "child", or a table
"""


def parser() -> argparse.ArgumentParser:
    """Parser of the command line."""
    top = argparse.ArgumentParser(
        prog="shellform",
        allow_abbrev=False,
        description="What clothing does to its wearer, mechanically.",
        epilog="Options with one dash go to PETSc, as -shell_ts_monitor.",
    )
    kinds = top.add_subparsers(dest="do", required=True)
    new = kinds.add_parser("new", allow_abbrev=False, help="write a commented scene to start from")
    new.add_argument("scene", type=Path)
    check = kinds.add_parser(
        "check", allow_abbrev=False, help="say what would be modelled and what it would cost"
    )
    check.add_argument("scene", type=Path)
    trade = kinds.add_parser(
        "trade", allow_abbrev=False, help="say what errors cost: cells, step, time, memory"
    )
    trade.add_argument("scene", type=Path)
    trade.add_argument("--measure", action="store_true", help="run the two cheapest settings")
    trade.add_argument("--out", type=Path, help="folder for what is run (default: out/trade/NAME)")
    run = kinds.add_parser(
        "run", allow_abbrev=False, help="dress the wearer, play the motion, report torques"
    )
    run.add_argument("scene", type=Path)
    run.add_argument("--out", type=Path, help="folder for results (default: out/NAME)")
    run.add_argument("--dressed", type=Path, help="dressed.npz of an earlier run, used again")
    run.add_argument(
        "--estimate",
        action="store_true",
        help="a second run with other cells, to estimate the error reached",
    )
    run.add_argument(
        "--runs",
        type=console.positive(int),
        help="starts whose mean is reported (default: what the accuracy needs)",
    )
    resume = kinds.add_parser(
        "resume", allow_abbrev=False, help="go on with a run that was stopped"
    )
    resume.add_argument("out", type=Path, help="folder of the run")
    compare = kinds.add_parser(
        "compare", allow_abbrev=False, help="say whether two runs differ in their torques"
    )
    compare.add_argument("one", type=Path, help="folder of a run")
    compare.add_argument("other", type=Path, help="folder of another, with other cloth or garment")
    fabric = kinds.add_parser(
        "fabric", allow_abbrev=False, help="test a fabric as laboratories do: KES, D1388, Cusick"
    )
    fabric.add_argument("card", help="a shipped card or the file of one")
    fabric.add_argument("--out", type=Path, help="folder for results (default: out/fabric/NAME)")
    fabric.add_argument("--only", nargs="+", choices=TESTS, default=TESTS, help="tests to run")
    fabric.add_argument(
        "--starts", type=console.positive(int), default=1, help="drapes whose mean is reported"
    )
    fabric.add_argument(
        "--no-bands", action="store_true", help="leave out what estimated inputs spread over"
    )
    export = kinds.add_parser(
        "export", allow_abbrev=False, help="write a run's forces and torques for OpenSim"
    )
    export.add_argument("out", type=Path, help="folder of the run")
    export.add_argument("--to", choices=["opensim"], default="opensim", help="the program")
    export.add_argument(
        "--model",
        choices=["rajagopal", "gait2392"],
        default="rajagopal",
        help="whose names and signs the coordinates have (default: %(default)s)",
    )
    export.add_argument(
        "--osim",
        type=Path,
        metavar="FILE",
        help="your own model: its hips are put at the wearer's, its sizes compared",
    )
    export.add_argument("--folder", type=Path, help="for the files (default: opensim in OUT)")
    report = kinds.add_parser(
        "report", allow_abbrev=False, help="write a page of one or more runs, for any browser"
    )
    report.add_argument("runs", type=Path, nargs="+", metavar="OUT", help="folder of a run")
    report.add_argument("--out", type=Path, help="file (default: report.html in the first folder)")
    for kind in (run, resume, fabric):
        kind.add_argument("--no-pictures", action="store_true", help="leave the pictures out")
    return top


def main(given: Sequence[str] | None = None) -> None:
    """Run the command; `given` is a list of arguments or None for the program's own."""
    options = console.parse(parser(), given)
    if options.do == "new":
        _new(options.scene)
    elif options.do == "check":
        # here and below: finite elements load only for what needs them
        from shellform.scene.scene_file import read_scene
        from shellform.simulation.check import check

        console.say(check(read_scene(options.scene)))
    elif options.do == "trade":
        from shellform.scene.scene_file import read_scene
        from shellform.simulation.error_study import cost_table

        out = options.out or Path("out/trade") / options.scene.stem
        lines = cost_table(read_scene(options.scene), out=out if options.measure else None)
        console.say(lines)
    elif options.do == "run":
        _run(options)
    elif options.do == "fabric":
        _fabric(options)
    elif options.do == "compare":
        from shellform.results.comparison import comparison_lines
        from shellform.results.verdict import verdict_sentence
        from shellform.simulation.ensemble import compare_runs

        found = compare_runs(options.one, options.other)
        names = str(options.one), str(options.other)
        console.say([*comparison_lines(found, *names), verdict_sentence(found, *names)])
    elif options.do == "export":
        _export(options)
    elif options.do == "report":
        _report(options)
    else:
        from shellform.simulation.ensemble import resume

        _show(options.out, resume(options.out), options.no_pictures)


def _new(path: Path) -> None:
    """Write the commented scene."""
    if path.exists():
        raise ValueError(f"{path} exists already: give another name")
    path.write_text(TEMPLATE)


def _run(options: argparse.Namespace) -> None:
    """Run a scene, and with --estimate a second one with other cells."""
    from shellform.scene.scene_file import read_scene
    from shellform.simulation.ensemble import run
    from shellform.simulation.error_study import check_cells, estimate

    out, scene = options.out or Path("out") / options.scene.stem, read_scene(options.scene)
    if options.runs:
        scene = replace(scene, steps=replace(scene.steps, runs=options.runs))
    if options.estimate:
        check_cells(scene, "--estimate")
    results = run(scene, out, dressed=options.dressed)
    if options.estimate:
        estimate(scene, out)
    _show(out, results, options.no_pictures)


def _fabric(options: argparse.Namespace) -> None:
    """Tests of a fabric, with lines and a picture by rank 0."""
    from shellform.bench.run import fabric_tests, summary_lines
    from shellform.material.card import fabric_of

    fabric = fabric_of(options.card)
    out = options.out or Path("out/fabric") / fabric.name
    bands = not options.no_bands
    results = fabric_tests(fabric, options.only, starts=options.starts, bands=bands, out=out)
    console.say(summary_lines(fabric, results))
    if MPI.COMM_WORLD.rank:
        return
    wrote = [f"{out}/summary.json"]
    if not options.no_pictures:
        # only here: it loads matplotlib
        from shellform.pictures.fabric_tests import fabric_figure

        estimated = results["estimated"]
        title = f"{fabric.name}, estimated: {', '.join(estimated)}" if estimated else fabric.name
        fabric_figure(out / "fabric.png", results, title)
        wrote.append("fabric.png")
    print(f"wrote {', '.join(wrote)}")


def _export(options: argparse.Namespace) -> None:
    """Files for another program, by rank 0; all ranks learn of what is wrong."""

    def write() -> None:
        from shellform.export.opensim import export, export_lines

        folder = options.folder or options.out / options.to
        console.say(export_lines(export(options.out, folder, options.model, options.osim), folder))

    _by_rank_0(write)


def _report(options: argparse.Namespace) -> None:
    """Write the page, by rank 0; all ranks learn of what is wrong."""

    def write() -> None:
        from shellform.report.page import write_report

        print(f"wrote {write_report(options.runs, options.out)}")

    _by_rank_0(write)


def _by_rank_0(write: Callable[[], None]) -> None:
    """Call it on rank 0; what it raises is raised on all ranks."""
    comm, fault = MPI.COMM_WORLD, None
    if comm.rank == 0:
        try:
            write()
        except console.KNOWN as error:
            fault = error
    fault = comm.bcast(fault)
    if fault is not None:
        raise fault


def _show(out: Path, results: dict, no_pictures: bool) -> None:
    """Pictures and lines for a person, by rank 0."""
    if MPI.COMM_WORLD.rank:
        return
    from shellform.accuracy.choice import accuracy_line
    from shellform.simulation.figures import draw
    from shellform.simulation.summary import summary_lines, summary_of

    if not no_pictures:
        draw(out)
    print("\n".join(summary_lines(results)))
    print(accuracy_line(summary_of(out)["accuracy"]))
    print(f"wrote {out}/summary.json, torque.csv, ledger.csv, series.pvd")


def command() -> None:
    """The installed command."""
    console.run(main)


if __name__ == "__main__":
    command()
