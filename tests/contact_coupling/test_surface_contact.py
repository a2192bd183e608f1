# SPDX-License-Identifier: LGPL-3.0-or-later
"""A shell on closed surfaces of triangles: weight, momentum, checkpoints, what is refused."""

import numpy as np

from contact.body.rigid_surface import RigidSurface
from contact.geometry.triangle_mesh.sphere import sphere
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
