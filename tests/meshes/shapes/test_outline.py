# SPDX-License-Identifier: LGPL-3.0-or-later
"""Panels inside a closed polygon."""

import numpy as np
import pytest

import meshes
from tests.meshes.measures import L_SHAPE, euler, facing


def test_from_outline(capfd):
    names = ["hem", "side", "side", None, "cut", "back"]
    panel = meshes.from_outline(L_SHAPE, 0.15, names=names, warp=(0, 1, 0))
    assert panel.kind == "quadrilateral" and euler(panel) == 1
    assert panel.area == pytest.approx(3.0, rel=1e-12)
    assert 0.1 < panel.mean_cell_size < 0.2
    assert meshes.scaled_jacobian(panel).min() > 0.3
    assert set(panel.edges) == {"hem", "side", "cut", "back"}
    ends = panel.points[panel.edges["side"][[0, -1], [0, 1]]]
    assert np.allclose(ends, [[2, 0, 0], [1, 1, 0]])
    assert np.all(panel.points[panel.edges["hem"], 1] == 0.0)
    assert np.all(facing(panel)[:, 2] > 0.999)
    again = meshes.from_outline(L_SHAPE, 0.15, names=names)
    assert np.array_equal(again.points, panel.points) and np.array_equal(again.cells, panel.cells)
    assert capfd.readouterr() == ("", "")


def test_from_outline_side_and_plane():
    clockwise = meshes.from_outline([*L_SHAPE[::-1], L_SHAPE[-1]], 0.4)
    assert np.all(facing(clockwise)[:, 2] > 0.999)
    outline = clockwise.edges["outline"]
    assert outline[-1, 1] == outline[0, 0]
    upright = np.array([(0, 0, 1), (0, 2, 1), (0, 2, 3), (0, 0, 3.0)])
    panel = meshes.from_outline(upright, 0.4, quads=False)
    assert panel.kind == "triangle" and panel.area == pytest.approx(4.0)
    assert np.allclose(panel.directors, [1, 0, 0]) and np.allclose(panel.points[:, 0], 0.0)
    assert np.all(facing(panel)[:, 0] > 0.999)


def test_from_outline_leaves_an_open_gmsh_alone():
    gmsh = pytest.importorskip("gmsh")
    gmsh.initialize([], False)
    try:
        gmsh.option.setNumber("Mesh.RecombineAll", 0)
        gmsh.model.add("mine")
        meshes.from_outline(L_SHAPE, 0.5)
        assert gmsh.model.getCurrent() == "mine"
        assert gmsh.option.getNumber("Mesh.RecombineAll") == 0
    finally:
        gmsh.finalize()
    assert meshes.from_outline(L_SHAPE, 0.5).area == pytest.approx(3.0)
