# SPDX-License-Identifier: LGPL-3.0-or-later
"""A body of triangles: cut, measured, brought to the wearer's joints and girths, rigged."""

from dataclasses import replace

import numpy as np
import pytest

from contact.geometry.triangle_mesh.closed import closed_surface, volume
from shellform.motion.body_mesh import rigging
from shellform.motion.body_mesh.between_legs import SKIN, between_legs
from shellform.motion.body_mesh.fitting import asked_girths, fitted
from shellform.motion.body_mesh.girths import NAMES, girth, girths, levels
from shellform.motion.body_mesh.lower_body import ABOVE_HIPS, DOME, lower_body
from shellform.motion.body_mesh.placing import placed
from shellform.motion.body_mesh.rigging import along_skin, ramp, weights_of
from shellform.motion.gait.standing_pose import standing
from shellform.motion.proportions import LENGTHS, STATURE
from shellform.motion.recording import SEGMENTS, SIDES

from .manikin import HIP, KNEE, manikin


def standing_points(stature, heading=(1.0, 0.0, 0.0)):
    scale = stature / STATURE
    long = {"pelvis": LENGTHS["pelvis"] * scale}
    for side in SIDES:
        long |= {f"{side}_{part}": LENGTHS[part] * scale for part in ("thigh", "shank", "foot")}
    return standing(long, heading, at=(0.4, -0.2))


def test_manikin_is_a_body():
    body = manikin()
    closed_surface(body.points, body.triangles, "manikin")
    assert volume(body.points, body.triangles) > 0.05


def test_cut_body_is_closed_and_level_on_top():
    body = lower_body(manikin())
    closed_surface(body.points, body.triangles, "lower body")
    assert HIP + ABOVE_HIPS < body.points[:, 2].max() <= HIP + ABOVE_HIPS + DOME
    rim = np.abs(body.points[:, 2] - 1.2) < 1e-9
    assert rim.sum() == 24  # one level ring of the trunk, under the dome


def test_girth_is_the_perimeter_of_the_slice():
    """Legs are rings of 16 points: a polygon, of two slopes."""
    body = manikin()
    corners = np.sqrt(2 - 2 * np.cos(2 * np.pi / 16)) * 16
    assert girth(body, "calf", 0.42) == pytest.approx(0.06 * corners, rel=1e-3)
    # a hull of both legs together would be 1.2 m
    assert 0.3 < girth(body, "knee", 0.54) < 0.45
    with pytest.raises(ValueError, match=r"manikin has no waist at a height of 3.000 m"):
        girth(body, "waist", 3.0)


@pytest.mark.parametrize("heading", [(1.0, 0.0, 0.0), (-0.6, 0.8, 0.0)])
def test_placed_on_the_joints_of_the_wearer(heading):
    points, body = standing_points(1.80, heading), manikin()
    on = placed(lower_body(body), points, 1.80)
    closed_surface(on.points, on.triangles, "placed")
    ahead, left = np.array(heading), np.cross([0, 0, 1], heading)
    for side, sign in (("right", -1), ("left", 1)):
        assert np.abs(on.landmarks[f"{side}_knee"] - points[f"{side}_shank"][0]).max() < 1e-12
        # the middle of a slice of the leg goes where the joint goes
        z = on.landmarks[f"{side}_knee"][2]
        leg = on.points[sign * ((on.points - on.middle) @ left) > 0]
        near = leg[np.abs(leg[:, 2] - z) < 0.012]
        for axis in (ahead, left):
            middle = 0.5 * ((near @ axis).min() + (near @ axis).max())
            assert abs(middle - on.landmarks[f"{side}_knee"] @ axis) < 0.012
    assert on.points[:, 2].min() == pytest.approx(0.0, abs=1e-9)  # soles on the floor


