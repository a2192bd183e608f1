"""The package meshes against exact areas, normals, topology and deliberately broken input."""
# SPDX-License-Identifier: LGPL-3.0-or-later

import subprocess
import sys
import warnings

import numpy as np
import pytest

import meshes
from meshes import MeshError, Surface
from meshes.topology import chain, directed_edges, edge_keys

TURN = 2.0 * np.pi
FORMATS = ("msh", "vtu", "vtk", "obj", "stl", "ply")
L_SHAPE = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]


@pytest.fixture(autouse=True)
def _warnings_are_errors():
    # Whatever warns must be asked for with pytest.warns.
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        yield


def euler(surface):
    corners = surface.cells[:, : 3 if surface.kind == "triangle" else 4]
    edges = np.unique(edge_keys(directed_edges(surface.cells), len(surface.points)))
    return len(np.unique(corners)) - len(edges) + len(corners)


def orders(errors):
    errors = np.abs(errors)
    return np.log2(errors[:-1] / errors[1:])


def shuffled(surface, seed=3):
    """Points and cells of a surface with a random half of its cells turned over."""
    rng = np.random.default_rng(seed)
    turn = rng.random(len(surface.cells)) < 0.5
    order = {3: [0, 2, 1], 4: [0, 3, 2, 1], 9: [0, 3, 2, 1, 7, 6, 5, 4, 8]}
    cells = surface.cells.copy()
    cells[turn] = cells[turn][:, order[cells.shape[1]]]
    return Surface(surface.points, cells, source="shuffled", verify=False)


def facing(surface):
    """Unit normal of each cell from its corners."""
    a, b, c, d = (surface.points[surface.cells[:, k]] for k in (0, 1, 2, -1))
    normal = np.cross(c - a, (d if surface.cells.shape[1] == 4 else c) - b)
    if surface.cells.shape[1] == 9:
        normal = np.cross(c - a, surface.points[surface.cells[:, 3]] - b)
    return normal / np.linalg.norm(normal, axis=1, keepdims=True)


# --- panels ---------------------------------------------------------------------------------


