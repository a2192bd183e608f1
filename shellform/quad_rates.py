# SPDX-License-Identifier: LGPL-3.0-or-later
"""Damping of 4-node quads, LANES cells at a time: rates of strain for quad_lanes.py.

Damped, the stress is that of the strains plus their rates times a time tau, in the present
configuration: it resists every change of strain, whatever stress there is, and no rigid motion. So
tau times the rates, taken off the strains at rest, makes the elastic force the damped one.
"""

import numpy as np

from .lanes import COUNT, LANES, at, compiled, dot, mix, vector
from .quad_lanes import RATES, bend, diagonals, gather, lines, nodes_of, scatter, sides, stretch

LOSS, SHIFTED = 18, 19  # rows of the strains at rest less the rates; the loss comes last


@compiled
def _set(shifted, k, lane, value):
    shifted[np.uint64(k) * COUNT + lane] = value


@compiled
def _length_rate(dx, dd, b, c, vx, vd):
    """Rate of half a squared arc length."""
    both = (dot(vx, dd) + dot(dx, vd)) * (1.0 + 2.0 / 15.0 * c)
    return dot(dx, vx) + b * (both + b * dot(dd, vd) * (2.0 / 15.0)) / 12.0


@compiled
def _turning_rate(b, c, rate_b, rate_c):
    """Rate of b (1 + c/12 + c^2/90)."""
    return rate_b * (1.0 + c / 12.0 + c * c / 90.0) + b * (1.0 / 12.0 + c / 45.0) * rate_c


@compiled
def _product(K, k, lane, e1, e2, e3):
    """e . K e with the upper triangle of K at row k."""
    k11, k12, k13 = vector(K, k, lane)
    k22, k23, k33 = vector(K, k + 3, lane)
    mixed = k12 * e1 * e2 + k13 * e1 * e3 + k23 * e2 * e3
    return k11 * e1 * e1 + k22 * e2 * e2 + k33 * e3 * e3 + 2.0 * mixed


@compiled
def _corner(K, k, lane, sign, e1, e2, diagonal, y1, y2):
    """Twice the energy of the rates at a corner."""
    k11, k12, k22 = vector(K, k + 6, lane)
    shear = k11 * y1 * y1 + 2.0 * k12 * y1 * y2 + k22 * y2 * y2
    return _product(K, k, lane, e1, e2, sign * (e1 + e2 - diagonal)) + shear


@compiled
def _stretch_rates(rows, K, rest, shifted):
    for lane in range(COUNT):
        x, d = nodes_of(rows, 0, lane)
        p, t = nodes_of(rows, RATES, lane)
        X0, X1, X2, X3 = sides(x)
        D0, D1, D2, D3 = sides(d)
        V0, V1, V2, V3 = sides(p)
        W0, W1, W2, W3 = sides(t)
        X4, X5 = diagonals(x)
        D4, D5 = diagonals(d)
        V4, V5 = diagonals(p)
        W4, W5 = diagonals(t)
        e0 = _length_rate(X0, D0, dot(X0, D0), dot(D0, D0), V0, W0)
        e1 = _length_rate(X1, D1, dot(X1, D1), dot(D1, D1), V1, W1)
        e2 = _length_rate(X2, D2, dot(X2, D2), dot(D2, D2), V2, W2)
        e3 = _length_rate(X3, D3, dot(X3, D3), dot(D3, D3), V3, W3)
        e4 = _length_rate(X4, D4, dot(X4, D4), dot(D4, D4), V4, W4)
        e5 = _length_rate(X5, D5, dot(X5, D5), dot(D5, D5), V5, W5)
        y0 = dot(V0, mix(0.5, d[0], 0.5, d[1])) + dot(X0, mix(0.5, t[0], 0.5, t[1]))
        y1 = dot(V1, mix(0.5, d[2], 0.5, d[3])) + dot(X1, mix(0.5, t[2], 0.5, t[3]))
        y2 = dot(V2, mix(0.5, d[0], 0.5, d[2])) + dot(X2, mix(0.5, t[0], 0.5, t[2]))
        y3 = dot(V3, mix(0.5, d[1], 0.5, d[3])) + dot(X3, mix(0.5, t[1], 0.5, t[3]))
        loss = _corner(K, 0, lane, 0.5, e0, e2, e4, y0, y2)
        loss += _corner(K, 15, lane, -0.5, e0, e3, e5, y0, y3)
        loss += _corner(K, 30, lane, -0.5, e1, e2, e5, y1, y2)
        loss += _corner(K, 45, lane, 0.5, e1, e3, e4, y1, y3)
        _set(shifted, LOSS, lane, loss)
        _set(shifted, 0, lane, at(rest, 0, lane) - e0)
        _set(shifted, 1, lane, at(rest, 1, lane) - e1)
        _set(shifted, 2, lane, at(rest, 2, lane) - e2)
        _set(shifted, 3, lane, at(rest, 3, lane) - e3)
        _set(shifted, 4, lane, at(rest, 4, lane) - e4)
        _set(shifted, 5, lane, at(rest, 5, lane) - e5)
        _set(shifted, 6, lane, at(rest, 6, lane) - y0)
        _set(shifted, 7, lane, at(rest, 7, lane) - y1)
        _set(shifted, 8, lane, at(rest, 8, lane) - y2)
        _set(shifted, 9, lane, at(rest, 9, lane) - y3)


@compiled
def _both(g1, h1, g2, h2):
    return dot(g1, h2) + dot(g2, h1)


