# SPDX-License-Identifier: LGPL-3.0-or-later
"""A walk that several files of tests look at."""

from pathlib import Path

from mpi4py import MPI

import pytest

from shellform.simulation.run import run as run_scene
from tests.simulation.short_walk import WALK

COMM = MPI.COMM_WORLD


@pytest.fixture(scope="session")
def walked(tmp_path_factory):
    """Folder of a whole run, and what it returned; frames that were watched."""
    # only here: most tests of this folder need no dressed wearer
    from tests.dressing.test_dress import dressed

    out = Path(COMM.bcast(str(tmp_path_factory.mktemp("walk")) if COMM.rank == 0 else None))
    watched = []
    results = run_scene(
        WALK, out, COMM, dressed("compliant").path, lambda stage, _: watched.append(stage)
    )
    COMM.Barrier()
    return out, results, watched
