# SPDX-License-Identifier: LGPL-3.0-or-later
"""A segment map set to the labels of a capture: which marker is which, and which rule is used.

Labels are compared without prefix, case and punctuation. A rule whose markers lack gives way to
the next one; a segment that cannot be had is left out where the map allows it.
"""

import difflib
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from itertools import chain

import numpy as np

from .joint_centres import apart, lies_at, point, references
from .label_meanings import labels_in_use
from .markers import Markers
from .segment_map import SegmentMap, plain

# how names of markers end that are joint centres
CENTRES = ("_hip", "_knee", "_ankle", "_hip_joint")


@dataclass(frozen=True, eq=False)
class FittedMap:
    """A map set to the labels of one capture.

    Parameters
    ----------
    map : SegmentMap
    labels : dict, marker -> label in the capture, those in use
    rules : dict, point -> rule in use, in the order of evaluation
    segments : dict, segment -> (J1, J2, M)
    notes : tuple of str, segments left out
    needed : frozenset of markers without which a segment that is not optional cannot be had
    """

    map: SegmentMap
    labels: dict
    rules: dict
    segments: dict
    notes: tuple = ()
    needed: frozenset = frozenset()

    def points(self, tracks: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
        """Points of the segments, segment -> (n, 3, 3) [m], from tracks (n, 3) by marker."""
        at = self._places(tracks)
        return {
            segment: np.stack([at[end] for end in ends], axis=1)
            for segment, ends in self.segments.items()
        }

    def choices(self, tracks: Mapping[str, np.ndarray]) -> list[str]:
        """What is to be told of joint centres: those of the file, and which of two is taken."""
        at, notes, judged = self._places(tracks), [], []
        for name, rule in self.rules.items():
            if "agree" in rule:
                first, second = rule["agree"]
                off = apart(at[first], at[second])
                taken = first if off <= rule["by"] else second
                said = [self.labels.get(n, n.replace("_", " ")) for n in (first, second, taken)]
                notes.append(
                    f"{said[0]} and {said[1]} are {1e3 * off:.0f} mm apart: {said[2]} taken"
                )
                judged += [first, second]
        own = [v for k, v in self.labels.items() if k.endswith(CENTRES) and k not in judged]
        if own:
            notes.append(f"joint centres of the file, not made from markers: {', '.join(own)}")
        return notes

    def _places(self, tracks):
        """Tracks of markers and of all points made of them."""
        at = dict(tracks)
        for name, rule in self.rules.items():
            at[name] = point(rule, at)
        return at

    def beside(self, name: str) -> list[str]:
        """Markers beside which a point of the map lies, see `joint_centres.lies_at`."""
        if name not in self.rules:
            return [name]
        return list(chain(*(self.beside(other) for other in lies_at(self.rules[name]))))


def fit_map(map: SegmentMap, markers: Markers, without: Collection[str] = ()) -> FittedMap:
    """Set a map to a capture; what a rule lacks sends it to the next rule.

    Parameters
    ----------
    map : SegmentMap
    markers : `shellform.motion.capture.markers.Markers`
    without : labels that are not to be used

    Raises
    ------
    ValueError
        When a segment that is not optional lacks a marker: which, and the closest label found.
    """
    fitted, lacks = try_map(map, markers.names, without)
    if lacks:
        segment, marker = next(iter(lacks.items()))
        raise ValueError(f"{markers.source}: {_lack(map, segment, marker, markers)}")
    return fitted


def try_map(
    map: SegmentMap, names: Iterable[str], without: Collection[str] = ()
) -> tuple[FittedMap, dict[str, str]]:
    """A map set to labels as far as it goes, and what segments lack that are not optional.

    Returns
    -------
    FittedMap; dict, segment -> the first marker that it lacks
    """
    labels = labels_in_use(map, [name for name in names if name not in without])
    rules, used, lacking = {}, {}, {}

    def ready(name):
        """Markers that `name` lacks, () if it can be had; notes rules and labels in use."""
        if name in map.markers:
            if name in labels:
                used[name] = labels[name]
                return ()
            return (name,)
        if name in rules:
            return ()
        if name not in lacking:
            tries = []
            for rule in map.points[name]:
                needed, wished = references(rule)
                lacks = tuple(m for point in needed for m in ready(point))
                if not lacks:
                    have = [point for point in wished if not ready(point)]
                    rules[name] = {**rule, "cluster": have} if wished else rule
                    return ()
                tries.append(lacks)
            lacking[name] = tries[0]
        return lacking[name]

    segments, notes, without_segment = {}, [], {}
    for key, entry in map.segments.items():
        lacks = [m for end in ("J1", "J2", "M") for m in ready(entry[end])]
        if not lacks:
            segments[key] = tuple(entry[end] for end in ("J1", "J2", "M"))
        elif entry.get("optional"):
            notes.append(f"no {key.replace('_', ' ')}, for lack of marker {lacks[0]}")
        else:
            without_segment[key] = lacks[0]
    ends = [p for points in segments.values() for p in points]
    firm = [
        p for k, points in segments.items() if not map.segments[k].get("optional") for p in points
    ]
    closed, needed = _closure(ends, rules, True), _closure(firm or ends, rules, False)
    fitted = FittedMap(
        map,
        {k: v for k, v in used.items() if k in closed},
        {k: v for k, v in rules.items() if k in closed},
        segments,
        tuple(notes),
        frozenset(needed & used.keys()),
    )
    return fitted, without_segment


def _closure(todo, rules, wished):
    """Names that points are made of; with those that are only wished for, or without."""
    todo, out = list(todo), set()
    while todo:
        name = todo.pop()
        if name not in out:
            out.add(name)
            if name in rules:
                must, may = references(rules[name])
                todo += [*must, *may] if wished else must
    return out


def _lack(map, segment, marker, markers):
    """What segment lacks, with the closest label."""
    spellings = map.markers[marker] or (marker,)
    blank = [n for n in markers.empty if plain(n) in {plain(s) for s in spellings}]
    if blank:
        return (
            f"marker '{blank[0]}' holds no numbers, and {segment} needs it (map "
            f"'{map.name}'); fill it, or take another map"
        )
    return (
        f"{segment} needs marker '{marker}' (map '{map.name}': {', '.join(spellings[:3])}), which "
        f"is not there; closest label: '{closest(spellings, markers.names)}'; rename it, or write "
        "a map"
    )


def closest(spellings: Iterable[str], names: Iterable[str]) -> str:
    """The one of `names` that is closest to any of the spellings of a marker."""
    ranked = {
        name: max(difflib.SequenceMatcher(None, plain(s), plain(name)).ratio() for s in spellings)
        for name in names
    }
    return max(ranked, key=lambda name: ranked[name]) if ranked else "nothing"