SHAPES = {
    "disc": (lambda n, d: meshes.disc(1.5, n // 2, d), np.pi * 2.25),
    "annulus": (lambda n, d: meshes.annulus(1, 2, (n, n // 4), degree=d), 3 * np.pi),
    "ring": (lambda n, d: meshes.annulus(1, 2, (n, n // 4), slit=False, degree=d), 3 * np.pi),
    "cylinder": (lambda n, d: meshes.cylinder(0.5, 2, (n, 2), angle=4.0, degree=d), 4.0),
    "cap": (
        lambda n, d: meshes.spherical_cap(2.0, (0.3, 1.5), (0.0, 1.2), (n, n), degree=d),
        4.0 * 1.2 * (np.cos(0.3) - np.cos(1.5)),
    ),
}


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("degree, least", [(1, 1.95), (2, 3.9)])
def test_area_converges(name, degree, least):
    make, exact = SHAPES[name]
    errors = np.array([make(n, degree).area - exact for n in (16, 32)])
    assert orders(errors)[0] > least
    assert orders(errors)[0] < least + 0.5
    assert abs(errors[-1]) < 0.01 * exact


@pytest.mark.parametrize("degree", [1, 2])
def test_rectangle(degree):
    panel = meshes.rectangle(2.0, 0.5, (4, 3), degree=degree)
    assert panel.degree == degree and panel.kind == "quadrilateral"
    assert panel.area == pytest.approx(1.0, rel=1e-14)
    assert panel.mean_cell_size == pytest.approx(np.sqrt(1.0 / 12.0))
    assert np.array_equal(panel.bounds, [[0, 0, 0], [2, 0.5, 0]])
    assert np.array_equal(panel.directors, np.tile([0.0, 0.0, 1.0], (len(panel.points), 1)))
    places = {"left": (0, 0.0), "right": (0, 2.0), "bottom": (1, 0.0), "top": (1, 0.5)}
    assert set(panel.edges) == set(places)
    for name, (axis, value) in places.items():
        edge = panel.edges[name]
        assert edge.shape == ((3, 4)[axis], degree + 1)
        assert np.all(panel.points[edge, axis] == value)
        along = panel.points[edge][..., 1 - axis]
        assert np.all(along[:, 1] > along[:, 0])
        assert np.array_equal(edge[1:, 0], edge[:-1, 1])
        if degree == 2:
            assert np.allclose(along[:, 2], along[:, :2].mean(axis=1), atol=1e-15)


def test_nine_node_order():
    panel = meshes.rectangle(1.0, 1.0, (3, 2), degree=2)
    x = panel.points[panel.cells]
    for middle, ends in zip((4, 5, 6, 7, 8), ((0, 1), (1, 2), (2, 3), (3, 0), (0, 1, 2, 3))):
        assert np.allclose(x[:, middle], x[:, list(ends)].mean(axis=1), atol=1e-15)


def test_triangles_alternate():
    panel = meshes.rectangle(1.0, 1.0, (4, 4), triangles=True, warp="b")
    assert panel.kind == "triangle" and panel.cells.shape == (32, 3)
    assert panel.area == pytest.approx(1.0) and euler(panel) == 1
    assert np.allclose(panel.warp, [0.0, 1.0, 0.0])
    valence = np.bincount(panel.cells.ravel())
    inner = np.abs(panel.points[:, :2] - 0.5).max(axis=1) < 0.49
    assert set(valence[inner]) == {4, 8}
    same = meshes.to_triangles(meshes.rectangle(1.0, 1.0, (4, 4)))
    assert np.array_equal(np.sort(same.cells, axis=1), np.sort(panel.cells, axis=1))


@pytest.mark.parametrize(
    "surface, chi",
    [
        (meshes.rectangle(1, 1, (3, 2)), 1),
        (meshes.disc(1, 3), 1),
        (meshes.disc(1, 3, degree=2), 1),
        (meshes.annulus(1, 2, (6, 2)), 1),
        (meshes.annulus(1, 2, (6, 2), slit=False), 0),
        (meshes.cylinder(1, 2, (6, 2)), 0),
        (meshes.cylinder(1, 2, (6, 2), degree=2), 0),
        (meshes.spherical_cap(1, (0.5, 1.5), cells=(6, 2)), 0),
    ],
)
def test_euler_characteristic(surface, chi):
    assert euler(surface) == chi
    assert len(meshes.boundary_loops(surface)) == (1 if chi == 1 else 2)


def test_closed_in_both_directions():
    def torus(a, b):
        ring = 2.0 + 0.5 * np.cos(TURN * b)
        return ring * np.cos(TURN * a), ring * np.sin(TURN * a), 0.5 * np.sin(TURN * b)

    surface = meshes.patch(torus, (24, 12), closed=(True, True), degree=2)
    assert euler(surface) == 0 and surface.edges == {}
    assert meshes.boundary_loops(surface) == []
    assert surface.area == pytest.approx(4 * np.pi**2 * 2.0 * 0.5, rel=1e-3)


@pytest.mark.parametrize("degree", [1, 2])
def test_slit_keeps_two_lips(degree):
    ring = meshes.annulus(1.0, 2.0, (8, 2), degree=degree)
    start, end = ring.edges["start"], ring.edges["end"]
    assert np.intersect1d(start, end).size == 0
    assert np.allclose(ring.points[start], ring.points[end], atol=1e-14)
    assert np.all(ring.points[start, 1] == 0.0)
    assert set(ring.edges) == {"start", "end", "outer", "inner"}
    radius = np.linalg.norm(ring.points, axis=1)
    assert np.allclose(radius[ring.edges["outer"]], 2.0)
    assert np.allclose(radius[ring.edges["inner"]], 1.0)
    assert np.all(facing(ring)[:, 2] > 0.999)
    closed = meshes.annulus(1.0, 2.0, (8, 2), slit=False, degree=degree)
    assert len(closed.points) == len(ring.points) - len(np.unique(start))
    assert set(closed.edges) == {"outer", "inner"}
    assert set(meshes.annulus(1, 2, (8, 2), slit=False, angle=3).edges) == set(ring.edges)


def test_cylinder_and_cap_face_outward():
    for degree in (1, 2):
        tube = meshes.cylinder(0.5, 2.0, (12, 4), degree=degree, warp="b")
        radial = tube.points * [2.0, 2.0, 0.0]
        assert np.allclose(tube.directors, radial, atol=1e-14)
        assert np.allclose(tube.warp, [0, 0, 1])
        assert np.all(tube.points[tube.edges["bottom"], 2] == 0.0)
        assert np.all(tube.points[tube.edges["top"], 2] == 2.0)
        cap = meshes.spherical_cap(
            10.0, (np.radians(18), np.pi / 2), (0, np.pi / 2), (4, 5), degree=degree
        )
        assert np.allclose(cap.directors * 10.0, cap.points, atol=1e-13)
        assert np.allclose(cap.points[cap.edges["bottom"], 2], 0.0, atol=1e-14)
        assert np.allclose(cap.points[cap.edges["top"], 2], 10.0 * np.cos(np.radians(18)))
        assert np.allclose(cap.points[cap.edges["start"], 1], 0.0)
        assert np.allclose(cap.points[cap.edges["end"], 0], 0.0, atol=1e-14)


def test_disc_shape():
    for degree in (1, 2):
        disc = meshes.disc(2.0, (4, 3), degree=degree)
        assert disc.cells.shape == (16 + 48, 4 if degree == 1 else 9)
        assert meshes.scaled_jacobian(disc).min() > 0.5
        rim = disc.edges["rim"]
        assert rim.shape == (16, degree + 1)
        assert np.allclose(np.linalg.norm(disc.points[rim], axis=2), 2.0)
        assert rim[-1, 1] == rim[0, 0]
        turning = np.cross(disc.points[rim[:, 0]], disc.points[rim[:, 1]])[:, 2]
        assert np.all(turning > 0.0)
        assert np.all(facing(disc)[:, 2] > 0.999)


def test_normals_of_a_sphere():
    def error(n, degree):
        parameters = meshes.distorted((n, n), 0.0)
        # A smooth grading: on a regular grid errors would cancel and hide a wrong weight.
        parameters = parameters + 0.1 * np.sin(np.pi * parameters) * np.array([1.0, -0.7])
        cap = meshes.spherical_cap(
            1.0, (0.4, 1.4), (0.0, 1.0), (n, n), degree=degree, parameters=parameters
        )
        return np.linalg.norm(meshes.nodal_normals(cap.points, cap.cells) - cap.points, axis=1)

    coarse, fine = error(8, 1), error(16, 1)
    assert orders([np.sqrt(np.mean(coarse**2)), np.sqrt(np.mean(fine**2))])[0] > 1.4
    # Away from the boundary, where normals are one-sided, the order is two.
    inner = [
        e.reshape(n + 1, n + 1)[n // 4 : -n // 4, n // 4 : -n // 4].max()
        for n, e in ((16, fine), (32, error(32, 1)))
    ]
    assert orders(inner)[0] > 1.7
    curved = [error(n, 2).max() for n in (8, 16)]
    assert orders(curved)[0] > 1.8 and curved[1] < 0.1 * fine.max()


def test_normals_are_weighted_by_angle():
    # Three faces of a cube corner, one of them cut in two: the mean must not notice the cut.
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 0.0]])
    cells = [[0, 1, 4], [0, 4, 2], [0, 2, 3], [0, 3, 1]]
    corner = Surface(points, cells)
    assert np.allclose(corner.directors[0], np.full(3, 1 / np.sqrt(3)))


def test_distorted_and_skewed():
    cells = (6, 4)
    uniform = meshes.distorted(cells, 0.0)
    rough = meshes.distorted(cells, 0.25, seed=7)
    moved = np.abs(rough - uniform) * cells
    assert 0.15 < moved.max() <= 0.25
    assert np.all(moved[[0, -1]] == 0.0) and np.all(moved[:, [0, -1]] == 0.0)
    assert np.all(moved[1:-1, 1:-1].max(axis=2) > 0.0)
    assert np.array_equal(rough, meshes.distorted(cells, 0.25, seed=7))
    assert not np.array_equal(rough, meshes.distorted(cells, 0.25, seed=8))
    skew = meshes.skewed(cells, 2.0)
    assert np.array_equal(skew[[0, -1]], uniform[[0, -1]])
    assert np.array_equal(skew[..., 1], uniform[..., 1])
    assert skew[3, -1, 0] - skew[3, 0, 0] == pytest.approx(2.0 / 6.0)
    for parameters in (rough, skew):
        for degree in (1, 2):
            panel = meshes.rectangle(3.0, 2.0, cells, degree=degree, parameters=parameters)
            assert panel.area == pytest.approx(6.0)
            assert meshes.scaled_jacobian(panel).min() < 0.98
    tube = meshes.cylinder(1.0, 1.0, cells, parameters=rough)
    assert np.allclose(np.linalg.norm(tube.points[:, :2], axis=1), 1.0)


@pytest.mark.parametrize(
    "call, words",
    [
        (lambda: meshes.rectangle(-1, 1, (2, 2)), "length must be a positive"),
        (lambda: meshes.rectangle(1, np.nan, (2, 2)), "width must be a positive"),
        (lambda: meshes.rectangle(1, 1, (0, 2)), "cells must be two whole numbers"),
        (lambda: meshes.rectangle(1, 1, (2.5, 2)), "cells must be two whole numbers"),
        (lambda: meshes.rectangle(1, 1, 2, degree=3), "degree must be 1 or 2"),
        (lambda: meshes.rectangle(1, 1, 2, degree=2, triangles=True), "degree 1 only"),
        (lambda: meshes.rectangle(1, 1, 2, warp="c"), "warp must be"),
        (lambda: meshes.rectangle(1, 1, 2, parameters=np.zeros((2, 2, 2))), "shape"),
        (lambda: meshes.annulus(2, 1, (4, 2)), "smaller than the outer"),
        (lambda: meshes.annulus(1, 2, (4, 2), angle=7), "2 pi"),
        (lambda: meshes.cylinder(1, 1, (2, 2)), "at least 3 cells"),
        (lambda: meshes.disc(0, 2), "radius must be a positive"),
        (lambda: meshes.disc(1, 2, degree=0), "degree must be"),
        (lambda: meshes.spherical_cap(1, (0.0, 1.0)), "disc"),
        (lambda: meshes.spherical_cap(1, (1.0, 0.5)), "rising angles"),
        (lambda: meshes.spherical_cap(1, (0.5, 1.0), (1.0, 0.5)), "longitude"),
        (lambda: meshes.distorted((2, 2), 0.5), "amount"),
        (lambda: meshes.skewed((4, 2), 2.0), "shift"),
        (lambda: meshes.patch(lambda a, b: (a, b), (2, 2)), "three arrays"),
        (lambda: meshes.patch(lambda a, b: (a, b, 0), 4, closed=(True, False)), "gap of 1 m"),
        (lambda: meshes.patch(lambda a, b: (a, b, 0), 2, names=("a",)), "four"),
        (lambda: meshes.from_outline([(0, 0), (1, 0)], 0.1), "at least 3 corners"),
        (lambda: meshes.from_outline([(0, 0), (1, 0), (2, 0)], 0.1), "no area"),
        (lambda: meshes.from_outline([(0, 0), (1, 0), (1, 0), (0, 1)], 0.1), "repeats corner 1"),
        (lambda: meshes.from_outline([(0, 0), (2, 2), (2, 0), (0, 1)], 0.1), "sides 0 and 2"),
        (lambda: meshes.from_outline(L_SHAPE, 0.0), "size must be"),
        (lambda: meshes.from_outline(L_SHAPE, 0.1, names=["a"]), "names must be 6"),
        (
            lambda: meshes.from_outline([(0, 0, 0), (1, 0, 0), (1, 1, 0.1), (0, 1, 0)], 0.1),
            "not flat",
        ),
    ],
)
def test_panels_refuse(call, words):
    with pytest.raises(ValueError, match=words):
        call()


def test_patch_director_against_cells():
    with pytest.raises(MeshError, match="director of point 0 points against"):
        meshes.patch(lambda a, b: (a, b, 0), (2, 2), normal=lambda a, b: (0, 0, -1))


# --- outlines -------------------------------------------------------------------------------


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


# --- the surface and its check --------------------------------------------------------------


SQUARE = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0], [1, 1, 0], [2, 1, 0.0]])
TWO = [[0, 1, 4, 3], [1, 2, 5, 4]]


def broken(**changes):
    fields = {"points": SQUARE, "cells": TWO, "source": "skirt.vtu"} | changes
    return Surface(**fields)


def with_point(index, value):
    points = SQUARE.copy()
    points[index] = value
    return points


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
    with pytest.raises(MeshError, match=r"points 0 and 1 belongs to 3 cells \[0, 1, 2\]"):
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


# --- repairs --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "surface",
    [
        meshes.rectangle(1, 1, (5, 4), triangles=True),
        meshes.cylinder(1, 1, (9, 4)),
        meshes.cylinder(1, 1, (9, 4), degree=2),
        meshes.disc(1, 3),
    ],
    ids=["triangles", "quads", "curved", "disc"],
)
def test_orient_undoes_random_flips(surface):
    mixed = shuffled(surface)
    with pytest.raises(MeshError, match=r"shuffled: neighbouring cells .* face opposite"):
        mixed.replace(verify=True)
    back = meshes.orient(mixed).replace(verify=True)
    along = np.einsum("mi,mi->m", facing(back), facing(surface))
    assert np.all(np.abs(along) > 0.999) and abs(along.sum()) > len(along) - 0.5
    first = np.array_equal(mixed.cells[0], surface.cells[0])
    assert (along[0] > 0) == first
    turned = meshes.orient(mixed, towards=-facing(surface)[0] if first else facing(surface)[0])
    if surface.kind == "triangle":
        assert np.dot(facing(turned)[0], facing(back)[0]) < 0


def test_orient_preferences():
    tube = meshes.cylinder(1.0, 1.0, (12, 3))
    inward = meshes.orient(shuffled(tube), majority=False)
    outward = meshes.orient(inward, outward=True).replace(verify=True)
    assert np.allclose(outward.directors, outward.points * [1, 1, 0], atol=1e-9)
    cells = tube.cells.copy()
    cells[0] = cells[0][[0, 3, 2, 1]]
    one_wrong = Surface(tube.points, cells, verify=False)
    assert np.array_equal(meshes.orient(one_wrong, majority=True).cells, tube.cells)
    assert not np.array_equal(meshes.orient(one_wrong).cells, tube.cells)
    flat = meshes.rectangle(1, 1, (3, 3))
    down = meshes.orient(flat, towards=(0, 0, -1))
    assert np.all(facing(down)[:, 2] < -0.999)
    assert np.array_equal(down.directors, -flat.directors)
    assert np.array_equal(down.edges["left"], flat.edges["left"])
    two = Surface(
        np.vstack([SQUARE, np.add(SQUARE, [9, 0, 0])]),
        [[0, 1, 4, 3], [1, 2, 5, 4], [6, 9, 10, 7], [7, 10, 11, 8]],
    )
    up = meshes.orient(two, towards=(0, 0, 1))
    assert np.all(facing(up)[:, 2] > 0.999) and np.any(facing(two)[:, 2] < 0)
    with pytest.raises(ValueError, match="at most one"):
        meshes.orient(flat, outward=True, towards=(0, 0, 1))
    with pytest.raises(ValueError, match="towards"):
        meshes.orient(flat, towards=(0, 0, 0))


def test_moebius_is_refused():
    n = 12
    t = TURN * np.arange(n) / n
    lower, upper = (
        np.stack(
            [
                (1 + s * np.cos(t / 2)) * np.cos(t),
                (1 + s * np.cos(t / 2)) * np.sin(t),
                s * np.sin(t / 2),
            ],
            axis=1,
        )
        for s in (-0.3, 0.3)
    )
    i = np.arange(n - 1)
    cells = np.stack([i, i + 1, n + i + 1, n + i], axis=1)
    points = np.vstack([lower, upper])
    # Closed with a half twist: the last cell joins lower to upper.
    moebius = Surface(
        points, np.vstack([cells, [n - 1, n, 0, 2 * n - 1]]), source="band", verify=False
    )
    with pytest.raises(MeshError, match=r"band: the surface has only one side .* cell \d+"):
        meshes.orient(moebius)
    with pytest.raises(MeshError, match="face opposite sides"):
        moebius.replace(verify=True)


def test_merge_and_clean():
    panel = meshes.rectangle(1.0, 1.0, (3, 3)).with_edges(all=lambda x: x[:, 0] >= 0)
    torn = Surface(
        panel.points[panel.cells].reshape(-1, 3),
        np.arange(36).reshape(-1, 4),
        verify=False,
    )
    noise = 1e-7 * np.random.default_rng(1).standard_normal(torn.points.shape)
    joined = meshes.merge_duplicates(torn.replace(points=torn.points + noise), 1e-5)
    joined = joined.replace(verify=True)
    assert len(joined.points) == 16 and euler(joined) == 1
    assert joined.area == pytest.approx(1.0, abs=1e-6)
    assert meshes.merge_duplicates(panel) is panel
    with pytest.raises(ValueError, match="tolerance"):
        meshes.merge_duplicates(panel, -1.0)
    ring = meshes.annulus(1.0, 2.0, (8, 2))
    closed = meshes.merge_duplicates(ring)
    assert euler(closed) == 0 and np.allclose(closed.directors, [0, 0, 1])
    # A sliver of an edge between two joined points is no segment any more.
    sliver = Surface(
        [*SQUARE.tolist(), [1, -1e-9, 0]],
        [[0, 6, 4, 3], [1, 2, 5, 4]],
        edges={"low": [[0, 6], [6, 1], [1, 2]]},
        verify=False,
    )
    low = meshes.merge_duplicates(sliver, 1e-6).replace(verify=True).edges["low"]
    assert np.array_equal(low, [[0, 1], [1, 2]])
    loose = Surface(
        np.vstack([[[9, 9, 9]], panel.points, [[8, 8, 8]]]),
        panel.cells + 1,
        verify=False,
        edges={"rim": panel.edges["all"] + 1, "gone": [[0, 17]]},
    )
    with pytest.raises(MeshError, match=r"point 0 .*\(2 such points\)"):
        loose.replace(verify=True)
    tidy = meshes.clean(loose).replace(verify=True)
    assert np.array_equal(tidy.points, panel.points) and np.array_equal(tidy.cells, panel.cells)
    assert np.array_equal(tidy.edges["rim"], panel.edges["all"]) and "gone" not in tidy.edges


@pytest.mark.parametrize("degree", [1, 2])
def test_boundary_loops(degree):
    ring = meshes.annulus(1.0, 2.0, (12, 2), slit=False, degree=degree)
    outer, inner = meshes.boundary_loops(ring)
    assert len(outer) == len(inner) == 12 * degree
    assert np.allclose(np.linalg.norm(ring.points[outer], axis=1), 2.0)
    assert np.allclose(np.linalg.norm(ring.points[inner], axis=1), 1.0)
    for loop, sign in ((outer, 1), (inner, -1)):
        x = ring.points[loop]
        assert np.all(sign * np.cross(x, np.roll(x, -1, axis=0))[:, 2] > 0)


def test_loops_that_touch():
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0.0]])
    bow = Surface(points, [[0, 1, 2], [0, 3, 4]])
    loops = meshes.boundary_loops(bow)
    assert sorted(len(loop) for loop in loops) == [3, 3]


