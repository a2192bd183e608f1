# SPDX-License-Identifier: LGPL-3.0-or-later
"""Three cells and more at an edge: what is sewn on is no border, faces the garment's side."""

import numpy as np
import pytest

import meshes
from meshes.seam_directors import cone_axis
from meshes.sheets import main_sheet, seams, sheet_of_cells
from tests.meshes.measures import facing
from tests.meshes.sewn import pocketed_trousers, tee, with_collar, with_patch

TUBE = meshes.cylinder(0.15, 0.6, (24, 10), angle=2 * np.pi)


def test_a_plain_surface_is_one_sheet():
    assert seams(TUBE.cells) == [] and main_sheet(TUBE.points, TUBE.cells).all()
    assert (sheet_of_cells(TUBE.points, TUBE.cells) == 0).all()


@pytest.mark.parametrize("turned", [True, False])
@pytest.mark.parametrize("open_top", [True, False])
def test_a_patch(turned, open_top):
    """A pocket is a sheet of its own, faces out like the garment, and adds no opening."""
    middle = TUBE.points[TUBE.cells].mean(axis=1)
    chosen = (middle[:, 0] > 0.1) & (np.abs(middle[:, 2] - middle[:, 2].mean()) < 0.15)
    assert 8 <= chosen.sum() < 60
    sewn = meshes.orient(with_patch(TUBE, chosen, turned=turned, open_top=open_top), majority=True)
    sewn = sewn.replace(verify=True)
    assert len(seams(sewn.cells)) > 4
    main = main_sheet(sewn.points, sewn.cells)
    assert main.sum() == len(TUBE.cells) and main[: len(TUBE.cells)][~chosen].all()
    assert len(meshes.boundary_loops(sewn)) == 2
    first = len(TUBE.cells)
    along = np.einsum("mi,mi->m", facing(sewn)[first:], facing(TUBE)[chosen])
    assert (along > 0.9 * np.abs(along).max()).all() or (along < -0.9 * np.abs(along).max()).all()
    assert np.sign(along[0]) == np.sign(np.sum(facing(sewn)[0] * facing(TUBE)[0]))


def test_a_collar_adds_no_opening():
    loop = meshes.boundary_loops(TUBE)
    heights = [TUBE.points[line, 2].mean() for line in loop]
    top = loop[int(np.argmax(heights))]
    below = TUBE.points[top] - [0, 0, 0.06]
    ring = np.array([np.argmin(np.linalg.norm(TUBE.points - p, axis=1)) for p in below])
    sewn = meshes.orient(with_collar(TUBE, ring, 2), majority=True).replace(verify=True)
    assert len(seams(sewn.cells)) == len(ring)
    assert len(meshes.boundary_loops(sewn)) == 2
    assert (main_sheet(sewn.points, sewn.cells) == (np.arange(len(sewn.cells)) < 240)).all()


@pytest.mark.parametrize("degrees", [20, 45, 90, 135, 160])
def test_a_flap_at_any_angle(degrees):
    """The director of the seam halves the angle between the sheets, whichever side they face."""
    sewn, _, _ = tee(4, degrees)
    seam = np.unique(np.concatenate([sewn.cells[:16].ravel()]))
    seam = np.intersect1d(seam, sewn.cells[16:])
    assert len(seam) == 5
    lean = np.degrees(np.arccos(np.abs(sewn.directors[seam, 2])))
    between = min(degrees, 180 - degrees)
    assert lean == pytest.approx(0.5 * between, abs=1e-6)


def test_axis_of_the_narrowest_cone():
    """Against the least largest angle over many directions."""
    random = np.random.default_rng(2)
    tried = random.normal(size=(20000, 3))
    tried /= np.linalg.norm(tried, axis=1)[:, None]
    for count in (1, 2, 3, 6):
        normals = random.normal(size=(count, 3)) + [0, 0, 2.0]
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        axis = cone_axis(normals, np.array([0, 0, 1.0]))
        reached = (normals @ axis).min()
        best = (tried @ normals.T).min(axis=1).max()
        assert np.linalg.norm(axis) == pytest.approx(1.0)
        assert best <= reached + 1e-12 < best + 0.03


def test_too_many_directions_are_refused():
    """Four sheets through one line, 45 degrees apart: none of all directions is near to all."""
    fan = np.radians([0, 45, 90, 135])
    wings = np.stack([np.cos(fan), 0 * fan, np.sin(fan)], axis=1)
    tips = np.concatenate([wings, wings + [0, 1, 0], -wings, -wings + [0, 1, 0]])
    points = np.concatenate([[[0, 0, 0], [0, 1, 0]], tips])
    cells = [[0, 1, 6 + k, 2 + k] for k in range(4)] + [[0, 1, 14 + k, 10 + k] for k in range(4)]
    star = meshes.Surface(points, cells, verify=False)
    with pytest.raises(meshes.MeshError, match=r"at the seam .* stands \d+ degrees off .*lay what"):
        meshes.orient(star).replace(verify=True)


def test_a_facing_folded_over_a_border_is_named():
    middle = TUBE.points[TUBE.cells].mean(axis=1)
    chosen = (middle[:, 0] > 0.1) & (middle[:, 2] < middle[:, 2].min() + 0.2)
    facing_of_hem = with_patch(TUBE, chosen)
    with pytest.raises(meshes.MeshError, match="folded back at a border that both have: join it"):
        meshes.orient(facing_of_hem, majority=True).replace(verify=True)


def test_trousers_with_pockets_from_a_file(tmp_path):
    sewn = pocketed_trousers()
    lines = [f"v {x} {y} {z}" for x, y, z in sewn.points.tolist()]
    lines += ["f " + " ".join(str(k + 1) for k in row) for row in sewn.cells.tolist()]
    (tmp_path / "x.obj").write_text("\n".join(lines) + "\n")
    with pytest.warns(UserWarning, match="faced the other side"):
        surface = meshes.load(tmp_path / "x.obj")
    garment = meshes.prepare_garment(surface, waist="highest")
    assert set(garment.edges) == {"waist", "left_hem", "right_hem"}
    plain = meshes.trousers("large-regular", cell_size=0.04)
    assert garment.area > plain.area + 0.02
    assert set(meshes.regions(garment)) == {"right_leg", "left_leg", "torso"}
