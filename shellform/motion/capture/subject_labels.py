# SPDX-License-Identifier: LGPL-3.0-or-later
"""Labels without what names no place: `Ann:RKNE`, `Skeleton_RKNE`, `RKNE_m` become `RKNE`.

Programs put the name of a subject before its labels. Before a colon it always goes. Words behind or
before other signs (_ | - . and blanks) go where most labels share them and no set fits without.
Labels of another subject, or of an object, never fill up those of the first one: of two subjects
that are both complete none is taken.
"""

from collections import Counter
from collections.abc import Collection
from itertools import product
from pathlib import Path

import numpy as np

from .map_fitting import try_map
from .marker_sets import belonging, fits
from .marker_table import Raw
from .segment_map import SegmentMap

SIGNS = "_|-. "
SHARED = 0.4  # of the labels, which a word must be common to: two subjects have half of them each


def subject_labels(raw: Raw, path: str | Path, map: SegmentMap | None = None) -> Raw:
    """A table whose labels are those of one subject, each once.

    Parameters
    ----------
    raw : Raw, with the labels of the file
    path : the file, for messages
    map : SegmentMap that the labels are for, None: any of the shipped ones

    Raises
    ------
    ValueError
        Where two columns with numbers have one label, or two subjects are complete.
    """
    raw = _each_once(_one_subject(raw, path, map), path)
    if _complete(raw.names, map):
        return raw
    return _bare(raw, path, map)


def _complete(names: Collection[str], map: SegmentMap | None) -> bool:
    """Whether a set has all that it needs."""
    if map is not None:
        return not try_map(map, names)[1]
    return not fits(names)[0].lacks


def _explained(names: Collection[str], map: SegmentMap | None) -> int:
    """Labels that belong to the set, or to the one that has most."""
    if map is not None:
        return len(belonging(map, names))
    return max(fit.explained for fit in fits(names))


def _one_subject(raw: Raw, path: str | Path, map: SegmentMap | None) -> Raw:
    """Labels without what stands before a colon; those of other subjects keep it, with a blank."""
    parts = [name.rsplit(":", 1) for name in raw.names]
    before = [part[0].strip() if len(part) > 1 else "" for part in parts]
    short = [part[-1].strip() for part in parts]
    subjects = Counter(before)
    full = np.isfinite(raw.positions).any(axis=(0, 2))
    whole = []
    if len(subjects) > 1:
        for subject in subjects:
            own = [n for n, b, f in zip(short, before, full) if f and b in (subject, "")]
            if subject and _complete(own, map):
                whole.append(subject)
    _require_one(whole, path)
    notes = list(raw.notes)
    others = [b for b in subjects if b and b not in whole] if whole else []
    names = [f"{b} {n}" if b in others else n for b, n in zip(before, short)]
    named = [b for b in subjects if b and b not in others]
    if named:
        notes.append(f"prefix {', '.join(sorted(named))} taken off the labels")
    if others:
        notes.append(f"{', '.join(sorted(others))} beside {whole[0]} not used")
    return raw._replace(names=tuple(names), notes=tuple(notes))


def _each_once(raw: Raw, path: str | Path) -> Raw:
    """Every label once; of two the one that holds numbers."""
    full = np.isfinite(raw.positions).any(axis=(0, 2))
    keep = []
    for k, name in enumerate(raw.names):
        twins = [j for j, other in enumerate(raw.names) if other == name]
        holding = [j for j in twins if full[j]]
        if len(holding) > 1:
            raise ValueError(
                f"{path}: two markers are called '{name}' (columns "
                f"{', '.join(str(j + 1) for j in holding)}); export one subject, or rename one"
            )
        if k == (holding or twins)[0]:
            keep.append(k)
    return raw._replace(names=tuple(raw.names[k] for k in keep), positions=raw.positions[:, keep])


def _bare(raw: Raw, path: str | Path, map: SegmentMap | None) -> Raw:
    """Labels without the words before and behind that most of them share, where more belong to a
    set so."""
    best, most = raw, _explained(raw.names, map)
    whole = set()
    before, behind = (["", *_shared(raw.names, last)] for last in (False, True))
    for prefix, suffix in product(before, behind):
        names = tuple(n.removesuffix(suffix).removeprefix(prefix) for n in raw.names)
        if not (prefix or suffix) or "" in names or len(set(names)) < len(names):
            continue
        own = [new for new, old in zip(names, raw.names) if prefix and old.startswith(prefix)]
        if _complete(own, map):
            whole.add(prefix)
        if (found := _explained(names, map)) > most:
            words = [f"prefix {prefix}"] * bool(prefix) + [f"suffix {suffix}"] * bool(suffix)
            note = f"{', '.join(words)} taken off the labels"
            best, most = raw._replace(names=names, notes=(*raw.notes, note)), found
    _require_one(sorted(whole), path)
    return best


def _shared(names: Collection[str], behind: bool) -> list[str]:
    """Words before, or behind, a sign that many labels have."""
    count: Counter[str] = Counter()
    for name in names:
        cuts = [k for k, sign in enumerate(name) if sign in SIGNS and 0 < k < len(name) - 1]
        count.update({name[k:] if behind else name[: k + 1] for k in cuts})
    return [word for word, found in count.items() if found >= max(3, SHARED * len(names))]


def _require_one(subjects: Collection[str], path: str | Path) -> None:
    if len(subjects) > 1:
        raise ValueError(
            f"{path}: {len(subjects)} subjects, {', '.join(subjects)}, and one is the wearer; "
            "export one"
        )
