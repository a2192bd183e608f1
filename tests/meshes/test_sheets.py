# SPDX-License-Identifier: LGPL-3.0-or-later
"""Three cells and more at an edge: what is sewn on is no border, faces the garment's side."""

import numpy as np
import pytest

import meshes
from meshes.sheets import main_sheet, seams, sheet_of_cells
from tests.meshes.measures import facing
from tests.meshes.sewn import pocketed_trousers, with_collar, with_patch

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


def test_what_stands_across_is_refused():
    """A frill at right angles would need directors of its own."""
    flat = meshes.rectangle(0.4, 0.4, (4, 4))
    line = np.flatnonzero(np.abs(flat.points[:, 0] - 0.2) < 1e-9)
    up = len(flat.points) + np.arange(len(line))
    cells = np.stack([line[:-1], line[1:], up[1:], up[:-1]], axis=1)
    points = np.concatenate([flat.points, flat.points[line] + [0, 0, 0.1]])
    frill = meshes.Surface(points, np.concatenate([flat.cells, cells]), verify=False)
    with pytest.raises(meshes.MeshError, match=r"at the seam .* stands \d+ degrees off.*lay what"):
        meshes.orient(frill).replace(verify=True)


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
