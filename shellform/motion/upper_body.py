# SPDX-License-Identifier: LGPL-3.0-or-later
"""Trunk and arms of a wearer whose garment hangs on the shoulders: where a capture does not tell.

What of thorax, upper arms and forearms a recording lacks is put in a neutral pose on the segment
above: the thorax upright on the pelvis, arms hanging from it, ABDUCTED outwards, elbows bent by
BENT. Nothing here is read or made for garments that hang at the waist.

Levels are heights at a stature of 1.755 m, means of ANSUR II men (Gordon et al., NATICK/TR-15/007,
2014), over hip centres 0.920 m high: cervicale 1.517, suprasternale 1.434, acromion 1.440; half the
biacromial breadth of 0.416; acromion to radiale 0.335, radiale to stylion 0.268. The shoulder joint
is 10.4 % of the first length below the acromion (de Leva, J. Biomech. 29, 1996); how far inward,
INWARD, is estimated. Xiphoid and tenth thoracic vertebra at 1.25 are estimated too.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from contact.body.segment_frame import pose_from_markers

from .joint_coordinates import anatomical_axes
from .proportions import SIGN, STATURE
from .recording import SIDES, UPPER_SEGMENTS, Recording

ABDUCTED, BENT = np.radians(30.0), np.radians(10.0)
HIPS = 0.920  # height of the hip centres [m]
TOP, LOW = 0.5 * (1.517 + 1.434) - HIPS, 1.25 - HIPS  # of the thorax over the hip centres [m]
ACROMION, BREADTH = 1.440 - HIPS, 0.416  # [m]
ARM, FOREARM = 0.335, 0.268  # [m]
BELOW = 0.104 * ARM  # the acromion: shoulder joint [m]
INWARD = 0.028  # of the acromion, which the breadth is measured over [m]
FRONT, ASIDE = 0.09, 0.04  # M of the thorax and of the arms from their axes [m]


def with_upper_body(recording: Recording, stature: float | None = None) -> Recording:
    """The recording with all of UPPER_SEGMENTS; those it lacks ride in a neutral pose, and a note.

    Parameters
    ----------
    stature : [m], None: 1.755 m
    """
    missing = [name for name in UPPER_SEGMENTS if name not in recording.points]
    if not missing:
        return recording
    points = {**recording.points}
    for name, track in neutral(recording.points, stature).items():
        points.setdefault(name, track)
    said = "trunk and arms" if "thorax" in missing else ", ".join(missing).replace("_", " ")
    note = (
        f"{said} not in the motion, assumed: "
        f"{'the trunk rigid with the pelvis, ' if 'thorax' in missing else ''}arms hanging, "
        f"{np.degrees(ABDUCTED):.0f} degrees outwards, elbows bent by {np.degrees(BENT):.0f}"
    )
    return replace(recording, points=points, notes=(*recording.notes, note))


def neutral(points: dict[str, np.ndarray], stature: float | None = None) -> dict[str, np.ndarray]:
    """Points (n, 3, 3) [m] of UPPER_SEGMENTS in a neutral pose, each on the one above it.

    points : segment -> (n, 3, 3), with the pelvis; the pose of an upper segment that is there
    decides where those below it hang
    """
    scale = (STATURE if stature is None else stature) / STATURE
    out: dict[str, np.ndarray] = {}

    def on(above: str, end: int, local: np.ndarray) -> np.ndarray:
        """Points `local` (3, 3), from an end of the segment above along ahead, left, up."""
        track = points.get(above, out.get(above))
        assert track is not None  # each after the one it hangs at
        _, rows = pose_from_markers(track[:, 0], track[:, 1], track[:, 2])
        axes = anatomical_axes(above, rows)
        return track[:, end, None] + np.einsum("nij,pj->npi", axes, scale * local)

    out["thorax"] = on("pelvis", 1, np.array([[0, 0, TOP], [0, 0, LOW], [FRONT, 0, TOP]]))
    for side in SIDES:
        outward = SIGN[side] * np.array([0.0, 1.0, 0.0])
        shoulder = (0.5 * BREADTH - INWARD) * outward + [0.0, 0.0, ACROMION - BELOW - TOP]
        hanging = Rotation.from_rotvec([SIGN[side] * ABDUCTED, 0.0, 0.0])
        elbow = np.array([0.0, 0.0, BELOW - ARM])
        arm = shoulder + hanging.apply([0.0 * elbow, elbow, elbow + ASIDE * outward])
        out[f"{side}_upper_arm"] = on("thorax", 0, arm)
        bent = Rotation.from_rotvec([0.0, -BENT, 0.0])
        wrist = np.array([0.0, 0.0, -FOREARM])
        forearm = bent.apply([0.0 * wrist, wrist, ASIDE * outward])
        out[f"{side}_forearm"] = on(f"{side}_upper_arm", 1, forearm)
    return out


def abduction(points: dict[str, np.ndarray]) -> float:
    """Mean angle [rad] of both upper arms from straight down along the thorax, in one frame.

    points : segment -> (3, 3) [m]; outwards in the plane of the breadth of the thorax
    """
    _, rows = pose_from_markers(*points["thorax"][:, None])
    _, left, up = anatomical_axes("thorax", rows)[0].T
    angles = []
    for side in SIDES:
        shoulder, elbow, _ = points[f"{side}_upper_arm"]
        arm = elbow - shoulder
        angles.append(np.arctan2(SIGN[side] * arm @ left, -arm @ up))
    return float(np.mean(angles))


def arms_raised(
    points: dict[str, np.ndarray], angle: float | np.ndarray, sides: tuple[str, ...] = SIDES
) -> dict[str, np.ndarray]:
    """Points (n, 3, 3) [m] of all segments, the arms turned outwards about their shoulders.

    angle : [rad], one or (n,); sides : of the arms that are
    """
    thorax = points["thorax"]
    _, rows = pose_from_markers(thorax[:, 0], thorax[:, 1], thorax[:, 2])
    ahead = anatomical_axes("thorax", rows)[:, :, 0]
    out = dict(points)
    for side in sides:
        turn = Rotation.from_rotvec(SIGN[side] * np.reshape(angle, (-1, 1)) * ahead).as_matrix()
        shoulder = points[f"{side}_upper_arm"][:, :1]
        for part in ("upper_arm", "forearm"):
            name = f"{side}_{part}"
            out[name] = shoulder + np.einsum("nij,npj->npi", turn, points[name] - shoulder)
    return out
