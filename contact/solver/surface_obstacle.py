# SPDX-License-Identifier: LGPL-3.0-or-later
"""A closed surface of triangles as implicit steps meet it, with shapes beside it: an obstacle.

The distance and the normal are those of explicit steps (geometry/triangle_mesh/smooth.py). A plane
of a node follows one sheet of the surface: of the triangles that face its way, less than 60 degrees
off, it stands on the closest one. surface_entry.py finds new ones. A node farther away than it and
the surface go asks for nothing.
"""

from typing import Any, NamedTuple

import numpy as np

from contact.geometry.triangle_mesh.carried import (
    Acting,
    add_impulse,
    speed_at,
    turned_with,
)
from contact.geometry.triangle_mesh.placed import Placed
from contact.geometry.triangle_mesh.topology import Mesh
from contact.kernel import kernel

from . import segment_obstacle as of_shapes
from .held_nodes import PLANES, Set
from .obstacle import Obstacle, book_kernel, locate_kernel, velocities_kernel
from .segment_obstacle import Segments
from .surface_entry import FACING, along_way, other_sheet
from .surface_foot import clear, foot, foot_facing, way_of

FAR = 10.0  # m: no sheet is looked for farther away

depth_of_shapes, met_shapes = of_shapes.depth, of_shapes.met
tangent_to_shape, carry_with_shape = of_shapes.tangent, of_shapes.carry
velocity_of_shape, book_shape = of_shapes.velocity, of_shapes.book


class SurfaceWorld(NamedTuple):
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
def depth(x: np.ndarray, i: int, offset: float, world: Any) -> float:
    """See obstacle.py."""
    deepest = 0.0
    if len(world.shapes.segments) > 0:
        deepest = depth_of_shapes(x, i, offset, world.shapes)
    if world.near[i] >= 0 and clear(x, i, offset, world.path[0], world) > 0.0:
        return deepest
    look = world.look[i]
    t, gap, _, _, _, flat = foot(x[0], x[1], x[2], world.near[i], world.start, world)
    world.near[i] = t
    look[0], look[1], look[2], look[4] = x[0], x[1], x[2], world.path[0]
    look[3] = flat - world.highest[0] if gap > 0.0 else -1.0
    return max(deepest, offset - gap)


@kernel(makes_arrays=False)
def carry(x: np.ndarray, i: int, world: Any, nodes: Set) -> None:
    """See obstacle.py."""
    over, anchor = nodes.over[i], nodes.anchor[i]
    if over[0] >= 0:
        u0, u1, u2 = way_of(x, over[0], world)
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
    t, gap, m0, m1, m2 = foot_facing(x[0], x[1], x[2], -n[0], -n[1], -n[2], -FACING, FAR, world)
    if t < 0:
        t, gap, m0, m1, m2, _ = foot(x[0], x[1], x[2], nodes.over[i, k], world.end, world)
    n[0], n[1], n[2] = m0, m1, m2
    nodes.over[i, k], nodes.owner[i, k] = t, world.owners[t]
    gap += nodes.way_out[i] - offset
    nodes.height[i, k] = m0 * x[0] + m1 * x[1] + m2 * x[2] - gap
    return gap


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
    if clear(x1, i, offset, world.path[0] + world.path[1], world) > 0.0:
        return owner, shape
    held = False
    for k in range(PLANES):
        held = held or (nodes.owner[i, k] >= 0 and nodes.over[i, k] >= 0)
    t = foot(x0[0], x0[1], x0[2], world.near[i], world.start, world)[0]
    u0, u1, u2 = way_of(x0, t, world)
    s0, s1, s2, other = x0[0] + u0, x0[1] + u1, x0[2] + u2, world.other
    if held:
        over = other_sheet(s0, s1, s2, x1, i, offset, world, nodes, other)
    else:
        over = along_way(s0, s1, s2, x1, i, offset, world, nodes, other)
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
    out[0], out[1], out[2] = speed_at(v, world.rates, corners, t, x[0], x[1], x[2])


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
    add_impulse(
        v, corners, t, x[0], x[1], x[2], impulse, energies[0], energies[1], energies[2],
        world.acting,
    )  # fmt: skip


KERNELS = Obstacle(
    locate_kernel(depth, carry, tangent, met), velocities_kernel(velocity), book_kernel(book)
)
