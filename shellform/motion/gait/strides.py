# SPDX-License-Identifier: LGPL-3.0-or-later
"""Which part of a motion is walking, and the strides in it, from footfall to footfall.

A stride goes from a heel strike to the next one of the same foot (Perry, Gait Analysis, 1992), with
one strike of the other foot between them. Standing is no stride: nobody walks while no joint moves
faster than a sway does. What leads into the first frame of a capture, and standing before and after
the walk, does not count.
"""

import numpy as np

from shellform.motion.capture.gait_events import facts
from shellform.motion.recording import JOINTS, SIDES, Recording
from shellform.motion.wearer import Wearer

SWAY = 0.1  # joint centres of one who stands are slower [m/s]; those of quiet stance reach 0.03
PAUSE = 0.3  # a longer rest is standing [s]; in full stride some joint always moves
LONGEST = 2.5  # stride [s]; the synthetic walk steps over 0.5 m in 1.8 s


def side_of(joint: str) -> str:
    """Whose foot's strides a joint has: those of its side, of the trunk those of the right foot."""
    side = joint.partition("_")[0]
    return side if side in SIDES else SIDES[0]


def counted(motion: Recording | Wearer) -> tuple[float, float]:
    """Begin and end [s] of what counts: the motion's own frames without standing at both ends.

    Frames that `gait_initiation` has put before the first one do not count. All of its own frames
    count where nothing ever moves.

    Examples
    --------
    >>> walk = sf.synthetic_walk(strides=2, obstacle=0.0, stand=1.0)
    >>> begin, end = counted(walk)
    >>> bool(1.0 <= begin < 1.2 and end == walk.times[-1])
    True
    """
    recording = _recording(motion)
    times = recording.times[recording.first_frame :]
    moving = np.flatnonzero(~_still(recording))
    if not len(moving):
        return float(times[0]), float(times[-1])
    # an interval moves: from the frame at its begin to that at its end
    return float(times[moving[0]]), float(times[moving[-1] + 1])


def strides(motion: Recording | Wearer) -> dict[str, np.ndarray]:
    """Strides of each foot that lie in the counted part of a motion.

    Parameters
    ----------
    motion : Recording, or Wearer of one. Heel strikes are those of its facts, "events", where it
        has them, else they are looked for

    Returns
    -------
    dict: 'right' and 'left' -> (k, 2) float [s], begin and end of each stride on the motion's
    clock, that of a simulation too; k may be 0. Intervals with a rest of 0.3 s, without one strike
    of the other foot between, or longer than 2.5 s are no strides.

    Examples
    --------
    >>> walk = sf.synthetic_walk(strides=3, obstacle=0.0)
    >>> {side: len(found) for side, found in sf.strides(walk).items()}
    {'right': 2, 'left': 2}
    """
    recording = _recording(motion)
    begin, end = counted(recording)
    step = (recording.times[-1] - recording.times[0]) / (len(recording.times) - 1)
    strikes = {side: heel_strike_times(recording, side) for side in SIDES}
    rests = _rests(recording)
    found = {}
    for side, other in (SIDES, SIDES[::-1]):
        own = strikes[side]
        own = own[(own >= begin - 0.5 * step) & (own <= end + 0.5 * step)]
        pairs = np.clip(np.column_stack([own[:-1], own[1:]]), begin, end)
        found[side] = pairs[[_is_stride(begin, end, strikes[other], rests) for begin, end in pairs]]
    return found


def heel_strike_times(recording: Recording, side: str) -> np.ndarray:
    """Times (k,) [s] of a foot's heel strikes, in order; see `strides`."""
    events = recording.facts.get("events")
    if events is None:
        own = slice(recording.first_frame, None)
        points = {name: track[own] for name, track in recording.points.items()}
        events = facts(recording.times[own], points).get("events", ())
    return np.array(sorted(time for name, time in events if name == f"{side}_heel_strike"))


def _recording(motion):
    return motion.recording if isinstance(motion, Wearer) else motion


def _is_stride(begin, end, others, rests):
    """Whether a foot makes one stride between two of its strikes [s]."""
    between = np.count_nonzero((others > begin) & (others < end))
    lengths = np.minimum(end, rests[:, 1]) - np.maximum(begin, rests[:, 0])
    return between == 1 and end - begin <= LONGEST and not (lengths > PAUSE).any()


def _still(recording):
    """Intervals between the motion's own frames, (n - 1,) bool, in which all joints rest."""
    own = slice(recording.first_frame, None)
    segments = [joint for joint, (*_, (name, _)) in JOINTS.items() if name in recording.points]
    tracks = [recording.joint_centre(joint)[own] for joint in segments]
    tracks = tracks or [track[own, 0] for track in recording.points.values()]
    ways = np.linalg.norm(np.diff(tracks, axis=1), axis=2)
    return (ways < SWAY * np.diff(recording.times[own])).all(axis=0)


def _rests(recording):
    """Begin and end (k, 2) [s] of the rests between the motion's own frames."""
    times = recording.times[recording.first_frame :]
    still = np.concatenate([[False], _still(recording), [False]]).astype(int)
    change = np.diff(still)
    return np.column_stack([times[np.flatnonzero(change > 0)], times[np.flatnonzero(change < 0)]])
