"""Garments against their measures, cones, a body, topology, and meshes and measures at fault."""
# SPDX-License-Identifier: LGPL-3.0-or-later

import warnings
from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial import cKDTree

import meshes
from meshes import MeshError, Surface
from meshes.garments.ring import count_cells
from meshes.topology import directed_edges, edge_keys

REGULAR = meshes.SIZES["large-regular"]
# A standing man of 1.755 m: centre and semi-axes of ellipsoids [m] inside the trousers.
BODY = {
    "pelvis": ((0.0, 0.0, 0.955), (0.128, 0.180, 0.105)),
    "left thigh": ((0.0, 0.10, 0.69), (0.095, 0.095, 0.26)),
    "right thigh": ((0.0, -0.10, 0.69), (0.095, 0.095, 0.26)),
    "left shank": ((0.0, 0.10, 0.28), (0.060, 0.060, 0.25)),
    "right shank": ((0.0, -0.10, 0.28), (0.060, 0.060, 0.25)),
}


@pytest.fixture(autouse=True)
def _warnings_are_errors():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        yield


def loop_length(surface, name):
    ends = surface.points[surface.edges[name][:, :2]]
    return np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum()


def section_length(surface, height):
    """Length of the line in which the level plane at ``height`` cuts the sides of the cells."""
    corners = surface.points[surface.cells]
    following = np.roll(corners, -1, axis=1)
    start, end = corners[..., 2] - height, following[..., 2] - height
    cut = start * end < 0.0
    assert set(cut.sum(axis=1)) <= {0, 2}
    part = np.where(cut, start / np.where(cut, start - end, 1.0), 0.0)
    places = (corners + part[..., None] * (following - corners))[cut].reshape(-1, 2, 3)
    return np.linalg.norm(places[:, 1] - places[:, 0], axis=1).sum()


def cell_normals(surface):
    corners = surface.points[surface.cells]
    normals = np.cross(corners[:, 2] - corners[:, 0], corners[:, -1] - corners[:, 1])
    return normals / np.linalg.norm(normals, axis=1, keepdims=True)


def inside_volume(surface):
    """Volume by the divergence theorem, for a tube whose openings are level rings."""
    corners = surface.points[surface.cells]
    areas = 0.5 * np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    # x and y alone: level openings add nothing to the flux of (x, y, 0).
    return 0.5 * np.sum(areas[:, :2] * corners.mean(axis=1)[:, :2])


def euler(surface):
    edges = np.unique(edge_keys(directed_edges(surface.cells), len(surface.points)))
    return len(surface.points) - len(edges) + len(surface.cells)


def triangles(surface):
    return meshes.to_triangles(surface, "shortest")


# --- trousers -------------------------------------------------------------------------------


@pytest.mark.parametrize("size", ["small-short", "medium-long", "large-regular"])
@pytest.mark.parametrize("cell_size", [0.040, 0.025, 0.015])
def test_trousers_measure_what_was_asked(size, cell_size):
    surface, measures = meshes.trousers(size, cell_size=cell_size), meshes.SIZES[size]
    assert surface.cells.shape[1] == 4
    assert meshes.scaled_jacobian(surface).min() >= 0.6
    assert 0.8 * cell_size < surface.mean_cell_size < 1.1 * cell_size
    assert loop_length(surface, "waist") == pytest.approx(measures["waist"], rel=1e-4)
    levels = {"hip": measures["hip_height"], "thigh": measures["fork_height"] - 0.05}
    levels["knee"] = measures["knee_height"]
    for name, height in levels.items():
        rings = 1 if name == "hip" else 2
        found = section_length(surface, height - 1e-7) / rings
        assert found == pytest.approx(measures[name], rel=1e-4)
    for side in ("left", "right"):
        assert loop_length(surface, f"{side}_hem") == pytest.approx(measures["hem"], rel=1e-4)
        hem = surface.points[surface.edges[f"{side}_hem"]]
        assert np.all(hem[..., 2] == measures["hem_height"])
    waist = surface.points[surface.edges["waist"]][:, 0, 2]
    assert waist.min() == measures["waist_height"]
    assert waist.max() == pytest.approx(measures["waist_height"] + 0.025)