def test_split_triangles():
    tube = meshes.cylinder(1.0, 1.0, (8, 3), triangles=True, warp="b")
    tube = tube.replace(panels={"p": [0, 5]})
    split = meshes.split_triangles(tube)
    assert split.cells.shape == (3 * len(tube.cells), 4)
    assert split.area == pytest.approx(tube.area, rel=1e-12) and euler(split) == 0
    areas = split.cell_areas.reshape(-1, 3).sum(axis=1)
    assert np.allclose(areas, tube.cell_areas)
    assert split.edges["top"].shape == (16, 2)
    assert np.array_equal(split.edges["top"][1:, 0], split.edges["top"][:-1, 1])
    assert np.array_equal(split.panels["p"], [0, 1, 2, 15, 16, 17])
    assert split.warp.shape == (len(split.cells), 3)
    assert np.allclose(np.linalg.norm(split.directors, axis=1), 1.0)
    assert np.allclose(split.directors[: len(tube.points)], tube.directors)
    with pytest.raises(ValueError, match="quads already"):
        meshes.split_triangles(split)


def test_to_triangles():
    panel = meshes.rectangle(1, 1, (4, 4), parameters=meshes.skewed((4, 4), 1.5), warp="a")
    panel = panel.replace(panels={"p": [3]})
    for pattern in ("alternating", "first", "second", "shortest"):
        cut = meshes.to_triangles(panel, pattern)
        assert cut.cells.shape == (32, 3) and cut.area == pytest.approx(1.0)
        assert np.array_equal(cut.panels["p"], [6, 7]) and cut.warp.shape == (32, 3)
        assert np.array_equal(cut.edges["left"], panel.edges["left"])
    worst = {
        p: meshes.scaled_jacobian(meshes.to_triangles(panel, p)).min()
        for p in ("first", "second", "shortest")
    }
    assert worst["shortest"] >= max(worst["first"], worst["second"]) > 0
    with pytest.raises(ValueError, match="pattern"):
        meshes.to_triangles(panel, "random")
    with pytest.raises(ValueError, match="4-node"):
        meshes.to_triangles(meshes.rectangle(1, 1, (2, 2), degree=2))


