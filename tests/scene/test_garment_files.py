# SPDX-License-Identifier: LGPL-3.0-or-later
"""Garments from files as strangers have them: turned, off their place, in other units, sewn."""

import re

import numpy as np
import pytest

import meshes
from shellform.dressing.fit import stretch_warning
from shellform.scene.fit import girth_at, waist_height
from shellform.scene.garment import garment_of, rotation_about
from shellform.scene.parts import Garment
from shellform.scene.scene import Scene
from shellform.scene.scene_file import read_scene
from shellform.scene.wearer import wearer_of
from tests.meshes.sewn import pocketed_trousers, with_patch
from tests.meshes.strangers import polo

Z90, Z180, Z30 = rotation_about(2, 90.0), rotation_about(2, 180.0), rotation_about(2, 30.0)
Y_UP = np.array([[0.0, 1, 0], [0, 0, 1], [1, 0, 0]])  # left, up, front
Y_UP_FACING_X = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])


@pytest.fixture(scope="module")
def wearer():
    return wearer_of(Scene())


@pytest.fixture(scope="module")
def trousers():
    plain = meshes.trousers("large-regular", cell_size=0.04)
    return {"plain": plain, "pockets": pocketed_trousers()}


def write(surface, path, turn=None, shift=(0.0, 0.0, 0.0), scale=1.0):
    turn = np.eye(3) if turn is None else turn
    points = scale * (surface.points @ turn.T + shift)
    lines = [f"v {x} {y} {z}" for x, y, z in points.tolist()]
    lines += ["f " + " ".join(str(k + 1) for k in row) for row in surface.cells.tolist()]
    path.write_text("\n".join(lines) + "\n")
    return str(path)


def worn(path, wearer, **more):
    return garment_of(Scene(garment=Garment(file=path, **more)), wearer)


TURNS = {
    "left": (Z90, "legs lie side by side"),
    "right": (Z90.T, "legs lie side by side"),
    "back to front": (Z180, "higher side of the waist is the back"),
    "a little": (Z30, "30 degrees about z"),
    "y up": (Y_UP, "y is up"),
    "y up, facing x": (Y_UP_FACING_X, "y is up"),
    "upside down": (np.diag([1.0, -1.0, -1.0]), "-z is up"),
}


@pytest.mark.parametrize("kind", ["plain", "pockets"])
@pytest.mark.parametrize("name", TURNS)
def test_turned_garments(name, kind, tmp_path, wearer, trousers):
    """Upright, legs beside each other, its front forward: where it was before it was turned."""
    turn, words = TURNS[name]
    surface = worn(write(trousers[kind], tmp_path / "x.obj", turn), wearer)
    same = worn(write(trousers[kind], tmp_path / "y.obj"), wearer)
    assert np.abs(surface.points - same.points).max() < 1e-9
    assert words in surface.notes[-1]
    assert {"waist", "left_hem", "right_hem"} <= set(surface.edges)


def test_a_turn_of_the_users_own(tmp_path, wearer, trousers):
    path = write(trousers["plain"], tmp_path / "x.obj", Y_UP_FACING_X)
    surface = worn(path, wearer, turn=[90, 0, 0])
    same = worn(write(trousers["plain"], tmp_path / "y.obj"), wearer)
    assert np.abs(surface.points - same.points).max() < 1e-9
    with pytest.raises(ValueError, match="not left and right of its waist: turn it"):
        worn(write(trousers["plain"], tmp_path / "z.obj", Z90), wearer, turn=[0, 0, 0])
    with pytest.raises(ValueError, match=r"garment.turn is three numbers, angles in degrees"):
        Scene(garment=Garment(turn=[90]))


@pytest.mark.parametrize("shift", [(0, 0, 0.3), (0, 0, 0.6), (0, 0, -1.0), (2.0, -1.0, 0)])
@pytest.mark.parametrize("waist", ["waist", "highest"])
@pytest.mark.parametrize("kind", ["plain", "pockets"])
def test_garments_off_their_place(shift, waist, kind, tmp_path, wearer, trousers):
    """Moved to the wearer's waist, which is told; left there on request, and then refused."""
    path = write(trousers[kind], tmp_path / "x.obj", shift=shift)
    surface = worn(path, wearer, waist=waist)
    middle = surface.points[np.unique(surface.edges["waist"])].mean(axis=0)
    assert abs(middle[2] - waist_height(wearer)) <= 0.08
    hems = np.concatenate([surface.edges["left_hem"], surface.edges["right_hem"]])
    assert surface.points[hems, 2].min() > 0.04
    assert "to the wearer's waist" in surface.notes[-1]
    if shift[2]:
        said = f"waist of x.obj lies at .* m, .* m {'above' if shift[2] > 0 else 'below'} .*place_m"
        with pytest.raises(ValueError, match=said):
            worn(path, wearer, waist=waist, place=[0, 0, 0])


