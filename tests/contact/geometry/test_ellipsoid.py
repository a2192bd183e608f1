# SPDX-License-Identifier: LGPL-3.0-or-later
"""Closest points on ellipsoids against Eq. 15, its gradient and dense samples of the surface."""

import numpy as np
import pytest

from contact.geometry.ellipsoid import closest_point, closest_points, level


def shapes(aspect):
    return aspect * np.array([[1, 0.5, 1 / aspect], [1 / aspect, 1, 1], [0.3, 1 / aspect, 1]])


def scattered(radii, count=2000, seed=0):
    """Points from 1e-15 to 100 radii off the surface, deep inside, near and in symmetry planes."""
    rng = np.random.default_rng(seed)
    d = rng.standard_normal((count, 3))
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    off = 10.0 ** rng.uniform(-15, 2, count)
    inside = np.arange(count) % 2 == 0
    points = radii * d * np.where(inside, 1 - np.minimum(off, 1), 1 + off)[:, None]
    points[::7] *= rng.integers(0, 2, points[::7].shape)
    points[::5] *= 10.0 ** rng.uniform(-20, 0, points[::5].shape)
    return points


def gradient(x, radii):
    g = x / radii**2
    return g / np.linalg.norm(g, axis=1, keepdims=True)


@pytest.mark.parametrize("aspect", [1, 1 + 1e-12, 1 + 1e-7, 3, 10, 100, 1e4])
def test_foot_lies_on_the_surface_below_the_point(aspect):
    for radii in shapes(aspect):
        y = scattered(radii)
        x, n, d = closest_points(y, radii)
        bar = 1e-10 if aspect <= 100 else 1e-8
        assert max(abs(level(a, radii)) for a in x) < bar
        assert np.abs(n - gradient(x, radii)).max() < 1e-14
        # tangency: the whole way from the foot to the point is along the normal
        size = np.maximum(np.linalg.norm(y, axis=1), radii.max())[:, None]
        assert np.abs((y - x - d[:, None] * n) / size).max() < 1e-14
        inside = np.sum((y / radii) ** 2, axis=1) - 1
        clear = np.abs(inside) > 1e-13
        assert np.array_equal(np.sign(d[clear]), np.sign(inside[clear]))


@pytest.mark.parametrize("radii", [(1, 1, 1), (3, 1, 1), (1, 2, 1.5), (10, 5, 1), (0.05, 2, 2)])
def test_no_sampled_point_is_closer(radii):
    radii = np.array(radii, float)
    rng = np.random.default_rng(1)
    d = rng.standard_normal((200_000, 3))
    surface = radii * d / np.linalg.norm(d, axis=1, keepdims=True)
    y = scattered(radii, 60, seed=2)
    y = np.vstack([y, np.diag(0.3 * radii), np.diag(-2 * radii), np.zeros(3)])
    x, _, distance = closest_points(y, radii)
    for point, foot, signed in zip(y, x, distance, strict=True):
        sampled = np.linalg.norm(surface - point, axis=1).min()
        assert np.linalg.norm(point - foot) <= sampled + 1e-12 * radii.max()
        assert abs(abs(signed) - np.linalg.norm(point - foot)) < 1e-13 * (1 + abs(signed))


def test_sphere_is_exact():
    rng = np.random.default_rng(3)
    y = rng.standard_normal((500, 3)) * 10.0 ** rng.uniform(-6, 3, (500, 1))
    size = np.linalg.norm(y, axis=1)
    x, n, d = closest_points(y, np.full(3, 0.7))
    assert np.abs(n - y / size[:, None]).max() < 1e-15
    assert np.abs(x - 0.7 * y / size[:, None]).max() < 1e-15
    assert np.abs((d - (size - 0.7)) / (size + 0.7)).max() < 1e-15


def test_on_an_axis_the_foot_is_the_pole_or_the_known_pair():
    """On the long axis the foot is the pole only beyond the centre of curvature a - c^2/a."""
    a, c = 2.0, 0.5
    radii = np.array([a, 1.0, c])
    centre_of_curvature = a - c**2 / a
    outer, inner = centre_of_curvature + 1e-9, 0.6 * centre_of_curvature
    x, _n, d = closest_points([[outer, 0, 0], [inner, 0, 0], [-3, 0, 0]], radii)
    assert np.abs(x[0] - [a, 0, 0]).max() < 1e-15 and d[0] == pytest.approx(outer - a, rel=1e-13)
    x0 = inner * a**2 / (a**2 - c**2)
    z0 = c * np.sqrt(1 - (x0 / a) ** 2)
    assert np.abs(x[1] - [x0, 0, z0]).max() < 1e-15
    assert d[1] == pytest.approx(-np.hypot(x0 - inner, z0), rel=1e-14)
    assert np.abs(x[2] - [-a, 0, 0]).max() < 1e-15 and d[2] == pytest.approx(1, rel=1e-15)


@pytest.mark.parametrize("shortest", [0, 1, 2])
def test_centre_goes_to_the_shortest_axis(shortest):
    radii = np.full(3, 3.0)
    radii[shortest] = 0.2
    foot, normal = np.empty(3), np.empty(3)
    assert closest_point(np.zeros(3), radii, foot, normal) == -0.2
    assert np.array_equal(foot, 0.2 * np.eye(3)[shortest])
    assert np.array_equal(normal, np.eye(3)[shortest])


def test_symmetry_plane_is_the_limit_from_its_positive_side():
    radii = np.array([1.0, 0.6, 0.1])
    plane = np.array([0.3, -0.2, 0.0])
    limit = closest_points(plane, radii)[0]
    for height in (1e-4, 1e-8, 1e-100, 1e-308):
        above = closest_points(plane + [0, 0, height], radii)[0]
        below = closest_points(plane - [0, 0, height], radii)[0]
        assert np.abs(above - limit).max() <= 10 * height + 1e-15
        assert np.abs(below * [1, 1, -1] - above).max() < 1e-15
    assert limit[0, 2] > 0.01


@pytest.mark.parametrize("factor", [1e-3, 1e3, 2.0**-20, 1e-30])
def test_scale_invariance(factor):
    radii = np.array([0.3, 0.1, 0.2])
    y = np.random.default_rng(4).standard_normal((500, 3)) * 0.2
    x, n, d = closest_points(y, radii)
    scaled = closest_points(factor * y, factor * radii)
    bar = 0 if np.log2(factor).is_integer() else 2e-15
    assert np.abs(scaled[0] / factor - x).max() <= bar
    assert np.abs(scaled[1] - n).max() <= bar
    assert np.abs(scaled[2] / factor - d).max() <= bar


def test_centre_and_axes():
    """The same scene moved and turned gives the same feet moved and turned."""
    rng = np.random.default_rng(5)
    axes = np.linalg.qr(rng.standard_normal((3, 3)))[0]
    centre, radii = np.array([0.4, -1.0, 2.0]), np.array([0.3, 0.1, 0.2])
    y = rng.standard_normal((100, 3)) * 0.3
    x, n, d = closest_points(y, radii)
    moved = closest_points(y @ axes + centre, radii, centre, axes)
    assert np.abs(moved[0] - (x @ axes + centre)).max() < 1e-15 * 10
    assert np.abs(moved[1] - n @ axes).max() < 1e-14
    assert np.abs(moved[2] - d).max() < 1e-15
