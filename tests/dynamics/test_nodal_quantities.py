# SPDX-License-Identifier: LGPL-3.0-or-later
"""Mass, inertia and internal force at the nodes, as explicit steps use them."""

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np
import pytest

import meshes
from shellform import Shell
from shellform.dynamics.explicit import Newmark
from shellform.dynamics.explicit_drift import drift
from shellform.fem.internal_force import InternalForce, by_segments
from shellform.fem.lumped_mass import lumped, nodal_areas
from tests.dynamics.test_explicit import ELEMENTS, FABRICS, sheet


@pytest.mark.parametrize("element", ELEMENTS)
def test_nodal_areas_share_out_the_area(element):
    degree, triangles = ELEMENTS[element]
    surface = sheet(5, degree, triangles).surface
    areas = nodal_areas(surface)
    assert areas.min() > 0
    assert areas.sum() == pytest.approx(1.0, rel=1e-13)


def test_rotary_inertia_is_never_below_the_physical():
    shell = sheet(4)
    mass, inertia = lumped(shell.surface, shell.fabric, rotary_scale=0.0)
    assert inertia == pytest.approx(mass * shell.fabric.thickness**2 / 12, rel=1e-13)
    _, scaled = lumped(shell.surface, shell.fabric)
    assert np.all(scaled >= inertia)


def curved(degree, triangles, fabric):
    """A distorted piece of a cylinder, its warp turning from cell to cell."""
    surface = meshes.cylinder(
        0.5, 1.0, (5, 4), angle=1.5, degree=degree, triangles=triangles,
        parameters=meshes.distorted((5, 4), 0.25, seed=5),
    )  # fmt: skip
    middle = surface.points[surface.cells].mean(axis=1)
    around = np.cross([0, 0, 1.0], middle)
    return Shell(surface.replace(warp=around + [0, 0, 0.3]), fabric)


@pytest.mark.parametrize("fabric", ["isotropic", "woven"])
@pytest.mark.parametrize(
    "element",
    [pytest.param(e, marks=pytest.mark.thorough if e == "nine nodes" else ()) for e in ELEMENTS],
)
def test_internal_force_equals_that_of_the_static_forms(element, fabric):
    """The force of explicit steps, by segments or packed kernels, is that of the weak form."""
    shell = curved(*ELEMENTS[element], FABRICS[fabric])
    newmark_force = InternalForce(shell)
    assert by_segments(shell) == (element == "quad")
    X = shell.surface.points[shell.partition.nodes]
    w = shell.w.x.array.reshape(-1, 6)
    w[:, :3] += 0.1 * np.sin(3 * X[:, [1, 2, 0]])
    w[:, 3:] += 0.1 * np.cos(4 * X)
    r = newmark_force(w)[: shell.partition.n_owned].copy()
    vector = shell.partition.petsc_vector(6)
    shell.internal_force(vector)
    vector.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)
    largest = shell.comm.allreduce(np.abs(r).max(), MPI.MAX)
    assert np.abs(r.ravel() - vector.array_r).max() < 1e-12 * largest


def test_directors_on_a_symmetry_plane_start_in_it():
    """Averaged normals lean out of a plane of symmetry: the supports' correction is taken over."""
    surface = meshes.cylinder(0.5, 1.0, (6, 2), angle=np.pi / 2)
    leaning = surface.directors + [0.0, 0.05, 0.0]
    leaning /= np.linalg.norm(leaning, axis=1, keepdims=True)
    shell = Shell(surface.replace(directors=leaning), FABRICS["isotropic"])
    shell.supports.symmetry("start", (0.0, 1.0, 0.0))
    Newmark(shell)
    edge = shell.partition.find("start")
    assert np.abs(shell.directors()[edge, 1]).max() < 1e-15
    assert sum(shell.energy().values()) == 0.0


@pytest.mark.parametrize("angles", [[0.0, 1e-9, 1e-3, 0.0999, 0.1001, 1.0], [0.0, 1e-9, 0.099]])
def test_directors_turn_by_the_angle_of_their_speed(angles):
    """Both sides of where the series of sine and cosine ends, and a director at rest.

    With the small turns alone the series serves all nodes.
    """
    angles = np.array(angles)
    w, v, q = np.zeros((len(angles), 6)), np.zeros((len(angles), 3)), np.zeros((len(angles), 3))
    w[:, 3], q[:, 1], v[:, 2] = 1.0, angles / 1e-4, 1.0
    assert drift(w, v, q, 1e-4) == pytest.approx(w.sum(), rel=1e-14)
    assert np.array_equal(w[:, :3], np.outer(np.ones(len(angles)), [0.0, 0.0, 1e-4]))
    turned = np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1)
    along = np.stack([-np.sin(angles), np.cos(angles), 0 * angles], axis=1)
    assert np.abs(w[:, 3:] - turned).max() < 4e-16
    assert np.abs(q - angles[:, None] / 1e-4 * along).max() < 4e-16 / 1e-4


@pytest.mark.parametrize("speed", [1.0, 5e3])
def test_what_leaves_the_finite_numbers_is_seen(speed):
    """By the sum that a drift returns, whether turns are small or large, and of what it is."""
    rng = np.random.default_rng(0)
    for array, at in ((0, (4, 1)), (0, (4, 5)), (1, (7, 0)), (2, (9, 2))):
        for bad in (np.nan, np.inf):
            w, v = rng.standard_normal((11, 6)), rng.standard_normal((11, 3))
            q = speed * rng.standard_normal((11, 3))
            w[:, 3:] /= np.linalg.norm(w[:, 3:], axis=1, keepdims=True)
            (w, v, q)[array][at] = bad
            assert not np.isfinite(drift(w, v, q, 1e-4))
