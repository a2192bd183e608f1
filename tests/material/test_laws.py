# SPDX-License-Identifier: LGPL-3.0-or-later
"""Shipped laws in every element and solver, against closed forms; their names in cards, scenes."""

from petsc4py import PETSc

import numpy as np
import pytest
from scipy.optimize import brentq

import ufl

import meshes
from shellform import Fabric, FabricError, Scene, Shell, Statics
from shellform.dynamics.explicit import Newmark
from shellform.dynamics.implicit import ImplicitNewmark
from shellform.fem.director import rotation_matrix
from shellform.fem.internal_force import InternalForce
from shellform.material.card import fabric_from_card, fabric_of
from shellform.material.fung import Fung
from shellform.material.laws import LAWS, law_from, law_table
from shellform.material.solid import CompressibleNeoHookean
from shellform.material.surface_energy import MetricAndCurvature
from shellform.scene.checks import check_dressing
from shellform.scene.scene_file import read_scene, write_scene
from tests.fem.test_shell import deform, dome, owned
from tests.material.test_measurements import SUITING

pytestmark = pytest.mark.serial  # laws act in a point of a cell

KINDS = {"quads": (1, False), "triangles": (1, True), "nine nodes": (2, False)}
E, NU, T = 6e5, 0.4, 2e-3
SOLID = Fabric.isotropic(E, NU, T, 1000.0)
FUNG = Fabric.from_stiffness(
    [[800.0, 120.0, 0], [120.0, 500.0, 0], [0, 0, 60.0]], np.diag([2e-5, 1e-5, 6e-6]), 0.2, 5e-4
)
SURFACE = Fabric.from_stiffness(
    np.diag([800.0, 500.0, 60.0]), np.diag([2e-5, 1e-5, 6e-6]), 0.2, 5e-4
)
CASES = {
    "solid": (CompressibleNeoHookean(), SOLID),
    "fung": (Fung(40.0), FUNG),
    "surface": (MetricAndCurvature(), SURFACE),
}
# forms of a law in every element take a minute to compile
LONG = [pytest.param(kind, marks=() if kind == "quads" else pytest.mark.thorough) for kind in KINDS]
QUICK = {*((case, "quads") for case in CASES), ("fung", "triangles")}
ALL = [
    pytest.param(case, kind, marks=() if (case, kind) in QUICK else pytest.mark.thorough)
    for case in CASES
    for kind in KINDS
]


def across(stretch):
    """C22 = C33 of a bar of the compressible solid pulled to a stretch, by bracketing."""
    mu, lam = 0.5 * E / (1 + NU), E * NU / (1 + NU) / (1 - 2 * NU)
    return brentq(
        lambda c: mu * (c - 1) + 0.5 * lam * np.log(stretch**2 * c**2), 1e-3, 20, xtol=1e-15
    )


def pulled(kind, law, fabric, force):
    """A sheet 1 m by 0.5 m, free to become narrower."""
    degree, triangles = KINDS[kind]
    surface = meshes.rectangle(1.0, 0.5, (2, 1), degree=degree, triangles=triangles)
    shell = Shell(surface, fabric, law=law)
    shell.supports.hold("left", "x")
    shell.supports.hold("bottom", "y")
    shell.supports.hold(np.arange(len(surface.points)), "z")
    shell.loads.line("right", (force, 0.0, 0.0))
    with Statics(shell) as statics:
        statics.solve(4)
    return shell


@pytest.mark.parametrize("kind", LONG)
@pytest.mark.parametrize("stretch", [0.8, 1.5])
def test_solid_pulled(kind, stretch):
    """Force, contraction and energy of a bar, S33 = 0 found by another method."""
    c, mu = across(stretch), 0.5 * E / (1 + NU)
    shell = pulled(kind, CompressibleNeoHookean(), SOLID, T * mu * (stretch**2 - c) / stretch)
    X = shell.surface.points
    wanted = np.stack([(stretch - 1) * X[:, 0], (np.sqrt(c) - 1) * X[:, 1], 0 * X[:, 0]], 1)
    np.testing.assert_allclose(shell.displacements(), wanted, atol=2e-7)


def bent_moment(law, fabric, curvature):
    """Moment per width [N] of a strip that is neither stretched nor bent across, by differences."""
    A, D = (ufl.as_matrix(m.tolist()) for m in (fabric.membrane, fabric.bending))

    def energy(kappa):
        strains = ([0.0, 0.0, 0.0], [kappa, 0.0, 0.0])
        return float(law.membrane_and_bending(*map(ufl.as_vector, strains), A, D)(()))

    h = 1e-4 * curvature
    return (energy(curvature + h) - energy(curvature - h)) / (2 * h)


