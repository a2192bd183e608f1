# SPDX-License-Identifier: LGPL-3.0-or-later
"""A shell on closed surfaces of triangles: weight, momentum, checkpoints, what is refused."""

import subprocess
import sys

from mpi4py import MPI

import numpy as np
import pytest

import meshes
from contact.body.blended_surface import BlendedSurface
from contact.body.flesh_bed import Flesh
from contact.body.rigid_surface import RigidSurface
from contact.body.segments import Body, Fixed, Segment, turned
from contact.geometry.triangle_mesh.sphere import sphere
from shellform import Fabric, ImplicitNewmark, Shell
from shellform.contact_coupling.contact import Contact
from shellform.dynamics import checkpoint
from shellform.dynamics.explicit import Newmark
from shellform.results.ledger import Ledger
from tests.contact_coupling.test_explicit_contact import G, over_sphere


def limb(place, divisions=3):
    """The limb of those tests, of triangles with a sagitta of up to 2 mm."""
    vertices, triangles = sphere(1.0, divisions)
    return RigidSurface(vertices * (0.2, 0.3, 0.25), triangles, place, "limb")


def test_momentum_closes_in_every_step():
    stepper, touch = over_sphere(drag=1.0, damping=1e-4, body=limb)
    comm, weight = stepper.shell.comm, stepper.shell.fabric.areal_mass * 0.25 * G
    contact = 0
    for _ in range(200):
        before = comm.allreduce(stepper.mass @ stepper.v)
        booked = [stepper.external_total.copy(), stepper.drag_total.copy()]
        dt = stepper.dt
        stepper.step(dt)
        last = touch.correction.last
        impulse = last.impulse.sum(axis=0)
        pushed = comm.allreduce(last.segment_impulse[0])
        assert np.abs(pushed - comm.allreduce(impulse)).max() < 1e-12 * weight * dt
        impulse = impulse + stepper.external_total - booked[0] + stepper.drag_total - booked[1]
        change = comm.allreduce(stepper.mass @ stepper.v) - before
        assert np.abs(change - comm.allreduce(impulse)).max() < 1e-10 * weight * dt
        contact += comm.allreduce(touch.correction.active)
    assert contact > 100


@pytest.mark.serial
def test_free_sheet_rests_with_its_weight_on_the_body():
    """Mean contact force at rest is the weight, to 0.1 % up and aside."""
    stepper, _ = over_sphere(drag=8.0, damping=1e-3, body=limb)
    ledger = stepper.add(Ledger())
    stepper.advance(3.0)
    ledger.record()
    stepper.drag = 0.0
    stepper.advance(3.6)
    row = ledger.record()
    force = np.array([row[f"force_limb_{a}"] for a in "xyz"])
    weight = stepper.shell.fabric.areal_mass * 0.25 * G
    assert row["active"] > 3
    assert np.abs(force - [0, 0, weight]).max() < 1e-3 * weight
    assert row["momentum_residual"] < 1e-10 * weight
    assert row["kinetic"] < 1e-6


def skinned(rate=1.0):
    """A limb of two segments under one skin that bends at the middle, and the skin."""

    def swing(side):
        def pose(t):
            angle = side * 0.2 * np.sin(rate * 2 * np.pi * t)
            turn = turned(np.eye(3), np.array([0.0, angle, 0.0]))
            spin = side * 0.2 * rate * 2 * np.pi * np.cos(rate * 2 * np.pi * t)
            return (0.0, 0.0, -0.25), turn, np.zeros(3), np.array([0.0, spin, 0.0])

        return pose

    body = Body([Segment(name, [0.1] * 3, swing(s)) for name, s in (("left", -1), ("right", 1))])
    vertices, triangles = sphere(1.0, 3)
    vertices = vertices * (0.3, 0.2, 0.25) + [0.0, 0.0, -0.25]
    right = 0.5 * (1.0 + np.tanh(vertices[:, 0] / 0.05))
    return body, BlendedSurface(vertices, triangles, np.column_stack([1 - right, right]), body)


def sheet(comm=MPI.COMM_WORLD, shapes=()):
    """A sheet a little above the limb, in explicit steps of 2e-4 s, and its contact."""
    surface = meshes.rectangle(0.5, 0.4, (10, 8)).transform(translation=(-0.24, -0.21, 2e-3))
    shell = Shell(surface, Fabric.isotropic(1e6, 0.3, 1e-3, 200.0), comm)
    shell.loads.gravity()
    stepper = Newmark(shell, 0.8, damping=1e-4, drag=0.5)
    stepper.recheck, stepper.dt = 10**9, 2e-4
    body, skin = skinned()
    if shapes:
        knee = Segment("knee", [0.1] * 3, Fixed((-0.1, 0.0, -0.08)))
        body = Body([*body.segments, knee])
    return stepper, stepper.add(Contact(body, 0.3, surface=skin, shapes=shapes))


def test_forces_of_segments_are_the_same_on_one_rank_and_on_all():
    """Over 200 steps to 1e-9, by segment; the skin stands on every rank as a whole."""
    runs = []
    for comm in (MPI.COMM_SELF, MPI.COMM_WORLD):
        stepper, contact = sheet(comm)
        forces = []
        for _ in range(200):
            stepper.step(stepper.dt)
            forces.append(comm.allreduce(contact.last.table[:, :6]).ravel())
        runs.append(np.array(forces))
    assert np.abs(runs[0]).max(axis=0).min() > 0.0  # both segments are pressed, in all directions
    assert np.abs(runs[0] - runs[1]).max() <= 1e-9 * np.abs(runs[1]).max()


