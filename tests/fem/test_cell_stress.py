# SPDX-License-Identifier: LGPL-3.0-or-later
"""Measured curves and friction inside the cloth: what comes out is what was put in."""

from petsc4py import PETSc

import numpy as np
import pytest
from scipy.integrate import trapezoid

import meshes
from shellform import Fabric, Shell
from shellform.fem.director import rotation_matrix
from shellform.fem.internal_force import InternalForce
from shellform.material.curve import Curve
from shellform.material.friction import ClothFriction, follow
from shellform.material.loops import CLOSED, FIT
from shellform.material.measured import Measured
from shellform.material.measurements import measured_fabric
from tests.fem.test_shell import deform, dome, owned

pytestmark = pytest.mark.serial  # ranks are in tests/dynamics/test_cloth_friction_on_ranks.py

WARP = Curve((0, 0.01, 0.03, 0.05, 0.08), (0, 2, 12, 60, 300.0), False)
WEFT = Curve((0, 0.02, 0.05, 0.10), (0, 2, 20, 120.0), False)
SHEAR = Curve((0, 0.1, 0.3, 0.5, 0.6), (0, 5, 16, 60, 200.0), True)
BEND = Curve((0, 20, 80, 250.0), (0, 2.6e-4, 9e-4, 2.2e-3), True)
BEND_WEFT = Curve((0, 10, 60, 200.0), (0, 8e-5, 4e-4, 1.1e-3), True)
COUPLING = Curve((0, 0.02, 0.05, 0.1), (0, 0.3, 1.2, 4.0), False)
LAW = Measured(WARP, WEFT, SHEAR, BEND, None, COUPLING)
B = 1e-5
SHEETS = ["quads", pytest.param("triangles", marks=pytest.mark.thorough)]
KINDS = {"quads": (1, False), "triangles": (1, True), "nine nodes": (2, False)}
FRICTION = ClothFriction(
    tension_warp=[(3000.0, 0.0, 150.0)],
    tension_weft=[(2000.0, 0.4, 60.0)],
    shear=[(60.0, 0.5, 8.5), (200.0, 0.3)],
    bend_warp=[(6e-5, 3e-4), (2e-5, 4e-4)],
    bend_weft=[(5e-5, 2.4e-4)],
    twist=[(3e-5, 1e-4)],
)


def sheet(law=LAW, friction=None):
    slopes = (WARP.at_rest, WEFT.at_rest, SHEAR.at_rest) if law else (200.0, 100.0, 50.0)
    A = np.diag(slopes)
    A[0, 1] = A[1, 0] = COUPLING.at_rest if law is LAW else 0.0
    bending = [B if law is None or c is None else c.at_rest for c in (law or LAW).curves[3:5]]
    D = np.diag([*bending, 0.6 * B])
    return Fabric.from_stiffness(A, D, 0.2, 5e-4).with_law(law).with_friction(friction)


def static_force(shell):
    """Owned forces (n, 6) that Newton's method sees."""
    field = shell.partition.petsc_vector(6)
    shell.internal_force(field)
    field.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)
    return field.array.reshape(-1, 6).copy()


def square(kind, angle, fabric, cells, bent=False):
    """A unit square of irregular cells, its warp at an angle [deg] from the mesh's first axis.

    The square lies turned so that the warp is along x.
    """
    degree, triangles = KINDS[kind]
    turn = np.radians(angle)
    # nine-node quads are exact for a uniform strain on regular cells only
    parameters = meshes.distorted(cells, 0.2, seed=1) if degree == 1 and cells[0] > 1 else None
    surface = meshes.rectangle(
        1.0, 1.0, cells, degree=degree, triangles=triangles, parameters=parameters
    )
    c, s = np.cos(turn), np.sin(turn)
    surface = surface.transform(np.array([[c, s, 0], [-s, c, 0], [0, 0, 1.0]]))
    return Shell(surface.replace(warp=(1.0, 0.0, 0.0)), fabric)


def power(shell, rates):
    """Power [W] of the internal forces at rates (n_owned, 6)."""
    return shell.comm.allreduce(np.vdot(static_force(shell), rates))


def move(shell, F):
    """Deform a flat sheet homogeneously; the field's change with F is linear."""
    X = shell.surface.points[shell.partition.nodes]
    owned(shell)[:, :3] = X @ (F - np.eye(3)).T


