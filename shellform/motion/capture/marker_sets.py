# SPDX-License-Identifier: LGPL-3.0-or-later
"""Which marker set a capture has: the one that explains most of its labels.

One label means a marker on the skin in one set and a joint centre in another: `RKnee` is both. So
sets are judged as a whole. Those whose segments can all be had are compared by how many labels of
the file belong to them; of equals the first of `SHIPPED` is taken. A file with both hips as centres
has them less than two thirds of a thigh apart: trochanters are further.
"""

from collections.abc import Collection, Iterable
from typing import NamedTuple

import numpy as np

from shellform.errors import Mendable

from .label_meanings import kind_of, labels_in_use, other_meaning
from .map_fitting import closest, try_map
from .markers import Markers
from .segment_map import SHIPPED, SegmentMap, plain, segment_map, vocabulary

HIPS_APART = 0.66  # of a thigh: centres 0.4 to 0.5, trochanters 0.75 and more
PELVIS = ("asis", "psis", "sacrum", "hip")
FEET = ("heel", "toe", "ankle")


class Fit(NamedTuple):
    """How a set fits: map, number of labels it explains, and what its segments lack."""

    map: SegmentMap
    explained: int
    lacks: dict[str, str]


def fits(names: Collection[str]) -> list[Fit]:
    """All shipped sets, those that lack nothing first, then by the labels that they explain."""
    out = []
    for name in SHIPPED:
        map = segment_map(name)
        out.append(Fit(map, len(belonging(map, names)), try_map(map, names)[1]))
    return sorted(out, key=lambda fit: (bool(fit.lacks), -fit.explained))


def belonging(map: SegmentMap, names: Collection[str]) -> list[str]:
    """Labels that belong to a set; of several that may be one marker, the one in use.

    `RKNE` and `RKnee` in one file are not both the lateral marker of the knee.
    """
    words, used = vocabulary(map), labels_in_use(map, names)
    out = []
    for name in names:
        key = words.get(plain(name))
        if key is not None and (not key or used[key] == name):
            out.append(name)
    return out


def choose_map(markers: Markers, hint: bool = True) -> SegmentMap:
    """The shipped map that explains most labels among those whose markers are all there.

    Parameters
    ----------
    markers : Markers; hint : bool, whether a refusal tells that a static trial may help

    Raises
    ------
    ValueError
        Naming what those lack that explain most.
    """
    ranked = fits(markers.names)
    whole = [fit for fit in ranked if not fit.lacks]
    wide = [fit for fit in whole if _hips_of_skin(fit.map, markers)]
    for fit in whole:
        if fit not in wide:
            return fit.map
    if wide:
        raise Mendable(
            f"{markers.source}: hips are as far apart as trochanters are, no joint centres (map "
            f"'{wide[0].map.name}')",
            "mark the pelvis, or write a map that says what they are and pass {map:own_map.toml}",
        )
    raise _refusal(ranked, markers.names, markers.empty, markers.source, hint)


def require_set(names: Collection[str], source: str) -> None:
    """Refuse labels that no shipped map fits, before their places are looked at."""
    ranked = fits(names)
    if ranked[0].lacks:
        raise _refusal(ranked, names, (), source, True)


def _refusal(ranked, names, empty, source, hint):
    """What the sets lack that explain most labels."""
    total, said = len(names), []
    if not any(fit.explained for fit in ranked):
        shown = ", ".join(f"'{name}'" for name in list(names)[:6]) + (", ..." if total > 6 else "")
        said.append(f"none of the {total} labels belongs to a set ({shown})")
    for fit in [fit for fit in ranked if fit.explained][:3]:
        segment, marker = next(iter(fit.lacks.items()))
        spellings = fit.map.markers[marker] or (marker,)
        said.append(
            f"'{fit.map.name}' explains {fit.explained} of {total} labels, and {segment} needs "
            f"marker '{marker}' ({', '.join(spellings[:3])}), which is not there (closest label: "
            f"'{closest(spellings, names)}')"
        )
    blank = ""
    if empty:
        shown = ", ".join(f"'{name}'" for name in empty[:4]) + (", ..." if len(empty) > 4 else "")
        blank = f"; {shown} holds no numbers, fill it"
    static = ", pass {static:standing.trc} if a static trial has them" if hint else ""
    return Mendable(
        f"{source}: no shipped map fits: {'; '.join(said)}{blank}",
        f"rename the markers{static}, or write a map and pass {{map:own_map.toml}}",
    )


