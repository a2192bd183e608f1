# SPDX-License-Identifier: LGPL-3.0-or-later
"""Legs of a Recording: two-link inverse kinematics, the standing pose, and joint angles.

The knee is a hinge whose axis stands on the plane of hip, knee and ankle; M of thigh and shank lies
beside knee and ankle along that axis. Of the axes of Eq. 17, e1 points down and e2 outward, so that
e3 = e1 x e2 points backward in a right leg and forward in a left one.
"""

import numpy as np

from contact.body.segment_frame import pose_from_markers
from shellform.motion.proportions import (
    ANKLE_UP,
    ENDS_UP,
    HEEL_BACK,
    HIP_SPACING,
    LEG,
    MARKERS,
    SIGN,
)
from shellform.motion.recording import SEGMENTS, SIDES


def unit(v):
    """Vectors (..., 3) over their length."""
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def leg_points(hip, ankle, left, thigh, shank, side, scale=1.0):
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


def standing(
    lengths,
    heading=(1.0, 0.0, 0.0),
    at=(0.0, 0.0),
    floor=0.0,
    hip_spacing=None,
    knee=3.0,
    ankle=None,
):
    """J1, J2, M of a wearer who stands upright, feet forward below the hips, soles on the floor.

    Parameters
    ----------
    lengths : dict, segment -> length [m] or (length, spread), as `Recording.lengths()` gives. The
        pelvis, thighs and shanks are needed; feet may be missing.
    heading : (3,) float, where the wearer looks; its part along z does not count
    at : (2,) float, place x, y of the mid of both ankles [m]
    floor : height of the floor [m]
    hip_spacing : distance of the hip centres [m]; None: in the leg's proportion
    knee : flexion of both knees [degree], 0 to 30
    ankle : dict, side -> (back, up) of the ankle from the line J1-J2 of the foot [m]: how far from
        J1 along it and how high above it; None: that of the synthetic walk

    Returns
    -------
    dict, segment -> (3, 3) float, rows J1, J2, M [m]

    Raises
    ------
    ValueError
        For a segment that is missing, a length that is not positive, a heading along z, a knee
        that is not in 0 to 30 degrees.
    """
    long = {name: float(np.ravel(value)[0]) for name, value in lengths.items()}
    needed = ["pelvis", *(f"{side}_{part}" for side in SIDES for part in ("thigh", "shank"))]
    missing = [name for name in needed if name not in long]
    if missing:
        raise ValueError(f"a standing wearer needs the lengths of {', '.join(missing)}")
    wrong = [name for name, value in long.items() if not (np.isfinite(value) and value > 0)]
    if wrong:
        raise ValueError(f"length of '{wrong[0]}' must be positive [m], not {long[wrong[0]]}")
    if not 0.0 <= knee <= 30.0:
        raise ValueError(f"knee flexion when standing must be 0 to 30 degrees, not {knee:g}")
    ahead = np.array([heading[0], heading[1], 0.0], float)
    if not np.linalg.norm(ahead) > 1e-9:
        raise ValueError(f"heading {tuple(heading)} has no horizontal part")
    ahead, up = unit(ahead), np.array([0.0, 0.0, 1.0])
    left = np.cross(up, ahead)
    legs = [long[f"{side}_thigh"] + long[f"{side}_shank"] for side in SIDES]
    scale = np.mean(legs) / LEG
    half = 0.5 * (HIP_SPACING * scale if hip_spacing is None else hip_spacing)
    ground = np.array([at[0], at[1], floor], float)
    ankle_up = ANKLE_UP * np.mean(legs)
    # the shorter leg is as straight as asked for, the other one bends a little more
    reach = min(
        np.sqrt(a * a + b * b + 2 * a * b * np.cos(np.radians(knee)))
        for a, b in ((long[f"{side}_thigh"], long[f"{side}_shank"]) for side in SIDES)
    )
    # a leg stretched to the last digit leaves the root of a difference of squares to roundoff
    reach = min(reach, (1 - 1e-12) * min(legs))
    middle = ground + (ankle_up + reach) * up
    top = middle + long["pelvis"] * up
    points = {"pelvis": np.stack([top, middle, top + MARKERS["pelvis"] * scale * ahead])}
    for side in SIDES:
        thigh, shank, foot = (f"{side}_{part}" for part in ("thigh", "shank", "foot"))
        aside = SIGN[side] * half * left
        low = ground + ankle_up * up + aside
        points[thigh], points[shank] = leg_points(
            middle + aside, low, left, long[thigh], long[shank], side, scale
        )
        if foot in long:
            parts = (HEEL_BACK * LEG * scale, (ANKLE_UP - ENDS_UP) * LEG * scale)
            back, above = parts if ankle is None else ankle[side]
            heel = low - back * ahead - above * up
            toe = heel + long[foot] * ahead
            outward = SIGN[side] * left
            points[foot] = np.stack([heel, toe, toe + MARKERS["foot"] * scale * outward])
    return points


def standing_of(recording, knee=3.0):
    """The standing pose from which a recording can be blended: its lengths, place and heading.

    Hip spacing, heading and the place of the mid hip are those of its first frame, lengths and the
    ankle's place over the foot are medians. The floor is below the lowest ankle by as much as the
    ankle stands over the sole of a synthetic walker of that leg.
    """
    points = recording.points
    first = {name: track[0] for name, track in points.items()}
    spacing = np.linalg.norm(first["left_thigh"][0] - first["right_thigh"][0])
    across = first["left_thigh"][0] - first["right_thigh"][0]
    heading = np.cross(across, [0.0, 0.0, 1.0])
    lengths = {name: value for name, value in recording.lengths().items() if name in SEGMENTS}
    ankle = {}
    lowest = np.inf
    for side in SIDES:
        joint = points[f"{side}_shank"][:, 1]
        lowest = min(lowest, joint[:, 2].min())
        if f"{side}_foot" in points:
            heel, toe = points[f"{side}_foot"][:, 0], points[f"{side}_foot"][:, 1]
            along = np.sum((joint - heel) * unit(toe - heel), axis=1)
            over = np.linalg.norm(joint - heel, axis=1) ** 2 - along**2
            ankle[side] = (np.median(along), np.median(np.sqrt(np.maximum(over, 0.0))))
    legs = [lengths[f"{side}_thigh"][0] + lengths[f"{side}_shank"][0] for side in SIDES]
    return standing(
        lengths,
        heading,
        first["pelvis"][1, :2],
        lowest - ANKLE_UP * np.mean(legs),
        spacing,
        knee,
        ankle or None,
    )


def joint_angles(recording):
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
