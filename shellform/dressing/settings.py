# SPDX-License-Identifier: LGPL-3.0-or-later
"""Settings that dressing changes for a while, brought back whatever happens."""

from collections.abc import Iterator
from contextlib import contextmanager

from shellform.contact_coupling.contact import require_contact
from shellform.dynamics.explicit import Newmark
from shellform.dynamics.state import State


@contextmanager
def borrowed(stepper: Newmark) -> Iterator[None]:
    """Lend a stepper's settings to a block.

    Drag [1/s], friction and the ellipsoids that nodes may meet are afterwards what they were. After
    an error the sheet, its clock and the forces applied to it are so too.
    """
    contact, forces = require_contact(stepper, "dressing"), list(stepper.external.applied)
    allowed = contact.correction.allowed
    drag, friction, reach = stepper.drag, contact.friction, allowed.copy()
    before = State(stepper).keep()
    try:
        yield
    except BaseException:
        before.restore()
        stepper.external.applied[:] = forces
        raise
    finally:
        stepper.drag, contact.friction = drag, friction
        allowed[:] = reach
