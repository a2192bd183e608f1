# SPDX-License-Identifier: LGPL-3.0-or-later
"""A compile that was killed is done anew at once; a live one is waited for."""

import shlex
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from shellform.fem.c_compiler import compiler
from tests.ranks import launch, needs_mpirun, outside

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = (
    "import meshes\n"
    "from shellform import Fabric, Shell\n"
    "sheet = meshes.rectangle(1.0, 1.0, (2, 2), triangles=True)\n"
    "Shell(sheet, Fabric.isotropic(1e6, 0.3, 0.01, 1000.0)).forms()\n"
)
LONG = 300  # s, for a cold cache; half of FFCx's time-out


KILLER = """#!/bin/sh
case "$*" in
  *{part}*) kill -9 0 ;;
  *) exec {compiler} "$@" ;;
esac
"""  # a compiler that kills all of its process group at a part


def begin(cache, **environment):
    return subprocess.Popen(
        [sys.executable, "-c", PROGRAM],
        cwd=ROOT,
        env=outside() | {"XDG_CACHE_HOME": str(cache)} | environment,
        stderr=subprocess.PIPE,
        start_new_session=True,  # the compiler dies with it
    )


def unfinished(cache):
    return [c for c in cache.glob("fenics/*.c") if not c.with_suffix(".c.cached").exists()]


def killed(cache, part="forms"):
    """Kill a program while it compiles a part; what it leaves unfinished."""
    killer = cache / "killer"
    killer.write_text(KILLER.format(part=f"libffcx_{part}", compiler=shlex.join(compiler())))
    killer.chmod(0o755)
    program = begin(cache, CC=str(killer))
    program.communicate(timeout=LONG)
    if program.returncode == 0:
        pytest.skip(f"this version compiles no {part}")
    assert program.returncode == -signal.SIGKILL
    (left,) = unfinished(cache)
    assert part in left.name and left.stat().st_size


@pytest.mark.serial
@pytest.mark.slow
@pytest.mark.parametrize("part", [pytest.param("elements", marks=pytest.mark.thorough), "forms"])
def test_a_killed_compile_is_done_anew(part, tmp_path):
    """Two at once: one compiles, the other waits for it."""
    killed(tmp_path, part)
    both = [begin(tmp_path), begin(tmp_path)]
    for program in both:
        said = program.communicate(timeout=LONG)[1]
        assert program.returncode == 0, said
    assert not unfinished(tmp_path) and not list(tmp_path.glob("fenics/*.failed"))


@needs_mpirun
@pytest.mark.serial
@pytest.mark.slow
def test_a_killed_compile_is_done_anew_on_two_ranks(tmp_path, monkeypatch):
    killed(tmp_path)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    done = launch(2, "-c", PROGRAM, timeout=LONG)
    assert done.returncode == 0, done.stderr[-2000:]
    assert not unfinished(tmp_path)


@needs_mpirun
@pytest.mark.serial
def test_a_rank_that_is_late_is_waited_for(tmp_path):
    """Its own sheet comes first: who held the lock, waiting for it, would wait for ever."""
    program = (
        "import time, meshes\n"
        "from mpi4py import MPI\n"
        "from shellform import Fabric, Shell\n"
        "sheet = meshes.rectangle(1.0, 1.0, (2, 2), triangles=True)\n"
        "fabric = Fabric.isotropic(1e6, 0.3, 0.01, 1000.0)\n"
        "world = MPI.COMM_WORLD\n"
        "Shell(sheet, fabric, world)\n"  # compiled from here on
        "if world.rank == 1:\n"
        "    time.sleep(1.0)\n"
        "    Shell(sheet, fabric, MPI.COMM_SELF)\n"
        "Shell(sheet, fabric, world)\n"
    )
    done = launch(2, "-c", program, timeout=LONG)
    assert done.returncode == 0, done.stderr[-2000:]
