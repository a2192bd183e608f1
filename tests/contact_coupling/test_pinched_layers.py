# SPDX-License-Identifier: LGPL-3.0-or-later
"""Layers between two closing parts of the body, which leave them no room: no energy by them."""

from mpi4py import MPI

import numpy as np
import pytest

from contact.body.segments import Body, Fixed, Segment, Steady
from contact.solver.contact_ledger import WORK
from shellform.contact_coupling.contact import Contact
from shellform.results.ledger import Ledger
from tests.contact_coupling.layers import THICKNESS, square, stepper_of, together

LAYERS, FLESH = 3, 2e5


def pinched(radii, friction, speed):
    """Three layers, turned against each other, on a limb on which another comes down, askew."""
    sheets = [
        square(
            6 + k % 2,
            0.2,
            turn=(0.0, 0.0, 0.3 * k),
            shift=(1e-3 * k, 2e-3, THICKNESS * (0.51 + 1.01 * k)),
        )
        for k in range(LAYERS)
    ]
    stepper = stepper_of(together(*sheets)[0], drag=1.0, damping=1e-4)
    height = radii[2] + 1.02 * LAYERS * THICKNESS + 1e-3
    way = Steady((0.0, 0.0, height), np.eye(3), (0.2 * speed, 0.0, -speed))
    limbs = [
        Segment("below", radii, Fixed((0.0, 0.0, -radii[2]))),
        Segment("above", radii, way),
    ]
    how = {"self_contact": True, "flesh_stiffness": FLESH}
    return stepper, stepper.add(Contact(Body(limbs), friction, **how))


@pytest.mark.parametrize(
    ("radii", "friction", "speed"),
    [([0.06, 0.06, 0.06], 0.3, 0.5), ([0.06, 0.3, 0.06], 0.02, 1.0)],
)
def test_layers_give_no_energy_that_the_body_does_not(radii, friction, speed, comm):
    """Cloth on cloth does no work but what moves layers apart that start a step too close.

    Step for step, by the books of energy; and nothing becomes faster than limbs can squeeze it out.
    Nor do layers pass each other, which the limbs would push through each other (at 20 and 146
    places when the body had the last word); and the books of energy close.
    """
    stepper, contact = pinched(radii, friction, speed)
    cloth, gained, booked = contact.cloth, 0.0, 0.0
    ledger = stepper.add(Ledger())
    while stepper.time < 0.012:
        stepper.step(stepper.dt)
        rows, before = cloth.solver.rows, booked
        booked = cloth.losses.sum()
        gained += max(0.0, before - booked - rows["push"] @ np.maximum(rows["bound"], 0.0))
        assert cloth.intersections() == 0
    work = comm.allreduce(contact.window.table[:, WORK].sum())
    fastest = comm.allreduce(np.abs(stepper.v).max(initial=0.0), MPI.MAX)
    print(f"{cloth.limited} at a limit, {gained:.2e} J of {work:.2e} J, {fastest:.1f} m/s")
    assert cloth.limited > 3 and work > 1e-4
    assert gained < 0.02 * work
    assert fastest < 10 * speed
    assert cloth.solver.relaxation.parted > 3  # steps in which layers had the last word
    assert abs(ledger.record()["energy_residual"]) < 0.03 * work  # of the time step