@pytest.mark.parametrize("kind", [*SHEETS, "nine nodes"])
@pytest.mark.parametrize("angle", [0.0, 90.0, 30.0])
@pytest.mark.parametrize("cells", [(1, 1), (8, 8)])
def test_tension_and_shear_curves_come_out(kind, angle, cells):
    """The load on an element of cloth, as the work it does, is that of the curve."""
    shell = square(kind, angle, sheet(), cells)
    n = shell.partition.n_owned
    X = shell.surface.points[shell.partition.nodes][:n]

    def load(F, dF):
        move(shell, F)
        return power(shell, np.hstack([X @ dF.T, 0 * X]))

    for x in (0.005, 0.02, 0.06, 0.09):
        for axis, curve in ((0, WARP), (1, WEFT)):
            F, dF = np.eye(3), np.zeros((3, 3))
            F[axis, axis], dF[axis, axis] = 1 + x, 1.0
            assert load(F, dF) == pytest.approx(curve(x), rel=1e-9)
    for x in (0.01, 0.04, 0.08):
        F, dF = np.diag([1 + x, 1 + x, 1.0]), np.diag([1.0, 0.0, 0.0])
        assert load(F, dF) == pytest.approx(WARP(x) + COUPLING(x), rel=1e-9)
    for gamma in (-0.4, 0.05, 0.2, 0.55):
        # yarns keep their length: the weft turns by gamma
        F = np.array([[1, np.sin(gamma), 0], [0, np.cos(gamma), 0], [0, 0, 1.0]])
        dF = np.array([[0, np.cos(gamma), 0], [0, -np.sin(gamma), 0], [0, 0, 0.0]])
        assert load(F, dF) == pytest.approx(SHEAR(gamma), rel=1e-9)


def roll(shell, curvature, along=0):
    """Roll a flat sheet along x or y; returns its rates by the curvature."""
    X = shell.surface.points[shell.partition.nodes]
    rates = np.zeros((len(X), 6))
    w = owned(shell)
    h = 1e-6 * max(abs(curvature), 1.0)
    states = []
    for k in (curvature - h, curvature + h, curvature):
        s = X[:, along]
        w[:, :] = 0.0
        phi = k * s
        # sin(phi)/k and (1 - cos(phi))/k, also of a flat one
        w[:, along] = s * np.sinc(phi / np.pi) - s
        w[:, 2] = -s * 0.5 * phi * np.sinc(0.5 * phi / np.pi) ** 2
        w[:, 3 + along], w[:, 5] = np.sin(phi), np.cos(phi)
        states.append(w.copy())
    rates = (states[1] - states[0]) / (2 * h)
    return rates[: shell.partition.n_owned]


def small_square(kind, angle, fabric, cells, size):
    """A square whose warp lies along x, at an angle [deg] from the mesh's first axis."""
    degree, triangles = KINDS[kind]
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    surface = meshes.rectangle(size, size, cells, degree=degree, triangles=triangles)
    surface = surface.transform(np.array([[c, s, 0], [-s, c, 0], [0, 0, 1.0]]))
    return Shell(surface.replace(warp=(1.0, 0.0, 0.0)), fabric)


@pytest.mark.parametrize("kind", SHEETS)
@pytest.mark.parametrize("angle", [0.0, 90.0, 30.0])
@pytest.mark.parametrize("cells", [(1, 1), (8, 8)])
def test_bending_curves_come_out(kind, angle, cells):
    """Rolled along warp and weft; cells turn by up to 0.06 rad."""
    law = Measured(bend_warp=BEND, bend_weft=BEND_WEFT)
    shell = small_square(kind, angle, sheet(law), cells, 1.25e-3 * cells[0])
    area = shell.surface.area
    for curvature in (-30.0, 10.0, 45.0):
        for along, curve in enumerate((BEND, BEND_WEFT)):
            moment = power(shell, roll(shell, curvature, along)) / area
            assert moment == pytest.approx(curve(curvature), rel=1e-3)


@pytest.mark.parametrize("kind", SHEETS)
def test_bending_without_a_curve_stays_quadratic(kind):
    shell = small_square(kind, 30.0, sheet(Measured(bend_warp=BEND)), (1, 1), 1.25e-3)
    moment = power(shell, roll(shell, 30.0, along=1)) / shell.surface.area
    assert moment == pytest.approx(B * 30.0, rel=1e-3)


