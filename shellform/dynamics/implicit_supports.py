# SPDX-License-Identifier: LGPL-3.0-or-later
"""What supports and still air do to the velocities of implicit steps, and its booking.

Drag acts before the forces of a step: a node at rest feels none, so it leaves weights alone.
"""

from typing import Any

import numpy as np

from .books import BY_DRAG, BY_SUPPORTS, DRAG, SUPPORT
from .prescribed_motion import rate_at


def slowed(stepper: Any, dt: float) -> np.ndarray:
    """Velocities (n_owned, 6) after the drag of a step; what is held keeps its velocity."""
    velocity = np.hstack([stepper.v, stepper.q])
    if not stepper.drag:
        return velocity
    return velocity - (1 - np.exp(-stepper.drag * dt)) * stepper.equilibrium.free_part(velocity)


def book_drag(stepper: Any, after: np.ndarray) -> None:
    """Book the impulse and the loss that leave velocities `after` (n_owned, 6) of the present."""
    before = np.hstack([stepper.v, stepper.q])
    inertia = np.repeat(np.column_stack([stepper.mass, stepper.inertia]), 3, axis=1)
    push = inertia * (after - before)
    stepper.books.works[DRAG] -= 0.5 * np.vdot(push, after + before)
    stepper.books.impulses[BY_DRAG] += push[:, :3].sum(axis=0)


def constrain(stepper: Any, free: np.ndarray, time: float, dt: float) -> None:
    """Set `v`, `q` to what supports leave of free velocities (n_owned, 6); book their impulses.

    time : float, end of the step of length dt [s]
    """
    velocity = stepper.equilibrium.free_part(free)
    stepper.v[:], stepper.q[:] = velocity[:, :3], velocity[:, 3:]
    if stepper.equilibrium.moves:
        for nodes, v, q in rate_at(stepper, time, 1e-3 * dt):
            if v is not None:
                stepper.v[nodes] = v
            if q is not None:
                stepper.q[nodes] = q
    push = stepper.mass[:, None] * (stepper.v - free[:, :3])
    stepper.books.impulses[BY_SUPPORTS] += push.sum(axis=0)
    stepper.books.works[SUPPORT] += np.vdot(push, stepper.v)
