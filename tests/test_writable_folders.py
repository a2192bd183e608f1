# SPDX-License-Identifier: LGPL-3.0-or-later
"""A home folder that cannot be written to: a temporary one serves, said in one line."""

import os
import subprocess
import sys

import pytest

from shellform.writable_folders import provide, writable
from tests.ranks import ROOT, launch, needs_mpirun

# beneath what is no folder: nobody can write there, root neither
NOWHERE = "/dev/null/home"
PROGRAM = (
    "import meshes\n"
    "from shellform import Fabric, Newmark, Shell, console\n"
    "def main(given=None):\n"
    "    sheet = meshes.rectangle(1.0, 1.0, (2, 2))\n"
    "    Newmark(Shell(sheet, Fabric.isotropic(1e6, 0.3, 0.01, 1000.0))).advance(1e-3)\n"
    "    import matplotlib.pyplot\n"
    "console.run(main)\n"
)
# MPI starts first: it wants files of its own
FILLED = (
    "import resource, ufl, meshes\n"
    "from shellform.fem.dolfinx_compat import Constant, compiled\n"
    "from shellform import Fabric, Shell, console\n"
    "def main(given=None):\n"
    "    {full}\n"
    "    sheet = meshes.rectangle(1.0, 1.0, (2, 2))\n"
    "    mesh = Shell(sheet, Fabric.isotropic(1e6, 0.3, 0.01, 1000.0)).mesh\n"
    "    compiled([(Constant(mesh, 2.0) * ufl.dx(mesh),)])\n"
    "console.run(main)\n"
)


@pytest.mark.serial
@pytest.mark.slow
@pytest.mark.parametrize("places", [{"HOME": NOWHERE}, {"XDG_CACHE_HOME": NOWHERE}])
def test_a_home_that_cannot_be_written_to(places, tmp_path):
    kept = {k: v for k, v in os.environ.items() if not k.startswith(("XDG_", "MPLCONFIG"))}
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM],
        cwd=ROOT,
        env=kept | {"TMPDIR": str(tmp_path), "OMP_NUM_THREADS": "1"} | places,
        capture_output=True,
        text=True,
        timeout=600,
    )
    assert done.returncode == 0, done.stderr
    said = [line for line in done.stderr.splitlines() if "cannot be written to" in line]
    assert len(said) == 1 and str(tmp_path) in said[0] and "Traceback" not in done.stderr
    assert list(tmp_path.glob("shellform-*/fenics/**/*.so"))


@pytest.mark.serial
@pytest.mark.parametrize("ranks", [1, pytest.param(2, marks=needs_mpirun)])
def test_a_temporary_folder_that_cannot_be_written_to(ranks, monkeypatch):
    """Open MPI would end as it starts."""
    monkeypatch.setenv("TMPDIR", NOWHERE)
    # one write a rank: those of ranks mix
    program = (
        "import os, sys, shellform\n"
        "from mpi4py import MPI\n"
        "from shellform.writable_folders import NOTES\n"
        "words = f'of {MPI.COMM_WORLD.size}', *NOTES, str(os.environ.get('TMPDIR'))\n"
        "sys.stdout.write(' '.join(words) + chr(10))"
    )
    done = launch(ranks, "-c", program)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count(f"of {ranks}") == ranks and done.stdout.count("None") == ranks
    said = done.stdout + done.stderr
    assert f"TMPDIR={NOWHERE} cannot be written to: /tmp is used" in said


@pytest.mark.serial
@pytest.mark.slow
@pytest.mark.parametrize("ranks", [1, pytest.param(2, marks=needs_mpirun)])
def test_a_disk_that_is_full(ranks, tmp_path, monkeypatch):
    """No file may be longer than 1000 bytes: one sentence, and all is well once there is room."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    full = "resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))"
    done = launch(ranks, "-c", FILLED.format(full=full))
    said = [line for line in done.stderr.splitlines() if line.startswith("-c: ")]
    assert done.returncode == 2 and "Traceback" not in done.stderr
    assert len(said) == 1 and f"compiled code cannot be written to {tmp_path}/fenics: " in said[0]
    assert not list(tmp_path.glob("fenics/*.so")) + list(tmp_path.glob("fenics/*.cached"))
    done = launch(ranks, "-c", FILLED.format(full=""))
    assert done.returncode == 0, done.stderr


def test_where_all_is_well_nothing_changes(tmp_path):
    environment = {"HOME": str(tmp_path)}
    assert provide(environment) == [] and environment == {"HOME": str(tmp_path)}
    assert not list(tmp_path.iterdir())
    (tmp_path / "file").touch()
    assert not writable(tmp_path / "file" / "below")