BENT = Measured(bend_warp=BEND)
PAIRS = [
    *(("quads", *p, {}) for p in ((LAW, None), (None, FRICTION), (LAW, FRICTION))),
    *(pytest.param("triangles", *p, {}, marks=pytest.mark.thorough) for p in
      ((LAW, None), (None, FRICTION))),
    pytest.param("triangles", LAW, FRICTION, {}, marks=pytest.mark.thorough),
    ("quads", BENT, FRICTION, {"wrinkles": "relaxed"}),
]  # fmt: skip


@pytest.mark.parametrize("kind, law, friction, options", PAIRS)
def test_explicit_and_static_forces_agree(kind, law, friction, options):
    """C against UFL, with sliders that have slipped, and both are turned with the sheet."""
    shell = Shell(dome(*KINDS[kind], cells=(3, 2)), sheet(law, friction), **options)
    force, w = InternalForce(shell), owned(shell)
    deform(shell, size=0.03, seed=1)
    shell.keep_slips()
    deform(shell, size=0.04)
    wanted = static_force(shell)
    n, largest = shell.partition.n_owned, np.abs(wanted).max()
    got = force(w)[:n].copy()
    assert np.abs(got - wanted).max() < 1e-10 * largest
    # asked again, nothing slips further
    assert np.abs(force(w)[:n] - got).max() < 1e-12 * largest
    R = rotation_matrix([0.4, -2.1, 1.7])
    x = shell.surface.points[shell.partition.nodes] - shell.partition.origin
    w[:, :3], w[:, 3:] = (x + w[:, :3]) @ R.T - x, w[:, 3:] @ R.T
    turned = np.hstack([got[:, :3] @ R.T, got[:, 3:] @ R.T])
    assert np.abs(force(w)[:n] - turned).max() < 1e-9 * largest


NINE = pytest.param("nine nodes", None, marks=pytest.mark.slow)  # half a minute to compile
TRIANGLES = pytest.param("triangles", FRICTION, marks=pytest.mark.thorough)


@pytest.mark.parametrize("kind, friction", [("quads", FRICTION), TRIANGLES, NINE])
def test_tangent_is_the_derivative(kind, friction):
    """Of the static force with curves and sliders that slip and stick, by differences."""
    shell = Shell(dome(*KINDS[kind], cells=(2, 2)), sheet(LAW, friction))
    deform(shell, size=0.03, seed=1)
    shell.keep_slips()
    deform(shell, size=0.04)
    w, n = owned(shell), shell.partition.n_owned
    here = w.copy()
    whole = np.random.default_rng(3).standard_normal((len(shell.surface.points), 6))
    way = whole[shell.partition.nodes] * [1, 1, 1, 0.1, 0.1, 0.1]
    matrix = shell.create_tangent()
    shell.tangent(matrix)
    matrix.assemble()
    direction = shell.partition.petsc_vector(6)
    product = direction.duplicate()
    direction.setArray(way[:n].ravel())
    matrix.mult(direction, product)
    sides = []
    for sign in (1, -1):
        w[:] = here + sign * 1e-8 * way
        sides.append(static_force(shell))
    change = (sides[0] - sides[1]).ravel() / 2e-8
    total = shell.comm.allreduce
    gap, size = total(np.sum((change - product.array) ** 2)), total(np.sum(product.array**2))
    assert np.sqrt(gap / size) < 1e-6


CYCLES = {
    "shear": (lambda x: np.array([[1, x, 0], [0, np.sqrt(1 - x * x), 0], [0, 0, 1.0]]), 0.2),
    "tension_warp": (lambda x: np.diag([np.sqrt(1 + 2 * x), 1.0, 1.0]), 0.05),
    "tension_weft": (lambda x: np.diag([1.0, np.sqrt(1 + 2 * x), 1.0]), 0.05),
}