@pytest.mark.parametrize("size", [0.88, 1.0, 1.12])
def test_girths_are_those_asked_for(size):
    asked = {name: size * value for name, value in asked_girths(STATURE).items()}
    standing_body = placed(lower_body(manikin()), standing_points(STATURE), STATURE)
    smooth = between_legs(standing_body, SKIN)
    at = levels(standing_body)
    body, told = fitted(standing_body, asked, smooth)
    closed_surface(body.points, body.triangles, "fitted")
    drawn = replace(body, points=smooth @ body.points)
    have = girths(drawn, at)
    assert have == pytest.approx(told, rel=1e-12)
    assert have == pytest.approx(asked, rel=0.01)
    assert set(have) == set(NAMES)


def test_girths_that_no_body_has_are_refused():
    asked = asked_girths(STATURE) | {"calf": 1.3}
    standing_body = placed(lower_body(manikin()), standing_points(STATURE), STATURE)
    with pytest.raises(ValueError, match=r"cannot be brought to a calf of 1.300 m"):
        fitted(standing_body, asked, between_legs(standing_body, SKIN))
    with pytest.raises(ValueError, match=r"girth 'knee' of 0.7 m is not between"):
        asked_girths(STATURE, own={"knee": 0.7})


def test_weights():
    body = lower_body(manikin())
    weights = weights_of(body)
    assert weights.min() >= 0 and np.abs(weights.sum(axis=1) - 1).max() < 1e-12
    z, y = body.points[:, 2], body.points[:, 1]

    def of(segment, where):
        return weights[where, SEGMENTS.index(segment)]

    assert (of("pelvis", z > HIP + 0.26) > 0.94).all()
    assert (of("right_thigh", (z > 0.64) & (z < 0.66) & (y < 0)) > 0.94).all()
    assert (of("left_shank", (z > 0.26) & (z < 0.3) & (y > 0)) > 0.97).all()
    assert (of("left_foot", (z < 0.03) & (y > 0)) > 0.99).all()
    assert np.abs(of("right_shank", np.abs(z - KNEE) < 1e-3) - 0.5).max(initial=0) < 0.1
    assert (of("left_thigh", y < -1e-9) == 0).all()  # no leg moves the other


def test_turning_by_the_angle_never_folds():
    """Angle about the joint to that of the bent limb: rising up to the angle that is stated."""
    assert ramp(np.array([-2.0, -1.0, 0.0, 1.0, 2.0])).tolist() == [1.0, 1.0, 0.5, 0.0, 0.0]
    half = rigging.RANGES["knee"][1]
    angle = np.linspace(-120, 120, 4001)
    limit = 2 * half * (1 - 0.5 * rigging.ROUND)
    assert limit == pytest.approx(108.0)
    for bend, rises in ((0.999 * limit, True), (1.01 * limit, False)):
        assert (np.diff(angle + bend * ramp(angle / half)) > 0).all() == rises


def test_distance_along_the_skin():
    """On a flat grid, from the line y = 0.003: along edges, never less than the distance."""
    n = 21
    x, y = np.meshgrid(np.arange(n) * 0.01, np.arange(n) * 0.01 - 0.1)
    points = np.column_stack([x.ravel(), y.ravel(), np.zeros(n * n)])
    cell = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    triangles = np.concatenate(
        [np.stack([cell, cell + 1, cell + n + 1], 1), np.stack([cell, cell + n + 1, cell + n], 1)]
    )
    far = along_skin(points, triangles, points[:, 1] - 0.003)
    assert far == pytest.approx(np.abs(points[:, 1] - 0.003), abs=1e-8)


def test_smoothing_is_a_mean_and_local():
    body = placed(lower_body(manikin()), standing_points(STATURE), STATURE)
    matrix = between_legs(body, SKIN)
    assert np.abs(np.asarray(matrix.sum(axis=1)) - 1).max() < 1e-12
    moved = np.linalg.norm(matrix @ body.points - body.points, axis=1) > 1e-9
    assert 0 < moved.sum() < 0.2 * len(moved)
    assert np.abs(body.points[moved, 2] - 0.84).max() < 0.17
