# SPDX-License-Identifier: LGPL-3.0-or-later
"""Stretch and transverse shear of a 4-node quad, from its four sides and two diagonals: Eq. 14.

The membrane strain of a corner is that of its two sides and of the diagonal across it, each half
the square of an arc length less that at rest; its shear strain is that of the two sides. What the
stresses do comes back to the segments: a pull along the arc, a shear force across the side.

C : (4, 15), see quad_reference.py; its row k is of corner k. Engineering shear strain of a corner:
+-1/2 (first side + second side - diagonal), + at corners 0 and 3, - at 1 and 2.
"""

from typing import NamedTuple

import numpy as np

from .vector3 import Vector, compiled, dot, mix, stage, sub

Four = tuple[float, float, float, float]
Six = tuple[float, float, float, float, float, float]
FourVectors = tuple[Vector, Vector, Vector, Vector]
SixVectors = tuple[Vector, Vector, Vector, Vector, Vector, Vector]


class Segment(NamedTuple):
    """A segment or a line of a cell, or the rates of one.

    X = difference of positions, D = difference of directors, b = X . D, c = D . D
    """

    X: Vector
    D: Vector
    b: float
    c: float


Segments = tuple[Segment, Segment, Segment, Segment, Segment, Segment]


@compiled
def segment(X: Vector, D: Vector) -> Segment:
    return Segment(X, D, dot(X, D), dot(D, D))


@compiled
def differences(a: FourVectors) -> SixVectors:
    """Differences of a nodal vector along the segments 01, 23, 02, 13, 21, 03."""
    a0, a1, a2, a3 = a
    return sub(a1, a0), sub(a3, a2), sub(a2, a0), sub(a3, a1), sub(a1, a2), sub(a3, a0)


@stage
def segments(x: FourVectors, d: FourVectors) -> Segments:
    """The six segments of a cell with positions x and directors d."""
    X0, X1, X2, X3, X4, X5 = differences(x)
    D0, D1, D2, D3, D4, D5 = differences(d)
    return (
        segment(X0, D0), segment(X1, D1), segment(X2, D2),
        segment(X3, D3), segment(X4, D4), segment(X5, D5),
    )  # fmt: skip


@stage
def middles(d: FourVectors) -> FourVectors:
    """Mean directors of the four sides."""
    d0, d1, d2, d3 = d
    return (
        mix(0.5, d0, 0.5, d1),
        mix(0.5, d2, 0.5, d3),
        mix(0.5, d0, 0.5, d2),
        mix(0.5, d1, 0.5, d3),
    )


# ---------------------------------------------------------------- strains and their rates


@compiled
def half_length_squared(X: Vector, b: float, c: float) -> float:
    """Of the arc: |X|^2/2 + b^2 (1 + 2/15 c)/24."""
    return 0.5 * dot(X, X) + b * b * (1.0 + 2.0 / 15.0 * c) / 24.0


@stage
def stretches(cell: Segments, rest: np.ndarray) -> Six:
    """Half the squares of arc lengths, less those at rest."""
    s0, s1, s2, s3, s4, s5 = cell
    return (
        half_length_squared(s0.X, s0.b, s0.c) - rest[0],
        half_length_squared(s1.X, s1.b, s1.c) - rest[1],
        half_length_squared(s2.X, s2.b, s2.c) - rest[2],
        half_length_squared(s3.X, s3.b, s3.c) - rest[3],
        half_length_squared(s4.X, s4.b, s4.c) - rest[4],
        half_length_squared(s5.X, s5.b, s5.c) - rest[5],
    )


@stage
def shears(cell: Segments, m: FourVectors, rest: np.ndarray) -> Four:
    """Covariant shear X . middle of the sides, less that at rest."""
    s0, s1, s2, s3, _, _ = cell
    m0, m1, m2, m3 = m
    return (
        dot(s0.X, m0) - rest[6],
        dot(s1.X, m1) - rest[7],
        dot(s2.X, m2) - rest[8],
        dot(s3.X, m3) - rest[9],
    )


@compiled
def length_rate(s: Segment, vX: Vector, vD: Vector) -> float:
    """Rate of `half_length_squared`, from those of X and D."""
    change = dot(vX, s.D) + dot(s.X, vD)
    bend = s.b * dot(s.D, vD) * (2.0 / 15.0)
    return dot(s.X, vX) + s.b * (change * (1.0 + 2.0 / 15.0 * s.c) + bend) / 12.0


@stage
def stretch_rates(cell: Segments, vX: SixVectors, vD: SixVectors) -> Six:
    """Rates of `stretches`, vX and vD being those of X and D."""
    return (
        length_rate(cell[0], vX[0], vD[0]),
        length_rate(cell[1], vX[1], vD[1]),
        length_rate(cell[2], vX[2], vD[2]),
        length_rate(cell[3], vX[3], vD[3]),
        length_rate(cell[4], vX[4], vD[4]),
        length_rate(cell[5], vX[5], vD[5]),
    )


