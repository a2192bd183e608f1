# SPDX-License-Identifier: LGPL-3.0-or-later
"""Skeletons in motion from a BVH file (Biovision Hierarchy): places of joints, no markers.

A joint stands off its parent by OFFSET; its channels are places along and turns about its axes, in
the order they are written: with M = T(offset) T(places) R1 R2 R3, column vectors, the place of a
joint is the product of the M from the root to it. An End Site is a point without channels. The
format has no unit and no vertical.
"""

import re
from pathlib import Path
from typing import NamedTuple

import numpy as np

from .marker_table import Raw
from .text_tables import text_of

CHANNELS = {f"{axis}{kind}": (axis, kind) for axis in "xyz" for kind in ("position", "rotation")}
DEEPEST = 200  # joints in a chain


class Joint(NamedTuple):
    """name; parent : its number, -1 for none; offset (3,); channels : (axis, kind), in order."""

    name: str
    parent: int
    offset: np.ndarray
    channels: list[tuple[str, str]]


def read_bvh(path: str | Path) -> Raw:
    """`Raw` of a BVH file; ValueError naming what is missing where it is cut off or malformed."""
    text, notes = text_of(path)
    parts = re.split(r"^\s*MOTION\s*$", text, maxsplit=1, flags=re.MULTILINE | re.IGNORECASE)
    if len(parts) < 2 or not text.lstrip().upper().startswith("HIERARCHY"):
        raise ValueError(f"{path}: no BVH file, or cut off: HIERARCHY and MOTION are needed")
    joints = _hierarchy(parts[0], path)
    values, step = _motion(parts[1], sum(len(j.channels) for j in joints), path)
    places = joint_places(joints, values)
    names = _plain_names([joint.name for joint in joints])
    rate = 1.0 / step
    times = np.arange(len(values)) / rate
    notes.append(f"{len(joints)} joints of a skeleton, no markers: taken for joint centres")
    # BVH knows no gaps, and a joint at the origin is one
    places[(places == 0.0).all(axis=2)] = 1e-9
    return Raw(tuple(names), times, places, rate, None, None, tuple(notes))


def _hierarchy(text, path):
    """Joints, parents first."""
    words, joints, open_ = text.split()[1:], [], []
    name, k = None, 0

    def wrong(what):
        return ValueError(f"{path}: {what} in HIERARCHY; export the skeleton again")

    def numbers(first, count):
        try:
            found = [float(w) for w in words[first : first + count]]
        except ValueError:
            found = []
        if len(found) < count or not np.isfinite(found).all():
            raise wrong(f"{count} numbers are missing behind {words[first - 1]}")
        return np.array(found)

    while k < len(words):
        word = words[k].upper()
        if word in ("ROOT", "JOINT"):
            end = next((j for j in range(k + 1, len(words)) if words[j] == "{"), None)
            if end is None or end == k + 1:
                raise wrong("a joint without name or brace")
            name, k = " ".join(words[k + 1 : end]), end
        elif word == "END":
            if not joints or not open_:
                raise wrong("an End Site without joint")
            name, k = f"{joints[open_[-1]].name} end", k + 2
        elif word == "{":
            if name is None or len(open_) > DEEPEST:
                raise wrong("a brace without joint")
            joints.append(Joint(name, open_[-1] if open_ else -1, np.zeros(3), []))
            open_.append(len(joints) - 1)
            name, k = None, k + 1
        elif word == "}":
            if not open_:
                raise wrong("a brace too many")
            open_.pop()
            k += 1
        elif word == "OFFSET" and open_:
            joints[open_[-1]] = joints[open_[-1]]._replace(offset=numbers(k + 1, 3))
            k += 4
        elif word == "CHANNELS" and open_:
            count = int(numbers(k + 1, 1)[0])
            chosen = [CHANNELS.get(w.lower()) for w in words[k + 2 : k + 2 + count]]
            if not 0 <= count <= 6 or len(chosen) < count or None in chosen:
                raise wrong(f"channels of {joints[open_[-1]].name} that are no places or turns")
            joints[open_[-1]].channels.extend(chosen)
            k += 2 + count
        else:
            raise wrong(f"unknown word {words[k]!r}")
    if open_ or not joints:
        raise wrong("a brace is not closed" if open_ else "no joint")
    return joints


def _motion(text, width, path):
    """Values (n, width) and the time between frames [s]."""
    found = re.match(r"\s*Frames:\s*(\d+)\s+Frame Time:\s*([-+.\deE]+)\s*", text, re.IGNORECASE)
    step = _number(found.group(2)) if found else None
    if found is None or not step or not 1e-5 < step < 1.0:
        raise ValueError(f"{path}: MOTION lacks 'Frames:' or a 'Frame Time:' in seconds")
    count, rest = int(found.group(1)), text[found.end() :].split()
    if width == 0 or len(rest) != count * width:
        raise ValueError(
            f"{path}: {len(rest)} numbers for {count} frames of {width} channels; the file is cut "
            "off, copy it again, or correct 'Frames:'"
        )
    if count < 1:
        raise ValueError(f"{path}: {count} frames; export the skeleton again")
    try:
        values = np.array(rest, float)
    except ValueError:
        bad = next(w for w in rest if _number(w) is None)
        raise ValueError(f"{path}: {bad!r} in MOTION is no number") from None
    if not np.isfinite(values).all():
        raise ValueError(f"{path}: MOTION holds what is no finite number; export it again")
    return values.reshape(count, width), step


def _number(word):
    try:
        return float(word)
    except ValueError:
        return None


def joint_places(joints: list[Joint], values: np.ndarray) -> np.ndarray:
    """Places (n, m, 3) of joints from channels (n, width) [degrees for turns]."""
    n, column = len(values), 0
    turns, places = [], np.zeros((n, len(joints), 3))
    for k, joint in enumerate(joints):
        shift = np.tile(joint.offset, (n, 1))
        turn = np.tile(np.eye(3), (n, 1, 1))
        for axis, kind in joint.channels:
            value, column = values[:, column], column + 1
            if kind == "position":
                shift[:, "xyz".index(axis)] += value
            else:
                turn = turn @ _about("xyz".index(axis), np.radians(value))
        if joint.parent < 0:
            turns.append(turn)
            places[:, k] = shift
        else:
            above = turns[joint.parent]
            turns.append(above @ turn)
            places[:, k] = places[:, joint.parent] + np.einsum("nab,nb->na", above, shift)
    return places


def _about(axis, angle):
    """Rotations (n, 3, 3) about a coordinate axis."""
    out = np.tile(np.eye(3), (len(angle), 1, 1))
    a, b = (axis + 1) % 3, (axis + 2) % 3
    out[:, a, a] = out[:, b, b] = np.cos(angle)
    out[:, b, a] = np.sin(angle)
    out[:, a, b] = -np.sin(angle)
    return out


def _plain_names(names):
    """Names without the prefix that all share, as `mixamorig_`; twins numbered."""
    first = re.match(r"[A-Za-z0-9]+[_|]", names[0])
    if first and all(name.startswith(first.group(0)) for name in names):
        names = [name.removeprefix(first.group(0)) for name in names]
    seen, out = {}, []
    for name in names:
        seen[name] = seen.get(name, 0) + 1
        out.append(name if seen[name] == 1 else f"{name} {seen[name]}")
    return out
