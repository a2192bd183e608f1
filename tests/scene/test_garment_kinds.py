# SPDX-License-Identifier: LGPL-3.0-or-later
"""A kind of garment is one builder and one entry of `meshes.GARMENTS`; scenes know it by name."""

from dataclasses import replace

import numpy as np
import pytest

import meshes
from shellform.motion.recording import SIDES
from shellform.motion.stance import stance
from shellform.scene.fit import waist_height
from shellform.scene.garment import HIP_HEIGHT, garment_of
from shellform.scene.parts import Garment, Person
from shellform.scene.scene import Scene
from shellform.scene.wearer import wearer_of

SKIRT = Scene(garment=Garment(kind="skirt", cell_size=0.04))


def apron(waist_height, drop, girth=1.1, cell_size=0.02):
    """A tube from the waist down: all that a garment must have."""
    cells = (round(girth / cell_size), round(drop / cell_size))
    tube = meshes.cylinder(girth / (2 * np.pi), drop, cells)
    tube = tube.transform(translation=(0.0, 0.0, waist_height - drop))
    return tube.replace(edges={"waist": tube.edges["top"], "hem": tube.edges["bottom"]})


@pytest.fixture
def aprons(monkeypatch):
    monkeypatch.setitem(meshes.GARMENTS, "apron", meshes.Pattern(apron, lengths={"drop": 0.3}))


def test_a_new_kind_grows_with_the_wearer(aprons):
    """Its waist lies where a belt stays; lengths go with the height of the hips."""
    for stature in (1.7, 1.9):
        scene = Scene(person=Person(stature=stature), garment=Garment(kind="apron", cell_size=0.03))
        wearer = wearer_of(scene)
        low, high = garment_of(scene, wearer).bounds[:, 2]
        assert high == pytest.approx(waist_height(wearer), abs=1e-12)
        assert high - low == pytest.approx(0.3 * stance(wearer)[0] / HIP_HEIGHT, rel=1e-12)


def test_measures_of_the_kind_are_those_of_its_builder(aprons):
    scene = Scene(garment=Garment(kind="apron", cell_size=0.03, measures={"drop": 0.2}))
    low, high = garment_of(scene, wearer_of(scene)).bounds[:, 2]
    assert high - low == pytest.approx(0.2, rel=1e-12)
    wrong = replace(scene, garment=Garment(kind="apron", measures={"sleeve": 0.2}))
    with pytest.raises(ValueError, match="no 'sleeve' of apron; there are waist_height, drop, g"):
        garment_of(wrong, wearer_of(scene))


def test_a_skirt_hangs_around_both_legs():
    """Waist and hem go around the wearer, wide enough at the hips, the hem level."""
    wearer = wearer_of(SKIRT)
    surface = garment_of(SKIRT, wearer)
    hem = surface.points[np.unique(surface.edges["hem"])]
    pose = wearer.new_pose(wearer.start)
    for side in SIDES:
        centre = pose.centres[wearer.index(f"{side}_thigh")]
        assert hem[:, 1].min() < centre[1] < hem[:, 1].max()
    assert np.ptp(hem[:, 2]) < 1e-9
    big = replace(SKIRT, person=Person(girths={"hip": 1.3}))
    with pytest.raises(ValueError, match=r"1\.300 m around the hips"):
        garment_of(big, wearer_of(big))


@pytest.mark.parametrize(
    ("garment", "words"),
    [
        (Garment(kind="toga"), "garment.kind: no garment is called 'toga'; there are trousers, sk"),
        (Garment(kind="skirt", size="small-long"), "'small-long', and a skirt has no sizes"),
    ],
)
def test_kinds_and_sizes_that_are_not_there(garment, words):
    scene = Scene(garment=garment)
    with pytest.raises(ValueError, match=words):
        garment_of(scene, wearer_of(scene))
