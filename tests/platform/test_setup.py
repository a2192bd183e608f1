# SPDX-License-Identifier: LGPL-3.0-or-later
"""Set-up picks the dolfinx that is there, says why, and leaves an mpirun that belongs to it."""

import os
import shutil
import subprocess
import sys
from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_loader

import pytest

from tests.ranks import MPIRUN, ROOT, launch, needs_mpirun, outside

pytestmark = pytest.mark.serial

TOOLS = "bash env awk grep head tail sed sort uname cat dirname dpkg-query".split()
SYSTEMS = {
    "debian 11": "ID=debian\nVERSION_ID=11\nPRETTY_NAME='Debian 11'\n",
    "debian 12": "ID=debian\nVERSION_ID=12\nPRETTY_NAME='Debian 12'\n",
    "debian sid": "ID=debian\nPRETTY_NAME='Debian sid'\n",
    "ubuntu 22.04": "ID=ubuntu\nVERSION_ID=22.04\nPRETTY_NAME='Ubuntu 22.04'\n",
    "ubuntu 24.04": "ID=ubuntu\nVERSION_ID=24.04\nPRETTY_NAME='Ubuntu 24.04'\n",
    "ubuntu 26.04": "ID=ubuntu\nVERSION_ID=26.04\nPRETTY_NAME='Ubuntu 26.04'\n",
    "fedora": "ID=fedora\nVERSION_ID=42\nPRETTY_NAME='Fedora 42'\n",
}
# Pythons that answer the question for dolfinx, and that for a version from 3.12 on
HAS_DOLFINX = 'case "$2" in *mpi4py*) echo "0.10.0 own" ;; *) exit 1 ;; esac'
COMPLEX = 'echo "has PETSc with numbers of type complex128, not float64" >&2; exit 1'
NEW = 'case "$2" in *mpi4py*) echo "has no dolfinx that can be imported" >&2; exit 1 ;; esac'


@pytest.fixture
def pick(tmp_path):
    """Answer of .ci/platform on a machine that has no more than what is named."""
    folder = tmp_path / "bin"
    folder.mkdir()
    for tool in TOOLS:
        if found := shutil.which(tool):
            (folder / tool).symlink_to(found)

    def answer(system, wanted="", sudo=True, **pythons):
        (tmp_path / "os-release").write_text(SYSTEMS[system])
        # sudo, as root or not: some tests are run as root
        programs = {"apt-get": "", **({"sudo": ""} if sudo else {}), **pythons}
        for name, text in programs.items():
            (folder / name).write_text(f"#!/bin/sh\n{text}\n")
            (folder / name).chmod(0o755)
        done = subprocess.run(
            [ROOT / ".ci/platform"],
            env={
                "PATH": str(folder),
                "HOME": str(tmp_path),
                "OS_RELEASE": str(tmp_path / "os-release"),
                "WITH": wanted,
            },
            capture_output=True,
            text=True,
            timeout=30,
            check=False,
        )
        if done.returncode:
            assert done.stdout == "" and len(done.stderr.splitlines()) == 1
            assert done.stderr.startswith("setup: ")
            return done.stderr
        with_, python, why = done.stdout.splitlines()
        return with_, python.removeprefix(f"{folder}/"), why

    return answer


@pytest.mark.parametrize("system", ["debian 12", "debian sid", "ubuntu 24.04", "ubuntu 26.04"])
def test_the_system_s_own_where_nothing_else_is_active(pick, system):
    assert pick(system, python3=NEW)[:2] == ("apt", "/usr/bin/python3")


def test_the_active_environment_before_the_system_s(pick):
    assert pick("debian 12", python3=HAS_DOLFINX) == (
        *("active", "python3"),
        "the active environment has dolfinx 0.10.0",
    )


def test_an_active_environment_that_will_not_do_is_named(pick):
    picked, python, why = pick("debian 12", python3=COMPLEX)
    assert (picked, python) == ("apt", "/usr/bin/python3")
    assert why.endswith("python3 has PETSc with numbers of type complex128, not float64")
    assert "complex128" in pick("debian 12", "active", python3=COMPLEX)


def test_what_apt_get_has_installed_is_apt_s_unless_asked_for(pick):
    python = HAS_DOLFINX.replace("own", "system")
    assert pick("debian 12", python3=python)[0] == "apt"
    assert pick("debian 12", "active", python3=python)[0] == "active"


@pytest.fixture
def environment(tmp_path):
    """Python that finds a dolfinx of a version and of a type of numbers, other modules beside."""

    def made(version, scalar="float64", *others):
        texts = {
            "mpi4py": "MPI = None",
            "petsc4py": f"class PETSc:\n    from numpy import {scalar} as ScalarType",
            "dolfinx": f"__version__ = {version!r}",
            **dict.fromkeys(others, ""),
        }
        folder = tmp_path / "modules"
        folder.mkdir()
        for name, text in texts.items():
            (folder / f"{name}.py").write_text(text + "\n")
        return f'PYTHONPATH={folder} exec {sys.executable} "$@"'

    return made


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (("0.10.0", "complex128"), "has PETSc with numbers of type complex128, not float64"),
        (("0.10.0", "float32"), "has PETSc with numbers of type float32, not float64"),
        (("0.5.1",), "has dolfinx 0.5.1, older than 0.5.2"),
    ],
)
def test_an_active_environment_is_asked_what_it_has(given, said, pick, environment):
    python = environment(*given)
    picked, _, why = pick("debian 12", python3=python)
    assert picked == "apt" and why.endswith(f"/python3 {said}")
    assert f"WITH=active is not possible: {why.split(', and ')[1]}" in pick(
        "debian 12", "active", python3=python
    )


