# SPDX-License-Identifier: LGPL-3.0-or-later
"""The planes that halve the bends of joints, where flesh meets flesh, and their rates.

    n = (u_a - u_b) / |u_a - u_b|,  c = (c_a + c_b) / 2

u_a points from the joint along the segment above, u_b along the one below, both unit vectors fixed
in their segments; c_a and c_b are the joint's centre as either segment carries it.
"""

import numpy as np

from contact.kernel import kernel

BENDS = [
    ("above", np.int64),
    ("below", np.int64),
    ("centre_above", float, 3),  # of the joint, in the axes of the segments [m]
    ("centre_below", float, 3),
    ("along_above", float, 3),  # u_a, u_b in the axes of the segments
    ("along_below", float, 3),
]


@kernel(makes_arrays=False, fastmath={"contract"})
def _turned(axes, y, out):
    """out (3,) = vector y in the axes (rows) of a segment, in the world's."""
    for c in range(3):
        out[c] = y[0] * axes[0, c] + y[1] * axes[1, c] + y[2] * axes[2, c]


@kernel(makes_arrays=False, fastmath={"contract"})
def set_planes(
    bends: np.ndarray, centres: np.ndarray, axes: np.ndarray, planes: np.ndarray
) -> None:
    """Fill planes (k, 7, 3): arms of c in both segments, u_a, u_b, c, n; the last row is free.

    bends (k,) BENDS; centres (m, 3), axes (m, 3, 3) of the segments; planes[:, 6, 0] = |u_a - u_b|
    """
    for k in range(len(bends)):
        a, b, at = bends[k].above, bends[k].below, planes[k]
        _turned(axes[a], bends[k].centre_above, at[0])
        _turned(axes[b], bends[k].centre_below, at[1])
        _turned(axes[a], bends[k].along_above, at[2])
        _turned(axes[b], bends[k].along_below, at[3])
        size = 0.0
        for c in range(3):
            at[4, c] = 0.5 * (centres[a, c] + at[0, c] + centres[b, c] + at[1, c])
            at[5, c] = at[2, c] - at[3, c]
            size += at[5, c] ** 2
        # only a leg folded back on itself has none; it is not pressed then
        size = np.sqrt(max(size, 1e-12))
        at[6, 0] = size
        for c in range(3):
            at[5, c] /= size


@kernel(makes_arrays=False, fastmath={"contract"})
def plane_rates(
    bends: np.ndarray, planes: np.ndarray, velocities: np.ndarray, spins: np.ndarray,
    out: np.ndarray,
) -> None:  # fmt: skip
    """Fill out (k, 2, 3): c' and n' of the planes."""
    for k in range(len(bends)):
        a, b, at = bends[k].above, bends[k].below, planes[k]
        along = 0.0
        for c in range(3):
            d, e = (c + 1) % 3, (c + 2) % 3
            out[k, 0, c] = 0.5 * (
                velocities[a, c] + spins[a, d] * at[0, e] - spins[a, e] * at[0, d]
                + velocities[b, c] + spins[b, d] * at[1, e] - spins[b, e] * at[1, d]
            )  # fmt: skip
            out[k, 1, c] = (
                spins[a, d] * at[2, e] - spins[a, e] * at[2, d]
                - spins[b, d] * at[3, e] + spins[b, e] * at[3, d]
            ) / at[6, 0]  # fmt: skip
            along += out[k, 1, c] * at[5, c]
        for c in range(3):
            out[k, 1, c] -= along * at[5, c]
