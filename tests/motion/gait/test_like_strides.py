# SPDX-License-Identifier: LGPL-3.0-or-later
"""Level strides are alike; one over an obstacle is not, nor the first one from standing."""

import numpy as np
import pytest

from shellform.fem.director import rotation_matrix
from shellform.motion.gait.like_strides import alike, postures
from shellform.motion.gait.strides import strides
from shellform.motion.gait.synthetic_walk import synthetic_walk
from shellform.motion.recording import Recording

pytestmark = pytest.mark.serial


def test_level_walk():
    walk = synthetic_walk(strides=6, obstacle=0.0)
    found = strides(walk)
    assert alike(walk, found["right"]) == [1, 2, 3, 4]  # the first one begins near standing
    assert alike(walk, found["left"]) == [0, 1, 2, 3, 4]


@pytest.mark.parametrize("height", [0.1, 0.5])
def test_obstacle(height):
    """Of three left strides the middle one goes over it; all right ones differ."""
    walk = synthetic_walk(strides=4, obstacle=height)
    found = strides(walk)
    assert alike(walk, found["left"]) == [0, 2] and alike(walk, found["right"]) == []


def test_nothing_to_compare():
    walk = synthetic_walk(strides=2, obstacle=0.0)
    assert alike(walk, np.zeros((0, 2))) == [] and alike(walk, np.array([[1.2, 2.3]])) == []


def test_place_and_heading_do_not_count():
    walk = synthetic_walk(strides=2, obstacle=0.0)
    turn = rotation_matrix([0.0, 0.0, 2.0])
    points = {name: track @ turn.T + [3.0, -1.0, 0.0] for name, track in walk.points.items()}
    assert postures(Recording(walk.times, points)) == pytest.approx(postures(walk), abs=1e-12)
