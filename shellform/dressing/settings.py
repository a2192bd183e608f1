# SPDX-License-Identifier: LGPL-3.0-or-later
"""Settings that dressing changes for a while, brought back whatever happens."""

from collections.abc import Iterator
from contextlib import contextmanager

from shellform.contact_coupling.explicit_contact import Touch
from shellform.dynamics.explicit import Newmark
from shellform.dynamics.state import State


@contextmanager
def borrowed(stepper: Newmark, contact: Touch) -> Iterator[None]:
    """Lend a stepper's settings to a block.

    Drag [1/s], friction and the ellipsoids that nodes may meet are afterwards what they were. After
    an error the sheet, its clock and what pulls at it are so too.
    """
    correction, pulls = contact.correction, list(stepper.pulls)
    drag, friction, allowed = stepper.drag, correction.friction, correction.allowed.copy()
    before = State(stepper).keep()
    try:
        yield
    except BaseException:
        before.restore()
        stepper.pulls[:] = pulls
        raise
    finally:
        stepper.drag, correction.friction = drag, friction
        correction.allowed[:] = allowed
