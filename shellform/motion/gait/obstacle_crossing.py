# SPDX-License-Identifier: LGPL-3.0-or-later
"""How a foot gets over an obstacle: knots of its swing, raised until the sole clears it.

A leg that steps over 0.5 m in its own plane, with level hips, needs 120 degrees of the hip and 150
of the knee, out of reach for most people. Hike of the pelvis, rise on the forefoot of the standing
leg, and the foot swung outward bring both down. The foot hangs from its shank: its pitch at each
knot is the shank's angle plus a given dorsiflexion, found by iteration with the leg's kinematics.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from shellform.motion.proportions import HIP_SPACING, LENGTHS, SIGN

from .footfall import Footfall, Swing, sole, track, turned
from .leg import leg_points

if TYPE_CHECKING:
    from .footsteps import Footsteps

CLEARANCE = 0.07  # of the sole over the obstacle [m]; people keep 0.05 to 0.2
LAST = 0.88  # instant of the last pitch knot, while the knee extends
SAMPLES, ROUNDS, RELAXED = 121, 12, 0.7


class Crossing(NamedTuple):
    """Numbers of a crossing step over 0.5 m at a stature of 1.755 m; lower ones take their share.

    time : of the step [s]; before, past : toe end before, heel end past the obstacle [m]
    instants : of the knots, part of the swing; x : ankle after the obstacle's front [m]; lift :
    over what clears the obstacle [m], both over 0.1 and over 0.5 m
    dorsiflexion : at the knots and at `LAST` [rad]
    aside, out : ankle outward [m] and leg turned outward [rad] in mid-swing
    vault : (before toe-off [s], pitch [rad]) of the standing foot
    sway, hike : of the pelvis to the standing side [m], swing side up [rad]
    pelvis : rows (part of the step, part of sway and hike, ahead of steady motion [m], height [m],
    height in a level step [m]); low, low_before : shift along and up [m] where the pelvis is lowest
    """

    time: float
    before: float
    past: float
    instants: tuple
    x: tuple
    lift: tuple
    dorsiflexion: tuple
    aside: float
    out: float
    vault: tuple
    sway: float
    hike: float
    pelvis: tuple
    low: tuple
    low_before: tuple = (0.0, 0.0)


LEAD = Crossing(
    time=0.95,
    before=0.235,
    past=0.110,
    instants=(0.25, 0.49, 0.61, 0.73),
    x=((-0.51, -0.225, -0.06, 0.105),) * 2,
    lift=((-0.14, 0.0, 0.0, 0.0), (-0.24, 0.0, 0.0, 0.0)),
    dorsiflexion=tuple(np.radians((3.0, 22.0, 18.0, 8.0, 5.0))),
    aside=0.065,
    out=np.radians(10.0),
    vault=((0.62, np.radians(-9.0)), (0.20, np.radians(-14.0))),
    sway=0.045,
    hike=np.radians(14.0),
    pelvis=(
        (0.25, 0.60, 0.0, 0.910, 0.895),
        (0.50, 1.00, -0.015, 0.957, 0.9122),
        (0.75, 0.75, 0.010, 0.942, 0.895),
    ),
    low=(-0.005, -0.010),
    low_before=(-0.004, -0.002),
)
TRAIL = LEAD._replace(
    instants=(0.15, 0.32, 0.44, 0.55, 0.66),
    x=((-0.33, -0.19, -0.05, 0.05, 0.18), (-0.44, -0.44, -0.22, -0.02, 0.16)),
    lift=((-0.14, -0.04, 0.0, 0.0, 0.0), (-0.40, -0.15, -0.03, 0.02, 0.0)),
    dorsiflexion=tuple(np.radians((-12.0, -5.0, 5.0, 12.0, 15.0, 8.0))),
    aside=0.10,
    out=np.radians(20.0),
    pelvis=(
        (0.25, 0.60, 0.005, 0.910, 0.895),
        (0.50, 1.00, 0.015, 0.957, 0.9122),
        (0.75, 0.75, 0.005, 0.937, 0.895),
    ),
    low=(-0.010, -0.004),
)


def _between(pair, height):
    """Values for this height from those over 0.1 and over 0.5 m."""
    low, high = np.array(pair)
    return low + max(0.0, (height - 0.1) / 0.4) * (high - low)


def turned_out(
    ways: Sequence[tuple[Crossing, Sequence[Footfall]]], side: str, share: float, t: np.ndarray
) -> np.ndarray:
    """Turn (n,) [rad] of a leg outward at times t, positive to the left; two derivatives smooth.

    ways : list of (Crossing, (footfall before, footfall after)); share : of its `out`.
    """
    turn = np.zeros(len(t))
    for way, (begin, end) in ways:
        s = np.clip((t - begin.off) / (end.strike - begin.off), 0.0, 1.0)
        turn += SIGN[side] * share * way.out * (4 * s * (1 - s)) ** 3
    return turn


def cross(
    way: Crossing,
    falls: Sequence[Footfall],
    side: str,
    steps: Footsteps,
    hips: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]],
) -> Swing:
    """Swing over the obstacle between two footfalls.

    Parameters
    ----------
    way : Crossing
    falls : the footfalls before and after
    side : 'right' or 'left'
    steps : Footsteps, of which count front, depth, height [m] of the obstacle and share, 0 to 1
    hips : function of times (n,): mid hip and axes left, ahead, up of the pelvis, (n, 3) each
    """
    begin, end = falls
    at = np.array(way.instants)
    at_pitch = np.append(at, LAST)
    x = steps.front + _between(way.x, steps.height)
    x[-1] += steps.depth - 0.06  # the knots are those of an obstacle of 0.06 m
    y = begin.aside + SIGN[side] * way.aside * steps.share
    s = np.linspace(0.0, 1.0, SAMPLES)
    t = begin.off + s * (end.strike - begin.off)
    middle, left, ahead, _ = hips(t)
    hip = middle + SIGN[side] * 0.5 * HIP_SPACING * left
    turn = turned_out([(way, falls)], side, steps.share, t)
    axis = np.cos(turn)[:, None] * left - np.sin(turn)[:, None] * ahead
    pitch = np.append(np.full(len(at), np.radians(-40.0)), 0.0)
    under = -turned(sole(), pitch[:1])[0, :, 1].min()
    z = steps.height + CLEARANCE + under + _between(way.lift, steps.height)
    for _ in range(ROUNDS):
        swing = Swing((at, x), (at, z), (at_pitch, pitch), ((0.5,), (y,)))
        ankle, pitches = track(falls, [swing], t)
        _, shank = leg_points(hip, ankle, axis, LENGTHS["thigh"], LENGTHS["shank"], side)
        # without gaps, see synthetic_walk.py
        forward, _, up = np.ascontiguousarray((shank[:, 1] - shank[:, 0]).T)
        hang = np.interp(at_pitch, s, np.arctan2(forward, -up))
        points = ankle[:, None, [0, 2]] + turned(sole(), pitches)
        over = (points[..., 0] > steps.front) & (points[..., 0] < steps.front + steps.depth)
        z = z + RELAXED * (CLEARANCE + steps.height - points[..., 1][over].min())
        pitch = pitch + RELAXED * (hang + np.array(way.dorsiflexion) - pitch)
    return swing
