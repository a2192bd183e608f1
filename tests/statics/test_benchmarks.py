# SPDX-License-Identifier: LGPL-3.0-or-later
"""The static shell against exact solutions and published tables: every bar is one of accuracy.

Tables of Sze, Liu and Lo (Finite Elem. Anal. Des. 40, 2004) come through the fixture `paper_data`;
everything else is compared with a formula.
"""

import json

import numpy as np
import pytest

import meshes
from shellform import Fabric, Ply, Shell, Statics
from shellform.material.fabric import lamina_matrix

# the problems are in the units of their authors
pytestmark = pytest.mark.filterwarnings("ignore::shellform.material.fabric.UnitWarning")

PLAIN = {"membrane": "chords", "curvature": "plain"}
ELEMENTS = {"quad": (1, False), "triangle": (1, True), "nine nodes": (2, False)}


@pytest.fixture(scope="session")
def table(paper_data):
    """Function giving the published rows (k, columns) of a case by the start of its name."""
    cases = json.loads((paper_data / "shell_benchmarks.json").read_text())

    def rows(name):
        (case,) = [value for key, value in cases.items() if key.startswith(name)]
        return np.array(case["data"])

    return rows


def moved(shell, point):
    """Displacement of the node at a point."""
    return shell.displacements()[shell.partition.find(point)[0]]


def solved(shell, levels):
    """Load steps of a shell, after which PETSc's objects are freed."""
    statics = Statics(shell)
    try:
        statics.solve(levels)
    finally:
        statics.destroy()
    return statics


def rotation_about_z(degrees):
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


# --- a strip rolled up by an end moment -------------------------------------------------------

LENGTH, MODULUS = 12.0, 1.2e6


def keep_sides_in_plane(shell):
    """Long edges held in the plane of the roll, free to move within it."""
    for edge in ("bottom", "top"):
        shell.supports.symmetry(edge, (0.0, 1.0, 0.0))


def roll_up(cells, degree=1, thickness=0.01, turns=1, levels=20, in_plane=False, **options):
    """Tip error over length of a strip of unit width rolled into circles, and its load steps."""
    surface = meshes.rectangle(LENGTH, 1.0, (cells, 1), degree=degree)
    fabric = Fabric.isotropic(MODULUS, 0.0, thickness, 1000.0)
    shell = Shell(surface, fabric, **options)
    shell.supports.clamp("left")
    if in_plane:
        keep_sides_in_plane(shell)
    k = 2 * np.pi * turns / LENGTH
    shell.loads.edge_moment("right", (0.0, -k * fabric.bending[0, 0], 0.0))
    statics = solved(shell, levels)
    exact = np.array([np.sin(k * LENGTH) / k - LENGTH, 0.0, (1 - np.cos(k * LENGTH)) / k])
    return np.linalg.norm(moved(shell, (LENGTH, 0.0, 0.0)) - exact) / LENGTH, statics


def test_roll_up_converges_to_the_circle():
    """8, 16, 32 quads with arc lengths and turning angles: within 1.5 %, 0.12 %, 0.01 %."""
    errors = np.array([roll_up(cells)[0] for cells in (8, 16, 32)])
    assert np.all(errors <= [1.5e-2, 1.2e-3, 1e-4])
    # Two terms of the series of arc and angle are restored, so the order is nearer 6 (measured
    # 5.6) than the 4 of one term: only a floor is set. From 32 cells on what is left is the floor
    # (t kappa)^2/6 = 5e-6 of test_roll_up_at_any_thickness, so a second order is not taken.
    assert np.log2(errors[0] / errors[1]) >= 3.7


@pytest.mark.parametrize(
    ("cells", "degree", "options", "bar"),
    [(16, 1, PLAIN, 3e-2), (8, 2, {}, 5e-3), (16, 2, {}, 5e-4)],
    ids=["16 plain quads", "8 nine-node quads", "16 nine-node quads"],
)
def test_roll_up_by_other_elements(cells, degree, options, bar):
    """Plain quads and 9-node quads reach their bar too."""
    assert roll_up(cells, degree, **options)[0] <= bar


