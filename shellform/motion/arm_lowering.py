# SPDX-License-Identifier: LGPL-3.0-or-later
"""A wearer who stands still and lets the arms down, as while a shirt is put on.

Shirts are sewn about arms held as their sleeves are cut; from there the arms turn about the
shoulders into the pose of the first frame, along the polynomial of least jerk.
"""

import numpy as np

from .recording import Recording
from .upper_body import arms_raised

FRAMES = 20  # of the way


def arms_lowered(
    recording: Recording, angle: float, end: float, hold: float, seconds: float
) -> Recording:
    """The first frame of a recording, held, with arms that come down to where they are in it.

    Parameters
    ----------
    recording : with the upper body; angle : [rad] outwards from there, at first
    end : time [s] at which the arms are down; hold, seconds : [s] that they are held up, and let
        down in
    """
    s = np.clip(np.linspace(-hold / seconds, 1.0, round(FRAMES * (1 + hold / seconds)) + 1), 0, 1)
    s = np.append(s, [1.0, 1.0, 1.0])  # at rest when the way ends
    up = 1.0 - s**3 * (10 - 15 * s + 6 * s**2)
    first = {n: np.repeat(track[:1], len(s), axis=0) for n, track in recording.points.items()}
    points = arms_raised(first, angle * up)
    step = (hold + seconds) / (len(s) - 4)
    times = end + step * (np.arange(len(s)) - (len(s) - 4))
    return Recording(times, points, recording.source)
