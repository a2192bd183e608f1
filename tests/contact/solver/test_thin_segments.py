# SPDX-License-Identifier: LGPL-3.0-or-later
"""Which segments pass between nodes: spans of cells against searches, and the sentence."""

import numpy as np
import pytest
from scipy.optimize import minimize

from contact.body.segments import Body, Fixed, Segment
from contact.solver.thin_segments import STRETCH, refusal, spans, thin_segments


@pytest.mark.parametrize("corners", [3, 4])
def test_spans_are_smallest_circles(corners):
    """Against a search for the middle from which the farthest node is nearest."""
    rng = np.random.default_rng(1)
    points = rng.uniform(-1, 1, (corners * 30, 3))
    if corners == 4:  # convex and plane, as cells are nearly
        angles = np.sort(rng.uniform(0, 2 * np.pi, (30, 4)), axis=1).ravel()
        flat = np.stack([1.5 * np.cos(angles), np.sin(angles)], axis=1)
        points = flat @ rng.standard_normal((2, 3))
    cells = np.arange(len(points)).reshape(30, corners)
    for cell, span in zip(cells, spans(points, cells), strict=True):
        x = points[cell]
        frame = np.linalg.svd(x - x.mean(axis=0))[2][:2]
        flat = (x - x.mean(axis=0)) @ frame.T

        def farthest(middle, flat=flat):
            return np.linalg.norm(flat - middle, axis=1).max()

        best = minimize(farthest, (0, 0), method="Nelder-Mead", options={"xatol": 1e-9})
        assert span == pytest.approx(2 * best.fun, rel=1e-4)


def test_bound_is_that_of_a_ball_between_four_nodes():
    """A ball that touches all corners of a square cell, stretched by STRETCH, has the diagonal as
    its diameter; offsets on both sides count."""
    square = np.array([[0, 0, 0], [0.04, 0, 0], [0.04, 0.04, 0], [0, 0.04, 0]], float)
    span = spans(square, np.array([[0, 1, 2, 3]]))[0]
    assert span == pytest.approx(0.04 * np.sqrt(2))
    radius = 0.5 * STRETCH * span
    for more, thin in ((-1e-9, True), (1e-9, False)):
        body = Body([Segment("ball", [radius - 1e-3 + more] * 3, Fixed())])
        assert bool(thin_segments(body.shapes, span, 1e-3)) == thin
        assert bool(refusal(body.names, body.shapes, span, 0.04, 1e-3)) == thin
