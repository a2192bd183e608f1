# SPDX-License-Identifier: LGPL-3.0-or-later
"""C3D files: places of points, or poses of segments where a program without markers wrote them.

Vicon stores angles, forces, moments and powers in the same list as places: they are told apart by
the groups POINT:ANGLES, FORCES, ... and by their names. A residual below 0 marks a gap.

ROTATION data (Theia3D) are poses of segments. The origin of each becomes a point of its name, and
another one, `name right`, lies beside it along that axis of the segment which runs to the right as
the hips do, a tenth of a thigh away.
"""

import re
from pathlib import Path

import numpy as np

from .c3d_contents import Contents, contents_of
from .marker_table import Raw

NO_PLACE = re.compile(r"(angles?|forces?|moments?|powers?|torques?|index|grf)$", re.IGNORECASE)
NO_PLACE_GROUPS = ("ANGLE", "FORCE", "MOMENT", "POWER", "SCALAR", "REACTION", "TORQUE")
SAME_RATE = 0.005  # relative, of the header and POINT:RATE
AXES = ("x", "y", "z", "-x", "-y", "-z")


def read_c3d(path: str | Path) -> Raw:
    """`Raw` of a C3D file: places only, NaN for gaps, unit and vertical as its parameters say.

    Raises
    ------
    ValueError
        When the file is cut off or no C3D file, its two rates differ, or all points are missing.
    ImportError
        When the library that reads it is not installed.
    """
    held = contents_of(path)
    if held.poses.size and not np.isfinite(held.points).any():
        return _of_poses(held, path)
    tracks = held.points.copy()
    if held.missing.size and held.missing.all():
        raise ValueError(
            f"{path}: every residual is -1, which marks all places as missing; where the "
            "coordinates are good all the same, export it with residuals, or as TRC"
        )
    tracks[held.missing] = np.nan
    count = tracks.shape[1]
    labels, notes = held.texts.get("POINT:LABELS", [])[:count], []
    if not labels or not len(tracks):
        raise ValueError(f"{path}: holds {len(labels)} points in {len(tracks)} frames, no motion")
    if len(labels) < count:
        notes.append(
            f"{count - len(labels)} of {count} points have no label (POINT:LABELS) and are left out"
        )
    others = {
        name
        for key, names in held.texts.items()
        if key.startswith("POINT:")
        and key.removeprefix("POINT:").rstrip("0123456789").startswith(NO_PLACE_GROUPS)
        and not key.endswith("UNITS")
        for name in names
    }
    keep = [
        k
        for k, name in enumerate(labels)
        if name and name not in others and not NO_PLACE.search(name) and not name.startswith("*")
    ]
    if len(keep) < len(labels):
        notes.append(f"{len(labels) - len(keep)} points that are no places or unnamed left out")
    if not keep:
        raise ValueError(f"{path}: none of its {len(labels)} points is a place with a name")
    rate = _rate(held, "POINT:RATE", path)
    times = (held.first + np.arange(len(tracks))) / rate
    names = tuple(labels[k] for k in keep)
    return Raw(names, times, tracks[:, keep], rate, _unit(held), _vertical(held), tuple(notes))


def _rate(held: Contents, key: str, path: str | Path) -> float:
    """Frames a second of parameter and header [Hz]; ValueError where they differ."""
    said, head = held.numbers.get(key, 0.0), held.header_rate
    if said > 0 and head > 0 and abs(said - head) > SAME_RATE * max(said, head):
        raise ValueError(
            f"{path}: {key} is {said:.6g} Hz and the header's rate is {head:.6g} Hz; correct the "
            "wrong one, or export the markers as TRC"
        )
    rate = said if said > 0 else head
    if not (rate > 0 and np.isfinite(rate)):
        raise ValueError(f"{path}: the frame rate is {rate:g} Hz; set {key}")
    return rate


def _unit(held: Contents) -> str | None:
    return next(iter(held.texts.get("POINT:UNITS", [])), "").lower() or None


def _vertical(held: Contents) -> str | None:
    """POINT:Y_SCREEN, the axis that is drawn upward, as "z" or "-y"; None where it is not told."""
    said = next(iter(held.texts.get("POINT:Y_SCREEN", [])), "").lower().lstrip("+")
    return said if said in AXES else None


def _of_poses(held: Contents, path: str | Path) -> Raw:
    """Origins and points to the right of segments from their poses."""
    labels = held.texts.get("ROTATION:LABELS", [])[: held.poses.shape[1]]
    use = [k for k, label in enumerate(labels) if not label.lower().startswith("world")]
    labels, poses = [labels[k] for k in use], held.poses[:, use]
    if not labels or not len(poses):
        raise ValueError(f"{path}: holds {len(labels)} poses in {len(poses)} frames, no motion")
    origins = poses[..., :3, 3].copy()
    origins[~np.isfinite(poses).all(axis=(2, 3))] = np.nan
    key = "ROTATION:RATE" if "ROTATION:RATE" in held.numbers else "POINT:RATE"
    rate = held.numbers.get(key, 0.0)
    if key == "POINT:RATE" or not rate > 0:
        rate = _rate(held, "POINT:RATE", path)
    names, tracks = list(labels), [origins]
    beside = _to_the_right(labels, origins, poses[..., :3, :3])
    if beside is not None:
        names += [f"{label} right" for label in labels]
        tracks.append(beside)
    times = (held.first + np.arange(len(poses))) / rate
    note = f"{len(labels)} poses of segments, no markers: their origins are taken for joint centres"
    positions = np.concatenate(tracks, axis=1)
    return Raw(tuple(names), times, positions, rate, None, _vertical(held), (note,))


def _to_the_right(labels, origins, axes):
    """Points (n, k, 3) beside the origins, along the axis that runs as the hips do; None without
    thighs and shanks. axes : (n, k, 3, 3), columns are those of the segment."""
    at = {label.lower(): origins[:, k] for k, label in enumerate(labels)}
    ends = [at.get(f"{side}_{part}_4x4") for part in ("thigh", "shank") for side in "rl"]
    if any(track is None for track in ends):
        return None
    right, left, knee, _ = ends
    hips = right - left
    own = np.einsum("nkca,nc->nka", axes, hips)  # in the axes of each segment
    mean = np.where(np.isfinite(own), own, 0.0).sum(axis=0)
    axis = np.argmax(np.abs(mean), axis=1)
    sign = np.sign(np.take_along_axis(mean, axis[:, None], 1))
    chosen = np.take_along_axis(axes, axis[None, :, None, None], 3)[..., 0]
    return origins + 0.1 * np.nanmedian(np.linalg.norm(right - knee, axis=1)) * sign * chosen
