# SPDX-License-Identifier: LGPL-3.0-or-later
"""Surfaces from files and into files."""

import numpy as np
import pytest

import meshes
from meshes import MeshError
from tests.meshes.measures import SQUARE, TWO, euler, facing

FORMATS = ("msh", "vtu", "vtk", "obj", "stl", "ply")


def samples():
    quads = meshes.cylinder(0.2, 1.0, (12, 4), angle=5.0)
    return {
        "quads": quads.replace(panels={"front": [0, 1], "back": np.arange(6, 48)}),
        "triangles": meshes.cylinder(0.2, 1.0, (12, 4), triangles=True),
        "curved": meshes.annulus(0.1, 0.2, (12, 2), degree=2),
    }


def by_place(surface):
    """Cells as sorted corner coordinates and their normals, whatever the numbering."""
    centres = surface.points[surface.cells].mean(axis=1)
    order = np.lexsort(np.round(centres, 9).T)
    return centres[order], facing(surface)[order]


@pytest.mark.parametrize("kind", FORMATS)
@pytest.mark.parametrize("name", ["quads", "triangles", "curved"])
def test_round_trip(tmp_path, name, kind, capfd):
    surface = samples()[name]
    path = tmp_path / f"{name}.{kind}"
    if name == "curved" and kind in ("obj", "stl", "ply"):
        with pytest.raises(MeshError, match=f"curved.{kind}: .* no curved cells"):
            meshes.save(surface, path)
        return
    meshes.save(surface, path)
    assert [p.name for p in tmp_path.iterdir()] == [path.name]
    back = meshes.load(path)
    assert back.source == path.name
    expected = (
        meshes.to_triangles(surface, "shortest") if kind == "stl" and name == "quads" else surface
    )
    for got, wanted in zip(by_place(back), by_place(expected)):
        assert np.allclose(got, wanted, atol=1e-12)
    if kind != "stl":
        assert np.array_equal(back.cells, surface.cells)
        assert np.allclose(back.points, surface.points, rtol=0, atol=1e-15)
    if kind in ("msh", "vtu", "vtk", "ply"):
        assert np.allclose(back.directors, surface.directors, atol=1e-14)
    if kind in ("msh", "vtu", "vtk"):
        for got, wanted in ((back.edges, surface.edges), (back.panels, surface.panels)):
            assert set(got) == set(wanted)
            assert all(np.array_equal(got[key], wanted[key]) for key in wanted)
    else:
        loops = meshes.boundary_loops(surface)
        assert list(back.edges) == [f"boundary_{k}" for k in range(len(loops))]
        assert [len(e) for e in back.edges.values()] == [len(loop) for loop in loops]
    assert capfd.readouterr() == ("", "")


def test_warp_and_overlapping_panels(tmp_path):
    surface = meshes.rectangle(0.5, 0.5, (3, 3), warp=(1, 0, 0))
    surface = surface.replace(panels={"a": [0, 1], "b": [1, 2]})
    meshes.save(surface, tmp_path / "x.vtu")
    back = meshes.load(tmp_path / "x.vtu")
    assert np.array_equal(back.warp, np.tile([1.0, 0, 0], (9, 1)))
    assert {k: v.tolist() for k, v in back.panels.items()} == {"a": [0, 1], "b": [1, 2]}
    with pytest.warns(UserWarning, match="keep no warp"):
        with pytest.raises(MeshError, match="panel 'b' shares cells"):
            meshes.save(surface, tmp_path / "x.msh")
    both = surface.replace(panels={"left": [0]}, warp=None)
    with pytest.raises(MeshError, match="'left' names both"):
        meshes.save(both, tmp_path / "x.msh")
    assert not (tmp_path / "x.msh").exists()
    with pytest.raises(MeshError, match=r"unknown file type '.doc'"):
        meshes.save(surface, tmp_path / "x.doc")


def test_save_is_all_or_nothing(tmp_path, monkeypatch):
    meshio = pytest.importorskip("meshio")
    path = tmp_path / "x.vtu"
    meshes.save(meshes.rectangle(0.5, 0.5, (2, 2)), path)
    before = path.read_bytes()
    # Whoever has the old file open keeps reading the old file.
    with open(path, "rb") as reader:
        meshes.save(meshes.rectangle(0.5, 0.5, (4, 4)), path)
        assert reader.read() == before != path.read_bytes()
    before = path.read_bytes()

    def fail(name, *rest, **options):
        open(name, "w").close()
        raise OSError("disk full")

    monkeypatch.setattr(meshio, "write", fail)
    with pytest.raises(OSError, match="disk full"):
        meshes.save(meshes.rectangle(0.5, 0.5, (3, 3)), path)
    assert path.read_bytes() == before and len(list(tmp_path.iterdir())) == 1


MIXED = """v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\nv 9 9 9
f 1 2 5 4\nf 2 3 5\nf 3 6 5\n"""


