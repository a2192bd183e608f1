# SPDX-License-Identifier: LGPL-3.0-or-later
"""summary.json: what was modelled, what it cost, on what versions, and the results."""

from __future__ import annotations

import json
import platform
import resource
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from mpi4py import MPI

import numpy as np

from shellform.fem.shell import Shell

if TYPE_CHECKING:
    # a static run loads no stepper
    from shellform.dynamics.time_stepper import Stepper

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

    def __init__(self, folder: str | Path, scene: str, settings: dict, comm: MPI.Comm):
        self.folder, self.comm = Path(folder), comm
        if comm.rank == 0:
            self.folder.mkdir(parents=True, exist_ok=True)
        self.seconds = dict.fromkeys(STAGES, 0.0)
        self._start, self._processor = time.perf_counter(), time.process_time()
        self.summary: dict = {"scene": scene, "plan": {}, "settings": settings, "ranks": comm.size}

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Count the seconds of a block to a stage of STAGES."""
        start = time.perf_counter()
        try:
            yield
        finally:
            self.seconds[name] += time.perf_counter() - start

    def shift(self, seconds: float, source: str, target: str) -> None:
        """Count seconds that were measured inside one stage to another."""
        self.seconds[source] -= seconds
        self.seconds[target] += seconds

    def describe(
        self,
        shell: Shell,
        stepper: Stepper | None = None,
        /,
        **plan: Any,
    ) -> None:
        """Enter sizes and terms of a shell, of its stepper if any, and what else is planned."""
        surface = shell.surface
        held = shell.comm.allreduce(int(shell.supports.held[: shell.partition.n_owned].sum()))
        self.summary |= {
            "cells": len(surface.cells),
            "nodes": len(surface.points),
            "dofs": 5 * len(surface.points) - held,
        }
        made = shell.plan() if stepper is None else stepper.describe()
        self.summary["plan"] |= made | plan

    def write(self, results: dict, **entries: Any) -> None:
        """Write summary.json with the results of the run."""
        seconds = {k: round(v, 4) for k, v in self.seconds.items()}
        seconds["total"] = round(time.perf_counter() - self._start, 4)
        memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        processor = self.comm.allreduce(time.process_time() - self._processor)
        self.summary |= entries
        self.summary |= {
            "seconds": seconds,
            "core_seconds": round(processor, 4),
            "peak_memory_mb": round(self.comm.allreduce(memory), 1),
            "versions": versions(),
            "results": results,
        }
        if self.comm.rank == 0:
            text = json.dumps(self.summary, indent=2, default=_plain)
            write_atomically(self.folder / "summary.json", text + "\n")


def versions() -> dict[str, str]:
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
