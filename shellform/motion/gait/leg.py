# SPDX-License-Identifier: LGPL-3.0-or-later
"""Legs of a Recording: two-link inverse kinematics, and joint angles.

The knee is a hinge whose axis stands on the plane of hip, knee and ankle; M of thigh and shank lies
beside knee and ankle along that axis. Of the axes of Eq. 17, e1 points down and e2 outward, so that
e3 = e1 x e2 points backward in a right leg and forward in a left one.
"""

import numpy as np

from contact.body.segment_frame import pose_from_markers
from shellform.motion.proportions import MARKERS, SIGN
from shellform.motion.recording import SEGMENTS, SIDES, Recording


def unit(v: np.ndarray) -> np.ndarray:
    """Vectors (..., 3) over their length."""
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def leg_points(
    hip: np.ndarray,
    ankle: np.ndarray,
    left: np.ndarray,
    thigh: float,
    shank: float,
    side: str,
    scale: float = 1.0,
) -> tuple[np.ndarray, np.ndarray]:
    """J1, J2, M of thigh and shank, (n, 3, 3) each, from hip and ankle centres.

    Parameters
    ----------
    hip, ankle : (n, 3) float [m]
    left : (n, 3) float, the knee's axis before it is put across the leg, to the walker's left
    thigh, shank : lengths [m]
    side : 'right' or 'left'
    scale : of the distances of M

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
    axis = unit(left - np.sum(left * down, axis=-1, keepdims=True) * down)
    along = (thigh**2 + reach**2 - shank**2) / (2 * reach)
    knee = hip + along * down + np.sqrt(thigh**2 - along**2) * np.cross(down, axis)
    outward = SIGN[side] * axis
    return (
        np.stack([hip, knee, knee + MARKERS["thigh"] * scale * outward], axis=-2),
        np.stack([knee, ankle, ankle + MARKERS["shank"] * scale * outward], axis=-2),
    )


def joint_angles(recording: Recording) -> dict[str, np.ndarray]:
    """Angles (n,) [degree] of hip, knee and ankle, from the axes of Eq. 17 of their segments.

    Returns
    -------
    dict: for 'right' and 'left', '<side>_hip_flexion' and '<side>_hip_abduction' (thigh against
    pelvis: forward, outward), '<side>_knee_flexion', '<side>_ankle_dorsiflexion' (0 where the line
    from heel to toe end stands on the shank; only with feet)
    """
    axes = {}
    for name in SEGMENTS:
        if name in recording.points:
            axes[name] = pose_from_markers(*np.moveaxis(recording.points[name], 1, 0))[1]
    out = {}
    for side in SIDES:
        pelvis, thigh, shank = axes["pelvis"], axes[f"{side}_thigh"], axes[f"{side}_shank"]
        down, sign = thigh[:, 0], SIGN[side]
        out[f"{side}_hip_flexion"] = _angle(down, pelvis[:, 0], pelvis[:, 1])
        # e3 of the pelvis points to the right
        aside = -sign * np.sum(down * pelvis[:, 2], axis=1)
        out[f"{side}_hip_abduction"] = np.degrees(np.arcsin(np.clip(aside, -1, 1)))
        out[f"{side}_knee_flexion"] = _angle(shank[:, 0], down, -sign * thigh[:, 2])
        if f"{side}_foot" in axes:
            foot = axes[f"{side}_foot"][:, 0]
            out[f"{side}_ankle_dorsiflexion"] = _angle(foot, sign * shank[:, 2], -shank[:, 0])
    return out


def _angle(v, zero, ninety):
    """Direction of v (n, 3) in the plane of two axes [degree]."""
    return np.degrees(np.arctan2(np.sum(v * ninety, axis=1), np.sum(v * zero, axis=1)))
