# SPDX-License-Identifier: LGPL-3.0-or-later
"""A static trial carried into a walk by clusters of markers (CAST: Cappozzo, Catani, Della Croce,
Leardini, Clin. Biomech. 10, 1995, 171-178).

Markers at the knees and ankles are worn while the wearer stands, and taken off to walk. In the
static trial each has a fixed place beside the markers of its limb that stay on, and goes with them
(cluster_fit.py). The markers of a limb are found by where they are in the
static trial, whatever they are called; those that do not keep their distances are left out.
Where less than three stay on, the centre of the joint above counts as one.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from shellform.errors import Mendable

from .cluster_fit import carried, mean_shape, misfit
from .joint_centres import NARROW, breadth, point, references
from .map_fitting import fit_map
from .marker_sets import choose_map
from .markers import Markers
from .segment_map import SegmentMap

REACH = 0.17  # of a limb's axis to its markers [m]
# of a limb's length, where its markers are; those where it begins are on the limb above, those
# beyond its end, as at the head of the fibula, on the limb below
ON_LIMB = (0.04, 1.06)
# beyond this part of its length a shank is slim [m]: what is further off is on the foot
AT_ANKLE = (0.9, 0.07)
ON_FOOT = (-0.4, 1.4)  # of the length from heel to toe
TRUNK = 0.32  # of the middle of the pelvis to its markers [m]
FOOT = 0.12  # of the foot's axis to its markers [m]
LOOSE = 0.015  # rms of a marker off its cluster, from which on it is not fixed on the limb [m]
FIRM = 0.01  # error up to which the limb's own cluster is taken, whatever others promise [m]
WRONG = 0.03  # rms of a whole cluster that is none [m]


def with_static(walk: Markers, static: Markers, map: SegmentMap | None = None) -> Markers:
    """The markers of a walk with those that only its static trial has, carried by clusters.

    Parameters
    ----------
    walk, static : Markers
    map : SegmentMap, None: the one that explains most labels of both

    Returns
    -------
    Markers of the walk with further tracks, NaN where less than three markers of a cluster are seen

    Raises
    ------
    ValueError
        When no map fits both together, or a needed marker has no cluster.
    """
    both = _union(walk, static)
    if map is None:
        map = choose_map(_union(static, walk), hint=False)
    fitted = fit_map(map, both)
    trials = _Trials(fitted, walk, static)
    lacking = {m for m, label in fitted.labels.items() if label not in walk.names}
    told: dict[str, list[str]] = {}
    for marker, segments in _carriers(fitted, lacking).items():
        label = fitted.labels[marker]
        tries = [trials.carry(label, segment) for segment in segments]
        found = [one for one in tries if one.track is not None]
        if not found:
            if marker in fitted.needed:
                raise _alone(label, segments[0], tries[0].cluster, walk, static)
            continue
        best = min(found, key=lambda one: one.error)
        if found[0].error < max(FIRM, 2.0 * best.error):
            best = found[0]  # it lies on this limb
        if best.rms > WRONG:
            raise Mendable(
                f"{walk.source}: markers {best.cluster} are {1e3 * best.rms:.0f} mm (rms) off "
                f"where {static.source} has them",
                "labels are mixed up, or it is another person's: take another {static}",
            )
        trials.walking[marker] = both.positions[:, both.names.index(label)] = best.track
        by = f"{best.cluster} ({1e3 * best.rms:.1f} mm rms)"
        told.setdefault(by, []).append(label)
    notes = [
        f"{', '.join(names)} carried from {static.source} by {by}" for by, names in told.items()
    ]
    full = np.isfinite(both.positions).any(axis=(0, 2))
    return replace(
        both,
        names=tuple(n for n, keep in zip(both.names, full) if keep),
        positions=both.positions[:, full],
        notes=(*walk.notes, *notes),
    )


class Carried(NamedTuple):
    """A marker carried by a cluster: its labels as text, the track (n, 3) or None, rms misfit of
    the cluster, and what that makes of the marker with its lever [m]."""

    cluster: str
    track: np.ndarray | None = None
    rms: float = 0.0
    error: float = 0.0


def _carriers(fitted, lacking):
    """Marker -> segments that may carry it, the one it lies on first, from the pelvis down."""
    out = {}
    for segment in fitted.segments:
        for marker in _markers_of(fitted, segment):
            if marker in lacking:
                out.setdefault(marker, []).append(segment)
    return out


def _alone(label, segment, cluster, walk, static):
    return Mendable(
        f"{walk.source}: marker '{label}' is in {static.source} alone, and of the markers that "
        f"stay on the {segment.replace('_', ' ')} both have {cluster or 'none'}",
        "three are needed to carry it, or another {static}",
    )


def _union(one, other):
    """Markers of one trial, and empty columns for those that the other has beside."""
    more = tuple(name for name in other.names if name not in one.names)
    blank = np.full((len(one.times), len(more), 3), np.nan)
    return replace(
        one,
        names=(*one.names, *more),
        positions=np.concatenate([one.positions, blank], axis=1),
        empty=tuple(name for name in one.empty if name not in more),
    )


def _markers_of(fitted, segment):
    """Markers beside the ends of a segment and its M, the far end first."""
    first, second, third = fitted.segments[segment]
    out = [m for end in (second, third, first) for m in fitted.beside(end)]
    return list(dict.fromkeys(out))


class _Trials:
    """Both trials in the terms of a map: where segments are, and which markers stay on them.

    walking, standing : tracks by the map's markers, those that are there
    """

    def __init__(self, fitted, walk, static):
        self.fitted, self.walk, self.static = fitted, walk, static
        self.walking, self.standing = (
            {m: trial.track(label) for m, label in fitted.labels.items() if label in trial.names}
            for trial in (walk, static)
        )
        middle = {m: np.nanmedian(t, axis=0, keepdims=True) for m, t in self.standing.items()}
        at = _points(fitted, middle)
        self.ends = {
            segment: (at[a][0], at[b][0])
            for segment, (a, b, _) in fitted.segments.items()
            if a in at and b in at
        }
        shared = [n for n in static.names if n in walk.names]
        self.places = {n: np.nanmedian(static.track(n), axis=0) for n in shared}

    def cluster(self, segment):
        """Labels in both trials that lie on a segment and keep their distances."""
        if segment not in self.ends:
            return []
        return self._rigid([n for n, place in self.places.items() if self._on(segment, place)])

    def _on(self, segment, place):
        near = {other: self._off(other, place) for other in self.ends}
        return near[segment] < 1.0 and near[segment] <= 1.6 * min(near.values())

    def _off(self, segment, place):
        """Distance of a place to a segment, over what its markers may have."""
        a, b = self.ends[segment]
        if segment == "pelvis":
            off = np.linalg.norm(place - a)
            return off / TRUNK if place[2] > min(a[2], b[2]) - 0.05 else np.inf
        axis = b - a
        share = np.dot(place - a, axis) / np.dot(axis, axis)
        foot = segment.endswith("_foot")
        low, high = ON_FOOT if foot else ON_LIMB
        if not low <= share <= high:
            return np.inf
        off = np.linalg.norm(place - a - share * axis)
        if segment.endswith("_shank") and share > AT_ANKLE[0] and off > AT_ANKLE[1]:
            return np.inf
        return off / (FOOT if foot else REACH)

    def _rigid(self, labels):
        """Without those that move against the others, one after another."""
        while len(labels) > 3:
            own, far = (
                np.stack([trial.track(n) for n in labels], axis=1)
                for trial in (self.static, self.walk)
            )
            off = misfit(mean_shape(own), far)
            worst = int(np.nanargmax(off)) if np.isfinite(off).any() else 0
            if not off[worst] > LOOSE:
                break
            labels = labels[:worst] + labels[worst + 1 :]
        return labels

    def carry(self, label, segment):
        """`Carried` of a label of the static trial by the markers on a segment, with the joint
        above where they are too few."""
        labels = self.cluster(segment)
        said = ", ".join(labels)
        own, far = ([trial.track(n) for n in labels] for trial in (self.static, self.walk))
        if not _wide(own) and segment != "pelvis":
            joint = self.fitted.segments[segment][0]
            above = [_points(self.fitted, t).get(joint) for t in (self.standing, self.walking)]
            if not any(track is None for track in above):
                own, far = [*own, above[0]], [*far, above[1]]
                said += " and the joint above"
        if not _wide(own):
            return Carried(", ".join(labels))
        own, far = np.stack(own, axis=1), np.stack(far, axis=1)
        if not (np.isfinite(far).all(axis=2).sum(axis=1) >= 3).any():
            return Carried(", ".join(labels))
        track, rms = carried(self.static.track(label), own, far)
        shape = mean_shape(own)
        place = np.nanmedian(self.static.track(label), axis=0)
        lever = np.linalg.norm(place - np.nanmean(np.nanmedian(own, axis=0), axis=0))
        wide = breadth(shape[np.isfinite(shape).all(axis=1)][None])
        return Carried(said, track, rms, float(rms * (1.0 + lever / wide)))


def _wide(tracks):
    """Whether tracks are three at least and stand off a line."""
    if len(tracks) < 3:
        return False
    shape = mean_shape(np.stack(tracks, axis=1))
    shape = shape[np.isfinite(shape).all(axis=1)]
    return len(shape) >= 3 and breadth(shape[None]) > NARROW


def _points(fitted, tracks):
    """Tracks of markers and points of a map, as far as the markers are there."""
    at = {name: track for name, track in tracks.items() if np.isfinite(track).any()}
    for name, rule in fitted.rules.items():
        needed, _ = references(rule)
        if all(other in at for other in needed):
            at[name] = point({**rule, "cluster": []} if "cluster" in rule else rule, at)
    return at