def test_elevate():
    panel = meshes.rectangle(2, 1, (3, 2))
    curved = meshes.elevate(panel)
    direct = meshes.rectangle(2, 1, (3, 2), degree=2)
    assert curved.cells.shape == (6, 9) and curved.area == pytest.approx(2.0)
    assert np.allclose(curved.points[curved.cells], direct.points[direct.cells])
    for name in direct.edges:
        assert np.allclose(curved.points[curved.edges[name]], direct.points[direct.edges[name]])

    def on_sphere(x):
        return x / np.linalg.norm(x, axis=-1, keepdims=True)

    def cube_face(a, b):
        x = on_sphere(np.stack([2 * a - 1, 2 * b - 1, np.ones_like(a)], axis=-1))
        return x[..., 0], x[..., 1], x[..., 2]

    # One of six faces of a cube blown up: its boundary is great circles, which project to
    # themselves, so the area is exact but for the cells.
    faces = [meshes.patch(cube_face, (n, n)) for n in (4, 8)]
    errors = [meshes.elevate(face, on_sphere).area - TURN / 3 for face in faces]
    assert orders(errors)[0] > 3.5
    with pytest.raises(ValueError, match="project must return"):
        meshes.elevate(panel, lambda x: x[:1])
    with pytest.raises(ValueError, match="4-node"):
        meshes.elevate(curved)


