# SPDX-License-Identifier: LGPL-3.0-or-later
"""One step of contact of all nodes with a moving closed surface of triangles.

Most nodes are away: their last distance, less what they and the surface have moved since, is more
than their step (broad_phase.py). The others ask for their closest triangle, the last one first.
Those that are too far from it for this step are away until that distance is used up; the rest meet
the surface (surface_node.py).

A node near the surface also asks how far the closest triangle is that faces another way. Nothing
but one sheet, a graph over its tangent plane, is within that distance, and until it is used up the
node is followed from triangle to triangle (smooth.py) without asking the tree.
"""

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from contact.geometry.triangle_mesh.closest import (
    closest,
    closest_facing,
    on_triangle,
    pseudo_normal,
)
from contact.geometry.triangle_mesh.smooth import smooth_gap
from contact.kernel import kernel

from .broad_phase import clearance_left, mark_away
from .step_record import ALLOWED, FAR, SEGMENT_TOUCHED
from .surface_node import gap_at, surface_node_kernel

ALL = -1  # every bit
ROUNDOFF = 1e-12  # m, of a distance
SHEET = 0.015  # m: how far around a node near the surface it is looked for other sheets, at least
FACING = 0.5  # cosine of the angle between normals of one sheet, at least
KEPT = 8.0  # steps: a distance that lasts so long is worth that the sheet is forgotten


@kernel(makes_arrays=False)
def is_outside(mesh: Any, placed: Any, t: int, x0: float, x1: float, x2: float) -> bool:
    """Whether x, closest to triangle t, is outside the surface."""
    v, corners = placed.vertices, mesh.triangles
    _, u, w, where = on_triangle(v, corners, t, x0, x1, x2)
    n0, n1, n2 = pseudo_normal(mesh, v, t, where)
    i, j, k, first = corners[t, 0], corners[t, 1], corners[t, 2], 1.0 - u - w
    above = n0 * (x0 - (first * v[i, 0] + u * v[j, 0] + w * v[k, 0]))
    above += n1 * (x1 - (first * v[i, 1] + u * v[j, 1] + w * v[k, 1]))
    above += n2 * (x2 - (first * v[i, 2] + u * v[j, 2] + w * v[k, 2]))
    return above >= 0.0


@kernel(makes_arrays=False)
def followed(
    mesh: Any, placed: Any, t: int, x0: float, x1: float, x2: float
) -> tuple[int, float, float, float, float, float, float, bool]:
    """Where x is over the sheet around triangle t, see `gap_at`; triangle -1 if it is lost."""
    square = on_triangle(placed.vertices, mesh.triangles, t, x0, x1, x2)[0]
    over, b1, b2, gap, n0, n1, n2 = smooth_gap(mesh, placed, t, square, x0, x1, x2)
    return over, b1, b2, gap, n0, n1, n2, True


