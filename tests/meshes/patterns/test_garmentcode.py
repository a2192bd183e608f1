# SPDX-License-Identifier: LGPL-3.0-or-later
"""GarmentCode's JSON: curves of its three kinds, places, units, and what is wrong with a file."""

import json

import numpy as np
import pytest

from meshes import MeshError
from meshes.patterns import read_pattern, sew

SQUARE = [[0, 0], [40, 0], [40, 30], [0, 30]]


def spec(panels=None, stitches=(), **properties):
    """Contents of a file; panels : name -> (vertices, curvature by edge)."""
    made = {}
    for name, (vertices, curved) in (panels or {"front": (SQUARE, {})}).items():
        edges = [
            {"endpoints": [k, (k + 1) % len(vertices)]}
            | ({"curvature": curved[k]} if k in curved else {})
            for k in range(len(vertices))
        ]
        made[name] = {"vertices": vertices, "edges": edges}
    sides = [[{"panel": a, "edge": i}, {"panel": b, "edge": j}] for a, i, b, j in stitches]
    return {
        "pattern": {"panels": made, "stitches": sides},
        "properties": {"units_in_meter": 100, "curvature_coords": "relative"} | properties,
    }


def written(tmp_path, data):
    path = tmp_path / "drawn.json"
    path.write_text(data if isinstance(data, str) else json.dumps(data))
    return path


def test_lengths_and_areas_of_curves(tmp_path):
    """A half circle of 40 cm, a parabola, a cubic that is a straight line: exact."""
    curved = {
        0: {"type": "circle", "params": [20.0, 0, 1]},
        2: {"type": "quadratic", "params": [[0.5, -0.5]]},
        3: {"type": "cubic", "params": [[0.25, 0.0], [0.5, 0.0]]},
    }
    panel = read_pattern(written(tmp_path, spec({"front": (SQUARE, curved)}))).panels[0]
    assert panel.edge("0").length == pytest.approx(0.2 * np.pi, rel=1e-4)
    # y = h (1 - (2x/c)^2) with h = c/4: c/2 (sqrt(1 + a^2) + asinh(a)/a), a = 4 h/c = 1
    assert panel.edge("2").length == pytest.approx(0.2 * (np.sqrt(2) + np.arcsinh(1.0)), rel=1e-4)
    assert panel.edge("3").length == pytest.approx(0.3, rel=1e-9)
    # the circle bulges to the right of the way: out of the panel; the parabola too
    bulge = 0.5 * np.pi * 0.2**2 + 2 / 3 * 0.4 * 0.1
    assert panel.area == pytest.approx(0.12 + bulge, rel=1e-3)
    assert np.allclose(panel.edge("0").at([0.5]), [[0.2, -0.2]], atol=1e-9)


def test_the_longer_arc(tmp_path):
    curved = {0: {"type": "circle", "params": [25.0, 1, 1]}}
    panel = read_pattern(written(tmp_path, spec({"front": (SQUARE, curved)}))).panels[0]
    whole = 2 * np.pi * 0.25
    assert panel.edge("0").length == pytest.approx(whole - 0.5 * np.arcsin(0.8), rel=1e-4)


@pytest.mark.parametrize(("units", "scale"), [(100, 0.01), (1000, 0.001), (1, 1.0)])
def test_units(tmp_path, units, scale):
    vertices = (np.array(SQUARE) * 0.01 / scale).tolist()
    panel = read_pattern(
        written(tmp_path, spec({"front": (vertices, {})}, units_in_meter=units))
    ).panels[0]
    assert panel.area == pytest.approx(0.12)


def test_absolute_control_points(tmp_path):
    curved = {2: {"type": "quadratic", "params": [[20, 50]]}}
    data = spec({"front": (SQUARE, curved)}, curvature_coords="absolute")
    panel = read_pattern(written(tmp_path, data)).panels[0]
    assert np.allclose(panel.edge("2").points[1], [0.2, 0.5])


def test_a_place_about_the_body(tmp_path):
    """The file's z is forward, its x to the left, its y up; turned about y, the back looks back."""
    data = spec()
    data["pattern"]["panels"]["front"] |= {"translation": [10, 100, -20], "rotation": [0, 180, 0]}
    panel = read_pattern(written(tmp_path, data)).panels[0]
    assert np.allclose(panel.translation, [-0.2, 0.1, 1.0])
    assert np.allclose(panel.rotation @ [1, 0, 0], [0, -1, 0])
    assert np.allclose(panel.rotation @ [0, 0, 1], [-1, 0, 0])
    data["pattern"]["panels"]["front"]["rotation"] = [90, 0, 90]
    panel = read_pattern(written(tmp_path, data)).panels[0]
    # about x, then y, then z: its y goes to the file's z, that stays
    assert np.allclose(panel.rotation @ [0, 1, 0], [1, 0, 0])


TWO = {"front": (SQUARE, {}), "back": (SQUARE, {})}
BOW = [[0, 0], [40, 30], [40, 0], [0, 30]]


def _open(data):
    data["pattern"]["panels"]["front"]["edges"].pop()


def _far(data):
    data["pattern"]["panels"]["front"]["edges"][1]["endpoints"] = [1, 7]


def _missing(data):
    data["pattern"]["panels"]["front"]["vertices"][2] = [float("nan"), 30]


