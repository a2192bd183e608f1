# SPDX-License-Identifier: LGPL-3.0-or-later
"""Mending tracks of markers: gaps, spikes, noise. What is changed is said in notes."""

from collections.abc import Mapping

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import butter, sosfiltfilt

from shellform.errors import Mendable
from shellform.motion.recording import SIDES

SPIKE = 0.010  # smallest jump taken for an error of the cameras [m]
OVER_NOISE = 12.0  # and by how much it must exceed the track's own noise
PASSES = 8
LASTING = 0.1  # from which on a jump that stays is not bridged [m]
JERK = 5e3  # of limbs, not reached [m/s^3]: tells how far a way may be from an even one


def runs(bad: np.ndarray) -> list[tuple[int, int]]:
    """First and last + 1 of every run of True in bad (n,)."""
    edges = np.diff(np.concatenate([[False], bad, [False]]).astype(int))
    return list(zip(np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)))


def common_span(
    tracks: Mapping[str, np.ndarray],
) -> tuple[int, int, tuple[str, ...], tuple[str, ...]]:
    """First and last + 1 frame in which all tracks are there, and who lacks before and after.

    Parameters
    ----------
    tracks : dict, name -> (n, 3) float, NaN in gaps

    Returns
    -------
    first, stop : int; equal where no frame has them all
    early, late : tuple of str, markers that are seen later or lost earlier than the others
    """
    there = {name: np.flatnonzero(np.isfinite(t).all(axis=1)) for name, t in tracks.items()}
    starts = {name: int(k[0]) for name, k in there.items() if len(k)}
    stops = {name: int(k[-1]) + 1 for name, k in there.items() if len(k)}
    n = len(next(iter(tracks.values())))
    first, stop = max(starts.values()), min(stops.values())
    early = tuple(name for name, k in starts.items() if k == first and first > 0)
    late = tuple(name for name, k in stops.items() if k == stop and stop < n)
    return first, max(first, stop), early, late


def filled(
    track: np.ndarray, name: str, times: np.ndarray, max_gap: float, source: str = "markers"
) -> tuple[np.ndarray, list[str]]:
    """A track without gaps, by the cubic spline through all frames that are there.

    Parameters
    ----------
    track : (n, 3) float [m], NaN in gaps; its first and last frame are there
    name : str, for messages
    times : (n,) float [s]
    max_gap : float, longest gap that is filled [s], counted in frames that lack

    Returns
    -------
    track (n, 3), notes (list of str, without the name)

    Raises
    ------
    ValueError
        When a gap is longer, naming marker and time.
    """
    bad = ~np.isfinite(track).all(axis=1)
    if not bad.any():
        return track, []
    step = (times[-1] - times[0]) / (len(times) - 1)
    notes = []
    for first, stop in runs(bad):
        gap = (stop - first) * step
        if gap > max_gap + 1e-9:
            raise Mendable(
                f"{source}: marker '{name}' lacks from t = {times[first]:.3f} s for {gap:.3f} s, "
                f"longer than max_gap = {max_gap:g} s",
                "fill it, raise {max_gap}, or cut the capture with {window}",
            )
        notes.append(f"filled at t = {times[first]:.3f} s for {1e3 * gap:.0f} ms")
    out = track.copy()
    good = ~bad
    if good.sum() < 4:
        raise ValueError(f"{source}: marker '{name}' is seen in {good.sum()} frames; 4 are needed")
    out[bad] = CubicSpline(times[good], track[good])(times[bad])
    return out, notes


def off_neighbours(track: np.ndarray) -> np.ndarray:
    """Distance (n,) [m] of each place from the cubic through two neighbours on either side.

    At the ends, where those lack, 0.
    """
    out = np.zeros(len(track))
    if len(track) > 4:
        before, after = track[:-4] - 4 * track[1:-3], track[4:] - 4 * track[3:-1]
        out[2:-2] = np.linalg.norm(track[2:-2] + (before + after) / 6.0, axis=1)
    return out


def _joined(bad, longest):
    """Runs of True in bad (n,) joined with what is between them, up to `longest` frames."""
    out, begin = bad.copy(), None
    for first, stop in runs(bad):
        if begin is not None and stop - begin <= longest:
            out[begin:stop] = True
        else:
            begin = first
    return out


def jump_over(track: np.ndarray, first: int, stop: int, step: float) -> tuple[float, float]:
    """How far a track goes on aside of where it came from, over the frames first to before stop.

    The way from the three frames before to the three after is held against that of a motion whose
    velocity changes evenly; at the ends of the track, without three frames, nothing is told.

    Returns
    -------
    distance [m]; what of it a person's motion may have done [m]
    """
    if first < 3 or stop > len(track) - 3:
        return 0.0, 0.0
    before, after = track[first - 3 : first], track[stop : stop + 3]
    between = (stop - first + 3) * step
    speed = (before[2] - before[0] + after[2] - after[0]) / (4 * step)
    way = after.mean(axis=0) - before.mean(axis=0)
    return float(np.linalg.norm(way - between * speed)), JERK * between**3 / 12


