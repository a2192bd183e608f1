# SPDX-License-Identifier: LGPL-3.0-or-later
"""One step of contact of all nodes with a moving closed surface of triangles.

Most nodes are away: their last distance, less what they and the surface have moved since, is more
than their step (broad_phase.py). The others ask for their closest triangle, the last one first.
Those that are too far from it for this step are away until that distance is used up; the rest meet
the surface (surface_node.py).

A node near the surface also asks how far the closest triangle is that faces another way. Nothing
but one sheet, a graph over its tangent plane, is within that distance, and until it is used up the
node is followed from triangle to triangle (smooth.py) without asking the tree.

What nodes keep of that from step to step, and the room of those that go along with the body, is in
surface_looks.py.
"""

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from contact.geometry.triangle_mesh.carried import forget_acting
from contact.geometry.triangle_mesh.closest import (
    closest,
    closest_facing,
    on_triangle,
    pseudo_normal,
)
from contact.geometry.triangle_mesh.smooth import smooth_gap
from contact.kernel import kernel

from .broad_phase import mark_away
from .step_record import ALLOWED, FAR, SEGMENT_TOUCHED
from .surface_looks import keep_room, room_left, set_look, set_look_ahead, still_left
from .surface_node import surface_node_kernel
from .surface_planes import gap_at

ROUNDOFF = 1e-12  # m, of a distance
SHEET = 0.025  # m: how far around a node near the surface it is looked for other sheets, at least
FACING = 0.5  # cosine of the angle between normals of one sheet, at least
KEPT = 64.0  # steps: a distance that lasts so long is worth that the sheet is forgotten
PART = 0.5  # of a distance, that is room: normals of neighbours may turn too
WORTH = 1e-5  # m, of room, to be kept
FARTHEST = 4.0  # rooms, from its sheet, of a node that has some left
NEARBY = 4e-3  # m, from it, that other sheets are looked for anew in time


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
) -> tuple[int, float, float, float, float, float, float, bool, float]:
    """Where x is over the sheet around triangle t, see `gap_at`; triangle -1 if it is lost.

    Last the flat distance [m] to triangle t, no less than that to the sheet.
    """
    square = on_triangle(placed.vertices, mesh.triangles, t, x0, x1, x2)[0]
    over, b1, b2, gap, n0, n1, n2 = smooth_gap(mesh, placed, t, square, x0, x1, x2)
    return over, b1, b2, gap, n0, n1, n2, True, np.sqrt(square)


@kernel(makes_arrays=False)
def other_sheet(
    mesh: Any,
    placed: Any,
    i: int,
    x0: float,
    x1: float,
    x2: float,
    asked: int,
    found: tuple,
    reach: float,
    work: Any,
    sheet: np.ndarray,
    stack: np.ndarray,
    bounds: np.ndarray,
) -> float:
    """How far [m] node i at x over its sheet, see `gap_at`, is from any other one, in this step.

    The surface's motion is taken off; what was found is kept as its `sheet`, see `surface_kernel`.
    """
    limit = max(SHEET, 8.0 * reach)
    t, square = closest_facing(
        mesh, placed, x0, x1, x2, asked, found[4], found[5], found[6], FACING, limit, stack, bounds
    )  # fmt: skip
    if t >= 0:
        limit = np.sqrt(square)
    work.evaluated += 1
    set_look(sheet, i, x0, x1, x2, limit, work)
    return limit - work.motion


