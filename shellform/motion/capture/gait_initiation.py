# SPDX-License-Identifier: LGPL-3.0-or-later
"""The way from standing into the first frame of a recording, so that dressing can start at rest.

A capture begins in mid-stride. Frames are put before it in which the wearer, who stands still at
first, gets going and arrives in the first frame with its velocity and acceleration. Each angle of a
joint (`joint_coordinates`) takes the smoothest path (`smooth_path`) that keeps within its range of
motion and is no faster than in the capture by much; the pelvis follows so high that no foot goes
lower than in the capture or in standing. Where a second is too short for that, the way is longer.

Segments keep the lengths and hinges of the first frame; where these change there, as skin moves, so
they do for 0.05 s before.
"""

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from shellform.motion.joint_coordinates import (
    CHAIN,
    RANGE_OF_MOTION,
    coordinates,
    heading_axes,
    points_of,
)
from shellform.motion.recording import Recording
from shellform.motion.smooth_path import smooth_path

LEAST, MOST, LONGER = 1.0, 3.0, 0.25  # the way takes so long, and so much longer at a time [s]
FASTER = 1.3  # than the same joint in the capture
SLOW = np.radians(60.0)  # a joint may always be as fast [rad/s]
BEYOND = np.radians(10.0)  # the angles of the capture and of standing, where there is time for it
FADE = 0.05  # changes of length and hinge die away so long before the first frame [s]


def gait_initiation(
    recording: Recording, standing: Mapping[str, ArrayLike], seconds: float | None = None
) -> Recording:
    """A recording with frames before its own in which the wearer gets going.

    Parameters
    ----------
    recording : Recording of pelvis, thighs, shanks, perhaps feet
    standing : dict, segment -> (3, 3), J1, J2, M of a standing pose [m]; it is moved over the floor
        to where half the speed of the first frame leads from it into that frame
    seconds : float [s]; 0 returns the recording as it is; None: 1 s, or as much longer, up to 3 s,
        as joints need to be at most 1.3 times as fast as in the recording. Where a given time is
        too short for that they are faster, but within their ranges

    Returns
    -------
    Recording whose `first_frame` is that of the recording given

    Raises
    ------
    ValueError for negative seconds or a standing pose that lacks a segment

    Examples
    --------
    >>> from shellform.motion.gait.standing_pose import standing_of
    >>> walk = sf.synthetic_walk(strides=2, obstacle=0.0)
    >>> late = {name: track[150:] for name, track in walk.points.items()}
    >>> part = Recording(walk.times[150:], late)
    >>> full = gait_initiation(part, standing_of(part))
    >>> f"{full.times[0]:.2f} {full.times[full.first_frame]:.2f} s"
    '0.50 1.50 s'
    """
    if seconds is not None and not seconds >= 0:
        raise ValueError(f"the way into the first frame takes 0 s or longer, not {seconds} s")
    missing = sorted(set(recording.points) - set(standing))
    if missing:
        raise ValueError(f"{recording.source}: the standing pose lacks {', '.join(missing)}")
    if seconds == 0:
        return recording
    pose = {name: np.asarray(standing[name], float) for name in recording.points}
    way = _Way(recording, pose)
    if seconds is None:
        seconds = LEAST
        while not way.within(seconds) and seconds < MOST:
            seconds += LONGER
    times, points = way.frames(seconds)
    return Recording(
        np.concatenate([times, recording.times]),
        {name: np.concatenate([points[name], p]) for name, p in recording.points.items()},
        recording.source,
        (*recording.notes, f"{seconds:g} s from standing into the first frame put before it"),
        recording.facts,
        len(times),
    )