def test_solid_bends_as_its_fibres_do():
    """Moment of fibres at all heights, each with its own C33: quadrature of scipy's."""
    from scipy.integrate import quad

    lam = E * NU / (1 + NU) / (1 - 2 * NU)
    mu, curvature = 0.5 * E / (1 + NU), 0.3 / T

    def stress(z):
        C = 1 + 2 * z * curvature
        c33 = brentq(lambda c: mu * (c - 1) + 0.5 * lam * np.log(C * c), 1e-3, 20, xtol=1e-15)
        return mu * (1 - 1 / C) + 0.5 * lam * np.log(C * c33) / C

    exact = quad(lambda z: z * stress(z), -T / 2, T / 2, epsrel=1e-12)[0]
    # three Gauss points over the thickness at a fibre strain of 15 %
    assert bent_moment(CompressibleNeoHookean(), SOLID, curvature) == pytest.approx(exact, rel=2e-3)
    linear = SOLID.bending[0, 0] * curvature
    assert abs(exact / linear - 1) > 0.02  # a bar of 2e-3 tells them apart


def edge_force(kind, law, fabric, F, angle, cells=(2, 2)):
    """Force (3,) [N] on the right edge of a unit square in the homogeneous deformation F (2, 2).

    The warp is at an angle [deg] from x.
    """
    degree, triangles = KINDS[kind]
    turn = np.radians(angle)
    surface = meshes.rectangle(
        1.0, 1.0, cells, degree=degree, triangles=triangles, warp=(np.cos(turn), np.sin(turn), 0)
    )
    shell = Shell(surface, fabric, law=law)
    X = surface.points[shell.partition.nodes]
    owned(shell)[:, :2] = X[:, :2] @ (F - np.eye(2)).T
    field = shell.partition.petsc_vector(6)
    shell.internal_force(field)
    field.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)
    right = surface.points[shell.partition.owned_nodes][:, 0] > 1 - 1e-9
    return shell.comm.allreduce(field.array.reshape(-1, 6)[right, :3].sum(axis=0))


def in_axes(F, angle):
    """Strain (E11, E22, 2 E12) along warp and weft, and the turn (2, 2) from there to x and y."""
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    turn = np.array([[c, -s], [s, c]])
    strain = 0.5 * turn.T @ (F.T @ F - np.eye(2)) @ turn
    return np.array([strain[0, 0], strain[1, 1], 2 * strain[0, 1]]), turn


@pytest.mark.parametrize("kind", LONG)
@pytest.mark.parametrize("angle", [0.0, 90.0, 30.0])
def test_fung_in_a_homogeneous_strain(kind, angle):
    """F S e_x on the edge, S = exp(E.A.E/c) A E written out."""
    F = np.array([[1.25, 0.1], [-0.05, 0.9]])
    e, turn = in_axes(F, angle)
    A, scale = FUNG.membrane, 40.0
    N = np.exp(e @ A @ e / scale) * (A @ e)
    assert np.abs(N).max() > 1.3 * np.abs(A @ e).max()  # far into the exponential
    S = turn @ [[N[0], N[2]], [N[2], N[1]]] @ turn.T
    force = edge_force(kind, Fung(scale), FUNG, F, angle)
    np.testing.assert_allclose(force, [*(F @ S)[:, 0], 0.0], atol=1e-9 * np.abs(N).max())


def solid_stress(strain):
    """Membrane stress (3,) of the compressible solid, C33 by bracketing."""
    mu, lam = 0.5 * E / (1 + NU), E * NU / (1 + NU) / (1 - 2 * NU)
    C = np.array([[1 + 2 * strain[0], strain[2]], [strain[2], 1 + 2 * strain[1]]])
    volume = np.linalg.det(C)
    c = brentq(lambda c: mu * (c - 1) + 0.5 * lam * np.log(volume * c), 1e-3, 20, xtol=1e-15)
    S = mu * np.eye(2) + (0.5 * lam * np.log(volume * c) - mu) * np.linalg.inv(C)
    return T * S[[0, 1, 0], [0, 1, 1]]


STRESS = {
    "fung": lambda e: np.exp(e @ FUNG.membrane @ e / 40.0) * (FUNG.membrane @ e),
    "surface": lambda e: SURFACE.membrane @ e,
    "solid": solid_stress,
}


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("angle, cells", [(0.0, (1, 1)), (90.0, (1, 1)), (30.0, (8, 8))])
def test_what_comes_out_is_what_was_put_in(case, angle, cells):
    """Force on the edge of one cell and of 8 x 8 against the law; warp, weft, 30 deg."""
    F = np.array([[1.25, 0.1], [-0.05, 0.9]])
    e, turn = in_axes(F, angle)
    N = STRESS[case](e)
    S = turn @ [[N[0], N[2]], [N[2], N[1]]] @ turn.T
    law, fabric = CASES[case]
    force = edge_force("quads", law, fabric, F, angle, cells)
    np.testing.assert_allclose(force, [*(F @ S)[:, 0], 0.0], atol=1e-8 * np.abs(N).max())


