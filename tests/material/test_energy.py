# SPDX-License-Identifier: LGPL-3.0-or-later
"""Laws: what a class may store in a strain, checked at rest and against closed forms."""

from petsc4py import PETSc

import numpy as np
import pytest

import ufl

import meshes
from shellform import Fabric, FabricError, Shell
from shellform.dynamics.explicit import Newmark
from shellform.dynamics.implicit import ImplicitNewmark
from shellform.dynamics.mass_spring import Particles
from shellform.fem.internal_force import InternalForce
from shellform.material.energy import StVenant, at_rest, check_law, quadratic
from tests.fem.test_shell import deform, dome, owned


class Fung(StVenant):
    """Stiffens exponentially in stretching, bending and shear, each by a number of its own."""

    def __init__(self, b):
        self.b = b

    def stored(self, strain, stiffness):
        c = stiffness[0, 0] / self.b
        return 0.5 * c * (ufl.exp(2 * quadratic(strain, stiffness) / c) - 1)

    def membrane(self, E, A):
        return self.stored(E, A)

    def bending(self, K, D):
        c = D[0, 0] / 0.01
        return 0.5 * c * (ufl.exp(2 * quadratic(K, D) / c) - 1)

    def shear(self, gamma, S):
        return self.stored(gamma, S)


class Spelled(StVenant):
    """The quadratic energy, written out as a law of one's own."""

    def membrane(self, E, A):
        return quadratic(E, A)

    def bending(self, K, D):
        return quadratic(K, D)

    def shear(self, gamma, S):
        return quadratic(gamma, S)


class Stressed(StVenant):
    def membrane(self, E, A):
        return quadratic(E, A) + 1e-3 * A[0, 0] * E[0]


class TooStiff(StVenant):
    def shear(self, gamma, S):
        return 1.1 * quadratic(gamma, S)


class Undefined(StVenant):
    def bending(self, K, D):
        return quadratic(K, D) + D[0, 0] * ufl.ln(K[0])


def woven(thickness=0.05):
    return Fabric.orthotropic(3e5, 1e5, 0.2, 8e3, 6e3, 5e3, thickness, 300.0)


def coupled():
    A = woven().membrane
    return Fabric(A, 3e-4 * A, 0.2 * A[:2, :2], 15.0, 0.05, coupling=3e-3 * A)


CASES = {"quads": (1, False, woven), "coupled nine nodes": (2, False, coupled)}


@pytest.fixture(params=["quads", pytest.param("coupled nine nodes", marks=pytest.mark.thorough)])
def make(request):
    degree, triangles, fabric = CASES[request.param]

    def shell(law):
        made = Shell(dome(degree, triangles, cells=(2, 2)), fabric(), law=law)
        deform(made)
        return made

    return shell


def forces(shell, stress_from=None):
    """Owned nodal forces of statics (n, 6)."""
    out = shell.partition.petsc_vector(6)
    shell.internal_force(out, stress_from=stress_from)
    return out.array.reshape(-1, 6).copy()


@pytest.mark.serial
def test_quadratic_law_written_out_is_the_default(make):
    """Differentiated by UFL, the same energy gives the same energy, forces and tangent."""
    plain, spelled = make(None), make(Spelled())
    wanted, energy = plain.energy(), spelled.energy()
    assert energy == pytest.approx(wanted, rel=1e-12)
    scale = np.abs(forces(plain)).max()
    np.testing.assert_allclose(forces(spelled), forces(plain), atol=1e-12 * scale)
    matrices = []
    for shell in (plain, spelled):
        matrix = shell.create_tangent()
        shell.tangent(matrix)
        matrix.assemble()
        matrices.append(matrix.convert("dense").getDenseArray().copy())
    np.testing.assert_allclose(*matrices, atol=1e-11 * np.abs(matrices[0]).max())


@pytest.mark.serial
def test_force_and_tangent_are_derivatives(make):
    """Of the energy and of the force, by differences along a random direction."""
    shell = make(Fung(3.0))
    w, rng = owned(shell), np.random.default_rng(3)
    here, way = w.copy(), rng.standard_normal(w.shape)
    way *= np.array([1, 1, 1, 1, 1, 1]) * 0.1
    force = forces(shell)
    matrix = shell.create_tangent()
    shell.tangent(matrix)
    matrix.assemble()
    product = matrix.convert("dense").getDenseArray() @ way.ravel()
    errors = []
    for h in (1e-3, 5e-4):
        values, pushes = [], []
        for sign in (1, -1):
            w[:] = here + sign * h * way
            values.append(sum(shell.energy().values()))
            pushes.append(forces(shell).ravel())
        w[:] = here
        work = (values[0] - values[1]) / (2 * h)
        change = (pushes[0] - pushes[1]) / (2 * h)
        errors.append(
            (
                abs(work / np.vdot(force, way) - 1),
                np.linalg.norm(change - product) / np.linalg.norm(product),
            )
        )
    # central differences: small, and a quarter with half the step
    assert np.all(np.array(errors) < 1e-3)
    assert np.all(np.array(errors[1]) < 0.3 * np.array(errors[0]))


@pytest.mark.serial
def test_stress_stiffens(make):
    """The law is not the quadratic one: at these strains it stores clearly more."""
    stiff, plain = (sum(make(law).energy().values()) for law in (Fung(3.0), None))
    assert stiff > 1.05 * plain


