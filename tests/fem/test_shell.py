# SPDX-License-Identifier: LGPL-3.0-or-later
"""The director shell against invariance, exact states and finite differences."""

from petsc4py import PETSc

import numpy as np
import pytest

import meshes
from shellform import Fabric, Ply, Shell
from shellform.fem.director import rotation_matrix
from shellform.statics.equilibrium import Equilibrium

PLAIN = {"membrane": "chords", "curvature": "plain"}
ELEMENTS = {
    "quad": (1, False, {}),
    "quad plain": (1, False, PLAIN),
    "triangle": (1, True, {}),
    "triangle plain": (1, True, PLAIN),
    "nine nodes": (2, False, {}),
}


def dome(degree, triangles, cells=(5, 4), amount=0.25, size=1.0):
    """A doubly curved, distorted patch with exact normals, about `size` wide."""

    def place(a, b):
        return size * a, size * b, size * (0.4 * a * (1 - a) + 0.3 * b * b + 0.1 * a * b)

    def normal(a, b):
        n = np.array([-(0.4 - 0.8 * a + 0.1 * b), -(0.6 * b + 0.1 * a), np.ones_like(a)])
        return n / np.linalg.norm(n, axis=0)

    return meshes.patch(
        place,
        cells,
        degree=degree,
        triangles=triangles,
        normal=normal,
        parameters=meshes.distorted(cells, amount, seed=2),
        warp=(1.0, 0.3, 0.0),
    )


def woven(thickness=0.05):
    """Strongly orthotropic, with bending of its own."""
    return Fabric.orthotropic(3e5, 1e5, 0.2, 8e3, 6e3, 5e3, thickness, 300.0)


def unsymmetric(thickness=0.05):
    ply = {"E1": 3e5, "E2": 1e4, "nu12": 0.3, "G12": 8e3, "G13": 6e3, "G23": 5e3, "density": 300.0}
    return Fabric.laminate([(Ply(**ply), thickness / 2, 0.0), (Ply(**ply), thickness / 2, 90.0)])


def owned(shell):
    return shell.w.x.array.reshape(-1, 6)


def deform(shell, size=0.3, seed=0):
    """A smooth, large displacement and turned directors, the same on any number of ranks."""
    X = shell.surface.points[shell.partition.nodes]
    rng = np.random.default_rng(seed)
    c = rng.uniform(-1, 1, (3, 3))
    w = owned(shell)
    w[:, :3] = size * np.sin(X @ c.T + rng.uniform(-1, 1, 3))
    R = rotation_matrix(size * np.cos(X @ c + 0.3))
    w[:, 3:] = np.einsum("nij,nj->ni", R, shell.partition.directors)


@pytest.mark.parametrize("element", ELEMENTS)
@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_rigid_motion_stores_no_energy(element, size):
    degree, triangles, options = ELEMENTS[element]
    shell = Shell(dome(degree, triangles, size=size), woven(0.05 * size), **options)
    points, origin = shell.surface.points, shell.partition.origin
    R = rotation_matrix([0.4, -2.1, 1.7])
    w = owned(shell)
    local = points[shell.partition.nodes] - origin
    w[:, :3] = local @ R.T - local + size * np.array([5.0, -3.0, 2.0])
    w[:, 3:] = shell.partition.directors @ R.T
    # strains of roundoff only: (eps * size of the motion / cell)^2 of the membrane's stiffness
    strain = 100 * np.finfo(float).eps
    bar = shell.fabric.membrane[0, 0] * shell.surface.area * strain**2
    assert sum(shell.energy().values()) < bar
    # and the measure is not blind: the same motion with a stretch of 1e-3 stores energy
    w[:, :3] += 1e-3 * local
    assert shell.energy()["membrane"] > 1e-7 * shell.fabric.membrane[0, 0] * shell.surface.area


@pytest.mark.parametrize("element", ELEMENTS)
@pytest.mark.parametrize("curved", [True, False])
@pytest.mark.serial
def test_exactly_six_zero_modes(element, curved):
    degree, triangles, options = ELEMENTS[element]
    if curved:
        surface = dome(degree, triangles)
    else:
        surface = meshes.rectangle(
            1.2, 1.0, (5, 4), degree=degree, triangles=triangles,
            parameters=meshes.distorted((5, 4), 0.25, seed=1), warp=(1.0, 0.0, 0.0),
        )  # fmt: skip
    equilibrium = Equilibrium(Shell(surface, woven(), **options))
    equilibrium.start(0.0)
    K = equilibrium.tangent(equilibrium.x)
    dense = K.convert("dense").getDenseArray()
    assert np.abs(dense - dense.T).max() < 1e-12 * np.abs(dense).max()
    values = np.linalg.eigvalsh(dense)
    assert np.abs(values[:6]).max() < 1e-11 * values[-1]
    assert values[6] > 1e-7 * values[-1]


