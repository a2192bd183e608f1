# SPDX-License-Identifier: LGPL-3.0-or-later
"""The same tests on one rank and on many: `pytest`, `mpirun -n 2 python -m pytest -m "not serial"`.

On many ranks only rank 0 reports, and a failure on any rank stops all of them: the others would
wait for it in their next collective call until a time-out.
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy loads its BLAS
os.environ.setdefault("NUMBA_NRT_STATS", "1")  # numba counts what its code allocates

import gc
from pathlib import Path

import pytest

try:
    from mpi4py import MPI

    import numpy  # noqa: F401
except ImportError as error:
    MPI, MISSING = None, str(error)

# Tests of what knows of no ranks, by `make lint`: on two of them all would be computed twice
WITHOUT_RANKS = ("contact", "meshes", "motion", "test_type_hints.py")
DATA = Path(__file__).resolve().parents[1] / "../shared/data"


@pytest.hookimpl(trylast=True)  # once the reporter is there
def pytest_configure(config):
    if MPI is None:
        raise pytest.UsageError(
            f"{MISSING}. Run `make setup` once, then `.venv/bin/python -m pytest`."
        )
    if MPI.COMM_WORLD.size > 1:
        gc.disable()  # see collect_garbage_together
        if MPI.COMM_WORLD.rank > 0:
            config.pluginmanager.unregister(name="terminalreporter")


@pytest.hookimpl(tryfirst=True)  # before -m chooses
def pytest_collection_modifyitems(items):
    for item in items:
        room = item.path.relative_to(Path(__file__).parent).parts[0]
        if room in WITHOUT_RANKS and not {"comm", "shared_tmp_path"} & set(item.fixturenames):
            item.add_marker(pytest.mark.serial)


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(item, call):
    """Abort all ranks once one has a failure to tell."""
    report = (yield).get_result()
    if report.failed:
        _abort_all(item.nodeid, report.longreprtext)


def pytest_collectreport(report):
    if report.failed:
        _abort_all(report.nodeid, report.longreprtext)


def _abort_all(where, text):
    world = MPI.COMM_WORLD
    if world.size > 1:
        print(f"\n[rank {world.rank} of {world.size}] {where}\n{text}", flush=True)
        world.Abort(1)


@pytest.fixture(autouse=True, scope="module")
def collect_garbage_together():
    """Free PETSc and dolfinx objects in cycles at the same point on all ranks.

    Freeing is collective; Python's collector runs at a different moment on each rank.
    """
    yield
    if MPI.COMM_WORLD.size > 1:
        gc.collect()


@pytest.fixture(scope="session")
def comm():
    """All ranks of this run."""
    return MPI.COMM_WORLD


@pytest.fixture
def shared_tmp_path(request, comm):
    """Rank 0's tmp_path, on all ranks."""
    path = str(request.getfixturevalue("tmp_path")) if comm.rank == 0 else None
    yield Path(comm.bcast(path))
    comm.Barrier()  # nobody still reads when rank 0 cleans up


@pytest.fixture(scope="session")
def paper_data():
    """Folder with published tables and motion captures, beside the repository; skips without."""
    if not DATA.is_dir():
        pytest.skip("the reference data (../shared/data beside the repository) are not here")
    return DATA.resolve()
