# SPDX-License-Identifier: LGPL-3.0-or-later
"""Runs of a case of cases.py within a budget, with their memory; medians of short ones."""

import gc
import resource
import statistics
import time
from pathlib import Path

from mpi4py import MPI

from shellform.console import say

COMM = MPI.COMM_WORLD
FAILURES = (ArithmeticError, RuntimeError, ValueError)  # of a run; Unstable is one of them
SHORT = 2.0  # s, a run as short is repeated


def ladder(case, budget):
    """Run the settings of a case until the budget [s] is spent.

    A run that would, by the growth of cost with cells, take more than is left is not begun; one
    that fails is named and left out.

    Returns
    -------
    runs : list of (settings, found); whole : bool, all settings were run
    """
    runs, start, worst, whole = [], time.perf_counter(), {}, True
    warm = set()
    for settings in case.ladder:
        left = budget - COMM.bcast(time.perf_counter() - start)
        before = worst.get(settings["family"])
        if left <= 0 or (before and before[1] > left and settings["kind"] == "mesh"):
            say([f"  {case.name}: no time left for {settings}"])
            whole = False
            continue
        began = time.perf_counter()
        try:
            if settings["family"] not in warm and case.name != "walk":
                case.run(settings)  # compiles
                warm.add(settings["family"])
                began = time.perf_counter()
            found = [measured(case, settings)]
            while len(found) < 3 and found[0]["core_seconds"] < SHORT * COMM.size:
                found.append(measured(case, settings))
        except FAILURES as failure:
            say([f"  {case.name}: {settings} failed: {failure}"])
            whole = False
            continue
        one = dict(found[0]) | {"repeats": len(found)}
        for key in ("core_seconds", "memory_mb"):
            one[key] = statistics.median(f[key] for f in found)
        runs.append((settings, one))
        took = COMM.bcast((time.perf_counter() - began) / len(found))
        if settings["kind"] == "mesh":
            growth = (before[0] / one["ratio"]) ** 3 if before else 2.5
            worst[settings["family"]] = one["ratio"], took * max(growth, 1.5)
        say([f"  {case.name}: {settings} {took:.1f} s"])
    return runs, whole


def measured(case, settings):
    """One run with its peak memory [MB] over all ranks."""
    gc.collect()
    forget_peak()
    found = case.run(settings)
    return found | {"memory_mb": COMM.allreduce(peak_memory())}


def forget_peak():
    """Let the system count the peak of memory anew, where it can (Linux)."""
    try:
        Path("/proc/self/clear_refs").write_text("5")
    except OSError:
        pass


def peak_memory():
    """Most resident memory [MB] since `forget_peak`."""
    try:
        for line in Path("/proc/self/status").read_text().splitlines():
            if line.startswith("VmHWM"):
                return float(line.split()[1]) / 1024
    except OSError:
        pass
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
