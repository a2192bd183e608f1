# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contact of one node with a moving closed surface of triangles over one step, Eqs. 15 and 16.

Seen from the moving surface, the node starts at x + drift, the place to which the triangle under it
carries x, and goes straight to x + step. Its step is bounded by planes n . step >= bound:

- of the closest point at the start of the step, as the surface carries it. Before a convex part of
  the body that is all: the node stays on the near side;
- of the closest point of what faces another way there, if the step can reach it: the other side of
  a crease, or another part of the body that the node lies between;
- where the step that results still ends inside, as before a hollow, or a long step meets the
  surface on its way, of the place where it is met.

A plane may stop what comes towards it and no more, so energy against the surface cannot grow; a
node that starts inside is moved out at the recovery speed. nearest_step.py finds the step,
plane_friction.py the friction, as with other bodies; surface_planes.py has the planes, and
surface_way.py what the step meets on its way.
"""

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from contact.geometry.triangle_mesh.carried import add_impulse, drift
from contact.kernel import kernel

from .nearest_step import PINCHED
from .node_contact import begin_path, push_out
from .plane_friction import friction_kernel
from .surface_planes import INSIDE, OPPOSED, add_carried, add_plane, hold, squeezed
from .surface_way import met_on_way

ROUNDS = 6  # of planes; what is left inside is moved out in the next steps


@kernel(makes_arrays=False)
def book_surface(
    x: np.ndarray,
    v: np.ndarray,
    mass: float,
    work: Any,
    planes: np.ndarray,
    over: np.ndarray,
    mesh: Any,
    start: Any,
    acting: Any,
) -> int:
    """Book the impulses of all planes at the vertices; the plane that pushes most, or -1."""
    dt, most, greatest = work.dt, -1, 0.0
    for k in range(work.count):
        push, done, pressed, rubbed = planes[k].push, 0.0, 0.0, 0.0
        if push > greatest:
            most, greatest = k, push
        friction = planes[k].friction
        if push == 0.0 and friction[0] == 0.0 and friction[1] == 0.0 and friction[2] == 0.0:
            continue
        for c in range(3):
            surface = planes[k].drift[c] / dt
            slip = v[c] + 0.5 * (work.change[c] - work.kick[c]) - surface
            pushed = mass / dt * push * planes[k].normal[c]
            dragged = mass / dt * friction[c]
            work.impulse[c] = pushed + dragged
            done += work.impulse[c] * surface
            pressed -= pushed * slip
            rubbed -= dragged * slip
        add_impulse(
            start.vertices, mesh.triangles, over[k], x[0], x[1], x[2], work.impulse, done, rubbed,
            pressed, acting,
        )  # fmt: skip
    return most


@cache
def surface_node_kernel(kinetic_coefficient: Callable) -> Any:
    """Kernel meet_surface(i, x, v, mass, found, second, other, local, ...) of a law of friction.

    i : int, number of the node; x, v : (3,), position at t [m] and velocity [m/s], unchanged;
        `work.change` is filled
    found : triangle, b1, b2, distance, normal, smooth or not at the start, see `gap_at`
    second : the same of what faces another way, if there is `other`
    local : whether nothing but the sheet found is near
    last : owner touched in the last step; asked : sets of triangles that count
    highest : of the smooth surface over the flat one [m]
    planes (PLANES,) PLANE, over (PLANES,) int, stack, bounds : scratch
    owners : (nt,) int; acting : Acting, added to; beds : (), as the body is hard

    Returns the triangle that pushes most, or -1; the triangle looked at last; the depth [m] of
    the start.
    """
    apply_friction = friction_kernel(kinetic_coefficient)

    @kernel(makes_arrays=False)
    def meet_surface(
        i, x, v, mass, found, second, other, local, last, smooth, asked, highest, work, mesh, start,
        end, planes, over, stack, bounds, owners, acting, beds,
    ):  # fmt: skip
        for c in range(3):
            work.free[c] = work.dt * v[c]
        begin_path(work)
        work.soft, t = 0, found[0]
        corners, before, after = mesh.triangles, start.vertices, end.vertices
        work.roundoff = 1e-14 * (1e-2 + abs(x[0]) + abs(x[1]) + abs(x[2]))
        work.depth = max(0.0, add_carried(x, found, mesh, start, end, owners, work, planes, over))
        # what may be left of the depth at the end; `tau` has no other use here
        work.tau = max(0.0, work.depth - work.recovery)
        upward = work.recovery if work.depth > INSIDE else 0.0
        held = False
        if other:
            add_carried(x, second, mesh, start, end, owners, work, planes, over)
            held = squeezed(last, work, planes, over)
        for turn in range(ROUNDS):
            push_out(last, work, planes)
            pushing = work.pushing
            if pushing != 0 and work.friction[0] > 0.0:
                apply_friction(mass, work, planes)
                if work.pushing == PINCHED and pushing != PINCHED:
                    # friction on one wall drives the node into the other
                    hold(max(work.first, 0), work, planes, over)
                    push_out(last, work, planes)
                    held = True
            if work.pushing == PINCHED or held or turn == ROUNDS - 1:
                break
            met, above, n0, n1, n2, deep = met_on_way(
                x, smooth, local, asked, t, highest, work, mesh, end, planes, stack, bounds
            )
            if met < 0:
                break
            # the start lies `above` the plane, seen from the triangle under it
            above -= n0 * planes[0].drift[0] + n1 * planes[0].drift[1] + n2 * planes[0].drift[2]
            u0, u1, u2 = drift(before, after, corners, met, x[0], x[1], x[2])
            above += n0 * u0 + n1 * u1 + n2 * u2
            facing = n0 * planes[0].normal[0] + n1 * planes[0].normal[1] + n2 * planes[0].normal[2]
            apart = owners[met] != planes[0].owner and facing < OPPOSED
            if apart and above < -INSIDE and work.depth > INSIDE:
                held = True
                break
            height = min(-above - work.tau, upward)
            add_plane(x, met, n0, n1, n2, u0, u1, u2, height, deep, owners[met], work, planes, over)
            t = met
        if held:
            work.pushing = PINCHED
        if work.pushing == 0:
            return -1, t, work.depth
        work.pinched += work.pushing == PINCHED
        for c in range(3):
            work.change[c] = 0.0
            for k in range(work.count):
                push = planes[k].push * planes[k].normal[c]
                work.change[c] += (push + planes[k].friction[c]) / work.dt
        most = book_surface(x, v, mass, work, planes, over, mesh, start, acting)
        if most < 0:
            # a squeezed node stays with its part, whether that pushes or not
            return (over[max(work.first, 0)] if work.pushing == PINCHED else -1), t, work.depth
        work.active += 1
        work.sticking += work.stick
        return over[most], over[most], work.depth

    return meet_surface