@pytest.mark.parametrize("version", ["0.5.2", "0.10.0.post1", "0.11.0"])
def test_an_active_environment_that_will_do(version, pick, environment):
    """Also where its dolfinx is the wheel of PyPI."""
    python = environment(version, "float64", "dolfinx_solver")
    assert pick("debian 12", python3=python) == (
        *("active", "python3"),
        f"the active environment has dolfinx {version}",
    )


def test_a_venv_on_top_is_told_where_mpi_is(finder, tmp_path):
    """An mpi4py that looks for libmpi in the environment that runs would find none there."""
    library, package = finder.library(), tmp_path / "mpi4py"
    package.mkdir()
    for name, text in {
        "__init__": "",
        "_mpiabi": "",
        "MPI": f"from ctypes import CDLL\nCDLL({str(library)!r})",
    }.items():
        (package / f"{name}.py").write_text(text + "\n")
    done = subprocess.run(
        [sys.executable, ROOT / ".ci/beneath"],
        env=outside() | {"PYTHONPATH": str(tmp_path)},
        capture_output=True,
        text=True,
        check=True,
    )
    lines = done.stdout.splitlines()
    assert f"import site; site.addsitedir({str(tmp_path)!r})" in lines
    assert f"import os; os.environ.setdefault('MPI4PY_LIBMPI', {str(library)!r})" in lines


@pytest.mark.parametrize("system", ["debian 11", "ubuntu 22.04", "fedora"])
def test_the_wheel_where_the_system_has_none(pick, system):
    assert pick(system, **{"python3.12": NEW})[:2] == ("wheel", "python3.12")


@pytest.mark.parametrize(
    ("version", "serves"),
    [((3, 11, 9), False), ((3, 12, 0), True), ((3, 13, 1), False), ((3, 13, 2), True)]
    + [((3, 14, 0), True), ((3, 15, 0), False)],
)
def test_pythons_that_the_wheel_runs_on(version, serves, pick):
    """3.13.0 and 3.13.1 never free a mesh."""
    pretend = f"import sys; sys.version_info = {version}; exec(sys.argv[1])"
    python = f'[ "$1" = -c ] && exec {sys.executable} -c "{pretend}" "$2"'
    picked = pick("fedora", "wheel", **{"python3.13": python})
    assert picked[0] == "wheel" if serves else picked.startswith("setup: WITH=wheel is not")


@pytest.mark.parametrize(
    ("system", "wanted", "said"),
    [
        ("fedora", "", "no dolfinx to use here (Fedora 42): "),
        ("fedora", "apt", "WITH=apt is not possible on Fedora 42: "),
        ("debian 11", "apt", "WITH=apt is not possible on Debian 11: "),
        ("debian 12", "wheel", "WITH=wheel is not possible: it takes Python 3.12, "),
        ("debian 12", "active", "WITH=active is not possible: no active environment has dolfinx"),
        ("debian 12", "conda", "WITH=conda is unknown: active, apt or wheel."),
    ],
)
def test_what_is_not_possible_is_one_sentence(pick, system, wanted, said):
    assert pick(system, wanted, python3="exit 1").startswith(f"setup: {said}")


@pytest.mark.parametrize("wanted", ["apt", "wheel"])
def test_what_is_asked_for_is_taken(pick, wanted):
    picked = pick("debian 12", wanted, python3=HAS_DOLFINX, **{"python3.13": NEW})
    assert picked[0] == wanted and picked[2] == "asked for"


# ---------------------------------------------------------------- mpirun


@pytest.fixture(scope="module")
def finder():
    """The program .ci/mpirun, as a module."""
    loader = SourceFileLoader("find_mpirun", str(ROOT / ".ci/mpirun"))
    module = module_from_spec(spec_from_loader("find_mpirun", loader))
    # its bytecode would be left in .ci
    before, sys.dont_write_bytecode = sys.dont_write_bytecode, True
    loader.exec_module(module)
    sys.dont_write_bytecode = before
    return module


@needs_mpirun
def test_mpirun_starts_more_ranks_than_cores():
    count = (os.cpu_count() or 1) + 1
    done = launch(count, "-c", "from mpi4py import MPI; print('of', MPI.COMM_WORLD.size)")
    assert done.returncode == 0, done.stderr
    assert done.stdout.split().count(str(count)) == count


@needs_mpirun
def test_mpirun_of_another_mpi_is_not_taken(finder, tmp_path):
    """It starts the program as often as asked, and each takes itself for the only one."""
    other = tmp_path / "mpirun"
    other.write_text('#!/bin/sh\nshift 2\n"$@"\nexec "$@"\n')
    other.chmod(0o755)
    assert not finder.starts_two([str(other)])
    assert finder.starts_two([str(MPIRUN)])