@pytest.mark.parametrize("case, kind", ALL)
def test_force_and_tangent_are_derivatives(case, kind):
    """Of the energy and of the force, by differences of a bent and stretched shell."""
    law, fabric = CASES[case]
    shell = Shell(dome(*KINDS[kind], cells=(2, 2)), fabric, law=law)
    deform(shell, size=0.02)
    w, rng = owned(shell), np.random.default_rng(3)
    here, whole = w.copy(), rng.standard_normal((len(shell.surface.points), 6))
    way = whole[shell.partition.owned_nodes] * [1, 1, 1, 0.1, 0.1, 0.1]
    matrix = shell.create_tangent()
    field, force = shell.partition.petsc_vector(6), None

    def forces():
        with field.localForm() as local:
            local.set(0.0)
        shell.internal_force(field)
        field.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)
        return field.array.reshape(-1, 6).copy()

    def move(by):
        w[: len(here)] = here + by * way
        shell.w.x.scatter_forward()

    here = here[: shell.partition.n_owned].copy()
    force = forces()
    shell.tangent(matrix)
    matrix.assemble()
    direction, product = field.duplicate(), field.duplicate()
    direction.setArray(way.ravel())
    matrix.mult(direction, product)
    h, energies, pushes = 1e-6, [], []
    for sign in (1, -1):
        move(sign * h)
        energies.append(sum(shell.energy().values()))
        pushes.append(forces())
    total = shell.comm.allreduce
    work = (energies[0] - energies[1]) / (2 * h)
    exact = total(np.vdot(force, way))
    assert work == pytest.approx(exact, rel=1e-6)
    gap = (pushes[0] - pushes[1]).ravel() / (2 * h) - product.array
    size = total(np.sum(product.array**2))
    assert np.sqrt(total(np.sum(gap**2)) / size) < 1e-6


@pytest.mark.parametrize("case, kind", ALL)
def test_turned_sheets_have_turned_forces(case, kind):
    """Objectivity, and the explicit force is that of statics."""
    law, fabric = CASES[case]
    shell = Shell(dome(*KINDS[kind], cells=(2, 2)), fabric, law=law)
    deform(shell, size=0.02)
    force, w, n = InternalForce(shell), owned(shell), shell.partition.n_owned
    plain = force(w)[:n].copy()
    field = shell.partition.petsc_vector(6)
    shell.internal_force(field)
    field.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)
    largest = np.abs(plain).max()
    assert np.abs(plain - field.array.reshape(-1, 6)).max() < 1e-9 * largest
    R = rotation_matrix([0.4, -2.1, 1.7])
    x = shell.surface.points[shell.partition.nodes] - shell.partition.origin
    w[:, :3], w[:, 3:] = (x + w[:, :3]) @ R.T - x, w[:, 3:] @ R.T
    turned = force(w)[:n]
    wanted = np.hstack([plain[:, :3] @ R.T, plain[:, 3:] @ R.T])
    assert np.abs(turned - wanted).max() < 1e-7 * largest


def test_surface_energy_is_the_sheet_without_contraction():
    """Terzopoulos' energy of G and B: (G - G0)^2 weighted by component, from the deformed mesh."""
    shell = Shell(
        meshes.rectangle(1.0, 1.0, (1, 1), warp=(1.0, 0.0, 0.0)), SURFACE, law=MetricAndCurvature()
    )
    F = np.array([[1.1, 0.2, 0.0], [0.05, 0.9, 0.0], [0.0, 0.0, 1.0]])
    X = shell.surface.points[shell.partition.nodes] - shell.partition.origin
    owned(shell)[:, :3] = X @ (F - np.eye(3)).T
    G = (F.T @ F - np.eye(3))[:2, :2]
    eta = SURFACE.membrane[[0, 0, 1], [0, 0, 1]] / 4 * [1, 0, 1]
    eta12 = SURFACE.membrane[2, 2] / 2
    wanted = 0.5 * (eta[0] * G[0, 0] ** 2 + eta[2] * G[1, 1] ** 2) + eta12 * G[0, 1] ** 2
    assert shell.energy()["membrane"] == pytest.approx(wanted, rel=1e-12)


