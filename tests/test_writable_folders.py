# SPDX-License-Identifier: LGPL-3.0-or-later
"""A home folder that cannot be written to: a temporary one serves, said in one line."""

import os
import subprocess
import sys

import pytest

from shellform.writable_folders import provide, writable
from tests.ranks import ROOT

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


def test_where_all_is_well_nothing_changes(tmp_path):
    environment = {"HOME": str(tmp_path)}
    assert provide(environment) == [] and environment == {"HOME": str(tmp_path)}
    assert not list(tmp_path.iterdir())
    (tmp_path / "file").touch()
    assert not writable(tmp_path / "file" / "below")
