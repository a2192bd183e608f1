# SPDX-License-Identifier: LGPL-3.0-or-later
"""What the force of a 4-node quad is put together from: segments, corners, lines, twists: Eq. 14.

Vectors are tuples of three numbers, so that compiled code keeps them in registers: arrays would
make it twice as slow. Symbols, at a segment or a line of the cell: X = difference of positions,
D = difference of directors, b = X . D, c = D . D.
"""

import numpy as np

from contact.kernel import kernel

Vector = tuple[float, float, float]

# not finite stays not finite: no assumption that NaN or infinity do not occur
compiled = kernel(fastmath={"contract", "reassoc", "nsz", "arcp"})


@compiled
def dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@compiled
def add(a: Vector, b: Vector) -> Vector:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@compiled
def sub(a: Vector, b: Vector) -> Vector:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@compiled
def mix(s: float, a: Vector, t: float, b: Vector) -> Vector:
    """s a + t b."""
    return s * a[0] + t * b[0], s * a[1] + t * b[1], s * a[2] + t * b[2]


@compiled
def plus(a: Vector, s: float, b: Vector) -> Vector:
    """a + s b."""
    return a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]


@compiled
def row(a: np.ndarray, i: int, k: int) -> Vector:
    """Numbers k, k + 1, k + 2 of row i."""
    return a[i, k], a[i, k + 1], a[i, k + 2]


@compiled
def add_to(r: np.ndarray, i: int, k: int, a: Vector) -> None:
    """Add a to numbers k, k + 1, k + 2 of row i."""
    r[i, k] += a[0]
    r[i, k + 1] += a[1]
    r[i, k + 2] += a[2]


# ---------------------------------------------------------------- stretch and shear of segments


@compiled
def half_length_squared(X: Vector, b: float, c: float) -> float:
    """Of the arc: |X|^2/2 + b^2 (1 + 2/15 c)/24."""
    return 0.5 * dot(X, X) + b * b * (1.0 + 2.0 / 15.0 * c) / 24.0


@compiled
def length_rate(X: Vector, D: Vector, b: float, c: float, vX: Vector, vD: Vector) -> float:
    """Rate of `half_length_squared`, from those of X and D."""
    change = dot(vX, D) + dot(X, vD)
    bend = b * dot(D, vD) * (2.0 / 15.0)
    return dot(X, vX) + b * (change * (1.0 + 2.0 / 15.0 * c) + bend) / 12.0


@compiled
def shear_rate(X: Vector, vX: Vector, middle: Vector, turn_i: Vector, turn_j: Vector) -> float:
    """Rate of X . middle, middle the mean of two directors that turn."""
    return dot(vX, middle) + 0.5 * (dot(X, turn_i) + dot(X, turn_j))


@compiled
def corner(C: np.ndarray, k: int, sign: float, e1: float, e2: float, diagonal: float) -> Vector:
    """Pulls on the two sides and the diagonal of corner k; the engineering shear strain of a corner
    is that of its sides and the diagonal across it."""
    e3 = sign * (e1 + e2 - diagonal)
    n3 = sign * (C[k, 2] * e1 + C[k, 4] * e2 + C[k, 5] * e3)
    n1 = C[k, 0] * e1 + C[k, 1] * e2 + C[k, 2] * e3
    n2 = C[k, 1] * e1 + C[k, 3] * e2 + C[k, 4] * e3
    return n1 + n3, n2 + n3, n3


@compiled
def corner_loss(
    C: np.ndarray, k: int, sign: float, e1: float, e2: float, diagonal: float, y1: float, y2: float
) -> float:
    """Rates times what they do to membrane and shear stress."""
    e3 = sign * (e1 + e2 - diagonal)
    loss = C[k, 0] * e1 * e1 + C[k, 3] * e2 * e2 + C[k, 5] * e3 * e3
    loss += 2.0 * (C[k, 1] * e1 * e2 + C[k, 2] * e1 * e3 + C[k, 4] * e2 * e3)
    return loss + C[k, 6] * y1 * y1 + 2.0 * C[k, 7] * y1 * y2 + C[k, 8] * y2 * y2


