# SPDX-License-Identifier: LGPL-3.0-or-later
"""What `pip install shellform` installs: built, looked into, run without the repository."""

import os
import shutil
import subprocess
import sys
from email import message_from_bytes
from pathlib import Path
from zipfile import ZipFile

import pytest

from tests.ranks import PATIENCE, ROOT, outside

PACKAGES = ("shellform", "contact", "meshes")
pytestmark = pytest.mark.serial


def run(*words, cwd, **environment):
    done = subprocess.run(
        [sys.executable, *map(str, words)],
        cwd=cwd,
        env=outside() | environment,
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=False,
    )
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    return done.stdout


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """Folder of the sdist and of the wheel made from it; what an older build left plays no part."""
    source, out = tmp_path_factory.mktemp("source"), tmp_path_factory.mktemp("dist")
    for name in PACKAGES:
        shutil.copytree(ROOT / name, source / name, ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, source)
    # setuptools is the one of this environment: nothing is fetched
    run("-m", "build", "-q", "--no-isolation", "--outdir", out, cwd=source)
    return out


@pytest.fixture(scope="module")
def wheel(built):
    (path,) = built.glob("*.whl")
    return path


def test_every_file_is_in_the_wheel(wheel):
    """C sources, tables, cards, maps and py.typed as well as modules; and nothing else."""
    with ZipFile(wheel) as files:
        names = {name for name in files.namelist() if ".dist-info/" not in name}
    here = {
        path.relative_to(ROOT).as_posix()
        for package in PACKAGES
        for path in (ROOT / package).rglob("*")
        if path.is_file() and path.parent.name != "__pycache__"
    }
    assert {Path(name).suffix for name in here} >= {".py", ".c", ".toml", ".csv", ".typed"}
    assert names == here


def test_nothing_is_required_unasked(wheel):
    """A requirement would let pip put another numpy or mpi4py in front of the one that is there."""
    with ZipFile(wheel) as files:
        (name,) = (name for name in files.namelist() if name.endswith("METADATA"))
        metadata = message_from_bytes(files.read(name))
    required = metadata.get_all("Requires-Dist")
    assert [line for line in required if "extra ==" not in line] == []
    wheel = [line for line in required if 'extra == "wheel"' in line.replace("'", '"')]
    assert any(line.startswith("dolfinx-solver-real") for line in wheel)
    assert {"apt", "active"}.isdisjoint(metadata.get_all("Provides-Extra"))


def test_an_index_would_take_it(built):
    run("-m", "twine", "check", "--strict", *built.iterdir(), cwd=built)


@pytest.mark.thorough
@pytest.mark.slow  # kernels compile anew
def test_command_without_the_repository(wheel, tmp_path):
    """Installed elsewhere, the command writes a scene and checks it: cards and tables are found."""
    place = tmp_path / "site"
    run("-m", "pip", "install", "-q", "--no-deps", "--no-index", "--target", place, wheel, cwd=".")
    environment = {"PYTHONPATH": os.pathsep.join([str(place), outside().get("PYTHONPATH", "")])}
    where = run("-c", "import shellform; print(shellform.__file__)", cwd=tmp_path, **environment)
    assert Path(where.strip()).parents[1] == place
    for words in (("new", "scene.toml"), ("check", "scene.toml")):
        said = run(place / "bin/shellform", *words, cwd=tmp_path, **environment)
    assert "torque" in said or "cells" in said


def test_gmsh_without_its_libraries_is_one_sentence(tmp_path):
    """As on a server without a desktop: what is missing and what to install."""
    (tmp_path / "gmsh.py").write_text("raise OSError('libGLU.so.1: cannot open shared object')\n")
    script = "from meshes.gmsh_model import gmsh_model\ntry:\n    gmsh_model().__enter__()\n"
    script += "except ImportError as error:\n    print(error)\n"
    path = os.pathsep.join([str(tmp_path), str(ROOT), outside().get("PYTHONPATH", "")])
    said = run("-c", script, cwd=tmp_path, PYTHONPATH=path).splitlines()
    assert len(said) == 1 and "libGLU.so.1" in said[0] and "apt-get install" in said[0]
