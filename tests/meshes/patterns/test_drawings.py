# SPDX-License-Identifier: LGPL-3.0-or-later
"""Patterns drawn in DXF (AAMA, ASTM) and SVG: layers, units, sizes, folds, grain, faults."""

import sys

import numpy as np
import pytest

import meshes
from meshes import MeshError
from meshes.patterns import read_pattern, sew
from meshes.patterns.crossings import crossings

FRONT = [(-250, 0), (-360, -550), (360, -550), (250, 0)]  # mm


def dxf(path, pieces, units="METRIC", header=0, sample=None):
    """A file of pieces : (name, size, quantity, [(layer, points, closed)], [(layer, point)])."""
    ezdxf = pytest.importorskip("ezdxf", reason="ezdxf, an option, is not installed")
    drawing = ezdxf.new("R2000" if header else "R12")
    drawing.header["$INSUNITS"] = header
    space = drawing.modelspace()
    for text in (f"Units: {units}" if units else "", f"Sample Size: {sample}" if sample else ""):
        if text:
            space.add_text(text, dxfattribs={"layer": "1"})
    for k, (name, size, quantity, lines, points) in enumerate(pieces):
        block = drawing.blocks.new(f"PIECE_{k}")
        for text in (
            f"Piece Name: {name}",
            f"Size: {size}" if size else "",
            f"Quantity: {quantity}",
        ):
            block.add_text(text, dxfattribs={"layer": "1"})
        for layer, line, closed in lines:
            block.add_polyline2d(line, close=closed, dxfattribs={"layer": layer})
        for layer, point in points:
            block.add_point(point, dxfattribs={"layer": layer})
        space.add_blockref(block.name, (0, 0))
    drawing.saveas(path)
    return path


def piece(name, outline=FRONT, size="", quantity="1", more=(), points=()):
    return name, size, quantity, [("1", outline, True), *more], list(points)


def hem(points=21):
    """The hem of FRONT as a curve of many points, 40 mm deep."""
    x = np.linspace(-360, 360, points)
    return [(float(a), float(-550 - 40 * (1 - (a / 360) ** 2))) for a in x]


CURVED = [FRONT[0], *hem(), FRONT[3]]


def test_a_skirt_of_two_pieces(tmp_path):
    """From a file of AAMA, its corners marked, sewn by stitches of the scene: areas, girths."""
    turns = [("2", p) for p in FRONT]
    notches = [("4", (-305, -275))]
    grain = [("7", [(0, -500), (0, -100)], False)]
    pieces = [
        piece("FRONT", CURVED, more=grain, points=turns + notches),
        piece("back", CURVED[::-1], more=grain, points=turns),
    ]
    path = dxf(tmp_path / "skirt.dxf", pieces)
    pattern = read_pattern(path, stitches=[["FRONT.0", "back.0"], ["FRONT.2", "back.2"]])
    assert [p.name for p in pattern.panels] == ["FRONT", "back"]
    exact = 0.55 * 0.5 * (0.5 + 0.72) + 2 / 3 * 0.72 * 0.04
    for panel in pattern.panels:
        assert panel.area == pytest.approx(exact, rel=2e-3) and panel.signed_area > 0
        assert {e.name for e in panel.edges} == {"0", "1", "2", "3"}
        assert abs(panel.grain[0]) < 1e-9 and panel.grain[1] != 0
    assert np.allclose(pattern.panels[0].notches, [[-0.305, -0.275]])
    surface = sew(pattern, cell_size=0.04)
    assert len(meshes.boundary_loops(surface)) == 2
    assert len(crossings(surface.points, surface.cells)) == 0


def test_sizes_by_grade_rules_are_refused(tmp_path):
    """What is not drawn but numbered by rules: the mend is a nest; the sample size is read."""
    ezdxf = pytest.importorskip("ezdxf", reason="ezdxf, an option, is not installed")
    path = dxf(tmp_path / "rules.dxf", [piece("front", size="M")], sample="M")
    drawing = ezdxf.readfile(str(path))
    drawing.blocks.get("PIECE_0").add_text("# 12", dxfattribs={"layer": "2"})
    drawing.saveas(path)
    with pytest.raises(MeshError, match=r"rules\.dxf: size 'L' .* graded by rules, .* size M\."):
        read_pattern(path, size="L")
    drawing.modelspace().add_text("Grade Rule Table: MEN", dxfattribs={"layer": "1"})
    drawing.saveas(path)
    with pytest.raises(MeshError, match=r"rules of the table MEN, .* every size drawn"):
        read_pattern(path, size="L")
    for size in (None, "M"):
        assert len(read_pattern(path, size=size).panels) == 1