@pytest.mark.parametrize("cell_size", [0.040, 0.025, 0.015])
def test_trousers_are_a_pair_of_pants(cell_size):
    surface = meshes.trousers(cell_size=cell_size)
    edges = edge_keys(directed_edges(surface.cells), len(surface.points))
    assert np.unique(edges, return_counts=True)[1].max() == 2
    assert euler(surface) == -1
    loops = meshes.boundary_loops(surface)
    assert len(loops) == 3
    for name in ("waist", "left_hem", "right_hem"):
        line = surface.edges[name]
        assert np.array_equal(np.roll(line[:, 0], -1), line[:, 1])
        assert any(np.array_equal(np.sort(loop), np.unique(line)) for loop in loops)
    # Six cells meet in the two ends of the bridge, four in every other inner point.
    inner = np.setdiff1d(np.arange(len(surface.points)), np.concatenate(loops))
    valence = np.bincount(surface.cells.ravel())[inner]
    assert np.sum(valence == 6) == 2 and np.sum(valence == 4) == len(inner) - 2
    names = ("right_front", "right_back", "left_front", "left_back")
    cells = np.concatenate([surface.panels[name] for name in names])
    assert np.array_equal(np.sort(cells), np.arange(len(surface.cells)))
    assert np.all(surface.points[surface.cells[surface.panels["right_back"]]][..., 1] <= 0.0)


@pytest.mark.parametrize("size", meshes.SIZES)
def test_every_size_has_good_cells(size):
    for cell_size in (0.034, 0.021, 0.018):
        surface = meshes.trousers(size, cell_size=cell_size)
        assert meshes.scaled_jacobian(surface).min() >= 0.6
    wide = meshes.trousers(size, stance=0.25, fork_gap=0.012)
    assert meshes.scaled_jacobian(wide).min() >= 0.6
    assert np.mean(wide.points[wide.edges["left_hem"]][..., 1]) == pytest.approx(0.25)


def test_left_and_right_are_mirror_images():
    surface = meshes.trousers()
    place = {tuple(point): number for number, point in enumerate(surface.points)}
    assert len(place) == len(surface.points)
    # The keys are the coordinates bit by bit; adding zero makes -0.0 the same as 0.0.
    image = np.array([place[tuple(p)] for p in surface.points * [1.0, -1.0, 1.0] + 0.0])
    mirrored = np.sort(np.sort(image[surface.cells], axis=1), axis=0)
    assert np.array_equal(mirrored, np.sort(np.sort(surface.cells, axis=1), axis=0))
    assert np.allclose(surface.directors[image], surface.directors * [1, -1, 1], atol=1e-12)
    for name in ("hem", "inseam", "outseam"):
        left, right = surface.edges[f"left_{name}"], surface.edges[f"right_{name}"]
        assert set(image[left].ravel()) == set(right.ravel())


def test_directors_point_outward_and_the_warp_down():
    surface = meshes.trousers()
    normals, warp = cell_normals(surface), surface.warp
    centres = surface.points[surface.cells].mean(axis=1)
    sides = np.sign(centres[:, 1]) * 0.1
    low = centres[:, 2] < REGULAR["fork_height"] - 0.05
    # Away from the axis of each leg, away from the middle of the torso.
    away = centres[:, :2] - np.stack([np.zeros(len(low)), np.where(low, sides, 0.0)], axis=1)
    outward = np.einsum("mi,mi->m", away, normals[:, :2])
    high = centres[:, 2] > REGULAR["hip_height"]
    assert np.all(outward[low | high] > 0.0)
    assert np.allclose(np.linalg.norm(warp, axis=1), 1.0)
    assert np.abs(np.einsum("mi,mi->m", warp, normals)).max() < 1e-12
    assert np.all(warp[:, 2] < -0.4)
    assert np.all(warp[low, 2] < -np.cos(np.radians(15.0)))


def test_seams_run_along_the_garment():
    surface = meshes.trousers()
    points = {name: surface.points[edge] for name, edge in surface.edges.items()}
    inseam, outseam, rise = points["left_inseam"], points["left_outseam"], points["rise"]
    assert np.array_equal(inseam[0, 0], [0.0, 0.0, REGULAR["fork_height"]])
    assert np.all(np.diff(inseam[..., 2], axis=1) < 0.0)
    assert inseam[-1, 1, 2] == REGULAR["hem_height"]
    height = REGULAR["fork_height"] - REGULAR["hem_height"]
    assert height < loop_length(surface, "left_inseam") < 1.02 * height
    assert outseam[0, 0, 2] == pytest.approx(REGULAR["waist_height"] + 0.0125, abs=1e-3)
    assert np.all(outseam[..., 1] > 0.1)
    assert np.all(rise[..., 1] == 0.0) and rise[0, 0, 0] > 0.1 and rise[-1, 1, 0] < -0.1
    # Front and back rise of finished trousers: 0.30 to 0.35 and 0.35 to 0.48 m.
    lengths = np.linalg.norm(rise[:, 1] - rise[:, 0], axis=1)
    front = rise[:, :, 0].mean(axis=1) > 0.0
    assert 0.30 < lengths[front].sum() < lengths[~front].sum() < 0.48


