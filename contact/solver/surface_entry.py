# SPDX-License-Identifier: LGPL-3.0-or-later
"""Where a node comes into a surface of triangles in an implicit step.

Seen from the surface a node starts where the triangle below it carries it, and goes straight. One
that nothing holds yet is looked for along its way; one that is held, where it ends: a sheet that
faces another way, and that it has come into from outside, as the other side of a crease. What faces
the plane that holds it and belongs to another segment is another part that closes on the node,
which would be held by any force between the two: it is left alone.
"""

from typing import Any

import numpy as np

from contact.kernel import kernel

from .held_nodes import PLANES, Set
from .surface_foot import foot, foot_facing
from .surface_planes import INSIDE, OPPOSED
from .surface_way import LONG, LOOKS

FACING = 0.5  # cosine of the angle between normals of one sheet, at least
BESIDE = 0.1  # of its way, by which a node may have been below a sheet that it comes into


@kernel(makes_arrays=False)
def along_way(
    s0: float,
    s1: float,
    s2: float,
    x1: np.ndarray,
    i: int,
    offset: float,
    world: Any,
    nodes: Set,
    place: np.ndarray,
) -> Any:
    """Triangle of the first place inside on the way from s to x1 at the end, or -1."""
    p0, p1, p2 = x1[0] - s0, x1[1] - s1, x1[2] - s2
    way, end = np.sqrt(p0 * p0 + p1 * p1 + p2 * p2), world.end
    allowed = nodes.way_out[i] + INSIDE
    t, gap, n0, n1, n2, _ = foot(s0, s1, s2, world.near[i], end, world)
    part, outside, before = 1.0, 0.0, gap - offset
    first, f0, f1, f2 = t, n0, n1, n2
    deep = max(0.0, -before)  # what starts inside may be on its way out
    if way > LONG:
        part = min(1.0, max(before, 0.25 * LONG) / way)
    for _ in range(LOOKS):
        t, gap, n0, n1, n2, _ = foot(s0 + part * p0, s1 + part * p1, s2 + part * p2, t, end, world)
        gap -= offset
        if gap < -allowed - (deep if part < 1.0 else 0.0):
            if before > 0.0:
                part = outside + (part - outside) * before / (before - gap)
                t, _, n0, n1, n2, _ = foot(
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
def other_sheet(
    s0: float,
    s1: float,
    s2: float,
    x1: np.ndarray,
    i: int,
    offset: float,
    world: Any,
    nodes: Set,
    place: np.ndarray,
) -> Any:
    """Triangle of what faces another way than the planes that hold the node, or -1."""
    t, gap, n0, n1, n2, _ = foot(x1[0], x1[1], x1[2], world.near[i], world.end, world)
    comes = _comes_into(t, gap - offset, n0, n1, n2, s0, s1, s2, x1, i, world, nodes)
    way = np.sqrt((x1[0] - s0) ** 2 + (x1[1] - s1) ** 2 + (x1[2] - s2) ** 2)
    limit = (1.0 + BESIDE) * way + offset + nodes.way_out[i] + 1e-6
    for k in range(PLANES):
        if not comes and nodes.owner[i, k] >= 0 and nodes.over[i, k] >= 0:
            m = nodes.normal[i, k]
            t, gap, n0, n1, n2 = foot_facing(
                x1[0], x1[1], x1[2], m[0], m[1], m[2], FACING, limit, world
            )
            if t >= 0:
                comes = _comes_into(t, gap - offset, n0, n1, n2, s0, s1, s2, x1, i, world, nodes)
    if not comes:
        return np.int64(-1)
    place[0], place[1], place[2], place[3], place[4], place[5] = x1[0], x1[1], x1[2], n0, n1, n2
    place[6] = offset - gap - nodes.way_out[i]
    return t
