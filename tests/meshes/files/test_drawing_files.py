# SPDX-License-Identifier: LGPL-3.0-or-later
"""Files as drawing programs write them: each kind of oddity read, mended and told, or refused."""

import base64
import json
import struct
import warnings
from pathlib import Path

import numpy as np
import pytest

import meshes
from meshes import MeshError
from meshes.files.faces import cut_polygon
from tests.meshes.files.gltf_file import glb

CASES = Path(__file__).resolve().parents[4] / "shared/cases/meshes"
TUBE = meshes.cylinder(0.15, 0.6, (12, 6), angle=2 * np.pi)


def obj(surface, face=lambda row: " ".join(str(k + 1) for k in row), vertex="v {} {} {}"):
    """Text of a .obj file; `face` writes the corners of a cell."""
    lines = [vertex.format(*point) for point in surface.points]
    return "\n".join(lines + ["f " + face(row) for row in surface.cells.tolist()]) + "\n"


def quiet(path, **options):
    """The surface of a file that gives no warning."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return meshes.load(path, **options)


def anyhow(path, **options):
    """The surface of a file, whatever it warns of."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return meshes.load(path, **options)


def told(path, words, **options):
    """The surface of a file of which `words` are told, in its notes too."""
    with pytest.warns(UserWarning, match=words):
        surface = meshes.load(path, **options)
    assert any(all(part in note for part in words.split(".*")) for note in surface.notes)
    return surface


def alike(surface, wanted=TUBE, cells=True):
    if cells:
        assert len(surface.cells) == len(wanted.cells)
    assert surface.area == pytest.approx(wanted.area, rel=1e-6)
    assert np.allclose(surface.bounds, wanted.bounds, atol=1e-7)
    assert len(meshes.boundary_loops(surface)) == 2


N = len(TUBE.points)
BACKWARD = {
    "negative": lambda row: " ".join(str(k - N) for k in row),
    "continued": lambda row: f"{row[0] + 1} {row[1] + 1} \\\n {row[2] + 1} \\\n{row[3] + 1}",
    "comment": lambda row: " ".join(str(k + 1) for k in row) + " # a cell",
    "glued comment": lambda row: " ".join(f"{k + 1}//1" for k in row) + "#cell",
    "texture": lambda row: " ".join(f"{k - N}/1/1" for k in row),
}


@pytest.mark.parametrize("kind", BACKWARD)
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_obj_as_written_elsewhere(tmp_path, kind, end):
    text = "\ufeff# cloth\nmtllib x.mtl\n" + obj(TUBE, BACKWARD[kind], "v {} {} {} # place")
    (tmp_path / "x.obj").write_bytes(text.replace("\n", end).encode())
    surface = quiet(tmp_path / "x.obj")
    alike(surface)
    assert np.array_equal(surface.cells, TUBE.cells)


@pytest.mark.parametrize(
    "more, words",
    [
        ("f 1 2 2 1", "x.obj: 1 face has less than three different corners"),
        ("f 1 1 1 1\nf 2 2 3 3", "2 faces have less than three different corners"),
        ("f 1 2 3 4", "1 face has the same corners as another"),
        ("f 1 2", "less than three different corners"),
        ("v 0.5 0.5 0\nv 1 1 0\nv 2 2 0\nf -1 -2 -3", "1 face has no area"),
        ("f 1 3 2 1 4 2", "1 face touches itself"),
    ],
)
def test_faces_that_are_no_cells(tmp_path, more, words):
    text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n" + more + "\n"
    (tmp_path / "x.obj").write_text(text)
    surface = told(tmp_path / "x.obj", words)
    assert surface.area == pytest.approx(1.0) and len(surface.cells) == 1


@pytest.mark.parametrize("count", [5, 6, 7, 8, 11])
@pytest.mark.parametrize("quads", [True, False])
def test_polygons_are_cut(count, quads):
    """Convex and star-shaped polygons keep their area and direction; even ones give quads alone."""
    angle = np.linspace(0, 2 * np.pi, count, endpoint=False)
    for inner in (1.0, 0.6):
        radius = np.where(np.arange(count) % 2, inner, 1.0)
        corners = np.stack([radius * np.cos(angle), 0 * angle, radius * np.sin(angle)], axis=1)
        parts = cut_polygon(corners, quads)

        def vector(face, corners=corners):
            line = corners[face]
            return 0.5 * np.cross(line, np.roll(line, -1, axis=0)).sum(axis=0)

        pieces = np.array([vector(part) for part in parts])
        assert np.allclose(pieces.sum(axis=0), vector(np.arange(count)))
        assert (pieces[:, 1] < 0).all()
        if quads and inner == 1.0:
            assert sum(len(part) == 3 for part in parts) == count % 2
        assert quads or all(len(part) == 3 for part in parts)


