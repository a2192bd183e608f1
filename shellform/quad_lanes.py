# SPDX-License-Identifier: LGPL-3.0-or-later
"""The forces of quad_force.py for LANES cells at a time: Eq. 14 in the vector units.

Cells go in batches, all numbers of a batch in rows of LANES, see lanes.py.

What a batch needs is written to `work`, rows of LANES numbers: 0 to 23 position and director of
nodes 0 to 3, in turn; 24 to 47 the forces on them; with damping (quad_rates.py) 48 to 71 what the
rates add to position and director. Segments, lines and corners are numbered as in quad_force.py;
g, h are x,1 or x,2 and d,1 or d,2 along a line.
"""

import numpy as np

from .element import GAUSS2
from .lanes import COUNT, LANES, at, compiled, dot, less, mix, mix3, plus, put, vector

ROWS, FORCES, RATES = 72, 24, 48
NEAR, FAR = 1.0 - float(GAUSS2[0][0]), float(GAUSS2[0][0])


def batches(cells, stiffness, rest):
    """Cells (m, 4) and what quad_force.baked gave in batches, the last one filled up.

    Returns
    -------
    nodes (b, LANES, 4) int, stiffness (b, 60 LANES), rest (b, 18 LANES), number of cells m
    """
    m = len(cells)
    b = -(-m // LANES)
    parts = []
    for part in (cells, stiffness.reshape(m, 60), rest):
        whole = np.zeros((b * LANES, part.shape[1]), part.dtype)
        whole[:m], whole[m:] = part, part[:1]
        parts.append(whole.reshape(b, LANES, -1))
    nodes, stiffness, rest = parts
    return (
        nodes.astype(np.int64),
        np.ascontiguousarray(stiffness.transpose(0, 2, 1)).reshape(b, -1),
        np.ascontiguousarray(rest.transpose(0, 2, 1)).reshape(b, -1),
        m,
    )


@compiled
def nodes_of(rows, k, lane):
    """Positions and directors of the four nodes, or their rates."""
    x = vector(rows, k, lane), vector(rows, k + 6, lane), vector(rows, k + 12, lane)
    d = vector(rows, k + 3, lane), vector(rows, k + 9, lane), vector(rows, k + 15, lane)
    return (*x, vector(rows, k + 18, lane)), (*d, vector(rows, k + 21, lane))


@compiled
def sides(x):
    return less(x[1], x[0]), less(x[3], x[2]), less(x[2], x[0]), less(x[3], x[1])


@compiled
def diagonals(x):
    return less(x[1], x[2]), less(x[3], x[0])


@compiled
def lines(s):
    """Along axis 1 near sides 0 and 1, along axis 2 near sides 2 and 3; its own transpose."""
    near, far = mix(NEAR, s[0], FAR, s[1]), mix(FAR, s[0], NEAR, s[1])
    return near, far, mix(NEAR, s[2], FAR, s[3]), mix(FAR, s[2], NEAR, s[3])


@compiled
def half_length_squared(dx, b, c):
    return 0.5 * dot(dx, dx) + b * b * (1.0 + 2.0 / 15.0 * c) / 24.0


@compiled
def turning(b, c):
    return b * (1.0 + c * (1.0 / 12.0 + c / 90.0))


@compiled
def turning_slope(b, c):
    """Twice the derivative of `turning` by c."""
    return b * (1.0 / 6.0 + c * (2.0 / 45.0))


@compiled
def corner(K, k, lane, sign, e1, e2, diagonal):
    """Pulls of a corner on its two sides and, reversed, on its diagonal."""
    e3 = sign * (e1 + e2 - diagonal)
    k11, k12, k13 = vector(K, k, lane)
    k22, k23, k33 = vector(K, k + 3, lane)
    n = sign * (k13 * e1 + k23 * e2 + k33 * e3)
    return k11 * e1 + k12 * e2 + k13 * e3 + n, k12 * e1 + k22 * e2 + k23 * e3 + n, n


@compiled
def shear(K, k, lane, one, two):
    k11, k12, k22 = vector(K, k + 6, lane)
    return k11 * one + k12 * two, k12 * one + k22 * two


@compiled
def segment(pull, b, c, dx, dd):
    """Forces along a segment that work on dx and on dd."""
    along = pull * b * (1.0 + 2.0 / 15.0 * c) / 12.0
    return mix(pull, dx, along, dd), mix(along, dx, pull * b * b / 90.0, dd)


@compiled
def share(rows, k, lane, F0, F1, F2, F3):
    """Add the forces along the sides to the nodes at their ends."""
    put(rows, k, lane, less(vector(rows, k, lane), plus(F0, F2)))
    put(rows, k + 6, lane, plus(vector(rows, k + 6, lane), less(F0, F3)))
    put(rows, k + 12, lane, plus(vector(rows, k + 12, lane), less(F2, F1)))
    put(rows, k + 18, lane, plus(vector(rows, k + 18, lane), plus(F1, F3)))


@compiled
def stretch(rows, K, rest):
    """Forces of membrane and shear of a batch, the first to be written."""
    for lane in range(COUNT):
        x, d = nodes_of(rows, 0, lane)
        X0, X1, X2, X3 = sides(x)
        D0, D1, D2, D3 = sides(d)
        X4, X5 = diagonals(x)
        D4, D5 = diagonals(d)
        b0, b1, b2, b3 = dot(X0, D0), dot(X1, D1), dot(X2, D2), dot(X3, D3)
        c0, c1, c2, c3 = dot(D0, D0), dot(D1, D1), dot(D2, D2), dot(D3, D3)
        b4, b5, c4, c5 = dot(X4, D4), dot(X5, D5), dot(D4, D4), dot(D5, D5)
        e0 = half_length_squared(X0, b0, c0) - at(rest, 0, lane)
        e1 = half_length_squared(X1, b1, c1) - at(rest, 1, lane)
        e2 = half_length_squared(X2, b2, c2) - at(rest, 2, lane)
        e3 = half_length_squared(X3, b3, c3) - at(rest, 3, lane)
        e4 = half_length_squared(X4, b4, c4) - at(rest, 4, lane)
        e5 = half_length_squared(X5, b5, c5) - at(rest, 5, lane)
        m0, m1 = mix(0.5, d[0], 0.5, d[1]), mix(0.5, d[2], 0.5, d[3])
        m2, m3 = mix(0.5, d[0], 0.5, d[2]), mix(0.5, d[1], 0.5, d[3])
        y0, y1 = dot(X0, m0) - at(rest, 6, lane), dot(X1, m1) - at(rest, 7, lane)
        y2, y3 = dot(X2, m2) - at(rest, 8, lane), dot(X3, m3) - at(rest, 9, lane)
        # corners: pulls p of the segments, shear forces t of the sides
        p0, p2, n0 = corner(K, 0, lane, 0.5, e0, e2, e4)
        q0, p3, n1 = corner(K, 15, lane, -0.5, e0, e3, e5)
        p1, q2, n2 = corner(K, 30, lane, -0.5, e1, e2, e5)
        q1, q3, n3 = corner(K, 45, lane, 0.5, e1, e3, e4)
        s0, s2 = shear(K, 0, lane, y0, y2)
        t0, s3 = shear(K, 15, lane, y0, y3)
        s1, t2 = shear(K, 30, lane, y1, y2)
        t1, t3 = shear(K, 45, lane, y1, y3)
        t0, t1, t2, t3 = s0 + t0, s1 + t1, s2 + t2, s3 + t3
        F0, G0 = segment(p0 + q0, b0, c0, X0, D0)
        F1, G1 = segment(p1 + q1, b1, c1, X1, D1)
        F2, G2 = segment(p2 + q2, b2, c2, X2, D2)
        F3, G3 = segment(p3 + q3, b3, c3, X3, D3)
        F4, G4 = segment(-n0 - n3, b4, c4, X4, D4)
        F5, G5 = segment(-n1 - n2, b5, c5, X5, D5)
        # diagonals, and shear, which turns both directors of a side
        put(rows, FORCES, lane, mix(-1.0, F5, 0.0, F5))
        put(rows, FORCES + 6, lane, F4)
        put(rows, FORCES + 12, lane, mix(-1.0, F4, 0.0, F4))
        put(rows, FORCES + 18, lane, F5)
        t0, t1, t2, t3 = 0.5 * t0, 0.5 * t1, 0.5 * t2, 0.5 * t3
        put(rows, FORCES + 3, lane, mix3(t0, X0, t2, X2, -1.0, G5))
        put(rows, FORCES + 9, lane, mix3(t0, X0, t3, X3, 1.0, G4))
        put(rows, FORCES + 15, lane, mix3(t1, X1, t2, X2, -1.0, G4))
        put(rows, FORCES + 21, lane, mix3(t1, X1, t3, X3, 1.0, G5))
        F0, F1 = mix(1.0, F0, 2.0 * t0, m0), mix(1.0, F1, 2.0 * t1, m1)
        F2, F3 = mix(1.0, F2, 2.0 * t2, m2), mix(1.0, F3, 2.0 * t3, m3)
        share(rows, FORCES, lane, F0, F1, F2, F3)
        share(rows, FORCES + 3, lane, G0, G1, G2, G3)


@compiled
def gauss(K, k, lane, rest, b1, c1, k1, g1, h1, b2, c2, k2, g2, h2):
    """A Gauss point: moments on its two lines, and what its twist couples.

    Twist is (turning along x,1 + x,2 less that along x,1 - x,2)/4. Returned besides the moments:
    factors of h or g of the line itself and of the other line, then the same of slopes.
    """
    b, c = dot(g1, h2) + dot(g2, h1), 2.0 * dot(h1, h2)
    plus_b, minus_b, plus_c, minus_c = b1 + b2 + b, b1 + b2 - b, c1 + c2 + c, c1 + c2 - c
    k3 = 0.25 * (turning(plus_b, plus_c) - turning(minus_b, minus_c)) - rest
    k11, k12, k13 = vector(K, k, lane)
    k22, k23, k33 = vector(K, k + 3, lane)
    m = 0.25 * (k13 * k1 + k23 * k2 + k33 * k3)
    plus, minus = turning(m, plus_c), turning(m, minus_c)
    up, down = m * turning_slope(plus_b, plus_c), m * turning_slope(minus_b, minus_c)
    one, two = k11 * k1 + k12 * k2 + k13 * k3, k12 * k1 + k22 * k2 + k23 * k3
    return one, two, plus - minus, plus + minus, up - down, up + down


@compiled
def bend(rows, K, rest):
    """Add the forces of bending of a batch."""
    for lane in range(COUNT):
        x, d = nodes_of(rows, 0, lane)
        g0, g1, g2, g3 = lines(sides(x))
        h0, h1, h2, h3 = lines(sides(d))
        b0, b1, b2, b3 = dot(g0, h0), dot(g1, h1), dot(g2, h2), dot(g3, h3)
        c0, c1, c2, c3 = dot(h0, h0), dot(h1, h1), dot(h2, h2), dot(h3, h3)
        k0, k1 = turning(b0, c0) - at(rest, 10, lane), turning(b1, c1) - at(rest, 11, lane)
        k2, k3 = turning(b2, c2) - at(rest, 12, lane), turning(b3, c3) - at(rest, 13, lane)
        r0, r1, r2, r3 = (
            at(rest, 14, lane), at(rest, 15, lane), at(rest, 16, lane), at(rest, 17, lane)
        )  # fmt: skip
        m0, m2, A, O02, B, P02 = gauss(K, 9, lane, r0, b0, c0, k0, g0, h0, b2, c2, k2, g2, h2)
        n0, m3, C, O03, D, P03 = gauss(K, 24, lane, r1, b0, c0, k0, g0, h0, b3, c3, k3, g3, h3)
        m1, n2, E, O12, F, P12 = gauss(K, 39, lane, r2, b1, c1, k1, g1, h1, b2, c2, k2, g2, h2)
        n1, n3, G, O13, H, P13 = gauss(K, 54, lane, r3, b1, c1, k1, g1, h1, b3, c3, k3, g3, h3)
        m0, m1, m2, m3 = m0 + n0, m1 + n1, m2 + n2, m3 + n3
        a0, a1 = turning(m0, c0) + A + C, turning(m1, c1) + E + G
        a2, a3 = turning(m2, c2) + A + E, turning(m3, c3) + C + G
        e0, e1 = m0 * turning_slope(b0, c0) + B + D, m1 * turning_slope(b1, c1) + F + H
        e2, e3 = m2 * turning_slope(b2, c2) + B + F, m3 * turning_slope(b3, c3) + D + H
        f0, f1 = mix3(a0, h0, O02, h2, O03, h3), mix3(a1, h1, O12, h2, O13, h3)
        f2, f3 = mix3(a2, h2, O02, h0, O12, h1), mix3(a3, h3, O03, h0, O13, h1)
        q0 = plus(mix3(a0, g0, O02, g2, O03, g3), mix3(e0, h0, P02, h2, P03, h3))
        q1 = plus(mix3(a1, g1, O12, g2, O13, g3), mix3(e1, h1, P12, h2, P13, h3))
        q2 = plus(mix3(a2, g2, O02, g0, O12, g1), mix3(e2, h2, P02, h0, P12, h1))
        q3 = plus(mix3(a3, g3, O03, g0, O13, g1), mix3(e3, h3, P03, h0, P13, h1))
        F0, F1, F2, F3 = lines((f0, f1, f2, f3))
        share(rows, FORCES, lane, F0, F1, F2, F3)
        F0, F1, F2, F3 = lines((q0, q1, q2, q3))
        share(rows, FORCES + 3, lane, F0, F1, F2, F3)


@compiled
def gather(w, points, nodes, work):
    for lane in range(LANES):
        for i in range(4):
            node = nodes[lane, i]
            for k in range(3):
                work[(6 * i + k) * LANES + lane] = points[node, k] + w[node, k]
                work[(6 * i + 3 + k) * LANES + lane] = w[node, 3 + k]


@compiled
def scatter(work, nodes, width, r):
    for lane in range(width):
        for i in range(4):
            node = nodes[lane, i]
            for k in range(6):
                r[node, k] += work[(FORCES + 6 * i + k) * LANES + lane]


@compiled
def add_force(w, points, nodes, stiffness, rest, count, work, r):
    """Add the internal forces of `count` cells.

    Parameters
    ----------
    w : (n, 6), (u, d); points : (n, 3), reference positions
    nodes, stiffness, rest, count : see `batches`; work : (ROWS LANES,), scratch
    r : (n, 6), added to [N, N m]
    """
    for b in range(len(nodes)):
        gather(w, points, nodes[b], work)
        stretch(work, stiffness[b], rest[b])
        bend(work, stiffness[b], rest[b])
        scatter(work, nodes[b], min(LANES, count - b * LANES), r)