@compiled
def shear_rate(X: Vector, vX: Vector, middle: Vector, turn_i: Vector, turn_j: Vector) -> float:
    """Rate of X . middle, middle the mean of two directors that turn."""
    return dot(vX, middle) + 0.5 * (dot(X, turn_i) + dot(X, turn_j))


@stage
def shear_rates(cell: Segments, vX: SixVectors, m: FourVectors, turns: FourVectors) -> Four:
    """Rates of `shears`; turns : rates of the directors."""
    s0, s1, s2, s3, _, _ = cell
    t0, t1, t2, t3 = turns
    return (
        shear_rate(s0.X, vX[0], m[0], t0, t1),
        shear_rate(s1.X, vX[1], m[1], t2, t3),
        shear_rate(s2.X, vX[2], m[2], t0, t2),
        shear_rate(s3.X, vX[3], m[3], t1, t3),
    )


# ---------------------------------------------------------------- stresses, their forces and loss


@compiled
def corner(C: np.ndarray, k: int, sign: float, e1: float, e2: float, diagonal: float) -> Vector:
    """Pulls on the two sides and the diagonal of corner k."""
    e3 = sign * (e1 + e2 - diagonal)
    n3 = sign * (C[k, 2] * e1 + C[k, 4] * e2 + C[k, 5] * e3)
    n1 = C[k, 0] * e1 + C[k, 1] * e2 + C[k, 2] * e3
    n2 = C[k, 1] * e1 + C[k, 3] * e2 + C[k, 4] * e3
    return n1 + n3, n2 + n3, n3


@stage
def pulls(C: np.ndarray, stretch: Six) -> Six:
    """Pulls of the six segments, summed over the corners."""
    s0, s1, s2, s3, s4, s5 = stretch
    p0, p2, n0 = corner(C, 0, 0.5, s0, s2, s4)
    q0, p3, n1 = corner(C, 1, -0.5, s0, s3, s5)
    p1, q2, n2 = corner(C, 2, -0.5, s1, s2, s5)
    q1, q3, n3 = corner(C, 3, 0.5, s1, s3, s4)
    return p0 + q0, p1 + q1, p2 + q2, p3 + q3, -n0 - n3, -n1 - n2


@compiled
def along_arc(pull: float, s: Segment) -> tuple[Vector, Vector]:
    """Force and couple, work-conjugate to X and D, of a pull along the arc."""
    along = pull * s.b * (1.0 + 2.0 / 15.0 * s.c) / 12.0
    across = pull * s.b * s.b / 90.0
    return mix(pull, s.X, along, s.D), mix(along, s.X, across, s.D)


@stage
def shear_forces(C: np.ndarray, shear: Four) -> Four:
    """Shear forces across the four sides, summed over the corners."""
    y0, y1, y2, y3 = shear
    return (
        C[0, 6] * y0 + C[0, 7] * y2 + C[1, 6] * y0 + C[1, 7] * y3,
        C[2, 6] * y1 + C[2, 7] * y2 + C[3, 6] * y1 + C[3, 7] * y3,
        C[0, 7] * y0 + C[0, 8] * y2 + C[2, 7] * y1 + C[2, 8] * y2,
        C[1, 7] * y0 + C[1, 8] * y3 + C[3, 7] * y1 + C[3, 8] * y3,
    )


@compiled
def corner_loss(
    C: np.ndarray, k: int, sign: float, e1: float, e2: float, diagonal: float, y1: float, y2: float
) -> float:
    """Rates times what they do to membrane and shear stress."""
    e3 = sign * (e1 + e2 - diagonal)
    loss = C[k, 0] * e1 * e1 + C[k, 3] * e2 * e2 + C[k, 5] * e3 * e3
    loss += 2.0 * (C[k, 1] * e1 * e2 + C[k, 2] * e1 * e3 + C[k, 4] * e2 * e3)
    return loss + C[k, 6] * y1 * y1 + 2.0 * C[k, 7] * y1 * y2 + C[k, 8] * y2 * y2


@stage
def loss_with_membrane(loss: float, C: np.ndarray, stretch: Six, shear: Four) -> float:
    """`loss` with that of the rates of stretch and shear, corner by corner."""
    r0, r1, r2, r3, r4, r5 = stretch
    z0, z1, z2, z3 = shear
    loss += corner_loss(C, 0, 0.5, r0, r2, r4, z0, z2)
    loss += corner_loss(C, 1, -0.5, r0, r3, r5, z0, z3)
    loss += corner_loss(C, 2, -0.5, r1, r2, r5, z1, z2)
    loss += corner_loss(C, 3, 0.5, r1, r3, r4, z1, z3)
    return loss