@pytest.mark.parametrize("case", ["solid", "fung"])
def test_explicit_and_implicit_steps_agree(case):
    """A sheet stretched by a tenth and let go follows one motion under both schemes."""
    law, fabric = CASES[case]
    (dt, steps), ends = {"solid": (5e-4, 20), "fung": (1.25e-4, 160)}[case], []
    for start in (lambda shell: Newmark(shell, 0.2), lambda shell: ImplicitNewmark(shell, dt)):
        surface = meshes.rectangle(1.0, 0.5, (2, 1), warp=(1.0, 0.0, 0.0))
        shell = Shell(surface, fabric, law=law)
        shell.supports.clamp("left")
        stepper = start(shell)
        X = surface.points[shell.partition.nodes]
        owned(shell)[:, 0] = 0.1 * X[:, 0]
        stored = sum(shell.energy().values())
        stepper.advance(steps * dt)
        ends.append(shell.displacements())
        assert sum(shell.energy().values()) < 0.9 * stored
    np.testing.assert_allclose(*ends, atol=0.03 * np.abs(ends[0]).max())


@pytest.mark.parametrize("kind", LAWS)
def test_names(kind):
    numbers = {"stiffening_load_N_per_m": 40.0} if kind == "fung" else {}
    law = law_from({"kind": kind} | numbers)
    assert law_table(law) == {"kind": kind} | numbers
    assert law_from(law_table(law)).__class__ is law.__class__


CARD = {
    "name": "rubber",
    "law": "compressible-neo-hookean",
    "isotropic": {
        "youngs_modulus_Pa": E,
        "poisson_ratio": NU,
        "thickness_m": T,
        "density_kg_per_m3": 1e3,
    },
}


def test_a_card_names_its_law():
    fabric = fabric_from_card(CARD)
    shell = Shell(meshes.rectangle(1.0, 1.0, (1, 1)), fabric)
    assert shell.law == CompressibleNeoHookean() == fabric.law
    assert shell.plan()["law"] == "CompressibleNeoHookean()"


@pytest.mark.parametrize(
    "law, words",
    [
        ("fungus", r'cloth \[law\]: unknown law "fungus"; did you mean "fung"\?'),
        ("fung", r'cloth \[law\]: key "stiffening_load_N_per_m" of the law "fung" is missing'),
        (
            {"kind": "fung", "stiffening_load_N_per_m": -1},
            r"cloth \[law\]: stiffening_load = -1 N/m is not a positive",
        ),
        ({"kind": "fung", "load": 1}, r'cloth \[law\]: unknown key "load" of the law "fung"'),
        ({"kind": "st-venant", "load": 1}, r'unknown key "load" of the law "st-venant"; it has no'),
        (3, r"cloth \[law\]: a law is a name, or a table with kind"),
        ("neo-hookean", r"cloth \[law\]: NeoHookean\(\) has the membrane stiffness .* give the"),
    ],
)
def test_bad_cards(law, words):
    with pytest.raises(FabricError, match=words):
        fabric_from_card(CARD | {"law": law}, "cloth")


def test_scenes_name_laws(tmp_path):
    """In place of the fabric's, kept by files; a law that does not fit is refused when made."""
    law = {"kind": "fung", "stiffening_load_N_per_m": 40.0}
    write_scene(Scene("compliant", law=law), tmp_path / "a.toml")
    assert read_scene(tmp_path / "a.toml").cloth.law == Fung(40.0)
    assert fabric_of("compliant").law is None
    write_scene(Scene(fabric_from_card(CARD)), tmp_path / "b.toml")
    assert read_scene(tmp_path / "b.toml").cloth.law == CompressibleNeoHookean()
    scene = Scene(fabric_from_card({"name": "suiting", "measured": SUITING}))
    write_scene(scene, tmp_path / "c.toml")
    again = read_scene(tmp_path / "c.toml").cloth
    assert again.law == scene.cloth.law and again.friction == scene.cloth.friction
    assert again.friction.counts() == [0, 0, 1, 1, 0, 0] and again.name == "suiting"
    with pytest.raises(FabricError, match=r"law: NeoHookean\(\) has the membrane stiffness"):
        Scene("compliant", law="neo-hookean")


def test_dressing_by_springs_is_refused():
    cloth = fabric_from_card({"name": "suiting", "measured": SUITING})
    check_dressing("shell", cloth)
    check_dressing("particles", fabric_of("compliant"))
    with pytest.raises(
        ValueError, match="'particles': masses and springs do not know the law of 's"
    ):
        check_dressing("particles", cloth)
    check_dressing("particles", cloth.with_law(None))  # friction is known to springs


def test_solids_refuse_what_they_do_themselves():
    surface = meshes.rectangle(1.0, 1.0, (1, 1))
    with pytest.raises(ValueError, match="integrates its own energy through the thickness"):
        Shell(surface, SOLID, law=CompressibleNeoHookean(), thick=True)
    with pytest.raises(FabricError, match="stand in the axes of warp and weft"):
        SOLID.with_law(CompressibleNeoHookean()).rotated(30.0)