@compiled
def segment(pull: float, X: Vector, D: Vector, b: float, c: float) -> tuple[Vector, Vector]:
    """Force and couple, work-conjugate to X and D, of a pull along the arc."""
    along = pull * b * (1.0 + 2.0 / 15.0 * c) / 12.0
    across = pull * b * b / 90.0
    return mix(pull, X, along, D), mix(along, X, across, D)


# ---------------------------------------------------------------- curvature of lines, twist


@compiled
def turning(b: float, c: float) -> float:
    """Curvature that the angle between two directors tells, of b = g . h and c = h . h."""
    return b * (1.0 + c / 12.0 + c * c / 90.0)


@compiled
def turning_rate(b: float, c: float, rate_b: float, rate_c: float) -> float:
    return rate_b * (1.0 + c / 12.0 + c * c / 90.0) + b * (1.0 / 12.0 + c / 45.0) * rate_c


@compiled
def line_rate(g: Vector, h: Vector, b: float, c: float, vg: Vector, vh: Vector) -> Vector:
    """Rates of b, of c and of `turning` on a line."""
    vb, vc = dot(vg, h) + dot(g, vh), 2.0 * dot(h, vh)
    return vb, vc, turning_rate(b, c, vb, vc)


@compiled
def diagonals(
    g: Vector, h: Vector, b: float, c: float, G: Vector, H: Vector, B: float, C: float
) -> tuple[float, float, float, float]:
    """b and c along g + G and along g - G, for two crossing lines."""
    cross_b = dot(g, H) + dot(G, h)
    cross_c = 2.0 * dot(h, H)
    return b + B + cross_b, b + B - cross_b, c + C + cross_c, c + C - cross_c


@compiled
def twist_rate(
    g: Vector,
    h: Vector,
    vg: Vector,
    vh: Vector,
    vb: float,
    vc: float,
    G: Vector,
    H: Vector,
    vG: Vector,
    vH: Vector,
    vB: float,
    vC: float,
    pb: float,
    mb: float,
    pc: float,
    mc: float,
) -> float:
    """Rate of the twist between two crossing lines; pb, mb, pc, mc: their `diagonals`."""
    rate_b = dot(vg, H) + dot(vG, h) + dot(g, vH) + dot(G, vh)
    rate_c = 2.0 * (dot(vh, H) + dot(h, vH))
    more = turning_rate(pb, pc, vb + vB + rate_b, vc + vC + rate_c)
    less = turning_rate(mb, mc, vb + vB - rate_b, vc + vC - rate_c)
    return 0.25 * (more - less)


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


@compiled
def twisted(
    moment: float,
    g: Vector,
    h: Vector,
    G: Vector,
    H: Vector,
    pb: float,
    mb: float,
    pc: float,
    mc: float,
) -> tuple[Vector, Vector, Vector, Vector]:
    """Forces conjugate to g, G and couples conjugate to h, H of a twisting moment."""
    moment = 0.25 * moment
    p = moment * (1.0 + pc / 12.0 + pc * pc / 90.0)
    m = moment * (1.0 + mc / 12.0 + mc * mc / 90.0)
    pd = moment * pb * (1.0 / 6.0 + pc * (2.0 / 45.0))
    md = moment * mb * (1.0 / 6.0 + mc * (2.0 / 45.0))
    hp, hm = add(h, H), sub(h, H)
    plus_f, minus_f = mix(p, hp, 0.0, hp), mix(m, hm, 0.0, hm)
    plus_c, minus_c = mix(p, add(g, G), pd, hp), mix(m, sub(g, G), md, hm)
    return sub(plus_f, minus_f), add(plus_f, minus_f), sub(plus_c, minus_c), add(plus_c, minus_c)


@compiled
def bent(
    moment: float, g: Vector, h: Vector, b: float, c: float, force: Vector, couple: Vector
) -> tuple[Vector, Vector]:
    """Force and couple with those of a bending moment on a line added."""
    s = moment * (1.0 + c / 12.0 + c * c / 90.0)
    t = moment * b * (1.0 / 6.0 + c * (2.0 / 45.0))
    return plus(force, s, h), add(couple, mix(s, g, t, h))
