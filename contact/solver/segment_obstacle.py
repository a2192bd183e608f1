# SPDX-License-Identifier: LGPL-3.0-or-later
"""Segments of a body as implicit steps meet them: an obstacle of convex shapes."""

from typing import Any, NamedTuple

import numpy as np

from contact.body.pose_check import require_no_jump
from contact.body.segments import Body
from contact.geometry.shape import foot_and_normal
from contact.kernel import kernel

from .contact_ledger import BOOKED, book_impulse
from .held_nodes import PLANES, Set
from .obstacle import Obstacle, book_kernel, locate_kernel, velocities_kernel
from .segment_motion import segment_records, set_motion, turned_by

INSIDE = 1e-9  # m: a node is met when it ends deeper than this
LONG = 0.1  # of the inner radius: a longer way is looked along for segments passed through
LOOKS = 16  # places looked at on a long way


class Segments(NamedTuple):
    """segments (m,) SEGMENT; rows (m,) int, of the ledger; velocities, spins (m, 3), at the end
    [m/s, rad/s]; table (m, BOOKED), filled; place (7,), at (3, 3) : scratch."""

    segments: np.ndarray
    rows: np.ndarray
    velocities: np.ndarray
    spins: np.ndarray
    table: np.ndarray
    place: np.ndarray
    at: np.ndarray


@kernel(makes_arrays=False)
def foot(
    x: np.ndarray, centre: np.ndarray, axes: np.ndarray, segment: Any, normal: np.ndarray
) -> float:
    """Distance of x to a segment posed so; its outward normal into `normal`."""
    q0, q1, q2 = x[0] - centre[0], x[1] - centre[1], x[2] - centre[2]
    y0, y1, y2 = turned_by(axes, q0, q1, q2)
    distance, _, _, _, n0, n1, n2 = foot_and_normal(segment, y0, y1, y2)
    for c in range(3):
        normal[c] = n0 * axes[0, c] + n1 * axes[1, c] + n2 * axes[2, c]
    return distance


@kernel(makes_arrays=False)
def carried(x: np.ndarray, segment: Any, out: np.ndarray) -> None:
    """Where the segment takes its point x over the step."""
    for c in range(3):
        out[c] = segment.end_centre[c]
    for k in range(3):
        y = 0.0
        for c in range(3):
            y += segment.axes[k, c] * (x[c] - segment.centre[c])
        for c in range(3):
            out[c] += y * segment.end_axes[k, c]


