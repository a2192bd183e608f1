# SPDX-License-Identifier: LGPL-3.0-or-later
"""A walk without a capture: from standing over four strides, the third over an obstacle (Sec. 4.2).

Feet and pelvis go along prescribed smooth paths, the legs between them follow by two-link inverse
kinematics, so segments keep their lengths. Feet: `footfall`. Pelvis: quintic splines through its
places near each heel strike, where it is low, and between them, where it is high. Knots of level
strides were fitted to published angles of hip and knee, the mean of 15 adults (BioCV, Univ. of
Bath, as in myogait's normative curves) and of 10 adults (CROSS_OBSTACLE_DATASET, level trials).

Published facts: cadence 110 a minute and stride 1.32 m, within 104 to 117 and 1.28 to 1.58 m
(Murray et al., J. Bone Joint Surg. 46A, 1964, and free captures); double support 2 x 8 % of the
stride; pelvis range 0.04 m up and down, 0.04 m aside, rotation 4.5 and list 3 degrees. Over an
obstacle of 0.3 leg lengths people put the toe 0.24 leg lengths before it and the heel 0.15 behind,
at 0.64 m/s (Sci. Rep. 12, 2022, s41598-022-06631-8, Table 1); here 0.28, 0.13 and 0.7 m/s. No
measured crossing of 0.5 m was found: as people do, the walker hikes the pelvis, rises on the
forefoot of the standing leg and swings the foot outward.

All of it is for a stature of 1.755 m; lengths scale with stature, times with its root.
"""

import numpy as np

from shellform.motion.proportions import (
    ANKLE,
    HEEL,
    HIP_SPACING,
    LENGTHS,
    MARKERS,
    RIM,
    SIGN,
    STATURE,
    TOE,
)
from shellform.motion.recording import SIDES, Recording

from .footfall import spline, track
from .footsteps import FIRST_OFF, STEP, STEP_TIME, events_of, footfalls, footsteps, level_swings
from .leg import joint_angles, leg_points
from .obstacle_crossing import LEAD, TRAIL, cross, turned_out
from .standing_pose import standing, standing_of

__all__ = ["joint_angles", "standing", "standing_of", "synthetic_walk"]

STANDING_KNEE = 3.0  # [degree]
# pelvis: heights of the mid hip, how far it is behind the foot that strikes, and in mid-step
LOW, HIGH, BEHIND, LAG = 0.873, 0.9122, 0.305, 0.008  # [m]
SWAY, ROTATION, LIST = 0.020, np.radians(4.5), np.radians(3.0)
# of the first step: places (x, aside, z) at toe-off and on the way, and at its heel strike
START = ((0.035, 0.025, 0.905), (0.13, 0.020, 0.898))
START_BEHIND, START_LOW = 0.26, 0.876
EARLY = 0.004  # the pelvis is lowest this long before heel strike [s]
TALLEST, DEEPEST = 0.305, 0.045  # obstacle over stature up to which the walk is made