@pytest.mark.parametrize("ratio", [1e-2, 1e-3, 1e-4, 1e-5])
def test_roll_up_at_any_thickness(ratio):
    """Twenty steps of at most 6 Newton iterations from thickness/length 1e-2 to 1e-5."""
    error, statics = roll_up(16, thickness=ratio * LENGTH)
    assert statics.cutbacks == 0
    assert max(step.iterations for step in statics.steps) <= 6
    assert error <= 1.2e-3
    # Free of force, the mid-line strains by e = -(t kappa)^2/12; with the stretch 1 + e the moment
    # D kappa turns the tip by 2 pi (1 - 2 e): off the circle by (t kappa)^2/6. Less than 1e-4 is
    # the mesh's (3e-5 measured).
    kappa = 2 * np.pi / LENGTH
    assert error == pytest.approx((ratio * LENGTH * kappa) ** 2 / 6, abs=1e-4)


@pytest.mark.serial
@pytest.mark.slow
def test_roll_up_ten_turns():
    """Ten turns, 8 cells to a turn: converges, as near the circle as 8 cells must be in one turn.

    The long edges are kept in their plane: a free strip leaves it by lateral twist.
    """
    error, statics = roll_up(80, turns=10, levels=250, in_plane=True)
    print(f"\nten turns: tip error / length {error:.2e}, cut back {statics.cutbacks} times")
    assert statics.level == 1.0
    assert error <= 1.5e-2


# --- published tables -------------------------------------------------------------------------


def test_cantilever_under_end_shear(table):
    """Sze 3.1: the whole table within 1 % or its rounding, full load within 0.3 %."""
    rows = table("3.1")
    shell = Shell(meshes.rectangle(10.0, 1.0, (16, 1)), Fabric.isotropic(1.2e6, 0.0, 0.1, 1.0))
    shell.supports.clamp("left")
    shell.loads.line("right", (0.0, 0.0, 4.0))
    statics, found = Statics(shell), []
    for _ in statics.march(rows[:, 0]):
        u = moved(shell, (10.0, 0.0, 0.0))
        found.append((-u[0], u[2]))
    statics.destroy()
    off, rounding = np.abs(np.array(found) - rows[:, 1:]), 5e-4
    assert np.all(off <= np.maximum(0.01 * rows[:, 1:], rounding))
    assert np.all(off[-1] <= 3e-3 * rows[-1, 1:])


@pytest.mark.slow
def test_slit_annulus(table):
    """Sze 3.3: 40x5 9-node quads within 0.6 % at full load."""
    rows = table("3.3")
    surface = meshes.annulus(6.0, 10.0, (40, 5), degree=2)
    shell = Shell(surface, Fabric.isotropic(21e6, 0.0, 0.03, 1.0))
    shell.supports.clamp("start")
    shell.loads.line("end", (0.0, 0.0, 0.8))
    solved(shell, 12)
    # both lips lie on the x axis: tell the loaded one by its name
    lip = np.unique(surface.edges["end"])
    radius = np.linalg.norm(surface.points[lip], axis=1)
    corners = lip[[radius.argmin(), radius.argmax()]]
    assert shell.displacements()[corners, 2] == pytest.approx(rows[-1, 1:], rel=6e-3)


