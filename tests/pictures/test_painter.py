# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pixels painted: areas, who hides whom, and scale."""

import numpy as np
import pytest

from shellform.pictures.painter import bars, dashes, fill_polygons, mean_of_parts, painted

WHITE, RED = 255, (200, 10, 20)


def filled(polygon, size=300):
    image = np.full((size, size, 3), WHITE, np.uint8)
    fill_polygons(np.array([polygon], float), np.array([RED], np.uint8), image)
    return (image == RED).all(axis=2)


@pytest.mark.parametrize(
    ("polygon", "area"),
    [
        ([[10, 20], [210, 40], [250, 230], [60, 180]], None),  # any quad: by its shoelace
        ([[10, 10], [110, 10], [60, 110], [60, 110]], 5000.0),  # a triangle, its corner twice
        ([[0, 0], [200, 200], [200, 0], [0, 200]], 20000.0),  # folded: two triangles
        ([[-500, 50], [800, 50], [800, 150], [-500, 150]], 30000.0),  # beyond the picture
        ([[20, 20], [20, 20], [20, 20], [20, 20]], 0.0),
    ],
)
def test_a_polygon_fills_its_area(polygon, area):
    p = np.array(polygon, float)
    if area is None:
        area = 0.5 * abs(np.sum(p[:, 0] * np.roll(p[:, 1], -1) - p[:, 1] * np.roll(p[:, 0], -1)))
    assert filled(p).sum() == pytest.approx(area, abs=500)  # by its border of some hundred pixels


def test_neighbours_leave_no_seam_and_do_not_overlap():
    """Two quads on both sides of a slanted line hold every pixel of their union once."""
    left = filled([[20, 20], [131.7, 20], [93.3, 280], [20, 280]])
    right = filled([[131.7, 20], [250, 20], [250, 280], [93.3, 280]])
    both = filled([[20, 20], [250, 20], [250, 280], [20, 280]])
    assert not (left & right).any() and np.array_equal(left | right, both)


def test_mean_of_parts():
    image = np.random.default_rng(1).integers(0, 256, (12, 15, 3)).astype(np.uint8)
    out = np.empty((4, 5, 3), np.uint8)
    mean_of_parts(image, 3, out)
    mean = image.reshape(4, 3, 5, 3, 3).mean(axis=(1, 3))
    assert np.abs(out - mean).max() <= 0.5


def test_bars_and_dashes_have_their_lengths():
    lines = np.array([[[0, 0], [30, 40]], [[5, 5], [5, 25]]], float)
    for (a, b, c, _), length in zip(bars(lines, 3.0), (50, 20), strict=True):
        assert np.linalg.norm(b - a) == pytest.approx(length)
        assert np.linalg.norm(c - b) == pytest.approx(3.0)
    cut = dashes(np.array([[0, 0], [100, 0]], float), 1.0)
    assert np.linalg.norm(cut[0, 1] - cut[0, 0]) == pytest.approx(3.7)
    assert cut[1, 0, 0] == pytest.approx(5.3) and cut[..., 0].max() <= 100


def square(side, height):
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * 0.5 * side
    return np.column_stack([corners, np.full(4, height)])[None]


def test_the_nearer_surface_hides_the_other():
    """Seen from above a small square over a large one, then the other way round; to scale."""
    corners = np.concatenate([*square(2.0, 0.0), *square(2.0, 1.0)])
    for height, seen in ((1.0, True), (-1.0, False)):
        surfaces = [
            (square(2.0, 0.0), None, "#ff0000", "#ff0000", 0.0),
            (square(1.0, height), None, "#0000ff", "#0000ff", 0.0),
        ]
        image = painted(surfaces, [], corners, (1.0, 1.0), 200, -90, 90, margin=0.0)
        blue = (image[..., 2] > image[..., 0]).sum()
        red = (image[..., 0] > image[..., 2]).sum()
        assert (blue > 0) == seen
        if seen:
            assert blue / (blue + red) == pytest.approx(0.25, abs=0.01)
        assert (blue + red) == pytest.approx((200 * 0.92) ** 2, rel=0.02)
