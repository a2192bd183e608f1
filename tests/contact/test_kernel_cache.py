# SPDX-License-Identifier: LGPL-3.0-or-later
"""Kernels on disk: what changes is compiled anew, the rest is loaded, nobody removes a file."""

import ast
import json
import os
import subprocess
import sys
from pathlib import Path

import numba
import numpy as np
import pytest

from contact.kernel import Unknown, fingerprint, kernel

ROOT = Path(__file__).resolve().parents[2]
FILES = {
    "constants.py": "FACTOR = 2.0\nTABLE = (1.0, 0.5)\n",
    "inner.py": """
        from contact.kernel import kernel
        from . import constants
        from .constants import FACTOR

        @kernel
        def inner(x):
            '''Twice x.'''
            return FACTOR * later(x) + 0.0 * constants.TABLE[1]

        @kernel
        def later(x):  # defined after its first use
            return x + 0.0
    """,
    "outer.py": """
        from contact.kernel import kernel
        from .inner import inner

        @kernel
        def outer(x):
            return inner(x) + 1.0
    """,
}
RUN = """
import json
from work.outer import outer
results = [outer(5.0), float(outer(5))]
stats = outer.stats
print(json.dumps([*results, sum(stats.cache_hits.values()), sum(stats.cache_misses.values())]))
"""
HIT, MISS = [2, 0], [0, 2]  # loaded and compiled, of two signatures


@pytest.fixture
def work(tmp_path):
    """Function that changes a text in a file of the package, and one that runs it anew."""
    folder = tmp_path / "work"
    folder.mkdir()
    for name, text in {"__init__.py": "", **FILES}.items():
        lines = text.splitlines()
        (folder / name).write_text("\n".join(line.removeprefix(" " * 8) for line in lines) + "\n")

    def change(name, old, new):
        path = folder / name
        times, text = path.stat(), path.read_text()
        assert text.count(old) == 1
        path.write_text(text.replace(old, new))
        # neither size nor time may matter; Python itself would take stale byte code
        os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))

    return change, tmp_path


def start(tmp_path, program=RUN, arguments=(), **environment):
    given = os.environ | {
        "PYTHONPATH": f"{tmp_path}{os.pathsep}{ROOT}", "PYTHONDONTWRITEBYTECODE": "1"
    } | environment  # fmt: skip
    command = [sys.executable, "-c", program, *arguments]
    return subprocess.Popen(command, env=given, stdout=subprocess.PIPE)


def result(process):
    """Value at 5, and how the two signatures were had."""
    said = process.communicate(timeout=300)[0]
    assert process.returncode == 0
    first, second, *stats = json.loads(said)
    assert first == second
    return first, stats


@pytest.mark.serial
def test_what_changes_is_compiled_anew_and_nothing_else(work):
    change, place = work
    assert result(start(place)) == (11.0, MISS)
    assert result(start(place)) == (11.0, HIT)
    change("inner.py", "x + 0.0", "x + 1.0")  # a kernel called by a kernel called
    assert result(start(place)) == (13.0, MISS)
    change("constants.py", "FACTOR = 2.0", "FACTOR = 3.0")  # a constant of a third file
    assert result(start(place)) == (19.0, MISS)
    change("constants.py", "FACTOR = 3.0", "FACTOR = 2.0")  # both versions are kept
    assert result(start(place)) == (13.0, HIT)
    change("inner.py", "x + 1.0", "x + 0.0")
    assert result(start(place)) == (11.0, HIT)
    change("constants.py", "(1.0, 0.5)", "(1.0, 0.7)")  # read as an attribute of a module
    assert result(start(place)) == (11.0, MISS)
    change("inner.py", "Twice x.", "Two times x.")
    change("inner.py", "from . import", "\n# a remark, which moves all lines\nfrom . import")
    assert result(start(place)) == (11.0, HIT)
    change("inner.py", "@kernel\ndef later", "@kernel(fastmath=True)\ndef later")
    assert result(start(place)) == (11.0, MISS)
    assert result(start(place, NUMBA_BOUNDSCHECK="1")) == (11.0, MISS)


TWO_LAWS = """
import sys
from contact.kernel import kernel
from work.law import law
first, second = law(2.0), law(4.0)

@kernel
def both(x):
    return 100.0 * first(x) + second(x)

results = {"first": first, "second": second}.get(sys.argv[1], both)(1.0)
print([results, results, sum(f.stats.cache_hits[f.signatures[0]] for f in (first, second)
                             if f.signatures), 0])
"""
LAW = """
from contact.kernel import kernel

def law(factor):
    @kernel
    def force(x):
        total = 0.0
        for _ in range(3):
            total += factor * x
        return total

    return force
"""


@pytest.mark.serial
def test_closures_from_files_of_two_processes_are_not_mixed_up(work):
    """Numba's own cache gives 606 here: it links by names, which both processes number alike."""
    _, place = work
    (place / "work" / "law.py").write_text(LAW)
    assert result(start(place, TWO_LAWS, arguments=["first"]))[0] == 6.0
    assert result(start(place, TWO_LAWS, arguments=["second"]))[0] == 12.0
    assert result(start(place, TWO_LAWS, arguments=["both"])) == (612.0, [2, 0])


