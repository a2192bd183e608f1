# SPDX-License-Identifier: LGPL-3.0-or-later
"""Planes that prove without a closest point that a node does not meet a segment in its step.

A segment is convex and rigid. The plane that touches it at the foot of a point has all of it on one
side, for ever, in the axes of the segment: with the unit normal n out of it and h = n . foot, every
point y is at a distance of no less than

    d(y) >= n . y - h,

as n . z <= h for all z of the segment, and so n . (y - z) >= n . y - h. Where that is more than the
step of the node can close, the node stays off: the same answer as from the closest point, whatever
the segment, the node or the clock have done since, for a product of three numbers. It holds for a
node that slides along, as its height over the plane is what counts, not its way.

A node keeps a plane each of GUARDS segments: of the last one in their place, found by its number.
"""

import numpy as np

from contact.kernel import kernel

from .step_record import GUARDS


@kernel(makes_arrays=False)
def height_over_guard(guards: np.ndarray, i: int, b: int, y0: float, y1: float, y2: float) -> float:
    """Height [m] of y, in the axes of segment b, over the plane that node i keeps; -inf: none.

    guards : (n, GUARDS, GUARD), number of the segment + 1, normal (3), height [m] of the plane
    """
    k = b % GUARDS
    if guards[i, k, 0] != b + 1:
        return -np.inf
    return guards[i, k, 1] * y0 + guards[i, k, 2] * y1 + guards[i, k, 3] * y2 - guards[i, k, 4]


@kernel(makes_arrays=False)
def keep_guard(
    guards: np.ndarray,
    i: int,
    b: int,
    x0: float,
    x1: float,
    x2: float,
    n0: float,
    n1: float,
    n2: float,
) -> None:
    """Keep the plane at the foot x with the normal n, both in the axes of segment b, of node i."""
    k = b % GUARDS
    guards[i, k, 0] = b + 1
    guards[i, k, 1], guards[i, k, 2], guards[i, k, 3] = n0, n1, n2
    guards[i, k, 4] = n0 * x0 + n1 * x1 + n2 * x2
