# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a node's step meets on its way over a moving closed surface of triangles.

Seen from the surface the node goes straight, from the start of its step to the end. Over one sheet
a short way stays over the plane of its start, and of a longer one the end tells. Elsewhere the tree
is asked, on a long way at so many places that nothing of the surface is passed.
"""

from typing import Any

import numpy as np

from contact.geometry.triangle_mesh.closest import closest, on_triangle
from contact.geometry.triangle_mesh.smooth import smooth_gap
from contact.kernel import kernel

from .surface_planes import INSIDE, gap_at

CURVED = 1e-2, 1e-6  # no reason for another plane: this part of the way, up to that many metres
SHORT = 2e-5  # m: on a shorter way along one sheet the surface stays under the plane of its start
LONG = 2e-3  # m: a longer way is looked along
LOOKS = 400  # places looked at on a long way, at most


@kernel(makes_arrays=False)
def _length(a0, a1, a2):
    return np.sqrt(a0 * a0 + a1 * a1 + a2 * a2)


@kernel(makes_arrays=False)
def met_on_way(
    x: np.ndarray,
    smooth: bool,
    local: bool,
    asked: int,
    guess: int,
    highest: float,
    work: Any,
    mesh: Any,
    end: Any,
    planes: np.ndarray,
    stack: np.ndarray,
    bounds: np.ndarray,
) -> tuple[int, float, float, float, float, float]:
    """Where the step as it is so far is inside the surface at its end, or passes into it.

    local : whether nothing but the sheet around triangle `guess` is near; highest : see
    `surface_node_kernel`

    Triangle (-1: nowhere), height [m] of the start over the plane there, its normal, and how deep
    the place is [m].
    """
    u, step = planes[0].drift, work.step
    s0, s1, s2 = x[0] + u[0], x[1] + u[1], x[2] + u[2]
    p0, p1, p2 = step[0] - u[0], step[1] - u[1], step[2] - u[2]
    way = _length(p0, p1, p2)
    allowed = work.tau + INSIDE + min(CURVED[0] * way, CURVED[1])
    if local and way <= LONG:
        if way <= SHORT:
            return -1, 0.0, 0.0, 0.0, 0.0, 0.0
        y0, y1, y2 = s0 + p0, s1 + p1, s2 + p2
        square = on_triangle(end.vertices, mesh.triangles, guess, y0, y1, y2)[0]
        over, _, _, gap, n0, n1, n2 = smooth_gap(mesh, end, guess, square, y0, y1, y2)
        gap -= work.offset
        if over >= 0:
            if gap >= -allowed:
                return -1, 0.0, 0.0, 0.0, 0.0, 0.0
            return over, gap - (n0 * p0 + n1 * p1 + n2 * p2), n0, n1, n2, -gap
    part, outside, before, t = 1.0, 0.0, 1.0, guess
    if way > LONG:
        part, before = 0.0, -1.0
    for look in range(LOOKS):
        y0, y1, y2 = s0 + part * p0, s1 + part * p1, s2 + part * p2
        t, square = closest(mesh, end, y0, y1, y2, asked, t, stack, bounds)
        work.evaluated += 1
        over, _, _, gap, n0, n1, n2, _ = gap_at(mesh, end, smooth, asked, t, square, y0, y1, y2)
        gap -= work.offset
        if gap < -allowed:
            if look > 0 and before > INSIDE and part > outside:
                # back to where the way comes in; a few secants
                inside, deep, above = part, gap, before
                for _ in range(8):
                    middle = outside + (inside - outside) * above / (above - deep)
                    y0, y1, y2 = s0 + middle * p0, s1 + middle * p1, s2 + middle * p2
                    t, square = closest(mesh, end, y0, y1, y2, asked, t, stack, bounds)
                    work.evaluated += 1
                    over, _, _, gap, n0, n1, n2, _ = gap_at(
                        mesh, end, smooth, asked, t, square, y0, y1, y2
                    )
                    gap -= work.offset
                    part = middle
                    if abs(gap) < INSIDE:
                        break
                    if gap > 0.0:
                        outside, above = middle, gap
                    else:
                        inside, deep = middle, gap
            height = gap - part * (n0 * p0 + n1 * p1 + n2 * p2)
            return over, height, n0, n1, n2, -gap
        if part >= 1.0:
            break
        outside, before = part, gap
        ahead = max(np.sqrt(square) - work.offset - highest, 0.25 * LONG)
        part = min(1.0, part + max(ahead / way, 1.0 / LOOKS))
    return -1, 0.0, 0.0, 0.0, 0.0, 0.0
