# SPDX-License-Identifier: LGPL-3.0-or-later
"""A segment map set to the labels of a capture: which marker is which, and which rule is used.

Labels are compared without prefix, case and punctuation. A rule whose markers lack gives way to
the next one; a segment that cannot be had is left out where the map allows it.
"""

import difflib
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import chain

from .joint_centres import references
from .markers import Markers, plain
from .segment_map import SHIPPED, SegmentMap, segment_map


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
    """

    map: SegmentMap
    labels: dict
    rules: dict
    segments: dict
    notes: tuple = ()


def labels_on_body(names: Iterable[str]) -> dict[str, str]:
    """Dict label -> place on the body, for those labels that the shipped maps know."""
    known: dict[str, str] = {}
    for name in SHIPPED:
        for place, labels in segment_map(name).markers.items():
            for label in labels:
                known.setdefault(plain(label), place)
    return {name: known[plain(name)] for name in names if plain(name) in known}


def fit_map(map: SegmentMap, markers: Markers) -> FittedMap:
    """Set a map to a capture; what a rule lacks sends it to the next rule.

    Parameters
    ----------
    map : SegmentMap
    markers : `shellform.motion.capture.markers.Markers`

    Raises
    ------
    ValueError
        When a segment that is not optional lacks a marker: which, and the closest label found.
    """
    by_plain = {plain(name): name for name in reversed(markers.names)}
    labels = {}
    for key, spellings in map.markers.items():
        found = [by_plain[plain(s)] for s in spellings if plain(s) in by_plain]
        if found:
            labels[key] = found[0]
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

    segments, notes = {}, []
    for key, entry in map.segments.items():
        lacks = [m for end in ("J1", "J2", "M") for m in ready(entry[end])]
        if not lacks:
            segments[key] = tuple(entry[end] for end in ("J1", "J2", "M"))
        elif entry.get("optional"):
            notes.append(f"no {key.replace('_', ' ')}, for lack of marker {lacks[0]}")
        else:
            raise ValueError(_lack(map, key, lacks[0], markers))
    needed = _closure(segments, rules)
    return FittedMap(
        map,
        {k: v for k, v in used.items() if k in needed},
        {k: v for k, v in rules.items() if k in needed},
        segments,
        tuple(notes),
    )


def _closure(segments, rules):
    todo, out = [point for ends in segments.values() for point in ends], set()
    while todo:
        name = todo.pop()
        if name not in out:
            out.add(name)
            todo += chain(*references(rules[name])) if name in rules else ()
    return out


def _lack(map, segment, marker, markers):
    spellings = map.markers[marker]
    blank = [n for n in markers.empty if plain(n) in {plain(s) for s in spellings}]
    if blank:
        return (
            f"{markers.source}: marker '{blank[0]}' holds no numbers, and {segment} needs it (map "
            f"'{map.name}'); fill it, or take another map"
        )
    ranked = {
        name: max(difflib.SequenceMatcher(None, plain(s), plain(name)).ratio() for s in spellings)
        for name in markers.names
    }
    return (
        f"{markers.source}: {segment} needs marker '{marker}' (map '{map.name}': "
        f"{', '.join(spellings[:3])}), which is not there; closest label: "
        f"'{max(ranked, key=ranked.get)}'; rename it, or write a map"
    )


def choose_map(markers: Markers) -> SegmentMap:
    """The first shipped map whose markers are all there.

    Raises
    ------
    ValueError
        Naming what each of them lacks.
    """
    lacks = []
    for name in SHIPPED:
        try:
            fit_map(segment_map(name), markers)
        except ValueError as error:
            lacks.append(str(error).removeprefix(f"{markers.source}: ").split("; rename")[0])
        else:
            return segment_map(name)
    raise ValueError(f"{markers.source}: no shipped map fits: {'; '.join(lacks)}; write a map")
