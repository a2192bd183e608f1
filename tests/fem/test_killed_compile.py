# SPDX-License-Identifier: LGPL-3.0-or-later
"""A compile that was killed is done anew at once; a live one is waited for."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.ranks import launch, needs_mpirun

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = (
    "import meshes\n"
    "from shellform import Fabric, Shell\n"
    "sheet = meshes.rectangle(1.0, 1.0, (2, 2), triangles=True)\n"
    "Shell(sheet, Fabric.isotropic(1e6, 0.3, 0.01, 1000.0)).forms()\n"
)
LONG = 300  # s, for a cold cache; half of FFCx's time-out


def begin(cache):
    return subprocess.Popen(
        [sys.executable, "-c", PROGRAM],
        cwd=ROOT,
        env=os.environ | {"XDG_CACHE_HOME": str(cache), "OMP_NUM_THREADS": "1"},
        stderr=subprocess.PIPE,
        start_new_session=True,  # the compiler dies with it
    )


def unfinished(cache):
    return [c for c in cache.glob("fenics/*.c") if not c.with_suffix(".c.cached").exists()]


def killed(cache):
    """Folder in which a program was killed while it compiled."""
    program, end = begin(cache), time.monotonic() + LONG
    while not any(c.stat().st_size for c in unfinished(cache)):
        assert program.poll() is None and time.monotonic() < end
        time.sleep(0.01)
    os.killpg(program.pid, signal.SIGKILL)
    program.communicate()
    assert unfinished(cache)


@pytest.mark.serial
@pytest.mark.slow
def test_a_killed_compile_is_done_anew(tmp_path):
    """Two at once: one compiles, the other waits for it."""
    killed(tmp_path)
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