@pytest.mark.serial
def test_processes_at_once_leave_good_files(work):
    _, place = work
    together = [start(place) for _ in range(3)]
    assert [result(process)[0] for process in together] == [11.0] * 3
    assert result(start(place)) == (11.0, HIT)
    assert not list(place.rglob("*.tmp"))


@pytest.mark.serial
def test_damaged_and_forgotten_files(work):
    """A file that a power cut left empty is replaced; one of another kernel is not believed."""
    _, place = work
    start(place).wait()
    files = sorted(place.rglob("work.outer*.nbc"))
    assert len(files) == 2
    files[0].write_bytes(b"")
    files[1].write_bytes(next(place.rglob("work.inner.inner*.nbc")).read_bytes())
    assert result(start(place)) == (11.0, MISS)
    assert result(start(place)) == (11.0, HIT)
    # a class that an argument was of has gone to another file
    files[0].write_bytes(b"ccontact.kernel\nGone\n.")
    files[1].write_bytes(b"ccontact.gone\nGone\n.")
    assert result(start(place)) == (11.0, MISS)
    flushed = "from work.outer import outer\nouter(1.0)\nouter.recompile()\n" + RUN
    result(start(place, flushed))
    assert len(list(place.rglob("work.outer*.nbc"))) == 2


@pytest.mark.serial
def test_folder_of_the_user_where_sources_cannot_be_written(work):
    """As root may write anywhere, a file stands where the folder would be."""
    _, place = work
    (place / "work" / "__pycache__").write_text("")
    home = {"XDG_CACHE_HOME": str(place / "user"), "NUMBA_CACHE_DIR": ""}
    assert result(start(place, **home)) == (11.0, MISS)
    assert result(start(place, **home)) == (11.0, HIT)
    assert list((place / "user").rglob("work.outer*.nbc"))
    (place / "nowhere").write_text("")
    for _ in range(2):
        assert result(start(place, **home | {"XDG_CACHE_HOME": str(place / "nowhere")}))[0] == 11.0


def scaled(factor, term=0.0):
    @kernel
    def scale(x):
        return factor * x + term

    return scale


def test_content_of_closures_and_kernels_given():
    def plus_one(x):
        return x + 1.0

    def plus_two(x):
        return x + 2.0

    def applied(law):
        @kernel
        def apply(x):
            return law(x)

        return apply

    assert fingerprint(scaled(2.0)) == fingerprint(scaled(2.0))
    different = scaled(2.0), scaled(3.0), scaled(2), scaled(2.0, 1.0), scaled(2.0, -0.0)
    assert len({fingerprint(one) for one in different}) == len(different)
    laws = kernel(plus_one), kernel(plus_two), kernel(fastmath=True)(plus_one)
    assert len({fingerprint(applied(law)) for law in laws}) == 3
    assert fingerprint(applied(laws[0])) == fingerprint(applied(kernel(plus_one)))


def test_kernels_that_call_each_other_have_a_content():
    @kernel
    def even(n):
        return n == 0 or odd(n - 1)

    @kernel
    def odd(n):
        return n != 0 and even(n - 1)

    assert fingerprint(even) == fingerprint(even) != fingerprint(odd)


SCALE = 2.0


@kernel
def times_scale(x):
    return SCALE * x


def test_constant_changed_while_running_is_not_kept(monkeypatch):
    """Numba goes on with the old value, in what it has compiled: such code must not be kept."""
    fingerprint(times_scale)
    monkeypatch.setattr(sys.modules[__name__], "SCALE", 3.0)
    with pytest.raises(Unknown):
        fingerprint(times_scale)
    monkeypatch.undo()
    fingerprint(times_scale)


def test_every_kernel_is_cached_by_content():
    """No file but contact/kernel.py names a decorator of numba."""
    files = [
        path for package in ("contact", "shellform") for path in (ROOT / package).rglob("*.py")
    ]
    assert len(files) > 50
    uses = set()
    for path in files:
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.ImportFrom) and node.module:
                modules = [node.module]
            elif isinstance(node, ast.Import):
                modules = [name.name for name in node.names]
            else:
                continue
            if any(module.split(".")[0] == "numba" for module in modules):
                uses.add(path.relative_to(ROOT).as_posix())
    assert uses == {"contact/kernel.py"}


def test_no_references_are_counted_where_no_arrays_are_made():
    """A kernel that gets rows of arrays counts no references; one that makes arrays is refused."""

    def total(a):
        found = 0.0
        for i in range(len(a)):
            row = a[i]
            found += row[0]
        return found

    counting, plain = kernel(total), kernel(total, makes_arrays=False)
    a = np.arange(6.0).reshape(3, 2)
    assert counting(a) == plain(a) == 6.0
    assert "NRT_incref" not in plain.inspect_llvm(plain.signatures[0])

    def makes(n):
        return np.zeros(n).sum()

    assert kernel(makes)(3) == 0.0
    with pytest.raises(numba.core.errors.NumbaError, match=r"NRT|returning of array"):
        kernel(makes, makes_arrays=False)(3)