def hemisphere(cells, degree):
    """A quarter of the hemisphere with a hole of 18 degrees, pulled and pushed at its equator."""
    surface = meshes.spherical_cap(
        10.0, (np.radians(18), np.pi / 2), (0.0, np.pi / 2), (cells, cells), degree=degree
    )
    shell = Shell(surface, Fabric.isotropic(6.825e7, 0.3, 0.04, 1.0))
    shell.supports.symmetry("start", (0.0, 1.0, 0.0))
    shell.supports.symmetry("end", (1.0, 0.0, 0.0))
    shell.supports.hold((10 * np.sqrt(0.5), 10 * np.sqrt(0.5), 0.0), "z")
    # 400 on the whole, half of it on the quarter: two quarters meet at each corner
    shell.loads.point((10.0, 0.0, 0.0), (200.0, 0.0, 0.0))
    shell.loads.point((0.0, 10.0, 0.0), (0.0, -200.0, 0.0))
    return shell


@pytest.mark.slow
def test_hemisphere(table):
    """Sze 3.4: 16x16 9-node quads within 1.5 % in 5 steps and 30 iterations."""
    shell = hemisphere(16, 2)
    statics = solved(shell, 5)
    assert (len(statics.steps), statics.cutbacks) == (5, 0)
    assert sum(step.iterations for step in statics.steps) <= 30
    found = moved(shell, (10.0, 0.0, 0.0))[0], -moved(shell, (0.0, 10.0, 0.0))[1]
    assert found == pytest.approx(table("3.4")[-1, 1:], rel=1.5e-2)


def rising(level, deflection):
    """Rows of a load-deflection curve before it turns over steeply.

    From there on, until the steepest place is passed, the curve runs more than twice as steep as
    its secant from the origin: 1 % more load would be more than 2 % more deflection.
    """
    level, deflection = np.append(0.0, level), np.append(0.0, deflection)
    slope, secant = np.diff(deflection) / np.diff(level), deflection[1:] / level[1:]
    # the first step's slope is its secant
    steep = np.flatnonzero(slope > 2 * secant)
    end = min([*steep[:1], slope.argmax() + 1])
    return np.arange(end)


def semi_cylinder(fabric, cells=(16, 16)):
    """Half of Sze 3.7: clamped at the bottom, pinched at the free end's crown."""
    radius, length = 101.6, 304.8
    # plies are laid from the cylinder's axis; the crown is at 90 degrees
    surface = meshes.cylinder(
        radius, length, cells, angle=np.pi / 2, degree=2, warp=(0.0, 0.0, 1.0)
    )
    shell = Shell(surface, fabric)
    shell.supports.clamp("bottom")
    shell.supports.symmetry("end", (1.0, 0.0, 0.0))
    shell.supports.symmetry("start", (0.0, 1.0, 0.0))
    shell.loads.point((0.0, radius, length), (0.0, -1000.0, 0.0))
    return shell, (0.0, radius, length)


@pytest.mark.serial
@pytest.mark.slow
@pytest.mark.parametrize(
    ("column", "angles"), [(1, None), (2, (0, 90, 0)), (3, (90, 0, 90))],
    ids=["isotropic", "0-90-0", "90-0-90"],
)  # fmt: skip
def test_pinched_semi_cylinder(table, column, angles):
    """Sze 3.7: the rising branch within 2 %; the proof of plies and angles.

    With R = 101.6 the moduli are 2068.5 and 517.125; the tables' 2.0685e7 belongs to R = 1.016.
    """
    if angles is None:
        fabric = Fabric.isotropic(2068.5, 0.3, 3.0, 1.0)
    else:
        # the transverse modulus G23 follows from nu23 = 0.3: E_T / 2.6
        ply = Ply(2068.5, 517.125, 0.3, 795.6, 795.6, 517.125 / 2.6, 1.0)
        fabric = Fabric.laminate([(ply, 1.0, float(angle)) for angle in angles])
    rows = table("3.7")
    rows = rows[rising(rows[:, 0], rows[:, column])]
    shell, crown = semi_cylinder(fabric)
    statics, found = Statics(shell), []
    for _ in statics.march(rows[:, 0]):
        found.append(-moved(shell, crown)[1])
    statics.destroy()
    ratio = np.array(found) / rows[:, column] - 1
    print(f"\nsemi-cylinder {angles or 'isotropic'}: P/Pmax, deflection, table, difference")
    for level, here, there, off in zip(rows[:, 0], found, rows[:, column], ratio, strict=True):
        print(f"{level:8.3f} {here:9.3f} {there:9.3f} {100 * off:7.2f} %")
    assert np.abs(ratio).max() <= 0.02


