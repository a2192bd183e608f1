# SPDX-License-Identifier: LGPL-3.0-or-later
"""Rows: pairs that can come closer than the thickness in a step, and what velocities they demand.

With r = sum_a w_a x_a the way between the closest points, d = |r|, n = r/d, a row demands

    n . sum_a w_a v_a >= (thickness - d)/dt,

at most `recovery` where it starts closer. Its impulse p n acts along that way: linear and angular
momentum stay what they are. Friction acts across it, at both ends, so that a tangent t alone would
leave the moment r x t. Node a gets, of an impulse f t, not f w_a t but f g_a,

    g_a = w_a t + m_a omega x (x_a - c),   I omega = -r x t,

c being the centre of mass of the four nodes and I their moment of inertia: no moment is left, and
the slip sum_a g_a . v_a of a pair that turns as one is zero.

Pairs of one connected piece that are closer at rest than the thickness keep half of that distance,
those about as close as it 0.99 of it.
"""

from typing import Any

import numpy as np

from contact.kernel import kernel

from .closest_points import closest
from .trust_region import AHEAD

ROW = np.dtype(
    [
        ("key", np.int64),  # see broad_phase.py
        ("nodes", np.int64, 4),
        ("weights", float, 4),
        ("normal", float, 3),
        ("sliding", float, (2, 4, 3)),  # g_a of two tangents
        ("tangents", float, (2, 3)),
        ("distance", float),  # at the start of the step [m]
        ("bound", float),  # least speed apart [m/s]
        ("push", float),  # p, impulse along the normal [N s]
        ("rub", float, 2),  # impulses along the tangents [N s]
        ("mass", float),  # that the normal impulse meets [kg], 0: none of its nodes can move
        ("rub_mass", float),  # the same across it
    ],
    align=True,
)
MARGIN = 0.1  # of the thickness: pairs within it have a row although they do not come closer


@kernel(makes_arrays=False)
def cross(a: np.ndarray, b: np.ndarray, out: np.ndarray) -> None:
    """Fill out (3,) with a x b."""
    out[0] = a[1] * b[2] - a[2] * b[1]
    out[1] = a[2] * b[0] - a[0] * b[2]
    out[2] = a[0] * b[1] - a[1] * b[0]


@kernel
def set_sliding(now: Any, x: np.ndarray, mass: np.ndarray, work: np.ndarray) -> None:
    """Fill the tangents of a row, a record of ROW, and what friction along them gives to its nodes.

    work : (15, 3)
    """
    n, t = now.normal, now.tangents
    least = 0
    for c in range(1, 3):
        if abs(n[c]) < abs(n[least]):
            least = c
    axis, centre, one, two, three = work[0], work[1], work[2], work[3], work[4]
    moment, omega, turned, inertia, arms = work[5], work[6], work[7], work[8:11], work[11:15]
    work[:] = 0.0
    axis[least] = 1.0
    cross(n, axis, t[0])
    size = np.sqrt(t[0, 0] ** 2 + t[0, 1] ** 2 + t[0, 2] ** 2)
    for c in range(3):
        t[0, c] /= size
    cross(n, t[0], t[1])
    total = 0.0
    for a in range(4):
        total += mass[now.nodes[a]]
        for c in range(3):
            centre[c] += mass[now.nodes[a]] * x[now.nodes[a], c]
    centre /= total
    for a in range(4):
        m = mass[now.nodes[a]]
        square = 0.0
        for c in range(3):
            arms[a, c] = x[now.nodes[a], c] - centre[c]
            square += arms[a, c] * arms[a, c]
        for c in range(3):
            inertia[c, c] += m * square
            for e in range(3):
                inertia[c, e] -= m * arms[a, c] * arms[a, e]
    # inverse by cofactors; four nodes of a pair are never on one line
    cross(inertia[1], inertia[2], one)
    cross(inertia[2], inertia[0], two)
    cross(inertia[0], inertia[1], three)
    size = inertia[0, 0] * one[0] + inertia[0, 1] * one[1] + inertia[0, 2] * one[2]
    for k in range(2):
        cross(n, t[k], moment)
        for c in range(3):
            omega[c] = one[c] * moment[0] + two[c] * moment[1] + three[c] * moment[2]
            omega[c] *= -now.distance / size
        for a in range(4):
            cross(omega, arms[a], turned)
            for c in range(3):
                now.sliding[k, a, c] = now.weights[a] * t[k, c] + mass[now.nodes[a]] * turned[c]