def synthetic_walk(
    stature: float = 1.755,
    strides: int = 4,
    obstacle: float = 0.5,
    obstacle_stride: int = 3,
    rate: float = 100.0,
    stand: float = 0.3,
    first: str = "right",
    depth: float = 0.06,
) -> Recording:
    """A wearer who stands, walks and steps over an obstacle; x forward, z up, floor at z = 0.

    A stride is a step of the `first` foot and one of the other; the recording ends with the heel
    strike of the last one, in full walk. It begins in the pose of `standing` with the mid of both
    ankles at the origin and has two continuous derivatives from there on.

    Parameters
    ----------
    stature : float [m]
    strides : int, 1 or more
    obstacle : height [m], up to 0.305 of the stature; 0: level walk. The sole clears it by 0.07 m,
        one lower than 0.1 m by more
    obstacle_stride : the stride that crosses it, 2 to `strides`; `first` leads
    rate : frames a second [Hz]
    stand : time at rest at the beginning [s]
    first : 'right' or 'left', the foot that starts
    depth : of the obstacle along x, up to 0.045 of the stature [m]

    Returns
    -------
    Recording with pelvis, thighs, shanks and feet. facts: stature, stride_length [m], cadence
    [steps/min] of the level strides, events ((name, time [s]), ...) in order, named as
    'right_heel_strike' and 'left_toe_off', and obstacle: dict of front, depth, height [m], or None

    Raises
    ------
    ValueError
        For an argument out of its range.

    Examples
    --------
    >>> walk = sf.synthetic_walk(stature=1.80, obstacle=0.0)
    >>> f"{walk.facts['stride_length']:.2f} m, {walk.facts['cadence']:.0f} steps a minute"
    '1.35 m, 109 steps a minute'
    >>> walk.facts["events"][0]
    ('right_toe_off', 0.72...)
    """
    _check(stature, strides, obstacle, obstacle_stride, rate, stand, first, depth)
    long, slow = stature / STATURE, np.sqrt(stature / STATURE)
    steps = footsteps(strides, obstacle / long, obstacle_stride, stand / slow, first, depth / long)
    pelvis = _pelvis(steps)
    falls = footfalls(steps)
    swings = {side: level_swings(falls[side]) for side in SIDES}
    out: dict[str, list] = {side: [] for side in SIDES}
    for i in range(1, 2 * strides + 1):
        way = steps.crossing(i)
        if way is not None:
            side, k = steps.side[i], (i - 1) // 2
            pair = falls[side][k : k + 2]
            swings[side][k] = cross(way, pair, side, steps, lambda t: _hips(pelvis, steps, t))
            out[side].append((way, pair))
    end = steps.strike[2 * strides] * slow
    times = np.arange(int(np.floor(end * rate + 1e-6)) + 1) / rate
    t = times / slow
    middle, left, ahead, up = _hips(pelvis, steps, t)
    top = middle + LENGTHS["pelvis"] * up
    points = {"pelvis": np.stack([top, middle, top + MARKERS["pelvis"] * ahead], axis=1)}
    for side in SIDES:
        ankle, pitch = track(falls[side], swings[side], t)
        turn = turned_out(out[side], side, steps.share, t)
        axis = np.cos(turn)[:, None] * left - np.sin(turn)[:, None] * ahead
        hip = middle + SIGN[side] * 0.5 * HIP_SPACING * left
        lengths = LENGTHS["thigh"], LENGTHS["shank"]
        points[f"{side}_thigh"], points[f"{side}_shank"] = leg_points(
            hip, ankle, axis, *lengths, side
        )
        points[f"{side}_foot"] = _foot(ankle, pitch, 0.5 * turn, side)
    level = {"stride_length": 2 * STEP * long, "cadence": 60.0 / (STEP_TIME * slow)}
    box = {"front": steps.front * long, "depth": depth, "height": obstacle}
    facts = {"stature": stature, **level, "obstacle": box if obstacle > 0 else None}
    facts["events"] = events_of(falls, slow, times[-1])
    points = {name: track_ * long for name, track_ in points.items()}
    return Recording(times, points, "synthetic walk", facts=facts)


def _check(stature, strides, obstacle, obstacle_stride, rate, stand, first, depth):
    if not 1.0 < stature < 2.5:
        raise ValueError(f"stature {stature:g} is not that of an adult in metres: give 1.0 to 2.5")
    if int(strides) != strides or strides < 1:
        raise ValueError(f"strides must be a whole number of 1 or more, not {strides}")
    if not 0.0 <= obstacle <= TALLEST * stature:
        raise ValueError(
            f"obstacle of {obstacle:g} m: this walker of {stature:g} m steps over 0 to "
            f"{TALLEST * stature:.2f} m"
        )
    if obstacle > 0 and obstacle_stride not in range(2, int(strides) + 1):
        raise ValueError(
            f"obstacle_stride must be one of 2 to {strides}, after a stride to get going, not "
            f"{obstacle_stride}"
        )
    if not (np.isfinite(rate) and rate >= 20.0):
        raise ValueError(f"rate must be 20 frames a second or more, not {rate:g}")
    if not (np.isfinite(stand) and stand >= 0.0):
        raise ValueError(f"stand must be a time of 0 s or more, not {stand:g}")
    if first not in SIDES:
        raise ValueError(f"first must be 'right' or 'left', not {first!r}")
    if not 0.0 < depth <= DEEPEST * stature:
        raise ValueError(
            f"depth of the obstacle must be above 0 and up to {DEEPEST * stature:.3f} m for this "
            f"walker, not {depth:g}"
        )


