# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cloth in a crease between two parts of the body, which are soft: a penalty there.

Rigid segments that close over cloth, as calf and thigh do at a bent knee, squeeze it out of the
crease between them with any force, and tear it. Flesh gives way, keeps the cloth and flattens: at
the surface where the two meet, both press alike.

So a part of the body that presses a point against another, with normals more than a right angle
apart, lets it in: at a depth d below its skin it presses with

    p = k (d + tau d')     [Pa],   never pulling,

as an elastic layer of stiffness k with a little loss, until the point has come out again. From both
sides the point is led to where the two pressures balance, held there by the friction of both, and
the work of k d is given back when the parts open. Everywhere else the body is rigid.

What the two press on each other alike is there without the cloth too, flesh on flesh: pushes of
f_i n_i and f_j n_j are booked less c (n_i - n_j)/2 and c (n_j - n_i)/2, c the smaller of f_i, f_j.
Their sum, the force on the cloth, stays; of two equal opposite pushes nothing is left.

Segments on one and the same carrier (`moving_together`) make a hard crease, as one body does.
"""

from typing import Any

import numpy as np

from contact.geometry.shape import foot_and_normal
from contact.kernel import kernel

from .nearest_step import PINCHED
from .segment_motion import drift_of, turned_by
from .supporting_planes import set_plane

# tau [s]: brings cloth that swings between two soft sides to rest; in a walk it is no matter
RELAXATION = 5e-4
RESOLVED = 0.1  # of 1/dt^2, the greatest stiffness over mass that steps of dt follow


@kernel(makes_arrays=False)
def soft_pushes(
    x: np.ndarray, node: Any, begun: int, work: Any, segments: np.ndarray, planes: np.ndarray
) -> float:
    """Pushes of the soft segments that a node lies in; `work.free` is changed by them.

    Parameters
    ----------
    x : (3,) float, node at t [m]; node : NODE, `penetrated` loses those that the node has left
    begun : int, set of the segments that began to let the node in in this step
    work : STEP, `soft` is set: planes filled
    segments : (m,) SEGMENT; planes : PLANE, filled from m on

    Returns
    -------
    greatest depth [m]
    """
    count, deepest, inside, start, dt = 0, 0.0, 0, len(segments), work.dt
    flesh = min(work.flesh, RESOLVED / dt**2)
    loss = flesh * RELAXATION * dt
    for b in range(len(segments)):
        segment = segments[b]
        if not (node.penetrated >> segment.bit) & 1:
            continue
        q0, q1, q2 = x[0] - segment.centre[0], x[1] - segment.centre[1], x[2] - segment.centre[2]
        y0, y1, y2 = turned_by(segment.axes, q0, q1, q2)
        distance, _, _, _, n0, n1, n2 = foot_and_normal(segment, y0, y1, y2)
        depth = work.offset - distance
        if depth <= 0.0:
            continue
        inside |= 1 << segment.bit
        u0, u1, u2 = drift_of(segment, q0, q1, q2)
        plane = planes[start + count]
        set_plane(plane, b, segment, n0, n1, n2, 0.0, depth, u0, u1, u2)
        n = plane.normal
        closing = 0.0
        for c in range(3):
            closing += (plane.drift[c] - work.free[c] + dt * work.kick[c]) * n[c]
        plane.push = max(0.0, flesh * dt * dt * depth + loss / (1.0 + loss) * closing)
        count, deepest = count + 1, max(deepest, depth)
    for k in range(start, start + count):
        for c in range(3):
            work.free[c] += planes[k].push * planes[k].normal[c]
    node.penetrated &= inside | begun
    work.soft = count
    return deepest


@kernel(makes_arrays=False)
def opposed(planes: np.ndarray, count: int, segments: np.ndarray, every: bool) -> int:
    """Set of the segments whose planes are turned against one of another segment.

    planes : (m,) PLANE, the first `count` in use; those that push, or `every` one
    """
    out = 0
    for k in range(count):
        for j in range(k):
            if not every and (planes[k].push <= 0.0 or planes[j].push <= 0.0):
                continue
            one, other = segments[planes[k].owner], segments[planes[j].owner]
            if (one.moving_together >> other.bit) & 1:
                continue
            p, q = planes[k].normal, planes[j].normal
            if p[0] * q[0] + p[1] * q[1] + p[2] * q[2] < 0.0:
                out |= (1 << one.bit) | (1 << other.bit)
    return out


@kernel(makes_arrays=False)
def bed_stiffness(planes: np.ndarray, work: Any, segments: np.ndarray) -> float:
    """Stiffness [Pa/m] of the beds that press the node at work from opposite sides.

    The sum over all segments whose pushes are turned against one of another segment; infinite where
    these are hard; zero where the node is free or pressed from one side only. `work.bed` is that of
    one segment; planes : (m,) PLANE, `count` hard ones, then `soft` ones.
    """
    both = opposed(planes, work.count + work.soft, segments, work.pushing == PINCHED)
    if both == 0:
        return 0.0
    stiffness = 0.0
    while both:
        both &= both - 1
        stiffness += work.bed
    return stiffness


@kernel(makes_arrays=False)
def from_cloth(
    planes: np.ndarray, first: int, last: int, k: int, segments: np.ndarray, out: np.ndarray
) -> None:
    """Push (3,) of plane k that is booked, into out: less what is flesh on flesh.

    planes : (m,) PLANE, from `first` to before `last` those of soft parts
    """
    n, push = planes[k].normal, planes[k].push
    for c in range(3):
        out[c] = push * n[c]
    if k < first:
        return
    for j in range(first, last):
        if (
            j == k
            or (segments[planes[k].owner].moving_together >> segments[planes[j].owner].bit) & 1
        ):
            continue
        common = 0.5 * min(push, planes[j].push)
        for c in range(3):
            out[c] -= common * (n[c] - planes[j].normal[c])