def set_notes(map: SegmentMap, names: Iterable[str]) -> list[str]:
    """What is to be told of a set that was chosen: labels it explains, and those that are joint
    centres in it and skin markers in another set, or the other way about."""
    names = list(names)
    words, known = vocabulary(map), belonging(map, names)
    notes = [f"map '{map.name}'"]
    if len(known) < len(names):
        rest = [name for name in names if name not in known]
        shown = ", ".join(rest[:4]) + (", ..." if len(rest) > 4 else "")
        notes.append(f"{len(known)} of {len(names)} labels belong to the set, not {shown}")
    else:
        notes.append(f"all {len(names)} labels belong to the set")
    told: dict[tuple[str, str], list[str]] = {}
    for name in known:
        marker = words[plain(name)]
        if there := other_meaning(name, marker):
            told.setdefault((kind_of(marker), there), []).append(name)
    for (here, there), odd in told.items():
        notes.append(f"{', '.join(odd)} taken for {here}, not the {there} they are in other sets")
    return notes


def regions(names: Collection[str], map: SegmentMap | None = None) -> dict[str, str]:
    """Label -> "pelvis", "feet" or "" for those of a set.

    Parameters
    ----------
    names : labels
    map : SegmentMap, None: the shipped one that fits best; where it does not tell, all of them
    """
    if map is None:
        best = fits(names)[0]
        map = best.map if not best.lacks else None
    out = _regions_by_segment(map, names) if map else {}
    if not {"pelvis", "feet"} <= set(out.values()):
        for name in SHIPPED:
            words = vocabulary(segment_map(name))
            for label in names:
                if place := words.get(plain(label), ""):
                    kind = [k for k, w in (("pelvis", PELVIS), ("feet", FEET)) if _has(place, w)]
                    out[label] = out.get(label) or (kind[0] if kind else "")
    return out


def _has(place, words):
    return any(word in place for word in words)


def _regions_by_segment(map, names):
    """By what the pelvis and the lowest segments are made of."""
    fitted, _ = try_map(map, names)
    words = vocabulary(map)
    out = {name: "" for name in names if plain(name) in words}
    low = [s for s in fitted.segments if s.endswith("_foot")]
    low = low or [s for s in fitted.segments if s.endswith("_shank")]
    for segments, region, ends in ((["pelvis"], "pelvis", (1, 0)), (low, "feet", (1,))):
        for segment in segments:
            for end in ends if segment in fitted.segments else ():
                for marker in fitted.beside(fitted.segments[segment][end]):
                    out[fitted.labels[marker]] = region
    return out


def _hips_of_skin(map, markers):
    """Whether a map of joint centres meets hips that are too far apart for them."""
    fitted, _ = try_map(map, markers.names)
    ends = [fitted.segments.get(f"{side}_thigh") for side in ("right", "left")]
    if None in ends or not all(e[0] in fitted.labels and e[1] in fitted.labels for e in ends):
        return False
    (right, knee, _), (left, _, _) = ends
    right, knee, left = (markers.track(fitted.labels[name]) for name in (right, knee, left))
    with np.errstate(all="ignore"):  # hip and knee in one place are refused later
        apart = np.linalg.norm(right - left, axis=1) / np.linalg.norm(right - knee, axis=1)
    return bool(np.isfinite(apart).any() and np.nanmedian(apart) > HIPS_APART)
