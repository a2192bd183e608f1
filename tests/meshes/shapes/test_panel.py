# SPDX-License-Identifier: LGPL-3.0-or-later
"""Panels against exact areas, normals and topology."""

import numpy as np
import pytest

import meshes
from meshes import MeshError, Surface
from tests.meshes.measures import L_SHAPE, TURN, euler, facing, orders

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
