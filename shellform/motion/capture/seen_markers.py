# SPDX-License-Identifier: LGPL-3.0-or-later
"""Which markers of a set are seen well enough, and in which frames.

What a segment cannot be had without decides the frames: from where all of it is seen to where it is
lost. A marker that is only wished for (of a cluster, of a foot, one of several rules) and that has
longer gaps in these frames is left out and told; it stops nothing.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from shellform.errors import Mendable

from .gaps_and_spikes import common_span, runs
from .map_fitting import FittedMap, fit_map, try_map
from .markers import Markers
from .segment_map import SegmentMap

KEPT = 0.75  # of the frames that the needed markers have, which one wished for may cost
NAMED = 8  # gaps that a refusal names


def seen(
    map: SegmentMap, markers: Markers, use: np.ndarray, max_gap: float
) -> tuple[FittedMap, slice, list[str]]:
    """A map set to those markers of a capture that are seen, and the frames to use.

    Parameters
    ----------
    map : SegmentMap
    markers : Markers
    use : (n,) bool, frames of the window
    max_gap : float, longest gap that is filled [s]

    Returns
    -------
    FittedMap; slice of the frames; notes (list of str)

    Raises
    ------
    ValueError
        When a marker that is needed has longer gaps or is never seen, naming all of them.
    """
    start = int(np.flatnonzero(use)[0])
    stop = int(np.flatnonzero(use)[-1]) + 1
    times = markers.times[start:stop]
    step = (times[-1] - times[0]) / (len(times) - 1)
    longest = int((max_gap + 1e-9) / step)
    there = {
        name: np.isfinite(markers.positions[start:stop, k]).all(axis=1)
        for k, name in enumerate(markers.names)
    }
    # markers that are not seen at all in the window are as if they were not there
    fitted = fit_map(map, markers)
    notes: list[str] = []
    bad: list[str] = []
    while True:
        core = {fitted.labels[name] for name in fitted.needed}
        blind = sorted(label for label in core if not there[label].any())
        first, last = (0, 0) if blind else _span(there, core)
        gappy = sorted(
            label for label in core if last - first < 2 or _gaps(there[label][first:last], longest)
        )
        if not (blind or gappy):
            break
        drop = blind or gappy
        other, lacks = try_map(map, markers.names, [*bad, *drop])
        if lacks or other.labels == fitted.labels:
            # one after another: perhaps only one of them has a rule beside it
            for label in drop:
                other, lacks = try_map(map, markers.names, [*bad, label])
                if not lacks and other.labels != fitted.labels:
                    drop = [label]
                    break
            else:
                raise _refusal(markers.source, times, there, blind, gappy, max_gap, (first, last))
        bad += drop
        notes.append(f"{', '.join(drop)} not used, for gaps: another rule takes the place")
        fitted = other
    core = {fitted.labels[name] for name in fitted.needed}
    first, last = _span(there, core)
    wished = [label for label in fitted.labels.values() if label not in core]
    out = []
    for label in wished:
        own = there[label]
        inside = np.flatnonzero(own[first:last])
        if not len(inside):
            out.append(label)
            continue
        begin, end = first + int(inside[0]), first + int(inside[-1]) + 1
        if _gaps(own[begin:end], longest) or end - begin < KEPT * (last - first):
            out.append(label)
    if out:
        fitted = fit_map(map, markers, [*bad, *out])
        shown = ", ".join(sorted(out))
        notes.append(f"{shown} left out, seen too seldom for what is only wished for")
    labels = set(fitted.labels.values())
    tracks = {label: markers.positions[start:stop, markers.names.index(label)] for label in labels}
    first, last, early, late = common_span(tracks)
    if first:
        notes.append(
            f"starts at t = {times[first]:.3f} s, {first} frames late, for lack of "
            f"{', '.join(sorted(early))}"
        )
    if last < len(times):
        notes.append(
            f"ends at t = {times[last - 1]:.3f} s, {len(times) - last} frames early, for lack of "
            f"{', '.join(sorted(late))}"
        )
    return fitted, slice(start + first, start + last), notes


def _span(there, labels):
    """First and last + 1 frame between which all labels have been seen and none is lost."""
    first = max(int(np.argmax(there[label])) for label in labels)
    last = min(len(there[label]) - int(np.argmax(there[label][::-1])) for label in labels)
    return first, max(first, last)


def _gaps(there: np.ndarray, longest: int) -> list[tuple[int, int]]:
    """Gaps of more than `longest` frames, as (first, last + 1)."""
    return [(a, b) for a, b in runs(~there) if b - a > longest]


def _refusal(
    source: str,
    times: np.ndarray,
    there: Mapping[str, np.ndarray],
    blind: Sequence[str],
    gappy: Sequence[str],
    max_gap: float,
    span: tuple[int, int],
) -> Mendable:
    """All gaps in one sentence, with the gap that would have to be filled and the best window."""
    step = (times[-1] - times[0]) / (len(times) - 1)
    if blind:
        names = ", ".join(f"'{label}'" for label in blind)
        return Mendable(
            f"{source}: marker {names} is not seen between {times[0]:.3f} and {times[-1]:.3f} s",
            "take another {window} or {map}",
        )
    first, last = span
    if last - first < 2:
        names = ", ".join(f"'{label}'" for label in gappy)
        return Mendable(
            f"{source}: no two frames have all markers needed, {names}",
            "take another {map}, or fill what lacks",
        )
    longest = int((max_gap + 1e-9) / step)
    found = [
        (label, first + a, (b - a) * step)
        for label in gappy
        for a, b in _gaps(there[label][first:last], longest)
    ]
    found.sort(key=lambda gap: gap[1])
    told = [
        f"'{label}' lacks from t = {times[k]:.3f} s for {gap:.3f} s"
        for label, k, gap in found[:NAMED]
    ]
    more = f" and {len(found) - NAMED} more" if len(found) > NAMED else ""
    widest = max(gap for *_, gap in found)
    open_ = np.zeros(last - first, bool)
    for label in gappy:
        for a, b in _gaps(there[label][first:last], longest):
            open_[a:b] = True
    begin, end = max(runs(~open_), key=lambda run: run[1] - run[0], default=(0, 1))
    free = f" as ({times[first + begin]:.3f}, {times[first + end - 1]:.3f}) s"
    return Mendable(
        f"{source}: marker {', '.join(told)}{more}, longer than max_gap = {max_gap:g} s",
        f"fill what lacks, raise {{max_gap:{np.ceil(1e3 * widest + 0.1) / 1e3:g}}}, or cut the "
        f"capture with {{window}}{free}",
    )
