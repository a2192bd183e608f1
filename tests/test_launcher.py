# SPDX-License-Identifier: LGPL-3.0-or-later
"""A program that the mpirun of another MPI has started ends with one sentence."""

import subprocess
import sys

import pytest

from shellform.launcher import Launched, launched, mismatch
from tests.ranks import ROOT, outside

OPEN_MPI, MPICH = "Open MPI 4.1.4", "MPICH 5.0.2"


@pytest.mark.parametrize(
    ("environment", "said"),
    [
        ({}, None),
        ({"OMPI_COMM_WORLD_SIZE": "1", "OMPI_COMM_WORLD_RANK": "0"}, None),
        ({"OMPI_COMM_WORLD_SIZE": "3", "OMPI_COMM_WORLD_RANK": "2"}, Launched("Open MPI", 3, 2)),
        ({"PMI_SIZE": "2", "PMI_RANK": "1", "PMI_FD": "9"}, Launched("MPICH", 2, 1)),
        ({"PMI_SIZE": "2"}, Launched("MPICH", 2, 0)),
        ({"PMI_SIZE": "two"}, None),
    ],
)
def test_what_a_launcher_says(environment, said):
    assert launched(environment) == said


@pytest.mark.parametrize(
    ("by", "mpi", "size", "fits"),
    [
        # before MPI starts: only what is sure to end in MPI_Init is refused
        ("Open MPI", OPEN_MPI, None, True),
        ("Open MPI", MPICH, None, False),
        ("MPICH", MPICH, None, True),
        ("MPICH", OPEN_MPI, None, True),
        # once it has: two were started, and each knows how many there are
        ("Open MPI", OPEN_MPI, 2, True),
        ("MPICH", MPICH, 2, True),
        ("MPICH", "Intel MPI 2021.13", 2, True),
        ("MPICH", OPEN_MPI, 2, True),
        ("MPICH", OPEN_MPI, 1, False),
        ("Open MPI", "Open MPI 5.0.7", 1, False),
    ],
)
def test_what_belongs_together(by, mpi, size, fits):
    message = mismatch(Launched(by, 2, 0), mpi, size, "/x/bin/mpirun")
    if fits:
        assert message is None
    else:
        assert message.startswith(f"2 copies of this program were started by the mpirun of {by}, ")
        assert mpi in message and message.endswith("start it with /x/bin/mpirun")


@pytest.mark.serial
@pytest.mark.parametrize("words", [("-m", "shellform", "-h"), ("demos/roll_up.py", "-h")])
def test_programs_end_with_one_sentence(words):
    """The first copy says it, the second is silent, neither does anything."""
    from mpi4py import MPI

    other = "PMI" if MPI.get_vendor()[0] == "Open MPI" else "OMPI_COMM_WORLD"
    for rank in (0, 1):
        done = subprocess.run(
            [sys.executable, *words],
            cwd=ROOT,
            env=outside() | {f"{other}_SIZE": "2", f"{other}_RANK": str(rank)},
            capture_output=True,
            text=True,
            timeout=60,
            check=False,
        )
        assert done.returncode == 2 and done.stdout == ""
        lines = done.stderr.splitlines()
        assert len(lines) == (rank == 0)
        if rank == 0:
            assert lines[0].startswith("shellform: 2 copies of this program were started by")
