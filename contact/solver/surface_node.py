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
plane_friction.py the friction, as with other bodies.

Where two parts of the skin pass through each other, there is no place for a node between them.
Their planes together would be a wedge of hard walls, which resists any pull along it. Flesh gives
way: such a node is squeezed, and only the part that it touched last keeps it on its near side.
"""

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from contact.geometry.triangle_mesh.carried import (
    add_impulse,
    drift,
    numbers_of,
    turned_with,
)
from contact.geometry.triangle_mesh.closest import closest, on_triangle
from contact.geometry.triangle_mesh.smooth import flat_gap, normal_at, smooth_gap
from contact.kernel import kernel

from .nearest_step import PINCHED
from .node_contact import begin_path, push_out
from .plane_friction import friction_kernel

PLANES = 8  # of a node, at most
ROUNDS = 6  # of planes; what is left inside is moved out in the next steps
INSIDE = 1e-9  # m: ends less deep than this are no reason for another plane
CURVED = 1e-2, 1e-6  # nor than this part of the way, up to that many metres
SHORT = 2e-5  # m: on a shorter way along one sheet the surface stays under the plane of its start
LONG = 2e-3  # m: a longer way is looked along
LOOKS = 400  # places looked at on a long way, at most
OPPOSED = -0.8  # cosine between normals of two parts that close on a node that lies in both


@kernel(makes_arrays=False)
def gap_at(
    mesh: Any,
    placed: Any,
    smooth: bool,
    asked: int,
    t: int,
    square: float,
    x0: float,
    x1: float,
    x2: float,
) -> tuple[int, float, float, float, float, float, float, bool]:
    """Distance of x to the surface with the closest triangle t at sqrt(square) [m].

    asked : sets of triangles that count.

    Returns triangle, b1, b2, distance [m], unit normal (3), whether the normal is a smooth one.
    """
    if smooth:
        over, b1, b2, gap, n0, n1, n2 = smooth_gap(mesh, placed, t, square, x0, x1, x2)
        if over >= 0 and mesh.sets[over] & asked:
            return over, b1, b2, gap, n0, n1, n2, True
    b1, b2, gap, n0, n1, n2 = flat_gap(mesh, placed, t, x0, x1, x2)
    return t, b1, b2, gap, n0, n1, n2, False


@kernel(makes_arrays=False)
def add_plane(
    x: np.ndarray,
    t: int,
    n0: float,
    n1: float,
    n2: float,
    u0: float,
    u1: float,
    u2: float,
    height: float,
    depth: float,
    owner: int,
    work: Any,
    planes: np.ndarray,
    over: np.ndarray,
) -> None:
    """Add the plane n . (step - drift) >= height over triangle t."""
    k = work.count
    plane = planes[k]
    plane.owner, plane.depth, plane.push = owner, depth, 0.0
    plane.normal[0], plane.normal[1], plane.normal[2] = n0, n1, n2
    plane.drift[0], plane.drift[1], plane.drift[2] = u0, u1, u2
    plane.bound = height + n0 * u0 + n1 * u1 + n2 * u2
    for c in range(3):
        plane.friction[c] = 0.0
    over[k] = t
    work.count = k + 1


@kernel(makes_arrays=False)
def add_carried(
    x: np.ndarray,
    found: tuple,
    mesh: Any,
    start: Any,
    end: Any,
    owners: np.ndarray,
    work: Any,
    planes: np.ndarray,
    over: np.ndarray,
) -> float:
    """Add the plane at a place found at the start, as the surface carries it; its depth [m].

    found : see `gap_at`
    """
    t, w1, w2, distance, n0, n1, n2, rounded = found
    corners, before, after = mesh.triangles, start.vertices, end.vertices
    b1, b2, h = numbers_of(before, corners, t, x[0], x[1], x[2])
    u0, u1, u2 = drift(before, after, corners, t, b1, b2, h)
    if rounded:
        n0, n1, n2, _ = normal_at(mesh, end, t, w1, w2)
    else:
        n0, n1, n2 = turned_with(before, after, corners, t, n0, n1, n2)
    depth = work.offset - distance
    height = min(depth, work.recovery)
    add_plane(x, t, n0, n1, n2, u0, u1, u2, height, depth, owners[t], work, planes, over)
    return depth


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


@kernel(makes_arrays=False)
def _cosine(p, q):
    return p[0] * q[0] + p[1] * q[1] + p[2] * q[2]


@kernel(makes_arrays=False)
def hold(k: int, work: Any, planes: np.ndarray, over: np.ndarray) -> None:
    """Leave plane k alone, which lets the node go no deeper and moves it out later."""
    p, q = planes[0], planes[k]
    p.owner, p.depth, over[0] = q.owner, q.depth, over[k]
    p.bound = q.bound - max(0.0, min(q.depth, work.recovery))
    for c in range(3):
        p.normal[c], p.drift[c] = q.normal[c], q.drift[c]
    work.count = 1


@kernel(makes_arrays=False)
def squeezed(last: int, work: Any, planes: np.ndarray, over: np.ndarray) -> bool:
    """Whether a node lies inside both parts of the first two planes; then one of them is left.

    Both sides of one thin part look alike: parts are told by their owners.

    last : owner touched in the last step, whose plane stays; else the first, which is nearer
    """
    p, q = planes[0], planes[1]
    opposed = p.owner != q.owner and _cosine(p.normal, q.normal) < OPPOSED
    if not opposed or min(p.depth, q.depth) <= INSIDE:
        return False
    hold(1 if q.owner == last and p.owner != last else 0, work, planes, over)
    return True


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
        for c in range(3):
            surface = planes[k].drift[c] / dt
            slip = v[c] + 0.5 * (work.change[c] - work.kick[c]) - surface
            pushed = mass / dt * push * planes[k].normal[c]
            friction = mass / dt * planes[k].friction[c]
            work.impulse[c] = pushed + friction
            done += work.impulse[c] * surface
            pressed -= pushed * slip
            rubbed -= friction * slip
        b1, b2, h = numbers_of(start.vertices, mesh.triangles, over[k], x[0], x[1], x[2])
        add_impulse(
            start.vertices, mesh.triangles, over[k], b1, b2, h, work.impulse, done, rubbed,
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
            b1, b2, h = numbers_of(before, corners, met, x[0], x[1], x[2])
            # the start lies `above` the plane, seen from the triangle under it
            above -= n0 * planes[0].drift[0] + n1 * planes[0].drift[1] + n2 * planes[0].drift[2]
            u0, u1, u2 = drift(before, after, corners, met, b1, b2, h)
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