def test_scaled_jacobian():
    assert np.allclose(meshes.scaled_jacobian(meshes.rectangle(3, 1, (2, 2))), 1.0)
    angle = np.radians(35.0)
    lean = meshes.patch(lambda a, b: (a + np.cos(angle) * b, np.sin(angle) * b, 0), (2, 2))
    assert np.allclose(meshes.scaled_jacobian(lean), np.sin(angle))
    even = Surface([[0, 0, 0], [1, 0, 0], [0.5, np.sqrt(0.75), 0]], [[0, 1, 2]])
    assert meshes.scaled_jacobian(even) == pytest.approx(np.sqrt(0.75))
    assert even.area == pytest.approx(np.sqrt(0.75) / 2)
    dart = Surface(with_point(5, (1.2, 0.2, 0)), TWO, verify=False)
    assert meshes.scaled_jacobian(dart)[1] < 0


# --- files ----------------------------------------------------------------------------------


def samples():
    quads = meshes.cylinder(0.2, 1.0, (12, 4), angle=5.0)
    return {
        "quads": quads.replace(panels={"front": [0, 1], "back": np.arange(6, 48)}),
        "triangles": meshes.cylinder(0.2, 1.0, (12, 4), triangles=True),
        "curved": meshes.annulus(0.1, 0.2, (12, 2), degree=2),
    }


