# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a solved shell tells: displacements at any point, energy against work."""

import numpy as np
import pytest

import meshes
from shellform import Fabric, Shell, Statics
from tests.statics.test_load_stepping import ELEMENTS, moved, rolled, sail, same, strip


@pytest.mark.parametrize("element", ELEMENTS)
def test_displacement_at_any_point(element):
    """Nodes give their own value, points between them the field's, others a clear refusal."""
    degree, triangles = ELEMENTS[element]
    surface = meshes.rectangle(
        1.2, 1.0, (5, 4), degree=degree, triangles=triangles,
        parameters=meshes.distorted((5, 4), 0.25, seed=8),
    )  # fmt: skip
    shell = Shell(surface, Fabric.isotropic(1e6, 0.3, 0.02, 1000.0))
    gradient = np.random.default_rng(1).uniform(-1, 1, (3, 3))
    w = shell.w.x.array.reshape(-1, 6)
    w[:, :3] = surface.points[shell.partition.nodes] @ gradient.T
    for point in surface.points[:: len(surface.points) // 6]:
        assert shell.displacement_at(point) == pytest.approx(gradient @ point, abs=1e-12)
    for point in np.random.default_rng(2).uniform(0, 1, (20, 2)):
        point = np.array([1.2 * point[0], point[1], 0.0])
        assert shell.displacement_at(point) == pytest.approx(gradient @ point, abs=1e-9)
    for beyond in ([1.3, 0.5, 0.0], [0.5, 0.5, 0.05]):
        with pytest.raises(ValueError, match="is not on rectangle"):
            shell.displacement_at(beyond)


def test_displacement_at_nodes_of_a_curved_sheet():
    surface = sail(2)
    shell = Shell(surface, Fabric.isotropic(1e6, 0.3, 0.02, 1000.0))
    nodal = np.random.default_rng(3).uniform(-1, 1, surface.points.shape)
    shell.w.x.array.reshape(-1, 6)[:, :3] = nodal[shell.partition.nodes]
    for node in range(0, len(surface.points), 7):
        assert shell.displacement_at(surface.points[node]) == pytest.approx(nodal[node], abs=1e-8)


@pytest.mark.parametrize("element", ELEMENTS)
def test_energy_is_half_the_work_of_small_loads(element):
    """Clapeyron: linear, the strain energy is half of force times displacement."""
    shell = Shell(sail(*ELEMENTS[element]), Fabric.isotropic(1e6, 0.3, 0.02, 1000.0))
    shell.supports.clamp("left")
    force, at = np.array([1e-6, -2e-6, 3e-6]), (1.0, 0.8, 0.2)
    shell.loads.point(at, force)
    Statics(shell).solve(1)
    # displacements of 1e-7: products of them are lost beside 1
    work = 0.5 * force @ moved(shell, at)
    energy = shell.energy()
    assert sum(energy.values()) == pytest.approx(work, rel=1e-5)
    assert min(energy.values()) > 0.0


def test_energy_is_the_work_of_large_loads():
    """Large motion: the energy is the work of the load along its path, by Simpson's rule."""
    shell = strip(cells=(8, 1))
    shell.supports.clamp("left")
    shell.loads.line("right", (0.0, 0.0, 4.0))
    statics, path = Statics(shell), [0.0]
    for _ in statics.march(40):
        path.append(moved(shell, (12.0, 0.0, 0.0))[2])
    # force as a function of displacement: integral of F du = F u - integral of u dF
    u, n = np.array(path), 40
    simpson = (u[0] + u[-1] + 4 * u[1:-1:2].sum() + 2 * u[2:-1:2].sum()) / (3 * n)
    assert sum(shell.energy().values()) == pytest.approx(4.0 * (u[-1] - simpson), rel=1e-4)


def test_rest_starts_again():
    """`rest` and a new Statics give the same solution once more."""
    shell, statics = rolled(5, turns=0.5)
    first = shell.displacements()
    statics.destroy()
    shell.rest()
    assert np.abs(shell.displacements()).max() == 0.0
    Statics(shell).solve(5)
    assert same(shell.displacements(), first, 1e-9)
