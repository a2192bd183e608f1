# SPDX-License-Identifier: LGPL-3.0-or-later
"""One file calls dolfinx; compilers are not heard, what they took is told once to the logger."""

import ast
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = {"dolfinx", "basix", "ffcx"}

SCRIPT = """
import logging, sys
import ufl
from mpi4py import MPI
from shellform.fem import dolfinx_compat as fem
import meshes

log = logging.getLogger("shellform")
log.setLevel(logging.INFO)
log.addHandler(logging.StreamHandler(sys.stdout))
log.propagate = False
before = logging.root.level, logging.root.handlers[:]
surface = meshes.rectangle(1.0, 1.0, (1, 1))
mesh = fem.surface_mesh(MPI.COMM_WORLD, "quadrilateral", 1, surface.cells, surface.points)
field = fem.Function(fem.vector_space(mesh, "Lagrange", 1, 2))
fem.compiled([(field[0] * ufl.dx,)])
assert before == (logging.root.level, logging.root.handlers)
"""


def imported(path):
    """Packages that a file imports, at whatever place in it."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (name.name.partition(".")[0] for name in node.names)
        elif isinstance(node, ast.ImportFrom) and not node.level:
            yield node.module.partition(".")[0]


def test_one_file_imports_dolfinx():
    files = [path for part in ("shellform", "demos") for path in (ROOT / part).rglob("*.py")]
    found = {p.relative_to(ROOT).as_posix() for p in files if PACKAGES & set(imported(p))}
    assert found == {"shellform/fem/dolfinx_compat.py"}


@pytest.mark.serial
def test_compilers_are_not_heard(tmp_path):
    """With an empty cache one line on one stream, nothing on the other; with a full one nothing."""
    said = []
    for _ in range(2):
        run = subprocess.run(
            [sys.executable, "-c", SCRIPT],
            cwd=ROOT,
            env=os.environ | {"XDG_CACHE_HOME": str(tmp_path)},
            capture_output=True,
            text=True,
            check=True,
        )
        assert run.stderr == ""
        said.append(run.stdout.splitlines())
    assert len(said[0]) == 1 and said[0][0].startswith("compiled 1 form of the finite elements in ")
    assert said[1] == []
