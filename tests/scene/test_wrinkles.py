# SPDX-License-Identifier: LGPL-3.0-or-later
"""garment.wrinkles: cloth whose folds the cells do not show is relaxed, armour is not."""

import numpy as np
import pytest

import meshes
from shellform import Fabric, Shell
from shellform.scene.garment import wrinkles_of
from shellform.scene.parts import Garment

SIZE = 0.02  # of the cells [m]


def cells(**options):
    return meshes.rectangle(10 * SIZE, 10 * SIZE, (10, 10), warp=(1.0, 0.0, 0.0), **options)


def held(length, weaker=1.0):
    """Fabric of a bending length [m] along the warp; along the weft `weaker` times as stiff."""
    areal = 0.2
    bending = areal * 9.81 * length**3
    D = np.diag([bending, weaker * bending, 0.4 * bending])
    return Fabric.from_stiffness(np.diag([1e4, 1e4, 1e3]), D, areal, 1e-3)


def test_bending_length_is_what_it_is_taken_for():
    assert held(0.05).bending_length(degrees=0.0) == pytest.approx(0.05, rel=0.01)


@pytest.mark.parametrize("share", [0.3, 1.0, 3.0, 3.9])
def test_auto_relaxes_cloth_whose_folds_its_cells_do_not_show(share):
    """Up to a bending length of four cells."""
    assert wrinkles_of(Garment(), cells(), held(share * SIZE)) == "relaxed"


@pytest.mark.parametrize("share", [4.1, 10.0, 100.0])
def test_auto_leaves_armour_as_it_is(share):
    assert wrinkles_of(Garment(), cells(), held(share * SIZE)) == "resolved"


def test_auto_looks_at_the_weaker_direction():
    assert wrinkles_of(Garment(), cells(), held(10 * SIZE)) == "resolved"
    assert wrinkles_of(Garment(), cells(), held(10 * SIZE, weaker=0.2**3)) == "relaxed"


def test_finer_cells_resolve_what_coarse_ones_do_not():
    fabric = held(4.1 * SIZE)
    coarse = meshes.rectangle(10 * SIZE, 10 * SIZE, (5, 5), warp=(1.0, 0.0, 0.0))
    assert wrinkles_of(Garment(), coarse, fabric) == "relaxed"
    assert wrinkles_of(Garment(), cells(), fabric) == "resolved"


def test_what_is_asked_for_is_taken():
    for word in ("relaxed", "resolved"):
        for share in (0.3, 10.0):
            assert wrinkles_of(Garment(wrinkles=word), cells(), held(share * SIZE)) == word


@pytest.mark.parametrize("mesh", [{"triangles": True}, {"degree": 2}])
def test_other_cells_are_left_as_they_are_and_refused(mesh, comm):
    """What `auto` says can always be made."""
    surface, fabric = cells(**mesh), held(0.3 * SIZE)
    found = wrinkles_of(Garment(), surface, fabric)
    assert found == "resolved"
    Shell(surface, fabric, comm, wrinkles=found)
    with pytest.raises(ValueError, match=r"garment\.wrinkles = 'relaxed' is for 4-node quads"):
        wrinkles_of(Garment(wrinkles="relaxed"), surface, fabric)
