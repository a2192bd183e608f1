# SPDX-License-Identifier: LGPL-3.0-or-later
"""Whether points of segments can be those of a person: sides, axes, speeds.

Points are tracks, segment -> (n, 3, 3) float [m]: frame, point (J1, J2, M), coordinate. Whatever is
wrong with them is mostly a label at the wrong marker, and says so in one sentence.
"""

from collections.abc import Mapping

import numpy as np

from shellform.errors import Mendable
from shellform.motion.recording import SIDES

from .gait_events import forward

LEVER = 0.010  # least distance of M from the line J1-J2 [m]
SHORTEST = 0.01  # of a segment [m]
# knees or ankles past each other that are no swapped labels [m]: who balances, or walks on a line,
# crosses them by less; swapped ones are off by the base of a gait, some 80 mm and more
CROSSED = 0.03
FASTEST = 30.0  # a kicking foot moves at 20 to 25 m/s


def require_shape(points: Mapping[str, np.ndarray], times: np.ndarray, source: str) -> None:
    """Refuse segments without length, and points that are no numbers: markers that coincide."""
    for name, track in points.items():
        length = np.linalg.norm(track[:, 1] - track[:, 0], axis=1)
        bad = ~np.isfinite(track).all(axis=(1, 2)) | ~(length > SHORTEST)
        if bad.any():
            raise ValueError(
                f"{source}: J1 and J2 of '{name}' coincide, or are nowhere, at t = "
                f"{times[int(np.argmax(bad))]:.3f} s; two markers have one place, correct them"
            )


def mirrored(points: Mapping[str, np.ndarray]) -> bool:
    """Whether right hip minus left, crossed with the pelvis' forward direction, points down.

    True for labels of the wrong side, and for a file whose axes are left-handed: for a body these
    are the same.
    """
    if not {"pelvis", "right_thigh", "left_thigh"} <= points.keys():
        return False
    across = points["right_thigh"][:, 0] - points["left_thigh"][:, 0]
    return bool(np.median(np.cross(across, forward(points["pelvis"]))[:, 2]) < 0)


def require_sides(points: Mapping[str, np.ndarray], source: str) -> None:
    """Refuse knees and feet on the wrong side, and toes behind the heels."""
    if not {"pelvis", "right_thigh", "left_thigh"} <= points.keys():
        return
    ahead = forward(points["pelvis"])
    right = np.cross(ahead, [0.0, 0.0, 1.0])
    for part in ("thigh", "shank"):
        pair = [points[f"{side}_{part}"] for side in SIDES if f"{side}_{part}" in points]
        if len(pair) < 2:
            continue
        apart = np.median(np.sum((pair[0] - pair[1])[:, 1] * right, axis=1))
        if apart < -CROSSED:
            raise ValueError(
                f"{source}: pelvis and legs disagree about right and left, as the end of "
                f"right_{part} is {-1e3 * apart:.0f} mm left of the other; swap these labels"
            )
        for side, track, sign in zip(SIDES, pair, (1, -1)):
            if np.median(np.sum((track[:, 2] - track[:, 1]) * right, axis=1)) * sign < 0:
                raise ValueError(
                    f"{source}: M of {side}_{part} lies inward of its joint; lateral and medial "
                    "labels are swapped"
                )
    for side in SIDES:
        foot = points.get(f"{side}_foot")
        if foot is not None and np.median(np.sum((foot[:, 1] - foot[:, 0]) * ahead, axis=1)) < 0:
            raise ValueError(
                f"{source}: the {side} toes are behind the heel; labels of heel and toe, or of "
                "front and back of the pelvis, are swapped"
            )


def require_lever(points: Mapping[str, np.ndarray], times: np.ndarray, source: str) -> None:
    """Refuse an M so close to the line J1-J2 that it does not tell the segment's turn about it."""
    for name, track in points.items():
        along, arm = track[:, 1] - track[:, 0], track[:, 2] - track[:, 0]
        along /= np.linalg.norm(along, axis=1, keepdims=True)
        lever = np.linalg.norm(arm - np.sum(arm * along, axis=1, keepdims=True) * along, axis=1)
        worst = int(np.argmin(lever))
        if lever[worst] < LEVER:
            raise ValueError(
                f"{source}: M of '{name}' is {1e3 * lever[worst]:.1f} mm off the line J1-J2 at t = "
                f"{times[worst]:.3f} s; at least {1e3 * LEVER:.0f} mm tell the turn about it, take "
                "another marker"
            )


def require_pace(points: Mapping[str, np.ndarray], times: np.ndarray, source: str) -> None:
    """Refuse points that move faster than a person does."""
    for name, track in points.items():
        speed = np.linalg.norm(np.diff(track, axis=0), axis=2) / np.diff(times)[:, None]
        frame = int(np.argmax(speed.max(axis=1)))
        if speed[frame].max() > FASTEST:
            raise Mendable(
                f"{source}: '{name}' moves at {speed[frame].max():.0f} m/s at t = "
                f"{times[frame]:.3f} s, and nobody is faster than {FASTEST:.0f} m/s",
                "correct the rate or the markers, cut the capture with {window}, or lower {cutoff}",
            )
