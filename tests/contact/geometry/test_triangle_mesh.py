# SPDX-License-Identifier: LGPL-3.0-or-later
"""Triangles: signed distance against numpy and a kept library; smooth normals against ellipsoids.

`trimesh` and `libigl` are no part of shellform. Where one is installed it is asked too.
"""

import numpy as np
import pytest

from contact.geometry.ellipsoid import closest_points
from contact.geometry.triangle_mesh.closest import STACK, closest, on_triangle, signed_distances
from contact.geometry.triangle_mesh.placed import know_normal, new_placed, refit
from contact.geometry.triangle_mesh.smooth import flat_gap, most_raised, smooth_gap
from contact.geometry.triangle_mesh.sphere import sphere
from contact.geometry.triangle_mesh.topology import mesh_of
from contact.kernel import kernel


def placed(vertices, triangles, sets=None):
    mesh = mesh_of(triangles, vertices, sets)
    place = new_placed(mesh, len(vertices))
    place.vertices[:] = vertices
    refit(mesh, place)
    return mesh, place


def wavy(divisions):
    """A body with hollows and ridges, as flat as 1 to 3."""
    vertices, triangles = sphere(1.0, divisions)
    vertices = vertices * [0.15, 0.05, 0.1]
    return vertices + 0.01 * np.sin(60 * vertices[:, [1, 2, 0]]), triangles


