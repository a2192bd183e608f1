# SPDX-License-Identifier: LGPL-3.0-or-later
"""Thighs and shanks keep their volumes as knees and hips bend; standing, nothing bulges."""

import importlib.util

import numpy as np
import pytest

from contact.body.segments import Pose
from contact.body.skinned_surface import Bend, SkinnedSurface
from shellform.motion.anthropometry import ellipsoids
from shellform.motion.body_mesh.bulging import (
    AMOUNTS,
    HIP,
    KNEE,
    PARTS,
    amount_of,
    bent,
    bulge_of,
    directions_of,
    field_names,
)
from shellform.motion.body_mesh.fitting import asked_girths
from shellform.motion.body_mesh.rigging import weights_of
from shellform.motion.body_mesh.segment_volumes import SegmentVolumes
from shellform.motion.body_mesh.skin import skin_of
from shellform.motion.body_mesh.template import template
from shellform.motion.gait.synthetic_walk import synthetic_walk
from shellform.motion.proportions import STATURE
from shellform.motion.recording import SEGMENTS, SIDES
from shellform.motion.wearer import Wearer

from .manikin import manikin

ANGLES = {KNEE: np.arange(1.0, 136.0, 6.7), HIP: np.arange(-33.0, 106.0, 8.7)}


@pytest.fixture(scope="module")
def body():
    return manikin()


@pytest.fixture(scope="module")
def parts(body):
    """What binds the skin of the body to segments whose axes are the world's at binding."""
    marks, still = body.landmarks, np.zeros((len(SEGMENTS), 3))
    centres = still.copy()
    for k, segment in enumerate(SEGMENTS[1:], 1):
        side, part = segment.split("_")
        joint = {"thigh": "hip", "shank": "knee", "foot": "ankle"}[part]
        centres[k] = marks[f"{side}_{joint}"]
    bound = Pose(centres, np.repeat(np.eye(3)[None], len(SEGMENTS), axis=0), still, still)
    knees = [
        Bend(f"{s}_thigh", f"{s}_shank", *(marks[f"{s}_{j}"] for j in ("knee", "hip", "ankle")))
        for s in SIDES
    ]
    return body, weights_of(body), SEGMENTS, bound, knees


def lacks(parts, bulge, hinge):
    """Volumes (k, m) of segments at ANGLES of both legs, over those standing, less 1."""
    body, weights, names, bound, knees = parts

    def pose(t, out):
        return bent(body, names, bound, hinge, t, out)

    skin = SkinnedSurface(
        body.points, body.triangles, weights, names, pose, bound, knees, None, bulge
    )
    x = skin.positions(0.0, np.empty_like(body.points))
    assert np.abs(x - body.points).max() < 1e-14
    volumes = SegmentVolumes(skin, x.copy(), pose)
    rest = volumes(0.0, x)
    return np.array([volumes(t, skin.positions(t, x)) / rest - 1.0 for t in ANGLES[hinge]])


def test_volumes_stay_as_knees_and_hips_bend(parts):
    bulge = bulge_of(*parts)
    for hinge, part in ((KNEE, "shank"), (KNEE, "thigh"), (HIP, "thigh")):
        own = [SEGMENTS.index(f"{side}_{part}") for side in SIDES]
        kept, lost = (np.abs(lacks(parts, b, hinge)[:, own]).max() for b in (bulge, None))
        assert kept < 0.004 < 0.02 < lost


def test_flesh_moves_away_from_the_axis_of_a_limb_and_not_at_joints(parts):
    body, weights, names, _, _ = parts
    fields, directions = directions_of(body, weights, names)
    size = np.linalg.norm(directions, axis=1)
    assert ((size > 0.0) == (fields >= 0)).all() and size.max() <= 1.0
    for number, (side, part) in enumerate(field_names()):
        own = fields == number
        assert weights[own, names.index(f"{side}_{part}")].min() > 0.5
        top, bottom = (body.landmarks[f"{side}_{joint}"] for joint in PARTS[part][:2])
        arm = body.points[own] - top
        across = arm - np.outer(arm @ (bottom - top), bottom - top) / np.sum((bottom - top) ** 2)
        out = np.einsum("ij,ij->i", directions[own], across)
        assert out == pytest.approx(size[own] * np.linalg.norm(across, axis=1))
    for joint in ("hip", "knee", "ankle"):
        for side in SIDES:
            off = np.abs(body.points[:, 2] - body.landmarks[f"{side}_{joint}"][2])
            assert size[off < off.min() + 0.005].max() < 0.15


def test_what_cannot_be_given_back_is_bounded():
    """Flesh that does not answer, or far too little."""
    assert amount_of(np.zeros(4)) == 0.0 and amount_of(np.full(4, -1e-3)) == 0.0
    beta = np.array(AMOUNTS)
    assert amount_of(0.1 * beta - 3e-4) == pytest.approx(0.003)
    assert amount_of(0.1 * beta - 1e-2) == AMOUNTS[-1]
    assert amount_of(0.1 * beta + 1e-2) == AMOUNTS[0]


@pytest.mark.thorough
@pytest.mark.skipif(importlib.util.find_spec("anny") is None, reason="anny is not installed")
@pytest.mark.parametrize("sex", ["male", "female"])
def test_installed_body_over_an_obstacle(sex):
    """The bars of a skinned body: volumes 5 %, no triangle turned, rates to 1e-6."""
    from demos.studies.bodies.volumes import through  # needs the body's files

    walk = synthetic_walk(strides=3, obstacle=0.5, obstacle_stride=2)
    wearer = Wearer(walk, ellipsoids(walk.lengths()))
    skin = skin_of(wearer, template(sex), STATURE, asked_girths(STATURE))
    found = through(skin, wearer)
    assert found.bends.max() > 130.0
    assert np.abs(found.volumes - 1.0).max() < 0.05
    assert found.turned.max() == 0 and found.crossings.max() == 0
    x = np.empty((3, skin.vertex_count, 3))
    for t in np.linspace(0.3, 0.95, 9) * wearer.end:
        h = 1e-5
        skin.velocities(t, x[0])
        skin.positions(t + h, x[1])
        skin.positions(t - h, x[2])
        difference = (x[1] - x[2]) / (2 * h)
        assert np.abs(x[0] - difference).max() < 1e-6 * np.abs(x[0]).max()
