# SPDX-License-Identifier: LGPL-3.0-or-later
"""What is no longer used is freed: MPICH has 2048 communicators, and a mesh takes some of them."""

import gc
import weakref

import pytest

import meshes
from contact.body.segments import Body, Fixed, Segment
from shellform import Contact, Fabric, ImplicitNewmark, Newmark, Shell, Statics
from tests.ranks import launch, needs_mpirun

BALL = Body([Segment("ball", (0.2, 0.2, 0.2), Fixed((0.5, 0.5, -0.21)))])


def shell(load=(0.0, 0.0, -9.81)):
    sheet = Shell(meshes.rectangle(1.0, 1.0, (4, 4)), Fabric.isotropic(1e6, 0.3, 1e-2, 200.0))
    sheet.loads.gravity(load)
    return sheet


def fallen(stepper):
    stepper.add(Contact(BALL, friction=0.3))
    stepper.advance(stepper.dt)
    return stepper


def bent():
    sheet = shell((0.0, 0.0, -1e-4))
    sheet.supports.clamp("left")
    statics = Statics(sheet)
    for _ in statics.march(1):
        pass
    return statics


@pytest.mark.parametrize("make", [
    lambda: fallen(Newmark(shell())),
    lambda: fallen(ImplicitNewmark(shell(), dt=1e-3)),
    bent,
], ids=["explicit", "implicit", "statics"])  # fmt: skip
def test_solvers_are_freed_with_their_meshes(make):
    """PETSc's hold on a Python object is one that Python's collector cannot follow."""
    solver = make()
    sheet, mesh = weakref.ref(solver.shell), weakref.ref(solver.shell.mesh)
    del solver
    gc.collect()
    assert sheet() is None and mesh() is None


PROGRAM = """
import gc
from mpi4py import MPI
from shellform import Newmark
from shellform.fem.destroyed_together import destroy_unwanted
from tests.dynamics.test_freed import bent, fallen, shell

world = MPI.COMM_WORLD
solvers = [bent(), fallen(Newmark(shell()))]
for rank, count in ((0, 0), (1, 2)):
    if world.rank == rank:
        del solvers[:]
        gc.collect()
    world.Barrier()
    assert destroy_unwanted(world) == count
solvers = [bent()]
"""


@needs_mpirun
@pytest.mark.serial
@pytest.mark.slow
def test_ranks_may_free_at_different_times():
    """MUMPS gives back what it holds on all ranks at once: one that frees earlier may not wait."""
    done = launch(2, "-c", PROGRAM, timeout=300)
    assert done.returncode == 0, done.stderr[-2000:]