def test_ngons_in_a_file(tmp_path):
    """Two neighbours as one face of six corners are two quads again."""
    one, other = TUBE.cells[0].tolist(), TUBE.cells[1].tolist()
    tail, head = next(
        pair for pair in zip(one, one[1:] + one[:1]) if {*pair} <= {*other}
    )  # of the side between them, as the first cell goes along it
    place, back = one.index(head), other.index(tail)
    ring = one[place:] + one[:place] + (other[back:] + other[:back])[1:3]
    text = obj(TUBE.replace(cells=TUBE.cells[2:], edges={}, verify=False))
    (tmp_path / "x.obj").write_text(text + "f " + " ".join(str(k + 1) for k in ring) + "\n")
    surface = quiet(tmp_path / "x.obj")
    alike(surface)
    assert "1 face has more than four corners and is cut into quads" in surface.notes[0]


def ply(surface, order, name, before=False):
    """Bytes of a .ply file with scalars and a list after the corners, or before them."""
    faces, points = surface.cells, surface.points
    lines = ["ply", f"format {order} 1.0", "comment x", f"element vertex {len(points)}"]
    lines += [f"property double {axis}" for axis in "xyz"] + ["property uchar red"]
    lines += [f"element face {len(faces)}", "property float quality"]
    lists = ["property list uchar float texcoord", f"property list uchar int {name}"]
    lines += lists if before else lists[::-1]
    lines += ["property short flags", "element edge 1", "property int a", "end_header"]
    head = ("\n".join(lines) + "\n").encode()
    if order == "ascii":
        rows = [" ".join(map(str, point)) + " 7" for point in points.tolist()]
        for face in faces.tolist():
            corners = f"{len(face)} " + " ".join(map(str, face))
            rows.append(f"0.5 2 0.1 0.2 {corners} 3" if before else f"0.5 {corners} 2 0.1 0.2 3")
        return head + ("\n".join([*rows, "5"]) + "\n").encode()
    mark = "<" if "little" in order else ">"
    body = b"".join(struct.pack(mark + "dddB", *point, 7) for point in points.tolist())
    for face in faces.tolist():
        corners = struct.pack(f"{mark}B{len(face)}i", len(face), *face)
        places = struct.pack(mark + "Bff", 2, 0.1, 0.2)
        both = places + corners if before else corners + places
        body += struct.pack(mark + "f", 0.5) + both + struct.pack(mark + "h", 3)
    return head + body + struct.pack(mark + "i", 5)


@pytest.mark.parametrize("order", ["ascii", "binary_little_endian", "binary_big_endian"])
@pytest.mark.parametrize("name", ["vertex_index", "vertex_indices"])
@pytest.mark.parametrize("before", [True, False])
def test_ply(tmp_path, order, name, before):
    data = ply(TUBE, order, name, before)
    (tmp_path / "x.ply").write_bytes(data)
    surface = quiet(tmp_path / "x.ply")
    alike(surface)
    assert np.array_equal(surface.points, TUBE.points)
    for part in (0.2, 0.5, 0.9):
        (tmp_path / "cut.ply").write_bytes(data[: int(part * len(data))])
        with pytest.raises(MeshError, match=r"^cut.ply: .*(cut short|end_header|format|says)"):
            meshes.load(tmp_path / "cut.ply")