def test_a_garment_five_centimetres_low_is_worn(tmp_path, wearer, trousers):
    """The uneven rim of its waist is cut at the hips: parts of a section are no girth."""
    surface = worn(write(trousers["plain"], tmp_path / "x.obj", shift=(0, 0, -0.05)), wearer)
    plain = worn(write(trousers["plain"], tmp_path / "y.obj"), wearer)
    assert np.abs(surface.points - plain.points).max() < 1e-3 and "moved" in surface.notes[-1]


def test_centimetres(tmp_path, wearer, trousers):
    path = write(trousers["pockets"], tmp_path / "x.obj", Z90, (0, 0, 0.3), 100.0)
    with pytest.raises(ValueError, match=r"x.obj: .*cm taken for m.* unit = \"cm\" under"):
        worn(path, wearer)
    assert worn(path, wearer, unit="cm").area > trousers["plain"].area


@pytest.mark.parametrize("waist", ["waist", "highest"])
def test_a_polo_is_refused(waist, tmp_path, wearer):
    """It is read, collar, placket and all; but it hangs on the shoulders."""
    shirt = meshes.orient(polo(), majority=True).replace(verify=True)
    assert len(meshes.boundary_loops(shirt)) == 4
    path = write(shirt, tmp_path / "polo.obj")
    with pytest.raises(ValueError, match=r"polo.obj.*(hangs on the shoulders|sleeve is no leg)"):
        worn(path, wearer, waist=waist)


def test_a_skirt_at_the_calves_is_refused(tmp_path, wearer):
    low = Garment(kind="skirt", measures={"waist_height": 0.45, "length": 0.3})
    with pytest.raises(ValueError, match=r"the waist of .* lies at 0.4\d m, .* below the wearer's"):
        garment_of(Scene(garment=low), wearer)


def test_girth_counts_no_cloth_twice():
    """Around a tube with a patch it is that of the tube; at a slit there is none."""
    tube = meshes.cylinder(0.2, 0.6, (24, 10), angle=2 * np.pi)
    middle = tube.points[tube.cells].mean(axis=1)
    chosen = (middle[:, 0] > 0.1) & (np.abs(middle[:, 2] - middle[:, 2].mean()) < 0.2)
    sewn = meshes.orient(with_patch(tube, chosen, off=0.01), majority=True).replace(verify=True)
    level, exact = middle[:, 2].mean() + 1e-3, 24 * 2 * 0.2 * np.sin(np.pi / 24)
    every = np.ones(len(sewn.cells), bool)
    assert girth_at(sewn, level, every) == pytest.approx(exact, rel=1e-9)
    every[: len(tube.cells)] &= ~((np.abs(middle[:, 1]) < 0.03) & (middle[:, 0] < 0))
    assert girth_at(sewn, level, every) == 0.0


def test_byte_order_mark(tmp_path):
    (tmp_path / "x.toml").write_bytes(b"\xef\xbb\xbftitle = 'with a mark'\r\n")
    assert read_scene(tmp_path / "x.toml").title == "with a mark"


def test_stretch_is_told_and_refused():
    """Up to that of suiting no word, up to what the garment bears a warning, then an end."""
    assert stretch_warning(0.05, 0.18, "x.obj") is None
    assert re.match(
        r"warning: x.obj: .* by 12 %.*larger size", stretch_warning(0.12, 0.18, "x.obj")
    )
    for stretch in (0.19, 0.84, np.nan):
        with pytest.raises(
            ValueError, match=r"x.obj: .* bears 18 % \(garment.max_elongation.*mall"
        ):
            stretch_warning(stretch, 0.18, "x.obj")
    assert stretch_warning(0.3, 0.5, "knit.obj") and stretch_warning(0.02, 0.03, "x.obj") is None
