# SPDX-License-Identifier: LGPL-3.0-or-later
"""A closed surface of triangles as implicit steps meet it, with shapes beside it: an obstacle.

The distance and the normal are those of explicit steps (geometry/triangle_mesh/smooth.py). A plane
of a node follows one sheet of the surface: of the triangles that face its way, less than 60 degrees
off, it stands on the closest one. A second plane stands on a sheet that faces another way and that
the node has come into from outside, as the other side of a crease. One that faces a held one, of
another segment, is another part that closes on the node, which would be held by any force between
the two: it is left alone.

Seen from the surface a node starts where the triangle below it carries it, and goes straight. A
node farther away than it and the surface go asks for nothing.
"""

from typing import Any, NamedTuple

import numpy as np

from contact.geometry.triangle_mesh.carried import (
    Acting,
    add_impulse,
    drift,
    numbers_of,
    speed_at,
    turned_with,
)
from contact.geometry.triangle_mesh.closest import closest, closest_facing
from contact.geometry.triangle_mesh.placed import Placed
from contact.geometry.triangle_mesh.topology import Mesh
from contact.kernel import kernel

from . import segment_obstacle as of_shapes
from .held_nodes import PLANES, Set
from .obstacle import Obstacle, book_kernel, locate_kernel, velocities_kernel
from .segment_obstacle import Segments
from .surface_planes import INSIDE, OPPOSED, gap_at
from .surface_way import LONG, LOOKS

FACING = 0.5  # cosine of the angle between normals of one sheet, at least
BESIDE = 0.1  # of its way, by which a node may have been below a sheet that it comes into
FAR = 10.0  # m: no sheet is looked for farther away

depth_of_shapes, met_shapes = of_shapes.depth, of_shapes.met
tangent_to_shape, carry_with_shape = of_shapes.tangent, of_shapes.carry
velocity_of_shape, book_shape = of_shapes.velocity, of_shapes.book


class Surface(NamedTuple):
    """shapes : Segments that are met besides, often none; mesh, start, end : Mesh, Placed
    owners (nt,) int, rows of the ledger; smooth (1,) bool, highest (1,) : of the smooth surface
    over the flat one [m]; rates (nv, 3) : velocities of the vertices at the end [m/s]
    acting : Acting, filled; near (n,) int : triangle last found, -1: none
    look (n, 5) : where a node was when it was found (3), how far from the skin, and the way of the
    surface till then [m]; path (2,) : the way of the surface before the step, and in it [m]
    stack, bounds, place, other (7,) : scratch
    """

    shapes: Segments
    mesh: Mesh
    start: Placed
    end: Placed
    owners: np.ndarray
    smooth: np.ndarray
    highest: np.ndarray
    rates: np.ndarray
    acting: Acting
    near: np.ndarray
    look: np.ndarray
    path: np.ndarray
    stack: np.ndarray
    bounds: np.ndarray
    place: np.ndarray
    other: np.ndarray


@kernel(makes_arrays=False)
def _clear(x, i, offset, path, world):
    """What is left [m] between node i at x and contact where the surface has gone `path` [m]."""
    look, gone = world.look[i], 0.0
    for c in range(3):
        gone += (x[c] - look[c]) ** 2
    return look[3] - offset - np.sqrt(gone) - (path - look[4])


@kernel(makes_arrays=False)
def _foot(x0, x1, x2, guess, placed, world):
    """Of x on the surface placed so, see `gap_at`; last the flat distance [m]."""
    mesh = world.mesh
    t, square = closest(mesh, placed, x0, x1, x2, -1, guess, world.stack, world.bounds)
    found = gap_at(mesh, placed, world.smooth[0], -1, t, square, x0, x1, x2)
    return np.int64(found[0]), found[3], found[4], found[5], found[6], np.sqrt(square)


@kernel(makes_arrays=False)
def _foot_facing(x0, x1, x2, n0, n1, n2, cosine, limit, world):
    """The same at the end of a step of what faces another way, see `closest_facing`; -1: none."""
    mesh, end = world.mesh, world.end
    t, square = closest_facing(
        mesh, end, x0, x1, x2, -1, n0, n1, n2, cosine, limit, world.stack, world.bounds
    )
    if t < 0:
        return np.int64(-1), 0.0, 0.0, 0.0, 0.0
    found = gap_at(mesh, end, world.smooth[0], -1, t, square, x0, x1, x2)
    return np.int64(found[0]), found[3], found[4], found[5], found[6]


@kernel(makes_arrays=False)
def _drift(x, t, world):
    """Way of the point x over the step as triangle t takes it."""
    before, after, corners = world.start.vertices, world.end.vertices, world.mesh.triangles
    b1, b2, h = numbers_of(before, corners, t, x[0], x[1], x[2])
    return drift(before, after, corners, t, b1, b2, h)


