# SPDX-License-Identifier: LGPL-3.0-or-later
"""Trousers against their measures, a body, topology, and measures at fault."""

import re
from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial import cKDTree

import meshes
from meshes import MeshError
from meshes.garments.ring import count_cells
from meshes.topology import directed_edges, edge_keys
from tests.meshes.measures import euler, facing, loop_length, section_length

REGULAR = meshes.SIZES["large-regular"]
# A standing man of 1.755 m: centre and semi-axes of ellipsoids [m] inside the trousers.
BODY = {
    "pelvis": ((0.0, 0.0, 0.955), (0.128, 0.180, 0.105)),
    "left thigh": ((0.0, 0.10, 0.69), (0.095, 0.095, 0.26)),
    "right thigh": ((0.0, -0.10, 0.69), (0.095, 0.095, 0.26)),
    "left shank": ((0.0, 0.10, 0.28), (0.060, 0.060, 0.25)),
    "right shank": ((0.0, -0.10, 0.28), (0.060, 0.060, 0.25)),
}


def triangles(surface):
    return meshes.to_triangles(surface, "shortest")


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
    normals, warp = facing(surface), surface.warp
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


@pytest.mark.parametrize("measures", [{"hem": 0.8}, {"knee": 0.7, "stance": 0.11}])
def test_the_stance_that_is_asked_for_suffices(measures):
    """Legs that run into each other stand apart with the stance named, and with none less."""
    with pytest.raises(ValueError, match="give a stance above") as refused:
        meshes.trousers(**measures)
    least = float(re.search(r"above ([\d.]+) m", str(refused.value))[1])
    with pytest.raises(ValueError, match="give a stance above"):
        meshes.trousers(**measures | {"stance": least - 0.002})
    meshes.trousers(**measures | {"stance": least + 0.02})
