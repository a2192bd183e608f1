# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a walk says about itself: heel strikes, stride length, cadence, heading, stature.

Heel strike is where the heel, once it was farthest in front of the pelvis (Zeni, Richards,
Higginson, Gait & Posture 27, 2008, 710-714), has stopped to sink. The latter matters where the foot
still comes down, as over an obstacle: strikes of known walks come from 0.2 to 0.04 s.
A stride length is the way between two strikes of one foot: the
straight line, prolonged to an arc where the walker turns; on a treadmill the belt's way is added.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy.signal import find_peaks

from shellform.motion.proportions import LEG_OF_STATURE
from shellform.motion.recording import SIDES

SHORTEST = 0.5  # of two strikes of one foot [s]
SWING = 0.25  # least reach between heel in front and heel behind that is a step [m]
SINKING = 0.2  # a heel that sinks faster is not yet down [m/s]
DOWN = 0.3  # it is down so long after it was farthest in front, at most [s]
BELT = 0.3  # speed of a foot at rest above which the ground moves [m/s]


def facts(times: np.ndarray, points: Mapping[str, np.ndarray]) -> dict[str, Any]:
    """Facts of a walk; a key lacks where the motion does not tell.

    Parameters
    ----------
    times : (n,) float [s]
    points : dict, segment -> (n, 3, 3) float [m], as in `shellform.motion.recording.Recording`

    Returns
    -------
    dict: "stride_length" [m] and "stride_time" [s], medians; "strides", their number, 0 where they
    are taken from the repetition of the posture; "cadence" [steps/min]; "speed" [m/s]; "heading"
    [rad], of the pelvis, from x toward y; "turn" [rad], its change from the first stride to the
    last; "belt_speed" [m/s] on a treadmill; "stature" [m], from the legs; "events", pairs (name,
    time [s])
    """
    out: dict[str, Any] = {}
    lengths = {
        name: np.median(np.linalg.norm(t[:, 1] - t[:, 0], axis=1)) for name, t in points.items()
    }
    legs = [lengths[f"{s}_thigh"] + lengths[f"{s}_shank"] for s in SIDES if f"{s}_shank" in lengths]
    if legs:
        out["stature"] = float(np.mean(legs) / LEG_OF_STATURE)
    if "pelvis" not in points:
        return out
    pelvis = points["pelvis"]
    ahead = forward(pelvis)
    x, y = np.ascontiguousarray(ahead[:, :2].T)  # without gaps, see synthetic_walk.py
    angle = np.unwrap(np.arctan2(y, x))
    out["heading"] = float(np.median(angle))
    heels = {
        s: points[f"{s}_foot"][:, 0] if f"{s}_foot" in points else points[f"{s}_shank"][:, 1]
        for s in SIDES
        if f"{s}_foot" in points or f"{s}_shank" in points
    }
    strikes = {s: heel_strikes(times, heel, pelvis) for s, heel in heels.items()}
    events = [(f"{s}_heel_strike", float(times[k])) for s in heels for k in strikes[s]]
    out["events"] = tuple(sorted(events, key=lambda event: event[1]))
    strides = [
        stride(times, heels[s], angle, a, b)
        for s in heels
        for a, b in zip(strikes[s], strikes[s][1:])
    ]
    period = 0 if strides or not events else repetition(times, heels, pelvis)
    if period:  # not two strikes of one foot
        way, seconds = _way(pelvis[:, 0], angle, period), times[period] - times[0]
        strides = [(way, seconds, 0.0)] if way > BELT * seconds else []
    if strides:
        length, seconds, belt = np.median(np.array(strides), axis=0)
        out["strides"] = 0 if period else len(strides)
        out["stride_length"], out["stride_time"] = float(length), float(seconds)
        out["cadence"], out["speed"] = float(120.0 / seconds), float(length / seconds)
        if belt > BELT:
            out["belt_speed"] = float(belt)
        one = np.searchsorted(times - times[0], seconds)  # a stride's mean is free of its sway
        if len(times) > 1.5 * one:
            out["turn"] = float(angle[-one:].mean() - angle[:one].mean())
    return out


