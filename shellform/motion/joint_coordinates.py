# SPDX-License-Identifier: LGPL-3.0-or-later
"""A pose of the body as angles of its joints, and back.

Axes of each segment run ahead, to the left and up when the wearer stands. Those of a segment turn
against those of the segment above it by flexion about left, then by abduction about ahead, then by
rotation about up (Grood and Suntay, J. Biomech. Eng. 105, 1983); the pelvis turns against axes that
stand in the world. Each segment hangs at its hinge: hip, knee, ankle, the trunk at the top of the
pelvis, shoulder, elbow; the pelvis at its centre.

Ranges of motion are those of the American Academy of Orthopaedic Surgeons (Joint Motion, 1965),
where it gives them, with room for how markers sit.
"""

from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from contact.body.segment_frame import pose_from_markers

from .proportions import SIGN
from .recording import ALL_JOINTS, SEGMENTS, UPPER_SEGMENTS

ABOVE = {below: above for above, below, _ in ALL_JOINTS.values()}
HINGE = {below: hinge for _, below, hinge in ALL_JOINTS.values()}
CHAIN = (*SEGMENTS, *UPPER_SEGMENTS)  # each after the one that it hangs at
ORDER = "YXZ"

# segment -> (least, greatest) [rad] of flexion, abduction, rotation of the joint above it, flexion
# of the ankle upwards; of the pelvis against upright
RANGE_OF_MOTION = {
    kind: tuple(tuple(np.radians(pair)) for pair in ranges)
    for kind, ranges in {
        "pelvis": ((-40.0, 40.0), (-30.0, 30.0), (-45.0, 45.0)),
        "thigh": ((-30.0, 125.0), (-30.0, 45.0), (-45.0, 45.0)),
        "shank": ((-5.0, 150.0), (-10.0, 10.0), (-30.0, 30.0)),
        "foot": ((-50.0, 30.0), (-35.0, 35.0), (-35.0, 35.0)),
        "thorax": ((-30.0, 80.0), (-35.0, 35.0), (-45.0, 45.0)),
        "arm": ((-60.0, 180.0), (-10.0, 180.0), (-90.0, 90.0)),
        "forearm": ((-10.0, 150.0), (-20.0, 20.0), (-90.0, 90.0)),
    }.items()
}


class Coordinates(NamedTuple):
    """Tables by segment of n frames.

    angles : (n, 3) [rad], flexion, abduction, rotation against the segment above
    arms : (n, 3) [m], hinge from the hinge above, in the axes of the segment above; the pelvis's
        centre in the world
    local : (n, 3, 3) [m], J1, J2, M from the hinge in the segment's own axes
    """

    angles: dict
    arms: dict
    local: dict


def heading_axes(pelvis: np.ndarray) -> np.ndarray:
    """Axes (3, 3) in the world, columns ahead, left, up, of one who looks where J1-M points.

    pelvis : (3, 3), its J1, J2, M [m]
    """
    ahead = (pelvis[2] - pelvis[0]) * [1.0, 1.0, 0.0]
    ahead /= np.linalg.norm(ahead)
    up = np.array([0.0, 0.0, 1.0])
    return np.stack([ahead, np.cross(up, ahead), up], axis=1)


def coordinates(points: dict[str, np.ndarray], base: np.ndarray) -> Coordinates:
    """Coordinates of poses; points : segment -> (n, 3, 3) [m]; base : see `heading_axes`."""
    axes: dict[str, np.ndarray] = {}
    hinges: dict[str, np.ndarray] = {}
    angles, arms, local = {}, {}, {}
    for name in (n for n in CHAIN if n in points):
        track = points[name]
        centre, along = pose_from_markers(track[:, 0], track[:, 1], track[:, 2])
        axes[name] = anatomical_axes(name, along)
        hinge = centre
        above, upper = ABOVE.get(name), np.broadcast_to(base, axes[name].shape)
        arm = hinge
        if above is not None:
            segment, end = HINGE[name]
            hinge, upper = points[segment][:, end], axes[above]
            arm = _into(upper, hinge - hinges[above])
        hinges[name], arms[name] = hinge, arm
        turn = Rotation.from_matrix(np.swapaxes(upper, 1, 2) @ axes[name])
        angles[name] = np.unwrap(turn.as_euler(ORDER), axis=0) * _signs(name)
        local[name] = np.einsum("nji,npj->npi", axes[name], track - hinge[:, None])
    return Coordinates(angles, arms, local)


def points_of(angles: dict, arms: dict, local: dict, base: np.ndarray) -> dict[str, np.ndarray]:
    """Points, segment -> (n, 3, 3) [m], of coordinates; the inverse of `coordinates`."""
    axes, hinges, points = {}, {}, {}
    for name in (n for n in CHAIN if n in angles):
        turn = Rotation.from_euler(ORDER, angles[name] * _signs(name)).as_matrix()
        above = ABOVE.get(name)
        if above is None:
            axes[name], hinges[name] = base @ turn, arms[name]
        else:
            axes[name] = axes[above] @ turn
            hinges[name] = hinges[above] + np.einsum("nij,nj->ni", axes[above], arms[name])
        points[name] = hinges[name][:, None] + np.einsum("nij,npj->npi", axes[name], local[name])
    return points


def anatomical_axes(name: str, axes: np.ndarray) -> np.ndarray:
    """Columns ahead, left, up (n, 3, 3) of a segment from its rows e1, e2, e3 (n, 3, 3), Eq. 17."""
    e1, e2, e3 = np.moveaxis(axes, 1, 0)
    if name in ("pelvis", "thorax"):
        return np.stack([e2, -e3, -e1], axis=2)
    left = SIGN[name.split("_")[0]] * e2
    if name.endswith("foot"):
        return np.stack([e1, left, np.cross(e1, left)], axis=2)
    return np.stack([np.cross(e1, left), left, -e1], axis=2)


def _into(axes, vectors):
    return np.einsum("nji,nj->ni", axes, vectors)


def _signs(name):
    """Of the Euler angles, so that flexion, dorsiflexion and abduction outward are positive."""
    flexion = -1.0 if name.endswith(("thigh", "foot", "arm")) else 1.0
    side = name.split("_")[0]
    return np.array([flexion, SIGN.get(side, 1.0), 1.0])
