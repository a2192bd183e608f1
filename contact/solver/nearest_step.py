# SPDX-License-Identifier: LGPL-3.0-or-later
"""Nearest point of a wedge: a step bounded by the supporting planes of several ellipsoids.

A point that would make the step `free` may only make steps with n_k . step >= bound_k. The nearest
admissible step is free + sum push_k n_k with push >= 0: push, times mass over dt, is the impulse
of every body on the point. This is the non-negative least-squares split of the reaction on an
intersection curve (two planes) or corner (three planes; more are never needed in space), and a
plane that says the same as another gets nothing. The step is a contraction of `free`, so it goes
from one plane over the edge to the next without a jump.

All combinations of one, two, three planes are tried: there are rarely more than three planes.
"""

import numpy as np
from numba import njit

PINCHED = -1
# a wedge so narrow that the way out is this many times the overlap holds the point instead
EJECTION = 10.0
ACCEPTED = 1e-6  # leftover over overlap; between distinct bodies it is 1e-15 or of order one


@njit(cache=True, error_model="numpy")
def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(cache=True, error_model="numpy")
def _overlap(step, planes, count, i, j, k):
    """Greatest overlap with any plane other than i, j, k."""
    worst = 0.0
    for other in range(count):
        if other != i and other != j and other != k:
            worst = max(worst, planes[other].bound - _dot(planes[other].normal, step))
    return worst


@njit(cache=True, error_model="numpy")
def nearest_step(free, planes, count, first, slack, step):
    """Nearest admissible step.

    Parameters
    ----------
    free : (3,) float, the step without contact [m]
    planes : (m,) PLANE, the first `count` in use; `push` is filled: the part of the correction
        along every normal [m]
    first : int, plane to be tried first (it wins a tie), or -1
    slack : float, roundoff of the bounds [m]
    step : (3,) float, filled [m]

    Returns
    -------
    Number of planes that push; PINCHED when no step is admissible or only one that ejects the
    point. Then the plane `first`, or without it the one with the deepest overlap, pushes alone.
    """
    deepest, need = -1, 0.0
    for k in range(count):
        planes[k].push = 0.0
        overlap = planes[k].bound - _dot(planes[k].normal, free)
        if overlap > need:
            deepest, need = k, overlap
    step[:] = free
    if deepest < 0:
        return 0
    best = np.inf
    bi, bj, bk = -1, -1, -1
    li, lj, lk = 0.0, 0.0, 0.0

    for turn in range(-1, count):
        i = first if turn < 0 else turn
        if i < 0 or (turn >= 0 and i == first):
            continue
        a = planes[i].bound - _dot(planes[i].normal, free)
        if a <= 0.0:
            continue
        for m in range(3):
            step[m] = free[m] + a * planes[i].normal[m]
        left = _overlap(step, planes, count, i, i, i)
        if left < best:
            best, bi, bj, bk, li, lj, lk = left, i, -1, -1, a, 0.0, 0.0
        if best <= slack:
            break

    if best > slack:
        for i in range(count):
            for j in range(i + 1, count):
                p, q = planes[i].normal, planes[j].normal
                across = _cross(p, q)
                det = _dot(across, across)
                if det < 1e-20:
                    continue
                cosine = _dot(p, q)
                gi, gj = planes[i].bound - _dot(p, free), planes[j].bound - _dot(q, free)
                a, b = (gi - cosine * gj) / det, (gj - cosine * gi) / det
                left = max(-a, -b)
                a, b = max(a, 0.0), max(b, 0.0)
                for m in range(3):
                    step[m] = free[m] + a * p[m] + b * q[m]
                left = max(left, _overlap(step, planes, count, i, j, j))
                if left < best:
                    best, bi, bj, bk, li, lj, lk = left, i, j, -1, a, b, 0.0

    if best > slack:
        for i in range(count):
            for j in range(i + 1, count):
                for k in range(j + 1, count):
                    jk = _cross(planes[j].normal, planes[k].normal)
                    ki = _cross(planes[k].normal, planes[i].normal)
                    ij = _cross(planes[i].normal, planes[j].normal)
                    det = _dot(planes[i].normal, jk)
                    if abs(det) < 1e-10:
                        continue
                    gi = (planes[i].bound - _dot(planes[i].normal, free)) / det
                    gj = (planes[j].bound - _dot(planes[j].normal, free)) / det
                    gk = (planes[k].bound - _dot(planes[k].normal, free)) / det
                    for m in range(3):
                        step[m] = gi * jk[m] + gj * ki[m] + gk * ij[m]
                    a, b, c = _dot(jk, step) / det, _dot(ki, step) / det, _dot(ij, step) / det
                    for m in range(3):
                        step[m] += free[m]
                    left = max(-a, -b, -c)
                    left = max(left, _overlap(step, planes, count, i, j, k))
                    if left < best:
                        best, bi, bj, bk = left, i, j, k
                        li, lj, lk = max(a, 0.0), max(b, 0.0), max(c, 0.0)

    pushing, length2 = 0, 0.0
    if best <= max(slack, ACCEPTED * need):
        for m in range(3):
            away = li * planes[bi].normal[m]
            if bj >= 0:
                away += lj * planes[bj].normal[m]
            if bk >= 0:
                away += lk * planes[bk].normal[m]
            step[m] = free[m] + away
            length2 += away * away
        if length2 <= (EJECTION * need) ** 2:
            planes[bi].push = li
            pushing = 1
            if bj >= 0:
                planes[bj].push = lj
                pushing += 1
            if bk >= 0:
                planes[bk].push = lk
                pushing += 1
            return pushing
    hold = first if first >= 0 else deepest
    planes[hold].push = max(0.0, planes[hold].bound - _dot(planes[hold].normal, free))
    for m in range(3):
        step[m] = free[m] + planes[hold].push * planes[hold].normal[m]
    return PINCHED


@njit(cache=True, error_model="numpy")
def _cross(a, b):
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )
