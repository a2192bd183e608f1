# SPDX-License-Identifier: LGPL-3.0-or-later
"""A body that jumps: its pose over a step is not where its own velocity leads.

Contact takes what a body does over a step as its motion (segment_motion.py), whatever velocity its
motion gives. A pose that is set anew, from one frame to the next, is then a velocity of hundreds of
metres a second for the length of one step, and cloth in the way takes it up. Looked at are the
points of a segment farthest along e1, e2, e3 (the tips of semi-axes): their way is held against the
mean of their velocities at both ends. A motion that starts or stops at once differs from that by
less than the velocities themselves, a jump by more.
"""

from collections.abc import Sequence

import numpy as np

from contact.kernel import kernel

from .segments import Pose

JUMP = 0.01  # more than the velocities say [m]; smaller ones bend no cell, and pass


@kernel
def first_jump(
    centres: np.ndarray,
    axes: np.ndarray,
    velocities: np.ndarray,
    spins: np.ndarray,
    end_centres: np.ndarray,
    end_axes: np.ndarray,
    end_velocities: np.ndarray,
    end_spins: np.ndarray,
    extents: np.ndarray,
    dt: float,
) -> tuple[int, float]:
    """First segment that jumps over a step, and the jump [m]; -1 and 0 without.

    Parameters
    ----------
    centres (m, 3), axes (m, 3, 3), velocities, spins (m, 3) : a `Pose` at t, and the same at
        t + dt
    extents : (m, 3), half extents of the shapes along e1, e2, e3 [m]; dt : float [s]
    """
    for b in range(len(centres)):
        for k in range(3):
            off2 = speed2 = end_speed2 = 0.0
            for c in range(3):
                d, e = (c + 1) % 3, (c + 2) % 3
                arm, end_arm = axes[b, k], end_axes[b, k]
                v = velocities[b, c] + extents[b, k] * (spins[b, d] * arm[e] - spins[b, e] * arm[d])
                w = end_velocities[b, c]
                w += extents[b, k] * (end_spins[b, d] * end_arm[e] - end_spins[b, e] * end_arm[d])
                way = end_centres[b, c] - centres[b, c] + extents[b, k] * (end_arm[c] - arm[c])
                off2 += (way - 0.5 * dt * (v + w)) ** 2
                speed2, end_speed2 = speed2 + v * v, end_speed2 + w * w
            off = np.sqrt(off2)
            if off > JUMP + dt * (np.sqrt(speed2) + np.sqrt(end_speed2)):
                return b, off
    return -1, 0.0


def require_no_jump(
    names: Sequence[str], extents: np.ndarray, start: Pose, end: Pose, t: float, dt: float
) -> None:
    """Refuse a body that jumps over the step from t to t + dt [s].

    Parameters
    ----------
    names : of the segments; extents : (m, 3), half extents [m]; start, end : `Pose`

    Raises
    ------
    ValueError
        With the segment, the jump and the time.
    """
    b, jump = first_jump(*start, *end, extents, dt)
    if b >= 0:
        raise body_jumps(names[b], jump, t, t + dt)


def body_jumps(name: str, jump: float, start: float, end: float) -> ValueError:
    """What to raise for a segment that jumps by some way [m] between two times [s]."""
    return ValueError(
        f"segment '{name}' jumps by {jump:.3g} m between t = {start:.6g} and {end:.6g} s, "
        "which its velocity does not tell; give it a motion that goes there, or place it "
        "before the first step"
    )
