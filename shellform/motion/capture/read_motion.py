# SPDX-License-Identifier: LGPL-3.0-or-later
"""Body from motion: a capture file becomes J1, J2, M of every segment (Eq. 17).

    recording = read_motion("walk.c3d")
    recording.notes   # what was detected and repaired
    recording.facts   # stride length, cadence, heading, stature

File -> `Markers` (metres, z up) -> a `SegmentMap` that fits -> gaps, spikes, mirrored labels ->
points of the segments -> low pass -> `shellform.motion.recording.Recording`.
"""

import numpy as np
from scipy.spatial.transform import Rotation

from contact.body.segment_frame import pose_from_markers
from shellform.motion.recording import SIDES, Recording

from .formats import read_table
from .gait_events import facts, forward
from .gaps_and_spikes import common_span, filled, low_pass, rigid_legs, without_spikes
from .joint_centres import point
from .map_fitting import choose_map, labels_on_body, plan
from .markers import Markers, to_markers
from .noise import told
from .segment_map import SegmentMap, segment_map

LEVER = 0.010  # least distance of M from the line J1-J2 [m]
FASTEST = 30.0  # a kicking foot moves at 20 to 25 m/s

__all__ = [
    "Markers",
    "SegmentMap",
    "choose_map",
    "read_markers",
    "read_motion",
    "recording",
    "segment_map",
]


def read_motion(
    path, map=None, unit=None, up=None, cutoff=6.0, max_gap=0.1, window=None, rigid=True
):
    """A capture file as a `Recording`: `read_markers`, then `recording`."""
    return recording(read_markers(path, unit, up), map, max_gap, cutoff, window, rigid)


def read_markers(path, unit=None, up=None):
    """Markers of a TRC, CSV or C3D file.

    Parameters
    ----------
    path : str or Path
    unit : "mm", "cm", "m" or None for what the file says
    up : "y", "z" or None: from the markers, else from the file. A file with y up is turned by
        (x, y, z) -> (x, -z, y); nothing else is turned

    Raises
    ------
    ValueError
        One sentence with file, place and mend: a file that is cut off or malformed, a unit that
        no person fits, a vertical that is not clear.
    ImportError
        When a C3D file is asked for and ezc3d is not installed.
    """
    raw = read_table(path)
    return to_markers(raw, str(path), labels_on_body(raw.names), unit, up)


def recording(markers, map=None, max_gap=0.1, cutoff=6.0, window=None, rigid=True):
    """Tracks of the segments' points from markers.

    Parameters
    ----------
    markers : Markers
    map : SegmentMap, name of a shipped one, path of a TOML file, or None for one that fits
    max_gap : float, longest gap filled [s]
    cutoff : float, of the zero-phase low pass on the points [Hz], or None
    window : (start, end) [s] on the capture's clock, or None for all of it
    rigid : bool, whether thighs and shanks get their median lengths (`rigid_legs`) and the pelvis
        is set `upright`

    Raises
    ------
    ValueError
        When a marker lacks or jumps, a gap is longer, labels are mixed up, the frames are too few a
        second for the cutoff, nobody moves that fast, or M lies within 10 mm of J1-J2.
    """
    source = markers.source
    if map is None:
        map = choose_map(markers)
    elif not isinstance(map, SegmentMap):
        map = segment_map(map)
    chosen = plan(map, markers)
    notes = [*markers.notes, f"map '{map.name}'", *chosen.notes]
    times, tracks, said = _cut(markers, chosen.labels, window)
    notes += said
    gaps = {}  # of one time together
    for name, track in tracks.items():
        label = chosen.labels[name]
        track, said = filled(track, label, times, max_gap, source)
        for note in said:
            gaps.setdefault(note, []).append(label)
        tracks[name], said = without_spikes(track, label, times, max_gap, source)
        notes += said
    notes += [f"{note}: {', '.join(labels)}" for note, labels in gaps.items()]
    notes += told(tracks, chosen.labels, markers.rate, cutoff)
    points = _evaluate(chosen, tracks)
    if mirrored(points):
        tracks = {_other(name, tracks): track for name, track in tracks.items()}
        points = _evaluate(chosen, tracks)
        notes.append("left and right are mirrored: labels swapped")
    _require_sides(points, source)
    if cutoff is not None:
        if not 0 < cutoff < 0.4 * markers.rate:
            raise ValueError(
                f"{source}: cutoff must lie between 0 and {0.4 * markers.rate:.4g} Hz at "
                f"{markers.rate:.4g} frames a second, not {cutoff:g} Hz: lower it, as far as the "
                "motion is slow, or None to filter nothing"
            )
        points = {name: low_pass(track, markers.rate, cutoff) for name, track in points.items()}
        notes.append(f"points low-passed at {cutoff:g} Hz")
    if rigid:
        points, moved = rigid_legs(points)
        notes.append(f"joints moved by up to {1e3 * moved:.1f} mm to keep the bones' lengths")
    if rigid and "pelvis" in points:
        points["pelvis"], lean = upright(points["pelvis"])
        notes.append(f"pelvis set upright: its landmarks lean by {np.degrees(lean):.0f} degrees")
    _require_lever(points, times, source)
    _require_pace(points, times, source)
    return Recording(times, points, source, tuple(notes), facts(times, points))