@pytest.mark.parametrize("make", ["quads"], indirect=True)
def test_explicit_force_is_that_of_statics(make):
    shell = make(Fung(3.0))
    force = InternalForce(shell)
    assert force.quads is None  # the kernel of 4-node quads knows the default law only
    n = shell.partition.n_owned
    out = shell.partition.petsc_vector(6)
    shell.internal_force(out)
    out.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)
    wanted = out.array.reshape(-1, 6)
    np.testing.assert_allclose(force(owned(shell))[:n], wanted, atol=1e-11 * np.abs(wanted).max())


@pytest.mark.parametrize("make", ["quads"], indirect=True)
def test_damping_is_that_of_the_stiffness_at_rest(make):
    """The same viscous force whatever the law: what the damped force has more than the other."""
    parts = []
    for law in (Fung(3.0), None):
        shell = make(law)
        force, w = InternalForce(shell, damped=True), owned(shell)
        ahead = w + 1e-2 * np.sin(np.arange(w.size)).reshape(w.shape)
        n = shell.partition.n_owned
        plain = force(w)[:n].copy()
        parts.append(force(w, ahead=ahead)[:n] - plain)
        assert shell.comm.allreduce(force.loss) > 0
    np.testing.assert_allclose(*parts, atol=1e-9 * np.abs(parts[1]).max())


def test_at_rest():
    A = woven().membrane
    stress, stiffness = at_rest(Fung(3.0).membrane, A, 1e-4)
    np.testing.assert_allclose(stress, 0.0, atol=1e-9 * A.max())
    np.testing.assert_allclose(stiffness, A, atol=1e-5 * A.max())


@pytest.mark.parametrize(
    "law, words",
    [
        (Stressed(), r"Stressed\(\) has the membrane stress \[.*\] in the sheet at rest"),
        (TooStiff(), r"TooStiff\(\) has the shear stiffness \[.*\] at rest, the fabric 'ortho"),
        (Undefined(), r"Undefined\(\) has the bending st"),
    ],
)
def test_laws_that_do_not_start_as_the_fabric_are_refused(law, words):
    with pytest.raises(FabricError, match=words):
        check_law(law, woven())


def test_what_is_no_law_is_refused():
    with pytest.raises(TypeError, match="derived from StVenant, not str: 'fung'"):
        Shell(meshes.rectangle(1.0, 1.0, (1, 1), warp=(1.0, 0.0, 0.0)), woven(), law="fung")


def test_plan_names_the_law():
    surface, fabric = meshes.rectangle(1.0, 1.0, (1, 1)), Fabric.isotropic(1e5, 0.3, 1e-3, 300.0)
    assert "law" not in Shell(surface, fabric).plan()
    assert Shell(surface, fabric, law=Spelled()).plan()["law"] == "Spelled()"


def test_explicit_and_implicit_steps_agree():
    """A sheet stretched by a tenth and let go: both schemes follow one motion, and its energy."""
    ends = []
    dt = 1e-3
    for start in (Newmark, lambda shell: ImplicitNewmark(shell, dt)):
        surface = meshes.rectangle(1.0, 0.5, (2, 1), warp=(1.0, 0.0, 0.0))
        shell = Shell(surface, woven(), law=Fung(3.0))
        shell.supports.clamp("left")
        stepper = start(shell)
        X = surface.points[shell.partition.nodes]
        owned(shell)[:, 0] = 0.1 * X[:, 0]
        stored = sum(shell.energy().values())
        for _ in range(15):
            stepper.step(dt)
        ends.append(shell.displacements())
        assert sum(shell.energy().values()) < 0.9 * stored
    size = np.abs(ends[0]).max()
    np.testing.assert_allclose(*ends, atol=0.02 * size)


@pytest.mark.serial
def test_springs_refuse_a_law():
    shell = Shell(
        meshes.rectangle(1.0, 1.0, (2, 2)), Fabric.isotropic(1e5, 0.3, 1e-3, 300.0), law=Spelled()
    )
    with pytest.raises(ValueError, match=r"springs follow the default law .* not Spelled\(\)"):
        Particles(shell)


class Stiffening(StVenant):
    """Exponential in the warp, written with a function of UFL on plain components."""

    def __init__(self, exponent, modulus):
        self.exponent, self.modulus = exponent, modulus

    def membrane(self, E, A):
        c = self.modulus / self.exponent
        rest = 0.5 * (A[1, 1] * E[1] ** 2 + A[2, 2] * E[2] ** 2) + A[0, 1] * E[0] * E[1]
        return 0.5 * c * (ufl.exp(self.exponent * E[0] ** 2) - 1) + rest


@pytest.mark.parametrize("exponent", [1.0, 1e4, 1e5])
def test_laws_that_stiffen_soon_are_recognised(exponent):
    """d2/dE2 of c/2 (exp(a E^2) - 1) at rest is c a, however soon the exponential takes over."""
    fabric = Fabric.isotropic(1e5, 0.3, 1e-3, 300.0)
    check_law(Stiffening(exponent, fabric.membrane[0, 0]), fabric)
    with pytest.raises(FabricError, match="membrane stiffness"):
        check_law(Stiffening(exponent, 1.01 * fabric.membrane[0, 0]), fabric)
