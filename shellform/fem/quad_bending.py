# SPDX-License-Identifier: LGPL-3.0-or-later
"""Curvature of a 4-node quad by turning angles, at its Gauss points: Eq. 14.

Two lines run along each axis through the Gauss points: 0, 1 along axis 1, 2, 3 along axis 2. A line
is a mean of two sides, and its curvature serves both Gauss points on it. Where a line crosses
another, the twist is the curvature along their sum less that along their difference, over 4.
Gauss points (crossings) run in tensor order: lines 02, 03, 12, 13.

C : (4, 15), see quad_reference.py; its row k is of Gauss point k.
"""

from typing import NamedTuple

import numpy as np

from .element import GAUSS2
from .quad_membrane import Four, FourVectors, Segment, Segments, segment
from .vector3 import Vector, add, compiled, dot, mix, plus, stage, sub

Lines = tuple[Segment, Segment, Segment, Segment]

NEAR, FAR = 1.0 - GAUSS2[0][0], GAUSS2[0][0]


class Crossing(NamedTuple):
    """b and c along the sum and along the difference of two lines that cross."""

    plus_b: float
    minus_b: float
    plus_c: float
    minus_c: float


Crossings = tuple[Crossing, Crossing, Crossing, Crossing]


@stage
def on_lines(a: FourVectors) -> FourVectors:
    """Means on the four lines of what the four sides have; symmetric, so it also takes back to the
    sides what acts on the lines."""
    a0, a1, a2, a3 = a
    return (
        mix(NEAR, a0, FAR, a1), mix(FAR, a0, NEAR, a1),
        mix(NEAR, a2, FAR, a3), mix(FAR, a2, NEAR, a3),
    )  # fmt: skip


@stage
def lines(cell: Segments) -> Lines:
    """The four lines of a cell."""
    s0, s1, s2, s3, _, _ = cell
    X0, X1, X2, X3 = on_lines((s0.X, s1.X, s2.X, s3.X))
    D0, D1, D2, D3 = on_lines((s0.D, s1.D, s2.D, s3.D))
    return segment(X0, D0), segment(X1, D1), segment(X2, D2), segment(X3, D3)


@compiled
def crossing(p: Segment, q: Segment) -> Crossing:
    cross_b = dot(p.X, q.D) + dot(q.X, p.D)
    cross_c = 2.0 * dot(p.D, q.D)
    b, c = p.b + q.b, p.c + q.c
    return Crossing(b + cross_b, b - cross_b, c + cross_c, c - cross_c)


@stage
def crossings(four: Lines) -> Crossings:
    """The four Gauss points of a cell."""
    p0, p1, q0, q1 = four
    return crossing(p0, q0), crossing(p0, q1), crossing(p1, q0), crossing(p1, q1)


# ---------------------------------------------------------------- strains and their rates


@compiled
def turning(b: float, c: float) -> float:
    """Curvature that the angle between two directors tells, of b = X . D and c = D . D."""
    return b * (1.0 + c / 12.0 + c * c / 90.0)


@compiled
def twist(x: Crossing) -> float:
    return 0.25 * (turning(x.plus_b, x.plus_c) - turning(x.minus_b, x.minus_c))


@stage
def curvatures(four: Lines, rest: np.ndarray) -> Four:
    """Of the lines, less those at rest."""
    p0, p1, q0, q1 = four
    return (
        turning(p0.b, p0.c) - rest[10],
        turning(p1.b, p1.c) - rest[11],
        turning(q0.b, q0.c) - rest[12],
        turning(q1.b, q1.c) - rest[13],
    )


@stage
def twists(points: Crossings, rest: np.ndarray) -> Four:
    """At the Gauss points, less those at rest."""
    x0, x1, x2, x3 = points
    return twist(x0) - rest[14], twist(x1) - rest[15], twist(x2) - rest[16], twist(x3) - rest[17]


@compiled
def turning_rate(b: float, c: float, rate_b: float, rate_c: float) -> float:
    return rate_b * (1.0 + c / 12.0 + c * c / 90.0) + b * (1.0 / 12.0 + c / 45.0) * rate_c


@compiled
def line_rate(line: Segment, vX: Vector, vD: Vector) -> Segment:
    """Rates of a line, from those of X and D."""
    return Segment(vX, vD, dot(vX, line.D) + dot(line.X, vD), 2.0 * dot(line.D, vD))


@stage
def line_rates(four: Lines, vX: FourVectors, vD: FourVectors) -> Lines:
    """Rates of `lines`, from those of X and D."""
    return (
        line_rate(four[0], vX[0], vD[0]),
        line_rate(four[1], vX[1], vD[1]),
        line_rate(four[2], vX[2], vD[2]),
        line_rate(four[3], vX[3], vD[3]),
    )


@stage
def curvature_rates(four: Lines, v: Lines) -> Four:
    """Rates of `curvatures`; v : rates of the lines."""
    p0, p1, q0, q1 = four
    v0, v1, v2, v3 = v
    return (
        turning_rate(p0.b, p0.c, v0.b, v0.c),
        turning_rate(p1.b, p1.c, v1.b, v1.c),
        turning_rate(q0.b, q0.c, v2.b, v2.c),
        turning_rate(q1.b, q1.c, v3.b, v3.c),
    )


