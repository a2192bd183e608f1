# SPDX-License-Identifier: LGPL-3.0-or-later
"""The same answer on 1, 2 and 3 ranks, and a prompt end of all ranks when one fails.

This file is also the program that the ranks run: `python test_parallel.py NAME OUT.npz`.
"""

import fcntl
import os
import struct
import sys
import termios
import threading

import numpy as np
import pytest

import meshes
from shellform.all_ranks import wait_until_read
from tests.ranks import launch, needs_mpirun


def distorted_sheet(degree=1, triangles=False):
    """A flat sheet of 1.2 by 1, turned in space, with its warp along one side."""
    from shellform.fem.director import rotation_matrix

    turn = rotation_matrix([0.3, -0.5, 0.8])
    surface = meshes.rectangle(
        1.2, 1.0, (9, 7), degree=degree, triangles=triangles,
        parameters=meshes.distorted((9, 7), 0.25, seed=3), warp=(1.0, 0.2, 0.0),
    )  # fmt: skip
    return surface.transform(rotation=turn), turn


def woven():
    from shellform import Fabric

    return Fabric.orthotropic(3e6, 1e6, 0.2, 8e4, 6e4, 5e4, 0.02, 300.0)


def laminate():
    """Two plies across one another: bending comes with stretching."""
    from shellform import Fabric, Ply

    ply = Ply(3e6, 1e6, 0.2, 8e4, 6e4, 5e4, 300.0)
    return Fabric.laminate([(ply, 0.01, 0.0), (ply, 0.01, 90.0)])


def loaded(degree, triangles, fabric):
    """Shell with inclined supports, pressure, moments, line and point loads."""
    from shellform import Shell

    surface, turn = distorted_sheet(degree, triangles)
    shell = Shell(surface, fabric)
    shell.supports.hold_normal("left", turn[:, 0])
    shell.supports.hold_normal("left", turn[:, 2])
    shell.supports.hold_director("left")
    shell.supports.symmetry("bottom", turn[:, 1])
    shell.loads.pressure(30.0)
    shell.loads.gravity()
    shell.loads.edge_moment("right", turn @ [0.2, -1.0, 0.1])
    shell.loads.line("top", turn @ [0.5, 3.0, 4.0])
    corner = turn @ [1.2, 1.0, 0.0]
    shell.loads.point(corner, (1.0, 2.0, -3.0))
    shell.loads.point_moment(corner, (0.05, 0.0, 0.1))
    return shell


def driven(degree, triangles, fabric):
    """Shell whose right edge is carried and turned, the left clamped."""
    from shellform import Shell
    from shellform.fem.director import rotation_matrix

    surface, turn = distorted_sheet(degree, triangles)
    shell = Shell(surface, fabric)
    shell.supports.clamp("left")
    shell.supports.move(
        "right",
        displacement=turn @ [-0.02, 0.02, 0.15],
        director=lambda level: turn @ rotation_matrix([0.1 * level, -0.3 * level, 0.0])[:, 2],
    )
    shell.loads.surface((1.0, 2.0, 3.0))
    return shell


CASES = {
    "quad": (loaded, 1, False, woven),
    "triangle": (loaded, 1, True, woven),
    "nine nodes": (loaded, 2, False, woven),
    "laminate": (loaded, 1, False, laminate),
    "driven quad": (driven, 1, False, woven),
    "driven nine nodes": (driven, 2, False, laminate),
}
THOROUGH = (
    "nine nodes",
    "driven nine nodes",
    "driven quad",
    "laminate",
)  # the others meet what they do


def run(name, path):
    """Solve a case on the ranks of this program; rank 0 writes the result."""
    from mpi4py import MPI

    from shellform import Statics

    build, degree, triangles, fabric = CASES[name]
    shell = build(degree, triangles, fabric())
    statics = Statics(shell)
    statics.solve(4 if build is driven else 3)
    energy = sum(shell.energy().values())
    u, d = shell.displacements(), shell.directors()
    if MPI.COMM_WORLD.rank == 0:
        iterations = [step.iterations for step in statics.steps]
        np.savez(path, u=u, d=d, energy=energy, iterations=iterations, ranks=MPI.COMM_WORLD.size)


