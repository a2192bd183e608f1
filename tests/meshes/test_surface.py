# SPDX-License-Identifier: LGPL-3.0-or-later
"""The surface and its check: what is right passes, what is broken is named."""

import subprocess
import sys
import warnings

import numpy as np
import pytest

import meshes
from meshes import MeshError, Surface
from meshes.topology import chain
from tests.meshes.measures import SQUARE, TWO, with_point


def broken(**changes):
    fields = {"points": SQUARE, "cells": TWO, "source": "skirt.vtu"} | changes
    return Surface(**fields)


@pytest.mark.parametrize(
    "changes, words",
    [
        ({"points": with_point(4, np.nan)}, ["point 4", "finite"]),
        ({"points": with_point(2, (np.inf, 0, 0))}, ["point 2", "finite"]),
        ({"cells": [[0, 1, 4, 3], [1, 2, 6, 4]]}, ["cell 1", "0 to 5"]),
        ({"cells": [[0, 1, 4, -3], [1, 2, 5, 4]]}, ["cell 0", "0 to 5"]),
        ({"cells": [[0, 1, 4, 3], [1, 2, 5, 1]]}, ["cell 1", "twice"]),
        ({"points": with_point(2, SQUARE[1])}, ["point 1 to point 2", "cell 1", "no length"]),
        ({"cells": [[0, 1, 4, 3], [1, 2, 4, 5]]}, ["cell 1", "crosses itself"]),
        ({"points": with_point(5, (1.2, 0.2, 0))}, ["cell 1", "concave", "point 5"]),
        ({"points": with_point(5, (1.5, 0.5, 0))}, ["cell 1", "concave"]),
        ({"points": SQUARE * [1, 0, 0] + [0, 0, 1]}, ["cell 0"]),
        ({"cells": [*TWO, [4, 3, 0, 1]]}, ["cells 0 and 2", "same points"]),
        ({"cells": [[0, 1, 4, 3], [1, 4, 5, 2]]}, ["cells 0 and 1", "meshes.orient"]),
        ({"cells": TWO[:1]}, ["point 2", "2 such points", "meshes.clean"]),
        ({"cells": np.empty((0, 4), int)}, ["empty", "0 cells"]),
        ({"points": np.empty((0, 3)), "cells": []}, ["empty", "0 points"]),
        ({"points": SQUARE[:, :2]}, ["(6, 2)", "zero column"]),
        ({"cells": [[0, 1, 4, 3, 2]]}, ["(1, 5)", "3, 4 or 9"]),
        ({"cells": [[0.0, 1.5, 4.0, 3.0]]}, ["cells", "whole numbers"]),
        ({"cells": [[0, 1, 4, 3], [1, 2]]}, ["cells", "whole numbers"]),
        ({"points": [["a", 0, 0]]}, ["points", "numbers"]),
        ({"directors": np.full((6, 3), 0.5)}, ["point 0", "unit length", "6 such"]),
        ({"directors": np.full((6, 3), np.nan)}, ["point 0", "unit length"]),
        ({"directors": np.tile([0, 0, 1.0], (5, 1))}, ["(5, 3)", "(6, 3)"]),
        (
            {"directors": [[0, 0, 1], [0, 0, 1], [0, 0, -1]] + 3 * [[0, 0, 1]]},
            ["point 2", "against", "1 of 6"],
        ),
        ({"warp": (0, 0, 0)}, ["warp", "no length"]),
        ({"warp": np.ones((3, 3))}, ["warp", "(2, 3)"]),
        ({"edges": {"hem": [[0, 1], [1, 9]]}}, ["segment 1", "'hem'", "0 to 5"]),
        ({"edges": {"hem": [[0, 1], [1, 5]]}}, ["segment 1", "'hem'", "not an edge"]),
        ({"edges": {"hem": [[0, 1, 2]]}}, ["'hem'", "2 point indices"]),
        ({"edges": {"hem": [0, 1]}}, ["'hem'", "shape"]),
        ({"panels": {"front": [0, 2]}}, ["'front'", "cell 2", "0 to 1"]),
        ({"panels": {"front": [[0]]}}, ["'front'", "flat list"]),
    ],
)
def test_check_says_what_is_wrong(changes, words):
    with pytest.raises(MeshError) as caught:
        broken(**changes)
    message = str(caught.value)
    assert message.startswith("skirt.vtu: ") and message.endswith(".")
    assert "\n" not in message
    for word in words:
        assert word in message


def test_check_passes_what_is_right():
    surface = broken()
    meshes.check(surface)
    assert surface.cells.dtype == np.int64 and surface.points.dtype == np.float64
    assert surface.edges == {} and surface.panels == {} and surface.warp is None


def test_three_sheets_on_one_edge():
    points = np.array([[0, 0, 0], [0, 0, 1], [1, 0, 0], [0, 1, 0], [-1, 0, 0.0]])
    with pytest.raises(
        MeshError, match=r"seam of more than two sheets at point 0 cell 0 stands 90 degrees off"
    ):
        Surface(points, [[0, 1, 2], [1, 0, 3], [0, 1, 4]])


def test_nine_node_cells_must_share_the_middle():
    panel = meshes.rectangle(1.0, 1.0, (2, 1), degree=2)
    shared = panel.cells[0, 5]
    points = np.vstack([panel.points, panel.points[shared] + [0.01, 0, 0]])
    cells = panel.cells.copy()
    cells[1, 7] = len(panel.points)
    with pytest.raises(MeshError, match="cells 0 and 1 share an edge"):
        Surface(points, cells)