def _pelvis(steps):
    """Spline of the mid hip x, y, z [m], the rotation (to the left) and list (right side up)."""
    straight = np.radians(STANDING_KNEE)
    a, b = LENGTHS["thigh"], LENGTHS["shank"]
    high = ANKLE + np.sqrt(a * a + b * b + 2 * a * b * np.cos(straight))
    sign = SIGN[steps.side[0]]
    off = steps.start + FIRST_OFF
    times = [steps.start, off, 0.5 * (off + steps.strike[1])]
    rows = [[0.0, 0.0, high, 0.0, 0.0]]
    rows += [[x, sign * y, z, 0.0, 0.0] for x, y, z in START]
    lowest = steps.strike - EARLY

    def low(i):
        behind, z = (BEHIND, LOW) if i > 1 else (START_BEHIND, START_LOW)
        change = (0.0, 0.0)
        for way, step in ((LEAD, steps.lead), (TRAIL, steps.lead and steps.lead + 1)):
            if i == step:
                change = way.low
        if steps.lead and i == steps.lead - 1:
            change = LEAD.low_before
        x = steps.place[i] - behind + steps.share * change[0]
        return np.array([x, 0.0, z + steps.share * change[1], -SIGN[steps.side[i]] * ROTATION, 0.0])

    for i in range(1, len(steps.side) - 1):
        sign, here, there = SIGN[steps.side[i]], low(i), low(i + 1)
        way = steps.crossing(i + 1)
        span = lowest[i + 1] - lowest[i]
        times.append(lowest[i])
        rows.append(here)
        if way is None:
            times.append(lowest[i] + 0.5 * span)
            x = 0.5 * (here[0] + there[0]) - LAG
            rows.append([x, sign * SWAY, HIGH, 0.0, -sign * LIST])
            continue
        for part, amount, ahead, z, level in way.pelvis:
            times.append(lowest[i] + part * span)
            x = here[0] + part * (there[0] - here[0]) + steps.share * ahead
            sway = SWAY + steps.share * (way.sway - SWAY)
            hike = LIST - steps.share * (LIST + way.hike)
            z = level + steps.share * (z - level)
            turn = here[3] * (1 - 2 * part)
            rows.append([x, amount * sign * sway, z, turn, -amount * sign * hike])
    return spline(times, np.array(rows))


def _hips(pelvis, steps, t):
    """Mid hip (n, 3) [m] and the pelvis's axes left, ahead, up, (n, 3) each, at times t."""
    # without gaps, or the last digit of a sine depends on where in memory an angle lies
    x, y, z, turn, hike = np.ascontiguousarray(pelvis(np.maximum(t, steps.start)).T)
    left = np.stack([-np.sin(turn) * np.cos(hike), np.cos(turn) * np.cos(hike), -np.sin(hike)], 1)
    ahead = np.stack([np.cos(turn), np.sin(turn), 0 * turn], 1)
    return np.stack([x, y, z], axis=1), left, ahead, np.cross(ahead, left)


def _foot(ankle, pitch, turn, side):
    """J1, J2, M of a foot, (n, 3, 3) [m], turned to the left by `turn` [rad]."""
    along = np.stack([np.cos(pitch) * np.cos(turn), np.cos(pitch) * np.sin(turn), np.sin(pitch)], 1)
    left = np.stack([-np.sin(turn), np.cos(turn), 0 * turn], axis=1)
    base = ankle - (ANKLE - RIM) * np.cross(along, left)
    toe = base + TOE * along
    return np.stack([base - HEEL * along, toe, toe + SIGN[side] * MARKERS["foot"] * left], axis=1)
