# SPDX-License-Identifier: LGPL-3.0-or-later
"""Garments from files as strangers have them: turned, off their place, in other units, sewn."""

import numpy as np
import pytest

import meshes
from shellform.dressing.fit import BEARS, too_stretched
from shellform.scene.fit import girth_at, waist_height
from shellform.scene.garment import garment_of, rotation_about
from shellform.scene.parts import Garment
from shellform.scene.scene import Scene
from shellform.scene.scene_file import read_scene
from shellform.scene.wearer import wearer_of
from tests.meshes.sewn import pocketed_trousers, with_collar, with_patch

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


def polo():
    """A trunk with two sleeves, a collar and a placket: four openings."""
    across = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    heights = np.linspace(0.9, 1.45, 12)
    radii = np.interp(heights, [0.9, 1.3, 1.38, 1.45], [0.18, 0.18, 0.14, 0.07])
    rings = [
        np.stack([0.7 * r * np.cos(across), r * np.sin(across), 0 * across + z], axis=1)
        for r, z in zip(radii, heights)
    ]
    points, cells = np.concatenate(rings), []
    sleeves = {1: [], -1: []}
    for row in range(11):
        for k in range(24):
            cell = [row * 24 + k, row * 24 + (k + 1) % 24, (row + 1) * 24 + (k + 1) % 24]
            cell.append((row + 1) * 24 + k)
            side = 1 if k in (5, 6) else -1 if k in (17, 18) else 0
            if side and row in (6, 7):
                sleeves[side].append(cell)
            else:
                cells.append(cell)
    for side, holes in sleeves.items():
        sides = [(c[j], c[(j + 1) % 4]) for c in holes for j in range(4)]
        rim = [s for s in sides if s[::-1] not in sides]
        for tail, head in rim:
            cells.append([tail, head, 10_000 + head, 10_000 + tail])
        for point in sorted({p for s in rim for p in s}):
            number = len(points)
            points = np.vstack([points, points[point] + [0.0, 0.2 * side, -0.05]])
            cells = [[number if q == 10_000 + point else q for q in c] for c in cells]
    plain = meshes.clean(meshes.Surface(points, cells, verify=False))
    plain = meshes.orient(plain, majority=True)
    plain = plain.replace(verify=True)
    middle = plain.points[plain.cells].mean(axis=1)
    front = (middle[:, 0] > 0.08) & (abs(middle[:, 1]) < 0.05) & (abs(middle[:, 2] - 1.2) < 0.1)
    placket = with_patch(plain, front)
    placket = meshes.orient(placket, majority=True).replace(verify=True)
    near = np.round(placket.points[:, 2] - heights[10], 9) == 0
    ring = np.flatnonzero(near)
    return with_collar(placket, ring, 1)


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


def test_stretch_is_told():
    assert "19 %" in too_stretched(0.19) and 0.05 < BEARS < 0.19
