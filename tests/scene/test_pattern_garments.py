# SPDX-License-Identifier: LGPL-3.0-or-later
"""Garments of a scene from flat patterns: around the wearer, dressed, walked."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

import meshes
from meshes.patterns import read_pattern
from meshes.patterns.crossings import crossings
from shellform.scene.garment import garment_of
from shellform.scene.parts import Garment, Motion, Output, Steps
from shellform.scene.scene import Scene
from shellform.scene.wearer import wearer_of
from shellform.simulation.model import Model
from shellform.simulation.run import run
from tests.meshes.patterns.drafts import FILES
from tests.ranks import outside

WALK = Scene(
    motion=Motion(start=1.5, end=1.7, initiation=0.4, obstacle=0.0),
    steps=Steps(runs=1),
    output=Output(checkpoint=0.1, pressure=0.0),
)


def of(name, **more):
    return replace(WALK, garment=Garment(file=str(FILES / f"{name}.json"), cell_size=0.04, **more))


@pytest.fixture(scope="module")
def wearer():
    return wearer_of(WALK)


@pytest.mark.serial
@pytest.mark.parametrize("name", ["skirt", "trousers"])
def test_sewn_around_the_wearer(name, wearer):
    """Where it hangs, with the openings that dressing asks for, nothing through anything."""
    surface = garment_of(of(name), wearer)
    hems = {"skirt": {"hem"}, "trousers": {"left_hem", "right_hem"}}[name]
    assert {"waist", *hems} <= set(surface.edges)
    assert surface.flat is not None and len(crossings(surface.points, surface.cells)) == 0
    # legs of the cloth about legs of the wearer; the panel called left is on the left
    if name == "trousers":
        left = surface.points[surface.cells[surface.panels["left_front"]]].mean(axis=(0, 1))
        assert left @ [0, 1, 0] > 0.03 and surface.directors.shape == surface.points.shape
        assert surface.cells.shape[1] == 4


@pytest.mark.serial
def test_a_shirt_is_sewn_and_refused(wearer):
    """Nothing hangs on shoulders here: it gets as far as the waist that it has not."""
    with pytest.raises(meshes.MeshError, match=r"shirt\.json: .*hangs on the shoulders"):
        garment_of(of("shirt"), wearer)


@pytest.mark.serial
def test_the_waist_may_be_named_by_an_edge_of_a_panel(wearer):
    """The opening that the edge is a part of."""
    named = garment_of(of("skirt", waist="band_front.2"), wearer)
    plain = garment_of(of("skirt"), wearer)
    assert np.array_equal(np.unique(named.edges["waist"]), np.unique(plain.edges["waist"]))


def test_keys_of_patterns_without_one(wearer):
    for given in ({"stitches": [["a.1", "b.2"]]}, {"about": {"front": "pelvis"}}):
        with pytest.raises(ValueError, match=r"are of sewing patterns, and there is no file"):
            garment_of(replace(WALK, garment=Garment(**given)), wearer)


@pytest.mark.serial
def test_other_garments_do_not_load_it():
    """Nor do files of meshes; readers of drawings wait for a drawing."""
    code = (
        "import sys; from shellform.simulation import model; from shellform.scene import scene, "
        "garment, wearer; s = scene.Scene(); garment.garment_of(s, wearer.wearer_of(s)); "
        "print([m for m in sys.modules if m.startswith(('meshes.patterns', 'ezdxf', 'svgel'))])"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, env=outside(), check=False
    )
    assert done.stdout.strip() == "[]", done.stdout + done.stderr


@pytest.mark.serial
@pytest.mark.slow
def test_it_weighs_what_its_panels_do(comm):
    """To half a per cent, whatever sewing has stretched; its energy is that of what is eased."""
    model = Model(of("skirt"), comm)
    pattern = read_pattern(FILES / "skirt.json")
    area = sum(panel.area for panel in pattern.panels)
    assert model.weight == pytest.approx(area * 0.21 * 9.81, rel=5e-3)
    assert np.isfinite(list(model.stepper.strain_energy().values())).all()


@pytest.mark.thorough
@pytest.mark.serial
@pytest.mark.parametrize("dressing", ["shell", "particles"])
@pytest.mark.parametrize("name", ["skirt", "trousers"])
def test_from_file_to_walked(name, dressing, tmp_path):
    """Sewn, put on, settled, and some steps of the walk; by both models of the cloth."""
    scene = replace(of(name), steps=Steps(runs=1, dressing=dressing))
    results = run(scene, tmp_path / "out", lines=False)
    fit = results["dressing"]
    assert fit["stretch"] < 0.1 and fit["depth"] < 5e-3
    assert np.isfinite([j["peak_torque"] for j in results["joints"].values()]).all()