@pytest.mark.parametrize("shapes", [(), ("knee",)])
def test_goes_on_bit_for_bit(shapes, shared_tmp_path, comm):
    def steps(stepper, count):
        for _ in range(count):
            stepper.step(stepper.dt)

    stepper, contact = sheet(shapes=shapes)
    steps(stepper, 110)
    checkpoint.save(shared_tmp_path / "c.npz", stepper)
    comm.Barrier()
    other, again = sheet(shapes=shapes)
    checkpoint.load(shared_tmp_path / "c.npz", other)
    evaluated = []
    for _ in range(90):
        steps(stepper, 1)
        steps(other, 1)
        evaluated.append((contact.correction.evaluated, again.correction.evaluated))
    gather = stepper.shell.partition.gather
    for one, two in (
        (stepper.owned, other.owned),
        (stepper.v, other.v),
        (contact.window.impulse, again.window.impulse),
    ):
        assert np.array_equal(gather(one), gather(two))
    assert comm.allreduce(np.abs(contact.window.impulse).sum()) > 0
    whole, same = np.array(evaluated).T
    assert len({*comm.allreduce(whole)}) > 1 and np.array_equal(whole, same)


def test_union_with_a_shape_closes_momentum_and_work():
    """A knee cap that stands out of the skin is met as the ellipsoid that it is."""
    stepper, contact = sheet(shapes=("knee",))
    ledger = stepper.add(Ledger())
    comm, both = stepper.shell.comm, np.zeros(3)
    ledger.record()
    for _ in range(250):
        stepper.step(stepper.dt)
        last = contact.last
        table = comm.allreduce(last.table)
        impulse = comm.allreduce(last.impulse.sum(axis=0))
        assert np.abs(table[:, :3].sum(axis=0) - impulse).max() < 1e-12 * (
            1e-9 + np.abs(table).max()
        )
        both += np.abs(table[:, :3]).sum(axis=1) > 0
    row = ledger.record()
    assert (both > 10).all()
    assert row["momentum_residual"] < 1e-10


def test_ledger_names_the_segments_of_the_body():
    stepper, contact = sheet()
    ledger = stepper.add(Ledger())
    ledger.record()
    stepper.advance(0.04)
    row = ledger.record()
    assert row["force_left_z"] > 0 and row["force_right_z"] > 0
    assert row["momentum_residual"] < 1e-10
    centres = contact.start_pose.centres
    assert np.array_equal(centres, np.tile([0.0, 0.0, -0.25], (2, 1)))


@pytest.mark.serial
def test_what_a_surface_does_not_know_is_refused_in_one_sentence():
    body, skin = skinned()
    for settings, said in (
        ({"samples": 2}, "is met at nodes, not at 2 samples a cell: leave `samples` out"),
        ({"flesh_stiffness": 1e5}, "no flesh between its parts alone.*1e\\+05|100000"),
    ):
        shell = Shell(meshes.rectangle(0.1, 0.1, (2, 2)), Fabric.isotropic(1e6, 0.3, 1e-3, 200.0))
        with pytest.raises(ValueError, match=said):
            Newmark(shell, 0.8).add(Contact(body, surface=skin, **settings))
    for stepper in (Newmark(shell, 0.8), ImplicitNewmark(shell, 1e-3)):
        with pytest.raises(ValueError, match="the shapes of left are those of a body: give it"):
            stepper.add(Contact(limb(Fixed()), shapes=["left"]))
    with pytest.raises(ValueError, match="are met besides a surface, which is not given"):
        Contact(body, shapes=["left"])
    with pytest.raises(TypeError, match=r"the surface of a contact is one as RigidSurface\(...\)"):
        Contact(body, surface=3)
    with pytest.raises(ValueError, match="the shapes of knee are met as hard ones, and"):
        Newmark(shell, 0.8).add(Contact(body, surface=skin, shapes=["knee"], flesh=Flesh(1e5)))
    with pytest.raises(ValueError, match=r"flesh of 'calf': no segment"):
        Contact(body, surface=skin, flesh=Flesh({"calf": 1e5}))


@pytest.mark.serial
def test_nothing_of_it_without_a_surface():
    """Its files are not even imported, so nothing of them is compiled or allocated."""
    program = (
        "import sys, meshes, shellform as sf\n"
        "shell = sf.Shell(meshes.rectangle(0.4, 0.4, (4, 4)), sf.Fabric.isotropic(1e5, 0.3, 1e-3,"
        " 200.0))\n"
        "shell.loads.gravity(); stepper = sf.Newmark(shell)\n"
        "ball = sf.Body([sf.Segment('ball', [0.2] * 3, sf.Fixed((0.2, 0.2, -0.202)))])\n"
        "contact = stepper.add(sf.Contact(ball)); stepper.advance(0.05)\n"
        "assert contact.window.impulse.any()\n"
        "print([m for m in sys.modules if 'triangle_mesh' in m or '.surface_' in m and\n"
        "       m.split('.')[-1] in ('surface_step', 'surface_node', 'surface_correction',\n"
        "                            'surface_contact')])\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.returncode == 0 and done.stdout.split("\n")[-2] == "[]", done.stderr[-1000:]