@kernel(makes_arrays=False)
def depth(x: np.ndarray, i: int, offset: float, world: Any) -> float:
    """See obstacle.py."""
    deepest = 0.0
    if len(world.shapes.segments) > 0:
        deepest = depth_of_shapes(x, i, offset, world.shapes)
    if world.near[i] >= 0 and _clear(x, i, offset, world.path[0], world) > 0.0:
        return deepest
    look = world.look[i]
    t, gap, _, _, _, flat = _foot(x[0], x[1], x[2], world.near[i], world.start, world)
    world.near[i] = t
    look[0], look[1], look[2], look[4] = x[0], x[1], x[2], world.path[0]
    look[3] = flat - world.highest[0] if gap > 0.0 else -1.0
    return max(deepest, offset - gap)


@kernel(makes_arrays=False)
def carry(x: np.ndarray, i: int, world: Any, nodes: Set) -> None:
    """See obstacle.py."""
    over, anchor = nodes.over[i], nodes.anchor[i]
    if over[0] >= 0:
        u0, u1, u2 = _drift(x, over[0], world)
        anchor[0], anchor[1], anchor[2] = x[0] + u0, x[1] + u1, x[2] + u2
    else:
        carry_with_shape(x, i, world.shapes, nodes)
    before, after, corners = world.start.vertices, world.end.vertices, world.mesh.triangles
    for k in range(PLANES):
        if nodes.owner[i, k] >= 0 and over[k] >= 0:
            n = nodes.normal[i, k]
            n[0], n[1], n[2] = turned_with(before, after, corners, over[k], n[0], n[1], n[2])


@kernel(makes_arrays=False)
def tangent(x: np.ndarray, i: int, k: int, offset: float, world: Any, nodes: Set) -> float:
    """See obstacle.py."""
    if nodes.over[i, k] < 0:
        return tangent_to_shape(x, i, k, offset, world.shapes, nodes)
    n = nodes.normal[i, k]
    t, gap, m0, m1, m2 = _foot_facing(x[0], x[1], x[2], -n[0], -n[1], -n[2], -FACING, FAR, world)
    if t < 0:
        t, gap, m0, m1, m2, _ = _foot(x[0], x[1], x[2], nodes.over[i, k], world.end, world)
    n[0], n[1], n[2] = m0, m1, m2
    nodes.over[i, k], nodes.owner[i, k] = t, world.owners[t]
    gap += nodes.way_out[i] - offset
    nodes.height[i, k] = m0 * x[0] + m1 * x[1] + m2 * x[2] - gap
    return gap


@kernel(makes_arrays=False)
def _along_way(s0, s1, s2, x1, i, offset, world, nodes, place):
    """Triangle of the first place inside on the way from s to x1 at the end, or -1."""
    p0, p1, p2 = x1[0] - s0, x1[1] - s1, x1[2] - s2
    way, end = np.sqrt(p0 * p0 + p1 * p1 + p2 * p2), world.end
    allowed = nodes.way_out[i] + INSIDE
    t, gap, n0, n1, n2, _ = _foot(s0, s1, s2, world.near[i], end, world)
    part, outside, before = 1.0, 0.0, gap - offset
    first, f0, f1, f2 = t, n0, n1, n2
    deep = max(0.0, -before)  # what starts inside may be on its way out
    if way > LONG:
        part = min(1.0, max(before, 0.25 * LONG) / way)
    for _ in range(LOOKS):
        t, gap, n0, n1, n2, _ = _foot(s0 + part * p0, s1 + part * p1, s2 + part * p2, t, end, world)
        gap -= offset
        if gap < -allowed - (deep if part < 1.0 else 0.0):
            if before > 0.0:
                part = outside + (part - outside) * before / (before - gap)
                t, _, n0, n1, n2, _ = _foot(
                    s0 + part * p0, s1 + part * p1, s2 + part * p2, t, end, world
                )
            elif outside == 0.0:
                part, t, n0, n1, n2 = 0.0, first, f0, f1, f2
            place[0], place[1], place[2] = s0 + part * p0, s1 + part * p1, s2 + part * p2
            place[3], place[4], place[5] = n0, n1, n2
            place[6] = -gap - nodes.way_out[i]
            return t
        if part >= 1.0:
            break
        outside, before = part, gap
        part = min(1.0, part + max(max(gap, 0.25 * LONG) / way, 1.0 / LOOKS))
    return np.int64(-1)


