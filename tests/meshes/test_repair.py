# SPDX-License-Identifier: LGPL-3.0-or-later
"""Orientation, joined points, boundary loops and changes of the cells."""

import numpy as np
import pytest

import meshes
from meshes import MeshError, Surface
from tests.meshes.measures import SQUARE, TURN, TWO, euler, facing, orders, shuffled, with_point


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
