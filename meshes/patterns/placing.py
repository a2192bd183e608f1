# SPDX-License-Identifier: LGPL-3.0-or-later
"""Panels about a standing body before they are sewn: as the file says, else on cylinders.

x is forward, y to the wearer's left, z up. Panels without a place lie on a cylinder about a segment
of the body, seen from outside as they are drawn: 'front' before it, 'back' behind it, 'left' and
'right' of a trunk aside of these, their tops at the top of the segment.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from meshes.validity import MeshError

from .pattern import Panel, SewingPattern


class Axis(NamedTuple):
    """Cylinder about a segment: its upper end (3,) [m] and the direction (3,) down along it."""

    top: tuple[float, float, float]
    down: tuple[float, float, float] = (0.0, 0.0, -1.0)


# of a person of 1.75 m
STANDING = {
    "pelvis": Axis((0.0, 0.0, 1.04)),
    "abdomen": Axis((0.0, 0.0, 1.2)),
    "thorax": Axis((0.0, 0.0, 1.45)),
    "left_thigh": Axis((0.0, 0.1, 1.04)),
    "right_thigh": Axis((0.0, -0.1, 1.04)),
    "left_upper_arm": Axis((0.0, 0.2, 1.4), (0.0, 0.7, -0.7)),
    "right_upper_arm": Axis((0.0, -0.2, 1.4), (0.0, -0.7, -0.7)),
}
ASIDE = 0.25  # of a panel's breadth, see `side_of`
HELD_OUT = np.radians(70.0)  # of arms from straight down, where the file does not place sleeves
_WORDS = {"sleeve": "upper_arm", "leg": "thigh", "trouser": "thigh", "pant": "thigh"}


class Places(NamedTuple):
    """Where panels go: flat, by rotation (3, 3) and translation (3,); rolled, by cylinder."""

    flat: dict[str, tuple[np.ndarray, np.ndarray]]
    rolled: dict[str, tuple[Axis, float, float, np.ndarray]]

    def put(self, panel: Panel, points: np.ndarray) -> np.ndarray:
        """Points (n, 2) of a panel in space (n, 3)."""
        if panel.name in self.flat:
            turn, shift = self.flat[panel.name]
            outward = turn[:, 2] * np.sign(panel.signed_area)
            return _around_a_leg(points @ turn[:, :2].T + shift, outward)
        axis, angle, radius, origin = self.rolled[panel.name]
        down = np.asarray(axis.down) / np.linalg.norm(axis.down)
        forward = np.array([1.0, 0.0, 0.0])
        left = np.cross(forward, down)
        left *= np.sign(left[1]) or 1.0
        x, y = (points - origin).T
        if panel.signed_area < 0.0:  # drawn from the inside
            x = -x
        turn = angle + x / radius
        around = np.outer(np.cos(turn), forward) + np.outer(np.sin(turn), left)
        return np.asarray(axis.top) + radius * around - np.outer(y, down)


def side_of(y: np.ndarray) -> float:
    """1 for a panel about the left leg or arm, -1 about the right, 0 about the trunk.

    y : of its points [m]; a panel whose middle lies off y = 0 by more than ASIDE of its breadth
    """
    return float(np.sign(y.mean()) * (abs(y.mean()) > ASIDE * np.ptp(y)))


def _around_a_leg(points, outward):
    """Points (n, 3) of a flat panel; what reaches across y = 0 goes back along that plane.

    The fork of trousers runs between the legs; drawn flat, both sides would overlap there.
    """
    side = side_of(points[:, 1])
    across = np.maximum(-side * points[:, 1], 0.0) if side else np.zeros(len(points))
    points = points - across[:, None] * outward
    points[:, 1] += side * across
    return points


def place_panels(pattern: SewingPattern, axes: Mapping[str, Axis] | None = None) -> Places:
    """Places of all panels.

    MeshError for a segment that is not there
    """
    axes = STANDING if axes is None else axes
    flat: dict = {}
    on: dict[str, list[Panel]] = {}
    for panel in pattern.panels:
        if panel.translation is not None and panel.rotation is not None:
            flat[panel.name] = (panel.rotation, panel.translation)
            continue
        segment = panel.about or _segment(panel.name)
        if segment not in axes:
            raise MeshError(
                f"{pattern.source}: panel '{panel.name}' goes around '{segment}', which is no "
                f"segment to place it on: there are {', '.join(axes)}."
            )
        on.setdefault(segment, []).append(panel)
    rolled = {}
    for segment, panels in on.items():
        # a ring of panels side by side; what lies over another is not told here
        wide = {panel.name: float(np.ptp(panel.outline()[:, 0])) for panel in panels}
        radius = sum(wide.values()) / (2 * np.pi)
        turned = 0.0
        for panel in panels:
            angle = _angle(panel.name, segment)
            if angle is None:
                angle = (turned + 0.5 * wide[panel.name]) / radius - np.pi / 2
            turned += wide[panel.name]
            low, high = panel.outline().min(axis=0), panel.outline().max(axis=0)
            origin = np.array([0.5 * (low[0] + high[0]), high[1]])
            rolled[panel.name] = (axes[segment], angle, radius, origin)
    return Places(flat, rolled)


def goes_about_arms(pattern: SewingPattern) -> bool:
    """Whether a panel is a sleeve, or goes about the upper body: the garment hangs on shoulders."""
    return any(
        "sleeve" in panel.name.lower() or (panel.about or "").endswith(("thorax", "arm"))
        for panel in pattern.panels
    )


def sleeve_angle(pattern: SewingPattern) -> float:
    """Mean angle [rad] from straight down at which the sleeves lie before they are sewn.

    From the middle of a sleeve's panel to that of its edges that are not sewn; HELD_OUT of sleeves
    on cylinders, and where there are none.
    """
    places = place_panels(pattern)
    sewn = {side for s in pattern.stitches for side in (*s.first, *s.second)}
    angles = []
    for panel in pattern.panels:
        if panel.name not in places.flat:
            continue
        outline = places.put(panel, panel.outline())
        side = side_of(outline[:, 1])
        open_ends = [e.at([0.0, 0.5, 1.0]) for e in panel.edges if (panel.name, e.name) not in sewn]
        if side and open_ends:
            way = places.put(panel, np.concatenate(open_ends)).mean(axis=0) - outline.mean(axis=0)
            angles.append(np.arctan2(side * way[1], -way[2]))
    return float(np.mean(angles)) if angles else HELD_OUT


def _segment(name):
    """Segment that a panel goes around, by words of its name."""
    words = name.lower()
    side = next((s for s in ("left", "right") if s in words), None)
    for word, segment in _WORDS.items():
        if word in words and side:
            return f"{side}_{segment}"
    return "pelvis"


def _angle(name, segment):
    """Angle [rad] of a panel about its segment, from forward to the left; None: not told."""
    words = name.lower()
    trunk = not segment.startswith(("left", "right"))
    side = 0.0
    if trunk:
        side = 1.0 * ("left" in words) - 1.0 * ("right" in words)
    if "front" in words:
        return side * np.pi / 4
    if "back" in words:
        return np.pi - side * np.pi / 4
    return side * np.pi / 2 if side else None
