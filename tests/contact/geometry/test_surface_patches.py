# SPDX-License-Identifier: LGPL-3.0-or-later
"""Patches of an ellipsoid's surface: their areas, and values between them."""

import numpy as np
import pytest
from scipy.special import elliprg

from contact.geometry.surface_patches import Patches, areas_between

SHAPES = ((0.2, 0.06, 0.05), (0.1, 0.12, 0.16), (0.05, 0.05, 0.05), (1.0, 0.05, 0.05))


def outward(patches):
    """Unit normals (P, 3) at the patches' centres, in the axes of the ellipsoids."""
    n = patches.centres / patches.radii[patches.owner] ** 2
    return n / np.linalg.norm(n, axis=1, keepdims=True)


def test_areas_are_those_of_the_ellipsoid():
    """Total by Carlson's 4 pi R_G(a2 b2, a2 c2, b2 c2), patches nearly equal and of their size."""
    size = 0.02
    patches = Patches(SHAPES, size)
    for b, (r1, r2, r3) in enumerate(SHAPES):
        own = patches.areas[patches.owner == b]
        exact = 4 * np.pi * elliprg((r1 * r2) ** 2, (r1 * r3) ** 2, (r2 * r3) ** 2)
        assert own.sum() == pytest.approx(exact, rel=1e-4)
        assert len(own) == patches.rows[b] * patches.columns[b]
        assert np.abs(own / own.mean() - 1).max() < 0.15
        assert own.mean() == pytest.approx(size**2, rel=0.15)
    # a sphere's zones are as large as their heights, Archimedes
    zones = areas_between((0.3, 0.3, 0.3), (-1, -0.5, 0.7, 1), (-np.pi, 0.0, np.pi))
    assert zones == pytest.approx(0.09 * np.pi * np.array([[0.5] * 2, [1.2] * 2, [0.3] * 2]))


def test_closed_surface():
    """Equal pressure all around pushes nowhere, and does p V through its centres; 1 %."""
    patches = Patches(SHAPES, 0.01)
    n = outward(patches)
    for b, radii in enumerate(SHAPES):
        own = patches.owner == b
        push = patches.areas[own] @ n[own]
        assert np.abs(push).max() < 1e-5 * patches.areas[own].sum()
        volume = np.sum(patches.areas[own] * np.sum(n[own] * patches.centres[own], axis=1)) / 3
        assert volume == pytest.approx(4 / 3 * np.pi * np.prod(radii), rel=1e-2)


def test_values_at_places():
    """A patch's own number at its centre, a height across the rows, ones everywhere."""
    patches = Patches(SHAPES, 0.02)
    rng = np.random.default_rng(4)
    for b, radii in enumerate(SHAPES):
        own = np.flatnonzero(patches.owner == b)
        numbers = np.arange(len(patches.areas), dtype=float)
        assert patches.values(b, patches.centres[own], numbers) == pytest.approx(own, abs=1e-6)
        unit = rng.standard_normal((200, 3))
        places = radii * unit / np.linalg.norm(unit, axis=1, keepdims=True)
        assert patches.values(b, places, np.ones(len(numbers))) == pytest.approx(1, abs=1e-12)
        middle = np.abs(places[:, 0]) < 0.7 * radii[0]
        heights = patches.values(b, places[middle], patches.centres[:, 0])
        step = np.diff(np.unique(np.round(patches.centres[own, 0], 9))).max()
        assert np.abs(heights - places[middle, 0]).max() < 0.1 * step


def test_even_pressure_gives_an_even_map():
    """On a lattice of points at odds with the patches, unevenness falls as its spacing squared."""
    patches, uneven = Patches([(0.05, 0.05, 0.05)], 0.01), []
    for times in (2.3, 4.6, 9.2):
        # equal parts of a sphere, by Archimedes
        rows, columns = round(times * patches.rows[0]), round(times * patches.columns[0])
        s = -1 + 2 * (np.arange(rows) + 0.5)[:, None] / rows
        phi = 2 * np.pi * (np.arange(columns) + 0.3) / columns
        c = np.sqrt(1 - s * s)
        points = 0.05 * np.stack([s + 0 * phi, c * np.cos(phi), c * np.sin(phi)], axis=-1)
        given = patches.values(0, points.reshape(-1, 3), np.eye(len(patches.areas))).sum(axis=0)
        assert given.sum() == pytest.approx(rows * columns, rel=1e-12)
        uneven.append(np.abs(given / given.sum() * patches.areas.sum() / patches.areas - 1).max())
    assert uneven[0] < 0.08
    assert np.log2(uneven[0] / uneven[2]) > 2 * 1.7
