# SPDX-License-Identifier: LGPL-3.0-or-later
"""Compilers kept from the terminal; what was compiled and how long it took goes to the logger.

setuptools takes over the root logger as a side effect of compiling. The logger `shellform` is shown
by the command lines and says nothing elsewhere unless it is asked for.
"""

import logging
import time
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path

from mpi4py import MPI

from .c_compiler import failures_as_sentences
from .killed_compile import alone

LOG = logging.getLogger("shellform")


@contextmanager
def quiet_compiler(folder: Path, comm: MPI.Comm | None, forms: int = 0) -> Iterator[None]:
    """Keep a compiler's words from the terminal, and say how long forms took, if any was new.

    Parameters
    ----------
    folder : where compiled forms are kept
    comm : of the ranks for which the first one compiles; all call. None: nothing is compiled
    forms : number of those asked for, 0 to say nothing

    Raises
    ------
    CompilerError where the compiler fails
    """
    root, disabled = logging.root, logging.root.manager.disable
    before = root.level, root.handlers[:]
    cached, start = _changed(folder), time.perf_counter()
    logging.disable(logging.INFO)
    try:
        if comm is not None and comm.size > 1:
            # who compiles waits for the others, and these may still be about to compile something
            # by themselves
            comm.Barrier()
        compiles = comm is not None and comm.rank == 0
        with failures_as_sentences(folder), alone(folder) if compiles else nullcontext():
            yield
    finally:
        logging.disable(disabled)
        root.setLevel(before[0])
        root.handlers[:] = before[1]
    if forms and _changed(folder) != cached:
        LOG.info(
            "compiled %d form%s of the finite elements in %.1f s; they are kept for the next run",
            *(forms, "" if forms == 1 else "s", time.perf_counter() - start),
        )


def _changed(folder: Path) -> int | None:
    """When a file came to or left a folder [ns]; None before there is one."""
    try:
        return folder.stat().st_mtime_ns
    except FileNotFoundError:
        return None