def _cut(markers, labels, window):
    """Times, tracks by the map's names and notes of the frames that have all of them."""
    times, source, notes = markers.times, markers.source, []
    use = np.ones(len(times), bool)
    if window is not None:
        use = (times >= window[0] - 1e-9) & (times <= window[1] + 1e-9)
        if use.sum() < 2:
            raise ValueError(
                f"{source}: window {tuple(window)} s holds {use.sum()} frames; the capture runs "
                f"from {times[0]:.3f} to {times[-1]:.3f} s"
            )
    times = times[use]
    tracks = {name: markers.track(label)[use].copy() for name, label in labels.items()}
    for name, track in tracks.items():
        if not np.isfinite(track).all(axis=1).any():
            raise ValueError(
                f"{source}: marker '{labels[name]}' is not seen between {times[0]:.3f} and "
                f"{times[-1]:.3f} s; take another window or map"
            )
    first, stop, early, late = common_span(tracks)
    if stop - first < 2:
        names = ", ".join(f"'{labels[n]}'" for n in (*early, *late))
        raise ValueError(f"{source}: no two frames have all markers needed; {names} lack most")
    if first:
        who = ", ".join(labels[n] for n in early)
        notes.append(f"starts at t = {times[first]:.3f} s, {first} frames late, for lack of {who}")
    if stop < len(times):
        who = ", ".join(labels[n] for n in late)
        notes.append(
            f"ends at t = {times[stop - 1]:.3f} s, {len(times) - stop} frames early, for lack of "
            f"{who}"
        )
    return times[first:stop], {n: t[first:stop] for n, t in tracks.items()}, notes


def _evaluate(chosen, tracks):
    at = dict(tracks)
    for name, rule in chosen.rules.items():
        at[name] = point(rule, at)
    return {
        segment: np.stack([at[end] for end in ends], axis=1)
        for segment, ends in chosen.segments.items()
    }


def _other(name, names):
    """The name of the same marker on the other side, where there is one."""
    for side, other in (SIDES, SIDES[::-1]):
        if name.startswith(f"{side}_") and (twin := other + name[len(side) :]) in names:
            return twin
    return name


def mirrored(points):
    """Whether right hip minus left, crossed with the pelvis' forward direction, points down.

    True for labels of the wrong side, and for a file whose axes are left-handed: for a body these
    are the same.
    """
    if not {"pelvis", "right_thigh", "left_thigh"} <= points.keys():
        return False
    across = points["right_thigh"][:, 0] - points["left_thigh"][:, 0]
    return bool(np.median(np.cross(across, forward(points["pelvis"]))[:, 2]) < 0)


def upright(pelvis):
    """Points (n, 3, 3) of a pelvis with e1 upright in the median, and the lean taken away [rad].

    The middle of the pelvis' markers is not above the hip centres: e1 of the landmarks leans by 20
    to 30 degrees in a wearer who stands. J1 and M are turned about J2 and e3, one angle for all
    frames.
    """
    _, axes = pose_from_markers(pelvis[:, 0], pelvis[:, 1], pelvis[:, 2])
    high, low = np.ascontiguousarray(axes[:, [1, 0], 2].T)  # without gaps, see synthetic_walk.py
    lean = float(np.median(np.arctan2(high, -low)))
    turn = Rotation.from_rotvec(-lean * axes[:, 2])
    turned = pelvis.copy()
    for k in (0, 2):
        turned[:, k] = pelvis[:, 1] + turn.apply(pelvis[:, k] - pelvis[:, 1])
    return turned, lean


def _require_sides(points, source):
    """Refuse knees and feet on the wrong side, and toes behind the heels."""
    if not {"pelvis", "right_thigh", "left_thigh"} <= points.keys():
        return
    ahead = forward(points["pelvis"])
    right = np.cross(ahead, [0.0, 0.0, 1.0])
    for part in ("thigh", "shank"):
        pair = [points.get(f"{side}_{part}") for side in SIDES]
        if pair[0] is None or pair[1] is None:
            continue
        apart = np.median(np.sum((pair[0] - pair[1])[:, 1] * right, axis=1))
        if apart < 0:
            raise ValueError(
                f"{source}: pelvis and legs disagree about right and left, as the end of "
                f"right_{part} is {-1e3 * apart:.0f} mm left of the other; swap these labels"
            )
        for side, track, sign in zip(SIDES, pair, (1, -1)):
            if np.median(np.sum((track[:, 2] - track[:, 1]) * right, axis=1)) * sign < 0:
                raise ValueError(
                    f"{source}: M of {side}_{part} lies inward of its joint; lateral and medial "
                    "labels are swapped"
                )
    for side in SIDES:
        foot = points.get(f"{side}_foot")
        if foot is not None and np.median(np.sum((foot[:, 1] - foot[:, 0]) * ahead, axis=1)) < 0:
            raise ValueError(
                f"{source}: the {side} toes are behind the heel; labels of heel and toe, or of "
                "front and back of the pelvis, are swapped"
            )


def _require_lever(points, times, source):
    for name, track in points.items():
        _, axes = pose_from_markers(track[:, 0], track[:, 1], track[:, 2])
        lever = np.sum((track[:, 2] - track[:, 0]) * axes[:, 1], axis=1)
        worst = int(np.argmin(lever))
        if lever[worst] < LEVER:
            raise ValueError(
                f"{source}: M of '{name}' is {1e3 * lever[worst]:.1f} mm off the line J1-J2 at t = "
                f"{times[worst]:.3f} s; at least {1e3 * LEVER:.0f} mm tell the turn about it, take "
                "another marker"
            )


def _require_pace(points, times, source):
    for name, track in points.items():
        speed = np.linalg.norm(np.diff(track, axis=0), axis=2) / np.diff(times)[:, None]
        frame = int(np.argmax(speed.max(axis=1)))
        if speed[frame].max() > FASTEST:
            raise ValueError(
                f"{source}: '{name}' moves at {speed[frame].max():.0f} m/s at t = "
                f"{times[frame]:.3f} s, and nobody is faster than {FASTEST:.0f} m/s; correct the "
                "rate or the markers, cut the capture with window=(start, end), or lower the cutoff"
            )