@pytest.mark.parametrize("upper", [True, False])
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_stl_text(tmp_path, upper, end):
    triangles = meshes.to_triangles(TUBE, "shortest")
    text = "solid cloth" + end
    for face in triangles.points[triangles.cells].tolist():
        text += f" facet normal 0 0 0{end}  outer loop{end}"
        text += "".join(f"   vertex {x:e} {y:e} {z:e}{end}" for x, y, z in face)
        text += f"  endloop{end} endfacet{end}"
    text += "endsolid cloth" + end
    data = (text.upper() if upper else text).encode()
    (tmp_path / "x.stl").write_bytes(data)
    alike(quiet(tmp_path / "x.stl"), triangles)
    (tmp_path / "cut.stl").write_bytes(data[: len(data) // 2])
    with pytest.raises(MeshError, match=r"cut.stl: .*cut short"):
        meshes.load(tmp_path / "cut.stl")


def test_stl_binary_cut_short(tmp_path):
    meshes.save(TUBE, tmp_path / "x.stl")
    triangles = meshes.to_triangles(TUBE, "shortest")
    corners = triangles.points[triangles.cells].astype("<f4")
    rows = b"".join(bytes(12) + face.tobytes() + bytes(2) for face in corners)
    data = b"solid in a binary file".ljust(80) + struct.pack("<I", len(corners)) + rows
    (tmp_path / "y.stl").write_bytes(data)
    alike(quiet(tmp_path / "y.stl"), triangles)
    (tmp_path / "z.stl").write_bytes(b"binary".ljust(80) + data[80 : len(data) // 2])
    with pytest.raises(MeshError, match=r"z.stl: .*cut short"):
        meshes.load(tmp_path / "z.stl")


@pytest.mark.parametrize("whole", [True, False])
def test_gltf(tmp_path, whole):
    """Y up, the front towards z, points repeated per triangle: one skirt, upright, x forward."""
    upright = TUBE.transform(translation=(0.3, 0.2, 0.1))
    data = glb(upright)
    if whole:
        (tmp_path / "x.glb").write_bytes(data)
        path = tmp_path / "x.glb"
    else:
        length = struct.unpack("<I", data[12:16])[0]
        tree = json.loads(data[20 : 20 + length])
        binary = base64.b64encode(data[28 + length :]).decode()
        tree["buffers"][0]["uri"] = "data:application/octet-stream;base64," + binary
        path = tmp_path / "x.gltf"
        path.write_text(json.dumps(tree))
    surface = quiet(path)
    assert "y up" in surface.notes[0] and surface.kind == "triangle"
    alike(surface, meshes.to_triangles(upright, "shortest"))
    if whole:
        for part in (0.3, 0.6, 0.95):
            (tmp_path / "cut.glb").write_bytes(data[: int(part * len(data))])
            with pytest.raises(MeshError, match=r"cut.glb: .*(cut short|JSON)"):
                meshes.load(tmp_path / "cut.glb")


def halves(gap):
    """The tube in two halves, its seams off by `gap` [m], and its rows of points on them."""
    points = np.concatenate([TUBE.points, TUBE.points + [0.0, gap, 0.0]])
    first = TUBE.points[TUBE.cells].mean(axis=1)[:, 1] > 0
    cells = np.concatenate([TUBE.cells[first], TUBE.cells[~first] + N])
    both = meshes.Surface(points, cells, verify=False)
    return meshes.clean(both)


def test_seams_that_nearly_meet(tmp_path):
    (tmp_path / "x.obj").write_text(obj(halves(-1e-4)))
    surface = told(tmp_path / "x.obj", "border comes near another side.*weld_m = ")
    assert len(surface.points) == N + 14
    mended = quiet(tmp_path / "x.obj", weld=2e-4)
    assert len(mended.points) == N and len(mended.cells) == len(TUBE.cells)
    assert len(meshes.boundary_loops(mended)) == 2
    assert "weld joined 14 points" in mended.notes[0]
    with pytest.raises(ValueError, match="weld must be a distance in m"):
        meshes.load(tmp_path / "x.obj", weld=-1.0)


@pytest.mark.parametrize("gap", [0.0, 1e-5])
def test_t_junctions(tmp_path, gap):
    """Two squares beside a larger one: the point between them lies in its side."""
    points = [(0, 0, 0), (0.1, 0, 0), (0.2, 0, 0), (0, 0.1, 0), (0.1, 0.1 + gap, 0), (0.2, 0.1, 0)]
    points += [(0.0, 0.3, 0.0), (0.2, 0.3, 0.0)]
    text = "".join(f"v {x} {y} {z}\n" for x, y, z in points)
    (tmp_path / "x.obj").write_text(text + "g seam\nf 1 2 5 4\nf 2 3 6 5\nf 4 6 8 7\n")
    surface = told(tmp_path / "x.obj", "at 1 point the border comes near.*T-junction")
    assert len(surface.points) == 8
    mended = quiet(tmp_path / "x.obj", weld=2e-5)
    assert len(meshes.boundary_loops(mended)) == 1
    assert mended.area == pytest.approx(0.06, rel=1e-3)
    assert len(mended.panels["seam"]) == len(mended.cells)


def thick(surface, thickness, offset=0):
    """A closed sheet of a thickness around a surface, as programs export it for pictures."""
    shift = 0.5 * thickness * surface.directors
    points, n = np.concatenate([surface.points + shift, surface.points - shift]), N
    cells = [surface.cells, surface.cells[:, ::-1] + n]
    for loop in meshes.boundary_loops(surface):
        after = np.roll(loop, -1)
        cells.append(np.stack([after, loop, loop + n, after + n], axis=1))
    return meshes.Surface(points, np.concatenate(cells))


@pytest.mark.parametrize("thickness", [0.5e-3, 2e-3, 8e-3])
def test_thick_sheets(tmp_path, thickness):
    (tmp_path / "x.obj").write_text(obj(thick(TUBE, thickness)))
    surface = told(tmp_path / "x.obj", "as cloth exported with its thickness.*midsurface = true")
    assert surface.area > 1.9 * TUBE.area
    with pytest.warns(UserWarning, match="surface in the middle of a sheet"):
        middle = meshes.load(tmp_path / "x.obj", midsurface=True)
    assert len(middle.cells) == len(TUBE.cells) and set(middle.edges) == {
        "boundary_0",
        "boundary_1",
    }
    # half the thickness is found to the sagitta of a cell's turn by 30 degrees
    assert middle.area == pytest.approx(TUBE.area, rel=0.2 * thickness / 0.15)
    (tmp_path / "y.obj").write_text(obj(TUBE))
    with pytest.raises(MeshError, match=r"y.obj: there is no middle surface.*midsurface out"):
        meshes.load(tmp_path / "y.obj", midsurface=True)


def test_closed_bodies_are_not_thick_sheets():
    """A box has no sheet behind its cells; one of 10 mm is a sheet."""
    corners = np.array([(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)], float)
    sides = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    for height, sheet in ((0.3, False), (0.01, True)):
        box = meshes.Surface(corners * [0.3, 0.3, height], sides)
        assert meshes.midsurface.thickness(box) == pytest.approx(height if sheet else 0.0)


def test_a_file_cut_short_is_told(tmp_path):
    text = obj(TUBE)
    half = text[: text.index("\nf", int(0.93 * len(text)))]
    (tmp_path / "x.obj").write_text(half + "\n")
    told(tmp_path / "x.obj", "points belong to no face.*cut short")


AREA = 0.5590505
READ = {
    "ascii_crlf_upper.stl": 144,
    "binary_mixed.ply": 360,
    "continuation.obj": 72,
    "face_same_point_twice.obj": 72,
    "negative.obj": 72,
    "ngon.obj": 72,
    "trailing_comment.obj": 72,
    "tri_degenerate.obj": 144,
    "vertex_index.ply": 144,
    "zero_face.obj": 72,
}


@pytest.fixture
def cases():
    if not CASES.is_dir():
        pytest.skip("the inputs of shared/cases are not here")
    return CASES


@pytest.mark.parametrize("name", READ)
def test_shared_files_are_read(cases, name):
    surface = anyhow(cases / name)
    assert len(surface.cells) == READ[name] and len(surface.edges) == 2
    assert surface.area == pytest.approx(AREA, rel=1e-5)
    if "face" in name or "degenerate" in name:
        assert "1 face has less than three different corners" in surface.notes[0]


def test_shared_files_are_mended(cases):
    for name, key, value in (
        ("t_junction.obj", "weld", 1e-6),
        ("seam_split_off_0p1mm.obj", "weld", 4e-4),
        ("thick_closed.obj", "midsurface", True),
    ):
        assert any(f"{key}=" in note for note in anyhow(cases / name).notes)
        surface = anyhow(cases / name, **{key: value})
        assert len(surface.edges) == 2 and surface.area == pytest.approx(AREA, rel=5e-3)
        assert meshes.garments.prepare.pieces(surface.cells).max() == 0


def test_shared_glb_is_refused_in_one_sentence(cases):
    with pytest.raises(MeshError, match=r"^glb.glb: .*cut short.*export it again"):
        meshes.load(cases / "glb.glb")