@compiled
def twist_rate(p: Segment, vp: Segment, q: Segment, vq: Segment, x: Crossing) -> float:
    """Rate of the twist where lines p and q cross, from theirs."""
    rate_b = dot(vp.X, q.D) + dot(vq.X, p.D) + dot(p.X, vq.D) + dot(q.X, vp.D)
    rate_c = 2.0 * (dot(vp.D, q.D) + dot(p.D, vq.D))
    more = turning_rate(x.plus_b, x.plus_c, vp.b + vq.b + rate_b, vp.c + vq.c + rate_c)
    less = turning_rate(x.minus_b, x.minus_c, vp.b + vq.b - rate_b, vp.c + vq.c - rate_c)
    return 0.25 * (more - less)


@stage
def twist_rates(four: Lines, v: Lines, points: Crossings) -> Four:
    """Rates of `twists`; v : rates of the lines."""
    p0, p1, q0, q1 = four
    v0, v1, v2, v3 = v
    return (
        twist_rate(p0, v0, q0, v2, points[0]),
        twist_rate(p0, v0, q1, v3, points[1]),
        twist_rate(p1, v1, q0, v2, points[2]),
        twist_rate(p1, v1, q1, v3, points[3]),
    )


# ---------------------------------------------------------------- moments, their forces and loss


@compiled
def moments(C: np.ndarray, k: int, k1: float, k2: float, twist: float) -> Vector:
    """Moments conjugate to the two curvatures and the twist at Gauss point k."""
    return (
        C[k, 9] * k1 + C[k, 10] * k2 + C[k, 11] * twist,
        C[k, 10] * k1 + C[k, 12] * k2 + C[k, 13] * twist,
        C[k, 11] * k1 + C[k, 13] * k2 + C[k, 14] * twist,
    )


@compiled
def point_loss(C: np.ndarray, k: int, k1: float, k2: float, twist: float) -> float:
    """Rates times what they do to the moments."""
    m1, m2, m3 = moments(C, k, k1, k2, twist)
    return m1 * k1 + m2 * k2 + m3 * twist


@stage
def loss_with_bending(loss: float, C: np.ndarray, curvature: Four, twist: Four) -> float:
    """`loss` with that of the rates of curvature and twist, Gauss point by Gauss point."""
    r0, r1, r2, r3 = curvature
    z0, z1, z2, z3 = twist
    loss += point_loss(C, 0, r0, r2, z0) + point_loss(C, 1, r0, r3, z1)
    loss += point_loss(C, 2, r1, r2, z2) + point_loss(C, 3, r1, r3, z3)
    return loss


@compiled
def twisted(
    moment: float, p: Segment, q: Segment, x: Crossing
) -> tuple[Vector, Vector, Vector, Vector]:
    """Forces on lines p and q, and couples, of a twisting moment where they cross."""
    moment = 0.25 * moment
    s = moment * (1.0 + x.plus_c / 12.0 + x.plus_c * x.plus_c / 90.0)
    t = moment * (1.0 + x.minus_c / 12.0 + x.minus_c * x.minus_c / 90.0)
    sd = moment * x.plus_b * (1.0 / 6.0 + x.plus_c * (2.0 / 45.0))
    td = moment * x.minus_b * (1.0 / 6.0 + x.minus_c * (2.0 / 45.0))
    hp, hm = add(p.D, q.D), sub(p.D, q.D)
    plus_f, minus_f = mix(s, hp, 0.0, hp), mix(t, hm, 0.0, hm)
    plus_c, minus_c = mix(s, add(p.X, q.X), sd, hp), mix(t, sub(p.X, q.X), td, hm)
    return sub(plus_f, minus_f), add(plus_f, minus_f), sub(plus_c, minus_c), add(plus_c, minus_c)


@compiled
def bent(moment: float, line: Segment, force: Vector, couple: Vector) -> tuple[Vector, Vector]:
    """Force and couple with those of a bending moment on a line added."""
    s = moment * (1.0 + line.c / 12.0 + line.c * line.c / 90.0)
    t = moment * line.b * (1.0 / 6.0 + line.c * (2.0 / 45.0))
    return plus(force, s, line.D), add(couple, mix(s, line.X, t, line.D))


@stage
def line_forces(
    C: np.ndarray, four: Lines, points: Crossings, curvature: Four, twist: Four
) -> tuple[FourVectors, FourVectors]:
    """Forces and couples, work-conjugate to X and D of the lines, of all moments."""
    p0, p1, q0, q1 = four
    k0, k1, k2, k3 = curvature
    a0, a2, n0 = moments(C, 0, k0, k2, twist[0])
    b0, a3, n1 = moments(C, 1, k0, k3, twist[1])
    a1, b2, n2 = moments(C, 2, k1, k2, twist[2])
    b1, b3, n3 = moments(C, 3, k1, k3, twist[3])
    f0, f2, m0, m2 = twisted(n0, p0, q0, points[0])
    g0, f3, l0, m3 = twisted(n1, p0, q1, points[1])
    f1, g2, m1, l2 = twisted(n2, p1, q0, points[2])
    g1, g3, l1, l3 = twisted(n3, p1, q1, points[3])
    f0, m0 = bent(a0 + b0, p0, add(f0, g0), add(m0, l0))
    f1, m1 = bent(a1 + b1, p1, add(f1, g1), add(m1, l1))
    f2, m2 = bent(a2 + b2, q0, add(f2, g2), add(m2, l2))
    f3, m3 = bent(a3 + b3, q1, add(f3, g3), add(m3, l3))
    return (f0, f1, f2, f3), (m0, m1, m2, m3)
