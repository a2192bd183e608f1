# SPDX-License-Identifier: LGPL-3.0-or-later
"""Which strides of a motion are alike, so that their mean says something.

A posture is told by the distances between hips, knees, ankles and toes, over the length of a leg:
they do not change with place or heading. A stride over an obstacle, or the first one from standing,
is unlike those of level walking and is not averaged with them.
"""

from itertools import combinations

import numpy as np

from shellform.motion.recording import JOINTS, SIDES, Recording

PLACES = 101  # of a stride
# of a leg's length: level strides differ by up to 0.04, the first one from standing by 0.13, one
# over an obstacle of 0.1 m by 0.55
ALIKE = 0.08


def alike(recording: Recording, strides: np.ndarray) -> list[int]:
    """Indices of the largest group of strides that are alike; [] for fewer than two.

    Parameters
    ----------
    strides : (k, 2) [s], begin and end of each

    Examples
    --------
    >>> from shellform.motion.gait.strides import strides
    >>> walk = sf.synthetic_walk(strides=4, obstacle=0.0)
    >>> alike(walk, strides(walk)["right"])  # not the first one, from standing
    [1, 2]
    """
    if len(strides) < 2:
        return []
    at = strides[:, :1] + (strides[:, 1:] - strides[:, :1]) * np.linspace(0.0, 1.0, PLACES)
    columns = postures(recording)
    courses = np.array(
        [np.stack([np.interp(t, recording.times, c) for c in columns]) for t in at]
    )  # (k, distances, places)
    apart = np.abs(courses[:, None] - courses[None]).max(axis=(2, 3))
    near = apart <= ALIKE
    middle = near.sum(axis=1).argmax()
    found = np.flatnonzero(near[middle]).tolist()
    return found if len(found) > 1 else []


def postures(recording: Recording) -> np.ndarray:
    """Distances (m, n) between the joints in n frames, over the length of a leg."""
    places = [
        recording.joint_centre(joint)
        for joint, (*_, (name, _)) in JOINTS.items()
        if name in recording.points
    ]
    feet = [f"{side}_foot" for side in SIDES]
    places += [recording.points[foot][:, 1] for foot in feet if foot in recording.points]
    pairs = combinations(places, 2)
    distances = np.array([np.linalg.norm(a - b, axis=1) for a, b in pairs])
    lengths = recording.lengths()
    parts = [length for name, (length, _) in lengths.items() if name.endswith(("thigh", "shank"))]
    return distances / (2 * np.mean(parts)) if parts else distances
