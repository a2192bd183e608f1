# SPDX-License-Identifier: LGPL-3.0-or-later
"""Implicit steps on surfaces of triangles: the oracles of ellipsoids, and the ellipsoids."""

import subprocess
import sys

from mpi4py import MPI

import numpy as np
import pytest

import meshes
from contact.body.rigid_surface import RigidSurface
from contact.body.segments import Body, Fixed, Segment, Steady
from contact.geometry.ellipsoid import closest_points
from contact.geometry.triangle_mesh.sphere import sphere
from contact.solver import held_nodes
from contact.solver.friction import as_friction
from contact.solver.moving_surface import SurfaceObstacle
from contact.solver.step_record import step_record
from demos.studies.contact_methods import scenes
from shellform import Fabric, ImplicitNewmark, Shell
from shellform.contact_coupling.contact import Contact
from shellform.results.ledger import Ledger
from tests.contact.solver.surfaces import tube, valley
from tests.contact_coupling.test_implicit_contact import CLOTH, G
from tests.contact_coupling.test_surface_contact import skinned

OFFSET = 5e-4  # m


def slab(motion, half=0.1, around=8):
    """A flat slab whose top is z = 0, of triangles that nodes cross."""
    s = np.linspace(-half, half, around + 1)
    x, y = (a.ravel() for a in np.meshgrid(s, s, indexing="ij"))
    top, k = np.column_stack([x, y, 0 * x]), np.arange(len(x)).reshape(around + 1, -1)
    a, b, c, d = (q.ravel() for q in (k[:-1, :-1], k[1:, :-1], k[1:, 1:], k[:-1, 1:]))
    faces = np.vstack([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    rim = np.concatenate([k[:, 0], k[-1, 1:], k[-2::-1, -1], k[0, -2:0:-1]])
    low = len(top) + np.arange(len(rim))
    points = np.vstack([top, top[rim] - [0, 0, 0.05], [0, 0, -0.05]])
    turn = np.roll(np.arange(len(rim)), -1)
    sides = [(rim, low, low[turn]), (rim, low[turn], rim[turn])]
    sides += [(low[turn], low, np.full(len(rim), len(points) - 1))]
    faces = np.vstack([faces, *(np.column_stack(side) for side in sides)])
    return RigidSurface(points, faces, motion, "limb")


def patch(body, dt, friction=0.3, gravity=(0.0, 0.0, -G), size=0.02, cells=2, **options):
    """A square that touches z = 0."""
    surface = meshes.rectangle(size, size, (cells, cells))
    surface = surface.transform(translation=(-0.5 * size, -0.5 * size, 5e-4))
    shell = Shell(surface, Fabric.isotropic(**CLOTH))
    shell.loads.gravity(gravity)
    stepper = ImplicitNewmark(shell, dt, **options)
    return stepper, stepper.add(Contact(body, friction, smooth=False))


@pytest.mark.parametrize("slope", [0.4, 0.6])
def test_patch_on_an_incline(slope):
    """mu = 0.5: below it sticks for good, above it slides by (sin - mu cos) g t^2/2."""
    mu, angle, seconds = 0.5, np.arctan(slope), 0.2
    down = G * np.array([np.sin(angle), 0.0, -np.cos(angle)])
    stepper, touch = patch(slab(Fixed()), 0.01, mu, down)
    stepper.advance(0.1 * seconds)
    landed = stepper.shell.displacements()[:, 0]
    stepper.advance(seconds)
    travel = stepper.shell.displacements()[:, 0]
    comm = stepper.shell.comm
    if slope < mu:
        assert np.abs(travel - landed).max() < 1e-13
        assert comm.allreduce(touch.sticking) == comm.allreduce(touch.active) == 9
    else:
        exact = 0.5 * G * (np.sin(angle) - mu * np.cos(angle)) * seconds**2
        assert travel.mean() == pytest.approx(exact, rel=2e-3)
        mass = comm.allreduce(stepper.mass.sum())
        loss = comm.allreduce(touch.window.friction_loss[0])
        assert loss == pytest.approx(mu * mass * G * np.cos(angle) * exact, rel=2e-3)


def test_force_follows_a_body_that_shakes():
    """On a body in harmonic motion the force is m (g + acceleration); the patch goes with it."""
    size, omega = 2e-3, 40.0

    def motion(t):
        centre = np.array([0.0, 0.0, size * np.sin(omega * t)])
        speed = np.array([0.0, 0.0, size * omega * np.cos(omega * t)])
        return centre, np.eye(3), speed, np.zeros(3)

    stepper, touch = patch(slab(motion), 1e-3)
    comm = stepper.shell.comm
    mass = comm.allreduce(stepper.mass.sum())
    stepper.advance(0.05)  # what meets the body at its speed is stopped on it
    forces, exact = [], []
    for _ in range(25):
        stepper.step(1e-3)
        forces.append(comm.allreduce(touch.last.impulse[:, 2].sum()) / 1e-3)
        middle = stepper.time - 0.5e-3
        exact.append(mass * (G - size * omega**2 * np.sin(omega * middle)))
    assert np.abs(np.array(forces) - exact).max() < 0.01 * mass * G


def test_stays_on_a_turning_slab():
    """In stick a patch turns with the body exactly."""
    spin = np.array([0.0, 0.0, 1.0])
    stepper, touch = patch(slab(Steady((0.0, 0.0, 0.0), spin=spin)), 5e-3, friction=1.0)
    shell = stepper.shell
    x = shell.positions()
    stepper.v[:] = np.cross(spin, x[shell.partition.owned_nodes])
    stepper.advance(0.1)
    c, s = np.cos(0.1), np.sin(0.1)
    turned = x @ np.array([(c, s, 0.0), (-s, c, 0.0), (0.0, 0.0, 1.0)])
    assert np.abs(shell.positions() - turned).max() < 2e-6
    assert shell.comm.allreduce(touch.sticking) == 9


@pytest.mark.serial
@pytest.mark.parametrize("speed", [pytest.param(1.0, marks=pytest.mark.thorough), 20.0])
def test_impact_of_a_patch(speed):
    """Nothing passes through, momentum is exact, energy does not grow, whatever the step."""
    surface = meshes.rectangle(0.04, 0.04, (4, 4)).transform(translation=(-0.02, -0.02, 0.01))
    shell = Shell(surface, Fabric.isotropic(**CLOTH))
    # one step at 20 m/s crosses the sphere
    stepper = ImplicitNewmark(shell, 5e-3, alpha=-0.3)
    stepper.v[:, 2] = -speed
    ball = RigidSurface(*sphere(0.04, 3), Fixed((0, 0, -0.04)), "limb")
    stepper.add(Contact(ball))
    ledger = stepper.add(Ledger())
    start = ledger.record()["kinetic"]
    for _ in range(6):
        stepper.advance(stepper.time + 0.01 / speed)
        row = ledger.record()
        assert row["kinetic"] + row["strain"] < start * (1 + 1e-6)
        assert row["momentum_residual"] < 1e-12
        gaps = np.linalg.norm(shell.positions() + [0, 0, 0.04], axis=1) - 0.04 - 5e-4
        assert gaps.min() > -2e-9
    assert sum(row["force_limb_z"] for row in ledger.rows) > 0  # it has met the body


def held(surface, x0, x1, smooth=True):
    """Nodes that went from x0 (n, 3) to x1 (n, 3), until nothing more is met."""
    n, changed, work = len(x0), np.zeros(len(x0), bool), step_record(as_friction(0.3), OFFSET)
    obstacle, nodes = SurfaceObstacle(surface, None, n, OFFSET, smooth, ()), held_nodes.new(n)
    obstacle.move(0.0, 1e-3)
    locate, world = obstacle.kernels.locate, obstacle.world
    locate(True, x0, x0, changed, work[0], world, nodes)
    x1 = x1.copy()
    for _ in range(4):
        if not locate(False, x0, x1, changed, work[0], world, nodes)[0]:
            break
        # a solve puts nodes that slip on their first plane
        n = nodes.normal[:, 0]
        x1 -= (np.sum(n * x1, axis=1) - nodes.height[:, 0])[:, None] * n
    return nodes


@pytest.mark.serial
def test_nodes_lie_on_an_ellipsoid_as_triangles_grow_small():
    """Anchors of nodes that came in from 3 mm outside: off the ellipsoid by second order."""
    axes, place = np.array([0.1, 0.06, 0.08]), Fixed((0.0, 0.0, -0.08))
    rng = np.random.default_rng(3)
    foot = rng.normal(size=(300, 3))
    foot = axes * foot / np.linalg.norm(foot, axis=1)[:, None]
    normal = foot / axes**2
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    foot = foot - [0.0, 0.0, 0.08]
    off, turned = [], []
    for divisions in (2, 3, 4):
        vertices, triangles = sphere(1.0, divisions)
        body = RigidSurface(vertices * axes, triangles, place, "limb")
        nodes = held(body, foot + 3e-3 * normal, foot - 2e-3 * normal)
        assert (nodes.state == held_nodes.STICK).all()
        assert (nodes.owner[:, 0] == 0).all() and (nodes.owner[:, 1] == -1).all()
        _, _, distance = closest_points(nodes.anchor, axes, place.centre)
        off.append(np.sqrt(np.mean((distance - OFFSET) ** 2)))
        turned.append(np.sqrt(np.mean((nodes.normal[:, 0] - normal) ** 2)))
    for errors in (off, turned):
        assert errors[0] > 3 * errors[1] > 9 * errors[2] > 0
    assert off[1] < 2e-5


@pytest.mark.serial
def test_a_crease_holds_by_both_sides():
    """A node that comes down on the bottom of a valley has two planes and stands on both."""
    half, down = np.radians(60.0), np.array([[0.0, 1e-3, -3e-3]])
    nodes = held(valley(half), np.array([[0.0, 4e-3, 1e-2]]), down, smooth=False)
    assert (nodes.owner[0] >= 0).tolist() == [True, True, False]
    assert nodes.anchor[0] == pytest.approx([0.0, 0.0, OFFSET / np.sin(half)], abs=1e-12)


@pytest.mark.serial
def test_friction_gives_no_energy():
    """A sheet that comes down on both sides of a valley is not thrown out of it."""
    surface = meshes.rectangle(0.04, 0.02, (2, 4)).transform(translation=(-0.02, -0.01, 8e-3))
    shell = Shell(surface, Fabric.isotropic(**CLOTH))
    shell.loads.gravity((0.0, 0.0, -G))
    stepper = ImplicitNewmark(shell, 2e-3, alpha=-0.3, drag=20.0)
    stepper.add(Contact(valley(np.radians(60.0)), 0.5, smooth=False))
    stepper.advance(0.03)
    for _ in range(15):
        stepper.step(2e-3)
        assert shell.positions()[:, 2].max() < 8e-3


def sheet(comm, shapes=()):
    """A sheet a little above a limb of two segments under one skin, steps of 2 ms."""
    surface = meshes.rectangle(0.4, 0.3, (6, 5)).transform(translation=(-0.19, -0.16, 5e-4))
    shell = Shell(surface, Fabric.isotropic(**CLOTH), comm)
    shell.loads.gravity((0.0, 0.0, -G))
    stepper = ImplicitNewmark(shell, 2e-3, alpha=-0.3, drag=5.0)
    body, skin = skinned()
    if shapes:
        body = Body([*body.segments, Segment("knee", [0.1] * 3, Fixed((-0.123, -0.04, -0.1)))])
    return stepper, stepper.add(Contact(body, 0.3, surface=skin, shapes=shapes))


@pytest.mark.parametrize("shapes", [(), ("knee",)])
def test_momentum_and_virtual_power_close(shapes):
    """What segments give by their velocities and spins is what cloth gets, in every step."""
    stepper, contact = sheet(MPI.COMM_WORLD, shapes)
    comm, body = stepper.shell.comm, contact.body
    ledger = stepper.add(Ledger())
    ledger.record()
    pose, powers, works, both = body.new_pose(), [], [], np.zeros(len(body))
    for _ in range(12):
        stepper.step(2e-3)
        table = comm.allreduce(contact.last.table)
        impulse = comm.allreduce(contact.last.impulse.sum(axis=0))
        assert np.abs(table[:, :3].sum(axis=0) - impulse).max() <= 1e-12 * np.abs(table).max()
        body.pose(stepper.time, pose)
        powers.append(np.vdot(table[:, :3], pose.velocities) + np.vdot(table[:, 3:6], pose.spins))
        works.append(table[:, 6].sum())
        both += np.abs(table[:, :3]).sum(axis=1) > 0
    assert (both > 3).all()
    assert np.abs(np.subtract(powers, works)).max() < 1e-6 * np.abs(works).max()
    assert ledger.record()["momentum_residual"] < 1e-12


def test_forces_of_segments_are_the_same_on_one_rank_and_on_all():
    runs = []
    for comm in (MPI.COMM_SELF, MPI.COMM_WORLD):
        stepper, contact = sheet(comm)
        forces = []
        for _ in range(12):
            stepper.step(2e-3)
            forces.append(comm.allreduce(contact.last.table[:, :6]).ravel())
        runs.append(np.array(forces))
    assert np.abs(runs[0]).max() > 0
    assert np.abs(runs[0] - runs[1]).max() <= 1e-9 * np.abs(runs[1]).max()


@pytest.mark.serial
def test_a_sleeve_of_triangles_presses_as_one_of_an_ellipsoid():
    """Its hoop tension over the radius, to 1 %."""
    errors = []
    for triangles in (False, True):
        shell, body = scenes.stretched_sleeve()
        if triangles:
            body = tube(scenes.RADIUS - 5e-4, 1.0, 44, 22)
        stepper = ImplicitNewmark(shell, 5e-3, alpha=-0.3, drag=60.0)
        contact = stepper.add(Contact(body, 0.0))
        stepper.advance(0.05)
        force = shell.partition.gather(contact.last.impulse / contact.last.seconds)
        errors.append(scenes.error_of_sleeve(force, shell.positions()))
    assert abs(errors[1]) < 0.01
    assert errors[1] == pytest.approx(errors[0], abs=1e-4)


@pytest.mark.serial
def test_nothing_of_it_without_a_surface():
    program = (
        "import sys, meshes, shellform as sf\n"
        "shell = sf.Shell(meshes.rectangle(0.4, 0.4, (4, 4)), sf.Fabric.isotropic(1e5, 0.3, 1e-3,"
        " 200.0))\n"
        "ball = sf.Body([sf.Segment('ball', [0.2] * 3, sf.Fixed((0.2, 0.2, -0.202)))])\n"
        "sf.ImplicitNewmark(shell, 1e-3).add(sf.Contact(ball))\n"
        "print([m for m in sys.modules if 'triangle_mesh' in m or 'surface_obstacle' in m])\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.returncode == 0 and done.stdout.split("\n")[-2] == "[]", done.stderr[-1000:]
