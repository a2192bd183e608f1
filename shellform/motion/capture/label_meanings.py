# SPDX-License-Identifier: LGPL-3.0-or-later
"""Labels that are a marker on the skin in one set and the centre of the joint in another: `RKnee`.

A file may have both, as where markers and a markerless program are compared. Of labels that may be
one marker of a set the one counts that has no other meaning elsewhere, or that is spelled as the
set has it; where that does not tell, and they lie apart, none is taken for the other.
"""

from collections.abc import Iterable, Mapping
from functools import cache

import numpy as np

from shellform.errors import Mendable

from .markers import Markers
from .segment_map import SHIPPED, SegmentMap, plain, segment_map, vocabulary

# how names of places end: on the skin, and at the centre of the joint
KINDS = {
    "markers": ("_knee_lateral", "_ankle_lateral"),
    "joint centres": ("_hip", "_knee", "_ankle"),
}
APART = 0.015  # of two places that are not one [m]


def kind_of(marker: str) -> str:
    """ "markers" or "joint centres" for the marker of a map that is one at a joint, else ""."""
    return next((kind for kind, ends in KINDS.items() if marker.endswith(ends)), "")


@cache
def _kinds_of_labels() -> dict[str, frozenset[str]]:
    out: dict[str, set[str]] = {}
    for name in SHIPPED:
        for label, marker in vocabulary(segment_map(name)).items():
            if kind := kind_of(marker):
                out.setdefault(label, set()).add(kind)
    return {label: frozenset(kinds) for label, kinds in out.items()}


def other_meaning(label: str, marker: str) -> str:
    """What a label means in other sets than at `marker`: "markers", "joint centres" or ""."""
    kind = kind_of(marker)
    others = _kinds_of_labels().get(plain(label), frozenset()) - {kind} if kind else ()
    return next(iter(others), "")


def labels_in_use(map: SegmentMap, names: Iterable[str]) -> dict[str, str]:
    """Marker of a map -> label that is there: one that means nothing else, then one spelled as the
    map has it but for the case, then the first of its spellings."""
    found = _candidates(map, names)
    return {m: min(labels, key=lambda n: _doubt(map, m, n)) for m, labels in found.items()}


def _doubt(map: SegmentMap, marker: str, label: str) -> tuple[bool, bool]:
    """Whether a label has another meaning elsewhere, and whether the map spells it otherwise."""
    spelled = {spelling.lower() for spelling in map.markers[marker]}
    return bool(other_meaning(label, marker)), label.lower() not in spelled


def _candidates(map: SegmentMap, names: Iterable[str]) -> dict[str, list[str]]:
    """Marker of a map -> labels that may be it, in the order of its spellings."""
    by_plain: dict[str, list[str]] = {}
    for name in names:
        by_plain.setdefault(plain(name), []).append(name)
    out: dict[str, list[str]] = {}
    for marker, spellings in map.markers.items():
        found = [name for s in spellings for name in by_plain.get(plain(s), [])]
        if found:
            out[marker] = list(dict.fromkeys(found))
    return out


def require_one_meaning(map: SegmentMap, labels: Mapping[str, str], markers: Markers) -> None:
    """Refuse labels that may be one marker of a set with the same doubt, and lie apart.

    Parameters
    ----------
    map : SegmentMap; labels : marker -> label in use; markers : Markers

    Raises
    ------
    ValueError
        Naming both labels and their distance.
    """
    for marker, names in _candidates(map, markers.names).items():
        used = labels.get(marker)
        if used is None or not other_meaning(used, marker):
            continue
        for name in names:
            if _doubt(map, marker, name) != _doubt(map, marker, used):
                continue
            off = np.linalg.norm(markers.track(name) - markers.track(used), axis=1)
            if np.isfinite(off).any() and np.nanmedian(off) > APART:
                raise Mendable(
                    f"{markers.source}: '{used}' and '{name}' are {1e3 * np.nanmedian(off):.0f} mm "
                    f"apart, and each may be the {marker.replace('_', ' ')} of the set "
                    f"'{map.name}', on the skin or at the joint's centre",
                    "leave one of them out, or write a map and pass {map:own_map.toml}",
                )
