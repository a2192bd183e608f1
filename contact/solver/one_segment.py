# SPDX-License-Identifier: LGPL-3.0-or-later
"""Contact of a node that meets one segment or none in its step, Eqs. 15 and 16.

Nearly all nodes near the body are of this kind. What node_contact.py does for any number of
segments is written out here for one, in scalars: with the plane n . step >= bound at the closest
point, the free step s_f goes to

    s = s_f + a n,  a = bound - n . s_f,

then friction takes of the slip what its cone transmits, and a is found anew. The numbers are those
of node_contact.py to the last bit. Nodes that are not of this kind (several planes, a path that
must be followed, friction that lifts the node off) are left to it untouched.
"""

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from contact.geometry.shape import foot_and_normal, least_distance
from contact.kernel import kernel

from .contact_ledger import FRICTION, IMPACT, WORK
from .friction import cone_kernel
from .guard_planes import height_over_guard, keep_guard
from .segment_motion import drift_of, turned_by
from .step_record import ALLOWED, FAR
from .supporting_planes import LONG_STEP, first_contact

NONE, MANY = -1, -2  # no segment; not decided here


@kernel(makes_arrays=False)
def _length(a0, a1, a2):
    return np.sqrt(a0 * a0 + a1 * a1 + a2 * a2)


@kernel(makes_arrays=False)
def _arm(x, i, segment):
    """From the centre of a segment to node i."""
    return x[i, 0] - segment.centre[0], x[i, 1] - segment.centre[1], x[i, 2] - segment.centre[2]


@kernel(makes_arrays=False)
def _in_sphere(segment, q0, q1, q2, reach):
    """Whether a step of some length from centre + q can come into the sphere around a segment."""
    limit = segment.reach + reach
    near = segment.contraction * segment.contraction
    return (q0 * q0 + q1 * q1 + q2 * q2) * near <= limit * limit


@kernel(makes_arrays=False)
def only_plane(
    x: np.ndarray,
    i: int,
    f0: float,
    f1: float,
    f2: float,
    sets: np.ndarray,
    guards: np.ndarray,
    work: Any,
    segments: np.ndarray,
    gaps: np.ndarray,
) -> tuple[int, float, float, float, float, float]:
    """The segment that the free step f of node i may meet, NONE, or MANY for several.

    gaps : (m,), filled for the segments looked at: no more than the gap at the start [m], -inf
        where that was not asked

    Returns the segment, the fraction of the step after which a long one meets it (0 of a short
    one), the height of the start over the plane [m] and the plane's normal in the axes of the
    segment.
    """
    reach = _length(f0, f1, f2)
    allowed = sets[ALLOWED, i]
    if reach <= work.clearance:
        allowed &= ~sets[FAR, i]
    owner, tau, height, m0, m1, m2 = NONE, 0.0, 0.0, 0.0, 0.0, 0.0
    for b in range(len(segments)):
        segment = segments[b]
        if not (allowed >> segment.bit) & 1:
            continue
        gaps[b] = -np.inf
        q0, q1, q2 = _arm(x, i, segment)
        if not _in_sphere(segment, q0, q1, q2, reach):
            continue
        u0, u1, u2 = drift_of(segment, q0, q1, q2)
        y0, y1, y2 = turned_by(segment.axes, q0, q1, q2)
        p0, p1, p2 = f0 - u0, f1 - u1, f2 - u2
        way = _length(p0, p1, p2)
        gaps[b] = height_over_guard(guards, i, b, y0, y1, y2) - work.offset - segment.roundoff
        if gaps[b] > way:
            continue
        least = least_distance(segment, y0, y1, y2)
        if least > work.offset + way:
            gaps[b] = least - work.offset
            continue
        foot = foot_and_normal(segment, y0, y1, y2)
        distance, x0, x1, x2, n0, n1, n2 = foot
        work.evaluated += 1
        gap, met = distance - work.offset, 0.0
        gaps[b] = gap
        if gap > way:
            keep_guard(guards, i, b, x0, x1, x2, n0, n1, n2)
            continue
        if gap > segment.roundoff and way > LONG_STEP * segment.curvature_radius:
            if owner != NONE and tau == 0.0:
                continue  # `no_other` looks where that plane leads
            p0, p1, p2 = turned_by(segment.end_axes, p0, p1, p2)
            met, more, n0, n1, n2, gap = first_contact(
                segment, y0, y1, y2, p0, p1, p2, work.offset, foot
            )
            work.evaluated += more
            if met > 1.0:
                continue
        if owner != NONE:
            return MANY, 0.0, 0.0, 0.0, 0.0, 0.0
        owner, tau, height, m0, m1, m2 = b, met, gap, n0, n1, n2
    return owner, tau, height, m0, m1, m2


@kernel(makes_arrays=False)
def no_other(
    x: np.ndarray,
    i: int,
    owner: int,
    tau: float,
    f0: float,
    f1: float,
    f2: float,
    s0: float,
    s1: float,
    s2: float,
    sets: np.ndarray,
    work: Any,
    segments: np.ndarray,
    gaps: np.ndarray,
) -> bool:
    """Whether node i meets its owner alone: with the step f up to tau, from there on to s.

    gaps : see `only_plane`. A distance changes by no more than the way.
    """
    a0, a1, a2, rest = tau * f0, tau * f1, tau * f2, 1.0 - tau
    reach = _length(s0, s1, s2) + _length(a0, a1, a2)
    allowed = sets[ALLOWED, i] & ~sets[FAR, i]
    if reach > work.clearance and sets[ALLOWED, i] != allowed:
        return False
    for b in range(len(segments)):
        segment = segments[b]
        if b == owner or not (allowed >> segment.bit) & 1:
            continue
        q0, q1, q2 = _arm(x, i, segment)
        if not _in_sphere(segment, q0, q1, q2, reach):
            continue
        u0, u1, u2 = drift_of(segment, q0, q1, q2)
        way = _length(s0 - a0 - rest * u0, s1 - a1 - rest * u1, s2 - a2 - rest * u2)
        if tau > 0.0:
            way += _length(a0 - tau * u0, a1 - tau * u1, a2 - tau * u2) + segment.roundoff
        if not gaps[b] > way:
            return False
    return True