def forward(pelvis: np.ndarray) -> np.ndarray:
    """Horizontal direction (n, 3) from J1 to M of the pelvis."""
    ahead = (pelvis[:, 2] - pelvis[:, 0]) * [1.0, 1.0, 0.0]
    return ahead / np.linalg.norm(ahead, axis=1, keepdims=True)


def heel_strikes(times: np.ndarray, heel: np.ndarray, pelvis: np.ndarray) -> np.ndarray:
    """Frames of the heel strikes, by the rule above.

    Parameters
    ----------
    times : (n,) float [s]
    heel : (n, 3) float [m]
    pelvis : (n, 3, 3) float, its J1, J2, M [m]
    """
    reach = np.sum((heel - pelvis[:, 0]) * forward(pelvis), axis=1)
    if np.ptp(reach) < SWING:
        return np.array([], int)
    step = (times[-1] - times[0]) / (len(times) - 1)
    middle = 0.5 * (reach.max() + reach.min())
    apart = max(1, round(SHORTEST / step))
    peaks = find_peaks(reach, height=middle, prominence=0.2 * SWING, distance=apart)[0]
    sinking = np.append(np.diff(heel[:, 2]) < -SINKING * step, False)
    return np.array([_landed(sinking, k, round(DOWN / step)) for k in peaks], int)


def _landed(sinking, peak, longest):
    """The first frame from `peak` on in which the heel does not sink; `peak` if it takes longer."""
    still = np.flatnonzero(~sinking[peak : peak + longest + 1])
    return peak + still[0] if len(still) else peak


def repetition(times: np.ndarray, heels: Mapping[str, np.ndarray], pelvis: np.ndarray) -> int:
    """Frames after which the heels stand to the pelvis as before; 0 where no time between
    0.6 and 2 s does it to a quarter of their motion.

    Needs a quarter of a second more than that time.
    """
    ahead = forward(pelvis)
    axes = np.stack([ahead, np.cross([0.0, 0.0, 1.0], ahead)], axis=1)
    q = [np.einsum("nij,nj->ni", axes, heel - pelvis[:, 0]) for heel in heels.values()]
    q = np.concatenate(q, axis=1)
    step = (times[-1] - times[0]) / (len(times) - 1)
    first, last = round(0.6 / step), min(round(2.0 / step), len(times) - round(0.25 / step))
    if last - first < 3:
        return 0
    tries = np.arange(first, last)
    off = [np.sqrt(np.mean(np.sum((q[k:] - q[:-k]) ** 2, axis=1))) for k in tries]
    best = int(np.argmin(off))
    motion = np.sqrt(np.sum(np.var(q, axis=0)))
    inner = 0 < best < len(tries) - 1
    return int(tries[best]) if inner and off[best] < 0.25 * motion else 0


def _way(track, angle, period):
    """Median horizontal way over `period` frames, along the arc [m]."""
    half = 0.5 * np.abs(angle[period:] - angle[:-period])
    return float(
        np.median(np.linalg.norm((track[period:] - track[:-period])[:, :2], axis=1) * _arc(half))
    )


def _arc(half):
    """Arc over chord for half the angle [rad] turned."""
    half = np.clip(half, 1e-6, 0.5 * np.pi)
    return half / np.sin(half)


def stride(
    times: np.ndarray, heel: np.ndarray, angle: np.ndarray, a: int, b: int
) -> tuple[float, float, float]:
    """Length [m], duration [s] and speed of the belt [m/s] of the stride from frame a to b.

    `angle` (n,) is the unwrapped heading [rad]. The foot is at rest from 12 to 28 % of the stride,
    walking or running.
    """
    seconds = times[b] - times[a]
    first, last = a + round(0.12 * (b - a)), a + round(0.28 * (b - a))
    last = max(last, first + 1)  # at a few frames a second both are one
    rest = (heel[last] - heel[first])[:2] / (times[last] - times[first])
    belt = float(np.linalg.norm(rest))
    way = (heel[b] - heel[a])[:2] - (rest * seconds if belt > BELT else 0.0)
    arc = _arc(0.5 * abs(angle[b] - angle[a]))
    return float(np.linalg.norm(way) * arc), float(seconds), belt
