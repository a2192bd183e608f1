# SPDX-License-Identifier: LGPL-3.0-or-later
"""How tests start programs on ranks: by the mpirun that set-up has left beside this Python."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
# A cold cache compiles four elements' forms; warm, each run takes about two seconds.
PATIENCE = 600
MPIRUN = Path(sys.prefix) / "bin/mpirun"
# what a launcher tells its ranks; a program started by one must not take itself for a rank
OF_A_LAUNCHER = ("OMPI_", "PMIX_", "PMI_", "PRTE_")

needs_mpirun = pytest.mark.skipif(not MPIRUN.is_file(), reason=f"no {MPIRUN}: make setup")


def outside():
    """The environment without what a launcher has told this program."""
    kept = {k: v for k, v in os.environ.items() if not k.startswith(OF_A_LAUNCHER)}
    return kept | {"OMP_NUM_THREADS": "1"}


def command(ranks, *words):
    """A Python program on ranks, as a list of words; on one rank without mpirun."""
    start = [str(MPIRUN), "-n", str(ranks)] if ranks > 1 else []
    return [*start, sys.executable, *map(str, words)]


def launch(ranks, *words, cwd=ROOT, timeout=PATIENCE):
    """Run a Python program on ranks; returns the completed process."""
    return subprocess.run(
        command(ranks, *words),
        cwd=cwd, env=outside(), capture_output=True, text=True, timeout=timeout, check=False,
    )  # fmt: skip
