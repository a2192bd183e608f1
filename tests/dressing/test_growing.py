# SPDX-License-Identifier: LGPL-3.0-or-later
"""A skin that grows inside a garment: thin enough at first, from there to exactly its own shape."""

import numpy as np
import pytest

import meshes
from contact.body.surface_motion import SurfaceMotion
from contact.geometry.triangle_mesh.closed import volume
from shellform.dressing.growing import CLEAR, FLAT, SHRUNK, Growing, shrunk_for
from shellform.motion.anthropometry import ellipsoids
from shellform.motion.body_mesh.skin import skin_of
from shellform.motion.gait.synthetic_walk import synthetic_walk
from shellform.motion.proportions import STATURE
from shellform.motion.wearer import Wearer
from tests.motion.body_mesh.manikin import manikin

pytestmark = pytest.mark.serial


@pytest.fixture(scope="module")
def standing():
    """The wearer and the skin of a manikin."""
    walk = synthetic_walk(strides=1, obstacle=0.0)
    wearer = Wearer(walk, ellipsoids(walk.lengths()))
    return wearer, skin_of(wearer, manikin(), STATURE)


def test_grows_outwards_to_its_own_shape(standing):
    wearer, skin = standing
    growing = Growing(skin, wearer, -0.5, 0.4, 0.45)
    assert isinstance(growing, SurfaceMotion)
    whole = skin.positions(wearer.start, np.empty((skin.vertex_count, 3))).copy()
    volumes = []
    for t in (-0.6, -0.5, -0.3, -0.1, 0.0):
        x = growing.positions(t, np.empty_like(whole)).copy()
        volumes.append(volume(x, skin.triangles))
    assert volumes[0] == volumes[1] < 0.5 * volumes[-1]
    assert sorted(volumes) == volumes and np.abs(x - whole).max() < 1e-15
    # a slice of a shank shrinks about the line of its joints, feet to the floor
    first = growing.positions(-0.5, np.empty_like(whole))
    at = np.abs(whole[:, 2] - 0.30) < 0.012
    at &= whole[:, 1] > 0
    ratio = np.ptp(first[at, 0]) / np.ptp(whole[at, 0])
    assert ratio == pytest.approx(0.55, abs=0.03)
    toes = whole[:, 0] > 0.15
    assert (first[toes, 2] <= 2 * (1 - FLAT) * whole[toes, 2] + 1e-12).all()
    assert np.abs(first - whole)[toes, 0].max() < 0.01  # they push no hem ahead of them
    book, pushed = np.zeros((2, len(skin.names), 9)), np.ones((skin.vertex_count, 6))
    growing.add_to_segments(0.0, pushed, book[0])
    skin.add_to_segments(0.0, pushed, book[1])
    assert (book[0] == book[1]).all()
    assert (growing.centres(0.0, np.empty((7, 3))) == skin.centres(0.0, np.empty((7, 3)))).all()


def winding(vertices, triangles, points):
    """Whether points (k, 3) lie inside: solid angles (van Oosterom and Strackee)."""
    a, b, c = (vertices[triangles[:, k]][None] - points[:, None] for k in range(3))
    sizes = [np.linalg.norm(arm, axis=2) for arm in (a, b, c)]
    triple = np.einsum("ijk,ijk->ij", a, np.cross(b, c))
    one, two, three = (np.einsum("ijk,ijk->ij", p, q) for p, q in ((a, b), (b, c), (c, a)))
    below = sizes[0] * sizes[1] * sizes[2] + one * sizes[2] + two * sizes[0] + three * sizes[1]
    return 2 * np.arctan2(triple, below).sum(axis=1) > 2 * np.pi


def test_begins_clear_of_the_garment(standing):
    """Short in rise, the garment asks for a thinner body; its place from another distance."""
    wearer, skin = standing
    shrunk = []
    for rise in (0.795, 0.85):
        garment = meshes.trousers("medium-regular", fork_height=rise, cell_size=0.04)
        shrunk.append(shrunk_for(skin, wearer, garment))
        x = Growing(skin, wearer, 0.0, 1.0, shrunk[-1]).positions(
            0.0, np.empty((skin.vertex_count, 3))
        )
        points = garment.points[::8]
        assert not winding(x, skin.triangles, points).any()
        nearest = min(np.linalg.norm(points[:, None] - x[None], axis=2).min(axis=1))
        assert nearest >= CLEAR  # the nearest vertex is no nearer than the surface
    assert SHRUNK[0] == shrunk[0] < shrunk[1]


def test_a_garment_beside_the_legs_is_refused(standing):
    garment = meshes.trousers("medium-regular", cell_size=0.04).transform(translation=(0, 0.1, 0))
    with pytest.raises(
        ValueError, match=r"lies inside it, first at .* does not go around the legs"
    ):
        shrunk_for(standing[1], standing[0], garment)
