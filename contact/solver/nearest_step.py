# SPDX-License-Identifier: LGPL-3.0-or-later
"""Nearest admissible step: one bounded by the supporting planes of several segments.

A node that would make the step `free` may only make steps with n_k . step >= bound_k. The nearest
of them is free + sum push_k n_k with push >= 0: push, times mass over dt, is the impulse of every
segment on the node. This is the non-negative least-squares split of the reaction on an intersection
curve (two planes) or corner (three planes; more are never needed in space), and a plane that says
the same as another gets nothing. The step is a contraction of `free`, so it goes from one plane
over the edge to the next without a jump.

All combinations of one, two, three planes are tried: there are rarely more than three planes.
"""

import numpy as np

from contact.kernel import kernel

PINCHED = -1
# an opening so narrow that the way out is this many times the overlap holds the node instead
EJECTION = 10.0
ACCEPTED = 1e-6  # violation over overlap; between distinct bodies it is 1e-15 or of order one


@kernel(makes_arrays=False)
def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel(makes_arrays=False)
def _cross(a, b):
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


@kernel(makes_arrays=False)
def _violation(step, planes, count, i, j, k):
    """Greatest overlap with any plane other than i, j, k."""
    worst = 0.0
    for other in range(count):
        if other != i and other != j and other != k:
            worst = max(worst, planes[other].bound - _dot(planes[other].normal, step))
    return worst


@kernel(makes_arrays=False)
def _deepest(free, planes, count):
    """Plane with the greatest overlap, -1 without any, and that overlap; pushes are set to zero."""
    deepest, overlap = -1, 0.0
    for k in range(count):
        planes[k].push = 0.0
        own = planes[k].bound - _dot(planes[k].normal, free)
        if own > overlap:
            deepest, overlap = k, own
    return deepest, overlap


# A candidate: violation of the other planes, up to three planes (-1: none) and their pushes. The
# functions below return the better one of what they are given and what they find; `step` is work.


@kernel(makes_arrays=False)
def _onto_one(free, planes, count, first, slack, step, best):
    """On one plane, `first` before the others."""
    for turn in range(-1, count):
        i = first if turn < 0 else turn
        if i < 0 or (turn >= 0 and i == first):
            continue
        a = planes[i].bound - _dot(planes[i].normal, free)
        if a <= 0.0:
            continue
        for m in range(3):
            step[m] = free[m] + a * planes[i].normal[m]
        violation = _violation(step, planes, count, i, i, i)
        if violation < best[0]:
            best = violation, i, -1, -1, a, 0.0, 0.0
        if best[0] <= slack:
            break
    return best


@kernel(makes_arrays=False)
def _onto_two(free, planes, count, step, best):
    """On the line where two planes meet."""
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
            violation = max(-a, -b)
            a, b = max(a, 0.0), max(b, 0.0)
            for m in range(3):
                step[m] = free[m] + a * p[m] + b * q[m]
            violation = max(violation, _violation(step, planes, count, i, j, j))
            if violation < best[0]:
                best = violation, i, j, -1, a, b, 0.0
    return best


@kernel(makes_arrays=False)
def _onto_three(free, planes, count, step, best):
    """In the corner of three planes."""
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
                violation = max(-a, -b, -c)
                violation = max(violation, _violation(step, planes, count, i, j, k))
                if violation < best[0]:
                    best = violation, i, j, k, max(a, 0.0), max(b, 0.0), max(c, 0.0)
    return best


@kernel(makes_arrays=False)
def _pushed(free, planes, best, step):
    """Fill `step` from a candidate; square of the length of the correction [m^2]."""
    _, i, j, k, a, b, c = best
    length2 = 0.0
    for m in range(3):
        away = a * planes[i].normal[m]
        if j >= 0:
            away += b * planes[j].normal[m]
        if k >= 0:
            away += c * planes[k].normal[m]
        step[m] = free[m] + away
        length2 += away * away
    return length2


@kernel(makes_arrays=False)
def nearest_step(
    free: np.ndarray, planes: np.ndarray, count: int, first: int, slack: float, step: np.ndarray
) -> int:
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
    node. Then the plane `first`, or without it the one with the deepest overlap, pushes alone.
    """
    deepest, overlap = _deepest(free, planes, count)
    for m in range(3):  # no slice: numba would copy where arrays overlap
        step[m] = free[m]
    if deepest < 0:
        return 0
    if count == 1:
        planes[0].push = overlap
        for m in range(3):
            step[m] += overlap * planes[0].normal[m]
        return 1
    best = np.inf, -1, -1, -1, 0.0, 0.0, 0.0
    best = _onto_one(free, planes, count, first, slack, step, best)
    if best[0] > slack:
        best = _onto_two(free, planes, count, step, best)
    if best[0] > slack:
        best = _onto_three(free, planes, count, step, best)
    if best[0] <= max(slack, ACCEPTED * overlap):
        if _pushed(free, planes, best, step) <= (EJECTION * overlap) ** 2:
            pushing = 0
            for plane, push in ((best[1], best[4]), (best[2], best[5]), (best[3], best[6])):
                if plane >= 0:
                    planes[plane].push = push
                    pushing += 1
            return pushing
    hold = first if first >= 0 else deepest
    planes[hold].push = max(0.0, planes[hold].bound - _dot(planes[hold].normal, free))
    for m in range(3):
        step[m] = free[m] + planes[hold].push * planes[hold].normal[m]
    return PINCHED
