# SPDX-License-Identifier: LGPL-3.0-or-later
"""A sheet lifted and spun by a body that it sticks to: contact gives m (a - g)."""

import numpy as np
import pytest

import meshes
from contact.body.rigid_surface import RigidSurface
from contact.body.segments import Body, Segment
from shellform import Fabric, Shell
from shellform.contact_coupling.contact import Contact
from shellform.dynamics.explicit import Newmark
from shellform.results.ledger import Ledger
from tests.contact.solver.surfaces import box

G, LIFT, SPIN, ARM = 9.81, 3.0, 2.0, 0.3
RADII = (30.0, 30.0, 1.0)  # flat where the sheet lies


def platform(t):
    """Centre, axes, velocity, spin: accelerated upwards, spinning about the vertical."""
    c, s = np.cos(SPIN * t), np.sin(SPIN * t)
    axes = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    centre = np.array([0.0, 0.0, -RADII[2] + 0.5 * LIFT * t**2])
    return centre, axes, np.array([0.0, 0.0, LIFT * t]), np.array([0.0, 0.0, SPIN])


def slab():
    """The platform as a box of triangles, its top where the ellipsoid's is."""
    block = box((0.6, 0.6, RADII[2]), 9)
    return RigidSurface(block.local, block.triangles, platform, "platform")


@pytest.mark.parametrize(
    ("arm", "kind"), [(0.0, "ellipsoid"), (ARM, "ellipsoid"), (ARM, "triangles")]
)
def test_reaction_is_mass_times_acceleration(arm, kind):
    """Mean force over a time: the change of momentum of the platform's points, less the weight."""
    side, thickness = 0.1, 1e-3
    surface = meshes.rectangle(side, side, (4, 4))
    surface = surface.transform(translation=(arm - 0.5 * side, -0.5 * side, 0.5 * thickness))
    shell = Shell(surface, Fabric.isotropic(1e5, 0.3, thickness, 200.0))
    shell.loads.gravity((0.0, 0.0, -G))
    stepper = Newmark(shell, 0.8, damping=2e-4)
    stepper.v[:] = np.cross([0.0, 0.0, SPIN], stepper.points)
    body = Body([Segment("platform", RADII, platform)]) if kind == "ellipsoid" else slab()
    touch = stepper.add(Contact(body, friction=5.0))
    ledger = stepper.add(Ledger())
    stepper.advance(0.2)
    ledger.record()
    start = stepper.time
    stepper.advance(0.5)
    row = ledger.record()
    force = np.array([row[f"force_platform_{a}"] for a in "xyz"])

    def velocity(t):
        return np.array([-np.sin(SPIN * t), np.cos(SPIN * t), 0.0]) * SPIN * arm + [0, 0, LIFT * t]

    mass = 200.0 * thickness * side**2
    end = stepper.time
    acceleration = (velocity(end) - velocity(start)) / (end - start)
    exact = mass * (acceleration + [0.0, 0.0, G])
    if arm:
        assert np.linalg.norm(exact[:2]) > 0.05 * exact[2]  # the centripetal part is not small
    assert np.abs(force - exact).max() < 1e-3 * exact[2]
    assert row["active"] > 0
    assert stepper.shell.comm.allreduce(touch.correction.sticking) == row["active"]
    # what the body gave is what the sheet has gained
    gained = row["kinetic"] - ledger.rows[0]["kinetic"]
    height = 0.5 * LIFT * (end**2 - start**2)
    work = row["body_work"] - row["friction_loss"] - row["impact_loss"]
    assert work == pytest.approx(gained + mass * G * height, rel=2e-3)
