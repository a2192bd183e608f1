# SPDX-License-Identifier: LGPL-3.0-or-later
"""A body that jumps: its pose over a step is not where its own velocity leads.

Contact takes what a body does over a step as its motion (travel.py), whatever the velocity its
motion tells. A pose that is set anew, from one frame to the next, is then a velocity of hundreds of
metres a second for the length of one step, and cloth in the way takes it up. The way of the tips of
the semi-axes is held against the mean of their velocities at both ends: a motion that starts or
stops at once differs from that by less than the velocities themselves, a jump by more.
"""

import numpy as np
from numba import njit

JUMP = 0.01  # more than the velocities tell [m]; smaller ones bend no cell, and pass


@njit(cache=True, error_model="numpy")
def first_jump(
    centres, axes, velocities, spins, end_centres, end_axes, end_velocities, end_spins, radii, dt
):  # fmt: skip
    """First segment that jumps over a step, and the jump [m]; -1 and 0 without.

    Parameters
    ----------
    centres (m, 3), axes (m, 3, 3), velocities, spins (m, 3) : a `Pose` at t, and the same at
        t + dt
    radii : (m, 3) [m]; dt : float [s]
    """
    for b in range(len(centres)):
        for k in range(3):
            off2 = speed2 = end_speed2 = 0.0
            for c in range(3):
                d, e = (c + 1) % 3, (c + 2) % 3
                arm, end_arm = axes[b, k], end_axes[b, k]
                v = velocities[b, c] + radii[b, k] * (spins[b, d] * arm[e] - spins[b, e] * arm[d])
                w = end_velocities[b, c]
                w += radii[b, k] * (end_spins[b, d] * end_arm[e] - end_spins[b, e] * end_arm[d])
                way = end_centres[b, c] - centres[b, c] + radii[b, k] * (end_arm[c] - arm[c])
                off2 += (way - 0.5 * dt * (v + w)) ** 2
                speed2, end_speed2 = speed2 + v * v, end_speed2 + w * w
            off = np.sqrt(off2)
            if off > JUMP + dt * (np.sqrt(speed2) + np.sqrt(end_speed2)):
                return b, off
    return -1, 0.0


def require_no_jump(names, radii, start, end, t, dt):
    """Refuse a body that jumps over the step from t to t + dt [s].

    Parameters
    ----------
    names : of the segments; radii : (m, 3) [m]; start, end : `contact.body.segments.Pose`

    Raises
    ------
    ValueError
        With the segment, the jump and the time.
    """
    b, jump = first_jump(*start, *end, radii, dt)
    if b >= 0:
        raise ValueError(
            f"segment '{names[b]}' jumps by {jump:.3g} m between t = {t:.6g} and {t + dt:.6g} s, "
            "which its velocity does not tell; give it a motion that goes there, or place it "
            "before the first step"
        )
