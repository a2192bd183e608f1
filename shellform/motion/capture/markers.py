# SPDX-License-Identifier: LGPL-3.0-or-later
"""Tracks of captured markers in one frame of reference: metres, right-handed, z up.

A file's numbers become `Markers` in four steps: markers at the origin are missing ones, empty
columns go, the vertical is found, the unit is held against the size of a person.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from shellform.errors import Mendable

from .marker_table import Raw

UNITS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "in": 0.0254}
SPELLINGS = {
    "meters": "m",
    "metres": "m",
    "meter": "m",
    "centimeters": "cm",
    "millimeters": "mm",
    "millimetres": "mm",
    "inches": "in",
}
PERSON = (0.5, 2.5)  # largest extent of the markers [m]: a child's legs, a tall man with arms up
FARTHEST = 1e9  # in any unit; a number beyond it is damaged
UPRIGHT = 0.9  # cosine between pelvis over feet and the axis taken for the vertical


@dataclass(frozen=True, eq=False)
class Markers:
    """Markers of a capture.

    Parameters
    ----------
    names : tuple of m str, as in the file, without the prefix "Subject:"
    times : (n,) float [s], evenly spaced
    positions : (n, m, 3) float [m], z up; NaN where a marker was not seen
    rate : float, frames a second [Hz]
    source : str, the file
    notes : tuple of str, what was found and changed on the way
    empty : tuple of str, names in the file that hold no numbers
    """

    names: tuple
    times: np.ndarray
    positions: np.ndarray
    rate: float
    source: str = "markers"
    notes: tuple = ()
    empty: tuple = ()

    def track(self, name: str) -> np.ndarray:
        """Positions (n, 3) [m] of one marker."""
        return self.positions[:, self.names.index(name)]


def vertical(pelvis: np.ndarray, feet: np.ndarray) -> str | None:
    """Which axis points from the feet to the pelvis.

    Parameters
    ----------
    pelvis, feet : (n, k, 3) float, tracks of markers there, any unit

    Returns
    -------
    "x", "y", "z", "-x", "-y", "-z", or None where none of them does clearly
    """
    if not (pelvis.shape[1] and feet.shape[1]):
        return None
    # medians: one wrong number in a file must not decide what is up
    up = np.nanmedian(pelvis, axis=(0, 1)) - np.nanmedian(feet, axis=(0, 1))
    axis = int(np.argmax(np.abs(up)))
    if not np.abs(up[axis]) > UPRIGHT * np.linalg.norm(up):
        return None
    return ("-" if up[axis] < 0 else "") + "xyz"[axis]


def extent(positions: np.ndarray) -> float:
    """Median over the frames of the markers' largest extent along an axis, in their unit."""
    with np.errstate(all="ignore"):
        spans = np.full(len(positions), np.nan)
        seen = np.isfinite(positions).all(axis=2)
        for k in np.flatnonzero(seen.sum(axis=1) > 1):
            spans[k] = np.ptp(positions[k, seen[k]], axis=0).max()
    return float(np.nanmedian(spans)) if np.isfinite(spans).any() else 0.0


