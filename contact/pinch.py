# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cloth in a crease between two parts of the body, which are soft.

Rigid ellipsoids that close over cloth, as calf and thigh do at a bent knee, squeeze it out of the
crease between them with any force, and tear it: the crease moves on as they overlap more. Flesh
gives way and keeps the cloth. So two parts push a point together with at most a pressure p on both
sides of it: with normals at an angle theta, pushes of p A each along both would give the resultant
2 p A cos(theta/2); it is limited to p A (1 + cos(theta)), the part of that along the way out, as
what is left of the two pressures is flesh on flesh, the wearer's own. A point that needs more goes
into the crease; bodies that part bring it out again.

Ellipsoids on one and the same rigid segment (`mates`) make a hard crease, as one body does.
"""

import numpy as np
from numba import njit


@njit(cache=True, error_model="numpy")
def apart(planes, count, travel):
    """Least cosine between the normals of two planes that belong to different segments; else 1."""
    least = 1.0
    for k in range(count):
        for j in range(k):
            if (travel[planes[k].owner].mates >> planes[j].owner) & 1:
                continue
            p, q = planes[k].normal, planes[j].normal
            least = min(least, p[0] * q[0] + p[1] * q[1] + p[2] * q[2])
    return least


@njit(cache=True, error_model="numpy")
def yielded(planes, count, travel, limit):
    """Part of the pushes that soft bodies transmit.

    planes : (m,) PLANE with pushes; limit : float [m], p A dt^2 over the mass
    """
    cosine = apart(planes, count, travel)
    if cosine == 1.0:
        return 1.0
    r0 = r1 = r2 = 0.0
    for k in range(count):
        push, n = planes[k].push, planes[k].normal
        r0, r1, r2 = r0 + push * n[0], r1 + push * n[1], r2 + push * n[2]
    needed, limit = np.sqrt(r0 * r0 + r1 * r1 + r2 * r2), limit * (1.0 + cosine)
    return 1.0 if needed <= limit else limit / needed


def mates_of(body):
    """Sets (m,) of the ellipsoids that move as one with each: that have the same entry in the
    `carriers` of a body that has them, as a Wearer; else each alone."""
    names = getattr(body, "carriers", None)
    m = len(body.radii)
    if names is None:
        return np.array([1 << b for b in range(m)], np.int64)
    return np.array([sum(1 << a for a in range(m) if names[a] == n) for n in names], np.int64)
