# SPDX-License-Identifier: LGPL-3.0-or-later
r"""Friction on nodes that slip, as a force that the solve of an implicit step follows.

A node that has slipped by w along its planes in the step is rubbed by

    t = -c w/|w|,   t = -c w/s where |w| < s,

c being its kinetic friction from the normal force of the solve before, s a way that is none to the
accuracy of positions: a node that ends there sticks. Friction is against the slip in every solve,
so it takes energy and never gives any; its stiffness is symmetric,

    c/|w| (T - w w/|w|^2),   c/s T,

T being the plane of the directions that are left free.
"""

import numpy as np

from contact.kernel import kernel

from .held_nodes import SLIP, Set


@kernel
def slip_friction(
    points: np.ndarray,
    owned: np.ndarray,
    nodes: Set,
    axes: np.ndarray,
    held: np.ndarray,
    least: float,
    force: np.ndarray,
    stiffness: np.ndarray,
) -> None:
    """Fill force (n, 3) [N] and stiffness (n, 3, 3) [N/m] of the friction on nodes that slip.

    points (n, 3), owned (n, 6) : places at rest and displacements, first, of the nodes [m]
    axes (n, 3, 3), held (n, 3) : directions in which nodes do not slip; least : s [m]
    """
    w, plane = np.empty(3), np.empty((3, 3))
    for i in range(len(points)):
        for c in range(3):
            force[i, c] = 0.0
            for d in range(3):
                stiffness[i, c, d] = 0.0
        if nodes.state[i] != SLIP or not nodes.cone[i] > 0.0:
            continue
        w[:], plane[:] = 0.0, 0.0
        for k in range(3):
            if held[i, k]:
                continue
            along = 0.0
            for c in range(3):
                along += axes[i, k, c] * (points[i, c] + owned[i, c] - nodes.anchor[i, c])
            for c in range(3):
                w[c] += along * axes[i, k, c]
                for d in range(3):
                    plane[c, d] += axes[i, k, c] * axes[i, k, d]
        size = np.sqrt(w[0] ** 2 + w[1] ** 2 + w[2] ** 2)
        slope = nodes.cone[i] / max(size, least)
        turns = 1.0 / size**2 if size > least else 0.0
        for c in range(3):
            force[i, c] = -slope * w[c]
            for d in range(3):
                stiffness[i, c, d] = slope * (plane[c, d] - turns * w[c] * w[d])
