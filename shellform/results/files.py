# SPDX-License-Identifier: LGPL-3.0-or-later
"""Files written whole or not at all."""

import os
from pathlib import Path

from mpi4py import MPI


def write_atomically(path: str | Path, text: str) -> None:
    """Write a text file so that readers see either the old or the whole new one.

    It is UTF-8; names of files in it that are not keep their bytes (PEP 383).
    """
    path = Path(path)
    part = path.with_name(path.name + ".part")
    part.write_text(text, encoding="utf-8", errors="surrogateescape")
    os.replace(part, path)


def check_place(path: str | Path, comm: MPI.Comm) -> None:
    """ValueError on all ranks, which all call, where rank 0 cannot put a file."""
    path, fault = Path(path), None
    if comm.rank == 0:
        if path.is_dir():
            fault = f"{path} is a folder: give the name of a file in it"
        elif not path.parent.is_dir():
            fault = f"{path}: there is no folder {path.parent}, make it first"
    fault = comm.bcast(fault)
    if fault:
        raise ValueError(fault)