def test_load_mixed_cells(tmp_path):
    path = tmp_path / "mixed.obj"
    path.write_text(MIXED)
    surface = meshes.load(path)
    assert surface.kind == "quadrilateral" and len(surface.cells) == 4 + 3 + 3
    assert surface.area == pytest.approx(2.0) and euler(surface) == 1
    assert surface.bounds[1].max() == 2.0
    assert list(surface.edges) == ["boundary_0"] and len(surface.edges["boundary_0"]) == 12


def test_load_obj_of_a_drawing_program(tmp_path):
    text = "mtllib m\no shirt\n" + "".join(f"v {x} {y} 0 0.5 0.5 0.5\n" for x, y, _ in SQUARE)
    text += "vt 0 0\nvt 1 1\nvn 0 0 1\ng front\nusemtl m\nf 1/1/1 2/2/1 5/1/1 4/2/1\n"
    text += "g back\nf 2/1/1 3/2/1 6/2/1 5/1/1\n"
    (tmp_path / "x.obj").write_text(text)
    surface = meshes.load(tmp_path / "x.obj")
    assert np.array_equal(surface.points, SQUARE) and np.array_equal(surface.cells, TWO)
    assert {k: v.tolist() for k, v in surface.panels.items()} == {"front": [0], "back": [1]}
    (tmp_path / "y.obj").write_text(text.replace("g back", "g front"))
    assert meshes.load(tmp_path / "y.obj").panels["front"].tolist() == [0, 1]
    (tmp_path / "z.obj").write_text(text.replace("g front", "").replace("g back", ""))
    assert meshes.load(tmp_path / "z.obj").panels["shirt"].tolist() == [0, 1]


def test_load_units_and_triangles(tmp_path):
    path = tmp_path / "t.obj"
    path.write_text("v 0 0 0\nv 800 0 0\nv 0 500 0\nf 1 2 3\n")
    assert meshes.load(path, unit="mm").area == pytest.approx(0.2)
    with pytest.warns(UserWarning, match=r"t.obj: read in 'm', .* 943 m .*unit='mm'"):
        meshes.load(path)
    path.write_text("v 0 0 0\nv 4 0 0\nv 0 5 0\nf 1 2 3\n")
    assert meshes.load(path, unit="in").area == pytest.approx(10 * 0.0254**2)
    assert meshes.load(path, unit="cm").kind == "triangle"
    split = meshes.load(path, unit="cm", quads="split")
    assert split.kind == "quadrilateral" and len(split.cells) == 3
    with pytest.warns(UserWarning, match="measures 0.0064"):
        meshes.load(path, unit="mm")
    with pytest.raises(ValueError, match="unit must be one of m, cm, mm, in"):
        meshes.load(path, unit="ft")
    with pytest.raises(ValueError, match="quads"):
        meshes.load(path, quads=True)


def test_load_turns_cells(tmp_path):
    path = tmp_path / "flip.obj"
    path.write_text(MIXED.replace("f 3 6 5", "f 3 5 6").replace("v 9 9 9", ""))
    with pytest.warns(UserWarning, match="flip.obj: 3 of 10 cells faced the other side"):
        surface = meshes.load(path)
    assert np.all(facing(surface)[:, 2] > 0)


@pytest.mark.parametrize(
    "name, text, words",
    [
        ("a.obj", "v 0 0 0\nv 1 0 0\nv 0 nan 0\nf 1 2 3\n", "point 2 .*finite"),
        ("b.obj", "v 0 0 0\nv 1 0 0\n", "no triangles or quads"),
        ("c.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 7\n", "cell 0 .* 0 to 2"),
        ("d.vtu", "not a mesh", "cannot be read as .vtu"),
        ("e.msh", "not a mesh", "cannot be read as .msh"),
        ("f.msh", "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 9", "f.msh: "),
        ("g.stl", "", "g.stl: "),
        ("h.ply", "ply\nformat strange 1.0\n", "cannot be read as .ply"),
        ("i.step", "ISO-10303-21;", "unknown file type '.step'"),
        ("j.obj", "v 0 0 0\nv 1 1 0\nv 1 0 0\nv 0 1 0\nv 0.5 2 0\nf 1 2 3 4 5\n", "crosses itself"),
    ],
)
def test_load_refuses(tmp_path, name, text, words, capfd):
    (tmp_path / name).write_text(text)
    with pytest.raises(MeshError, match=words) as caught:
        meshes.load(tmp_path / name)
    assert str(caught.value).startswith(f"{name}: ") and "\n" not in str(caught.value)
    assert capfd.readouterr() == ("", "")


def test_load_missing_file(tmp_path):
    with pytest.raises(MeshError, match=r"shirt.vtu: there is no such file"):
        meshes.load(tmp_path / "shirt.vtu")


