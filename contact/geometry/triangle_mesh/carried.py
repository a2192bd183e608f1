# SPDX-License-Identifier: LGPL-3.0-or-later
"""Points and impulses near a triangle, carried by it: the motion of its surroundings, its adjoint.

A point x near a triangle of corners v_0, v_1, v_2 and unit normal n keeps its numbers in

    x = v_0 + b_1 (v_1 - v_0) + b_2 (v_2 - v_0) + h n

while the corners move: a rigid motion of the triangle moves x rigidly. An impulse J at x is
work-equivalent to these at the corners, with a = v_1 - v_0, c = v_2 - v_0 and
g = h (J - n n.J) / |a x c|:

    j_1 = b_1 J + c x g,  j_2 = b_2 J + g x a,  j_0 = J - j_1 - j_2.

Sums are exact: j_0 + j_1 + j_2 = J, and the sum of v_i x j_i is x x J.
"""

from typing import Any, NamedTuple

import numpy as np

from contact.kernel import kernel


class Acting(NamedTuple):
    """What acts at vertices: few of them, so these are listed.

    table : (nv, 6), see `contact.body.surface_motion.SHARED`; zero where not listed
    rows : (nv,) int, of which the first number (1,) are those listed; taken : (nv,) bool, whether a
        vertex is
    """

    table: np.ndarray
    rows: np.ndarray
    number: np.ndarray
    taken: np.ndarray


def new_acting(count: int) -> Acting:
    """Nothing, for `count` vertices."""
    table = np.zeros((count, 6))
    return Acting(table, np.zeros(count, np.int64), np.zeros(1, np.int64), np.zeros(count, bool))


@kernel(makes_arrays=False)
def forget_acting(acting: Any) -> None:
    """Nothing acts any more."""
    for m in range(acting.number[0]):
        i = acting.rows[m]
        acting.taken[i] = False
        for c in range(6):
            acting.table[i, c] = 0.0
    acting.number[0] = 0


@kernel(makes_arrays=False)
def _frame(v, corners, t):
    """Edges a and c of triangle t, unit normal, square of twice its area (at least 1e-40)."""
    i, j, k = corners[t, 0], corners[t, 1], corners[t, 2]
    a0, a1, a2 = v[j, 0] - v[i, 0], v[j, 1] - v[i, 1], v[j, 2] - v[i, 2]
    c0, c1, c2 = v[k, 0] - v[i, 0], v[k, 1] - v[i, 1], v[k, 2] - v[i, 2]
    n0, n1, n2 = a1 * c2 - a2 * c1, a2 * c0 - a0 * c2, a0 * c1 - a1 * c0
    square = max(n0 * n0 + n1 * n1 + n2 * n2, 1e-40)
    size = np.sqrt(square)
    return a0, a1, a2, c0, c1, c2, n0 / size, n1 / size, n2 / size, square


@kernel(makes_arrays=False)
def _numbers(a0, a1, a2, c0, c1, c2, n0, n1, n2, square, r0, r1, r2):
    """b_1, b_2 and h [m] of a point r from the first corner of a triangle of this frame."""
    size = np.sqrt(square)
    b1 = n0 * (r1 * c2 - r2 * c1) + n1 * (r2 * c0 - r0 * c2) + n2 * (r0 * c1 - r1 * c0)
    b2 = n0 * (a1 * r2 - a2 * r1) + n1 * (a2 * r0 - a0 * r2) + n2 * (a0 * r1 - a1 * r0)
    return b1 / size, b2 / size, r0 * n0 + r1 * n1 + r2 * n2


@kernel(makes_arrays=False)
def drift(
    before: np.ndarray,
    after: np.ndarray,
    corners: np.ndarray,
    t: int,
    x0: float,
    x1: float,
    x2: float,
) -> tuple[float, float, float]:
    """Way [m] of a point x that triangle t carries from vertices (nv, 3) to others.

    Exactly zero where they are the same.
    """
    a0, a1, a2, c0, c1, c2, n0, n1, n2, square = _frame(before, corners, t)
    e0, e1, e2, f0, f1, f2, m0, m1, m2, _ = _frame(after, corners, t)
    i = corners[t, 0]
    o0, o1, o2 = before[i, 0], before[i, 1], before[i, 2]
    b1, b2, h = _numbers(
        a0, a1, a2, c0, c1, c2, n0, n1, n2, square, x0 - o0, x1 - o1, x2 - o2
    )  # fmt: skip
    u0 = after[i, 0] - o0 + b1 * (e0 - a0) + b2 * (f0 - c0) + h * (m0 - n0)
    u1 = after[i, 1] - o1 + b1 * (e1 - a1) + b2 * (f1 - c1) + h * (m1 - n1)
    u2 = after[i, 2] - o2 + b1 * (e2 - a2) + b2 * (f2 - c2) + h * (m2 - n2)
    return u0, u1, u2