@needs_mpirun
@pytest.mark.serial
@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=pytest.mark.thorough if name in THOROUGH else ()) for name in CASES],
)
def test_ranks_agree(name, tmp_path):
    """Displacements of 1, 2 and 3 ranks agree to 1e-9, in as many iterations."""
    results = []
    for ranks in (1, 2, 3):
        path = tmp_path / f"{ranks}.npz"
        done = launch(ranks, "-m", "tests.test_parallel", name, path)
        assert done.returncode == 0, done.stderr[-2000:]
        results.append(np.load(path))
        assert results[-1]["ranks"] == ranks
    one = results[0]
    size = np.abs(one["u"]).max()
    assert size > 0.05  # ten times the thickness and more: not a linear problem
    for other in results[1:]:
        assert np.abs(other["u"] - one["u"]).max() <= 1e-9 * size
        assert np.abs(other["d"] - one["d"]).max() <= 1e-9
        assert other["energy"] == pytest.approx(one["energy"], rel=1e-9)
        assert other["iterations"].tolist() == one["iterations"].tolist()


@needs_mpirun
@pytest.mark.serial
def test_a_failing_rank_ends_the_run(tmp_path):
    """One rank raises while the other waits for it: under `-m mpi4py` all end."""
    script = tmp_path / "fails.py"
    script.write_text(
        "from mpi4py import MPI\n"
        "world = MPI.COMM_WORLD\n"
        "if world.rank == 1:\n"
        "    raise ValueError('rank 1 gives up')\n"
        "world.Barrier()\n"
    )
    done = launch(2, "-m", "mpi4py", script)
    assert done.returncode != 0
    assert "rank 1 gives up" in done.stderr


@needs_mpirun
@pytest.mark.serial
@pytest.mark.parametrize("fault", ["1 / 0", "raise KeyboardInterrupt", "class E(BaseException): 0"])
@pytest.mark.parametrize("use", ["import shellform", "from shellform import Shell"])
def test_a_failing_rank_of_a_plain_script_ends_the_run(use, fault, tmp_path):
    """Whoever imports shellform needs no `-m mpi4py`; what was a hook before still has its say."""
    script = tmp_path / "fails.py"
    script.write_text(
        "import sys\n"
        "from mpi4py import MPI\n"
        "seen = lambda kind, error, trace: open(sys.argv[1], 'a').write(kind.__name__ + ' ')\n"
        "sys.excepthook = seen\n"
        f"{use}\n"
        "world = MPI.COMM_WORLD\n"
        "if world.rank == 1:\n"
        f"    {fault}\n"
        "    raise E('out')\n"
        "world.Barrier()\n"
    )
    done = launch(2, script, tmp_path / "seen", timeout=60)
    assert done.returncode not in (0, None)
    assert len((tmp_path / "seen").read_text().split()) == 1


def test_what_was_written_last_is_read_before_all_ranks_end():
    """MPICH's launcher drops what it has not read by then."""
    out, into = os.pipe()
    os.write(into, b"rank 1 gives up")
    reader = threading.Timer(0.3, os.read, (out, 100))
    reader.start()
    wait_until_read(into)
    (unread,) = struct.unpack("i", fcntl.ioctl(out, termios.FIONREAD, b"\0" * 4))
    assert unread == 0
    reader.join()
    os.close(out)
    os.close(into)


@needs_mpirun
@pytest.mark.serial
def test_bad_input_ends_all_ranks_alike(tmp_path):
    """A mistake that every rank sees is raised on every rank: no rank is left waiting."""
    script = tmp_path / "mistaken.py"
    script.write_text(
        "import meshes\n"
        "from shellform import Fabric, Shell\n"
        "surface = meshes.rectangle(1.0, 1.0, (4, 4))\n"
        "shell = Shell(surface, Fabric.isotropic(1e6, 0.3, 0.01, 1000.0))\n"
        "shell.supports.clamp('lefft')\n"
    )
    done = launch(2, script)
    assert done.returncode != 0
    assert "has no edge 'lefft'" in done.stderr


if __name__ == "__main__":
    run(sys.argv[1], sys.argv[2])
