# SPDX-License-Identifier: LGPL-3.0-or-later
"""Closest points on a capsule against dense samples of its surface, and its sizes."""

import numpy as np
import pytest

from contact.geometry.capsule import Capsule
from contact.geometry.ellipsoid import Ellipsoid
from contact.geometry.shape import foot_and_normal, least_distance, set_shapes
from contact.solver.segment_motion import SEGMENT


def record(shape):
    segments = np.zeros(1, SEGMENT)
    set_shapes([shape], segments)
    return segments[0]


def sampled(shape, count=300_000, seed=0):
    """Points all over the surface: a sphere pulled apart, and the cylinder between."""
    rng = np.random.default_rng(seed)
    unit = rng.standard_normal((count, 3))
    unit /= np.linalg.norm(unit, axis=1, keepdims=True)
    ends = shape.radius * unit + np.sign(unit[:, :1]) * [0.5 * shape.length, 0, 0]
    angle, along = rng.uniform(0, 2 * np.pi, count), rng.uniform(-0.5, 0.5, count)
    middle = np.column_stack([np.cos(angle), np.sin(angle)]) * shape.radius
    return np.vstack([ends, np.column_stack([shape.length * along, middle])])


def around(shape, count, seed=1):
    rng = np.random.default_rng(seed)
    size = np.array(shape.half_extents)
    return rng.uniform(-2, 2, (count, 3)) * size


@pytest.mark.parametrize("shape", [Capsule(0.3, 0.05), Capsule(0.0, 0.1), Capsule(0.02, 0.2)])
def test_no_sampled_point_is_closer(shape):
    surface, segment = sampled(shape), record(shape)
    spacing = np.sqrt(4 * np.pi * shape.radius * (shape.length + shape.radius) / len(surface))
    for y in np.vstack([around(shape, 60), np.zeros(3), [0.5 * shape.length, 0, 0]]):
        distance, *rest = foot_and_normal(segment, *y)
        foot, normal = np.array(rest[:3]), np.array(rest[3:])
        nearest = np.linalg.norm(surface - y, axis=1).min()
        assert abs(distance) <= nearest + 1e-14 < abs(distance) + 8 * spacing
        assert np.abs(y - foot - distance * normal).max() < 1e-15
        assert np.linalg.norm(normal) == pytest.approx(1, abs=1e-15)
        axis = np.clip(foot[0], -0.5 * shape.length, 0.5 * shape.length)
        assert np.linalg.norm(foot - [axis, 0, 0]) == pytest.approx(shape.radius, rel=1e-14)
        inside = np.linalg.norm(y - [np.clip(y[0], -shape.length / 2, shape.length / 2), 0, 0])
        assert (distance < 0) == (inside < shape.radius)


@pytest.mark.parametrize("shape", [Capsule(0.3, 0.05), Ellipsoid((0.1, 0.05, 0.08))])
def test_bounds_hold(shape):
    """What the broad phase relies on: cheap distances, bounding sphere, inner sphere, curvature."""
    segment = record(shape)
    for y in around(shape, 500):
        distance, *rest = foot_and_normal(segment, *y)
        foot, normal = np.array(rest[:3]), np.array(rest[3:])
        if distance > 0:
            assert least_distance(segment, *y) <= distance * (1 + 1e-14)
            assert np.linalg.norm(y) - shape.bounding_radius <= distance * (1 + 1e-14)
        assert (np.abs(foot) <= np.array(shape.half_extents) * (1 + 1e-14)).all()
        assert np.linalg.norm(foot) >= shape.inner_radius * (1 - 1e-14)
        # a sphere of the smallest radius of curvature fits in wherever it touches
        ball = foot - shape.curvature_radius * normal
        assert foot_and_normal(segment, *ball)[0] <= -shape.curvature_radius * (1 - 1e-12)


def test_a_capsule_without_length_is_a_sphere():
    ball, segment = record(Ellipsoid((0.7, 0.7, 0.7))), record(Capsule(0.0, 0.7))
    for y in np.random.default_rng(2).standard_normal((200, 3)):
        expected = foot_and_normal(ball, *y)
        assert foot_and_normal(segment, *y) == pytest.approx(expected, abs=2e-15)


def test_wrong_sizes_are_refused():
    for length, radius, message in (
        (0.1, 0.0, "radius > 0"),
        (0.1, np.nan, "radius > 0"),
        (-0.1, 0.1, "length >= 0"),
        (np.inf, 0.1, "length >= 0"),
    ):
        with pytest.raises(ValueError, match=message):
            Capsule(length, radius)
    with pytest.raises(ValueError, match="no shape that contact knows: Ellipsoid, Capsule"):
        set_shapes(["cube"], np.zeros(1, SEGMENT))