@cache
def surface_kernel(kinetic_coefficient: Callable, of_node: Callable = surface_node_kernel) -> Any:
    """Kernel correct(x, v, old, mass, dt, ...) of a law of friction, see `SurfaceCorrection`.

    of_node : gives the kernel that a node meets the surface by; beds : what that one wants besides

    0, or the number + 1 of a node that is not finite.

    fixed (n,), sets (SETS, n), look (LOOK, n) : what nodes keep, see step_record.py
    sheet (LOOK, n) : the same of what is not the sheet near a node; last (n,) int, triangle found
    last; room (n, ROOM), see `keep_room`, room[:, 0] = 0: none
    away (n,), planes (PLANES,), over (PLANES,), stack, bounds : work
    impulse (n, 3), acting Acting : of this step, filled; window (n, 3) : added to
    """
    meet_surface = of_node(kinetic_coefficient)

    @kernel(makes_arrays=False)
    def correct(
        x, v, old, mass, dt, fixed, sets, look, sheet, last, room, away, step, smooth, highest,
        mesh, start, end, planes, over, stack, bounds, owners, impulse, window, acting, beds,
    ):  # fmt: skip
        work = step[0]
        work.dt, work.recovery = dt, work.recovery_speed * dt
        if work.active > 0:
            forget_acting(acting)
            impulse[:] = 0.0
        work.evaluated, work.active, work.sticking, work.pinched = 0, 0, 0, 0
        work.max_depth = work.pinch_depth = 0.0
        mark_away(
            x, v, mass, dt, work.path, work.motion, fixed, sets, look, work.frame, work.shift, away
        )
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
            u0, u1, u2 = dt * v[i, 0], dt * v[i, 1], dt * v[i, 2]
            y0, y1, y2 = x0 + u0, x1 + u1, x2 + u2
            u0, u1, u2 = u0 - work.shift[0], u1 - work.shift[1], u2 - work.shift[2]
            reach = np.sqrt(u0 * u0 + u1 * u1 + u2 * u2) + work.motion
            needed = work.offset + work.recovery + reach
            left = -1.0
            if smooth and asked & ~sets[FAR, i] == 0 and last[i] >= 0:
                left = still_left(sheet, i, x0, x1, x2, work)
            local = known = other = False
            if left > needed:
                if room[i, 0] > 0.0 and left > needed + reach + min(FARTHEST * room[i, 0], NEARBY):
                    rest = room_left(mesh, end, last[i], y0, y1, y2, room[i])
                    if rest > 0.0:
                        rest = min(rest + 0.5 * room[i, 0], left - needed)
                        set_look_ahead(look, i, y0, y1, y2, rest, work)
                        continue
                lead = followed(mesh, start, last[i], x0, x1, x2)
                found, near = lead[:8], max(abs(lead[3]), lead[8])
                # nearer than anything else: the closest triangle is one of the sheet
                known = found[0] >= 0 and near < left and mesh.sets[found[0]] & asked != 0
                if known and left <= near + reach + needed:
                    # as long as that is known, other sheets are looked for anew
                    left = other_sheet(
                        mesh, start, i, x0, x1, x2, asked, found, reach, work, sheet, stack, bounds
                    )
                    known = left > max(near, needed)
                second = found
                # at the end of the step too
                local = known and left > near + reach + needed
            room[i, 0] = 0.0
            if not known:
                t, square = closest(mesh, start, x0, x1, x2, asked, last[i], stack, bounds)
                work.evaluated += 1
                if t < 0:
                    continue
                last[i], sets[FAR, i] = t, asked
                look[3, i] = -1.0
                set_look(sheet, i, x0, x1, x2, -1.0, work)
                clear = np.sqrt(square) - highest - work.offset - ROUNDOFF
                lasts = clear > KEPT * reach
                if clear > reach and not lasts:
                    found = gap_at(mesh, start, smooth, asked, t, square, x0, x1, x2)
                    lasts = not found[7]
                if lasts and is_outside(mesh, start, t, x0, x1, x2):
                    set_look(look, i, x0, x1, x2, clear, work)
                    continue
                found = gap_at(mesh, start, smooth, asked, t, square, x0, x1, x2)
                flat = np.sqrt(square)
                limit = max(SHEET, 8.0 * reach) if found[7] else needed
                t, square = closest_facing(
                    mesh, start, x0, x1, x2, asked, found[4], found[5], found[6], FACING, limit,
                    stack, bounds,
                )  # fmt: skip
                second, other = found, False
                if t >= 0:
                    limit = np.sqrt(square)
                    other = limit <= needed
                    if other:
                        second = gap_at(mesh, start, smooth, asked, t, square, x0, x1, x2)
                        # from outside, the far side of a thin part is behind it, not beside
                        other = found[3] <= 0.0 or second[3] > 0.0
                if found[7]:
                    left = sheet[3, i] = limit
                    local = not other and limit > max(abs(found[3]), flat) + reach + needed
            last[i] = found[0]
            gap = found[3] - work.offset
            roomy = found[7] and not other and PART * gap > WORTH
            if roomy:
                keep_room(mesh, start, found[0], x0, x1, x2, PART * gap, room[i])
            if gap > reach and not other:
                if roomy:
                    rest = min(1.5 * PART * gap, left - work.offset - work.recovery)
                    set_look(look, i, x0, x1, x2, rest, work)
                continue
            if roomy and local:
                # so near that it might touch, but it goes along with the triangle under it
                if room_left(mesh, end, found[0], y0, y1, y2, room[i]) > 0.0:
                    continue
            for c in range(3):
                work.kick[c] = v[i, c] - old[i, c]
            pushing, near, depth = meet_surface(
                i, x[i], v[i], mass[i], found, second, other, local, touched, smooth, asked,
                highest, work, mesh, start, end, planes, over, stack, bounds, owners, acting, beds,
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
