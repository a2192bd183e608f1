# SPDX-License-Identifier: LGPL-3.0-or-later
"""Numbers that must not depend on where in memory an array lies.

NumPy's sine, cosine, arc tangent, ... take vector instructions where input and output do not
overlap, else the C library, whose last digit differs. For arrays with gaps it looks at the ends of
the memory only: whether they overlap is then a matter of luck, and a walk that goes on differs from
one that was not stopped. Arrays without gaps are never taken to overlap.
"""

import numpy as np
import pytest

import meshes
from shellform.motion.gait.synthetic_walk import synthetic_walk
from shellform.scene.garment import garment_of
from shellform.scene.parts import Motion
from shellform.scene.scene import Scene
from shellform.scene.wearer import wearer_of

FUNCTIONS = ("sin", "cos", "tan", "arcsin", "arccos", "arctan", "arctan2", "exp", "log", "power")


@pytest.fixture
def gaps(monkeypatch):
    """Function that calls another and tells which functions of NumPy met arrays with gaps."""

    def watched(name, function, found):
        def call(*arrays, **options):
            for array in map(np.asarray, arrays):
                if array.size > 1 and not (array.flags.c_contiguous or array.flags.f_contiguous):
                    found.append((name, array.shape, array.strides))
            return function(*arrays, **options)

        return call

    def called(make):
        make()  # kernels that are compiled now want NumPy as it is
        found = []
        with monkeypatch.context() as patch:
            for name in FUNCTIONS:
                patch.setattr(np, name, watched(name, getattr(np, name), found))
            make()
        return found

    return called


@pytest.mark.parametrize("obstacle", [0.0, 0.3])
def test_walk(gaps, obstacle):
    assert gaps(lambda: synthetic_walk(strides=4, obstacle=obstacle, obstacle_stride=3)) == []


def test_wearer_and_garment(gaps):
    scene = Scene(motion=Motion(initiation=0.4))
    assert gaps(lambda: garment_of(scene, wearer_of(scene))) == []


SHAPES = {
    "cylinder": lambda: meshes.cylinder(0.1, 0.3, (8, 4)),
    "cap": lambda: meshes.spherical_cap(0.2, (0.6, 2.4), cells=(8, 4)),
    "triangles": lambda: meshes.cylinder(0.1, 0.3, (8, 4), triangles=True),
    "nine nodes": lambda: meshes.cylinder(0.1, 0.3, (8, 4), degree=2),
}


@pytest.mark.parametrize("name", SHAPES)
def test_shapes(gaps, name):
    assert gaps(SHAPES[name]) == []


def test_gaps_are_seen(gaps):
    assert gaps(lambda: np.sin(np.zeros((3, 2))[:, 0])) == [("sin", (3,), (16,))]


def test_a_walk_is_the_same_wherever_it_lies(rng=np.random.default_rng(0)):
    """Differed in every third on processors whose vector instructions have another last digit."""
    kept, walks = [], []
    for k in range(60):
        kept = kept if k % 7 else []
        kept += [np.empty(n) for n in rng.integers(1, 5000, 5)]
        walks.append(np.concatenate([*synthetic_walk(strides=3).points.values()]))
    assert all(np.array_equal(walk, walks[0]) for walk in walks)
