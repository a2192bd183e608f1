# SPDX-License-Identifier: LGPL-3.0-or-later
"""A skin that grows under cloth: from inside its limbs to exactly its own shape."""

import numpy as np
import pytest

from contact.body.surface_motion import SurfaceMotion
from contact.geometry.triangle_mesh.closed import volume
from shellform.dressing.growing import SHRUNK, Growing
from shellform.motion.anthropometry import ellipsoids
from shellform.motion.body_mesh.skin import skin_of
from shellform.motion.gait.synthetic_walk import synthetic_walk
from shellform.motion.proportions import STATURE
from shellform.motion.wearer import Wearer
from tests.motion.body_mesh.manikin import manikin


@pytest.mark.serial
def test_grows_outwards_to_its_own_shape():
    walk = synthetic_walk(strides=1, obstacle=0.0)
    wearer = Wearer(walk, ellipsoids(walk.lengths()))
    skin = skin_of(wearer, manikin(), STATURE)
    growing = Growing(skin, wearer, -0.5, 0.4)
    assert isinstance(growing, SurfaceMotion)
    whole = skin.positions(wearer.start, np.empty((skin.vertex_count, 3))).copy()
    volumes = []
    for t in (-0.6, -0.5, -0.3, -0.1, 0.0):
        x = growing.positions(t, np.empty_like(whole)).copy()
        volumes.append(volume(x, skin.triangles))
    assert volumes[0] == volumes[1] < 0.5 * volumes[-1]
    assert sorted(volumes) == volumes and np.abs(x - whole).max() < 1e-15
    # a slice of a shank shrinks about the line of its joints
    first = growing.positions(-0.5, np.empty_like(whole))
    at = np.abs(whole[:, 2] - 0.30) < 0.012
    at &= whole[:, 1] > 0
    ratio = np.ptp(first[at, 0]) / np.ptp(whole[at, 0])
    assert ratio == pytest.approx(1 - SHRUNK, abs=0.03)
    book, pushed = np.zeros((2, len(skin.names), 9)), np.ones((skin.vertex_count, 6))
    growing.add_to_segments(0.0, pushed, book[0])
    skin.add_to_segments(0.0, pushed, book[1])
    assert (book[0] == book[1]).all()
    assert (growing.centres(0.0, np.empty((7, 3))) == skin.centres(0.0, np.empty((7, 3)))).all()
