# SPDX-License-Identifier: LGPL-3.0-or-later
"""Body from motion: a capture file becomes J1, J2, M of every segment (Eq. 17).

    recording = read_motion("walk.c3d")
    recording.notes   # what was detected and repaired
    recording.facts   # stride length, cadence, heading, stature

File -> `Markers` (metres, z up) -> a `SegmentMap` that fits -> gaps, spikes, mirrored labels ->
points of the segments -> low pass -> `shellform.motion.recording.Recording`.
"""

from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from contact.body.segment_frame import pose_from_markers
from shellform.errors import Mendable
from shellform.motion.recording import SIDES, Recording

from .formats import read_table
from .gait_events import facts
from .gaps_and_spikes import filled, low_pass, rigid_legs, without_spikes
from .label_meanings import require_one_meaning
from .marker_sets import choose_map, regions, require_set, set_notes
from .markers import Markers, to_markers
from .noise import noise_note
from .seen_markers import seen
from .segment_checks import mirrored, require_lever, require_pace, require_shape, require_sides
from .segment_map import SegmentMap, segment_map, with_upper_body
from .static_trial import with_static

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
    file: str | Path,
    static: str | Path | None = None,
    map: SegmentMap | str | Path | None = None,
    unit: str | None = None,
    up: str | None = None,
    cutoff: float | None = 6.0,
    max_gap: float = 0.1,
    window: tuple[float, float] | None = None,
    rigid: bool = True,
    upper: bool = False,
) -> Recording:
    """A capture file as a `Recording`: `read_markers`, then `recording`; see these.

    Parameters
    ----------
    file : TRC, CSV, C3D or BVH file; unit, up : of its coordinates, where it does not tell
    static : file of a static trial with the markers that are taken off for the walk, see
        `shellform.motion.capture.static_trial`
    map : SegmentMap, name or file of one, None: the shipped one that explains most labels
    cutoff : of the low pass [Hz], None: none; max_gap : longest gap filled [s]
    window : (start, end) [s] of what is used; rigid : thighs and shanks keep their lengths
    upper : whether trunk and arms are read, where they have markers

    Returns
    -------
    Recording; `notes` says what was detected and repaired, `facts` the stride, cadence, stature

    Raises
    ------
    ValueError
        One sentence with file, place and mend.
    ImportError
        When a C3D file is asked for and ezc3d is not installed.

    Examples
    --------
    A capture whose markers are the points of the segments themselves, for which the map is short:

    >>> import numpy as np
    >>> from shellform.motion.capture.segment_map import SegmentMap
    >>> walk = sf.synthetic_walk(strides=2, obstacle=0.0)
    >>> ends = {name: {end: f"{name}.{end}" for end in ("J1", "J2", "M")} for name in walk.points}
    >>> labels = [label for segment in ends.values() for label in segment.values()]
    >>> head = ",".join(["time", *(f"{label}_{axis} [m]" for label in labels for axis in "xyz")])
    >>> tracks = np.hstack([track.reshape(-1, 9) for track in walk.points.values()])
    >>> table = np.column_stack([walk.times, tracks])
    >>> np.savetxt("walk.csv", table, delimiter=",", header=head, comments="")
    >>> mine = SegmentMap("mine", {label: (label,) for label in labels}, {}, ends)
    >>> again = sf.read_motion("walk.csv", map=mine, up="z")
    >>> again.notes[0]
    'up is z, as given'
    >>> f"{again.facts['stride_length']:.2f} m"
    '1.31 m'
    """
    if map is not None and not isinstance(map, SegmentMap):
        map = segment_map(map)
    raw = read_table(file, map)
    if map is None and static is None:
        require_set(raw.names, str(file))
    markers = to_markers(raw, str(file), regions(raw.names, map), unit, up)
    if static is not None:
        markers = with_static(markers, read_markers(static, unit, up, map), map)
    return recording(markers, map, max_gap, cutoff, window, rigid, upper)


def read_markers(
    path: str | Path,
    unit: str | None = None,
    up: str | None = None,
    map: SegmentMap | None = None,
) -> Markers:
    """Markers of a TRC, CSV or C3D file, joints of a BVH file.

    Parameters
    ----------
    path : str or Path
    unit : "mm", "cm", "m", the length of one in metres, or None for what the file says
    up : "y", "z" or None: from the markers, else from the file. A file with y up is turned by
        (x, y, z) -> (x, -z, y); nothing else is turned
    map : SegmentMap that says where its labels are on the body, None: the shipped one that fits

    Raises
    ------
    ValueError
        One sentence with file, place and mend: a file that is cut off or malformed, a unit that
        no person fits, a vertical that is not clear.
    ImportError
        When a C3D file is asked for and ezc3d is not installed.
    """
    raw = read_table(path, map)
    return to_markers(raw, str(path), regions(raw.names, map), unit, up)