FORMS = {
    **{name: (*ELEMENTS[name], woven) for name in ELEMENTS},
    "quad thick": (1, False, {"thick": True}, woven),
    "quad coupled": (1, False, {}, unsymmetric),
    "nine nodes thick and coupled": (2, False, {"thick": True}, unsymmetric),
    "triangle thick": (1, True, {"thick": True}, woven),
}


@pytest.mark.parametrize("name", FORMS)
def test_tangent_is_the_derivative_of_the_residual(name):
    """Central differences in the 5 unknowns, with pressure and moments; linearised stress off."""
    degree, triangles, options, fabric = FORMS[name]
    shell = Shell(dome(degree, triangles), fabric(), **options)
    shell.loads.pressure(200.0)
    shell.loads.edge_moment("right", (1.0, -2.0, 0.5))
    shell.loads.line("top", (10.0, 5.0, -4.0))
    shell.supports.clamp("left")
    shell.supports.hold_normal("bottom", (0.3, 1.0, 0.2))
    equilibrium = Equilibrium(shell, mip=False)
    deform(shell)
    equilibrium.adopt()
    equilibrium.start(1.0)
    x, n = equilibrium.x, equilibrium.n_owned
    rng = np.random.default_rng(7)
    whole = rng.standard_normal((len(shell.surface.points), 5))
    change = whole[shell.partition.owned_nodes] * ~equilibrium.held[:n]
    base = x.array_r.copy()
    h = 2e-6
    sides = []
    for sign in (1, -1):
        x.setArray(base + sign * h * change.ravel())
        equilibrium.residual(x, equilibrium.F)
        sides.append(equilibrium.F.array_r.copy())
    x.setArray(base)
    K = equilibrium.tangent(x)
    direction, product = x.duplicate(), x.duplicate()
    direction.setArray(change.ravel())
    K.mult(direction, product)
    numerical = (sides[0] - sides[1]) / (2 * h)
    error = np.array([np.sum((numerical - product.array_r) ** 2), np.sum(product.array_r**2)])
    error = shell.comm.allreduce(error)
    assert np.sqrt(error[0] / error[1]) < 1e-7


@pytest.mark.parametrize("name", FORMS)
def test_internal_force_is_the_derivative_of_the_energy(name):
    degree, triangles, options, fabric = FORMS[name]
    shell = Shell(dome(degree, triangles), fabric(), **options)
    deform(shell)
    force = shell.partition.petsc_vector(6)
    shell.internal_force(force)
    force.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)
    rng = np.random.default_rng(3)
    change = rng.standard_normal((len(shell.surface.points), 6))[shell.partition.nodes]
    w, base, h = owned(shell), owned(shell).copy(), 2e-6
    sides = []
    for sign in (1, -1):
        w[:] = base + sign * h * change
        sides.append(sum(shell.energy().values()))
    work = shell.comm.allreduce(np.sum(force.array_r * change[: shell.partition.n_owned].ravel()))
    assert (sides[0] - sides[1]) / (2 * h) == pytest.approx(work, rel=1e-7)


PATCHES = {"quad": (1, False, {}), "quad plain": (1, False, PLAIN), "nine nodes": (2, False, {})}
# Relative error of nodal forces and of energy. The three membrane rules of the 9-node quad see
# covariant components that vary over a cell that is no parallelogram: not exact there.
EXACT = (1e-10, 1e-10)
BAR = {("nine nodes", 0.25): (5e-2, 3e-4)}
# The mixed shear product of the 9-node quad is capped in cells larger than the sheet is thick:
# a shear stiffness that is not isotropic, off the mesh's axes, comes out a little different.
SHEAR_BAR = {("nine nodes", 0.0): (1e-10, 2e-2), ("nine nodes", 0.25): (0.1, 2e-2)}


def flat_patch(name, fabric, amount=0.25):
    degree, triangles, options = PATCHES[name]
    surface = meshes.rectangle(
        1.2, 1.0, (6, 5), degree=degree, triangles=triangles,
        parameters=meshes.distorted((6, 5), amount, seed=4), warp=(np.cos(0.5), np.sin(0.5), 0.0),
    )  # fmt: skip
    shell = Shell(surface, fabric, **options)
    equilibrium = Equilibrium(shell)
    equilibrium.start(0.0)
    return shell, equilibrium, equilibrium.tangent(equilibrium.x)


