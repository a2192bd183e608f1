# SPDX-License-Identifier: LGPL-3.0-or-later
"""Series of arc length and turning angle: against circles."""

import numpy as np

from shellform.fem.arc import arc_lengths, turning


def arc(angle, radius=0.3):
    """Ends (1, 2, 3) of a circular arc and the directors there."""
    turns = np.array([0.0, angle])
    directors = np.stack([np.sin(turns), 0 * turns, np.cos(turns)], 1)
    return radius * directors[None], directors[None]


def test_length_of_a_circular_arc():
    """The error falls with the sixth power of the angle relative to the length; 0.1 % at 60 deg."""
    errors = []
    for angle in np.radians([60.0, 30.0]):
        errors.append(abs(arc_lengths(*arc(angle))[0] / (0.3 * angle) - 1))
    assert errors[0] < 1.1e-3 and errors[1] < errors[0] / 8


def test_turning_of_a_circular_arc():
    """dx . dd = l phi: here radius phi^2."""
    errors = []
    for angle in np.radians([60.0, 30.0]):
        X, D = arc(angle)
        dx, dd = X[0, 1] - X[0, 0], D[0, 1] - D[0, 0]
        errors.append(abs(turning(dx @ dd, dd @ dd) / (0.3 * angle**2) - 1))
    assert errors[0] < 1e-2 and errors[1] < errors[0] / 8