def test_folded_nine_node_cell():
    panel = meshes.rectangle(1.0, 1.0, (2, 2), degree=2)
    points = panel.points.copy()
    points[panel.cells[3, 8]] += [0.3, 0, 0]
    with pytest.raises(MeshError, match=r"cell 3 .*folded"):
        panel.replace(points=points)


def test_flat_fold_has_no_normal():
    points = np.array([[0, 0, 0], [0, 1, 0], [1, 0, 0], [1, 0, 1e-13]])
    with pytest.raises(MeshError, match=r"point 0 fold back .* give the directors"):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            Surface(points, [[0, 1, 2], [1, 0, 3]])


def test_coincident_points_warn():
    points = np.vstack([SQUARE, SQUARE[[1, 4]]])
    cells = [[0, 1, 4, 3], [6, 2, 5, 7]]
    with pytest.warns(UserWarning, match="seam: 2 points .* points 1 and 6.*merge_duplicates"):
        surface = Surface(points, cells, source="seam")
    joined = meshes.merge_duplicates(surface)
    assert len(joined.points) == 6 and np.array_equal(joined.cells, TWO)
    # Named on either side it is a slit, and no cause for a warning.
    with pytest.warns(UserWarning):
        Surface(points, cells, edges={"rim": [[1, 4], [6, 7]]})
    with pytest.warns(UserWarning):
        Surface(points, cells, edges={"left": [[1, 4]]})
    Surface(points, cells, edges={"left": [[1, 4]], "right": [[6, 7]]})


def test_replace_and_transform():
    tube = meshes.cylinder(1.0, 2.0, (8, 2), warp=(0, 0, 1))
    turn = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
    moved = tube.transform(rotation=turn, translation=(1, 2, 3), scale=2.0)
    assert moved.area == pytest.approx(4.0 * tube.area)
    assert np.allclose(moved.points, 2.0 * tube.points @ turn.T + [1, 2, 3])
    assert np.allclose(moved.directors, tube.directors @ turn.T)
    assert np.allclose(moved.warp, [0, -1, 0])
    assert set(moved.edges) == set(tube.edges)
    wider = tube.replace(points=tube.points * [2, 1, 1])
    assert not np.allclose(wider.directors, tube.directors)
    assert tube.replace(source="tube").source == "tube"
    for bad in (np.diag([1, 1, -1]), np.ones((3, 3)), np.eye(2)):
        with pytest.raises(ValueError, match="rotation"):
            tube.transform(rotation=bad)
    with pytest.raises(ValueError, match="scale"):
        tube.transform(scale=0.0)
    with pytest.raises(ValueError, match="translation"):
        tube.transform(translation=(1, 2))


@pytest.mark.parametrize("degree", [1, 2])
def test_with_edges(degree):
    panel = meshes.rectangle(2.0, 1.0, (4, 3), degree=degree).replace(edges={})
    named = panel.with_edges(
        low=lambda x: x[:, 1] < 1e-9,
        rim=lambda x: np.full(len(x), True),
        part=[[1, 0]] if degree == 1 else [[2, 0]],
    )
    assert named.edges["low"].shape == (4, degree + 1)
    assert np.all(named.points[named.edges["low"], 1] == 0.0)
    rim = named.edges["rim"]
    assert len(rim) == 14 and np.array_equal(rim[:, 1], np.roll(rim[:, 0], -1))
    assert named.edges["part"].shape == (1, degree + 1)
    if degree == 2:
        assert named.edges["part"][0, 2] == 1
    with pytest.raises(MeshError, match="'none' selects no boundary segment"):
        panel.with_edges(none=lambda x: x[:, 0] > 9.0)
    with pytest.raises(MeshError, match="'odd' must return one True or False"):
        panel.with_edges(odd=lambda x: x[:, 0])
    with pytest.raises(MeshError, match="'gap'"):
        panel.with_edges(gap=[[0, 3]])


def test_chain_orders_segments():
    line = np.array([[3, 2], [0, 1], [3, 4], [2, 1]])
    ordered = chain(line)
    assert np.array_equal(ordered[1:, 0], ordered[:-1, 1])
    assert {tuple(sorted(s)) for s in ordered.tolist()} == {(0, 1), (1, 2), (2, 3), (3, 4)}
    two = chain(np.array([[5, 6], [1, 2], [6, 7], [0, 1]]))
    assert sorted(map(tuple, two.tolist())) == [(0, 1), (1, 2), (5, 6), (6, 7)]
    assert np.sum(two[1:, 0] != two[:-1, 1]) == 1
    loop = chain(np.array([[0, 1], [2, 0], [1, 2]]))
    assert np.array_equal(loop[:, 1], np.roll(loop[:, 0], -1))
    curved = chain(np.array([[2, 4, 3], [2, 0, 1]]))
    assert sorted(curved[:, 2].tolist()) == [1, 3] and curved[0, 1] == curved[1, 0] == 2
    fork = np.array([[0, 1], [1, 2], [1, 3]])
    assert np.array_equal(chain(fork), fork)


def test_package_is_light():
    code = (
        "import sys, meshes; meshes.annulus(1, 2, (8, 2));"
        "print([m for m in ('dolfinx', 'gmsh', 'meshio', 'scipy', 'petsc4py') if m in sys.modules])"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "[]"
    assert all(hasattr(meshes, name) for name in meshes.__all__)
