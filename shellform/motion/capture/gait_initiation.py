# SPDX-License-Identifier: LGPL-3.0-or-later
"""The way from standing into the first frame of a recording, so that dressing can start at rest.

A capture begins in mid-stride. Frames are put before it in which the wearer, who stands still at
first, gets going and arrives in the first frame with its velocity: the pelvis along polynomials of
least jerk, every segment turning along a rotation vector from no spin to that of the first frame.

Segments keep together: each hangs at its hinge (hip, knee, ankle; the pelvis at its centre), whose
place in the axes of the segment above goes evenly from that of the standing pose to that of the
first frame, as do the segment's own points.
"""

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from contact.body.segment_frame import pose_from_markers
from shellform.motion.recording import JOINTS, Recording

ABOVE = {below: above for above, below, _ in JOINTS.values()}
HINGE = {below: hinge for _, below, hinge in JOINTS.values()}


def gait_initiation(
    recording: Recording, standing: Mapping[str, ArrayLike], seconds: float = 1.0
) -> Recording:
    """A recording with frames before its own in which the wearer gets going.

    Parameters
    ----------
    recording : Recording
    standing : dict, segment -> (3, 3), J1, J2, M of a standing pose [m]; it is moved over the floor
        to where half the speed of the first frame leads from it into that frame
    seconds : float [s]; 0 returns the recording as it is

    Raises
    ------
    ValueError for negative seconds or a standing pose that lacks a segment
    """
    if not seconds >= 0:
        raise ValueError(f"the way into the first frame takes 0 s or longer, not {seconds} s")
    missing = sorted(set(recording.points) - set(standing))
    if missing:
        raise ValueError(f"{recording.source}: the standing pose lacks {', '.join(missing)}")
    if seconds == 0:
        return recording
    count = max(2, round(seconds * recording.rate))
    s = np.arange(count) / count
    start = _taken_apart({name: np.asarray(standing[name], float) for name in recording.points})
    frames = [_taken_apart({n: p[k] for n, p in recording.points.items()}) for k in range(3)]
    h = recording.times[1] - recording.times[0]
    even = (s**3 * (10 - 15 * s + 6 * s**2))[:, None]

    places: dict[str, np.ndarray] = {}
    turns, points = {}, {}
    for name in _from_the_root(recording.points):
        turn, local, hinge = frames[0][name]
        first = start[name]
        vector = (first[0].inv() * turn).as_rotvec()
        # one-sided differences of second order; the spin in the segment's own axes
        one, two = ((turn.inv() * frame[name][0]).as_rotvec() for frame in frames[1:])
        rate = _rate_of_vector(vector, (4 * one - two) / (2 * h))
        way = _arrive(s, np.zeros(3), vector, rate * seconds)
        turns[name] = (first[0] * Rotation.from_rotvec(way)).as_matrix()
        above = ABOVE.get(name)
        if above is not None and above in recording.points:
            arm = first[2] + even * (hinge - first[2])
            places[name] = places[above] + np.einsum("nij,nj->ni", turns[above], arm)
        else:
            speed = (4 * frames[1][name][2] - 3 * hinge - frames[2][name][2]) / (2 * h)
            begin = hinge - 0.5 * seconds * speed
            begin[2] = first[2][2]
            places[name] = _arrive(s, begin, hinge, speed * seconds)
        own = first[1] + even[:, :, None] * (local - first[1])
        points[name] = places[name][:, None] + np.einsum("nij,npj->npi", turns[name], own)

    times = recording.times[0] - seconds * (1 - s)
    return Recording(
        np.concatenate([times, recording.times]),
        {name: np.concatenate([points[name], p]) for name, p in recording.points.items()},
        recording.source,
        (*recording.notes, f"{seconds:g} s from standing into the first frame put before it"),
        recording.facts,
        count,
    )


def _from_the_root(names):
    """Segments, each after the one it hangs at."""
    known = [name for name in names if ABOVE.get(name) not in names]
    for below, above in ABOVE.items():
        if below in names and above in names:
            known.append(below)
    return known


def _taken_apart(pose):
    """segment -> its turn (columns e1, e2, e3), its points from the hinge in its own axes (3, 3),
    and the hinge in the axes of the segment above, from that one's hinge; in the world for a root.
    """
    centres, axes, hinges = {}, {}, {}
    for name, points in pose.items():
        centres[name], axes[name] = pose_from_markers(*points)
        segment, end = HINGE.get(name, (None, 0))
        hinges[name] = pose[segment][end] if segment in pose else centres[name]
    parts = {}
    for name, points in pose.items():
        above = ABOVE.get(name)
        place = hinges[name]
        if above in pose:
            place = axes[above] @ (place - hinges[above])
        local = (points - hinges[name]) @ axes[name].T
        parts[name] = Rotation.from_matrix(axes[name].T), local, place
    return parts


def _arrive(s, begin, end, rate):
    """Quintic (n, 3) from rest at `begin` to `end` at the given rate per s; no acceleration there.

    s : (n,) float, 0 to 1
    """
    s = s[:, None]
    way = np.asarray(end) - begin
    return begin + way * s**3 * (10 - 15 * s + 6 * s**2) + rate * s**3 * (-4 + 7 * s - 3 * s**2)


def _rate_of_vector(vector, spin):
    """Rate of a rotation vector whose rotation spins with `spin` (3,) in the turned axes."""
    angle = np.linalg.norm(vector)
    if angle < 1e-8:
        return spin
    half = 0.5 * angle
    across = np.cross(vector, spin)
    factor = (1 - half / np.tan(half)) / angle**2
    return spin + 0.5 * across + factor * np.cross(vector, across)
