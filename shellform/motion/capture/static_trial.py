# SPDX-License-Identifier: LGPL-3.0-or-later
"""A static trial carried into a walk by clusters of markers (CAST: Cappozzo, Catani, Della Croce,
Leardini, Clin. Biomech. 10, 1995, 171-178).

Markers at the knees and ankles are worn while the wearer stands, and taken off to walk. In the
static trial each has a fixed place beside the markers of its limb that stay on:

    x = c + R a,    sum over i of w_i |R (s_i - s) + c - y_i|^2 = min

with the cluster's shape s_i, its places y_i in a frame of the walk, both with their means s and c,
and a the place of the marker in the shape. R is the best rotation by singular values (Soederkvist,
Wedin, J. Biomech. 26, 1993, 1473-1477). The markers of a limb are found by where they are in the
static trial, whatever they are called; those that do not keep their distances are left out.
Where less than three stay on, the centre of the joint above counts as one.
"""

from dataclasses import replace

import numpy as np

from shellform.errors import Mendable

from .joint_centres import NARROW, breadth, point
from .map_fitting import fit_map
from .marker_sets import choose_map
from .markers import Markers
from .segment_map import SegmentMap

REACH = 0.17  # of a limb's axis to its markers [m]
BEYOND = (-0.05, 1.12)  # of its length, where its markers are
TRUNK = 0.32  # of the middle of the pelvis to its markers [m]
FOOT = 0.12  # of the foot's axis to its markers [m]
LOOSE = 0.015  # rms of a marker off its cluster, from which on it is not fixed on the limb [m]
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
    source = f"{walk.source} with {static.source}"
    more = [name for name in static.names if name not in walk.names]
    both = replace(
        walk,
        names=(*walk.names, *more),
        positions=np.concatenate(
            [walk.positions, np.full((len(walk.times), len(more), 3), np.nan)], axis=1
        ),
        source=source,
        empty=tuple(name for name in walk.empty if name not in more),
    )
    union = replace(static, names=(*static.names, *walk.names), source=source)
    if map is None:
        map = choose_map(replace(union, positions=_padded(static, walk)), hint=False)
    fitted = fit_map(map, both)
    needed = {fitted.labels[name] for name in fitted.needed}
    tracks = {name: both.track(label) for name, label in fitted.labels.items()}
    standing = {
        name: static.track(label) for name, label in fitted.labels.items() if label in static.names
    }
    limbs = _Limbs(fitted, standing, walk, static)
    notes = []
    for segment in fitted.segments:
        for name in _markers_of(fitted, segment):
            label = fitted.labels[name]
            if label in walk.names:
                continue
            if label not in static.names:  # pragma: no cover, the union has it
                continue
            cluster = limbs.cluster(segment, label)
            own, far = limbs.tracks(cluster, segment, tracks, standing)
            if own is None:
                if label in needed and not np.isfinite(tracks[name]).any():
                    if _later(fitted, segment, name):
                        continue
                    raise Mendable(
                        f"{walk.source}: marker '{label}' is in {static.source} alone, and of the "
                        f"markers that stay on the {segment.replace('_', ' ')} both have "
                        f"{', '.join(cluster) or 'none'}",
                        "three are needed to carry it, or another {static}",
                    )
                continue
            if np.isfinite(tracks[name]).any():
                continue
            tracks[name], rms = carried(standing[name], own, far)
            if rms > WRONG:
                raise Mendable(
                    f"{walk.source}: markers {', '.join(cluster)} are {1e3 * rms:.0f} mm (rms) off "
                    f"where {static.source} has them on the {segment.replace('_', ' ')}",
                    "labels are mixed up, or it is another person's: take another {static}",
                )
            both.positions[:, both.names.index(label)] = tracks[name]
            notes.append((segment, ", ".join(cluster), rms, label))
    told = {}
    for segment, cluster, rms, label in notes:
        told.setdefault((segment, cluster, rms), []).append(label)
    said = [
        f"{', '.join(labels)} carried from {static.source} by {cluster} ({1e3 * rms:.1f} mm rms)"
        for (segment, cluster, rms), labels in told.items()
    ]
    full = np.isfinite(both.positions).any(axis=(0, 2))
    return replace(
        both,
        names=tuple(n for n, keep in zip(both.names, full) if keep),
        positions=both.positions[:, full],
        source=walk.source,
        notes=(*walk.notes, *said),
    )


def _padded(static, walk):
    """Static positions with columns of NaN for the walk's labels."""
    blank = np.full((len(static.times), len(walk.names), 3), np.nan)
    return np.concatenate([static.positions, blank], axis=1)


def _markers_of(fitted, segment):
    """Markers beside the far end of a segment, beside M, and beside the near end."""
    first, second, third = fitted.segments[segment]
    out = [m for end in (second, third, first) for m in fitted.beside(end)]
    return list(dict.fromkeys(out))


def _later(fitted, segment, name):
    """Whether a segment further down may carry the marker as well."""
    order = list(fitted.segments)
    later = order[order.index(segment) + 1 :]
    return any(name in _markers_of(fitted, other) for other in later)


