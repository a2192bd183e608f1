# SPDX-License-Identifier: LGPL-3.0-or-later
"""What supports and still air do to the velocities of implicit steps, and its booking.

Drag acts before the forces of a step: a node at rest feels none, so it leaves weights alone.
"""

import numpy as np

from shellform.fem.director import along


def slowed(stepper, dt):
    """Velocities (n_owned, 6) after the drag of a step; what is held keeps its velocity."""
    velocity = np.hstack([stepper.v, stepper.q])
    if not stepper.drag:
        return velocity
    return velocity - (1 - np.exp(-stepper.drag * dt)) * stepper.equilibrium.free_part(velocity)


def book_drag(stepper, after):
    """Book the impulse and the loss that leave velocities `after` (n_owned, 6) of the present."""
    before = np.hstack([stepper.v, stepper.q])
    inertia = np.repeat(np.column_stack([stepper.mass, stepper.inertia]), 3, axis=1)
    push = inertia * (after - before)
    stepper.work["drag"] -= 0.5 * np.vdot(push, after + before)
    stepper.drag_total += push[:, :3].sum(axis=0)


def constrain(stepper, free, time, dt):
    """Set `v`, `q` to what supports leave of free velocities (n_owned, 6); book their impulses.

    time : float, end of the step of length dt [s]
    """
    velocity = stepper.equilibrium.free_part(free)
    stepper.v[:], stepper.q[:] = velocity[:, :3], velocity[:, 3:]
    if stepper.equilibrium.moves:
        follow(stepper, time, 1e-3 * dt)
    push = stepper.mass[:, None] * (stepper.v - free[:, :3])
    stepper.support_total += push.sum(axis=0)
    stepper.work["support"] += np.vdot(push, stepper.v)


def follow(stepper, time, h):
    """Velocities of nodes of prescribed motion: one-sided differences of second order over h.

    Newmark's formula would give them a velocity that rings about the true one.
    """
    places = [stepper.shell.supports.prescribed(time - k * h) for k in range(3)]
    for (local, u, d), (_, u1, d1), (_, u2, d2) in zip(*places, strict=True):
        mine = local < stepper.n_owned
        nodes = local[mine]
        if u is not None:
            stepper.v[nodes] = ((3 * u - 4 * u1 + u2) / (2 * h))[mine]
        if d is not None:
            turn = ((3 * d - 4 * d1 + d2) / (2 * h))[mine]
            stepper.q[nodes] = turn - along(turn, stepper.owned[nodes, 3:])
