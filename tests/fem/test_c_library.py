# SPDX-License-Identifier: LGPL-3.0-or-later
"""C code of the package: compiled once, for any processor, and what is said where it cannot be."""

import os
import signal
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from shellform.errors import CompilerError
from shellform.fem import c_library
from shellform.fem.quad_force import DECLARATIONS, SOURCE, QuadForce
from tests.fem.test_quad_force import WOVEN, bent, curved
from tests.ranks import outside

pytestmark = pytest.mark.serial
CODE = "double twice(double x) { return 2 * x; }"


@pytest.fixture
def source(tmp_path, monkeypatch):
    """A small C file, and an empty folder of compiled code."""
    monkeypatch.setattr(c_library, "cache_folder", lambda: tmp_path / "kept")
    c_library._opened.cache_clear()
    yield tmp_path / "small.c"
    c_library._opened.cache_clear()


def twice(source):
    return c_library.library(source, "double twice(double x);")[1].twice(1.5)


def test_compiled_once(source, tmp_path):
    source.write_text(CODE)
    assert twice(source) == 3.0
    (kept,) = (tmp_path / "kept").iterdir()
    made = kept.stat().st_mtime_ns
    c_library._opened.cache_clear()
    assert twice(source) == 3.0 and kept.stat().st_mtime_ns == made


def test_other_code_or_flags_have_files_of_their_own(source, tmp_path, monkeypatch):
    source.write_text(CODE)
    twice(source)
    # as nobody else has them
    monkeypatch.setenv("SHELLFORM_CFLAGS", "-march=x86-64 -mtune=generic")
    twice(source)
    source.write_text(CODE.replace("2 *", "3 *"))
    c_library._opened.cache_clear()
    assert twice(source) == 4.5
    assert len(list((tmp_path / "kept").iterdir())) == 3


# a program that compiles a file, or takes what is kept of it
PROGRAM = """
import os, pathlib, signal
from shellform.fem import c_library
c_library.cache_folder = lambda: pathlib.Path({kept!r})
{before}
assert c_library.library(pathlib.Path({source!r}), "double twice(double x);")[1].twice(1.5) == 3.0
"""
KILLED = "c_library.os.replace = lambda *_: os.kill(os.getpid(), signal.SIGKILL)"
# a compiler that writes half a library and kills the program
KILLER = """#!/bin/sh
while [ "$1" != -o ]; do shift; done
printf "\\177ELF" >"$2"
kill -9 $PPID
"""


def run(source, kept, before="", **environment):
    """The program in a process of its own: it may be killed, or die of a bad library."""
    program = PROGRAM.format(kept=str(kept), source=str(source), before=before)
    words = [sys.executable, "-c", program]
    return subprocess.run(words, capture_output=True, text=True, env=outside() | environment)


@pytest.mark.parametrize("part", [0.0, 0.3, 0.6, 0.999])
def test_a_file_cut_short_is_made_again(part, source, tmp_path):
    """Also where the loader would take it, and the program die of what is not there."""
    source.write_text(CODE)
    twice(source)
    (kept,) = (tmp_path / "kept").iterdir()
    whole = kept.read_bytes()
    kept.unlink()  # not written over: it is in use
    kept.write_bytes(whole[: int(part * len(whole))])
    done = run(source, tmp_path / "kept")
    assert done.returncode == 0, done.stderr
    assert len(kept.read_bytes()) == len(whole)


def test_killed_while_it_compiles(source, tmp_path):
    """Nothing half made is left where libraries are looked for; the next start makes it."""
    source.write_text(CODE)
    killer = tmp_path / "killer"
    killer.write_text(KILLER)
    killer.chmod(0o755)
    done = run(source, tmp_path / "kept", CC=str(killer), TMPDIR=str(tmp_path))
    assert done.returncode == -signal.SIGKILL
    assert len(list(tmp_path.glob("shellform-*/*.so"))) == 1  # half a library, elsewhere
    assert not list(tmp_path.glob("kept/*"))
    assert twice(source) == 3.0 and len(list(tmp_path.glob("kept/*.so"))) == 1


def test_killed_before_the_library_is_in_its_place(source, tmp_path):
    """What is left is not taken, and removed by a later compile, when nobody can be writing it."""
    source.write_text(CODE)
    assert run(source, tmp_path / "kept", before=KILLED).returncode == -signal.SIGKILL
    (left,) = (tmp_path / "kept").iterdir()
    assert left.suffix == ".tmp"
    assert twice(source) == 3.0 and left.exists()
    os.utime(left, (0, 0))
    source.write_text(CODE + "\n")
    c_library._opened.cache_clear()
    assert twice(source) == 3.0 and not left.exists()


def test_a_disk_that_is_full(source, tmp_path):
    """The compiler can write nothing: one sentence; the same once there is room."""
    source.write_text(CODE)
    full = "import resource; resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))"
    done = run(source, tmp_path / "kept", before=full)
    last = done.stderr.splitlines()[-1]
    assert last.startswith("shellform.errors.CompilerError: compiled code cannot be written to ")
    assert "TMPDIR" in last and not list(tmp_path.glob("kept/*"))
    assert twice(source) == 3.0


def test_a_folder_that_cannot_be_written_to(source, tmp_path):
    source.write_text(CODE)
    (tmp_path / "kept").write_text("a file")
    assert twice(source) == 3.0


def test_no_compiler(source, monkeypatch):
    source.write_text(CODE)
    monkeypatch.setenv("CC", "no-such-compiler")
    with pytest.raises(CompilerError, match="no C compiler: 'no-such-compiler' is not found"):
        twice(source)


def test_a_compiler_that_refuses(source):
    source.write_text("double twice(double x) { return 2 * y; }")
    with pytest.raises(CompilerError, match=r"refuses small\.c: .*'?y"):
        twice(source)


def test_many_compile_at_once(source, tmp_path):
    """Processes that start together all get a whole library, and leave one."""
    source.write_text(CODE)
    with ThreadPoolExecutor(4) as pool:
        runs = list(pool.map(lambda _: run(source, tmp_path / "kept"), range(4)))
    assert [done.returncode for done in runs] == [0] * 4, runs[0].stderr
    assert len(list((tmp_path / "kept").iterdir())) == 1


@pytest.mark.skipif(os.uname().machine != "x86_64", reason="flags of x86-64")
@pytest.mark.parametrize("relaxed", [False, True])
def test_any_processor_gives_the_same_force(relaxed, monkeypatch):
    """Narrow vectors and no fused products change roundoff alone."""
    given = *curved((9, 6)), WOVEN
    w = bent(*given[:2], size=0.01)
    count = len(given[2])
    options = (np.full(count, 5.0), np.ones(count)) if relaxed else ()
    found = []
    for flags in ("-march=native", "-march=x86-64-v2", "-march=x86-64"):
        monkeypatch.setenv("SHELLFORM_CFLAGS", flags)
        quads, r = QuadForce(*given, relaxed=relaxed), np.zeros_like(w)
        loss = quads(w, r, 1.01 * w, *options)
        found.append(np.append(r, loss))
    for other in found[1:]:
        assert np.abs(other - found[0]).max() < 1e-12 * np.abs(found[0]).max()
    assert c_library.library(SOURCE, DECLARATIONS)[1].lanes() == 2
