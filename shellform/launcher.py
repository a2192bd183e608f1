# SPDX-License-Identifier: LGPL-3.0-or-later
"""A launcher of another MPI is refused: it starts copies of a run that know nothing of one another.

Each copy would take itself for the whole run and write the same files. MPICH started by Open MPI
ends the program in MPI_Init, with messages of its own; so what mpirun says to its ranks is looked
at before MPI starts. Nothing is loaded where there is no launcher.
"""

import os
import sys
import time
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

# how many ranks a launcher has started, and which of them a program is
OPEN_MPI = ("OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_RANK")
MPICH = ("PMI_SIZE", "PMI_RANK")  # and its kin, as Intel MPI


class Launched(NamedTuple):
    """What a launcher says: whose it is, how many ranks it has started, which of them this is."""

    by: str
    ranks: int
    rank: int


def launched(environment: Mapping[str, str]) -> Launched | None:
    """What the launcher says, None without one or with one rank."""
    for by, (size, rank) in (("Open MPI", OPEN_MPI), ("MPICH", MPICH)):
        ranks, number = environment.get(size, ""), environment.get(rank, "0")
        if ranks.isdecimal() and number.isdecimal() and int(ranks) > 1:
            return Launched(by, int(ranks), int(number))
    return None


def mismatch(by: Launched, mpi: str, size: int | None, mpirun: str) -> str | None:
    """What is wrong, in one sentence; None where launcher and MPI belong together.

    Parameters
    ----------
    mpi : name and version of the MPI that mpi4py has
    size : ranks it knows of; None before it starts
    mpirun : the mpirun that belongs to it
    """
    if size is None:
        # Open MPI starts under launchers of several kinds, MPICH not under Open MPI's
        wrong = by.by == "Open MPI" and not mpi.startswith("Open MPI")
    else:
        wrong = size == 1
    if not wrong:
        return None
    return (
        f"{by.ranks} copies of this program were started by the mpirun of {by.by}, which the "
        f"{mpi} of this Python's mpi4py knows nothing of: start it with {mpirun}"
    )


def refuse_another(environment: Mapping[str, str] = os.environ) -> None:
    """End the program with one sentence of its first copy if another MPI has launched it.

    Raises
    ------
    SystemExit, on all copies
    """
    by = launched(environment)
    if by is None:
        return
    import mpi4py  # only here: nothing of MPI loads where there is no launcher

    wait = "mpi4py.MPI" not in sys.modules and mpi4py.rc.initialize
    if wait:
        mpi4py.rc.initialize, mpi4py.rc.finalize = False, True
    from mpi4py import MPI

    name, version = MPI.get_vendor()
    mpi = f"{name} {'.'.join(map(str, version))}"
    beside = Path(sys.prefix) / "bin/mpirun"
    mpirun = str(beside) if beside.is_file() else f"that of {mpi}"
    message = None if MPI.Is_initialized() else mismatch(by, mpi, None, mpirun)
    if message is None:
        if wait:
            MPI.Init_thread()
            mpi4py.rc.initialize = True
        if MPI.Is_initialized():
            message = mismatch(by, mpi, MPI.COMM_WORLD.size, mpirun)
    if message is not None:
        if by.rank == 0:
            print(f"shellform: {message}", file=sys.stderr, flush=True)
        else:
            time.sleep(0.3)  # the first that ends may end all, and is to have spoken
        raise SystemExit(2)
