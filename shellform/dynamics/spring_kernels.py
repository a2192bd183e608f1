# SPDX-License-Identifier: LGPL-3.0-or-later
"""Forces and energies of single springs of the particle model, Sec. 2.1 of the paper.

A spring pulls with k (l - l0). One that buckles (Choi and Ko, ACM Trans. Graph. 21, 2002) pushes as
a pinned column of bending stiffness k_b does: f = k_b kappa^2/(cos(kappa L/2) - sinc(kappa L/2)),
-12 k_b/L^2 when straight; above the length at which that force is reached it is the plain spring.
"""

import numpy as np

from contact.kernel import kernel

EDGE, DIAGONAL, BEND = 0, 1, 2


@kernel
def buckling_force(length: float, rest: float, k_b: float) -> tuple[float, float]:
    """Force [N] of a buckled pinned column of chord `length` < rest, and its energy [J]."""
    ratio = length / rest
    low, high = 0.0, np.pi
    u = min(3.0, np.sqrt(6.0 * max(0.0, 1.0 - ratio)))
    for _ in range(60):
        value = (1.0 - u * u / 6.0 + u**4 / 120.0) if u < 1e-2 else np.sin(u) / u
        slope = -u / 3.0 + u**3 / 30.0 if u < 1e-2 else (np.cos(u) - value) / u
        if value > ratio:
            low = u
        else:
            high = u
        new = u - (value - ratio) / slope if slope != 0.0 else 0.5 * (low + high)
        if not low <= new <= high:
            new = 0.5 * (low + high)
        if abs(new - u) <= 1e-14 * (1.0 + u):
            u = new
            break
        u = new
    energy = 2.0 * k_b * u * u / rest
    if u < 1e-2:
        return -12.0 * k_b / rest**2 / (1.0 - u * u / 10.0), energy
    return k_b * (2.0 * u / rest) ** 2 / (np.cos(u) - np.sin(u) / u), energy


@kernel
def pull(length: float, rest: float, k: float, k_b: float, turn: float, linear: bool) -> float:
    """Force [N], positive in tension, of one spring; `turn` is the length where it buckles."""
    if k_b == 0.0 or linear:
        return k * (length - rest)
    if length >= rest:
        return 0.0
    if length >= turn:
        return k * (length - rest)
    return buckling_force(length, rest, k_b)[0]


# one record per spring
SPRING = np.dtype(
    [
        ("ends", np.int64, 2),  # nodes
        ("rest", float),  # length [m]
        ("k", float),  # in tension [N/m]
        ("k_b", float),  # of springs that buckle [N m^2], 0 else
        ("turn", float),  # length where they do [m]
        ("kind", np.int64),  # EDGE, DIAGONAL or BEND
    ]
)


@kernel
def forces(
    points: np.ndarray,
    w: np.ndarray,
    v: np.ndarray,
    damping: float,
    table: np.ndarray,
    linear: bool,
    r: np.ndarray,
    viscous: np.ndarray,
) -> None:
    """Internal forces into r (n, 6) [N], stiffness-proportional damping along the springs.

    table : (s,) SPRING. The part of damping alone goes into viscous (n, 3) [N] too. `linear`:
    springs that buckle have the slope they start with, on both sides.
    """
    r[:] = 0.0
    if damping > 0.0:
        viscous[:] = 0.0
    for s in range(len(table)):
        spring = table[s]
        i, j = spring.ends[0], spring.ends[1]
        d0 = points[j, 0] - points[i, 0] + w[j, 0] - w[i, 0]
        d1 = points[j, 1] - points[i, 1] + w[j, 1] - w[i, 1]
        d2 = points[j, 2] - points[i, 2] + w[j, 2] - w[i, 2]
        length = np.sqrt(d0 * d0 + d1 * d1 + d2 * d2)
        if length == 0.0:
            continue
        f = pull(length, spring.rest, spring.k, spring.k_b, spring.turn, linear)
        if damping > 0.0:
            rate = d0 * (v[j, 0] - v[i, 0]) + d1 * (v[j, 1] - v[i, 1]) + d2 * (v[j, 2] - v[i, 2])
            slow = damping * spring.k * rate / length
            f += slow
            slow /= length
            viscous[i, 0] -= slow * d0
            viscous[i, 1] -= slow * d1
            viscous[i, 2] -= slow * d2
            viscous[j, 0] += slow * d0
            viscous[j, 1] += slow * d1
            viscous[j, 2] += slow * d2
        f /= length
        r[i, 0] -= f * d0
        r[i, 1] -= f * d1
        r[i, 2] -= f * d2
        r[j, 0] += f * d0
        r[j, 1] += f * d1
        r[j, 2] += f * d2


@kernel
def energies(points: np.ndarray, w: np.ndarray, table: np.ndarray, out: np.ndarray) -> None:
    """Strain energies [J] of springs (s,) SPRING by kind into out (3,)."""
    out[:] = 0.0
    for s in range(len(table)):
        spring, square = table[s], 0.0
        i, j = spring.ends[0], spring.ends[1]
        for c in range(3):
            square += (points[j, c] - points[i, c] + w[j, c] - w[i, c]) ** 2
        length = np.sqrt(square)
        rest, k, k_b, turn = spring.rest, spring.k, spring.k_b, spring.turn
        e = 0.5 * k * (length - rest) ** 2
        if k_b > 0.0 and length >= rest:
            e = 0.0
        elif k_b > 0.0 and length < turn:
            e = 0.5 * k * (turn - rest) ** 2
            e += buckling_force(length, rest, k_b)[1]
            e -= buckling_force(turn, rest, k_b)[1]
        out[spring.kind] += e


def buckling_length(rest: float, k: float, k_b: float) -> float:
    """Length [m] at which the ramp k (l - rest) meets the column's force."""
    if k_b == 0.0:
        return 0.0
    low, high = 1e-6 * rest, rest
    for _ in range(60):
        middle = 0.5 * (low + high)
        if k * (middle - rest) < buckling_force(middle, rest, k_b)[0]:
            low = middle
        else:
            high = middle
    return high
