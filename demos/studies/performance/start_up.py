# SPDX-License-Identifier: LGPL-3.0-or-later
"""Seconds from the start of a demo to its first step, with everything compiled before and without.

    python -m demos.studies.performance.start_up         # warm: what every later run takes
    python -m demos.studies.performance.start_up --cold  # and with empty caches
    python -m demos.studies.performance.start_up --motion walk.c3d  # and a walk from a capture

Every demo is run as a process of its own that ends where it would make its first step; warm figures
are the better of two after one that fills the caches. One rank.
"""

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from mpi4py import MPI

from shellform.console import parse, run
from shellform.results.report import Report

DEMOS = Path(__file__).resolve().parents[2]  # the folder
NAMES = ("roll_up", "drape", "strip_over_cylinder", "capstan", "hinge_sleeve", "walk")
# ends the process at the first step of any kind; the time before Python itself starts is not seen
PROBE = """
import time
start = time.perf_counter()
import builtins, os, runpy, sys

def first(*_):
    print(f"first step after {time.perf_counter() - start}", flush=True)
    os._exit(0)

waiting = [("shellform.dynamics.explicit", "Newmark", "step"),
           ("shellform.statics.newton", "Newton", "solve")]
load = builtins.__import__

def watched(*given, **named):
    module = load(*given, **named)
    for place, owner, method in list(waiting):
        if hasattr(sys.modules.get(place), owner):
            setattr(getattr(sys.modules[place], owner), method, first)
            waiting.remove((place, owner, method))
    return module

builtins.__import__ = watched
sys.argv = sys.argv[1:]
sys.path.insert(0, os.path.dirname(sys.argv[0]))
runpy.run_path(sys.argv[0], run_name="__main__")
"""


def seconds(demo, given, out, caches=None):
    """Seconds to the first step of a demo; ValueError with what it said if it makes none."""
    environment = os.environ | {"PYTHONPATH": str(DEMOS.parent)}
    if caches:
        environment |= {"XDG_CACHE_HOME": str(caches), "NUMBA_CACHE_DIR": str(caches / "numba")}
    script = DEMOS / f"{demo}.py"
    done = subprocess.run(
        [sys.executable, "-c", PROBE, str(script), *given, "--out", str(out)],
        env=environment, capture_output=True, text=True, check=False,
    )  # fmt: skip
    for line in done.stdout.splitlines():
        if line.startswith("first step after "):
            return float(line.split()[-1])
    raise ValueError(f"{demo} made no step: {done.stderr.strip() or done.stdout.strip()}")


def main(arguments=None):
    parser = argparse.ArgumentParser(allow_abbrev=False, description=__doc__.split("\n")[0])
    parser.add_argument("--demo", nargs="+", choices=NAMES, default=NAMES, help="these only")
    parser.add_argument("--motion", type=Path, help="a capture: C3D, TRC or CSV, for a second walk")
    parser.add_argument("--cold", action="store_true", help="with empty caches too")
    parser.add_argument("--out", type=Path, default=Path("out/start_up"))
    options = parse(parser, arguments)
    if MPI.COMM_WORLD.size > 1:
        parser.error("start-up is measured on one rank")
    report, rows = Report(options.out, "start_up", vars(options), MPI.COMM_WORLD), {}
    demos = {name: (name, ()) for name in options.demo}
    if options.motion:
        demos[f"walk --motion {options.motion.name}"] = "walk", ("--motion", str(options.motion))
    print("| demo | warm [s] |" + (" cold [s] |" if options.cold else ""))
    print("|---|---|" + ("---|" if options.cold else ""))
    with tempfile.TemporaryDirectory() as folder, report.stage("solve"):
        for name, (demo, given) in demos.items():
            out = Path(folder) / "out"
            found = [seconds(demo, given, out) for _ in range(3)]
            rows[name] = {"warm": min(found[1:])}
            line = f"| {name} | {rows[name]['warm']:.1f} |"
            if options.cold:
                caches = Path(tempfile.mkdtemp(dir=folder))
                rows[name]["cold"] = seconds(demo, given, out, caches)
                line += f" {rows[name]['cold']:.1f} |"
            print(line, flush=True)
    report.summary |= {"plan": {}, "cells": None, "nodes": None, "dofs": None}
    report.write(rows, steps=0, newton_iterations=0)


if __name__ == "__main__":
    run(main)
