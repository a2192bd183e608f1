# SPDX-License-Identifier: LGPL-3.0-or-later
"""Which ellipsoids a point cannot meet for a while: most cloth is near one part of a body, or none.

A look measures how far a point is from every ellipsoid. Those beyond a margin are `far`, and need
not be asked again before the point and the body together have gone as far as the nearest of them
was away: a surface moves by no more than |shift| + |turn| r in a step, r its longest semi-axis, see
travel.py. What is left out could not have changed the step: the plane of its closest point, carried
along, would lie behind it.

Positions are compared with the place of the look, so a point may be moved by anybody in between;
after a pose that does not follow the last one everything is looked at anew.
"""

import numpy as np
from numba import njit

from contact.geometry.ellipsoid import foot_and_normal

from .segment_motion import turned_by

# one record per point, as left by its last look
CLEAR = np.dtype(
    [
        ("place", float, 3),  # where it was [m]
        ("far", np.int64),  # set of segments, see travel.py, that are not near
        ("room", float),  # distance to the nearest of them [m]; negative: look anew
        ("path", float),  # way of the body's surfaces up to then [m]
    ]
)
STEPS = 12  # that a look should last
LEAST = 1e-3  # margin in shortest semi-axes
KEPT = 0.99  # of a distance, for turns of up to MOST_TURN a step: 1 - turn^2
MOST_TURN = 0.1  # radians a step, above which nothing is left out


@njit(cache=True, error_model="numpy")
def surface_motion(travel, offset):
    """Bound [m] on the way of any surface point in this step, smallest semi-axis [m] of all."""
    most, shortest, turned = 0.0, np.inf, 0.0
    for b in range(len(travel)):
        body = travel[b]
        shift = turning = 0.0
        for k in range(3):
            shift += body.shift[k] * body.shift[k]
            for j in range(3):
                turning += body.turn[k, j] * body.turn[k, j]
        turning = np.sqrt(turning)
        longest = max(body.radii[0], body.radii[1], body.radii[2])
        most = max(most, np.sqrt(shift) + turning * (longest + offset))
        shortest, turned = min(shortest, body.shortest), max(turned, turning)
    return (most if turned <= MOST_TURN else np.inf), shortest


@njit(cache=True, error_model="numpy")
def left_of(x, path, motion, clear):
    """What is left [m] of the room of a point for its step, the body's motion in it taken off."""
    d0, d1, d2 = x[0] - clear.place[0], x[1] - clear.place[1], x[2] - clear.place[2]
    return clear.room - np.sqrt(d0 * d0 + d1 * d1 + d2 * d2) - (path - clear.path) - motion


@njit(cache=True, error_model="numpy")
def look(x, path, margin, allowed, travel, offset, clear):
    """Measure how far a point is from the segments that it can touch; fills its record.

    Others are not far: it may be able to touch them later. Returns closest points evaluated.
    """
    evaluated, near, room = 0, ~allowed, np.inf
    for b in range(len(travel)):
        body = travel[b]
        if not (allowed >> body.bit) & 1:
            continue
        q0, q1, q2 = x[0] - body.centre[0], x[1] - body.centre[1], x[2] - body.centre[2]
        r0, r1, r2 = body.radii[0], body.radii[1], body.radii[2]
        gap = np.sqrt(q0 * q0 + q1 * q1 + q2 * q2) - max(r0, r1, r2) - offset
        if KEPT * gap <= margin:
            y0, y1, y2 = turned_by(body.axes, q0, q1, q2)
            size = np.sqrt((y0 / r0) ** 2 + (y1 / r1) ** 2 + (y2 / r2) ** 2)
            gap = max(gap, (size - 1.0) * body.shortest - offset)
            if KEPT * gap <= margin:
                gap = foot_and_normal(y0, y1, y2, r0, r1, r2)[0] - offset
                evaluated += 1
        if KEPT * gap <= margin:
            near |= np.int64(1) << body.bit
        else:
            room = min(room, KEPT * gap - body.slack)
    if room == np.inf:  # all are near: look again some time
        room = 2.0 * margin
    clear.place[0], clear.place[1], clear.place[2] = x[0], x[1], x[2]
    clear.far, clear.room, clear.path = ~near, room, path
    return evaluated
