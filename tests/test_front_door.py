# SPDX-License-Identifier: LGPL-3.0-or-later
"""`import shellform`: cheap, complete, and every public name explained by an example that runs."""

import ast
import doctest
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import shellform as sf

PROJECT = Path(sf.__file__).resolve().parents[1]


@pytest.mark.serial
def test_importing_loads_nothing_else():
    """Neither finite elements nor numba nor numpy; the names are there all the same."""
    code = (
        "import sys; before = set(sys.modules)\n"
        "import shellform as sf\n"
        "heavy = {'numpy', 'numba', 'dolfinx', 'ufl', 'petsc4py', 'mpi4py', 'scipy'}\n"
        "print(sorted(heavy & (set(sys.modules) - before)), len(set(sf.__all__) - set(dir(sf))))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert done.stdout.strip() == "[] 0", done.stdout + done.stderr


def test_names_have_one_list():
    """What is listed, where it comes from, and what type checkers are shown are the same names."""
    tree = ast.parse(Path(sf.__file__).read_text())
    shown = {
        alias.name: ("shellform." if node.level else "") + str(node.module)
        for block in tree.body
        if isinstance(block, ast.If)
        for node in block.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    assert shown == sf._HOMES
    assert sorted(sf.__all__) == sorted(sf._HOMES)


def test_a_name_that_is_none():
    with pytest.raises(AttributeError, match="no attribute 'Trousers'"):
        sf.Trousers


@pytest.mark.serial
@pytest.mark.parametrize("name", sf.__all__)
def test_examples_of_the_docstrings_run(name, tmp_path, monkeypatch):
    """Each name has an example of its own, which gives what it says."""
    monkeypatch.chdir(tmp_path)
    one = getattr(sf, name)
    tests = doctest.DocTestFinder(recurse=False).find(one, name, globs={"sf": sf, "np": np})
    examples = [example for test in tests for example in test.examples]
    assert len(examples) >= 2, f"{name} has no example in its docstring"
    flags = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
    runner, said = doctest.DocTestRunner(optionflags=flags), []
    for test in tests:
        runner.run(test, out=said.append)
    assert runner.summarize(verbose=False).failed == 0, "".join(said)


@pytest.mark.serial
def test_one_place_for_the_version(tmp_path):
    """The version of the distribution is that of the package."""
    code = "from importlib.metadata import version; print(version('shellform'))"
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, env=os.environ, capture_output=True, text=True
    )
    assert done.stdout.strip() == sf.__version__
    for file in ("pyproject.toml", "CITATION.cff", "docs/conf.py"):
        assert sf.__version__ not in (PROJECT / file).read_text()