@kernel(makes_arrays=False)
def _comes_into(t, gap, n0, n1, n2, s0, s1, s2, x1, i, world, nodes):
    """Whether the node comes into a sheet near x1 that nothing yet holds it before."""
    if gap >= -nodes.way_out[i] - INSIDE:
        return False
    for k in range(PLANES):
        if nodes.owner[i, k] >= 0 and nodes.over[i, k] >= 0:
            m = nodes.normal[i, k]
            along = n0 * m[0] + n1 * m[1] + n2 * m[2]
            if along > FACING or (along < OPPOSED and world.owners[t] != nodes.owner[i, k]):
                return False
    p0, p1, p2 = x1[0] - s0, x1[1] - s1, x1[2] - s2
    above = gap - (n0 * p0 + n1 * p1 + n2 * p2) + nodes.way_out[i]
    # else it is the far side of a thin part
    return above >= -max(1e-6, BESIDE * np.sqrt(p0 * p0 + p1 * p1 + p2 * p2))


@kernel(makes_arrays=False)
def _other_sheet(s0, s1, s2, x1, i, offset, world, nodes, place):
    """Triangle of what faces another way than the planes that hold the node, or -1."""
    t, gap, n0, n1, n2, _ = _foot(x1[0], x1[1], x1[2], world.near[i], world.end, world)
    comes = _comes_into(t, gap - offset, n0, n1, n2, s0, s1, s2, x1, i, world, nodes)
    way = np.sqrt((x1[0] - s0) ** 2 + (x1[1] - s1) ** 2 + (x1[2] - s2) ** 2)
    limit = (1.0 + BESIDE) * way + offset + nodes.way_out[i] + 1e-6
    for k in range(PLANES):
        if not comes and nodes.owner[i, k] >= 0 and nodes.over[i, k] >= 0:
            m = nodes.normal[i, k]
            t, gap, n0, n1, n2 = _foot_facing(
                x1[0], x1[1], x1[2], m[0], m[1], m[2], FACING, limit, world
            )
            if t >= 0:
                comes = _comes_into(t, gap - offset, n0, n1, n2, s0, s1, s2, x1, i, world, nodes)
    if not comes:
        return np.int64(-1)
    place[0], place[1], place[2], place[3], place[4], place[5] = x1[0], x1[1], x1[2], n0, n1, n2
    place[6] = offset - gap - nodes.way_out[i]
    return t


@kernel(makes_arrays=False)
def met(
    x0: np.ndarray,
    x1: np.ndarray,
    i: int,
    offset: float,
    world: Any,
    nodes: Set,
    place: np.ndarray,
) -> tuple[Any, Any]:
    """See obstacle.py."""
    owner, shape = np.int64(-1), np.int64(0)
    if len(world.shapes.segments) > 0:
        owner, shape = met_shapes(x0, x1, i, offset, world.shapes, nodes, place)
    if _clear(x1, i, offset, world.path[0] + world.path[1], world) > 0.0:
        return owner, shape
    held = False
    for k in range(PLANES):
        held = held or (nodes.owner[i, k] >= 0 and nodes.over[i, k] >= 0)
    t = _foot(x0[0], x0[1], x0[2], world.near[i], world.start, world)[0]
    u0, u1, u2 = _drift(x0, t, world)
    s0, s1, s2, other = x0[0] + u0, x0[1] + u1, x0[2] + u2, world.other
    if held:
        over = _other_sheet(s0, s1, s2, x1, i, offset, world, nodes, other)
    else:
        over = _along_way(s0, s1, s2, x1, i, offset, world, nodes, other)
    if over < 0 or (owner >= 0 and place[6] >= other[6]):
        return owner, shape
    for c in range(7):
        place[c] = other[c]
    return world.owners[over], over


@kernel(makes_arrays=False)
def velocity(x: np.ndarray, i: int, k: int, world: Any, nodes: Set, out: np.ndarray) -> None:
    """See obstacle.py."""
    t = nodes.over[i, k]
    if t < 0:
        velocity_of_shape(x, i, k, world.shapes, nodes, out)
        return
    v, corners = world.end.vertices, world.mesh.triangles
    b1, b2, h = numbers_of(v, corners, t, x[0], x[1], x[2])
    out[0], out[1], out[2] = speed_at(v, world.rates, corners, t, b1, b2, h)


@kernel(makes_arrays=False)
def book(
    x: np.ndarray,
    i: int,
    k: int,
    impulse: np.ndarray,
    energies: np.ndarray,
    world: Any,
    nodes: Set,
) -> None:
    """See obstacle.py."""
    t = nodes.over[i, k]
    if t < 0:
        book_shape(x, i, k, impulse, energies, world.shapes, nodes)
        return
    v, corners = world.end.vertices, world.mesh.triangles
    b1, b2, h = numbers_of(v, corners, t, x[0], x[1], x[2])
    add_impulse(
        v, corners, t, b1, b2, h, impulse, energies[0], energies[1], energies[2], world.acting
    )


KERNELS = Obstacle(
    locate_kernel(depth, carry, tangent, met), velocities_kernel(velocity), book_kernel(book)
)