@cache
def surface_kernel(kinetic_coefficient: Callable) -> Any:
    """Kernel correct(x, v, old, mass, dt, ...) of a law of friction, see `SurfaceCorrection`.

    0, or the number + 1 of a node that is not finite.

    fixed (n,), sets (SETS, n), look (LOOK, n), last (n,) int : what nodes keep, see step_record.py
    and `SurfaceCorrection`; away (n,), planes (PLANES,), over (PLANES,), stack, bounds : work
    impulse (n, 3), at_vertices (nv, 6) : of this step, filled; window (n, 3) : added to
    """
    meet_surface = surface_node_kernel(kinetic_coefficient)

    @kernel(makes_arrays=False)
    def correct(
        x, v, old, mass, dt, fixed, sets, look, last, away, step, smooth, highest, mesh, start,
        end, planes, over, stack, bounds, owners, impulse, window, at_vertices,
    ):  # fmt: skip
        work = step[0]
        work.dt, work.recovery = dt, work.recovery_speed * dt
        if work.active > 0:
            at_vertices[:] = 0.0
            impulse[:] = 0.0
        work.evaluated, work.active, work.sticking, work.pinched = 0, 0, 0, 0
        work.max_depth = work.pinch_depth = 0.0
        mark_away(x, v, mass, dt, work.path, work.motion, fixed, sets, look, away)
        for i in range(len(x)):
            if away[i] >= 0.0:
                sets[SEGMENT_TOUCHED, i] = -1
                continue
            total = x[i, 0] + x[i, 1] + x[i, 2] + v[i, 0] + v[i, 1] + v[i, 2]
            if not (np.isfinite(total) and 0.0 < mass[i] < np.inf):
                return i + 1
            touched = sets[SEGMENT_TOUCHED, i]
            sets[SEGMENT_TOUCHED, i] = -1
            if fixed[i] or sets[ALLOWED, i] == 0:
                continue
            x0, x1, x2, asked = x[i, 0], x[i, 1], x[i, 2], sets[ALLOWED, i]
            reach = dt * np.sqrt(v[i, 0] ** 2 + v[i, 1] ** 2 + v[i, 2] ** 2) + work.motion
            least = work.offset + highest + work.recovery + 2.0 * reach
            left = -1.0
            if smooth and sets[FAR, i] == 0 and last[i] >= 0:
                left = clearance_left(x, i, work.path, work.motion, look)
            local = False
            if left > least:
                found = followed(mesh, start, last[i], x0, x1, x2)
                local = found[0] >= 0 and abs(found[3]) < left
                local = local and mesh.sets[found[0]] & asked != 0
                second, other = found, False
            if not local:
                t, square = closest(mesh, start, x0, x1, x2, asked, last[i], stack, bounds)
                work.evaluated += 1
                if t < 0:
                    continue
                last[i], sets[FAR, i] = t, 0
                look[0, i], look[1, i], look[2, i] = x0, x1, x2
                look[3, i], look[4, i] = -1.0, work.path
                clear = np.sqrt(square) - highest - work.offset - ROUNDOFF
                if clear > (KEPT * reach if smooth else reach):
                    if is_outside(mesh, start, t, x0, x1, x2):
                        look[3, i], sets[FAR, i] = clear, ALL
                        continue
                found = gap_at(mesh, start, smooth, asked, t, square, x0, x1, x2)
                limit = max(SHEET, 2.0 * least)
                t, square = closest_facing(
                    mesh, start, x0, x1, x2, asked, found[4], found[5], found[6], FACING, limit,
                    stack, bounds,
                )  # fmt: skip
                second, other = found, False
                if t >= 0:
                    limit = np.sqrt(square)
                    other = limit <= work.offset + reach + work.recovery
                    if other:
                        second = gap_at(mesh, start, smooth, asked, t, square, x0, x1, x2)
                        # from outside, the far side of a thin part is behind it, not beside
                        other = found[3] <= 0.0 or second[3] > 0.0
                if found[7]:
                    look[3, i] = limit
            last[i] = found[0]
            if found[3] - work.offset > reach and not other:
                continue
            for c in range(3):
                work.kick[c] = v[i, c] - old[i, c]
            pushing, near, depth = meet_surface(
                x[i], v[i], mass[i], found, second, other, local, touched, smooth, asked, highest,
                work, mesh, start, end, planes, over, stack, bounds, owners, at_vertices,
            )  # fmt: skip
            last[i] = near
            if work.pushing == -1:
                work.pinch_depth = max(work.pinch_depth, depth)
            else:
                work.max_depth = max(work.max_depth, depth)
            if pushing < 0:
                continue
            sets[SEGMENT_TOUCHED, i] = owners[pushing]
            for c in range(3):
                v[i, c] += work.change[c]
                impulse[i, c] = mass[i] * work.change[c]
                window[i, c] += impulse[i, c]
        work.path += work.motion
        return 0

    return correct
