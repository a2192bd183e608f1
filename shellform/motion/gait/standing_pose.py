# SPDX-License-Identifier: LGPL-3.0-or-later
"""The standing pose: upright, feet forward below the hips, soles on the floor.

A synthetic walk begins in it, a captured one is led into from it, and in it a wearer is dressed.
"""

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from shellform.motion.proportions import (
    ANKLE_UP,
    ENDS_UP,
    HEEL_BACK,
    HIP_SPACING,
    LEG,
    MARKERS,
    SIGN,
)
from shellform.motion.recording import SEGMENTS, SIDES, Recording

from .leg import leg_points, unit


def standing(
    lengths: Mapping[str, ArrayLike],
    heading: ArrayLike = (1.0, 0.0, 0.0),
    at: ArrayLike = (0.0, 0.0),
    floor: float = 0.0,
    hip_spacing: float | None = None,
    knee: float = 3.0,
    ankle: Mapping[str, tuple[float, float]] | None = None,
) -> dict[str, np.ndarray]:
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
    long = _checked(lengths, knee)
    ahead = np.append(np.asarray(heading, float)[:2], 0.0)
    if not np.linalg.norm(ahead) > 1e-9:
        raise ValueError(f"heading {tuple(np.asarray(heading))} has no horizontal part")
    ahead, up = unit(ahead), np.array([0.0, 0.0, 1.0])
    left = np.cross(up, ahead)
    leg = float(np.mean([long[f"{side}_thigh"] + long[f"{side}_shank"] for side in SIDES]))
    scale, ankle_up = leg / LEG, ANKLE_UP * leg
    half = 0.5 * (HIP_SPACING * scale if hip_spacing is None else hip_spacing)
    ground = np.append(np.asarray(at, float), floor)
    middle = ground + (ankle_up + _hips_over_ankles(long, knee)) * up
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


def _checked(lengths, knee):
    """Lengths [m] as numbers; ValueError for one that lacks or is none, or a knee that is bent."""
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
    return long


def _hips_over_ankles(long, knee):
    """Height [m] of the hip centres over the ankles, knees bent by `knee` [degree].

    The shorter leg is as straight as asked for, the other one bends a little more.
    """
    legs = [(long[f"{side}_thigh"], long[f"{side}_shank"]) for side in SIDES]
    reach = min(np.sqrt(a * a + b * b + 2 * a * b * np.cos(np.radians(knee))) for a, b in legs)
    # a leg stretched to the last digit leaves the root of a difference of squares to roundoff
    return min(reach, (1 - 1e-12) * min(a + b for a, b in legs))


def standing_of(recording: Recording, knee: float = 3.0) -> dict[str, np.ndarray]:
    """The standing pose from which a recording can be blended: its lengths, place and heading.

    Hip spacing, heading and the place of the mid hip are those of its first frame, lengths and the
    ankle's place over the foot are medians. The floor is below the lowest ankle by as much as the
    ankle stands over the sole of a synthetic walker of that leg.
    """
    points = recording.points
    first = {name: track[0] for name, track in points.items()}
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
        float(lowest - ANKLE_UP * np.mean(legs)),
        float(np.linalg.norm(across)),
        knee,
        ankle or None,
    )