def test_load_mixed_with_curved(tmp_path):
    meshio = pytest.importorskip("meshio")
    panel = meshes.rectangle(0.5, 0.5, (2, 1), degree=2)
    cells = [("quad9", panel.cells[:1]), ("quad", panel.cells[1:, :4])]
    meshio.write_points_cells(tmp_path / "x.vtu", panel.points, cells)
    with pytest.raises(MeshError, match=r"x.vtu: 9-node quads are mixed"):
        meshes.load(tmp_path / "x.vtu")


def test_load_leaves_out_stray_segments(tmp_path):
    meshio = pytest.importorskip("meshio")
    panel = meshes.rectangle(0.5, 0.5, (2, 2))
    cells = [("quad", panel.cells), ("line", [[0, 1], [0, 8]])]
    flags = {"edge:hem": [np.zeros(4, dtype=int), np.ones(2, dtype=int)]}
    meshio.write_points_cells(tmp_path / "x.vtu", panel.points, cells, cell_data=flags)
    with pytest.warns(UserWarning, match=r"x.vtu: 1 segments of 'hem' lie along no side"):
        surface = meshes.load(tmp_path / "x.vtu")
    assert np.array_equal(surface.edges["hem"], [[0, 1]])


def test_load_straightens_quadratic_triangles(tmp_path):
    meshio = pytest.importorskip("meshio")
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.5, 0, 0], [0.5, 0.5, 0], [0, 0.5, 0.0]])
    meshio.write_points_cells(tmp_path / "x.vtu", points, [("triangle6", [[0, 1, 2, 3, 4, 5]])])
    with pytest.warns(UserWarning, match="triangle6 cells are straightened"):
        surface = meshes.load(tmp_path / "x.vtu")
    assert len(surface.points) == 3 and surface.kind == "triangle"


def test_load_stl_joins_points(tmp_path):
    # Single precision: the shared corner differs in its last digit between the two facets.
    text = "solid\n"
    for facet in (
        ["0 0 0", "1 0 0", "0.3333333 1 0"],
        ["1 0 0", "1.3333333 1 0", "0.33333334 1 0"],
    ):
        text += "facet normal 0 0 1\nouter loop\n"
        text += "".join(f"vertex {vertex}\n" for vertex in facet)
        text += "endloop\nendfacet\n"
    (tmp_path / "x.stl").write_text(text + "endsolid\n")
    surface = meshes.load(tmp_path / "x.stl")
    assert len(surface.points) == 4 and len(surface.edges["boundary_0"]) == 4


@pytest.mark.parametrize("version", [2.2, 4.1])
@pytest.mark.parametrize("save_all", [0, 1])
def test_physical_groups_of_gmsh(tmp_path, version, save_all):
    gmsh = pytest.importorskip("gmsh")
    path = str(tmp_path / "groups.msh")
    gmsh.initialize([], False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        geo = gmsh.model.geo
        corners = [(0, 0), (1, 0), (2, 0), (2, 1), (1, 1), (0, 1)]
        tags = [geo.addPoint(x, y, 0.0, 0.4) for x, y in corners]
        lines = [geo.addLine(tags[i], tags[(i + 1) % 6]) for i in range(6)]
        seam = geo.addLine(tags[1], tags[4])
        one = geo.addPlaneSurface([geo.addCurveLoop([lines[0], seam, lines[4], lines[5]])])
        two = geo.addPlaneSurface([geo.addCurveLoop([lines[1], lines[2], lines[3], -seam])])
        geo.synchronize()

        def group(dim, members, name):
            gmsh.model.setPhysicalName(dim, gmsh.model.addPhysicalGroup(dim, members), name)

        group(1, lines[:2], "hem")
        group(1, [seam], "seam")
        group(2, [one], "front")
        group(2, [one, two], "all")
        gmsh.model.mesh.generate(2)
        gmsh.option.setNumber("Mesh.MshFileVersion", version)
        gmsh.option.setNumber("Mesh.SaveAll", save_all)
        gmsh.write(path)
    finally:
        gmsh.finalize()
    surface = meshes.load(path)
    assert surface.area == pytest.approx(2.0) and euler(surface) == 1
    if version == 2.2 and save_all:
        # gmsh itself leaves the groups out of such a file.
        assert list(surface.edges) == ["boundary_0"]
        return
    assert set(surface.edges) == {"hem", "seam"}
    assert np.all(surface.points[surface.edges["hem"], 1] == 0.0)
    assert np.all(surface.points[surface.edges["seam"], 0] == 1.0)
    ends = surface.points[surface.edges["hem"][[0, -1], [0, 1]], 0]
    assert set(ends) == {0.0, 2.0}
    if version == 2.2 or save_all:
        assert set(surface.panels) == {"front", "all"}
        assert len(surface.panels["all"]) == len(surface.cells)
    assert surface.cell_areas[surface.panels["front"]].sum() == pytest.approx(1.0)