@pytest.mark.parametrize("cell_size", [0.040, 0.020])
def test_a_standing_body_fits_in(cell_size):
    """No ellipsoid pokes through a cell."""
    surface = meshes.trousers(cell_size=cell_size)
    grid = np.linspace(0.0, 1.0, 6)
    a, b = (value.ravel() for value in np.meshgrid(grid, grid))
    shape = np.stack([(1 - a) * (1 - b), a * (1 - b), a * b, (1 - a) * b])
    points = np.einsum("kq,mki->mqi", shape, surface.points[surface.cells]).reshape(-1, 3)
    for name, (centre, radii) in BODY.items():
        level = np.linalg.norm((points - centre) / np.array(radii), axis=1)
        assert level.min() > 1.0, name


def test_half_the_cell_size_refines_the_same_shape():
    """Coarse points lie on fine ones and the area converges, both of second order."""
    meshed = [meshes.trousers(cell_size=size) for size in (0.04, 0.02, 0.01)]
    moved = []
    for coarse, fine in pairwise(meshed):
        assert len(fine.cells) == 4 * len(coarse.cells)
        moved.append(cKDTree(fine.points).query(coarse.points)[0].max())
    assert moved[0] < 2e-3 and np.log2(moved[0] / moved[1]) > 1.8
    assert np.ptp([surface.area for surface in meshed]) < 2e-4 * meshed[-1].area


def test_counting_cells():
    assert count_cells(1.0, 0.04) == 25 and count_cells(0.001, 0.02) == 2
    for size in (0.04, 0.031, 0.025, 0.0201):
        counts = [count_cells(0.7, size / 2**k) for k in range(4)]
        assert np.array_equal(counts, counts[0] * 2 ** np.arange(4))
    assert abs(count_cells(1.17, 0.0125) * 0.0125 / 1.17 - 1.0) < 0.05


def test_regions_of_trousers():
    surface = meshes.trousers()
    parts = meshes.regions(surface)
    together = np.concatenate([parts[name] for name in ("right_leg", "left_leg", "torso")])
    assert np.array_equal(np.sort(together), np.arange(len(surface.points)))
    fork = REGULAR["fork_height"]
    assert np.all(surface.points[parts["left_leg"]] @ [0, 1, 0] > 0.0)
    assert np.all(surface.points[parts["right_leg"]] @ [0, 1, 0] < 0.0)
    assert surface.points[parts["torso"], 2].min() == pytest.approx(fork, abs=1e-9)
    assert len(parts["left_leg"]) == len(parts["right_leg"])
    turn = np.array([[0.6, -0.8, 0.0], [0.8, 0.6, 0.0], [0.0, 0.0, 1.0]])
    turned = meshes.regions(triangles(surface).transform(rotation=turn, translation=(1, 2, 0)))
    for name, part in parts.items():
        assert np.array_equal(turned[name], part)
    with pytest.raises(MeshError, match="garment with legs needs the edge 'left_hem'"):
        meshes.regions(meshes.skirt())
    bent = surface.points.copy()
    bent[parts["left_leg"], 1] -= 0.3 * np.exp(-(((bent[parts["left_leg"], 2] - 0.4) / 0.1) ** 2))
    low = meshes.regions(surface.replace(points=bent))
    # A leg bent over the plane between the hems counts only below that place.
    assert len(low["left_leg"]) < len(parts["left_leg"])
    bent[:, 1] = np.abs(bent[:, 1]) * np.sign(bent[:, 0])
    with pytest.raises(MeshError, match="the legs cannot be told apart above the hems"):
        meshes.regions(surface.replace(points=bent, directors=surface.directors, verify=False))


