# SPDX-License-Identifier: LGPL-3.0-or-later
"""Garments of a scene from flat patterns: around the wearer, dressed, walked."""

import json
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

import meshes
from meshes.patterns import read_pattern
from meshes.patterns.crossings import crossings
from shellform.fem.lumped_mass import nodal_areas
from shellform.scene.garment import garment_of, stiffer_at_seams
from shellform.scene.parts import Garment, Motion, Output, Steps
from shellform.scene.scene import Scene
from shellform.scene.wearer import wearer_of
from shellform.simulation.run import run
from tests.meshes.patterns.drafts import FILES
from tests.meshes.patterns.test_drawings import CURVED, FRONT, dxf, piece, svg
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
    """Where it hangs, with the openings that dressing asks for, nothing through anything.

    The waist of the skirt is named by an edge of a panel that is a part of it.
    """
    named = {"waist": "band_front.2"} if name == "skirt" else {}
    surface = garment_of(of(name, **named), wearer)
    hems = {"skirt": {"hem"}, "trousers": {"left_hem", "right_hem"}}[name]
    assert {"waist", *hems} <= set(surface.edges)
    waist = np.unique(surface.edges["waist"])
    assert surface.points[waist, 2].min() > surface.points[:, 2].max() - 0.06
    # it weighs what its panels do, whatever sewing has stretched
    area = sum(panel.area for panel in read_pattern(FILES / f"{name}.json").panels)
    assert nodal_areas(surface).sum() == pytest.approx(area, rel=5e-3)
    assert surface.flat is not None and len(crossings(surface.points, surface.cells)) == 0
    # seams are as the cloth, or the cells on both sides of each are stiffer
    assert stiffer_at_seams(Garment(), surface) is None
    stiffer = stiffer_at_seams(Garment(seam_bending=4.0), surface)
    lines = [line for name, line in surface.edges.items() if name.startswith("seam_")]
    sewn = {frozenset(pair) for pair in np.concatenate(lines).tolist()}
    beside = [
        {frozenset(pair) for pair in zip(c, c[1:] + c[:1], strict=True)} & sewn
        for c in surface.cells.tolist()
    ]
    assert np.array_equal(stiffer, [4.0 if sides else 1.0 for sides in beside])
    assert sum(map(len, beside)) == 2 * len(sewn)
    # legs of the cloth about legs of the wearer; the panel called left is on the left
    if name == "trousers":
        left = surface.points[surface.cells[surface.panels["left_front"]]].mean(axis=(0, 1))
        assert left @ [0, 1, 0] > 0.03 and surface.directors.shape == surface.points.shape
        assert surface.cells.shape[1] == 4


def test_keys_of_patterns_without_one(wearer):
    with pytest.raises(ValueError, match=r"seam_bending = 3 is of sewing patterns, and sleeve"):
        stiffer_at_seams(Garment(seam_bending=3.0), meshes.sleeve(0.3, 0.3, 0.3))
    for given in ({"stitches": [["a.1", "b.2"]]}, {"about": {"front": "pelvis"}}):
        with pytest.raises(ValueError, match=r"are of sewing patterns, and there is no file"):
            garment_of(replace(WALK, garment=Garment(**given)), wearer)


@pytest.mark.serial
def test_other_garments_do_not_load_it():
    """Nor do files of meshes; readers of drawings wait for a drawing."""
    code = (
        "import sys; from shellform.scene import scene, garment, wearer; s = scene.Scene(); "
        "garment.garment_of(s, wearer.wearer_of(s)); "
        "rooms = ('meshes.patterns', 'meshes.garments.shirt', 'ezdxf', 'svgel', "
        "'shellform.motion.upper', 'shellform.motion.arm', 'shellform.scene.shirt', "
        "'shellform.dressing.shoulders'); "
        "print([m for m in sys.modules if m.startswith(rooms)])"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, env=outside(), check=False
    )
    assert done.stdout.strip() == "[]", done.stdout + done.stderr


@pytest.mark.serial
def test_panels_without_a_place_go_around_the_legs_named(wearer, tmp_path):
    """The trousers' file without its places: cylinders about the thighs, sewn as before."""
    data = json.loads((FILES / "trousers.json").read_text())
    for panel in data["pattern"]["panels"].values():
        del panel["translation"], panel["rotation"]
    (tmp_path / "unplaced.json").write_text(json.dumps(data))
    about = {name: f"{name.partition('_')[0]}_thigh" for name in data["pattern"]["panels"]}
    garment = Garment(file=str(tmp_path / "unplaced.json"), about=about, cell_size=0.04)
    surface = garment_of(replace(WALK, garment=garment), wearer)
    assert {"waist", "left_hem", "right_hem"} <= set(surface.edges)
    assert len(crossings(surface.points, surface.cells)) == 0
    for name, rows in surface.panels.items():
        aside = surface.points[surface.cells[rows], 1].mean()
        assert (aside > 0.03) == name.startswith("left")


def drawing(kind, folder):
    """A garment of two panels from a drawing, sewn by stitches of the scene."""
    if kind == "svg":
        path, sides = svg(folder / "skirt.svg"), (("right", "2"), ("left", "0"))
    else:
        turns = [("2", point) for point in FRONT]
        pieces = [piece(name, CURVED, points=turns) for name in ("front", "back")]
        path, sides = dxf(folder / "skirt.dxf", pieces), (("0", "2"), ("2", "0"))
    stitches = [[f"front.{one}", f"back.{other}"] for one, other in sides]
    return Garment(file=str(path), stitches=stitches, cell_size=0.04)


@pytest.mark.serial
@pytest.mark.parametrize("kind", ["dxf", "svg"])
def test_drawings_are_sewn_around_the_wearer(kind, wearer, tmp_path):
    surface = garment_of(replace(WALK, garment=drawing(kind, tmp_path)), wearer)
    assert {"waist", "hem"} <= set(surface.edges)
    assert len(crossings(surface.points, surface.cells)) == 0


@pytest.mark.thorough
@pytest.mark.serial
@pytest.mark.parametrize("dressing", ["shell", "particles"])
@pytest.mark.parametrize("name", ["skirt", "trousers", "dxf", "svg"])
def test_from_file_to_walked(name, dressing, tmp_path):
    """Sewn, put on, settled, and some steps of the walk; by both models of the cloth."""
    garment = drawing(name, tmp_path) if name in ("dxf", "svg") else of(name).garment
    scene = replace(WALK, garment=garment, steps=Steps(runs=1, dressing=dressing))
    results = run(scene, tmp_path / "out", lines=False)
    fit = results["dressing"]
    assert fit["settled"] and fit["stretch"] < 0.1 and fit["depth"] < 5e-3
    assert np.isfinite([j["peak_torque"] for j in results["joints"].values()]).all()