@pytest.mark.parametrize("kind", SHEETS)
@pytest.mark.parametrize("cells", [(1, 1), (8, 8)])
@pytest.mark.parametrize("angle", [0.0, 90.0, 30.0])
@pytest.mark.parametrize("what", CYCLES)
def test_loops_in_the_plane(kind, cells, angle, what):
    """What is lost in a closed cycle is the area of the loop that the elements draw."""
    shell = square(kind, angle, sheet(None, FRICTION), cells)
    shape, most = CYCLES[what]
    elements = getattr(FRICTION, what)
    steps = np.linspace(0, 1, 41)
    low = -most if what == "shear" else 0.0
    cycle = np.concatenate(
        [most * steps, most + (low - most) * steps[1:], low + (most - low) * steps[1:]]
    )
    force, n = InternalForce(shell), shell.partition.n_owned
    lost = []
    for x in cycle:
        move(shell, shape(x))
        force(owned(shell))[:n].copy()
        lost.append(shell.friction_loss())
    # in a closed cycle what is lost is the area of the loop: exact trapezoids of fine steps
    fine = np.interp(np.linspace(0, 2, 60_001), np.linspace(0, 2, 81), cycle[40:])
    start = np.concatenate([np.linspace(0, most, 2001), fine])
    area = sum(trapezoid(follow(element, start)[2001:], fine) for element in elements)
    assert lost[-1] - lost[40] == pytest.approx(area, rel=1e-6)
    stored = sum(follow(one, cycle)[-1] ** 2 / (2 * one[0]) for one in elements)
    assert shell.energy()["friction"] == pytest.approx(stored, rel=1e-9, abs=1e-15)


LOOPS = {
    "stretch_warp": [0, 0.01, 0.02, 0.03, 0.04],
    "load_warp_N_per_m": [0, 8, 20, 60, 150.0],
    "unload_warp_N_per_m": [0, 5.4, 13.5, 47, 150.0],
    "stretch_weft": [0, 0.02, 0.04, 0.06],
    "load_weft_N_per_m": [0, 20, 50, 140.0],
    "unload_weft_N_per_m": [0, 14, 36, 140.0],
    "angle_degrees": [0, 0.5, 2, 5, 8],
    "shear_load_N_per_m": [0, 0.9, 2.5, 5.6, 9.0],
    "shear_unload_N_per_m": [-0.8, -0.6, 0.8, 3.6, 9.0],
    "B_warp_uN_m": 13.0, "B_weft_uN_m": 9.0, "weight_g_per_m2": 260, "thickness_mm": 0.7,
}  # fmt: skip
BRANCHES = {"stretch_warp": "load_warp_N_per_m", "stretch_weft": "load_weft_N_per_m",
            "angle_degrees": "shear_load_N_per_m"}  # fmt: skip


@pytest.mark.parametrize("what", BRANCHES)
@pytest.mark.parametrize(
    "kind, angle", [("quads", 0.0), ("quads", 90.0), ("quads", 30.0), ("triangles", 30.0)]
)
@pytest.mark.parametrize("cells", [(1, 1), (8, 8)])
def test_measured_loops_come_out_of_a_sheet(kind, what, angle, cells):
    """Up through the points of a card to 0.1 %; down as near as its sliders were fitted."""
    shell = square(kind, angle, measured_fabric(LOOPS), cells)
    force, n = InternalForce(shell), shell.partition.n_owned
    X = shell.surface.points[shell.partition.nodes][:n]
    unit = np.pi / 180 if what == "angle_degrees" else 1.0
    x = np.array(LOOPS[what]) * unit
    axis = 1 if what == "stretch_weft" else 0

    def shape(s):
        F, dF = np.eye(3), np.zeros((3, 3))
        if what == "angle_degrees":
            F[:2, 1], dF[:2, 1] = (np.sin(s), np.cos(s)), (np.cos(s), -np.sin(s))
        else:
            F[axis, axis], dF[axis, axis] = 1 + s, 1.0
        return F, dF

    fine = np.unique(np.concatenate([np.linspace(0, x[-1], 60), x]))
    loads = []
    for s in np.concatenate([fine, fine[-2::-1]]):
        F, dF = shape(s)
        move(shell, F)
        r = force(owned(shell))[:n]
        loads.append(shell.comm.allreduce(np.vdot(r[:, :3], X @ dF.T)))
    up, down = np.array(loads[: len(fine)]), np.array(loads[len(fine) - 1 :][::-1])
    at = np.searchsorted(fine, x)
    wanted = np.array(LOOPS[BRANCHES[what]])
    np.testing.assert_allclose(up[at], wanted, rtol=1e-3, atol=1e-9)
    back = np.array(LOOPS[BRANCHES[what].replace("load", "unload")])
    assert np.abs(down[at] - back).max() <= max(FIT * (wanted - back).max(), CLOSED * wanted[-1])


