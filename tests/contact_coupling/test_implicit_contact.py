# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contact under implicit steps: weight, momentum, incline, moving body, impact."""

import re

import numpy as np
import pytest

import meshes
from contact.body.segments import Body, Fixed, Segment, Steady
from contact.geometry.capsule import Capsule
from shellform import Fabric, Shell
from shellform.contact_coupling.contact import Contact
from shellform.dynamics.explicit import Newmark
from shellform.dynamics.implicit import ImplicitNewmark
from shellform.dynamics.implicit_midpoint import ImplicitMidpoint
from shellform.results.ledger import Ledger

CLOTH = {"youngs_modulus": 1e6, "poisson_ratio": 0.3, "thickness": 1e-3, "density": 200.0}
G = 9.81


def patch(size, cells, motion, dt, radius=0.25, friction=0.3, gravity=(0.0, 0.0, -G), **options):
    """A square whose middle touches the top of a sphere; z = 0 is the sphere's top."""
    surface = meshes.rectangle(size, size, (cells, cells))
    surface = surface.transform(translation=(-0.5 * size, -0.5 * size, 5e-4))
    shell = Shell(surface, Fabric.isotropic(**CLOTH))
    shell.loads.gravity(gravity)
    stepper = ImplicitNewmark(shell, dt, **options)
    body = Body([Segment("limb", [radius] * 3, motion)])
    return stepper, stepper.add(Contact(body, friction))


def below(radius=0.25):
    return Fixed((0.0, 0.0, -radius))


@pytest.mark.slow
def test_free_sheet_rests_with_its_weight_on_the_body():
    """Mean contact force at rest is the weight, to 0.1 % up and aside; momentum closes."""
    stepper, _ = patch(0.4, 4, below(), 0.01, alpha=-0.3, drag=8.0)
    ledger = stepper.add(Ledger())
    weight = stepper.shell.comm.allreduce(stepper.mass.sum()) * G
    stepper.advance(1.5)
    row = ledger.record()
    assert row["momentum_residual"] < 1e-10 * weight
    stepper.drag = 0.0  # what rests must stay so by itself
    stepper.advance(2.0)
    row = ledger.record()
    force = np.array([row[f"force_limb_{a}"] for a in "xyz"])
    assert row["active"] > 1
    assert np.abs(force - [0, 0, weight]).max() < 1e-3 * weight
    assert row["momentum_residual"] < 1e-10 * weight
    assert row["kinetic"] < 1e-6
    gaps = np.linalg.norm(stepper.shell.positions() + [0, 0, 0.25], axis=1) - 0.25 - 5e-4
    assert gaps.min() > -2e-9


@pytest.mark.parametrize("slope", [0.4, 0.6])
def test_patch_on_an_incline(slope):
    """mu = 0.5: below it sticks for good, above it slides by (sin - mu cos) g t^2/2."""
    radius, mu, angle, seconds = 1e4, 0.5, np.arctan(slope), 0.5
    down = G * np.array([np.sin(angle), 0.0, -np.cos(angle)])
    stepper, touch = patch(0.02, 2, below(radius), 0.01, radius, mu, down)
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
        loss = comm.allreduce(touch.window.friction_loss[0])
        mass = comm.allreduce(stepper.mass.sum())
        assert loss == pytest.approx(mu * mass * G * np.cos(angle) * exact, rel=2e-3)


def test_patch_with_guided_sides_slides_on_an_incline():
    """Nodes that a support keeps in a plane are met too: it takes nothing from them along it."""
    radius, mu, angle, seconds = 1e4, 0.5, np.arctan(0.6), 0.3
    surface = meshes.rectangle(0.02, 0.02, (2, 2)).transform(translation=(-0.01, -0.01, 5e-4))
    shell = Shell(surface, Fabric.isotropic(**CLOTH))
    shell.loads.gravity(G * np.array([np.sin(angle), 0.0, -np.cos(angle)]))
    for edge in ("bottom", "top"):
        shell.supports.symmetry(edge, (0, 1, 0))
    stepper = ImplicitNewmark(shell, 0.01)
    touch = stepper.add(Contact(Body([Segment("limb", [radius] * 3, below(radius))]), mu))
    ledger = stepper.add(Ledger())
    ledger.record()
    stepper.advance(seconds)
    exact = 0.5 * G * (np.sin(angle) - mu * np.cos(angle)) * seconds**2
    assert shell.displacements()[:, 0].mean() == pytest.approx(exact, rel=2e-3)
    assert shell.comm.allreduce(touch.active) == 9
    assert ledger.record()["momentum_residual"] < 1e-12


