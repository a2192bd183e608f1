# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pairs: closest points against minimisation, lists against all with all, crossings."""

import numpy as np
import pytest

from contact.self_contact.boxes import members_of
from contact.self_contact.broad_phase import list_pairs
from contact.self_contact.closest_points import closest, on_edges, on_triangle
from contact.self_contact.intersections import count_intersections
from tests.contact.self_contact.meshes_of_triangles import crossings, featured, sheet, together


def nearest(corners, point):
    """Least distance of a point to the hull of two or three corners, face by face."""
    best = np.inf
    k = len(corners)
    for bits in range(1, 2**k):
        face = corners[[i for i in range(k) if bits >> i & 1]]
        base = (face[1:] - face[0]).T
        w = np.linalg.lstsq(base, point - face[0], rcond=None)[0] if len(face) > 1 else np.zeros(0)
        if (w >= 0).all() and w.sum() <= 1:
            best = min(best, np.linalg.norm(face[0] + base @ w - point))
    return best


def test_point_and_triangle():
    rng = np.random.default_rng(0)
    for x in rng.normal(size=(300, 4, 3)):
        w = np.array(on_triangle(x, 0, 1, 2, 3))
        assert (w >= 0).all() and w.sum() == pytest.approx(1.0, abs=1e-12)
        assert np.linalg.norm(w @ x[1:] - x[0]) == pytest.approx(nearest(x[1:], x[0]), abs=1e-12)


def test_two_edges():
    """Against the closest of 201 points of one edge, which lies within a step of it."""
    rng = np.random.default_rng(1)
    for x in rng.normal(size=(100, 4, 3)):
        s, t = on_edges(x, 0, 1, 2, 3)
        d = np.linalg.norm((1 - s) * x[0] + s * x[1] - (1 - t) * x[2] - t * x[3])
        tried = [nearest(x[2:], (1 - a) * x[0] + a * x[1]) for a in np.linspace(0, 1, 201)]
        assert d <= min(tried) + 1e-12
        assert d >= min(tried) - np.linalg.norm(x[1] - x[0]) / 400


def pairs_of(points, f, reach, groups=1):
    """Keys and distances of the list of groups of triangles that are neighbours by number."""
    m = len(f.triangles)
    members = tuple(members_of(f, np.arange(m) * groups // m))
    keys, distance, of = np.empty(200_000, np.int64), np.empty(200_000), np.empty(200_000, np.int64)
    found = list_pairs(
        points, *f[:4], f.numbers, f.places, members, np.ones((groups, groups), bool), reach, keys,
        distance, of,
    )  # fmt: skip
    assert found <= len(keys)
    return keys[:found], distance[:found]


@pytest.mark.parametrize("groups", [1, 7])
def test_list_is_that_of_all_with_all(groups):
    points, cells = together(
        sheet(5, wave=0.1), sheet(4, height=0.05, turn=0.3), sheet(3, 0.2, 9.0)
    )
    f, reach = featured(points, cells), 0.12
    keys, _ = pairs_of(points, f, reach, groups)
    assert len(np.unique(keys)) == len(keys)
    m, e = len(f.triangles), len(f.edges)
    found, wanted = set(keys.tolist()), set()
    for p in range(len(points)):
        for t in range(m):
            if p not in f.triangles[t] and nearest(points[f.triangles[t]], points[p]) < reach:
                wanted.add(p * m + t)
    for i in range(e):
        for j in range(i + 1, e):
            if not set(f.edges[i]) & set(f.edges[j]):
                s, t = on_edges(points, *f.edges[i], *f.edges[j])
                a, b, c, d = points[f.edges[i]].tolist() + points[f.edges[j]].tolist()
                way = (1 - s) * np.array(a) + s * np.array(b) - (1 - t) * np.array(c)
                if np.linalg.norm(way - t * np.array(d)) < reach:
                    wanted.add(len(points) * m + i * e + j)
    assert found == wanted and len(wanted) > 500


def test_owners_keep_the_least_distance():
    """Pairs that keep a distance are at the least distance of the two sheets."""
    rng = np.random.default_rng(2)
    for turn in rng.uniform(0, 3, 20):
        points, cells = together(sheet(3, wave=0.1), sheet(4, 0.7, 0.2, turn, 0.05))
        f = featured(points, cells)
        keys, distance = pairs_of(points, f, 0.3)
        nodes, w, r = np.empty(4, np.int64), np.empty(4), np.empty(3)
        corners, kept = len(points) * len(f.triangles), []
        for key in keys:
            d, keeps = closest(points, key, corners, *f[:4], f.places, nodes, w, r)
            assert abs(w.sum()) < 1e-12
            if keeps and f.piece[nodes[0]] != f.piece[nodes[3]]:
                kept.append(d)
        both = f.piece[f.triangles[:, 0]]
        apart = [d for key, d in zip(keys, distance) if _pieces(key, corners, f, both)]
        assert min(kept) == pytest.approx(min(apart), abs=1e-12)


def _pieces(key, corners, f, piece):
    if key < corners:
        m = len(f.triangles)
        return f.piece[key // m] != piece[key % m]
    one, other = divmod(key - corners, len(f.edges))
    return f.piece[f.edges[one, 0]] != f.piece[f.edges[other, 0]]


@pytest.mark.parametrize("height", [0.0, 0.03, 0.4])
def test_crossings(height):
    points, cells = together(sheet(6, wave=0.1), sheet(5, 0.9, height, 0.4, -0.1))
    f = featured(points, cells)
    found = count_intersections(points, *f[:4])
    assert found == crossings(points, cells)
    assert (found > 0) == (height < 0.2)