def respond(shell, equilibrium, K, displacement, director_change):
    """Linear nodal forces (n, 6)-like: (u forces, d forces) and energy of a prescribed field."""
    n = equilibrium.n_owned
    T = equilibrium.T[:n]
    X = shell.surface.points[shell.partition.owned_nodes]
    x = np.zeros((n, 5))
    x[:, :3] = displacement(X)
    x[:, 3:] = np.einsum("nij,ni->nj", T, director_change(X)) * equilibrium.length
    vector, product = equilibrium.x.duplicate(), equilibrium.x.duplicate()
    vector.setArray(x.ravel())
    K.mult(vector, product)
    force = product.array_r.reshape(n, 5)
    turning = np.einsum("nij,nj->ni", T, force[:, 3:]) * equilibrium.length
    whole = shell.partition.gather(np.hstack([force[:, :3], turning]))
    return whole, 0.5 * vector.dot(product)


def inner(surface):
    x, y, _ = surface.points.T
    return (x > 1e-9) & (x < x.max() - 1e-9) & (y > 1e-9) & (y < y.max() - 1e-9)


def in_warp_axes(xx, yy, xy):
    c, s = np.cos(0.5), np.sin(0.5)
    e = np.array([[xx, xy], [xy, yy]])
    R = np.array([[c, s], [-s, c]])
    e = R @ e @ R.T
    return np.array([e[0, 0], e[1, 1], 2 * e[0, 1]])


DISTORTED = [("quad", 0.25), ("quad plain", 0.25), ("nine nodes", 0.0), ("nine nodes", 0.25)]


@pytest.mark.parametrize(("name", "amount"), DISTORTED)
def test_membrane_patch(name, amount):
    """A constant membrane strain: no force inside, the exact energy."""
    fabric, (bar, energy_bar) = woven(), BAR.get((name, amount), EXACT)
    shell, equilibrium, K = flat_patch(name, fabric, amount)
    g = np.array([[0.3, -0.7, 0.0], [0.5, 0.2, 0.0], [0.0, 0.0, 0.0]])
    force, energy = respond(shell, equilibrium, K, lambda X: X @ g.T, lambda X: 0 * X)
    assert np.abs(force[inner(shell.surface)]).max() < bar * np.abs(force).max()
    e = in_warp_axes(g[0, 0], g[1, 1], 0.5 * (g[0, 1] + g[1, 0]))
    assert energy == pytest.approx(0.5 * e @ fabric.membrane @ e * 1.2, rel=energy_bar)


@pytest.mark.parametrize("name", PATCHES)
def test_constant_curvature_patch(name):
    """u_z quadratic, no shear: no force or moment inside, the exact energy."""
    fabric = woven()
    shell, equilibrium, K = flat_patch(name, fabric)
    k = np.array([[0.4, -0.3], [-0.3, 0.8]])

    def deflection(X):
        w = -0.5 * np.einsum("ni,ij,nj->n", X[:, :2], k, X[:, :2])
        return np.column_stack([0 * w, 0 * w, w])

    def turned(X):
        return np.column_stack([X[:, :2] @ k, 0 * X[:, 0]])

    force, energy = respond(shell, equilibrium, K, deflection, turned)
    assert np.abs(force[inner(shell.surface)]).max() < 1e-10 * np.abs(force).max()
    e = in_warp_axes(k[0, 0], k[1, 1], k[0, 1])
    assert energy == pytest.approx(0.5 * e @ fabric.bending @ e * 1.2, rel=1e-10)


@pytest.mark.parametrize(("name", "amount"), DISTORTED)
def test_constant_shear_patch(name, amount):
    """u_z linear, directors still: exact energy, no force inside, couples of the shear force."""
    fabric, (bar, energy_bar) = woven(), SHEAR_BAR.get((name, amount), EXACT)
    shell, equilibrium, K = flat_patch(name, fabric, amount)
    g = np.array([0.6, -0.4])

    def deflection(X):
        return np.column_stack([0 * X[:, :2], X[:, :2] @ g])

    force, energy = respond(shell, equilibrium, K, deflection, lambda X: 0 * X)
    c, s = np.cos(0.5), np.sin(0.5)
    R = np.array([[c, s], [-s, c]])
    Q = R.T @ fabric.shear @ R @ g
    assert energy == pytest.approx(0.5 * (R @ g) @ fabric.shear @ (R @ g) * 1.2, rel=energy_bar)
    assert np.abs(force[inner(shell.surface), :3]).max() < bar * np.abs(force).max()
    assert np.abs(force[:, 3:5].sum(axis=0) - 1.2 * Q).max() < 3 * energy_bar * np.abs(Q).max()