class _Way:
    """Angles, lengths and hinges at both ends of the way, and what bounds the angles."""

    def __init__(self, recording, pose):
        self.recording, self.pose = recording, pose
        self.base = heading_axes(pose["pelvis"])
        own = coordinates(recording.points, self.base)
        still = coordinates({name: p[None] for name, p in pose.items()}, self.base)
        self.names = [name for name in CHAIN if name in recording.points]
        self.begin = {name: still.angles[name][0] for name in self.names}
        few = slice(0, 4)
        t = recording.times[few] - recording.times[0]
        self.end = {name: _state(t, own.angles[name][few]) for name in self.names}
        self.arms = {name: _state(t, own.arms[name][few]) for name in self.names}
        self.local = {name: _state(t, own.local[name][few]) for name in self.names}
        self.tight, self.ample, self.fastest = {}, {}, {}
        peaks = {}
        for name in self.names:
            rate = np.abs(np.gradient(own.angles[name], recording.times, axis=0)).max(axis=0)
            kind = name.split("_")[-1]
            peaks[kind] = np.maximum(peaks.get(kind, SLOW), rate)
        for name in self.names:
            kind = name.split("_")[-1]
            ample = np.array(RANGE_OF_MOTION[kind])
            known = np.vstack([own.angles[name], still.angles[name]])
            near = np.stack([known.min(axis=0) - BEYOND, known.max(axis=0) + BEYOND], axis=1)
            tight = np.stack(
                [np.maximum(near[:, 0], ample[:, 0]), np.minimum(near[:, 1], ample[:, 1])], axis=1
            )
            self.tight[name], self.ample[name] = np.sort(tight, axis=1), ample
            self.fastest[name] = FASTER * peaks[kind]

    def within(self, seconds):
        """Whether all angles keep near those of the capture, and slow, in a time [s]."""
        times = np.linspace(-seconds, 0.0, 11)
        return all(
            self._path(times, name, k, self.tight, 1.0) is not None
            for name in self.names
            for k in range(3)
        )

    def _path(self, times, name, k, ranges, faster):
        end = tuple(state[k] for state in self.end[name])
        bounds = tuple(ranges[name][k])
        return smooth_path(times, self.begin[name][k], end, bounds, faster * self.fastest[name][k])

    def _angle(self, times, name, k):
        """The path of an angle (n,) [rad]: as slow, and as near to the capture's, as can be."""
        tries = ((self.tight, 1.0), (self.ample, 1.0), (self.ample, 2.0), (self.ample, np.inf))
        for ranges, faster in tries:
            path = self._path(times, name, k, ranges, faster)
            if path is not None:
                return path
        raise AssertionError("an angle without a bound on its rate has a path")

    def frames(self, seconds):
        """Times (n,) [s] and points, segment -> (n, 3, 3) [m], of the frames before the first."""
        recording = self.recording
        count = max(2, round(seconds * recording.rate))
        t = seconds * np.linspace(-1.0, 0.0, count + 1)
        angles = {
            name: np.stack([self._angle(t, name, k) for k in range(3)], axis=1)
            for name in self.names
        }
        arms = {name: _faded(t, self.arms[name]) for name in self.names}
        local = {name: _faded(t, self.local[name]) for name in self.names}
        arms["pelvis"] = self._places(t, seconds, angles, arms, local)
        points = points_of(angles, arms, local, self.base)
        times = recording.times[0] + t[:-1]
        return times, {name: track[:-1] for name, track in points.items()}

    def _places(self, t, seconds, angles, arms, local):
        """The pelvis's centre (n, 3) [m]."""
        value, rate, change = self.arms["pelvis"]
        begin = value - 0.5 * seconds * rate
        place = _arrival(t, seconds, begin, value, rate, change)
        level = {**arms, "pelvis": np.zeros_like(place)}
        hanging = _lowest(points_of(angles, level, local, self.base))
        floor = _lowest({name: p[None] for name, p in self.pose.items()})[0]
        low = min(floor, _lowest(self.recording.points).min())
        end = value[2], rate[2], change[2]
        height = smooth_path(t, floor - hanging[0], end, lowest=low - hanging)
        if height is not None:
            place[:, 2] = height
        return place


def _lowest(points):
    """Lowest point (n,) [m] of the feet in each frame; of the ankles where there are none."""
    feet = [track[..., 2] for name, track in points.items() if name.endswith("foot")]
    shanks = [track[:, 1:2, 2] for name, track in points.items() if name.endswith("shank")]
    return np.concatenate(feet or shanks, axis=1).min(axis=1)


def _state(t, values):
    """Value, rate, change of rate at t = 0 of the polynomial through values (n, ...) at t (n,)."""
    powers = np.linalg.inv(np.vander(t, increasing=True))
    terms = np.tensordot(powers, values, axes=1)
    return terms[0], terms[1], 2.0 * terms[2] if len(t) > 2 else 0.0 * terms[0]


def _faded(t, state):
    """Values (n, ...) at times t (n,) [s] up to 0 that arrive in a state from nearly its value."""
    value, rate, change = state
    s = np.clip(1.0 + t / FADE, 0.0, 1.0)
    t, s = (x.reshape(-1, *[1] * np.ndim(value)) for x in (t, s))
    return value + (rate * t + 0.5 * change * t * t) * s**3 * (10 - 15 * s + 6 * s**2)


def _arrival(t, seconds, begin, value, rate, change):
    """Quintic (n, 3) at t (n,), -seconds to 0, from rest at `begin` into a state."""
    s = (1.0 + t / seconds)[:, None]
    path = begin + (value - begin) * s**3 * (10 - 15 * s + 6 * s**2)
    path += rate * seconds * s**3 * (-4 + 7 * s - 3 * s**2)
    return path + 0.5 * change * seconds**2 * s**3 * (1 - s) ** 2