def to_markers(
    raw: Raw, source: str, body: Mapping[str, str], unit: str | None = None, up: str | None = None
) -> Markers:
    """`Markers` from the numbers of a file.

    Parameters
    ----------
    raw : `shellform.motion.capture.marker_table.Raw`
    source : str, the file, for messages
    body : dict, name of a marker -> "pelvis", "feet" or "", for those that are known
    unit, up : what the caller knows better than the file, or None; a unit is a name or the length
        of one in metres, as "0.0564"

    Raises
    ------
    ValueError
        When nothing is left, the vertical is not clear, or no person has this size.
    """
    names, positions, notes = list(raw.names), np.array(raw.positions, float), list(raw.notes)
    far = (np.abs(positions) > FARTHEST).any(axis=2)
    if far.any():
        positions[far] = np.nan
        notes.append(f"{int(far.sum())} places out of the world taken for gaps")
    at_origin = (positions == 0.0).all(axis=2)
    if at_origin.any():
        positions[at_origin] = np.nan
        notes.append(f"{int(at_origin.sum())} places exactly at the origin taken for gaps")
    full = np.isfinite(positions).any(axis=(0, 2))
    empty = tuple(name for name, keep in zip(names, full) if not keep)
    if empty:
        shown = ", ".join(empty[:4]) + (", ..." if len(empty) > 4 else "")
        notes.append(f"{len(empty)} columns without numbers left out: {shown}")
    names = [name for name, keep in zip(names, full) if keep]
    positions = positions[:, full]
    if not names:
        raise ValueError(f"{source}: no marker holds any number; export the trajectories again")
    up, said = _up(positions, names, source, body, raw.up, up)
    positions, unit_note = _metres(positions, names, source, body, raw.unit, unit)
    if up == "y":
        positions = np.stack([positions[..., 0], -positions[..., 2], positions[..., 1]], axis=-1)
    notes += [*said, *unit_note]
    return Markers(tuple(names), raw.times, positions, float(raw.rate), source, tuple(notes), empty)


def _up(positions, names, source, body, declared, given):
    if given is not None:
        if given not in ("y", "z"):
            raise Mendable(f"{source}: up is y or z, not {given!r}", "pass {up:y} or {up:z}")
        return given, [f"up is {given}, as given"]

    def tracks(region):
        return positions[:, [k for k, n in enumerate(names) if body.get(n) == region]]

    found = vertical(tracks("pelvis"), tracks("feet"))
    up, said = found or declared, []
    if found and declared and found != declared:
        said = [f"the file says {declared} is up, its markers stand along {found}: taken"]
    elif up:
        said = [f"up is {up}, from the {'markers' if found else 'file'}"]
    if up is None:
        raise Mendable(
            f"{source}: the vertical is not clear, as no axis points from the feet to the pelvis "
            "and the file does not tell",
            "pass {up:y} or {up:z}",
        )
    if up not in ("y", "z"):
        raise Mendable(
            f"{source}: {up} points up, and only y and z may",
            "turn the file, or pass {up:y} or {up:z} if that is wrong",
        )
    return up, said


def _metres(positions, names, source, body, declared, given):
    unit, factor = given if given is not None else declared, None
    if unit is not None:
        word = str(unit).strip().lower()
        unit = SPELLINGS.get(word, word)
        factor = UNITS.get(unit, _number(unit))
        if not factor:
            raise Mendable(
                f"{source}: unknown unit {word!r}", "pass {unit:mm}, {unit:cm} or {unit:m}"
            )
    # something that lies about makes all markers too wide, and a few of them are no person
    known = [k for k, name in enumerate(names) if name in body]
    sizes = [extent(positions)] + ([extent(positions[:, known])] if len(known) > 3 else [])

    def a_person(scale):
        return any(PERSON[0] <= size * scale <= PERSON[1] for size in sizes)

    fits = [u for u in ("m", "cm", "mm") if a_person(UNITS[u])]
    if unit is None:
        if not fits:
            raise Mendable(
                f"{source}: the markers span {sizes[0]:.4g} and no unit is given; in m, cm or mm a "
                f"person spans {PERSON[0]} to {PERSON[1]} m",
                "pass {unit:in}, or the length of one in metres as {unit:0.0564}, and check the "
                "markers",
            )
        return positions * UNITS[fits[0]], [f"unit {fits[0]}, from the size of the person"]
    if not a_person(factor):
        mend = f"pass {{unit:{fits[0]}}}" if fits else "check the markers"
        who = "given" if given is not None else "in the header"
        raise Mendable(
            f"{source}: with the unit '{unit}' {who} the markers span {sizes[0] * factor:.4g} m, "
            f"and a person spans {PERSON[0]} to {PERSON[1]} m",
            mend,
        )
    return positions * factor, [f"unit {unit}, {'as given' if given else 'from the header'}"]


def _number(word):
    """A length in metres, None for what is none."""
    try:
        return length if 0 < (length := float(word)) < 10 else None
    except ValueError:
        return None