@pytest.mark.parametrize(
    "change, sentence",
    [
        ({"waist": 100.0}, "waist = 100.0 is no girth of a garment, give it in m"),
        ({"thigh": -0.7}, "thigh = -0.7 is no girth"),
        ({"knee": np.nan}, "knee = nan is no girth"),
        ({"hem_height": 0.6}, "knee_height = 0.48 m must lie 0.03 m or more above hem_height"),
        ({"fork_height": 0.95}, "hip_height = 0.9 m must lie"),
        ({"waist_height": 104.0}, "waist_height = 104.0 does not fit a person"),
        ({"thigh": 1.3}, "do not meet at a fork, the thigh must be 0.55 to 0.85 of the hip"),
        ({"thigh": 0.6}, "not 0.51"),
        ({"hem": 0.8}, "run into each other; give a stance above"),
        ({"stance": 2.0}, "stance = 2.0 m must lie in 0.05 to 0.6"),
        ({"fork_gap": 0.0}, "fork_gap = 0.0 m must lie"),
        ({"cell_size": 25.0}, "cell_size = 25.0 does not fit, give it in m, 0.001 to 0.04"),
        ({"cell_size": 0.0}, "cell_size = 0.0 does not fit"),
        ({"size": "huge"}, "there is no size 'huge', give one of small-short"),
    ],
)
def test_impossible_trousers(change, sentence):
    with pytest.raises(ValueError, match=sentence):
        meshes.trousers(**change)


# --- sleeves and skirts ---------------------------------------------------------------------


def frustum(upper, lower, height):
    """Lateral area and volume of a cone frustum of two girths."""
    one, other = upper / (2.0 * np.pi), lower / (2.0 * np.pi)
    area = np.pi * (one + other) * np.hypot(height, one - other)
    return area, np.pi * height / 3.0 * (one**2 + one * other + other**2)


TUBES = {
    "sleeve": (lambda h: meshes.sleeve(0.6, 0.5, 0.3, cell_size=h), (0.5, 0.3, 0.6)),
    "middle": (lambda h: meshes.sleeve(0.6, 0.5, 0.3, 0.4, cell_size=h), (0.5, 0.3, 0.6)),
    "skirt": (
        lambda h: meshes.skirt(
            0.8, 1.0, 1.4, 0.6, 0.2, waist_ratio=1.0, hem_ratio=1.0, cell_size=h
        ),
        (0.8, 1.4, 0.6),
    ),
}


@pytest.mark.parametrize("name", TUBES)
def test_tubes_converge_to_cones(name):
    make, measures = TUBES[name]
    exact = np.array(frustum(*measures))
    found = np.array([(make(h).area, inside_volume(make(h))) for h in (0.04, 0.02, 0.01)])
    errors = np.abs(found - exact) / exact
    # A regular polygon of n sides and a circle of its girth differ by pi^2 / (3 n^2) in area.
    assert np.all(errors[-1] < 3e-3)
    orders = np.log2(errors[:-1] / errors[1:])
    assert np.all((orders > 1.9) & (orders < 2.1))


@pytest.mark.parametrize("cell_size", [0.04, 0.025, 0.01])
def test_girths_of_tubes(cell_size):
    sleeve = meshes.sleeve(0.6, 0.5, 0.3, 0.45, ratio=1.2, cell_size=cell_size)
    assert loop_length(sleeve, "top") == pytest.approx(0.5, rel=1e-9)
    assert loop_length(sleeve, "bottom") == pytest.approx(0.3, rel=1e-9)
    assert section_length(sleeve, 0.3 - 1e-8) == pytest.approx(0.45, rel=1e-6)
    assert np.array_equal(sleeve.bounds[:, 2], [0.0, 0.6])
    skirt = meshes.skirt(cell_size=cell_size)
    assert loop_length(skirt, "waist") == pytest.approx(0.74, rel=1e-9)
    assert loop_length(skirt, "hem") == pytest.approx(1.30, rel=1e-9)
    assert section_length(skirt, 0.84 - 1e-8) == pytest.approx(1.02, rel=1e-6)
    assert np.allclose(skirt.bounds[:, 2], [0.44, 1.04])
    for surface in (sleeve, skirt):
        assert euler(surface) == 0 and meshes.scaled_jacobian(surface).min() > 0.9
        assert np.all(np.einsum("ni,ni->n", surface.directors, surface.points * [1, 1, 0]) > 0.0)
        assert np.all(surface.warp[:, 2] < -0.7)
        assert np.abs(np.einsum("mi,mi->m", surface.warp, cell_normals(surface))).max() < 1e-12
        assert np.allclose(surface.points[surface.edges["seam"]][..., 1], 0.0)


