# SPDX-License-Identifier: LGPL-3.0-or-later
"""Legs of a Recording: two-link inverse kinematics, the standing pose, and joint angles.

The knee is a hinge whose axis stands on the plane of hip, knee and ankle; M of thigh and shank lies
on that axis, so that both turn about one line, and e3 of a right leg points backward, of a left one
forward (e2 is outward in both).
"""

import numpy as np

from contact.body import pose_from_markers
from contact.recording import JOINTS, SIDES

# as parts of the stature, from 1.755 m: median of ANSUR II men (Paquette et al. 2009, 2012)
STATURE = 1.755
LENGTHS = {"pelvis": 0.100, "thigh": 0.425, "shank": 0.420, "foot": 0.267}  # [m]
HIP_SPACING = 0.170  # [m]
MARKERS = {"pelvis": 0.090, "thigh": 0.060, "shank": 0.048, "foot": 0.050}  # M from J1 or J2 [m]
# of a foot, as parts of the leg (thigh and shank): ankle and ends above the sole, heel behind
ANKLE_UP, ENDS_UP, HEEL_BACK = 0.075 / 0.845, 0.035 / 0.845, 0.055 / 0.845
SIGN = {"right": -1.0, "left": 1.0}  # of the outward axis along the walker's left


def unit(v):
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def leg_points(hip, ankle, forward, thigh, shank, side):
    """J1, J2, M of thigh and shank, (n, 3, 3) each, from hip and ankle centres.

    Parameters
    ----------
    hip, ankle : (n, 3) float [m]
    forward : (n, 3) float, where the knee points to
    thigh, shank : lengths [m]
    side : 'right' or 'left'

    Raises
    ------
    ValueError
        When an ankle is farther from its hip than the leg is long.
    """
    reach = np.linalg.norm(ankle - hip, axis=-1, keepdims=True)
    if not (reach < thigh + shank).all():
        raise ValueError(
            f"the {side} leg of {thigh + shank:.3f} m does not reach from hip to ankle, "
            f"{reach.max():.3f} m"
        )
    down = (ankle - hip) / reach
    ahead = unit(forward - np.sum(forward * down, axis=-1, keepdims=True) * down)
    along = (thigh**2 + reach**2 - shank**2) / (2 * reach)
    knee = hip + along * down + np.sqrt(thigh**2 - along**2) * ahead
    outward = SIGN[side] * np.cross(ahead, down)
    scale = (thigh + shank) / (LENGTHS["thigh"] + LENGTHS["shank"])
    return (
        np.stack([hip, knee, knee + MARKERS["thigh"] * scale * outward], axis=-2),
        np.stack([knee, ankle, ankle + MARKERS["shank"] * scale * outward], axis=-2),
    )