def _kind(data):
    data["pattern"]["panels"]["front"]["edges"][1]["curvature"] = {"type": "spline", "params": []}


BROKEN = {
    "open": (spec(), _open, r"panel 'front', edge 2: it ends at vertex 3 and edge 0 begins"),
    "vertex": (spec(), _far, r"panel 'front', edge 1: endpoints are two numbers"),
    "nan": (spec(), _missing, r"panel 'front', edge '1': a point of it is .*nan.* give finite"),
    "curvature": (spec(), _kind, r"panel 'front', edge 1: its curvature is of the type 'spline'"),
    "small circle": (
        spec({"front": (SQUARE, {0: {"type": "circle", "params": [5, 0, 1]}})}),
        None,
        r"panel 'front', edge 0: a circle of radius 0.05 m does not reach",
    ),
    "unit": (spec(units_in_meter=7), None, r"properties.units_in_meter is 7, which is no unit"),
    "crossing": (
        spec({"front": (BOW, {})}),
        None,
        r"panel 'front': its outline crosses itself, edge '0' meets edge '2'",
    ),
    "no length": (
        spec({"front": ([*SQUARE, [0, 30]], {})}),
        None,
        r"panel 'front', edge '3': it has no length",
    ),
    "stitch to no panel": (
        spec(TWO, [("front", 1, "pocket", 0)]),
        None,
        r"stitch 0 names panel 'pocket', which is not there: there are front, back",
    ),
    "stitch to no edge": (
        spec(TWO, [("front", 1, "back", 9)]),
        None,
        r"stitch 0 names edge 9 of panel 'back', which has edges 0 to 3",
    ),
    "sewn twice": (
        spec(TWO, [("front", 1, "back", 3), ("front", 1, "back", 1)]),
        None,
        r"edge '1' of panel 'front' is in stitch 0 and in stitch 1",
    ),
    "no ease": (
        spec(
            {"front": (SQUARE, {}), "band": ([[0, 0], [10, 0], [10, 4], [0, 4]], {})},
            [("front", 0, "band", 2)],
        ),
        None,
        r"stitch 0 sews edge '0' of panel 'front' \(0.400 m\) to edge '2' of panel 'band' "
        r"\(0.100 m\), 4.00 to 1",
    ),
    "huge": (spec(units_in_meter=1), None, r"its largest panel is 40 m long"),
    "layer": (
        spec({**TWO, "chest_pocket": (SQUARE, {})}),
        None,
        r"panel 'chest_pocket' is a pocket, which lies on another layer",
    ),
    "two left sleeves": (
        spec(
            {
                "left_sleeve": ([[0, 0], [30, 5], [40, 30], [0, 20]], {}),
                "right_sleeve": ([[0, 0], [30, 5], [40, 30], [0, 20]], {}),
            }
        ),
        None,
        r"panel 'right_sleeve' is panel 'left_sleeve' once more, .* edge '0'",
    ),
}


@pytest.mark.parametrize("name", BROKEN)
def test_broken_patterns(name, tmp_path):
    """One sentence with file, panel, edge and mend, before anything is meshed."""
    data, spoil, said = BROKEN[name]
    data = json.loads(json.dumps(data))
    if spoil:
        spoil(data)
    with pytest.raises(MeshError, match=r"^drawn\.json: " + said) as error:
        sew(read_pattern(written(tmp_path, data)))
    assert str(error.value).endswith(".") and "\n" not in str(error.value)


def test_files_that_are_none(tmp_path):
    with pytest.raises(MeshError, match=r"drawn\.json: not a JSON file"):
        read_pattern(written(tmp_path, "{"))
    with pytest.raises(MeshError, match=r"there are no panels under pattern\.panels"):
        read_pattern(written(tmp_path, "[]"))
    text = json.dumps(spec()).replace('"front": {', '"front": {}, "front": {')
    with pytest.raises(MeshError, match="'front' is there twice"):
        read_pattern(written(tmp_path, text))
    with pytest.raises(MeshError, match="size 'M' is asked for, and GarmentCode files have one"):
        read_pattern(written(tmp_path, spec()), size="M")
    with pytest.raises(MeshError, match="there is no such file"):
        read_pattern(tmp_path / "else.json")
    with pytest.raises(MeshError, match=r"no pattern ends in '\.pat'"):
        read_pattern(tmp_path / "else.pat")


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ("front.1", r"garment.stitches\[0\] is 'front.1': give two edges"),
        (["front.1", "sleeve.2"], r"garment.stitches\[0\] names 'sleeve.2', and there is no such"),
        (["front.1", "back.7"], r"garment.stitches\[0\] names edge '7' of panel 'back'"),
        (["front.1", "back.2", "turned"], r"garment.stitches\[0\] has a third text 'turned'"),
    ],
)
def test_stitches_of_a_scene_that_do_not_fit(given, said, tmp_path):
    with pytest.raises(MeshError, match=said):
        read_pattern(written(tmp_path, spec(TWO)), stitches=[given])


def test_a_panel_about_no_segment(tmp_path):
    path = written(tmp_path, spec(TWO))
    with pytest.raises(MeshError, match=r"garment\.about names panel 'side', which is not there"):
        read_pattern(path, about={"side": "pelvis"})
    with pytest.raises(MeshError, match="panel 'front' goes around 'tail', which is no segment"):
        sew(read_pattern(path, about={"front": "tail"}))