# --- plates: locking by shear, bending stiffness ----------------------------------------------


def clamped_plate(cells, thickness, degree=1, triangles=False, amount=0.25, seed=1):
    """Centre deflection of a clamped unit plate under a small uniform load, over q L^4 / D."""
    parameters = meshes.distorted((cells, cells), amount, seed)
    parameters[cells // 2, cells // 2] = 0.5  # read at a node: no error of interpolation
    surface = meshes.rectangle(
        1.0, 1.0, (cells, cells), degree=degree, triangles=triangles, parameters=parameters
    )
    fabric = Fabric.isotropic(1e6, 0.3, thickness, 1.0)
    shell = Shell(surface, fabric)
    for edge in surface.edges:
        shell.supports.clamp(edge)
    # deflections of 1e-4 thicknesses: linear
    load = 0.1 * thickness**4
    shell.loads.surface((0.0, 0.0, load))
    solved(shell, 1)
    return moved(shell, (0.5, 0.5, 0.0))[2] * fabric.bending[0, 0] / load


@pytest.fixture(scope="module")
def converged_plate():
    """Deflection over q L^4/D by thickness: Kirchhoff's series if thin, else a fine mesh."""
    known = {1e-3: 0.00126532, 1e-4: 0.00126532}
    for thickness in (1e-1, 1e-2):
        coarse, fine = (clamped_plate(n, thickness, 2, amount=0.0) for n in (16, 32))
        assert coarse == pytest.approx(fine, rel=5e-4)  # fine enough for a bar of 5e-3
        known[thickness] = fine
    return known


# Measured: quads 0.15 to 0.20 %, 9-node quads up to 0.05 %, triangles 0.23 to 0.59 %, which is the
# price of their capped shear on this mesh (strains.shear_cap); it falls with the cells' size.
PLATES = {"quad": (32, 5e-3), "nine nodes": (16, 5e-3), "triangle": (32, 1e-2)}


@pytest.mark.parametrize("thickness", [1e-1, 1e-2, 1e-3, 1e-4])
@pytest.mark.parametrize("element", PLATES)
def test_distorted_clamped_plate(element, thickness, converged_plate):
    """Cells distorted by 25 % do not lock: within 0.5 % at any thickness, triangles within 1 %."""
    cells, bar = PLATES[element]
    deflection = clamped_plate(cells, thickness, *ELEMENTS[element])
    print(f"\n{element} t/L {thickness:g}: {deflection / converged_plate[thickness] - 1:+.2e}")
    assert deflection == pytest.approx(converged_plate[thickness], rel=bar)


def lean(cells, length, width):
    """Parameters whose lines a = const lean by 30 degrees in the middle of a rectangle."""
    return meshes.skewed(cells, np.tan(np.radians(30)) * width / length * cells[0])


def laid(length, width, cells, mesh, degree, triangles):
    """A rectangle with its warp along x, meshed and turned in one of several ways."""
    parameters = {
        "distorted": lambda: meshes.distorted(cells, 0.25, seed=5),
        "leaning": lambda: lean(cells, length, width),
    }.get(mesh, lambda: None)()
    surface = meshes.rectangle(
        length, width, cells, degree=degree, triangles=triangles, parameters=parameters,
        warp=(1.0, 0.0, 0.0),
    )  # fmt: skip
    turn = rotation_about_z(30.0 if mesh == "turned" else 0.0)
    return surface.transform(rotation=turn), turn


MESHES = ["aligned", "turned", "leaning", "distorted"]


def cloth_like(nu=0.25, thickness=1e-3):
    """Four times stiffer along the warp than the weft, soft in shear."""
    return Fabric.orthotropic(4e9, 1e9, nu, 3e8, 3e8, 3e8, thickness, 1000.0)


def simply_supported(element, mesh):
    """Deflection of a simply supported orthotropic plate over that of Navier's solution."""
    degree, triangles = ELEMENTS[element]
    a, b = 1.0, 0.8
    # triangles: 20 cells a side are 1.3 % too stiff on the worst mesh, 32 are 0.5 %
    n = {"quad": 20, "triangle": 32, "nine nodes": 10}[element]
    surface, turn = laid(a, b, (n, n), mesh, degree, triangles)
    fabric = cloth_like()
    shell = Shell(surface, fabric)
    for edge in surface.edges:
        along = turn[:, 1] if edge in ("left", "right") else turn[:, 0]
        shell.supports.hold(edge)
        shell.supports.hold_director(edge, plane=along)
    (D11, D12, _), (_, D22, _), (_, _, D66) = fabric.bending
    D = np.pi**4 * (D11 / a**4 + 2 * (D12 + 2 * D66) / (a * b) ** 2 + D22 / b**4)
    load = 1e-4 * fabric.thickness * D

    def sinus(points):
        x, y, _ = (points @ turn).T
        q = load * np.sin(np.pi * x / a) * np.sin(np.pi * y / b)
        return np.column_stack([0 * q, 0 * q, q])

    shell.loads.surface(sinus)
    solved(shell, 1)
    x, y, _ = (surface.points @ turn).T
    # the amplitude of the sinus by least squares over all nodes: no mesh has to meet the centre
    shape = np.sin(np.pi * x / a) * np.sin(np.pi * y / b)
    return (shape @ shell.displacements()[:, 2]) / (shape @ shape) * D / load


def cantilever(element, mesh, sides):
    """Tip deflection of a strip under end shear over that of the exact solution."""
    degree, triangles = ELEMENTS[element]
    length, width = 4.0, 1.0
    cells = (16, 4) if degree == 2 else (32, 8)
    surface, turn = laid(length, width, cells, mesh, degree, triangles)
    # free sides: contraction would curl the strip, so none; kept sides: cylindrical bending
    fabric = cloth_like(nu=0.25 if sides == "kept" else 0.0, thickness=1e-2)
    shell = Shell(surface, fabric)
    shell.supports.clamp("left")
    if sides == "kept":
        for edge in ("bottom", "top"):
            shell.supports.symmetry(edge, turn[:, 1])
    stiffness = fabric.bending[0, 0]
    load = 1e-4 * fabric.thickness * 3 * stiffness / length**3
    shell.loads.line("right", (0.0, 0.0, load))
    solved(shell, 1)
    tip = shell.displacements()[np.unique(surface.edges["right"]), 2]
    exact = load * length**3 / (3 * stiffness) + load * length / fabric.shear[0, 0]
    assert np.ptp(tip) <= 0.01 * exact
    return tip.mean() / exact


@pytest.mark.parametrize("mesh", MESHES)
@pytest.mark.parametrize("element", ELEMENTS)
def test_bending_stiffness_of_a_simply_supported_sheet(element, mesh):
    """D_effective/D = 1.00 +- 0.01 however the mesh is laid (Navier's orthotropic plate)."""
    ratio = 1 / simply_supported(element, mesh)
    print(f"\nsimply supported, {element}, {mesh}: D_effective/D = {ratio:.4f}")
    assert ratio == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("sides", ["kept", "free"])
@pytest.mark.parametrize("mesh", MESHES)
@pytest.mark.parametrize("element", ELEMENTS)
def test_bending_stiffness_of_a_cantilever(element, mesh, sides):
    """D_effective/D = 1.00 +- 0.01 however the mesh is laid, sides kept straight or free."""
    ratio = 1 / cantilever(element, mesh, sides)
    print(f"\ncantilever, sides {sides}, {element}, {mesh}: D_effective/D = {ratio:.4f}")
    assert ratio == pytest.approx(1.0, abs=0.01)


# --- folds across the mesh --------------------------------------------------------------------

FOLD_CELLS = (32, 4)
FOLD_MESHES = {
    "regular": lambda: None,
    "skewed": lambda: meshes.skewed(FOLD_CELLS, 1.0),
    "10 %": lambda: meshes.distorted(FOLD_CELLS, 0.10, seed=3),
    "25 %": lambda: meshes.distorted(FOLD_CELLS, 0.25, seed=3),
}


def woven(thickness):
    """In-plane shear 1/40 of tensile stiffness; bends alike in all directions."""
    membrane = thickness * lamina_matrix(MODULUS, MODULUS, 0.2, MODULUS / 40)
    bending = MODULUS * thickness**3 / 12 * np.diag([1.0, 1.0, 0.5])
    return Fabric.from_stiffness(membrane, bending, 1000 * thickness, thickness)


def fold(mesh, sharpness, triangles=False, yarns=None, **options):
    """Tip error over length, and rotation over exact, of a strip rolled once across its mesh.

    `sharpness` is kappa h^2 / t; `yarns` the angle of a woven sheet's warp, None: isotropic.
    """
    k = 2 * np.pi / LENGTH
    thickness = k * (LENGTH / FOLD_CELLS[0]) ** 2 / sharpness
    angle = np.radians(yarns or 0.0)
    surface = meshes.rectangle(
        LENGTH, 1.0, FOLD_CELLS, triangles=triangles, parameters=FOLD_MESHES[mesh](),
        warp=(np.cos(angle), np.sin(angle), 0.0),
    )  # fmt: skip
    if yarns is None:
        fabric = Fabric.isotropic(MODULUS, 0.0, thickness, 1000.0)
    else:
        fabric = woven(thickness)
    shell = Shell(surface, fabric, **options)
    shell.supports.clamp("left")
    keep_sides_in_plane(shell)
    # bending is the same in all directions: no angle enters the moment
    shell.loads.edge_moment("right", (0.0, -k * fabric.bending[0, 0], 0.0))
    solved(shell, 20)
    exact = np.array([np.sin(k * LENGTH) / k - LENGTH, 0.0, (1 - np.cos(k * LENGTH)) / k])
    error = np.linalg.norm(moved(shell, (LENGTH, 0.0, 0.0)) - exact) / LENGTH
    side = np.unique(surface.edges["bottom"])
    d = shell.directors()[side[np.argsort(surface.points[side, 0])]]
    turned = np.unwrap(np.arctan2(-d[:, 0], d[:, 2]))[-1]
    return error, turned / (2 * np.pi)


@pytest.mark.serial
@pytest.mark.slow
@pytest.mark.parametrize("triangles", [False, True], ids=["quad", "triangle"])
@pytest.mark.parametrize("sharpness", [7, 74])
@pytest.mark.parametrize("mesh", FOLD_MESHES)
def test_fold_across_the_mesh(mesh, sharpness, triangles):
    """Tip within 1 %, rotation within 1 %, whatever lines the fold crosses."""
    error, rotation = fold(mesh, sharpness, triangles)
    assert error <= 0.01
    assert rotation == pytest.approx(1.0, abs=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("yarns", [0, 22, 45])
def test_fold_of_woven_cloth(yarns):
    """The same for cloth soft in shear, folded along and across its yarns."""
    error, rotation = fold("25 %", 74, yarns=yarns)
    assert error <= 0.01
    assert rotation == pytest.approx(1.0, abs=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("triangles", [False, True], ids=["quad", "triangle"])
def test_chords_lock_where_arcs_do_not(triangles):
    """The fold test tells the two apart: chords turn by less than three quarters."""
    error, rotation = fold("25 %", 74, triangles, **PLAIN)
    assert error > 0.1
    assert rotation < 0.75
