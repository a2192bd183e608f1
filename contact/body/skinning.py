# SPDX-License-Identifier: LGPL-3.0-or-later
r"""Vertices of a skin carried by several segments: where they are and how fast.

A vertex, bulged as the joints bend (`bulge`), is placed by the blended dual quaternions of its
segments (`dual_quaternions`), then, near a joint that bends, kept on its side of the plane that
halves the bend (`flesh`):

    s = side n . (x - c),   x <- x + part side (g(s) - s) n

with the plane of `bend_planes`. All is linear in the twists of the segments, and `skin_adjoint` is
the transpose to the last digit, so virtual power, momentum and angular momentum are exact.
"""

import numpy as np

from contact.kernel import kernel

from .dual_quaternions import NOWHERE, blend, moved, moving, set_motion
from .flesh import kept_on_side

SKIN = [
    ("bend", np.int64),  # joint that presses it, -1 for none
    ("side", float),  # 1 above that joint, -1 below
    ("margin", float),  # m of `flesh` [m]
    ("room", float),  # r of `flesh` [m]
    ("part", float),  # of the press that it feels, 0 to 1
]


@kernel(makes_arrays=False, fastmath={"contract"})
def set_motions(
    centres: np.ndarray, axes: np.ndarray, at: np.ndarray, along: np.ndarray,
    motions: np.ndarray, matrices: np.ndarray,
) -> None:  # fmt: skip
    """Fill motions (m, 8) and matrices (m, 3, 4), R and t, of segments from where skin was bound.

    centres (m, 3), axes (m, 3, 3) : now; at, along : the same at binding
    """
    for j in range(len(motions)):
        set_motion(motions[j], centres[j], axes[j], at[j], along[j])
        for r in range(3):
            shift = centres[j, r]
            for c in range(3):
                R = 0.0
                for k in range(3):
                    R += axes[j, k, r] * along[j, k, c]
                matrices[j, r, c] = R
                shift -= R * at[j, c]
            matrices[j, r, 3] = shift


@kernel(makes_arrays=False, fastmath={"contract"})
def _on_one(weights, i):
    """Whether vertex i is bound to one segment."""
    return weights.shape[1] == 1 or weights[i, 1] == 0.0


@kernel(makes_arrays=False, fastmath={"contract"})
def place_skin(
    skin: np.ndarray, points: np.ndarray, which: np.ndarray, weights: np.ndarray,
    motions: np.ndarray, matrices: np.ndarray, planes: np.ndarray, out: np.ndarray,
) -> None:  # fmt: skip
    """Fill the places out (n, 3) [m] of the vertices.

    skin : (n,) SKIN; points : (n, 3), where they were bound, bulged [m]
    which, weights : (n, k), segments and weights, the largest first
    motions, matrices : of `set_motions`; planes : of `set_planes`
    """
    for i in range(len(skin)):
        k, p = skin[i].bend, points[i]
        if _on_one(weights, i):
            R = matrices[which[i, 0]]
            x0 = R[0, 3] + R[0, 0] * p[0] + R[0, 1] * p[1] + R[0, 2] * p[2]
            x1 = R[1, 3] + R[1, 0] * p[0] + R[1, 1] * p[1] + R[1, 2] * p[2]
            x2 = R[2, 3] + R[2, 0] * p[0] + R[2, 1] * p[1] + R[2, 2] * p[2]
        else:
            b, d = blend(motions, motions, which[i], weights[i])
            x0, x1, x2 = moved(b, d, (0.0, p[0], p[1], p[2]))
        if k >= 0:
            at, side = planes[k], skin[i].side
            s = side * (
                at[5, 0] * (x0 - at[4, 0]) + at[5, 1] * (x1 - at[4, 1]) + at[5, 2] * (x2 - at[4, 2])
            )
            push = skin[i].part * side * (kept_on_side(s, skin[i].margin, skin[i].room)[0] - s)
            x0, x1, x2 = x0 + push * at[5, 0], x1 + push * at[5, 1], x2 + push * at[5, 2]
        out[i, 0], out[i, 1], out[i, 2] = x0, x1, x2


@kernel(makes_arrays=False, fastmath={"contract"})
def skin_rates(
    skin: np.ndarray, points: np.ndarray, which: np.ndarray, weights: np.ndarray,
    motions: np.ndarray, rates: np.ndarray, planes: np.ndarray, of_planes: np.ndarray,
    fields: np.ndarray, directions: np.ndarray, swelling: np.ndarray, out: np.ndarray,
) -> None:  # fmt: skip
    """Fill the velocities out (n, 3) [m/s]: the derivative of `place_skin`.

    rates (m, 8) : of the motions; of_planes : of `plane_rates`
    fields (n,), directions (n, 3), swelling (k,) : of `bulge`, fields of none without one
    """
    for i in range(len(skin)):
        p = (0.0, points[i, 0], points[i, 1], points[i, 2])
        b, d = blend(motions, motions, which[i], weights[i])
        db, dd = blend(motions, rates, which[i], weights[i])
        x = moved(b, d, p)
        v = moving(b, d, p, db, dd, x)
        if len(fields) > 0 and fields[i] >= 0:
            y = moved(b, NOWHERE, (0.0, directions[i, 0], directions[i, 1], directions[i, 2]))
            rate = swelling[fields[i]]
            v = (v[0] + rate * y[0], v[1] + rate * y[1], v[2] + rate * y[2])
        for c in range(3):
            out[i, c] = v[c]
        k = skin[i].bend
        if k < 0:
            continue
        at, side, s, ds = planes[k], skin[i].side, 0.0, 0.0
        for c in range(3):
            arm = x[c] - at[4, c]
            s += at[5, c] * arm
            ds += at[5, c] * (v[c] - of_planes[k, 0, c]) + of_planes[k, 1, c] * arm
        g, slope = kept_on_side(side * s, skin[i].margin, skin[i].room)
        push, h = skin[i].part * (slope - 1.0) * ds, skin[i].part * (side * g - s)
        for c in range(3):
            out[i, c] += push * at[5, c] + h * of_planes[k, 1, c]