def by_place(surface):
    """Cells as sorted corner coordinates and their normals, whatever the numbering."""
    centres = surface.points[surface.cells].mean(axis=1)
    order = np.lexsort(np.round(centres, 9).T)
    return centres[order], facing(surface)[order]


@pytest.mark.parametrize("kind", FORMATS)
@pytest.mark.parametrize("name", ["quads", "triangles", "curved"])
def test_round_trip(tmp_path, name, kind, capfd):
    surface = samples()[name]
    path = tmp_path / f"{name}.{kind}"
    if name == "curved" and kind in ("obj", "stl", "ply"):
        with pytest.raises(MeshError, match=f"curved.{kind}: .* no curved cells"):
            meshes.save(surface, path)
        return
    meshes.save(surface, path)
    assert [p.name for p in tmp_path.iterdir()] == [path.name]
    back = meshes.load(path)
    assert back.source == path.name
    expected = (
        meshes.to_triangles(surface, "shortest") if kind == "stl" and name == "quads" else surface
    )
    for got, wanted in zip(by_place(back), by_place(expected)):
        assert np.allclose(got, wanted, atol=1e-12)
    if kind != "stl":
        assert np.array_equal(back.cells, surface.cells)
        assert np.allclose(back.points, surface.points, rtol=0, atol=1e-15)
    if kind in ("msh", "vtu", "vtk", "ply"):
        assert np.allclose(back.directors, surface.directors, atol=1e-14)
    if kind in ("msh", "vtu", "vtk"):
        for got, wanted in ((back.edges, surface.edges), (back.panels, surface.panels)):
            assert set(got) == set(wanted)
            assert all(np.array_equal(got[key], wanted[key]) for key in wanted)
    else:
        loops = meshes.boundary_loops(surface)
        assert list(back.edges) == [f"boundary_{k}" for k in range(len(loops))]
        assert [len(e) for e in back.edges.values()] == [len(loop) for loop in loops]
    assert capfd.readouterr() == ("", "")


def test_warp_and_overlapping_panels(tmp_path):
    surface = meshes.rectangle(0.5, 0.5, (3, 3), warp=(1, 0, 0))
    surface = surface.replace(panels={"a": [0, 1], "b": [1, 2]})
    meshes.save(surface, tmp_path / "x.vtu")
    back = meshes.load(tmp_path / "x.vtu")
    assert np.array_equal(back.warp, np.tile([1.0, 0, 0], (9, 1)))
    assert {k: v.tolist() for k, v in back.panels.items()} == {"a": [0, 1], "b": [1, 2]}
    with pytest.warns(UserWarning, match="keep no warp"):
        with pytest.raises(MeshError, match="panel 'b' shares cells"):
            meshes.save(surface, tmp_path / "x.msh")
    both = surface.replace(panels={"left": [0]}, warp=None)
    with pytest.raises(MeshError, match="'left' names both"):
        meshes.save(both, tmp_path / "x.msh")
    assert not (tmp_path / "x.msh").exists()
    with pytest.raises(MeshError, match=r"unknown file type '.doc'"):
        meshes.save(surface, tmp_path / "x.doc")


