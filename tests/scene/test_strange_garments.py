# SPDX-License-Identifier: LGPL-3.0-or-later
"""Garments with pockets and bands in every format and with every fault: worn, or told the mend."""

import numpy as np
import pytest

import meshes
from shellform.scene.garment import garment_of, rotation_about
from shellform.scene.parts import Garment, Steps
from shellform.scene.scene import Scene
from shellform.scene.wearer import wearer_of
from shellform.simulation.check import check
from tests.meshes.strangers import FAULTS, FORMATS, KINDS

pytestmark = pytest.mark.serial
WORN = ("trousers", "shorts", "skirt")
TURNS = [
    (WORN[(axis + place) % 3], axis, angle)
    for axis in range(3)
    for place, angle in enumerate((90.0, 180.0, -90.0))
]


@pytest.fixture(scope="module")
def wearer():
    return wearer_of(Scene())


@pytest.fixture(scope="module")
def drawn():
    """{kind: points, faces}."""
    made = {kind: KINDS[kind]() for kind in KINDS}
    return {kind: (made[kind].points, made[kind].cells.tolist()) for kind in KINDS}


def area(points, faces):
    surface = meshes.Surface(points, np.array(faces), verify=False)
    return surface.area


@pytest.fixture
def put_on(tmp_path, wearer, drawn):
    """Function giving the garment of a file as it is worn, or raising what `check` would."""

    def wear(kind, fault="none", ending=".obj", change=lambda points: points, **keys):
        points, faces = FAULTS[fault](*drawn[kind])
        path = tmp_path / f"drawn{ending}"
        path.write_bytes(FORMATS[ending](change(points), faces))
        surface = garment_of(Scene(garment=Garment(file=str(path), **keys)), wearer)
        hems = {"hem"} if kind == "skirt" else {"left_hem", "right_hem"}
        assert {"waist", *hems} == set(surface.edges)
        return surface

    return wear


@pytest.mark.parametrize("ending", FORMATS)
def test_every_format(ending, put_on, drawn):
    """Pockets and all; where quads became triangles a few of a pocket's are the garment's own."""
    kind = "skirt" if ending in (".off", ".gltf") else "trousers"
    worn = put_on(kind, ending=ending).area
    cut = 5e-3 if ending in (".stl", ".glb", ".gltf") else 1e-6
    assert worn == pytest.approx(area(*drawn[kind]), rel=cut)


@pytest.mark.parametrize(
    ("kind", "fault", "keys"),
    [
        ("shorts", "mirrored", {}),
        ("trousers", "inside out", {}),
        ("shorts", "n-gons", {}),
        ("skirt", "isolated points", {}),
        ("trousers", "degenerate faces", {}),
        ("skirt", "own points", {"weld": 1e-6}),
        ("trousers", "doubled points", {"weld": 1e-4}),
        ("skirt", "T-junctions", {"weld": 1e-4}),
        ("shorts", "T-junctions", {"weld": 1e-4}),
    ],
)
def test_faults_that_are_mended(kind, fault, keys, put_on, drawn):
    worn = put_on(kind, fault, **keys)
    assert worn.area == pytest.approx(area(*drawn[kind]), rel=2e-3)


@pytest.mark.parametrize("kind", ["skirt", "polo"])
@pytest.mark.parametrize(
    ("fault", "mend"),
    [
        ("own points", "weld_m"),
        ("doubled points", "weld_m"),
        ("T-junctions", "weld_m"),
        ("thick", "midsurface = true"),
    ],
)
def test_faults_that_are_told_with_their_mend(kind, fault, mend, put_on):
    """Whatever is refused because of them names the key that mends it."""
    with pytest.raises(ValueError, match=rf"drawn\.obj.*{mend}"):
        put_on(kind, fault)


def test_a_thick_sheet_is_mended(put_on, drawn):
    worn = put_on("shorts", "thick", midsurface=True)
    assert worn.area == pytest.approx(area(*drawn["shorts"]), rel=0.01)


@pytest.mark.parametrize(("kind", "axis", "angle"), TURNS)
def test_turned_in_centimetres_and_too_high(kind, axis, angle, put_on):
    """It hangs where the one hangs that was drawn upright, at the waist's height."""
    turn = rotation_about(axis, angle)
    plain = put_on(kind, change=lambda points: points + [0.0, 0.0, 0.3])
    worn = put_on(kind, change=lambda p: 100.0 * (p + [0.0, 0.0, 0.3]) @ turn.T, unit="cm")
    assert worn.area == pytest.approx(plain.area)
    assert np.abs(np.sort(worn.points[:, 2]) - np.sort(plain.points[:, 2])).max() < 0.01


@pytest.mark.parametrize("unit", ["cm", "mm", "in"])
def test_the_unit_is_named(unit, put_on):
    size = meshes.files.load.UNITS[unit]
    with pytest.raises(ValueError, match=f'drawn.obj: .* unit = "{unit}" under'):
        put_on("trousers", change=lambda points: points / size)


@pytest.mark.parametrize("kind", ["shirt", "polo"])
def test_what_hangs_on_the_shoulders_is_refused(kind, put_on):
    with pytest.raises(ValueError, match="which hangs on the shoulders: of these sewing patterns"):
        put_on(kind)


def test_cells_that_no_springs_stand_for_are_refused_by_check(tmp_path):
    """Before anything is dressed."""
    plain = meshes.skirt(waist=1.0, hip=1.2, hem=1.5, cell_size=0.04)
    slender = plain.points.copy()
    heights = np.unique(np.round(plain.points[:, 2], 6))
    row = np.isclose(slender[:, 2], heights[3], atol=1e-5)
    slender[row, 2] = heights[2] + 0.002
    path = tmp_path / "slender.obj"
    path.write_bytes(FORMATS[".obj"](slender, plain.cells.tolist()))
    scene = Scene(garment=Garment(file=str(path)), steps=Steps(dressing="particles"))
    with pytest.raises(ValueError, match=r"cell \d+ of slender.obj is too slender"):
        check(scene)