@cache
def one_segment_kernel(kinetic_coefficient: Callable) -> Any:
    """Kernel meet_one(x, v, old, mass, i, sets, guards, work, segments, gaps, *books) of a law.

    It corrects node i; books : table and impulses of this step, impulses of the window, see
    `correction_kernel`. Returns the segment that holds it, NONE or MANY; MANY leaves everything but
    `gaps`, `guards` and the count of closest points as it is.
    """
    transmitted = cone_kernel(kinetic_coefficient)

    @kernel(makes_arrays=False)
    def meet_one(x, v, old, mass, i, sets, guards, work, segments, gaps, book, impulse, window):
        dt = work.dt
        v0, v1, v2 = v[i, 0], v[i, 1], v[i, 2]
        f0, f1, f2 = dt * v0, dt * v1, dt * v2
        b, tau, gap, m0, m1, m2 = only_plane(x, i, f0, f1, f2, sets, guards, work, segments, gaps)
        if b < 0:
            return b
        segment = segments[b]
        depth = max(0.0, -gap)
        q0, q1, q2 = _arm(x, i, segment)
        u0, u1, u2 = drift_of(segment, q0, q1, q2)
        axes = segment.end_axes
        n0 = m0 * axes[0, 0] + m1 * axes[1, 0] + m2 * axes[2, 0]
        n1 = m0 * axes[0, 1] + m1 * axes[1, 1] + m2 * axes[2, 1]
        n2 = m0 * axes[0, 2] + m1 * axes[1, 2] + m2 * axes[2, 2]
        bound = min(-gap, work.recovery) + n0 * u0 + n1 * u1 + n2 * u2
        push = bound - (n0 * f0 + n1 * f1 + n2 * f2)
        if not push > 0.0:
            # the free step is the step: segments that `only_plane` left to be asked are asked here
            if not no_other(x, i, b, tau, f0, f1, f2, f0, f1, f2, sets, work, segments, gaps):
                return MANY
            work.max_depth = max(work.max_depth, depth)
            return NONE
        s0, s1, s2 = f0 + push * n0, f1 + push * n1, f2 + push * n2
        t0, t1, t2, stick = 0.0, 0.0, 0.0, False
        if work.friction[0] > 0.0:
            w0, w1, w2 = s0 - u0, s1 - u1, s2 - u2
            along = w0 * n0 + w1 * n1 + w2 * n2
            t0, t1, t2 = -(w0 - along * n0), -(w1 - along * n1), -(w2 - along * n2)
            size, inertia = _length(t0, t1, t2), mass[i] / dt
            fraction = transmitted(inertia * push, inertia * size, size / dt, work.friction)
            stick = fraction == 1.0
            t0, t1, t2 = fraction * t0, fraction * t1, fraction * t2
            s0, s1, s2 = f0 + t0, f1 + t1, f2 + t2
            push = bound - (n0 * s0 + n1 * s1 + n2 * s2)
            if not push > 0.0:
                return MANY
            s0, s1, s2 = s0 + push * n0, s1 + push * n1, s2 + push * n2
        if not no_other(x, i, b, tau, f0, f1, f2, s0, s1, s2, sets, work, segments, gaps):
            return MANY
        work.max_depth = max(work.max_depth, depth)
        work.active += 1
        work.sticking += stick
        scale, p0, p1, p2 = mass[i] / dt, push * n0, push * n1, push * n2
        c0, c1, c2 = (p0 + t0) / dt, (p1 + t1) / dt, (p2 + t2) / dt
        # slip over the step: mean of the velocities before and after it, less the surface's
        r0, r1, r2 = u0 / dt, u1 / dt, u2 / dt
        w0 = v0 + 0.5 * (c0 - (v0 - old[i, 0])) - r0
        w1 = v1 + 0.5 * (c1 - (v1 - old[i, 1])) - r1
        w2 = v2 + 0.5 * (c2 - (v2 - old[i, 2])) - r2
        p0, p1, p2 = scale * p0, scale * p1, scale * p2
        t0, t1, t2 = scale * t0, scale * t1, scale * t2
        j0, j1, j2 = p0 + t0, p1 + t1, p2 + t2
        book[b, 0] += j0
        book[b, 1] += j1
        book[b, 2] += j2
        book[b, 3] += q1 * j2 - q2 * j1
        book[b, 4] += q2 * j0 - q0 * j2
        book[b, 5] += q0 * j1 - q1 * j0
        book[b, WORK] += j0 * r0 + j1 * r1 + j2 * r2
        book[b, FRICTION] += 0.0 - t0 * w0 - t1 * w1 - t2 * w2
        book[b, IMPACT] += 0.0 - p0 * w0 - p1 * w1 - p2 * w2
        v[i, 0] += c0
        v[i, 1] += c1
        v[i, 2] += c2
        j0, j1, j2 = mass[i] * c0, mass[i] * c1, mass[i] * c2
        impulse[i, 0], impulse[i, 1], impulse[i, 2] = j0, j1, j2
        window[i, 0] += j0
        window[i, 1] += j1
        window[i, 2] += j2
        return b

    return meet_one
