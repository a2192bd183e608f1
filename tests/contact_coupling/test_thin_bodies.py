# SPDX-License-Identifier: LGPL-3.0-or-later
"""Thin bodies and tips under coarse cells: nothing passes; forces, torque and pressure add up."""

import subprocess
import sys

from mpi4py import MPI

import numpy as np
import pytest

import meshes
from contact.body.segments import Body, Fixed, Segment, Steady
from contact.geometry.capsule import Capsule
from demos.studies.thin_rods.passages import Passages
from demos.studies.thin_rods.run import axes_of, rows_of
from shellform import Fabric, Shell
from shellform.contact_coupling.contact import Contact
from shellform.dynamics.explicit import Newmark
from shellform.results.ledger import Ledger
from shellform.results.pressure_map import summary
from shellform.results.skin_pressure import Pressure
from tests.contact_coupling.test_edge_contact import SHEET, G, rod, strip

ACROSS = np.array([0.0, 1.0, 0.0])


def watched(stepper, axis=lambda t: (np.zeros(3), ACROSS)):
    """Passages of the stepper's strip through an axis."""
    passages = Passages(rows_of(stepper.shell.surface), axis)
    stepper.add(passages)
    return passages


@pytest.mark.slow
@pytest.mark.parametrize("angle", [0.0, 0.4])
@pytest.mark.parametrize("shape", [(1.0, 0.002, 0.08), (1.0, 0.002, 0.002)], ids=["edge", "blade"])
def test_sharp_edges_hold(shape, angle):
    """The upright edge of a flat ellipsoid, 0.05 mm round, and a blade; 2 mm semi-axis."""
    e1, e2, e3 = axes_of(angle)
    top = shape[2]
    stepper = strip(shift=0.013, height=0.002)
    body = Body([Segment("edge", shape, Fixed((0.0, 0.0, -top), [e1, e2, e3]))])
    touch = stepper.add(Contact(body, friction=0.4))
    passages = watched(stepper, lambda t: (np.array([0.0, 0.0, -5e-5]), e1))
    stepper.advance(1.0)
    assert not passages.passed.any() and touch.edges.active > 0
    assert stepper.shell.positions()[:, 2].max() > -1e-3


@pytest.mark.parametrize("speed", [1.0, 3.0, 10.0])
@pytest.mark.parametrize("angle", [0.0, 0.3])
def test_a_rod_that_swings_into_the_sheet(speed, angle):
    """Upwards through 0.2 m, 2 mm thick, up to its thickness a step: cloth is taken along."""
    stepper = strip(shift=0.013, height=0.0)
    stepper.recheck, (e1, e2, e3) = 10**9, axes_of(angle)
    stepper.dt = 2e-4
    motion = Steady((0.0, 0.0, -0.02), [e1, e2, e3], velocity=(0.0, 0.0, speed))
    stepper.add(Contact(Body([Segment("rod", Capsule(2.0, 0.001), motion)]), friction=0.3))
    passages = watched(stepper, lambda t: (np.array([0.0, 0.0, -0.02 + speed * t]), e1))
    stepper.advance(0.22 / speed)
    assert not passages.passed.any()
    top = stepper.shell.positions()[:, 2].max()
    assert top > 0.2 - 0.04  # within a cell of the rod


@pytest.mark.parametrize("which", ["edge", "crossed", "two sheets"])
def test_other_places(which):
    """A rod under the free edge of a sheet; two rods that cross under it; two sheets on one rod."""
    segments = [Segment("rod", Capsule(2.0, 0.001), Fixed((0.0, 0.0, 0.0), axes_of(0.0)))]
    stepper, axes = strip(shift=0.013, height=0.003), [ACROSS]
    if which == "edge":
        stepper = strip(shift=0.238, height=0.003)  # 2 mm beyond the rod
    elif which == "crossed":
        axes.append(np.array([np.sin(1.2), np.cos(1.2), 0.0]))
        turned = axes_of(-1.2)
        segments.append(Segment("other", Capsule(2.0, 0.001), Fixed((0.0, 0.0, 0.0), turned)))
        assert abs(turned[0] @ axes[1]) == pytest.approx(1.0)
    else:
        stepper = two_strips()
    touch = stepper.add(Contact(Body(segments), friction=0.4))
    parts = [watched(stepper, lambda t, along=along: (np.zeros(3), along)) for along in axes]
    stepper.advance(0.6)
    assert not any(part.passed.any() for part in parts)
    if which != "edge":  # there it slides off
        assert touch.edges.active > 0 and stepper.shell.positions()[:, 2].max() > 0.0


def two_strips():
    """Two strips, one over the other, of one shell."""
    one = meshes.rectangle(0.48, 0.1, (12, 3)).transform(translation=(-0.227, -0.05, 0.003))
    other = one.transform(translation=(0.013, 0.2, 0.0))
    points, n = np.vstack([one.points, other.points]), len(one.points)
    both = meshes.Surface(points, np.vstack([one.cells, other.cells + n]))
    shell = Shell(both, Fabric.isotropic(1e6, 0.3, thickness=1e-3, density=200.0))
    shell.loads.gravity()
    return Newmark(shell, drag=4.0, damping=1e-5)