@compiled
def _twist_rate(b, c, p, r, cross_b, cross_c, cross_p, cross_r):
    """Rate of a quarter of the turning along line 1 + line 2 less that along line 1 - line 2.

    b = g . h, c = h . h and their rates p, r : sums of those of the two lines; cross : what the two
    lines have in common
    """
    plus = _turning_rate(b + cross_b, c + cross_c, p + cross_p, r + cross_r)
    return 0.25 * (plus - _turning_rate(b - cross_b, c - cross_c, p - cross_p, r - cross_r))


@compiled
def _bend_rates(rows, K, rest, shifted):
    for lane in range(COUNT):
        x, d = nodes_of(rows, 0, lane)
        p, t = nodes_of(rows, RATES, lane)
        g0, g1, g2, g3 = lines(sides(x))
        h0, h1, h2, h3 = lines(sides(d))
        v0, v1, v2, v3 = lines(sides(p))
        w0, w1, w2, w3 = lines(sides(t))
        b0, b1, b2, b3 = dot(g0, h0), dot(g1, h1), dot(g2, h2), dot(g3, h3)
        c0, c1, c2, c3 = dot(h0, h0), dot(h1, h1), dot(h2, h2), dot(h3, h3)
        p0, p1 = _both(v0, w0, g0, h0), _both(v1, w1, g1, h1)
        p2, p3 = _both(v2, w2, g2, h2), _both(v3, w3, g3, h3)
        r0, r1, r2, r3 = (
            2.0 * dot(h0, w0), 2.0 * dot(h1, w1), 2.0 * dot(h2, w2), 2.0 * dot(h3, w3)
        )  # fmt: skip
        k0, k1 = _turning_rate(b0, c0, p0, r0), _turning_rate(b1, c1, p1, r1)
        k2, k3 = _turning_rate(b2, c2, p2, r2), _turning_rate(b3, c3, p3, r3)
        b, c = _both(g0, h0, g2, h2), 2.0 * dot(h0, h2)
        q, s = _both(v0, h0, v2, h2) + _both(g0, w0, g2, w2), 2.0 * _both(w0, h0, w2, h2)
        z0 = _twist_rate(b0 + b2, c0 + c2, p0 + p2, r0 + r2, b, c, q, s)
        b, c = _both(g0, h0, g3, h3), 2.0 * dot(h0, h3)
        q, s = _both(v0, h0, v3, h3) + _both(g0, w0, g3, w3), 2.0 * _both(w0, h0, w3, h3)
        z1 = _twist_rate(b0 + b3, c0 + c3, p0 + p3, r0 + r3, b, c, q, s)
        b, c = _both(g1, h1, g2, h2), 2.0 * dot(h1, h2)
        q, s = _both(v1, h1, v2, h2) + _both(g1, w1, g2, w2), 2.0 * _both(w1, h1, w2, h2)
        z2 = _twist_rate(b1 + b2, c1 + c2, p1 + p2, r1 + r2, b, c, q, s)
        b, c = _both(g1, h1, g3, h3), 2.0 * dot(h1, h3)
        q, s = _both(v1, h1, v3, h3) + _both(g1, w1, g3, w3), 2.0 * _both(w1, h1, w3, h3)
        z3 = _twist_rate(b1 + b3, c1 + c3, p1 + p3, r1 + r3, b, c, q, s)
        loss = _product(K, 9, lane, k0, k2, z0) + _product(K, 24, lane, k0, k3, z1)
        loss += _product(K, 39, lane, k1, k2, z2) + _product(K, 54, lane, k1, k3, z3)
        _set(shifted, LOSS, lane, at(shifted, LOSS, lane) + loss)
        _set(shifted, 10, lane, at(rest, 10, lane) - k0)
        _set(shifted, 11, lane, at(rest, 11, lane) - k1)
        _set(shifted, 12, lane, at(rest, 12, lane) - k2)
        _set(shifted, 13, lane, at(rest, 13, lane) - k3)
        _set(shifted, 14, lane, at(rest, 14, lane) - z0)
        _set(shifted, 15, lane, at(rest, 15, lane) - z1)
        _set(shifted, 16, lane, at(rest, 16, lane) - z2)
        _set(shifted, 17, lane, at(rest, 17, lane) - z3)


@compiled
def add_damped_force(w, ahead, points, nodes, stiffness, rest, count, work, shifted, r):
    """Add the internal forces of `count` cells with damping.

    Parameters
    ----------
    ahead : (n, 6), w + tau times its rates; shifted : (SHIFTED LANES,), scratch
    others : see quad_lanes.add_force

    Returns
    -------
    Twice what the rates would store as strains [J]: over tau, the power of damping
    """
    loss = 0.0
    for b in range(len(nodes)):
        width = min(LANES, count - b * LANES)
        gather(w, points, nodes[b], work)
        for lane in range(LANES):
            for i in range(4):
                node = nodes[b, lane, i]
                for k in range(6):
                    work[(RATES + 6 * i + k) * LANES + lane] = ahead[node, k] - w[node, k]
        _stretch_rates(work, stiffness[b], rest[b], shifted)
        _bend_rates(work, stiffness[b], rest[b], shifted)
        stretch(work, stiffness[b], shifted)
        bend(work, stiffness[b], shifted)
        scatter(work, nodes[b], width, r)
        for lane in range(width):
            loss += shifted[LOSS * LANES + lane]
    return loss