def test_save_is_all_or_nothing(tmp_path, monkeypatch):
    meshio = pytest.importorskip("meshio")
    path = tmp_path / "x.vtu"
    meshes.save(meshes.rectangle(0.5, 0.5, (2, 2)), path)
    before = path.read_bytes()
    # Whoever has the old file open keeps reading the old file.
    with open(path, "rb") as reader:
        meshes.save(meshes.rectangle(0.5, 0.5, (4, 4)), path)
        assert reader.read() == before != path.read_bytes()
    before = path.read_bytes()

    def fail(name, *rest, **options):
        open(name, "w").close()
        raise OSError("disk full")

    monkeypatch.setattr(meshio, "write", fail)
    with pytest.raises(OSError, match="disk full"):
        meshes.save(meshes.rectangle(0.5, 0.5, (3, 3)), path)
    assert path.read_bytes() == before and len(list(tmp_path.iterdir())) == 1


MIXED = """v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\nv 9 9 9
f 1 2 5 4\nf 2 3 5\nf 3 6 5\n"""


def test_load_mixed_cells(tmp_path):
    path = tmp_path / "mixed.obj"
    path.write_text(MIXED)
    surface = meshes.load(path)
    assert surface.kind == "quadrilateral" and len(surface.cells) == 4 + 3 + 3
    assert surface.area == pytest.approx(2.0) and euler(surface) == 1
    assert surface.bounds[1].max() == 2.0
    assert list(surface.edges) == ["boundary_0"] and len(surface.edges["boundary_0"]) == 12


def test_load_obj_of_a_drawing_program(tmp_path):
    text = "mtllib m\no shirt\n" + "".join(f"v {x} {y} 0 0.5 0.5 0.5\n" for x, y, _ in SQUARE)
    text += "vt 0 0\nvt 1 1\nvn 0 0 1\ng front\nusemtl m\nf 1/1/1 2/2/1 5/1/1 4/2/1\n"
    text += "g back\nf 2/1/1 3/2/1 6/2/1 5/1/1\n"
    (tmp_path / "x.obj").write_text(text)
    surface = meshes.load(tmp_path / "x.obj")
    assert np.array_equal(surface.points, SQUARE) and np.array_equal(surface.cells, TWO)
    assert {k: v.tolist() for k, v in surface.panels.items()} == {"front": [0], "back": [1]}
    (tmp_path / "y.obj").write_text(text.replace("g back", "g front"))
    assert meshes.load(tmp_path / "y.obj").panels["front"].tolist() == [0, 1]
    (tmp_path / "z.obj").write_text(text.replace("g front", "").replace("g back", ""))
    assert meshes.load(tmp_path / "z.obj").panels["shirt"].tolist() == [0, 1]


def test_load_units_and_triangles(tmp_path):
    path = tmp_path / "t.obj"
    path.write_text("v 0 0 0\nv 800 0 0\nv 0 500 0\nf 1 2 3\n")
    assert meshes.load(path, unit="mm").area == pytest.approx(0.2)
    with pytest.warns(UserWarning, match=r"t.obj: read in 'm', .* 943 m .*unit='mm'"):
        meshes.load(path)
    path.write_text("v 0 0 0\nv 4 0 0\nv 0 5 0\nf 1 2 3\n")
    assert meshes.load(path, unit="in").area == pytest.approx(10 * 0.0254**2)
    assert meshes.load(path, unit="cm").kind == "triangle"
    split = meshes.load(path, unit="cm", quads="split")
    assert split.kind == "quadrilateral" and len(split.cells) == 3
    with pytest.warns(UserWarning, match="measures 0.0064"):
        meshes.load(path, unit="mm")
    with pytest.raises(ValueError, match="unit must be one of m, cm, mm, in"):
        meshes.load(path, unit="ft")
    with pytest.raises(ValueError, match="quads"):
        meshes.load(path, quads=True)


def test_load_turns_cells(tmp_path):
    path = tmp_path / "flip.obj"
    path.write_text(MIXED.replace("f 3 6 5", "f 3 5 6").replace("v 9 9 9", ""))
    with pytest.warns(UserWarning, match="flip.obj: 3 of 10 cells faced the other side"):
        surface = meshes.load(path)
    assert np.all(facing(surface)[:, 2] > 0)


@pytest.mark.parametrize(
    "name, text, words",
    [
        ("a.obj", "v 0 0 0\nv 1 0 0\nv 0 nan 0\nf 1 2 3\n", "point 2 .*finite"),
        ("b.obj", "v 0 0 0\nv 1 0 0\n", "no triangles or quads"),
        ("c.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 7\n", "cell 0 .* 0 to 2"),
        ("d.vtu", "not a mesh", "cannot be read as .vtu"),
        ("e.msh", "not a mesh", "cannot be read as .msh"),
        ("f.msh", "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 9", "f.msh: "),
        ("g.stl", "", "g.stl: "),
        ("h.ply", "ply\nformat strange 1.0\n", "cannot be read as .ply"),
        ("i.step", "ISO-10303-21;", "unknown file type '.step'"),
        ("j.obj", "v 0 0 0\nv 1 0 0\nv 2 1 0\nv 1 2 0\nv 0 1 0\nf 1 2 3 4 5\n", "four corners"),
    ],
)
def test_load_refuses(tmp_path, name, text, words, capfd):
    (tmp_path / name).write_text(text)
    with pytest.raises(MeshError, match=words) as caught:
        meshes.load(tmp_path / name)
    assert str(caught.value).startswith(f"{name}: ") and "\n" not in str(caught.value)
    assert capfd.readouterr() == ("", "")


