# SPDX-License-Identifier: LGPL-3.0-or-later
"""Where a body is met, at nodes or inside cells: against the elastica, and what must not change."""

from mpi4py import MPI

import numpy as np
import pytest
from scipy.integrate import quad

import meshes
from contact.body.segments import Body, Fixed, Segment
from contact.solver.cell_samples import midpoints
from demos import strip_over_cylinder as demo
from shellform import Fabric, Shell
from shellform.contact_coupling.contact import Contact
from shellform.dynamics.explicit import Newmark
from shellform.results.ledger import Ledger

CLOTH = {"youngs_modulus": 1e6, "poisson_ratio": 0.3, "thickness": 1e-3, "density": 200.0}
G = 9.81


def limb(radii=(0.2, 0.3, 0.25), centre=(0.0, 0.0, -0.25)):
    return Body([Segment("limb", radii, Fixed(centre))])


def sheet(samples, cells=8, shuffle=False, comm=MPI.COMM_WORLD, acceleration=(1.0, 0.0, -G)):
    """A sheet a little above a limb, guided along one side, held at a corner."""
    surface = meshes.rectangle(
        0.5, 0.5, (cells, cells), parameters=meshes.distorted((cells, cells), 0.1, seed=1)
    ).transform(translation=(-0.24, -0.255, 1e-3))
    if shuffle:
        mixed = np.random.default_rng(2).permutation(len(surface.cells))
        surface = surface.replace(cells=surface.cells[mixed])
    shell = Shell(surface, Fabric.isotropic(**CLOTH), comm)
    shell.loads.gravity(acceleration)
    shell.supports.symmetry("left", (1, 0, 0))
    shell.supports.hold(np.array([cells]))
    stepper = Newmark(shell, 0.8, drag=1.0)
    stepper.recheck, stepper.dt = 10**9, 2e-4
    return stepper, stepper.add(Contact(limb(), 0.3, samples=samples))