@pytest.mark.parametrize(
    "make, change, sentence",
    [
        (meshes.sleeve, {"girth_top": 50.0}, "girth_top = 50.0 is no girth"),
        (meshes.sleeve, {"length": 0.0}, "length = 0.0 m does not fit"),
        (meshes.sleeve, {"ratio": 0.0}, "breadth over depth"),
        (meshes.sleeve, {"cell_size": 0.2}, "0.001 to 0.05"),
        (meshes.skirt, {"hem": -1.0}, "hem = -1.0 is no girth"),
        (meshes.skirt, {"hip_depth": 0.7}, "must rise in this order"),
        (meshes.skirt, {"length": 1.2}, "hem above floor"),
    ],
)
def test_impossible_tubes(make, change, sentence):
    measures = {"length": 0.6, "girth_top": 0.5, "girth_bottom": 0.3}
    if make is meshes.skirt:
        measures = {}
    with pytest.raises(ValueError, match=sentence):
        make(**{**measures, **change})


# --- garments of others ---------------------------------------------------------------------


def nameless(surface, **changes):
    fields = {"edges": {}, "panels": {}, "warp": None, "source": "mine.obj", **changes}
    return surface.replace(**fields)


@pytest.mark.parametrize("kind", ["vtu", "msh"])
def test_trousers_come_back_from_a_file(tmp_path, kind):
    surface = meshes.trousers(cell_size=0.04)
    path = tmp_path / f"trousers.{kind}"
    if kind == "msh":
        with pytest.warns(UserWarning, match="keep no warp"):
            meshes.save(surface, path)
    else:
        meshes.save(surface, path)
    back = meshes.load(path)
    assert np.allclose(back.points, surface.points, atol=1e-15)
    assert np.array_equal(back.cells, surface.cells)
    for name, edge in surface.edges.items():
        assert set(map(tuple, np.sort(back.edges[name]))) == set(map(tuple, np.sort(edge)))
    for name, panel in surface.panels.items():
        assert np.array_equal(back.panels[name], np.sort(panel))
    if kind == "vtu":
        assert np.allclose(back.warp, surface.warp)
    dressed = meshes.prepare_garment(back)
    assert set(dressed.edges) == set(surface.edges)


@pytest.mark.parametrize("form", ["quads", "triangles", "inside out", "9 nodes"])
@pytest.mark.parametrize("kind", ["obj", "ply", "vtu"])
def test_a_nameless_file_gets_its_names(tmp_path, form, kind):
    if form == "9 nodes" and kind != "vtu":
        pytest.skip("this format holds no curved cells")
    surface = mine = meshes.trousers(cell_size=0.04)
    if form == "triangles":
        mine = triangles(surface)
    elif form == "inside out":
        mine = surface.replace(cells=surface.cells[:, ::-1], directors=-surface.directors)
    elif form == "9 nodes":
        mine = meshes.elevate(surface)
    path = tmp_path / f"mine.{kind}"
    meshes.save(nameless(mine), path)
    dressed = meshes.prepare_garment(meshes.load(path), "highest")
    assert set(dressed.edges) == {"waist", "left_hem", "right_hem"}
    for name, edge in dressed.edges.items():
        assert set(edge[:, :2].ravel()) == set(surface.edges[name].ravel())
    along = np.einsum("ni,ni->n", dressed.directors[: len(surface.points)], surface.directors)
    assert np.all(along > 0.5)
    if form != "9 nodes":
        normals = cell_normals(dressed)
        assert np.abs(np.einsum("mi,mi->m", dressed.warp, normals)).max() < 1e-9
    assert np.allclose(np.linalg.norm(dressed.warp, axis=1), 1.0)
    assert np.all(dressed.warp[:, 2] < 0.0)


def test_ways_to_name_the_waist():
    surface = meshes.skirt(cell_size=0.04)
    mine = nameless(surface, edges={"top": surface.edges["waist"], "hem": surface.edges["hem"]})
    ways = ["top", "highest", lambda x: x[:, 2] > 1.03]
    for way in ways:
        dressed = meshes.prepare_garment(mine, way)
        assert set(dressed.edges["waist"].ravel()) == set(surface.edges["waist"].ravel())
        assert np.array_equal(dressed.edges["hem"], mine.edges["hem"])
    poncho = nameless(meshes.annulus(0.15, 0.8, (24, 6), slit=False))
    radii = np.linalg.norm(poncho.points, axis=1)
    level = poncho.points + np.outer(1.0 - 1e-9 * radii, [0.0, 0.0, 1.0])
    laid = meshes.prepare_garment(
        poncho.replace(points=level), lambda x: np.hypot(x[:, 0], x[:, 1]) < 0.16
    )
    # On a level sheet the warp leads away from the waist.
    centres = laid.points[laid.cells].mean(axis=1) * [1, 1, 0]
    assert np.all(
        np.einsum("mi,mi->m", laid.warp, centres) > 0.99 * np.linalg.norm(centres, axis=1)
    )


