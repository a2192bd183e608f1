# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a solve of an implicit step holds of nodes in contact: axes, and places along them.

A node that slips is held along the normals of its planes, made orthogonal in turn; one that sticks
in all directions. Directions that supports hold come first and stay as they are.
"""

import numpy as np

from contact.kernel import kernel

from .held_nodes import OPEN, PLANES, STICK, Set, dot


@kernel
def constrain(
    points: np.ndarray,
    owned: np.ndarray,
    nodes: Set,
    own_axes: np.ndarray,
    guided: np.ndarray,
    axes: np.ndarray,
    held: np.ndarray,
    goal: np.ndarray,
) -> None:
    """Axes, held directions and displacements along them (Inertial.hold) from the set.

    owned (n, 6) : displacements, first, of the nodes; own_axes (n, 3, 3), guided (n, 3) bool : axes
    of the supports, and which of them they hold. These stay, and contact holds of the others.
    """
    n, known = np.zeros(3), np.zeros(3, np.bool_)
    for i in range(len(points)):
        for k in range(3):
            known[k], held[i, k], goal[i, k] = guided[i, k], False, 0.0
            for c in range(3):
                axes[i, k, c] = own_axes[i, k, c]
        if nodes.state[i] <= OPEN:
            continue
        free = 3 - known.sum()
        if nodes.state[i] == STICK and free == 3:
            for c in range(3):
                held[i, c], goal[i, c] = True, dot(axes[i, c], nodes.anchor[i] - points[i])
            continue
        for k in range(3):
            if known[k]:
                goal[i, k] = dot(axes[i, k], owned[i, :3])
        for k in range(PLANES):
            if nodes.owner[i, k] < 0 or free == 0:
                continue
            n[:] = nodes.normal[i, k]
            g = nodes.height[i, k] - dot(n, points[i])
            for j in range(3):
                if known[j]:
                    along = dot(axes[i, j], n)
                    g -= along * goal[i, j]
                    n -= along * axes[i, j]
            size = np.sqrt(dot(n, n))
            if size < 1e-6:
                continue
            j = 0
            while known[j]:
                j += 1
            axes[i, j] = n / size
            goal[i, j] = g / size
            known[j], held[i, j] = True, True
            free -= 1
        _complete(axes[i], known)
        if nodes.state[i] == STICK:
            for k in range(3):
                if not known[k]:
                    goal[i, k], held[i, k] = dot(axes[i, k], nodes.anchor[i] - points[i]), True


@kernel
def _complete(rows, known):
    """Fill rows (3, 3), of which `known` (3,) are orthonormal, to a right-handed basis."""
    count, first = 0, 0
    for k in range(3):
        if known[k]:
            count, first = count + 1, k
    if count == 0:
        return
    if count == 1:
        a, second = rows[first], (first + 1) % 3
        k = np.argmin(np.abs(a))
        b = np.zeros(3)
        b[k] = 1.0
        b -= a[k] * a
        rows[second] = b / np.sqrt(dot(b, b))
    for k in range(3):
        if (count == 1 and k == (first + 2) % 3) or (count == 2 and not known[k]):
            a, b = rows[(k + 1) % 3], rows[(k + 2) % 3]
            for c in range(3):
                d, e = (c + 1) % 3, (c + 2) % 3
                rows[k, c] = a[d] * b[e] - a[e] * b[d]