def test_forces_of_the_elastica_carry_its_weight():
    """Distributed and point forces add up to q S; the tail's moment where it lifts off is D/rho."""
    scene = demo.Scene(membrane=1e9)
    exact = demo.elastica(scene)
    c, h = exact.angle, 1e-6

    def rate(a):
        return (exact.pushed(a + h) - exact.pushed(a - h)) / (2 * h)

    lifted = quad(lambda a: rate(a) * np.cos(a), h, c - 2 * h)[0] + exact.point_force * np.cos(c)
    assert lifted == pytest.approx(scene.q * scene.length, rel=1e-4)
    x = scene.rho * np.sin(c)
    arm = quad(lambda s: exact.shape(s)[2] - x, exact.lift_off, scene.length)[0]
    assert scene.q * arm == pytest.approx(scene.D / scene.rho, rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("samples", [0, 1])
def test_strip_over_a_cylinder(samples):
    """The tip closes in with the square of the cells, to parts of a sag h^2/(8 rho) of a chord.

    Nodes lie on the body: half a sag. Samples lie on chords, which stands the nodes off by a sag:
    within a sag of the elastica on a cylinder that is thicker by one, beyond a sag of the true one.
    """
    scene = demo.Scene()
    exact = demo.elastica(scene)
    meshed, tips = (8, 16, 32), []
    for cells in meshed:
        found = demo.measure(exact, *demo.strip(scene, cells, samples), until=1.5)
        h = scene.length / cells
        sag = h**2 / (8 * scene.rho)
        tips.append(found["tip"] * scene.length)
        if samples:
            thick = demo.elastica(scene._replace(radius=scene.radius + sag))
            assert tips[-1] > sag
            assert np.linalg.norm(found["nodes"][-1] - thick.tip) < sag
        else:
            assert tips[-1] < 0.5 * sag
        assert abs(found["weight"]) < 1e-3
        assert abs(found["angle"]) < 1.5 * h / scene.rho
        assert found["speed"] < 1e-3
    assert demo.order(meshed, tips) > 1.7
    assert abs(found["normal"]) < 0.01 and abs(found["moment"]) < 0.01


def test_samples_close_momentum_and_work():
    """One step from random velocities: impulses are changes of momentum, works those of energy."""
    stepper, touch = sheet(2)
    comm, rng = stepper.shell.comm, np.random.default_rng(3)
    whole = rng.standard_normal((2, len(stepper.shell.surface.points), 3)) * 0.2
    whole[..., 2] -= 1.0
    old, free = whole[:, stepper.shell.partition.owned_nodes]
    stepper.v_old[:], stepper.v[:], stepper.support_impulse[:] = old, free, 0.0
    stepper.shell.w.x.array.reshape(-1, 6)[:, 2] = -2e-3
    touch(stepper, 2e-2)
    last, v = touch.correction.last, stepper.v
    push = last.impulse + stepper.support_impulse
    assert np.abs(push - stepper.mass[:, None] * (v - free)).max() < 1e-15
    assert comm.allreduce(touch.inner.active) > 20
    held = stepper.shell.supports.held[: stepper.n_owned, :3]
    assert np.array_equal(v[held], free[held])
    table = comm.allreduce(last.table)
    place = stepper.points + stepper.owned[:, :3] - [0, 0, -0.25]
    total = comm.allreduce(np.hstack([last.impulse, np.cross(place, last.impulse)]).sum(axis=0))
    assert table[0, :6] == pytest.approx(total, rel=1e-10, abs=1e-13)
    work = comm.allreduce(0.5 * np.vdot(last.impulse, old + v))
    assert table[0, 6] - table[0, 7] - table[0, 8] == pytest.approx(work, rel=1e-9)


@pytest.mark.parametrize("samples", [1, 2])
def test_no_order_among_cells_or_ranks(samples):
    """Cells in another order, and one rank beside all: the same to roundoff, with friction."""
    runs = []
    for shuffle, comm in ((False, MPI.COMM_WORLD), (True, MPI.COMM_WORLD), (False, MPI.COMM_SELF)):
        stepper, _ = sheet(samples, shuffle=shuffle, comm=comm)
        ledger = stepper.add(Ledger())
        stepper.advance(300 * 2e-4)
        row = ledger.record()
        assert row["momentum_residual"] < 1e-13
        assert row["friction_loss"] > 0
        runs.append((stepper.shell.positions(), [row["force_limb_z"], row["moment_limb_x"]]))
    for place, force in runs[1:]:
        assert np.abs(place - runs[0][0]).max() < 1e-9
        assert force == pytest.approx(runs[0][1], rel=1e-6)


def test_cell_rests_on_a_body_between_its_nodes():
    """A cell on a small sphere that its nodes cannot meet: held in the middle, with its weight.

    By the pair of the cell and the sphere where contact meets nodes alone; else by its sample too.
    """
    for samples in ("nodes", 1):
        surface = meshes.rectangle(0.1, 0.1, (1, 1)).transform(translation=(-0.05, -0.05, 1e-3))
        shell = Shell(surface, Fabric.isotropic(1e5, 0.3, 1e-3, 200.0), MPI.COMM_SELF)
        shell.loads.gravity((0, 0, -G))
        stepper = Newmark(shell, 0.5)
        body = limb((0.02, 0.02, 0.02), (0.0, 0.0, -0.02))
        touch = stepper.add(Contact(body, 0.3, samples=samples))
        stepper.advance(0.2)
        touch.correction.reset()
        stepper.advance(0.3)
        force = touch.correction.window.impulse.sum(axis=0) / 0.1
        weight = G * shell.fabric.areal_mass * 0.01
        assert force == pytest.approx([0, 0, weight], abs=1e-3 * weight)
        assert shell.positions()[:, 2].min() > -0.05


def test_weights_and_what_is_refused():
    assert midpoints(1) == pytest.approx(np.full((1, 4), 0.25))
    assert midpoints(3).sum(axis=0) == pytest.approx(np.full(4, 9 / 4))
    for wrong in (-1, 1.5, True):
        with pytest.raises(ValueError, match="k x k points"):
            midpoints(wrong)
    surface = meshes.rectangle(0.1, 0.1, (2, 2), triangles=True)
    stepper = Newmark(Shell(surface, Fabric.isotropic(**CLOTH)), 0.5)
    with pytest.raises(ValueError, match="need cells of four nodes"):
        stepper.add(Contact(limb(), samples=1))