@kernel(makes_arrays=False)
def turned_with(
    before: np.ndarray,
    after: np.ndarray,
    corners: np.ndarray,
    t: int,
    d0: float,
    d1: float,
    d2: float,
) -> tuple[float, float, float]:
    """Unit direction d as triangle t carries it from vertices (nv, 3) to others."""
    a0, a1, a2, c0, c1, c2, n0, n1, n2, square = _frame(before, corners, t)
    e0, e1, e2, f0, f1, f2, m0, m1, m2, _ = _frame(after, corners, t)
    b1, b2, h = _numbers(a0, a1, a2, c0, c1, c2, n0, n1, n2, square, d0, d1, d2)
    o0, o1, o2 = b1 * e0 + b2 * f0 + h * m0, b1 * e1 + b2 * f1 + h * m1, b1 * e2 + b2 * f2 + h * m2
    length = np.sqrt(o0 * o0 + o1 * o1 + o2 * o2)
    return o0 / length, o1 / length, o2 / length


@kernel(makes_arrays=False)
def speed_at(
    v: np.ndarray,
    rates: np.ndarray,
    corners: np.ndarray,
    t: int,
    x0: float,
    x1: float,
    x2: float,
) -> tuple[float, float, float]:
    """Velocity [m/s] of a point x that triangle t carries, its vertices moving at rates (nv, 3).

    `add_impulse` is its adjoint.
    """
    a0, a1, a2, c0, c1, c2, n0, n1, n2, square = _frame(v, corners, t)
    i, j, k = corners[t, 0], corners[t, 1], corners[t, 2]
    b1, b2, h = _numbers(
        a0, a1, a2, c0, c1, c2, n0, n1, n2, square, x0 - v[i, 0], x1 - v[i, 1], x2 - v[i, 2]
    )  # fmt: skip
    r0, r1, r2 = rates[i, 0], rates[i, 1], rates[i, 2]
    d0, d1, d2 = rates[j, 0] - r0, rates[j, 1] - r1, rates[j, 2] - r2
    e0, e1, e2 = rates[k, 0] - r0, rates[k, 1] - r1, rates[k, 2] - r2
    m0 = d1 * c2 - d2 * c1 + a1 * e2 - a2 * e1
    m1 = d2 * c0 - d0 * c2 + a2 * e0 - a0 * e2
    m2 = d0 * c1 - d1 * c0 + a0 * e1 - a1 * e0
    along, scale = m0 * n0 + m1 * n1 + m2 * n2, h / np.sqrt(square)
    return (
        r0 + b1 * d0 + b2 * e0 + scale * (m0 - along * n0),
        r1 + b1 * d1 + b2 * e1 + scale * (m1 - along * n1),
        r2 + b1 * d2 + b2 * e2 + scale * (m2 - along * n2),
    )


@kernel(makes_arrays=False)
def add_impulse(
    v: np.ndarray,
    corners: np.ndarray,
    t: int,
    x0: float,
    x1: float,
    x2: float,
    impulse: np.ndarray,
    done: float,
    rubbed: float,
    pressed: float,
    acting: Any,
) -> None:
    """Add an impulse (3,) [N s] at a point x near triangle t to its corners.

    done, rubbed, pressed : work, friction and impact loss [J], shared out by b; acting : Acting
    """
    at_vertices = acting.table
    a0, a1, a2, c0, c1, c2, n0, n1, n2, square = _frame(v, corners, t)
    i, j, k = corners[t, 0], corners[t, 1], corners[t, 2]
    r0, r1, r2 = x0 - v[i, 0], x1 - v[i, 1], x2 - v[i, 2]
    b1, b2, h = _numbers(a0, a1, a2, c0, c1, c2, n0, n1, n2, square, r0, r1, r2)
    along = impulse[0] * n0 + impulse[1] * n1 + impulse[2] * n2
    scale = h / np.sqrt(square)
    g0 = scale * (impulse[0] - along * n0)
    g1 = scale * (impulse[1] - along * n1)
    g2 = scale * (impulse[2] - along * n2)
    p0 = b1 * impulse[0] + c1 * g2 - c2 * g1
    p1 = b1 * impulse[1] + c2 * g0 - c0 * g2
    p2 = b1 * impulse[2] + c0 * g1 - c1 * g0
    q0 = b2 * impulse[0] + g1 * a2 - g2 * a1
    q1 = b2 * impulse[1] + g2 * a0 - g0 * a2
    q2 = b2 * impulse[2] + g0 * a1 - g1 * a0
    at_vertices[i, 0] += impulse[0] - p0 - q0
    at_vertices[i, 1] += impulse[1] - p1 - q1
    at_vertices[i, 2] += impulse[2] - p2 - q2
    at_vertices[j, 0] += p0
    at_vertices[j, 1] += p1
    at_vertices[j, 2] += p2
    at_vertices[k, 0] += q0
    at_vertices[k, 1] += q1
    at_vertices[k, 2] += q2
    for vertex, share in ((i, 1.0 - b1 - b2), (j, b1), (k, b2)):
        if not acting.taken[vertex]:
            acting.taken[vertex], acting.rows[acting.number[0]] = True, vertex
            acting.number[0] += 1
        at_vertices[vertex, 3] += share * done
        at_vertices[vertex, 4] += share * rubbed
        at_vertices[vertex, 5] += share * pressed