def mixed():
    surface = meshes.skirt(cell_size=0.04)
    cells = surface.cells.copy()
    cells[5] = cells[5, ::-1]
    return Surface(surface.points, cells, surface.edges, source="mine.obj", verify=False)


def crowded():
    surface = meshes.skirt(cell_size=0.04)
    one, other = surface.edges["seam"][4]
    fin = surface.points[[other, one]] + [0.1, 0.0, 0.0]
    cells = np.vstack([surface.cells, [[one, other, *len(surface.points) + np.arange(2)]]])
    points = np.vstack([surface.points, fin])
    return Surface(points, cells, surface.edges, source="mine.obj", verify=False)


def two_pieces():
    one = meshes.skirt(cell_size=0.04)
    points = np.vstack([one.points, one.points + [0.0, 3.0, 0.0]])
    cells = np.vstack([one.cells, one.cells + len(one.points)])
    return Surface(points, cells, one.edges, source="mine.obj")


def upside_down():
    surface = meshes.trousers(cell_size=0.04)
    return surface.transform(rotation=np.diag([1.0, -1.0, -1.0]))


def half_waist():
    surface = meshes.skirt(cell_size=0.04)
    return surface.replace(edges={"waist": surface.edges["waist"][:7]})


def closed():
    ball = meshes.spherical_cap(0.3, (0.5, 2.6), cells=(12, 8))
    rims = [meshes.boundary_loops(ball)[k] for k in (0, 1)]
    points = np.vstack([ball.points, [[0, 0, 0.3], [0, 0, -0.3]]])
    cells = triangles(ball).cells
    lids = [
        [tip, following, point]
        for rim in rims
        for tip in [len(ball.points) + int(ball.points[rim[0], 2] < 0.0)]
        for point, following in zip(rim, np.roll(rim, -1))
    ]
    return Surface(points, np.vstack([cells, lids]), source="mine.obj")


def of_skirt(**changes):
    return lambda: nameless(meshes.skirt(cell_size=0.04), **changes)


def scaled(factor):
    return lambda: meshes.trousers(cell_size=0.04).transform(scale=factor)


@pytest.mark.parametrize(
    "make, waist, sentence",
    [
        (of_skirt(), None, "mine.obj: there is no edge 'waist' .edges: none., name the waist"),
        (of_skirt(), "belt", "there is no edge 'belt'"),
        (of_skirt(), lambda x: x[:, 2] > 2.0, "selects no boundary segment"),
        (of_skirt(), lambda x: x[:, 2] > -2.0, "selects points of 2 boundary loops, narrow it"),
        (half_waist, None, "the edge 'waist' .8 points. is not one closed boundary loop"),
        (upside_down, "highest", "2 boundary loops are equally high, about"),
        (upside_down, None, "not above the edge at .* turn the garment upright"),
        (two_pieces, None, r"the garment is in 2 pieces .cells 0 and \d+ are not joined."),
        (closed, "highest", "the mesh is closed, open it at the waist"),
        (mixed, None, "cells 4 and 5 face opposite sides, turn them with meshes.orient"),
        (crowded, None, "belongs to 3 cells"),
        (scaled(1000.0), None, "look like mm taken for m, .* give load.path, unit='mm'."),
        (scaled(100.0), None, "look like cm taken for m, .* give load.path, unit='cm'."),
        (scaled(1.0 / 0.0254), None, "look like in taken for m, .* unit='in'."),
        (scaled(0.001), None, "waist measures 0.001 m .* look like m taken for mm, .* unit='m'."),
        (scaled(1e-9), None, "nobody wears; scale it with"),
    ],
)
def test_unwearable(make, waist, sentence):
    with pytest.raises(MeshError, match=sentence) as caught:
        meshes.prepare_garment(make(), waist)
    assert str(caught.value).count("\n") == 0