def recording(
    markers: Markers,
    map: SegmentMap | str | Path | None = None,
    max_gap: float = 0.1,
    cutoff: float | None = 6.0,
    window: tuple[float, float] | None = None,
    rigid: bool = True,
    upper: bool = False,
) -> Recording:
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
    upper : bool, whether trunk and arms are made too, of the markers of `with_upper_body`

    Raises
    ------
    ValueError
        When a marker lacks or jumps, a gap is longer, labels are mixed up, the frames are too few a
        second for the cutoff, nobody moves that fast, or M lies within 10 mm of J1-J2.
    """
    source = markers.source
    if len(markers.times) < 2:
        raise Mendable(
            f"{source}: one frame is no motion",
            "pass a capture with two at least; one frame is enough as {static:standing.trc}",
        )
    if cutoff is not None and not 0 < cutoff < 0.4 * markers.rate:
        raise Mendable(
            f"{source}: cutoff must lie between 0 and {0.4 * markers.rate:.4g} Hz at "
            f"{markers.rate:.4g} frames a second, not {cutoff:g} Hz",
            "lower {cutoff}, as far as the motion is slow",
        )
    if map is None:
        map = choose_map(markers)
    elif not isinstance(map, SegmentMap):
        map = segment_map(map)
    if upper:
        map = with_upper_body(map)
    use = _window(markers, window)
    fitted, frames, said = seen(map, markers, use, max_gap)
    require_one_meaning(map, fitted.labels, markers)
    notes = [*markers.notes, *set_notes(map, markers.names), *fitted.notes, *said]
    times = markers.times[frames]
    tracks = {name: markers.track(label)[frames].copy() for name, label in fitted.labels.items()}
    tracks, said = _mended(tracks, fitted.labels, times, max_gap, source)
    notes += [*said, *noise_note(tracks, fitted.labels, markers.rate, cutoff)]
    with np.errstate(all="ignore"):  # markers that coincide are refused by what comes of them
        points = fitted.points(tracks)
    require_shape(points, times, source)
    notes += fitted.choices(tracks)
    if mirrored(points):
        tracks = {_other(name, tracks): track for name, track in tracks.items()}
        points = fitted.points(tracks)
        notes.append("left and right are mirrored: labels swapped")
    require_sides(points, source)
    if cutoff is not None:
        points = {name: low_pass(track, markers.rate, cutoff) for name, track in points.items()}
        notes.append(f"points low-passed at {cutoff:g} Hz")
    if rigid:
        points, moved = rigid_legs(points)
        notes.append(f"joints moved by up to {1e3 * moved:.1f} mm to keep the bones' lengths")
    require_shape(points, times, source)
    require_lever(points, times, source)
    if rigid and "pelvis" in points:
        points["pelvis"], lean = upright(points["pelvis"])
        notes.append(f"pelvis set upright: its landmarks lean by {np.degrees(lean):.0f} degrees")
    require_pace(points, times, source)
    return Recording(times, points, source, tuple(notes), facts(times, points))


def _mended(tracks, labels, times, max_gap, source):
    """Tracks without gaps and spikes, by the map's names, and notes of what was mended."""
    out, spikes = {}, []
    gaps = {}  # those of one time together
    for name, track in tracks.items():
        label = labels[name]
        track, said = filled(track, label, times, max_gap, source)
        for note in said:
            gaps.setdefault(note, []).append(label)
        out[name], said = without_spikes(track, label, times, max_gap, source)
        spikes += said
    return out, spikes + [f"{note}: {', '.join(names)}" for note, names in gaps.items()]


def _window(markers, window):
    """Frames (n,) bool of a window."""
    times = markers.times
    if window is None:
        return np.ones(len(times), bool)
    use = (times >= window[0] - 1e-9) & (times <= window[1] + 1e-9)
    if use.sum() < 2:
        raise Mendable(
            f"{markers.source}: window {tuple(window)} s holds {use.sum()} frames, and the capture "
            f"runs from {times[0]:.3f} to {times[-1]:.3f} s",
            "give another {window}",
        )
    return use


def _other(name, names):
    """The name of the same marker on the other side, where there is one."""
    for side, other in (SIDES, SIDES[::-1]):
        if name.startswith(f"{side}_") and (twin := other + name[len(side) :]) in names:
            return twin
    return name


def upright(pelvis: np.ndarray) -> tuple[np.ndarray, float]:
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