@pytest.mark.parametrize("radius", [0.005, 0.0225, 0.027])
@pytest.mark.parametrize("options", [{}, {"triangles": True}], ids=["quads", "triangles"])
def test_tips_do_not_come_through_a_cell(radius, options):
    """The end of an upright rod under the inside of a cell of 40 mm, of a clamped sheet."""
    surface = meshes.rectangle(0.2, 0.2, (5, 5), **options)
    shell = Shell(surface, Fabric.isotropic(1e5, 0.3, thickness=1e-3, density=200.0))
    for side in ("left", "right", "bottom", "top"):
        shell.supports.clamp(side)
    stepper = Newmark(shell, drag=4.0, damping=1e-5)
    axes = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    start = np.array([0.107, 0.096, -0.3 - radius - 1e-3])
    motion = Steady(start, axes, velocity=(0.0, 0.0, 0.5))
    shape = Capsule(0.6, radius)
    touch = stepper.add(Contact(Body([Segment("rod", shape, motion)]), friction=0.3))
    stepper.advance(0.08)  # 39 mm up
    cell = np.flatnonzero(np.linalg.norm(surface.points - [0.1, 0.1, 0], axis=1) < 0.03)
    assert len(cell) == 4 and touch.max_depth < 1e-4
    assert shell.positions()[cell, 2].mean() > 0.03 - 0.7 * radius  # the cell is taken along


@pytest.mark.slow
def test_a_nine_node_sheet_on_a_rod():
    """Edges of the quarters of its cells hold."""
    surface = meshes.rectangle(0.48, 0.1, (6, 2), degree=2)
    surface = surface.transform(translation=(-0.227, -0.05, 0.003))
    shell = Shell(surface, Fabric.isotropic(1e6, 0.3, thickness=1e-3, density=200.0))
    shell.loads.gravity()
    stepper = Newmark(shell, drag=4.0, damping=1e-5)
    touch = stepper.add(Contact(rod(0.001, 0.1), friction=0.3))
    passages = watched(stepper, lambda t: (np.zeros(3), axes_of(0.1)[0]))
    stepper.advance(0.5)
    assert not passages.passed.any() and touch.edges.active > 0


@pytest.mark.serial
def test_force_moment_and_pressure_of_a_strip_at_rest():
    """The rod carries the weight at the strip's centre of mass; the map holds all of it."""
    stepper = strip(shift=0.013, height=0.003, drag=8.0)
    away = np.array([0.0, 0.2, 0.0])  # of the rod's centre, along it
    thin = Segment("rod", (1.0, 0.001, 0.001), Fixed(-away, axes_of(0.0)))
    touch = stepper.add(Contact(Body([thin]), friction=0.3))
    skin, ledger = stepper.add(Pressure(0.05)), stepper.add(Ledger())
    stepper.advance(2.5)
    ledger.record(), skin.record(stepper.time, False)
    pressed = 0.0

    def press(stepper, dt):
        nonlocal pressed
        alone = touch.last.impulse - touch.edges.impulse  # that of nodes, which presses at them
        x = (stepper.points + stepper.owned[:, :3])[touch.segment >= 0]
        normal = x * [1.0, 0.0, 1.0] / np.linalg.norm(x[:, [0, 2]], axis=1)[:, None]
        pressed += np.vdot(alone[touch.segment >= 0], normal) + touch.edges.pairs["push"].sum()

    stepper.add(press)
    stepper.advance(3.5)
    row, weight = ledger.record(), SHEET * 0.048 * G
    skin.record(stepper.time)
    comm, mass = stepper.shell.comm, stepper.mass
    x = stepper.points + stepper.owned[:, :3]
    centre = comm.allreduce(mass @ x) / comm.allreduce(mass.sum())
    assert row["force_rod_z"] == pytest.approx(weight, rel=5e-3)
    for axis, lever in (("x", centre[1] + 0.2), ("y", -centre[0])):
        assert row[f"moment_rod_{axis}"] == pytest.approx(lever * weight, rel=0.01, abs=2e-4)
    # across the rod, as if it were straight; all of it is from edges
    held = summary(skin.result())["rod"]["normal_force"]
    assert held == pytest.approx(comm.allreduce(pressed) / 1.0, rel=1e-6)
    assert held > 0.8 * weight


def test_forces_of_the_first_200_steps_on_all_ranks():
    """All ranks together and each alone, step by step, to 1e-9."""
    runs = []
    for comm in (MPI.COMM_WORLD, MPI.COMM_SELF):
        stepper, forces = strip(shift=0.013, comm=comm), []
        stepper.recheck, stepper.dt = 10**9, 2e-4
        touch = stepper.add(Contact(rod(0.001, 0.3), friction=0.3))

        def look(stepper, dt, touch=touch, forces=forces, comm=comm):
            forces.append(comm.allreduce(touch.last.table[0]) / dt)

        stepper.add(look)
        stepper.advance(200 * 2e-4)
        assert len(forces) == 200
        runs.append(np.array(forces))
    assert np.abs(runs[1][:, 2]).max() > 0.1
    assert np.abs(runs[0] - runs[1]).max() <= 1e-9 * np.abs(runs[1]).max()


@pytest.mark.serial
def test_nothing_of_it_where_no_body_is_thin():
    """Its files are not even imported, so nothing of them is compiled or allocated."""
    program = (
        "import sys, meshes, shellform as sf\n"
        "shell = sf.Shell(meshes.rectangle(0.4, 0.4, (4, 4)), sf.Fabric.isotropic(1e5, 0.3, 1e-3,"
        " 200.0))\n"
        "shell.loads.gravity(); stepper = sf.Newmark(shell)\n"
        "ball = sf.Body([sf.Segment('ball', [0.2] * 3, sf.Fixed((0.2, 0.2, -0.202)))])\n"
        "contact = stepper.add(sf.Contact(ball)); stepper.advance(0.05)\n"
        "assert contact.edges is None and contact.window.impulse.any()\n"
        "names = ('edge_contact', 'cell_pairs', 'nearest_on_cell', 'pair_impulses')\n"
        "print([m for m in sys.modules if m.rsplit('.', 1)[-1] in names])\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.returncode == 0 and done.stdout.split("\n")[-2] == "[]", done.stderr[-1000:]
