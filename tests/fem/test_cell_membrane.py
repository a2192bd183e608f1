# SPDX-License-Identifier: LGPL-3.0-or-later
"""The membrane of cells in the weak form: force, tangent, explicit twin, resolved and relaxed."""

from petsc4py import PETSc

import numpy as np
import pytest

import meshes
from shellform.fem.internal_force import InternalForce
from shellform.fem.shell import Shell
from shellform.material.fabric import Fabric

KINDS = ["resolved", "relaxed"]


def cloth():
    """Balanced weave, soft in shear."""
    return Fabric.from_kes(
        tensile_warp_N_per_m=5000,
        tensile_weft_N_per_m=4000,
        shear_N_per_m_per_radian=80,
        bending_warp_N_m=1.2e-5,
        bending_weft_N_m=1.2e-5,
        areal_mass_kg_per_m2=0.21,
        thickness_m=0.36e-3,
    )


def crumpled(wrinkles, comm, seed=0):
    """A curved sheet of uneven quads, warp askew, with cells taut, wrinkled and slack."""
    surface = meshes.rectangle(0.7, 0.5, (7, 5), parameters=meshes.distorted((7, 5), 0.2))
    points = surface.points.copy()
    points[:, 2] += 0.2 * points[:, 0] ** 2
    shell = Shell(surface.replace(points=points, warp=(1.0, 0.3, 0.0)), cloth(), comm=comm,
                  wrinkles=wrinkles)  # fmt: skip
    if shell.wrinkles is not None:
        # some cells between beds
        beds = np.where(shell.cell_membrane.area > np.median(shell.cell_membrane.area), 4e5, 0.0)
        shell.cell_membrane.set_beds(beds, shell.w.x.array)
    whole = np.random.default_rng(seed).normal(size=(len(points), 6))
    move(shell, whole * [1e-3, 1e-3, 1e-3, 0.05, 0.05, 0.05])
    return shell


def move(shell, change):
    """Add changes (n, 6) in the surface's numbering to the nodal field."""
    shell.w.x.array.reshape(-1, 6)[:] += change[shell.partition.nodes]


def force_of(shell):
    """Internal force as the weak form has it, owned nodes."""
    vector = shell.partition.petsc_vector(6)
    with vector.localForm() as local:
        local.set(0.0)
    shell.internal_force(vector)
    vector.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)
    return vector.array.reshape(-1, 6).copy()


def along(shell, owned, direction):
    """Product of owned nodal values with a direction (n, 6), over all ranks."""
    return shell.comm.allreduce(float(np.vdot(owned, direction[shell.partition.owned_nodes])))


@pytest.mark.parametrize("wrinkles", KINDS)
def test_force_is_the_slope_of_the_energy(wrinkles, comm):
    shell = crumpled(wrinkles, comm)
    direction = np.random.default_rng(1).normal(size=(48, 6))
    work = along(shell, force_of(shell), direction)
    h, energies = 1e-7, []
    for step in (h, -2 * h):
        move(shell, step * direction)
        energies.append(sum(shell.energy().values()))
    assert (energies[0] - energies[1]) / (2 * h) == pytest.approx(work, rel=1e-6)


@pytest.mark.parametrize("wrinkles", KINDS)
def test_tangent_is_the_slope_of_the_force(wrinkles, comm):
    """Of a relaxed sheet up to the share of the taut stiffness that keeps the tangent regular."""
    shell = crumpled(wrinkles, comm)
    direction = np.random.default_rng(2).normal(size=(48, 6))
    matrix = shell.create_tangent()
    shell.tangent(matrix)
    matrix.assemble()
    x, product = shell.partition.petsc_vector(6), shell.partition.petsc_vector(6)
    x.setArray(direction[shell.partition.owned_nodes].ravel())
    matrix.mult(x, product)
    h, forces = 1e-7, []
    for step in (h, -2 * h):
        move(shell, step * direction)
        forces.append(force_of(shell))
    slope = (forces[0] - forces[1]) / (2 * h)
    found = product.array.reshape(-1, 6)
    scale = max(comm.allgather(np.abs(slope).max(initial=0.0)))
    bar = 1e-6 if wrinkles == "resolved" else 2e-3
    assert np.abs(found - slope).max(initial=0.0) < bar * scale


@pytest.mark.parametrize("wrinkles", KINDS)
def test_explicit_twin(wrinkles, comm):
    """The force of explicit steps, which no UFL is in, is that of the weak form."""
    shell = crumpled(wrinkles, comm)
    internal = InternalForce(shell)
    assert internal.quads is not None
    found = internal(shell.w.x.array)[: shell.partition.n_owned]
    wanted = force_of(shell)
    assert np.abs(found - wanted).max(initial=0.0) < 1e-10 * np.abs(wanted).max(initial=1e-300)


def test_states_of_all_kinds_are_met(comm):
    """The sheet of these tests has taut, wrinkled and slack cells: none is left untried."""
    shell = crumpled("relaxed", comm)
    shell.energy()
    counts = comm.allreduce(np.bincount(shell.cell_membrane.law.state, minlength=3))
    assert counts.min() > 0


@pytest.mark.parametrize("wrinkles", KINDS)
def test_patch(wrinkles, comm):
    """A constant strain, taut, has its exact energy on uneven quads."""
    shell = Shell(
        meshes.rectangle(0.7, 0.5, (7, 5), parameters=meshes.distorted((7, 5), 0.2)).replace(
            warp=(1.0, 0.0, 0.0)
        ),
        cloth(), comm=comm, wrinkles=wrinkles,
    )  # fmt: skip
    E = np.array([0.01, 0.02, 0.003])
    C = np.array([[1 + 2 * E[0], E[2]], [E[2], 1 + 2 * E[1]]])
    values, vectors = np.linalg.eigh(C)
    U = vectors @ np.diag(np.sqrt(values)) @ vectors.T
    change = np.zeros((48, 6))
    change[:, :2] = shell.surface.points[:, :2] @ (U - np.eye(2))
    move(shell, change)
    exact = 0.5 * E @ shell.fabric.membrane @ E * 0.35
    assert shell.energy()["membrane"] == pytest.approx(exact, rel=1e-9)
    # points of the surface are moved about its middle
    mine = shell.cell_membrane.strain(shell.w.x.array)
    assert np.abs(mine - E).max(initial=0.0) < 1e-12