@kernel(makes_arrays=False)
def fastest(v: np.ndarray, nodes: np.ndarray) -> float:
    """Greatest speed of any of the nodes (4,) relative to the first; v (n, 3)."""
    speed = 0.0
    for a in range(1, 4):
        square = 0.0
        for c in range(3):
            square += (v[nodes[a], c] - v[nodes[0], c]) ** 2
        speed = max(speed, square)
    return np.sqrt(speed)


@kernel
def find_rows(
    x: np.ndarray,
    rest: np.ndarray,
    v: np.ndarray,
    piece: np.ndarray,
    places: np.ndarray,
    triangles: np.ndarray,
    edges: np.ndarray,
    sides: np.ndarray,
    owns: np.ndarray,
    keys: np.ndarray,
    due: np.ndarray,
    groups: np.ndarray,
    near: np.ndarray,
    path: np.ndarray,
    step: np.ndarray,
    thickness: float,
    recovery: float,
    dt: float,
    mass: np.ndarray,
    old: np.ndarray,
    rows: np.ndarray,
) -> tuple[int, float, float]:
    """Fill rows (k,) ROW, in the order of the keys.

    x, rest : (n, 3), positions now and at rest [m]; v : (n, 3), velocities of the last step [m/s]
    piece to owns : see Features
    keys, due : (pairs,), listed pairs, and the path at which each has to be looked at; the latter
        is changed; groups : (pairs,) int, whose path; near : numbers of those to go through
    path, step : (groups,), what pairs have come closer at most until now, and in this step [m]
    mass : (n,) [kg]; old : (l,) ROW of the step before, whose impulses are taken over

    Returns how many there are, more than k where they do not fit, and by how much paths may grow
    before one of those near needs a look, and the least distance of a row
    """
    nodes, w, r, work = np.empty(4, np.int64), np.empty(4), np.empty(3), np.empty((15, 3))
    w_rest, r_rest = np.empty(4), np.empty(3)
    corners, found, at, least, closest_row = len(x) * len(triangles), 0, 0, np.inf, np.inf
    reach = thickness * (1.0 + MARGIN)
    for k in near:
        now = path[groups[k]]
        if now + step[groups[k]] < due[k]:
            least = min(least, due[k] - now)
            continue
        key = keys[k]
        d, keeps = closest(x, key, corners, triangles, edges, sides, owns, places, nodes, w, r)
        due[k] = now + d - reach
        least = min(least, d - reach)
        if not keeps or d - reach >= step[groups[k]] or d == 0.0:
            continue
        own = AHEAD * dt * fastest(v, nodes)
        if d - reach >= own:
            continue
        gap = thickness
        if piece[nodes[0]] == piece[nodes[3]]:
            first, _ = closest(
                rest, key, corners, triangles, edges, sides, owns, places, nodes, w_rest, r_rest
            )
            if first < 0.99 * thickness:
                gap = 0.5 * first
            elif first < 1.01 * thickness:
                gap = 0.99 * thickness
            if d - gap - MARGIN * thickness >= own:
                continue
        if found < len(rows):
            row = rows[found]
            row.key, row.distance = key, d
            closest_row = min(closest_row, d)
            for a in range(4):
                row.nodes[a], row.weights[a] = nodes[a], w[a]
            for c in range(3):
                row.normal[c] = r[c] / d
            row.bound = min((gap - d) / dt, recovery)
            set_sliding(row, x, mass, work)
            row.push, row.rub[0], row.rub[1] = 0.0, 0.0, 0.0
            while at < len(old) and old[at].key < key:
                at += 1
            if at < len(old) and old[at].key == key:
                before = old[at]
                row.push = before.push
                for i in range(2):
                    for c in range(3):
                        impulse = before.rub[0] * before.tangents[0, c]
                        impulse += before.rub[1] * before.tangents[1, c]
                        row.rub[i] += impulse * row.tangents[i, c]
        found += 1
    return found, least, closest_row