def twist(shell, by):
    """Bend a flat sheet into z = -by x y; no yarn is bent along itself, nearly."""
    X, w = shell.surface.points[shell.partition.nodes], owned(shell)
    w[:, :3], w[:, 2] = 0.0, -by * X[:, 0] * X[:, 1]
    normals = np.stack([by * X[:, 1], by * X[:, 0], np.ones(len(X))], axis=1)
    w[:, 3:] = normals / np.linalg.norm(normals, axis=1, keepdims=True)


BENT_BY = {
    "bend_warp": lambda shell, k: roll(shell, k, 0),
    "bend_weft": lambda shell, k: roll(shell, k, 1),
    "twist": lambda shell, k: twist(shell, 0.5 * k),
}


@pytest.mark.parametrize("kind", SHEETS)
@pytest.mark.parametrize("angle", [0.0, 90.0, 30.0])
@pytest.mark.parametrize("cells", [(1, 1), (8, 8)])
@pytest.mark.parametrize("what", BENT_BY)
def test_bending_loops(kind, angle, cells, what):
    """To and fro through flat: loss of a closed cycle 4 m (a - m/k) of each slider."""
    some = ClothFriction(**{what: getattr(FRICTION, what)})  # no strain in the plane rubs, too
    size = 5e-4 if what == "twist" else 2.5e-3
    shell = small_square(kind, angle, sheet(None, some), cells, size * cells[0])
    a, lost, n = 40.0, [], len(shell.cell_stress.slips)
    for curvature in (a, -a, a, -a, a):
        BENT_BY[what](shell, curvature)
        shell.keep_slips()
        lost.append(shell.friction_loss())
    strain = shell.cell_stress.strains(owned(shell))[:, 3 + list(BENT_BY).index(what)]
    # cells aslant take the arc for its chord, normals of a twisted sheet lean by 0.1 rad
    np.testing.assert_allclose(strain, a, rtol=1e-2 if what == "twist" else 1e-3)
    per_cell = [4 * m * (strain - m / k) for k, m, _ in getattr(some, what)]
    mean = shell.comm.allreduce(np.sum(per_cell)) / shell.comm.allreduce(n)
    assert lost[4] - lost[2] == pytest.approx(mean * shell.surface.area, rel=1e-6)


def test_rest_takes_slips_back():
    shell = Shell(dome(1, False, cells=(2, 2)), sheet(None, FRICTION))
    deform(shell, size=0.03)
    shell.keep_slips()
    assert shell.friction_loss() > 0
    shell.rest()
    assert shell.friction_loss() == 0 and shell.energy()["friction"] < 1e-25


def test_nothing_is_made_that_is_not_named(monkeypatch, comm):
    """No library, no state and no form of curves or friction without them."""
    made = []
    library = "shellform.fem.cell_stress.CellStress.__init__"
    monkeypatch.setattr(library, lambda *a, **k: made.append("cells"))
    monkeypatch.setattr("shellform.fem.shell.friction_terms", lambda *a: made.append("terms") or [])
    shell = Shell(dome(1, False, cells=(2, 2)), sheet(None, None))
    deform(shell, size=0.03)
    InternalForce(shell)(owned(shell))
    static_force(shell)
    shell.energy()
    shell.keep_slips()
    assert made == [] and shell.cell_stress is None and "friction" not in shell.energy()
    with pytest.raises(AttributeError):  # the counter counts
        Shell(dome(1, False, cells=(2, 2)), sheet(None, FRICTION)).energy()
    assert made == ["cells"]


@pytest.mark.parametrize("options", [{"membrane": "chords"}, {"thick": True}, {"degree": 2}])
def test_other_forms_refuse_friction(options):
    surface = dome(options.pop("degree", 1), False, cells=(2, 2))
    with pytest.raises(
        ValueError, match="friction inside the cloth goes with triangles and 4-node"
    ):
        Shell(surface, sheet(None, FRICTION), **options)