@pytest.mark.parametrize(
    ("units", "header", "scale"), [("METRIC", 0, 1e-3), ("ENGLISH", 4, 0.0254), ("", 5, 0.01)]
)
def test_units_of_a_dxf(tmp_path, units, header, scale):
    outline = [(0.001 * x / scale, 0.001 * y / scale) for x, y in FRONT]
    path = dxf(tmp_path / "a.dxf", [piece("front", outline)], units, header)
    assert read_pattern(path).panels[0].area == pytest.approx(0.3355, rel=1e-6)


def test_a_graded_nest(tmp_path):
    """Sizes by name, the sample size where none is asked for."""
    sizes = {"S": 0.9, "M": 1.0, "L": 1.1}
    pieces = [
        piece("front", [(f * x, f * y) for x, y in FRONT], size=name) for name, f in sizes.items()
    ]
    path = dxf(tmp_path / "nest.dxf", pieces, sample="M")
    for size, factor in (*sizes.items(), (None, 1.0)):
        (panel,) = read_pattern(path, size=size).panels
        assert panel.area == pytest.approx(0.3355 * factor**2, rel=1e-6)
    with pytest.raises(MeshError, match=r"nest\.dxf: there is no size 'XL' .* there are S, M, L"):
        read_pattern(path, size="XL")
    path = dxf(tmp_path / "nest.dxf", pieces)
    with pytest.raises(MeshError, match=r"nest\.dxf: the pattern is graded in S, M, L: give one"):
        read_pattern(path)


def test_a_piece_drawn_by_half_and_one_of_a_pair(tmp_path):
    """Unfolded at its mirror line; a second piece, mirrored, where the quantity says 1,1."""
    half = [(0, 0), (0, -550), (360, -550), (250, 0)]
    fold = [("6", [(0, 0), (0, -550)], False)]
    sleeve = [(0, 0), (200, 0), (260, 300), (0, 250)]
    path = dxf(
        tmp_path / "a.dxf",
        [piece("front", half, more=fold), piece("sleeve", sleeve, quantity="1,1")],
    )
    front, sleeve, other = read_pattern(path).panels
    assert front.area == pytest.approx(0.3355, rel=1e-6) and len(front.edges) == 6
    assert {e.name for e in front.edges} >= {"1", "2", "3", "1m", "2m", "3m"}
    assert other.name == "sleeve_mirrored"
    assert other.area == pytest.approx(sleeve.area) and other.signed_area > 0
    for edge in sleeve.edges:
        assert other.edge(edge.name).length == pytest.approx(edge.length)
        assert np.allclose(other.edge(edge.name).points, edge.points[::-1] * [-1, 1])


def test_the_sew_line_is_the_edge(tmp_path):
    """Where it is there, the allowance outside of it is no cloth of the panel."""
    inner = [(0.96 * x, 0.96 * y - 10) for x, y in FRONT]
    path = dxf(tmp_path / "a.dxf", [piece("front", more=[("14", inner, True)])])
    assert read_pattern(path).panels[0].area == pytest.approx(0.3355 * 0.96**2, rel=1e-6)


def test_faults_of_a_dxf(tmp_path):
    def refused(said, pieces, *more):
        path = dxf(tmp_path / "a.dxf", pieces, *more)
        with pytest.raises(MeshError, match=r"^a\.dxf: " + said):
            sew(read_pattern(path))

    refused("its text says 'Units: FURLONG'", [piece("front")], "FURLONG")
    refused(r"it names no unit that is known \(\$INSUNITS = 2", [piece("front")], "", 2)
    open_line = ("front", "", "1", [("1", FRONT, False)], [])
    refused("panel 'front': the outline is open, its last point lies 500 mm", [open_line])
    bow = [(0, 0), (400, 300), (400, 0), (0, 300)]
    refused("panel 'front': its outline crosses itself", [piece("front", bow)])
    refused("2 panels are called 'sleeve'", [piece("sleeve"), piece("sleeve")])
    circle = [(200 * np.cos(t), 200 * np.sin(t)) for t in np.linspace(0, 2 * np.pi, 60)[:-1]]
    refused("panel 'front': its outline has 0 corners", [piece("front", circle)])
    refused("no block has a boundary on layer 1", [("front", "", "1", [("8", FRONT, True)], [])])
    (tmp_path / "a.dxf").write_text("nothing")
    with pytest.raises(MeshError, match=r"a\.dxf: not a DXF file"):
        read_pattern(tmp_path / "a.dxf")


SVG = """<svg xmlns="http://www.w3.org/2000/svg" width="{width}" viewBox="0 0 1000 800">
<g id="front">
 <path d="M 100,100 L 0,650 Q 375,730 750,650 L 640,100 C 500,130 240,130 100,100 Z" {names}/>
 <path class="grain" d="M 300,600 L 300,200"/>
 <circle class="notch" cx="50" cy="375" r="2"/>
</g>
<path id="back" d="M 100,100 L 0,650 Q 375,730 750,650 L 640,100 C 500,130 240,130 100,100 Z"/>
</svg>
"""
NAMES = 'data-edges="right hem left waist"'


