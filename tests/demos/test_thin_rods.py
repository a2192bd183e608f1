# SPDX-License-Identifier: LGPL-3.0-or-later
"""Passages are told from what slides off: made-up motions of a row of nodes about an axis."""

import numpy as np
import pytest

from demos.studies.thin_rods.passages import Passages

TIMES = np.linspace(0.0, 1.0, 201)


def passages(motion, axis=lambda t: (np.zeros(3), np.array([0.0, 1.0, 0.0]))):
    """Passages of a row of nodes that bends like a roof over the axis and moves."""
    counted = Passages([np.arange(20)], axis)
    s = np.linspace(-0.24, 0.22, 20)
    roof = np.stack([s, 0 * s, 0.02 - np.abs(s)], axis=1)
    for t in TIMES:
        counted.look(motion(roof, t), t)
    return counted.passed[0]


@pytest.mark.parametrize("sideways", [-1.0, 0.3, 1.0])
def test_what_slides_off_passes_nothing(sideways):
    """Along its own roof shape until it is off at one end, then away below the rod."""

    def slide(roof, t):
        s = np.linspace(-0.24, 0.22, 20) + sideways * t
        x = np.stack([s, 0 * s, 0.02 - np.abs(s)], axis=1)
        return x - [0, 0, 0.5 * max(0.0, t - 0.5)] if abs(sideways) == 1.0 else x

    assert passages(slide) == 0


@pytest.mark.parametrize("speed", [0.1, 0.5, 2.0])
def test_what_falls_through_is_a_passage(speed):
    assert passages(lambda roof, t: roof - [0, 0, speed * t]) == 1


def test_a_rod_that_swings_through():
    """The axis moves up through a row at rest, or past its end."""
    for start, passed in ((0.0, 1), (0.3, 0)):

        def axis(t, start=start):
            return np.array([start, 0.0, -0.5 + t]), np.array([0.0, 1.0, 0.0])

        assert passages(lambda roof, t: roof, axis) == passed


def test_all_the_way_around_and_back():
    """A row wound around the axis and unwound again by its end."""

    def wind(roof, t):
        angle = np.linspace(0.0, 1.0, 20) * 6 * np.pi * np.sin(np.pi * t)
        return np.stack([0.1 * np.cos(angle), 0 * angle, 0.1 * np.sin(angle)], axis=1)

    assert passages(wind) == 0