@kernel(makes_arrays=False)
def _square(a, b):
    """Square of the distance of two points."""
    return (a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 + (a[2] - b[2]) ** 2


@kernel(makes_arrays=False)
def depth(x: np.ndarray, i: int, offset: float, world: Any) -> float:
    """See obstacle.py."""
    deepest, normal = 0.0, world.at[0]
    for b in range(len(world.segments)):
        segment = world.segments[b]
        far = segment.bounding_radius + offset
        if _square(x, segment.centre) < far * far:
            own = offset - foot(x, segment.centre, segment.axes, segment, normal)
            deepest = max(deepest, own)
    return deepest


@kernel(makes_arrays=False)
def carry(x: np.ndarray, i: int, world: Any, nodes: Set) -> None:
    """See obstacle.py."""
    carried(x, world.segments[-1 - nodes.over[i, 0]], nodes.anchor[i])


@kernel(makes_arrays=False)
def tangent(x: np.ndarray, i: int, k: int, offset: float, world: Any, nodes: Set) -> float:
    """See obstacle.py."""
    segment = world.segments[-1 - nodes.over[i, k]]
    distance = foot(x, segment.end_centre, segment.end_axes, segment, nodes.normal[i, k])
    gap = distance - offset + nodes.way_out[i]
    n = nodes.normal[i, k]
    nodes.height[i, k] = n[0] * x[0] + n[1] * x[1] + n[2] * x[2] - gap
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
    """See obstacle.py; the deepest segment."""
    found, deepest, segments = -1, INSIDE, world.segments
    normal, start, at = world.at[0], world.at[1], world.at[2]
    for b in range(len(segments)):
        held = False
        for k in range(PLANES):
            held = held or (nodes.owner[i, k] >= 0 and nodes.over[i, k] == -1 - b)
        if held:
            continue
        segment = segments[b]
        end, axes = segment.end_centre, segment.end_axes
        carried(x0, segment, start)
        way = np.sqrt(_square(x1, start))
        far = segment.bounding_radius + offset
        if _square(x1, end) > (far + way) ** 2:
            continue
        looks = LOOKS if way > LONG * segment.inner_radius else 1
        before = foot(start, end, axes, segment, normal) - offset
        for look in range(1, looks + 1):
            for c in range(3):
                at[c] = start[c] + look / looks * (x1[c] - start[c])
            gap = foot(at, end, axes, segment, normal) - offset
            own = -gap - nodes.way_out[i]
            if own > deepest:
                found, deepest = b, own
                part = before / (before - gap) if before > 0.0 else 0.0
                fraction = (look - 1 + part) / looks
                for c in range(3):
                    place[c] = start[c] + fraction * (x1[c] - start[c])
                    place[3 + c] = normal[c]
                place[6] = own
                break
            before = gap
    if found < 0:
        return np.int64(-1), np.int64(0)
    return world.rows[found], np.int64(-1 - found)


@kernel(makes_arrays=False)
def velocity(x: np.ndarray, i: int, k: int, world: Any, nodes: Set, out: np.ndarray) -> None:
    """See obstacle.py."""
    b = -1 - nodes.over[i, k]
    centre = world.segments[b].end_centre
    for c in range(3):
        d, e = (c + 1) % 3, (c + 2) % 3
        turn = world.spins[b, d] * (x[e] - centre[e])
        turn -= world.spins[b, e] * (x[d] - centre[d])
        out[c] = world.velocities[b, c] + turn


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
    b = -1 - nodes.over[i, k]
    row, centre = world.table[world.rows[b]], world.segments[b].end_centre
    book_impulse(row, centre, x, impulse, energies[0], energies[1], energies[2])


KERNELS = Obstacle(
    locate_kernel(depth, carry, tangent, met), velocities_kernel(velocity), book_kernel(book)
)


class SegmentObstacle:
    """The segments of a body over a step, all or some of them.

    Parameters
    ----------
    body : Body; offset : float [m]; shapes : names of those that are met, None: all

    Attributes
    ----------
    names : of the rows of the ledger; met : names and shapes of the segments that are met
    kernels : Obstacle; world : Segments
    """

    kernels = KERNELS

    def __init__(self, body: Body, offset: float, shapes: Any = None) -> None:
        self.names, self._body, self._offset = tuple(body.names), body, offset
        chosen = self.names if shapes is None else shapes
        self._chosen = np.array([self.names.index(name) for name in chosen], np.int64)
        self.met = chosen, [body.shapes[k] for k in self._chosen]
        self._extents = np.array([shape.half_extents for shape in body.shapes])
        self._start, self._end = body.new_pose(), body.new_pose()
        m, k = len(self.names), len(self._chosen)
        self.world = Segments(
            segment_records(body)[self._chosen], self._chosen, np.zeros((k, 3)), np.zeros((k, 3)),
            np.zeros((m, BOOKED)), np.zeros(7), np.zeros((3, 3)),
        )  # fmt: skip

    def move(self, t: float, dt: float) -> None:
        """Place the segments at the start and at the end of a step; ValueError if one jumps."""
        start, end, chosen, world = self._start, self._end, self._chosen, self.world
        self._body.pose(t, start)
        self._body.pose(t + dt, end)
        require_no_jump(self._body.names, self._extents, start, end, t, dt)
        parts = (part[chosen] for pose in (start, end) for part in pose[:2])
        set_motion(*parts, self._offset, world.segments)
        world.velocities[:], world.spins[:] = end.velocities[chosen], end.spins[chosen]

    def booked(self, table: np.ndarray, x: np.ndarray) -> None:
        """Take what was booked since the last call into a ledger's table; x (n, 3) : nodes [m]."""
        table[:] = self.world.table
        self.world.table[:] = 0.0

    def settle(self) -> None:
        """A step is done."""