def test_force_follows_a_body_that_shakes():
    """On a body in harmonic motion the force is m (g + acceleration); the patch goes with it."""
    size, omega, radius = 2e-3, 40.0, 1e3

    def motion(t):
        centre = np.array([0.0, 0.0, -radius + size * np.sin(omega * t)])
        speed = np.array([0.0, 0.0, size * omega * np.cos(omega * t)])
        return centre, np.eye(3), speed, np.zeros(3)

    stepper, touch = patch(0.02, 2, motion, 1e-3, radius)
    comm = stepper.shell.comm
    mass = comm.allreduce(stepper.mass.sum())
    stepper.advance(0.1)  # what meets the body at its speed is stopped on it
    forces, exact = [], []
    for _ in range(100):
        stepper.step(1e-3)
        forces.append(comm.allreduce(touch.last.impulse[:, 2].sum()) / 1e-3)
        middle = stepper.time - 0.5e-3
        exact.append(mass * (G - size * omega**2 * np.sin(omega * middle)))
    assert np.abs(np.array(forces) - exact).max() < 0.01 * mass * G


def test_stays_on_a_turning_belt():
    """In stick a patch moves with the body exactly: the top of a large sphere that turns."""
    radius = 100.0
    motion = Steady((0.0, 0.0, -radius), spin=(0.0, 0.01, 0.0))
    stepper, touch = patch(0.02, 2, motion, 5e-3, radius, friction=1.0)
    stepper.v[:, 0] = 0.01 * radius
    stepper.advance(0.1)
    assert stepper.shell.displacements()[:, 0] == pytest.approx(0.01 * radius * 0.1, rel=1e-4)
    assert stepper.shell.comm.allreduce(touch.sticking) == 9


@pytest.mark.parametrize("speed", [1.0, 20.0])
def test_impact_of_a_patch(speed):
    """Nothing passes through, momentum is exact, energy does not grow, whatever the step."""
    surface = meshes.rectangle(0.04, 0.04, (4, 4)).transform(translation=(-0.02, -0.02, 0.01))
    shell = Shell(surface, Fabric.isotropic(**CLOTH))
    # one step at 20 m/s crosses the sphere
    stepper = ImplicitNewmark(shell, 5e-3, alpha=-0.3)
    stepper.v[:, 2] = -speed
    stepper.add(Contact(Body([Segment("limb", [0.04] * 3, Fixed((0, 0, -0.04)))])))
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


def test_wrong_settings_are_refused():
    body = Body([Segment("limb", [0.5] * 3, Fixed())])
    shell = Shell(meshes.rectangle(1.0, 1.0, (2, 2)), Fabric.isotropic(**CLOTH))
    with pytest.raises(ValueError, match="midpoint steps know no contact"):
        ImplicitMidpoint(shell, 1e-3).add(Contact(body))
    stepper = ImplicitNewmark(shell, 1e-3)
    with pytest.raises(ValueError, match="recovery speed is positive"):
        stepper.add(Contact(body, recovery=0.0))
    stepper.add(Contact(body))
    with pytest.raises(ValueError, match="has a body already"):
        stepper.add(Contact(body))


@pytest.mark.parametrize(
    "shape", [Capsule(1.0, 0.02), (0.3, 0.02, 0.3), (0.025, 0.025, 0.025)], ids=str
)
def test_what_passes_between_nodes_is_refused(shape):
    """Rod, blade and ball under cells of 40 mm; explicit steps meet them at edges, and so do
    implicit steps with nodes as far apart as the sentence says."""
    body = Body([Segment("limb", (0.2, 0.2, 0.2), Fixed()), Segment("thin", shape, Fixed())])
    fabric = Fabric.isotropic(**CLOTH)

    def sheet(cell):
        size = 5 * cell
        return Shell(meshes.rectangle(size, size, (5, 5)), fabric)

    sentence = r"'thin', \d+ mm thick, .* of cells 56.6 mm across.*take Newmark.* below ([\d.]+) mm"
    with pytest.raises(ValueError, match=sentence) as refused:
        ImplicitNewmark(sheet(0.04), 1e-3).add(Contact(body))
    below = 1e-3 * float(re.search(sentence, str(refused.value))[1])
    assert ImplicitNewmark(sheet(below), 1e-3).add(Contact(body)).active == 0
    with pytest.raises(ValueError, match="can pass between nodes"):
        ImplicitNewmark(sheet(1.01 * below), 1e-3).add(Contact(body))
    assert Newmark(sheet(0.04)).add(Contact(body)).edges is not None