def without_spikes(
    track: np.ndarray, name: str, times: np.ndarray, max_gap: float, source: str = "markers"
) -> tuple[np.ndarray, list[str]]:
    """A track whose frames far from their neighbours are replaced by the spline through the rest.

    A frame is a spike when it stands off the cubic through its neighbours by 10 mm, by 12 times the
    median over the track, and by more than limbs do by themselves (JERK). Frames between two spikes
    go with them if all is no longer than `max_gap`: they are off as well. A small jump that stays
    is bridged and told; noise goes on.

    Parameters
    ----------
    track : (n, 3) float [m], no gaps
    name : str, for messages
    times : (n,) float [s]
    max_gap : float [s], longest run of frames that is replaced

    Returns
    -------
    track (n, 3), notes (list of str)

    Raises
    ------
    ValueError
        When the marker jumps by 0.1 m or more and does not come back.
    """
    bad = np.zeros(len(track), bool)
    out, largest, stays = track, 0.0, ""
    step = (times[-1] - times[0]) / (len(times) - 1)
    # at few frames a second a motion itself stands off: its jerk may turn around in two frames
    moved = JERK * step**3 / 3
    limit = max(SPIKE, OVER_NOISE * float(np.median(off_neighbours(track))), moved)
    for _ in range(PASSES):
        off = off_neighbours(out)
        off[bad] = 0.0
        peak = off > limit
        if not peak.any():
            break
        largest = max(largest, float(off.max()))
        more = _joined(bad | peak, round(max_gap / step))
        if not bad.any():
            for first, stop in runs(more):
                aside, may_be = jump_over(track, first, stop, step)
                if aside > max(LASTING, limit) + may_be:
                    raise Mendable(
                        f"{source}: marker '{name}' jumps by {1e3 * aside:.4g} mm at t = "
                        f"{times[first]:.3f} s and stays there, as where two captures are joined "
                        "or labels change",
                        "correct it, or cut the capture with {window}",
                    )
                if aside > limit + may_be:
                    stays += f", it stays {1e3 * aside:.0f} mm aside from t = {times[first]:.3f} s"
        if max(stop - first for first, stop in runs(more)) * step > max_gap:
            break  # no spike any more; what is mended so far stays
        bad = more
        out = track.copy()
        out[bad] = CubicSpline(times[~bad], track[~bad])(times[bad])
    notes = [
        f"'{name}' jumps at t = {times[first]:.3f} s, up to {1e3 * largest:.4g} mm off its "
        f"neighbours: {stop - first} frames replaced"
        for first, stop in runs(bad)
    ]
    if notes:
        notes[-1] += stays
    return out, notes


def low_pass(track: np.ndarray, rate: float, cutoff: float) -> np.ndarray:
    """A track without what is faster than `cutoff`, not shifted in time.

    A Butterworth filter of order 2 forward and back, its cutoff raised by 1/0.802 so that both
    passes together damp by 3 dB at `cutoff` (Winter, Biomechanics and Motor Control, 2009, 2.2.4).

    Parameters
    ----------
    track : (n, ...) float, evenly spaced
    rate, cutoff : float [Hz]; cutoff below 0.4 rate
    """
    corner = min(cutoff / 0.802, 0.499 * rate)
    sections = butter(2, corner, fs=rate, output="sos")
    pad = min(len(track) - 1, int(2 * rate / cutoff))
    return sosfiltfilt(sections, track, axis=0, padlen=pad)


def rigid_legs(points: Mapping[str, np.ndarray]) -> tuple[dict[str, np.ndarray], float]:
    """Knees and ankles moved as little as it takes for thighs and shanks of constant length.

    Skin slides over the joints by some mm, bones do not stretch. The lengths are the medians; the
    hip stays; corrections go along the segments by turns, halved between knee and ankle in the
    shank, until both lengths are met (the projection known as SHAKE). M moves with its joint.

    Parameters
    ----------
    points : dict, segment -> (n, 3, 3) float [m], as in `shellform.motion.recording.Recording`

    Returns
    -------
    points, moved: the largest shift of a joint centre [m]
    """
    out, moved = dict(points), 0.0
    for side in SIDES:
        thigh, shank = points.get(f"{side}_thigh"), points.get(f"{side}_shank")
        if thigh is None or shank is None or not np.allclose(thigh[:, 1], shank[:, 0], atol=1e-9):
            continue
        hip, knee, ankle = thigh[:, 0], thigh[:, 1], shank[:, 1]
        above, below = (
            np.median(np.linalg.norm(t[:, 1] - t[:, 0], axis=1)) for t in (thigh, shank)
        )
        for _ in range(200):
            leg = knee - hip
            long = np.linalg.norm(leg, axis=1, keepdims=True)
            knee = knee + (above / long - 1.0) * leg
            calf = ankle - knee
            far = np.linalg.norm(calf, axis=1, keepdims=True)
            knee, ankle = (
                knee - 0.5 * (below / far - 1) * calf,
                ankle + 0.5 * (below / far - 1) * calf,
            )
            if max(np.abs(long - above).max(), np.abs(far - below).max()) < 1e-12:
                break
        shift = knee - thigh[:, 1], ankle - shank[:, 1]
        moved = max(moved, *(float(np.linalg.norm(s, axis=1).max()) for s in shift))
        out[f"{side}_thigh"] = np.stack([hip, knee, thigh[:, 2] + shift[0]], axis=1)
        out[f"{side}_shank"] = np.stack([knee, ankle, shank[:, 2] + shift[1]], axis=1)
    return out, moved
