# SPDX-License-Identifier: LGPL-3.0-or-later
"""Volumes of segments: of a straight tube, and of one that moves as a whole or bends."""

import numpy as np
import pytest

from contact.body.skinned_surface import SkinnedSurface
from contact.geometry.triangle_mesh.closed import volume
from shellform.motion.body_mesh.segment_volumes import SegmentVolumes
from tests.contact.body.test_skinning import LONG, NAMES, RADIUS, bending, leg, rest


def tube(pose):
    points, triangles, weights = leg()
    skin = SkinnedSurface(points, triangles, weights, NAMES, pose, rest())
    return skin, points, SegmentVolumes(skin, points, pose)


def test_cut_of_a_straight_tube():
    """The rim lies between two rows, whose triangles are half of either: the cut is halfway."""
    skin, points, volumes = tube(lambda t, out: bending(0.0, out, rest()))
    around = 0.5 * 24 * np.sin(2 * np.pi / 24) * RADIUS**2
    thigh, shank = volumes(0.0, points)
    assert thigh + shank == pytest.approx(2 * LONG * around)
    rim = np.unique(skin.triangles[skin.owners == 0])
    rim = np.intersect1d(rim, np.unique(skin.triangles[skin.owners == 1]))
    assert shank == pytest.approx(around * (points[rim, 2].mean() + LONG), rel=1e-3)


def test_what_moves_as_a_whole_keeps_its_volumes_and_a_bent_leg_nearly():
    """A knee on the axis of the tube turns as much flesh in as out."""

    def carried(t, out):
        out = bending(t, out, rest())
        knee, turn = np.array([0.1, 0.2, 0.3]), out.axes[0].T @ rest().axes[0]
        for j in range(2):
            out.centres[j] = knee + turn @ rest().centres[j]
            out.axes[j] = rest().axes[j] @ turn.T
        return out

    for pose, within in ((carried, 1e-12), (lambda t, out: bending(t, out, rest()), 0.02)):
        skin, _, volumes = tube(pose)
        x = skin.positions(0.4, np.empty((skin.vertex_count, 3)))
        assert volumes(0.4, x) == pytest.approx(tube_volumes(), rel=within)
        assert volumes(0.4, x).sum() == pytest.approx(volume(x, skin.triangles))


def tube_volumes():
    _, points, volumes = tube(lambda t, out: bending(0.0, out, rest()))
    return volumes(0.0, points)