class _Limbs:
    """Where segments are in the static trial, and which markers stay on them."""

    def __init__(self, fitted, standing, walk, static):
        self.fitted, self.walk, self.static = fitted, walk, static
        middle = {k: np.nanmedian(t, axis=0, keepdims=True) for k, t in standing.items()}
        at = dict(middle)
        for name, rule in fitted.rules.items():
            try:
                at[name] = point(rule, at)
            except KeyError:
                continue
        self.ends = {
            s: (at[a][0], at[b][0]) for s, (a, b, _) in fitted.segments.items() if a in at and b in at
        }
        shared = [n for n in static.names if n in walk.names]
        self.places = {n: np.nanmedian(static.track(n), axis=0) for n in shared}

    def cluster(self, segment, label):
        """Labels in both files that lie on a segment and keep their distances."""
        if segment not in self.ends:
            return []
        found = [n for n in self.places if n != label and self._on(segment, self.places[n])]
        return self._rigid(found)

    def _on(self, segment, place):
        near = {s: self._off(s, place) for s in self.ends}
        return near[segment] < 1.0 and near[segment] <= 1.6 * min(near.values())

    def _off(self, segment, place):
        """Distance of a place to a segment, over what its markers may have."""
        a, b = self.ends[segment]
        if segment == "pelvis":
            off = np.linalg.norm(place - a)
            return off / TRUNK if place[2] > min(a[2], b[2]) - 0.05 else np.inf
        axis = b - a
        share = np.dot(place - a, axis) / np.dot(axis, axis)
        low, high = BEYOND if not segment.endswith("_foot") else (-0.4, 1.4)
        if not low <= share <= high:
            return np.inf
        off = np.linalg.norm(place - a - share * axis)
        return off / (FOOT if segment.endswith("_foot") else REACH)

    def _rigid(self, labels):
        """Without those that move against the others, one after another."""
        labels = list(labels)
        while len(labels) > 3:
            own = np.stack([self.static.track(n) for n in labels], axis=1)
            far = np.stack([self.walk.track(n) for n in labels], axis=1)
            shape = _shape(own)
            off = _misfit(shape, far)
            worst = int(np.nanargmax(off)) if np.isfinite(off).any() else 0
            if not off[worst] > LOOSE:
                break
            labels.pop(worst)
        return labels

    def tracks(self, cluster, segment, walking, standing):
        """Tracks (n, k, 3) of a cluster, in the static trial and in the walk, None for too few."""
        own = [self.static.track(n) for n in cluster]
        far = [self.walk.track(n) for n in cluster]
        if len(cluster) < 3 or breadth(_shape(np.stack(own, axis=1))[None]) < NARROW:
            joint = self.fitted.segments[segment][0]
            above = [_point(self.fitted, joint, t) for t in (standing, walking)]
            if segment == "pelvis" or any(t is None for t in above):
                return None, None
            own, far = [*own, above[0]], [*far, above[1]]
        if len(own) < 3:
            return None, None
        own, far = np.stack(own, axis=1), np.stack(far, axis=1)
        enough = (np.isfinite(far).all(axis=2).sum(axis=1) >= 3).any()
        if not enough or breadth(_shape(own)[None]) < NARROW:
            return None, None
        return own, far


def _point(fitted, name, tracks):
    """Track of a point of the map, None where a marker of it is nowhere."""
    at = {k: t for k, t in tracks.items() if np.isfinite(t).any()}
    for key, rule in fitted.rules.items():
        try:
            at[key] = point(rule, at)
        except KeyError:
            continue
    return at.get(name)


def carried(
    marker: np.ndarray, cluster: np.ndarray, walking: np.ndarray
) -> tuple[np.ndarray, float]:
    """Track of a marker that is fixed to a cluster.

    Parameters
    ----------
    marker : (m, 3) float [m], in the static trial; cluster : (m, k, 3), the cluster there
    walking : (n, k, 3), the cluster in the walk; NaN where a marker is not seen

    Returns
    -------
    (n, 3) float [m], NaN where less than three of the cluster are seen; rms misfit [m]
    """
    shape = _shape(cluster)
    turn, here, there = _fit(shape, cluster)
    place = np.einsum("nba,nb->na", turn, marker - there) + here
    place = np.nanmedian(place, axis=0)
    turn, here, there = _fit(shape, walking)
    track = np.einsum("nab,nb->na", turn, place - here) + there
    off = np.einsum("nab,nkb->nka", turn, shape - here[:, None]) + there[:, None] - walking
    return track, float(np.sqrt(np.nanmean(np.sum(off**2, axis=2))))


def _shape(cluster):
    """Mean shape (k, 3) of a cluster's frames (n, k, 3), laid on one another."""
    first = np.nanmedian(cluster, axis=0)
    if not np.isfinite(first).all():
        return first
    turn, here, there = _fit(first, cluster)
    back = np.einsum("nba,nkb->nka", turn, cluster - there[:, None]) + here[:, None]
    mean = np.nanmean(back, axis=0) if np.isfinite(back).any() else first
    return np.where(np.isfinite(mean), mean, first)


def _misfit(shape, cluster):
    """Rms (k,) of each marker off the shape that fits all of them best."""
    turn, here, there = _fit(shape, cluster)
    off = np.einsum("nab,nkb->nka", turn, shape - here[:, None]) + there[:, None] - cluster
    with np.errstate(all="ignore"):
        return np.sqrt(np.nanmean(np.sum(off**2, axis=2), axis=0))


def _fit(shape, cluster):
    """Rotation (n, 3, 3) of a shape (k, 3) to each frame (n, k, 3), and the means of both."""
    weights = np.isfinite(cluster).all(axis=2) & np.isfinite(shape).all(axis=1)
    enough = weights.sum(axis=1) >= 3
    w = weights / np.maximum(weights.sum(axis=1, keepdims=True), 1)
    y, s = np.where(weights[..., None], cluster, 0.0), np.where(np.isfinite(shape), shape, 0.0)
    here, there = np.einsum("nk,kc->nc", w, s), np.einsum("nk,nkc->nc", w, y)
    a = s - here[:, None]
    b = y - there[:, None]
    u, _, vt = np.linalg.svd(np.einsum("nk,nka,nkb->nab", w, b, a))
    u[:, :, 2] *= np.linalg.det(u @ vt)[:, None]
    turn = u @ vt
    turn[~enough] = np.nan
    return turn, here, there
