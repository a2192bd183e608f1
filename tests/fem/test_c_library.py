# SPDX-License-Identifier: LGPL-3.0-or-later
"""C code of the package: compiled once, for any processor, and what is said where it cannot be."""

import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from shellform.fem import c_library
from shellform.fem.quad_force import DECLARATIONS, SOURCE, QuadForce
from tests.fem.test_quad_force import WOVEN, bent, curved

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


def test_a_file_cut_short_is_made_again(source, tmp_path):
    source.write_text(CODE)
    twice(source)
    (kept,) = (tmp_path / "kept").iterdir()
    whole = kept.read_bytes()
    kept.unlink()  # not written over: it is in use
    kept.write_bytes(whole[:100])
    c_library._opened.cache_clear()
    assert twice(source) == 3.0 and len(kept.read_bytes()) == len(whole)


def test_a_folder_that_cannot_be_written_to(source, tmp_path):
    source.write_text(CODE)
    (tmp_path / "kept").write_text("a file")
    assert twice(source) == 3.0


def test_no_compiler(source, monkeypatch):
    source.write_text(CODE)
    monkeypatch.setenv("CC", "no-such-compiler")
    with pytest.raises(RuntimeError, match="no C compiler: 'no-such-compiler' is not found"):
        twice(source)


def test_a_compiler_that_refuses(source):
    source.write_text("double twice(double x) { return 2 * y; }")
    with pytest.raises(RuntimeError, match=r"refuses small\.c: .*'?y"):
        twice(source)


def test_many_compile_at_once(source, tmp_path):
    """Processes that start together all get a whole library, and leave one."""
    source.write_text(CODE)
    code = (
        "import pathlib; from shellform.fem import c_library as c\n"
        f"c.cache_folder = lambda: pathlib.Path({str(tmp_path / 'kept')!r})\n"
        f"_, lib = c.library(pathlib.Path({str(source)!r}), 'double twice(double x);')\n"
        "assert lib.twice(1.5) == 3.0"
    )
    with ThreadPoolExecutor(4) as pool:
        words = [sys.executable, "-c", code]
        runs = list(pool.map(lambda _: subprocess.run(words, capture_output=True), range(4)))
    assert [run.returncode for run in runs] == [0] * 4, runs[0].stderr
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
