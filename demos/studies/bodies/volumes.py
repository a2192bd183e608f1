# SPDX-License-Identifier: LGPL-3.0-or-later
"""Volumes of the segments of the installed body through motions, turned triangles, crossings.

A triangle counts as turned where its normal looks away from where the rotations of its corners
carry the one at rest; crossings are edges that go through a triangle. Volumes of segments:
`shellform/motion/body_mesh/segment_volumes.py`.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from contact.body.segments import Pose
from contact.body.skinned_surface import SkinnedSurface
from contact.geometry.triangle_mesh.closed import volume
from contact.geometry.triangle_mesh.crossings import crossings
from shellform.motion.body_mesh.segment_volumes import SegmentVolumes
from shellform.motion.body_mesh.skin import skin_of
from shellform.motion.body_mesh.template import template
from shellform.motion.recording import SEGMENTS
from shellform.motion.wearer import Wearer

FRAME = 0.02  # [s]


def crosses(x: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Twice the areas of triangles times their normals."""
    a, b, c = (x[triangles[:, k]] for k in range(3))
    return np.cross(b - a, c - a)


def turned(skin: SkinnedSurface, pose: Pose, normals: np.ndarray, x: np.ndarray) -> int:
    """Triangles of a skin that look away, at x (n, 3), from where a pose carries their normals."""
    turns = [pose.axes[j].T @ skin.bound.axes[j] for j in range(len(skin.names))]
    q = Rotation.from_matrix(turns).as_quat()
    q *= np.where(q @ q[0] < 0, -1.0, 1.0)[:, None]
    T, of_vertex = skin.triangles, np.einsum("ik,ikc->ic", skin.weights, q[skin.which])
    carried = sum(Rotation.from_quat(of_vertex[T[:, k]]).apply(normals) for k in range(3))
    return int((np.einsum("ij,ij->i", carried, crosses(x, T)) <= 0).sum())


class Through(NamedTuple):
    """What a motion does to a skin, frame by frame.

    turned, crossings : (k,) int
    volumes : (k, m) of the segments, over those standing; whole : (k,) of all
    bends : (k, 4) of right and left hip, right and left knee [degree]
    """

    turned: np.ndarray
    crossings: np.ndarray
    volumes: np.ndarray
    whole: np.ndarray
    bends: np.ndarray


def through(skin: SkinnedSurface, wearer: Wearer) -> Through:
    """Through the motion of a wearer who stands at the start."""
    names = list(wearer.recording.points)
    which = np.array([names.index(name) for name in skin.names])
    T, x = skin.triangles, skin.positions(wearer.start, np.empty((skin.vertex_count, 3)))
    volumes = SegmentVolumes(skin, x.copy(), lambda t, out: wearer.segments_into(t, which, out))
    rest, whole, parts = crosses(x, T), volume(x, T), volumes(wearer.start, x)
    rows = []
    for t in np.arange(wearer.start, wearer.end, FRAME):
        skin.positions(t, x)
        pose = wearer.segment_pose(t, SEGMENTS)
        down = pose.axes[:, 0]
        turns = [down[a] @ down[b] for a, b in ((0, 1), (0, 4), (1, 2), (4, 5))]
        bends = np.degrees(np.arccos(np.clip(turns, -1, 1)))
        own = turned(skin, pose, rest, x), crossings(x, T)[0]
        rows.append((*own, volumes(t, x) / parts, volume(x, T) / whole, bends))
    return Through(*(np.array(column) for column in zip(*rows, strict=True)))


def volume_line(
    title: str, wearer: Wearer, sex: str, stature: float, girths: Mapping[str, float]
) -> str:
    """What becomes of a skin's volumes through the motion of a wearer who stands at the start."""
    skin = skin_of(wearer, template(sex), stature, girths)
    found = through(skin, wearer)
    hip, knee = found.bends.max(axis=0).reshape(2, 2).max(axis=1)
    change, whole = 100 * (found.volumes - 1.0), 100 * (found.whole - 1.0)
    named = ", ".join(
        f"{part} {change[:, pick].min():.1f} to {change[:, pick].max():+.1f}"
        for part, pick in parts_of(skin.names).items()
    )
    return (
        f"{sex}, {title} (hip {hip:.0f}, knee {knee:.0f} degrees): at most {found.turned.max()} of "
        f"{len(skin.triangles)} triangles turned, {found.crossings.max()} crossings; volume "
        f"{whole.min():.1f} to {whole.max():+.1f} % ({named})"
    )


def parts_of(names: Sequence[str]) -> dict[str, np.ndarray]:
    """Numbers of segments by their names without the side."""
    short = [name.split("_")[-1] for name in names]
    return {part: np.array([k for k, s in enumerate(short) if s == part]) for part in short}