def svg(path, width="1000mm", names=NAMES, text=SVG):
    pytest.importorskip("svgelements", reason="svgelements, an option, is not installed")
    path.write_text(text.format(width=width, names=names))
    return path


def test_a_skirt_of_a_drawing(tmp_path):
    """Curves, grain and a notch of a group; names of edges; y of the drawing points down."""
    path = svg(tmp_path / "skirt.svg")
    stitches = [["front.right", "back.2"], ["front.left", "back.0"]]
    pattern = read_pattern(path, stitches=stitches)
    front, back = pattern.panels
    assert {e.name for e in front.edges} == {"right", "hem", "left", "waist"}
    # the trapezium, two thirds of the hem's bow, less the waist's
    t = np.linspace(0, 1, 4001)[:, None]
    waist = np.array([(0.64, -0.1), (0.5, -0.13), (0.24, -0.13), (0.1, -0.1)])
    x, y = sum(
        c * (1 - t) ** (3 - k) * t**k * p for k, (c, p) in enumerate(zip((1, 3, 3, 1), waist))
    ).T
    bow = float(np.sum(0.5 * (-0.2 - y[1:] - y[:-1]) * (x[:-1] - x[1:])))
    exact = 0.5 * (0.75 + 0.54) * 0.55 + 2 / 3 * 0.75 * 0.04 - bow
    assert front.area == pytest.approx(exact, rel=1e-3)
    assert back.area == pytest.approx(front.area) and front.signed_area > 0
    assert front.grain[0] == pytest.approx(0.0) and front.grain[1] == pytest.approx(0.4)
    assert np.allclose(front.notches, [[0.05, -0.375]], atol=1e-6)
    surface = sew(pattern, cell_size=0.04)
    assert len(meshes.boundary_loops(surface)) == 2
    assert len(crossings(surface.points, surface.cells)) == 0


def test_units_of_a_drawing(tmp_path):
    """By its width, or by the scene's unit where that has none."""
    area = read_pattern(svg(tmp_path / "a.svg")).panels[0].area
    assert read_pattern(svg(tmp_path / "a.svg", "100cm")).panels[0].area == pytest.approx(area)
    assert read_pattern(svg(tmp_path / "a.svg", "500mm")).panels[0].area == pytest.approx(area / 4)
    plain = svg(tmp_path / "a.svg", "1000")
    assert read_pattern(plain, unit="mm").panels[0].area == pytest.approx(area)
    with pytest.raises(MeshError, match=r"a\.svg: its width has no unit of length \('1000'\)"):
        read_pattern(plain)
    with pytest.raises(MeshError, match=r"a\.svg: its width is '10furlong', in no unit"):
        read_pattern(svg(tmp_path / "a.svg", "10furlong"))


def test_faults_of_a_drawing(tmp_path):
    path = tmp_path / "a.svg"

    def refused(said, text, **more):
        with pytest.raises(MeshError, match=r"^a\.svg: " + said):
            sew(read_pattern(svg(path, text=text), **more))

    refused(
        "panel 'front': the outline is open, its last point",
        SVG.replace(" C 500,130 240,130 100,100 Z", ""),
    )
    refused("panel 'front': data-edges has 2 names", SVG.replace("{names}", 'data-edges="a b"'))
    refused("there is no size 'M' .* it has no groups 'size-...'", SVG, size="M")
    refused("it has no closed path", '<svg xmlns="http://www.w3.org/2000/svg" width="1mm"/>')
    with pytest.raises(MeshError, match=r"a\.svg: not an SVG file"):
        path.write_text("nothing")
        read_pattern(path)


def test_sizes_of_a_drawing(tmp_path):
    text = """<svg xmlns="http://www.w3.org/2000/svg" width="{width}" viewBox="0 0 1000 800">
    <g id="size-S"><path id="front" d="M 0,0 L 0,300 L 400,300 L 400,0 Z"/></g>
    <g id="size-L"><path id="front" d="M 0,0 L 0,400 L 500,400 L 500,0 Z"/></g></svg>"""
    path = svg(tmp_path / "a.svg", text=text)
    assert read_pattern(path, size="S").panels[0].area == pytest.approx(0.12)
    assert read_pattern(path, size="L").panels[0].area == pytest.approx(0.20)
    with pytest.raises(MeshError, match=r"a\.svg: the pattern has sizes S, L: give one"):
        read_pattern(path)


@pytest.mark.parametrize(("package", "kind"), [("ezdxf", "dxf"), ("svgelements", "svg")])
def test_without_the_package_a_sentence_says_how_to_get_it(package, kind, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, package, None)
    (tmp_path / f"a.{kind}").write_text("")
    with pytest.raises(ImportError, match=rf"is read by the package {package}: pip install"):
        read_pattern(tmp_path / f"a.{kind}")
