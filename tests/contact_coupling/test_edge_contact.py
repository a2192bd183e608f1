# SPDX-License-Identifier: LGPL-3.0-or-later
"""Edges of cells on rods and blades that fit between nodes: they carry the weight, for good."""

from mpi4py import MPI

import numpy as np
import pytest

import meshes
from contact.body.segments import Body, Fixed, Segment, Steady
from contact.geometry.capsule import Capsule
from shellform import Fabric, Shell
from shellform.contact_coupling.contact import Contact
from shellform.contact_coupling.edge_contact import pieces_of
from shellform.dynamics.explicit import Newmark
from shellform.results.ledger import Ledger

G = 9.81
SHEET = 0.2  # kg/m^2


def strip(cells=(12, 3), shift=0.0, height=0.002, comm=MPI.COMM_WORLD, triangles=False, drag=4.0):
    """A strip of 0.48 x 0.1 m along x, its middle `shift` m from the origin."""
    surface = meshes.rectangle(0.48, 0.1, cells, triangles=triangles)
    surface = surface.transform(translation=(-0.24 + shift, -0.05, height))
    shell = Shell(surface, Fabric.isotropic(1e6, 0.3, thickness=1e-3, density=200.0), comm)
    shell.loads.gravity()
    return Newmark(shell, drag=drag, damping=1e-5)


def rod(radius, angle=0.0, shape=None, motion=Fixed, **rates):
    """A bar across the strip, turned by an angle [rad] about the vertical."""
    c, s = np.cos(angle), np.sin(angle)
    axes = np.array([[-s, c, 0.0], [-c, -s, 0.0], [0.0, 0.0, 1.0]])
    shape = Capsule(2.0, radius) if shape is None else shape
    return Body([Segment("rod", shape, motion((0.0, 0.0, 0.0), axes, **rates))])


@pytest.mark.parametrize(
    ("radius", "shift", "angle", "triangles"),
    [
        pytest.param(0.0005, 0.02, 0.0, False, marks=[pytest.mark.serial, pytest.mark.thorough]),
        pytest.param(0.001, 0.013, 0.3, False, marks=[pytest.mark.serial, pytest.mark.thorough]),
        pytest.param(0.0025, 0.007, 0.0, False, marks=[pytest.mark.serial, pytest.mark.thorough]),
        pytest.param(0.001, 0.013, 0.1, True, marks=[pytest.mark.serial, pytest.mark.thorough]),
    ],
)
def test_a_strip_hangs_over_a_rod(radius, shift, angle, triangles):
    """Cells of 40 mm: after 3 s the rod carries the weight; nothing moves or lies below it."""
    stepper = strip(shift=shift, height=radius + 1e-3, triangles=triangles)
    touch = stepper.add(Contact(rod(radius, angle), friction=0.3))
    stepper.advance(3.0)
    touch.reset()
    stepper.advance(4.0)
    comm = stepper.shell.comm
    force = comm.allreduce(touch.window.table[0, :3]) / touch.window.seconds
    assert force[2] == pytest.approx(SHEET * 0.048 * G, rel=0.005)
    assert stepper.shell.positions()[:, 2].max() > 0.0


@pytest.mark.slow
def test_a_blade_of_an_ellipsoid():
    stepper = strip(shift=0.01, height=0.003)
    stepper.add(Contact(rod(0.002, shape=(1.0, 0.002, 0.002)), friction=0.3))
    stepper.advance(2.0)
    assert stepper.shell.positions()[:, 2].max() > 0.0


@pytest.mark.parametrize("friction", [0.0, 0.4])
def test_momentum_work_and_losses_close(friction):
    """One step of a flat sheet thrown at a moving rod: impulses are changes of momentum, works
    those of energy, and neither friction nor impact gives energy to the sheet."""
    stepper = strip(cells=(8, 3), shift=0.013, height=0.0016)
    speed = {"velocity": (0.3, 0.0, 0.5), "spin": (0.0, 0.0, 0.4)}
    touch = stepper.add(Contact(rod(0.001, 0.2, motion=Steady, **speed), friction=friction))
    comm, dt = stepper.shell.comm, 2e-4
    rng = np.random.default_rng(4)
    whole = 0.1 * rng.standard_normal((2, len(stepper.shell.surface.points), 3))
    whole[..., 2] -= 2.0
    old, free = whole[:, stepper.shell.partition.owned_nodes]
    stepper.v_old[:], stepper.v[:], stepper.support_impulse[:] = old, free, 0.0
    touch(stepper, dt)
    assert comm.allreduce(touch.edges.active) >= 4
    last, v = touch.last, stepper.v
    assert np.abs(last.impulse - stepper.mass[:, None] * (v - free)).max() < 1e-15
    table = comm.allreduce(last.table)
    x = stepper.points + stepper.owned[:, :3]
    total = comm.allreduce(np.hstack([last.impulse, np.cross(x, last.impulse)]).sum(axis=0))
    assert table[0, :6] == pytest.approx(total, rel=1e-9, abs=1e-12)
    work = comm.allreduce(0.5 * np.vdot(last.impulse, old + v))
    assert table[0, 6] - table[0, 7] - table[0, 8] == pytest.approx(work, rel=1e-9)
    assert table[0, 7] >= 0.0 and (table[0, 7] > 0.0) == (friction > 0.0)


def test_the_same_on_any_number_of_ranks():
    """All ranks together and each alone, with friction and a rod askew."""
    runs = []
    for comm in (MPI.COMM_WORLD, MPI.COMM_SELF):
        stepper = strip(shift=0.013, comm=comm)
        stepper.recheck, stepper.dt = 10**9, 2e-4
        stepper.add(Contact(rod(0.001, 0.3), friction=0.3))
        ledger = stepper.add(Ledger())
        stepper.advance(300 * 2e-4)
        row = ledger.record()
        assert row["momentum_residual"] < 1e-13
        runs.append((stepper.shell.positions(), [row["force_rod_z"], row["moment_rod_x"]]))
    assert np.abs(runs[0][0] - runs[1][0]).max() < 1e-9
    assert runs[1][1] == pytest.approx(runs[0][1], rel=1e-6)


@pytest.mark.parametrize(
    ("options", "edges", "cells"),
    [({}, 17, 6), ({"triangles": True}, 23, 12), ({"degree": 2}, 58, 24)],
)
def test_edges_and_cells_once_each(options, edges, cells):
    """Of the quarters where cells have nine nodes; spans are the diagonals."""
    surface = meshes.rectangle(0.3, 0.2, (3, 2), **options)
    pieces, first, span = pieces_of(surface)
    assert len(pieces) == edges + cells and np.count_nonzero(pieces[:, 2] < 0) == edges
    assert len(np.unique(np.sort(pieces, axis=1), axis=0)) == len(pieces)
    for piece, c in zip(pieces, first, strict=True):
        assert np.isin(piece[piece >= 0], surface.cells[c]).all()
    size = 0.05 if options.get("degree") == 2 else 0.1
    assert span == pytest.approx(np.full(len(pieces), np.sqrt(2) * size))
