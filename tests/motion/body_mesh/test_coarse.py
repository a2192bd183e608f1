# SPDX-License-Identifier: LGPL-3.0-or-later
"""Fewer triangles on feet and upper end: the surface stays closed, and what garments meet stays."""

import warnings

import numpy as np
import pytest

from contact.geometry.triangle_mesh.closed import closed_surface, volume
from contact.geometry.triangle_mesh.sphere import sphere
from shellform.motion.body_mesh.coarse import BELOW_ANKLES, coarse_ends, coarsened
from shellform.motion.body_mesh.girths import girths, levels
from shellform.motion.body_mesh.lower_body import lower_body
from shellform.motion.body_mesh.surface import BodySurface
from tests.motion.body_mesh.manikin import ANKLE, manikin


def told(surface):
    """What is told of a closed surface; others are refused."""
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        closed_surface(surface.points, surface.triangles, "body")
    return [str(warning.message).split(":")[1] for warning in found]


def test_half_a_sphere():
    """Short edges go in the half that is named, which stays round; the other is as it was."""
    points, triangles = sphere(0.1, 4)
    fine = BodySurface(points, triangles, {}, 1.75, "ball")
    half = points[:, 2] < 0.0
    coarse = coarsened(fine, half, 0.02)
    assert told(coarse) == []
    assert (coarse.points[:, 2] < 0).sum() < 0.5 * half.sum()
    kept = {tuple(p) for p in coarse.points}
    assert all(tuple(p) in kept for p in points[~half])
    radii = np.linalg.norm(coarse.points, axis=1)
    assert radii.min() > 0.09 and radii.max() < 0.1 + 1e-12
    whole = volume(points, triangles)
    assert volume(coarse.points, coarse.triangles) == pytest.approx(whole, rel=0.04)


def test_ends_of_a_body():
    body = lower_body(manikin())
    coarse = coarse_ends(body)
    assert len(told(coarse)) == len(told(body))  # the thighs of the manikin touch
    assert len(coarse.triangles) < len(body.triangles)
    at = levels(body)
    assert girths(coarse, at) == pytest.approx(girths(body, at), rel=1e-12)
    limit = ANKLE - BELOW_ANKLES
    between = (body.points[:, 2] > limit) & (body.points[:, 2] < body.middle[2] + 0.26)
    kept = {tuple(p) for p in coarse.points}
    assert all(tuple(p) in kept for p in body.points[between])
