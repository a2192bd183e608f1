# SPDX-License-Identifier: LGPL-3.0-or-later
"""Curves over the phase of gait against those they were made of; arrays as text and back."""

import json

import numpy as np
import pytest

import shellform as sf
from shellform.motion.anthropometry import ellipsoids
from shellform.motion.gait.strides import counted, strides
from shellform.report.curves import mean_and_band, torque_curves
from shellform.report.finished_run import FinishedRun
from shellform.report.packed import as_json, packed, rounded_colours, rounded_places, unpacked
from shellform.report.skin import skin_data, skin_scale, unit_sphere
from shellform.report.walk_frames import triangles_of
from shellform.results.mean_torque import PLACES, Course
from shellform.results.pressure_map import Map, VertexPressure

pytestmark = pytest.mark.serial


@pytest.fixture(scope="module")
def made_up():
    """Run of a level walk whose torque is a sine of the phase, its size 1, 2, 3 in three starts."""
    walk = sf.synthetic_walk(strides=4, obstacle=0.0)
    wearer = sf.Wearer(walk, ellipsoids(walk.lengths()))
    found = strides(walk)["right"]
    ends = np.arange(walk.times[0], walk.times[-1], 0.005)[1:]
    widths = np.full(len(ends), 0.005)
    phase = np.interp(
        ends - 0.0025, found.ravel(), (np.arange(len(found))[:, None] + [0, 1]).ravel()
    )
    torque = np.outer([1.0, 2.0, 3.0], np.sin(2 * np.pi * phase))
    courses = {"right_knee": Course(ends, widths, torque, 0 * torque)}
    results = {"strides": {"right": found.tolist()}, "counted_s": counted(walk)}
    return FinishedRun("run", None, None, None, wearer, None, {"results": results}, courses)


def test_curves_over_the_phase_of_gait(made_up):
    """The mean of three sines, their standard error 1 / sqrt(3), in each stride and their mean."""
    own = torque_curves(made_up)["right_knee"]
    sine = np.sin(2 * np.pi * PLACES / 100)
    assert own["percent"] is PLACES and len(own["strides"]) == len(own["names"]) == 3
    for stride in own["strides"]:
        assert stride == pytest.approx(2 * sine, abs=0.02)
    assert own["mean"] == pytest.approx(2 * sine, abs=0.02)
    assert own["mean_error"] == pytest.approx(np.abs(sine) / np.sqrt(3), abs=0.02)
    assert own["mean_spread"] == pytest.approx(np.abs(sine), abs=0.02)
    assert own["torque"] == pytest.approx(made_up.courses["right_knee"].torque.mean(axis=0))


def test_mean_and_band():
    """Of constant torques 1, 2, 3: mean 2, both errors 1 / sqrt(3); of one run none."""
    ends = np.arange(1.0, 6.0)
    course = Course(ends, np.ones(5), np.outer([1.0, 2.0, 3.0], np.ones(5)), np.zeros((3, 5)))
    assert mean_and_band(course, (0.0, 5.0)) == pytest.approx((2.0, 3**-0.5, 3**-0.5))
    alone = Course(ends, np.ones(5), np.full((1, 5), 4.0), np.zeros((1, 5)))
    mean, error, wide = mean_and_band(alone, (1.0, 3.0))
    assert mean == 4.0 and np.isnan(error) and np.isnan(wide)


@pytest.mark.parametrize("kind", ["int16", "uint8", "int32", "float32"])
def test_arrays_as_text(kind):
    values = np.arange(24).reshape(2, 3, 4).astype(kind)
    found = unpacked(json.loads(json.dumps(packed(values))))
    assert found.dtype == values.dtype and found.tolist() == values.tolist()


def test_rounding():
    places = np.array([[-1.23456, 0.0, 3.2]])
    assert np.abs(rounded_places(places, 1e-4) * 1e-4 - places).max() <= 0.5e-4 + 1e-12
    with pytest.raises(ValueError, match="too far off"):
        rounded_places(np.array([4.0]), 1e-4)
    assert rounded_colours(np.array([np.nan, -1.0, 0.0, 1.0, 9.0]), 0.0, 2.0).tolist() == [
        255, 0, 0, 127, 254,
    ]  # fmt: skip


def test_json_stands_inside_a_script():
    text = as_json({"a": "</script>&", "b": np.array([1.0, np.nan]), "c": (np.int64(2), None)})
    assert not set("<>&") & set(text)
    assert json.loads(as_json(np.array([np.pi]))) == [3.141592654]
    assert json.loads(text) == {"a": "</script>&", "b": [1.0, None], "c": [2, None]}


def test_a_sphere_is_closed():
    """Its triangles turn outwards and enclose 4/3 pi; each edge is met from both sides."""
    points, triangles = unit_sphere(48)
    a, b, c = (points[triangles[:, k]] for k in range(3))
    volume = np.einsum("ki,ki->k", a, np.cross(b, c)).sum() / 6
    assert abs(volume) == pytest.approx(4 / 3 * np.pi, rel=0.01)


def test_cells_as_triangles():
    assert triangles_of(np.array([[0, 1, 2, 3]])).tolist() == [[0, 1, 2], [0, 2, 3]]
    assert triangles_of(np.array([[4, 5, 6]])).tolist() == [[4, 5, 6]]
    nine = np.arange(9)[None]
    assert triangles_of(nine).tolist() == [[0, 1, 2], [0, 2, 3]]


def test_the_scale_of_skin_without_touch():
    nothing = np.zeros(4)
    empty = Map(("a",), np.ones((1, 3)), 0.1, np.zeros(4, int), np.zeros((4, 3)), np.ones(4),
                nothing, nothing, nothing, nothing, nothing, 1.0)  # fmt: skip
    low, high = skin_scale([empty])
    assert low < high == 0.0


def test_the_skin_of_a_body_of_triangles(made_up):
    """Its vertices to a tenth of a millimetre about their middle, its triangles, its colours."""
    vertices = np.array([(1.0, 2.0, 0.1), (1.4, 2.0, 0.3), (1.0, 2.2, 0.5), (1.2, 2.1, 1.1)])
    triangles = np.array([(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)])
    mean, ones = np.array([0.0, 10.0, 100.0, 1000.0]), np.ones(4)
    found = VertexPressure(
        ("limb",), np.zeros(4, int), vertices, triangles, ones, mean, 10 * mean, *[ones] * 3, 2.0
    )
    data = skin_data(made_up, found, [0.0, 4.0])
    assert unpacked(data["places"]) * data["step"] == pytest.approx(
        vertices - (1.2, 2.1, 0.0), abs=6e-5
    )
    assert unpacked(data["triangles"]).tolist() == triangles.tolist()
    assert unpacked(data["colours"]["mean"]).tolist() == [255, 64, 127, 190]
    assert unpacked(data["colours"]["peak"]).tolist() == [255, 127, 190, 254]
    assert data["seconds"] == 2.0 and "ellipsoids" not in data
