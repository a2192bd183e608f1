# SPDX-License-Identifier: LGPL-3.0-or-later
"""One step of contact of all nodes with a moving closed surface of triangles.

Most nodes are away: their last distance, less what they and the surface have moved since, is more
than their step (broad_phase.py). The others ask for their closest triangle, the last one first.
Those that are too far from it for this step are away until that distance is used up; the rest meet
the surface (surface_node.py).
"""

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from contact.geometry.triangle_mesh.closest import closest, on_triangle, pseudo_normal
from contact.kernel import kernel

from .broad_phase import mark_away
from .step_record import ALLOWED, FAR, SEGMENT_TOUCHED
from .surface_node import gap_at, surface_node_kernel

ALL = -1  # every bit
ROUNDOFF = 1e-12  # m, of a distance


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
            x0, x1, x2 = x[i, 0], x[i, 1], x[i, 2]
            reach = dt * np.sqrt(v[i, 0] ** 2 + v[i, 1] ** 2 + v[i, 2] ** 2) + work.motion
            asked = sets[ALLOWED, i]
            t, square = closest(mesh, start, x0, x1, x2, asked, last[i], stack, bounds)
            work.evaluated += 1
            if t < 0:
                continue
            last[i] = t
            sets[FAR, i], look[3, i] = 0, -1.0
            clear = np.sqrt(square) - highest - work.offset - ROUNDOFF
            if clear > reach and is_outside(mesh, start, t, x0, x1, x2):
                look[0, i], look[1, i], look[2, i] = x0, x1, x2
                look[3, i], look[4, i] = clear, work.path
                sets[FAR, i] = ALL
                continue
            found = gap_at(mesh, start, smooth, asked, t, square, x0, x1, x2)
            if found[3] - work.offset > reach and clear + highest > reach:
                continue
            for c in range(3):
                work.kick[c] = v[i, c] - old[i, c]
            pushing, near, depth = meet_surface(
                x[i], v[i], mass[i], found, touched, smooth, asked, highest, work, mesh, start,
                end, planes, over, stack, bounds, owners, at_vertices,
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