def test_load_missing_file(tmp_path):
    with pytest.raises(MeshError, match=r"shirt.vtu: there is no such file"):
        meshes.load(tmp_path / "shirt.vtu")


def test_load_mixed_with_curved(tmp_path):
    meshio = pytest.importorskip("meshio")
    panel = meshes.rectangle(0.5, 0.5, (2, 1), degree=2)
    cells = [("quad9", panel.cells[:1]), ("quad", panel.cells[1:, :4])]
    meshio.write_points_cells(tmp_path / "x.vtu", panel.points, cells)
    with pytest.raises(MeshError, match=r"x.vtu: 9-node quads are mixed"):
        meshes.load(tmp_path / "x.vtu")


def test_load_leaves_out_stray_segments(tmp_path):
    meshio = pytest.importorskip("meshio")
    panel = meshes.rectangle(0.5, 0.5, (2, 2))
    cells = [("quad", panel.cells), ("line", [[0, 1], [0, 8]])]
    flags = {"edge:hem": [np.zeros(4, dtype=int), np.ones(2, dtype=int)]}
    meshio.write_points_cells(tmp_path / "x.vtu", panel.points, cells, cell_data=flags)
    with pytest.warns(UserWarning, match=r"x.vtu: 1 segments of 'hem' lie along no side"):
        surface = meshes.load(tmp_path / "x.vtu")
    assert np.array_equal(surface.edges["hem"], [[0, 1]])


def test_load_straightens_quadratic_triangles(tmp_path):
    meshio = pytest.importorskip("meshio")
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.5, 0, 0], [0.5, 0.5, 0], [0, 0.5, 0.0]])
    meshio.write_points_cells(tmp_path / "x.vtu", points, [("triangle6", [[0, 1, 2, 3, 4, 5]])])
    with pytest.warns(UserWarning, match="triangle6 cells are straightened"):
        surface = meshes.load(tmp_path / "x.vtu")
    assert len(surface.points) == 3 and surface.kind == "triangle"


def test_load_stl_joins_points(tmp_path):
    # Single precision: the shared corner differs in its last digit between the two facets.
    text = "solid\n"
    for facet in (
        ["0 0 0", "1 0 0", "0.3333333 1 0"],
        ["1 0 0", "1.3333333 1 0", "0.33333334 1 0"],
    ):
        text += "facet normal 0 0 1\nouter loop\n"
        text += "".join(f"vertex {vertex}\n" for vertex in facet)
        text += "endloop\nendfacet\n"
    (tmp_path / "x.stl").write_text(text + "endsolid\n")
    surface = meshes.load(tmp_path / "x.stl")
    assert len(surface.points) == 4 and len(surface.edges["boundary_0"]) == 4


@pytest.mark.parametrize("version", [2.2, 4.1])
@pytest.mark.parametrize("save_all", [0, 1])
def test_physical_groups_of_gmsh(tmp_path, version, save_all):
    gmsh = pytest.importorskip("gmsh")
    path = str(tmp_path / "groups.msh")
    gmsh.initialize([], False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        geo = gmsh.model.geo
        corners = [(0, 0), (1, 0), (2, 0), (2, 1), (1, 1), (0, 1)]
        tags = [geo.addPoint(x, y, 0.0, 0.4) for x, y in corners]
        lines = [geo.addLine(tags[i], tags[(i + 1) % 6]) for i in range(6)]
        seam = geo.addLine(tags[1], tags[4])
        one = geo.addPlaneSurface([geo.addCurveLoop([lines[0], seam, lines[4], lines[5]])])
        two = geo.addPlaneSurface([geo.addCurveLoop([lines[1], lines[2], lines[3], -seam])])
        geo.synchronize()

        def group(dim, members, name):
            gmsh.model.setPhysicalName(dim, gmsh.model.addPhysicalGroup(dim, members), name)

        group(1, lines[:2], "hem")
        group(1, [seam], "seam")
        group(2, [one], "front")
        group(2, [one, two], "all")
        gmsh.model.mesh.generate(2)
        gmsh.option.setNumber("Mesh.MshFileVersion", version)
        gmsh.option.setNumber("Mesh.SaveAll", save_all)
        gmsh.write(path)
    finally:
        gmsh.finalize()
    surface = meshes.load(path)
    assert surface.area == pytest.approx(2.0) and euler(surface) == 1
    if version == 2.2 and save_all:
        # gmsh itself leaves the groups out of such a file.
        assert list(surface.edges) == ["boundary_0"]
        return
    assert set(surface.edges) == {"hem", "seam"}
    assert np.all(surface.points[surface.edges["hem"], 1] == 0.0)
    assert np.all(surface.points[surface.edges["seam"], 0] == 1.0)
    ends = surface.points[surface.edges["hem"][[0, -1], [0, 1]], 0]
    assert set(ends) == {0.0, 2.0}
    if version == 2.2 or save_all:
        assert set(surface.panels) == {"front", "all"}
        assert len(surface.panels["all"]) == len(surface.cells)
    assert surface.cell_areas[surface.panels["front"]].sum() == pytest.approx(1.0)


def test_package_is_light():
    code = (
        "import sys, meshes; meshes.annulus(1, 2, (8, 2));"
        "print([m for m in ('dolfinx', 'gmsh', 'meshio', 'scipy', 'petsc4py') if m in sys.modules])"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "[]"
    assert all(hasattr(meshes, name) for name in meshes.__all__)
