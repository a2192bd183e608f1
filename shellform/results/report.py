# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a run leaves behind: summary.json and the frames of a series for ParaView.

Every file is written under a temporary name and then renamed, by rank 0: a run that dies leaves
its last complete files.
"""

import json
import platform
import resource
import time
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from .files import write_atomically

STAGES = ("setup", "compile", "assemble", "solve", "contact", "output")


class Report:
    """Seconds by stage and the contents of summary.json.

    Parameters
    ----------
    folder : path, made if missing
    scene, settings : str and dict, what was asked for
    comm : MPI communicator
    """

    def __init__(self, folder, scene, settings, comm):
        self.folder, self.comm = Path(folder), comm
        if comm.rank == 0:
            self.folder.mkdir(parents=True, exist_ok=True)
        self.seconds = dict.fromkeys(STAGES, 0.0)
        self._start = time.perf_counter()
        self.summary = {"scene": scene, "plan": {}, "settings": settings, "ranks": comm.size}

    @contextmanager
    def stage(self, name):
        """Count the seconds of a block to a stage of STAGES."""
        start = time.perf_counter()
        try:
            yield
        finally:
            self.seconds[name] += time.perf_counter() - start

    def shift(self, seconds, source, target):
        """Count seconds that were measured inside one stage to another."""
        self.seconds[source] -= seconds
        self.seconds[target] += seconds

    def describe(self, shell, **plan):
        """Enter sizes and energy terms of a shell, and what else the plan of a scene says."""
        surface = shell.surface
        held = shell.comm.allreduce(int(shell.supports.held[: shell.partition.n_owned].sum()))
        self.summary |= {
            "cells": len(surface.cells),
            "nodes": len(surface.points),
            "dofs": 5 * len(surface.points) - held,
        }
        self.summary["plan"] |= shell.plan() | plan

    def write(self, results, **entries):
        """Write summary.json with the results of the run."""
        seconds = {k: round(v, 4) for k, v in self.seconds.items()}
        seconds["total"] = round(time.perf_counter() - self._start, 4)
        memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        self.summary |= entries
        self.summary |= {
            "seconds": seconds,
            "peak_memory_mb": round(self.comm.allreduce(memory), 1),
            "versions": versions(),
            "results": results,
        }
        if self.comm.rank == 0:
            text = json.dumps(self.summary, indent=2, default=_plain)
            write_atomically(self.folder / "summary.json", text + "\n")


def versions():
    """Versions of what the numbers depend on."""
    from petsc4py import PETSc

    from shellform import __version__
    from shellform.fem.dolfinx_compat import VERSION

    return {
        "shellform": __version__,
        "dolfinx": VERSION,
        "petsc": ".".join(map(str, PETSc.Sys.getVersion())),
        "numpy": np.__version__,
        "python": platform.python_version(),
    }


def _plain(value):
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, Path):
        return str(value)
    raise TypeError(f"{type(value).__name__} does not belong in summary.json")