def by_hand(vertices, triangles, x):
    """Signed distance of one point: every triangle, its edges and corners, in plain numpy."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    best, feet = np.full(len(a), np.inf), np.empty_like(a)
    foot = x - np.sum((x - a) * normal, axis=1, keepdims=True) * normal
    inside = np.ones(len(a), bool)
    for p, q in ((a, b), (b, c), (c, a)):
        inside &= np.sum(np.cross(q - p, foot - p) * normal, axis=1) >= 0
        part = np.clip(np.sum((x - p) * (q - p), axis=1) / np.sum((q - p) ** 2, axis=1), 0, 1)
        on_edge = p + part[:, None] * (q - p)
        far = np.linalg.norm(x - on_edge, axis=1)
        nearer = far < best
        best[nearer], feet[nearer] = far[nearer], on_edge[nearer]
    best[inside], feet[inside] = np.linalg.norm(x - foot, axis=1)[inside], foot[inside]
    # solid angles of all triangles: 4 pi inside, 0 outside (van Oosterom and Strackee)
    r = [p - x for p in (a, b, c)]
    size = [np.linalg.norm(p, axis=1) for p in r]
    down = size[0] * size[1] * size[2]
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        down = down + np.sum(r[i] * r[j], axis=1) * size[k]
    angle = 2 * np.arctan2(np.sum(r[0] * np.cross(r[1], r[2]), axis=1), down).sum()
    return best.min() if angle < 2 * np.pi else -best.min()


def distances(mesh, place, points):
    out, found = np.empty(len(points)), np.empty(len(points), np.int64)
    signed_distances(mesh, place, points, out, found)
    return out, found


def places(vertices, triangles, rng, count):
    """Points all around, and on, just off and beside edges and corners."""
    corners = vertices[triangles[rng.integers(len(triangles), size=count)]]
    weights = rng.dirichlet([0.4] * 3, count)
    weights[: count // 8] = [0.5, 0.5, 0.0]
    weights[count // 8 : count // 4] = [1.0, 0.0, 0.0]
    near = np.einsum("na,nac->nc", weights, corners)
    near = near + 10.0 ** rng.uniform(-6, -1, (count, 1)) * rng.standard_normal(near.shape)
    return np.vstack([near, rng.uniform(-0.2, 0.2, near.shape)])


def test_signed_distance_is_that_of_numpy():
    vertices, triangles = wavy(4)
    points = places(vertices, triangles, np.random.default_rng(0), 250)
    found = distances(*placed(vertices, triangles), points)[0]
    expected = np.array([by_hand(vertices, triangles, x) for x in points])
    assert np.abs(found - expected).max() < 1e-12
    assert 50 < (found < 0).sum() < 450


def test_signed_distance_is_that_of_a_kept_library():
    """1e5 points around a body of 32,768 triangles, sign included."""
    vertices, triangles = wavy(6)
    points = places(vertices, triangles, np.random.default_rng(1), 50_000)
    found = distances(*placed(vertices, triangles), points)[0]
    try:
        import igl
    except ImportError:
        trimesh = pytest.importorskip(
            "trimesh", reason="needs one of libigl and trimesh (with rtree), no part of shellform"
        )
        body = trimesh.Trimesh(vertices, triangles, process=False)
        expected = -trimesh.proximity.signed_distance(body, points)
    else:
        kind = igl.SIGNED_DISTANCE_TYPE_PSEUDONORMAL
        expected = igl.signed_distance(points, vertices, triangles.astype(np.int32), kind)[0]
    assert np.abs(found - expected).max() < 1e-9


def test_a_guess_and_the_tree_change_no_answer():
    """Points in the middle between triangles too: of equal distances the lowest number wins."""
    vertices, triangles = sphere(0.1, 3)
    rng = np.random.default_rng(2)
    mesh, place = placed(vertices, triangles)
    points = np.vstack([1.1 * vertices[:60], np.zeros((1, 3)), rng.uniform(-0.1, 0.1, (60, 3))])
    stack, bounds = np.empty(STACK, np.int64), np.empty(STACK)
    other, other_place = placed(vertices, triangles)
    other = mesh_of(triangles, vertices[:, ::-1] * [1, 3, 9])  # another tree
    other_place = new_placed(other, len(vertices))
    other_place.vertices[:] = vertices
    refit(other, other_place)
    for x in points:
        first = closest(mesh, place, *x, -1, -1, stack, bounds)
        assert first == closest(other, other_place, *x, -1, -1, stack, bounds)
        for guess in rng.integers(len(triangles), size=5):
            assert first == closest(mesh, place, *x, -1, guess, stack, bounds)
        own = [on_triangle(vertices, triangles, t, *x)[0] for t in range(len(triangles))]
        assert first == (int(np.argmin(own)), min(own))


def test_only_what_is_asked_for_is_found():
    vertices, triangles = sphere(0.1, 3)
    sets = np.where(vertices[triangles].mean(axis=1)[:, 0] > 0, 1, 2)
    mesh, place = placed(vertices, triangles, sets)
    stack, bounds = np.empty(STACK, np.int64), np.empty(STACK)
    for asked in (1, 2, 3):
        t, square = closest(mesh, place, 0.2, 0.01, 0.02, asked, 5, stack, bounds)
        assert sets[t] & asked
        own = [
            on_triangle(vertices, triangles, t, 0.2, 0.01, 0.02)[0]
            for t in np.flatnonzero(sets & asked)
        ]
        assert square == min(own)
    assert closest(mesh, place, 0.2, 0.0, 0.0, 4, -1, stack, bounds)[0] == -1


@kernel
def gaps(mesh, place, points, out):
    """Triangle, smooth distance and normal, flat distance and normal of points (n, 3)."""
    stack, bounds = np.empty(STACK, np.int64), np.empty(STACK)
    for i in range(len(points)):
        x0, x1, x2 = points[i, 0], points[i, 1], points[i, 2]
        t, square = closest(mesh, place, x0, x1, x2, -1, -1, stack, bounds)
        over, _, _, gap, n0, n1, n2 = smooth_gap(mesh, place, t, square, x0, x1, x2)
        out[i, 0], out[i, 1], out[i, 2], out[i, 3], out[i, 4] = over, gap, n0, n1, n2
        _, _, gap, n0, n1, n2 = flat_gap(mesh, place, t, x0, x1, x2)
        out[i, 5], out[i, 6], out[i, 7], out[i, 8] = gap, n0, n1, n2


def smooth_and_flat(vertices, triangles, points):
    out = np.empty((len(points), 9))
    gaps(*placed(vertices, triangles), points, out)
    assert (out[:, 0] >= 0).all()
    return out[:, 1], out[:, 2:5], out[:, 5], out[:, 6:]


def test_a_sphere_of_triangles_is_a_sphere():
    """To roundoff, however coarse: 128 triangles with a sagitta of 6 mm."""
    vertices, triangles = sphere(0.1, 2)
    rng = np.random.default_rng(3)
    n = rng.standard_normal((500, 3))
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    height = rng.uniform(-2e-3, 5e-3, 500)
    gap, normal, flat, _ = smooth_and_flat(vertices, triangles, (0.1 + height)[:, None] * n)
    assert np.abs(gap - height).max() < 1e-14 and np.abs(normal - n).max() < 1e-13
    assert 5e-3 < (flat - height).max() < 7e-3


def test_order_of_distance_and_normal_on_an_ellipsoid():
    """Halved triangles: distance of third order, normals of second; flat ones one less."""
    radii = np.array([0.1, 0.06, 0.08])
    x = np.random.default_rng(4).standard_normal((2000, 3))
    foot, n, _ = closest_points(x * radii / np.linalg.norm(x, axis=1, keepdims=True), radii)
    errors = []
    for divisions in (3, 4, 5):
        vertices, triangles = sphere(1.0, divisions)
        found = smooth_and_flat(vertices * radii, triangles, foot + 3e-4 * n)
        gap, normal, flat, direct = (
            found[0] - 3e-4, found[1] - n, found[2] - 3e-4, found[3] - n,
        )  # fmt: skip
        errors.append([np.sqrt(np.mean(e**2)) for e in (gap, normal, flat, direct)])
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert (orders > [2.7, 1.8, 1.8, 0.9]).all()
    assert errors[0][0] < 0.03 * errors[0][2]


def test_smooth_distance_and_normal_go_on_over_edges_and_corners():
    """Along lines across a wavy body they never jump: twice as many points, half the steps."""
    vertices, triangles = wavy(4)
    rng = np.random.default_rng(5)
    ends = vertices[triangles[rng.integers(len(triangles), size=8)]].mean(axis=1) * 1.002
    steps = []
    for count in (4000, 8000):
        part = np.linspace(0, 0.02, count)[:, None]
        greatest = []
        for a in ends:
            along = np.cross(a, [0.3, -0.5, 0.8])
            line = a + part * along / np.linalg.norm(along)
            near = np.abs(distances(*placed(vertices, triangles), line)[0]) < 3e-3
            gap, normal, _, _ = smooth_and_flat(vertices, triangles, line[near])
            joined = np.diff(np.flatnonzero(near)) == 1
            greatest.append(
                [np.abs(np.diff(gap))[joined].max(), np.abs(np.diff(normal, axis=0))[joined].max()]
            )
        steps.append(np.max(greatest, axis=0))
    assert (steps[1] < 0.6 * steps[0]).all()


@pytest.mark.parametrize("divisions", [1, 2])
def test_far_from_coarse_triangles_the_smooth_surface_is_found_on_the_right_side(divisions):
    """As far as edges are long, where the cubic of a triangle has several roots."""
    vertices, triangles = wavy(divisions)
    mesh, place = placed(vertices, triangles)
    rng = np.random.default_rng(1)
    count = 4000
    corners = vertices[triangles[rng.integers(len(triangles), size=count)]]
    n = rng.standard_normal((count, 3))
    n *= rng.uniform(0.0, 0.1, (count, 1)) / np.linalg.norm(n, axis=1, keepdims=True)
    points = np.einsum("na,nac->nc", rng.dirichlet(np.ones(3), count), corners) + n
    wanted, found = distances(mesh, place, points)[0], np.empty((count, 9))
    gaps(mesh, place, points, found)
    most = most_raised(mesh, place)
    known = found[:, 0] >= 0
    assert known.mean() > 0.97
    far = known & (np.abs(wanted) > most)
    assert far.sum() > 1000 and (found[far, 1] * wanted[far] > 0.0).all()


def test_normal_of_a_vertex_is_found_once():
    vertices, triangles = sphere(0.1, 2)
    mesh, place = placed(vertices, triangles)
    know_normal(mesh, place, 7)
    assert np.flatnonzero(place.known).tolist() == [7]
    assert place.normals[7] == pytest.approx(vertices[7] / 0.1, abs=1e-14)
    refit(mesh, place)
    assert not place.known.any()


def test_rings_go_around_vertices_also_where_two_surfaces_meet_in_one():
    """Counterclockwise: each triangle begins at the corner where the one before it ended."""
    points, triangles = sphere(0.1, 1)
    other = points * [1.0, 1.0, -1.0] + [0.0, 0.0, 2 * points[:, 2].max()]
    top = int(points[:, 2].argmax())
    number = np.arange(len(points)) + len(points)
    number[top] = top  # both balls share this vertex
    both = np.vstack([triangles, number[triangles[:, ::-1]]])
    mesh = mesh_of(both, np.vstack([points, other]))
    breaks = 0
    for i in range(len(points)):
        own = slice(mesh.ring_start[i], mesh.ring_start[i + 1])
        ring, ends = mesh.ring[own], mesh.ring_ends[own]
        assert sorted(ring) == sorted(np.flatnonzero((both == i).any(axis=1)))
        for t, (p, q) in zip(ring, ends, strict=True):
            assert any([i, p, q] == np.roll(both[t], k).tolist() for k in range(3))
        breaks += int((ends[1:, 0] != ends[:-1, 1]).sum())
    assert breaks == 1  # where the second ball begins
