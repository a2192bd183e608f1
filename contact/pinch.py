# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cloth between two parts of the body that close over it, as calf and thigh do at a bent knee.

Rigid ellipsoids would squeeze the cloth out of the crease between them with any force, and tear it:
the crease moves on as they overlap more. Flesh gives way and keeps the cloth. So a point that two
segments push together with more than a given pressure slips in between: as long as they close over
it, neither pushes it, since what flesh does to cloth from both sides is equal and opposite, and
what it does to the other flesh is the wearer's own. The point goes where the cloth takes it. When
one of them is LINGER away, or both have left it, it is met as any other.

Ellipsoids on one and the same rigid segment (`mates`) do not close over anything.
"""

import numpy as np
from numba import njit

from contact.ellipsoid import foot_and_normal
from contact.travel import turned_by

LINGER = 0.01  # a point this near a segment is still between it and another [m]


@njit(cache=True, error_model="numpy")
def depth_in(x, body, offset):
    """Depth [m] of x (3,) below the offset surface of an ellipsoid at t."""
    q0, q1, q2 = x[0] - body.centre[0], x[1] - body.centre[1], x[2] - body.centre[2]
    y0, y1, y2 = turned_by(body.axes, q0, q1, q2)
    return offset - foot_and_normal(y0, y1, y2, body.radii[0], body.radii[1], body.radii[2])[0]


@njit(cache=True, error_model="numpy")
def still_between(x, closed, travel, offset):
    """Which of the segments that have closed over a point still do.

    They do as long as it is inside one and inside, or LINGER near, another. Returns their set and
    the depth in the one it is less deep in [m].
    """
    kept, deepest = 0, 0.0
    for b in range(len(travel)):
        if not (closed >> b) & 1:
            continue
        depth = depth_in(x, travel[b], offset)
        if depth <= 0.0:
            continue
        for a in range(len(travel)):
            if a == b or not (closed >> a) & 1 or (travel[b].mates >> a) & 1:
                continue
            other = depth_in(x, travel[a], offset)
            if other > -LINGER:
                kept |= (1 << a) | (1 << b)
                deepest = max(deepest, min(depth, other))
    return kept, deepest


@njit(cache=True, error_model="numpy")
def closing(planes, count, travel):
    """Set of the segments that push a point together with another that is no mate of theirs."""
    closed = 0
    for k in range(count):
        for j in range(k):
            if planes[k].push <= 0.0 or planes[j].push <= 0.0:
                continue
            b, a = planes[k].owner, planes[j].owner
            if not (travel[b].mates >> a) & 1:
                closed |= (1 << a) | (1 << b)
    return closed


@njit(cache=True, error_model="numpy")
def overlapping(planes, count, travel):
    """Set of the segments that leave a point no room: all in reach, but mates."""
    closed = 0
    for k in range(count):
        for j in range(k):
            b, a = planes[k].owner, planes[j].owner
            if not (travel[b].mates >> a) & 1:
                closed |= (1 << a) | (1 << b)
    return closed


def mates_of(body):
    """Sets (m,) of the ellipsoids that move as one with each: that have the same entry in the
    `carriers` of a body that has them, as a Wearer; else each alone."""
    names = getattr(body, "carriers", None)
    m = len(body.radii)
    if names is None:
        return np.array([1 << b for b in range(m)], np.int64)
    return np.array([sum(1 << a for a in range(m) if names[a] == n) for n in names], np.int64)
