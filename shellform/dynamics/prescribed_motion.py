# SPDX-License-Identifier: LGPL-3.0-or-later
"""Velocities of nodes of prescribed motion, in explicit and in implicit steps.

Explicit steps move a node by its velocity: that is the way to where it is due at the end of a step,
over the step. Implicit steps know the place already and need its rate; Newmark's formula would give
them a velocity that rings about the true one.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np

from shellform.fem.director import along, logarithmic_map, tangent_frames

Rates = tuple[np.ndarray, np.ndarray | None, np.ndarray | None]


def way_to_goal(stepper: Any, dt: float) -> Iterator[Rates]:
    """Yield owned nodes (k,) and the constant rates that bring them to their goals in dt [s].

    Rates are (k, 3) velocities [m/s] and turns of the director [1/s], None where not prescribed.
    """
    for local, u, d in stepper.shell.supports.prescribed(stepper.time + dt):
        mine = local < stepper.n_owned
        nodes, v, q = local[mine], None, None
        if u is not None:
            v = (u[mine] - stepper.owned[nodes, :3]) / dt
        if d is not None:
            now = stepper.owned[nodes, 3:]
            T = tangent_frames(now)
            q = np.einsum("nij,nj->ni", T, logarithmic_map(now, T, d[mine])) / dt
        yield nodes, v, q


def rate_at(stepper: Any, time: float, h: float) -> Iterator[Rates]:
    """Yield nodes and rates as `way_to_goal`, at a time [s]: one-sided differences over h [s].

    Of second order.
    """
    places = [stepper.shell.supports.prescribed(time - k * h) for k in range(3)]
    for (local, u, d), (_, u1, d1), (_, u2, d2) in zip(*places, strict=True):
        mine = local < stepper.n_owned
        nodes, v, q = local[mine], None, None
        if u is not None:
            v = ((3 * u - 4 * u1 + u2) / (2 * h))[mine]
        if d is not None:
            turn = ((3 * d - 4 * d1 + d2) / (2 * h))[mine]
            q = turn - along(turn, stepper.owned[nodes, 3:])
        yield nodes, v, q
