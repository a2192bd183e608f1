# SPDX-License-Identifier: LGPL-3.0-or-later
"""Statics: invariance, load stepping, supports, loads and reactions against exact values."""

import warnings

from petsc4py import PETSc

import numpy as np
import pytest

import meshes
from shellform import Fabric, NotConverged, Shell, Statics

pytestmark = pytest.mark.filterwarnings("ignore::shellform.material.fabric.UnitWarning")

ELEMENTS = {"quad": (1, False), "triangle": (1, True), "nine nodes": (2, False)}


def moved(shell, point):
    """Displacement of the node at a point."""
    return shell.displacements()[shell.partition.find(point)[0]]


def same(one, other, bar):
    """Largest difference between two fields, against the largest value, within a bar."""
    return np.abs(one - other).max() <= bar * np.abs(other).max()


@pytest.fixture
def petsc_options():
    """Set PETSc options for one test: afterwards none of the prefix is left."""
    options = PETSc.Options()
    yield options
    for name in list(options.getAll()):
        if name.startswith("shell_"):
            options.delValue(name)


def sail(degree=1, triangles=False):
    """A curved, distorted sheet of one metre with an exact normal."""
    cells = (6, 5)

    def place(a, b):
        return a, 0.8 * b, 0.3 * a * (1 - a) + 0.2 * b**2

    def normal(a, b):
        n = np.array([-(0.3 - 0.6 * a), -0.5 * b, np.ones_like(a)])
        return n / np.linalg.norm(n, axis=0)

    return meshes.patch(
        place, cells, degree, triangles, normal=normal, warp=(1.0, 0.3, 0.0),
        parameters=meshes.distorted(cells, 0.2, seed=6),
    )  # fmt: skip


def sail_under_load(surface, unit=1.0):
    """Displacements [m] of the sail, computed with lengths in multiples of a unit [m] and in N."""
    s = 1.0 / unit
    E, thickness = 2e6 / s**2, 0.02 * s
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # 20 "m" of thickness are meant
        fabric = Fabric.orthotropic(E, E / 3, 0.2, E / 10, E / 10, E / 12, thickness, 1000.0 / s**3)
    shell = Shell(surface, fabric)
    shell.supports.clamp("left")
    shell.loads.line("right", np.array([0.2, -0.5, 2.0]) / s)
    shell.loads.pressure(3.0 / s**2)
    shell.loads.edge_moment("right", (0.1, 0.3, -0.1))
    statics = Statics(shell)
    statics.solve(5)
    statics.destroy()
    return shell.displacements() / s


@pytest.mark.parametrize("element", ELEMENTS)
def test_units_do_not_matter(element):
    """In mm, m and km the same answer to 1e-8; the deflection is large."""
    surface = sail(*ELEMENTS[element])
    metres = sail_under_load(surface)
    assert np.abs(metres).max() > 0.1
    for unit in (1e-3, 1e3):
        assert same(sail_under_load(surface.transform(scale=1 / unit), unit), metres, 1e-8)


@pytest.mark.parametrize("element", ELEMENTS)
def test_origin_does_not_matter(element):
    """Shifted by 1e4 lengths: what changes is the rounding of the coordinates, nothing else."""
    surface, shift = sail(*ELEMENTS[element]), np.array([1e4, -2e4, 1e4])
    here = sail_under_load(surface)
    assert np.abs(here).max() > 0.1
    there = sail_under_load(surface.transform(translation=shift))
    # half a unit in the last place of 2e4 moves nodes by 2e-12; measured 2e-12 to 4e-12 here
    assert same(there, here, 1e-8)
    # a sheet with the same rounding, brought back, shows that nothing else is lost
    rounded = surface.replace(points=(surface.points + shift) - shift, directors=surface.directors)
    explained = sail_under_load(rounded)
    assert same(there, explained, 1e-11)


def strip(cells=(12, 1), length=12.0, width=1.0, thickness=0.1, nu=0.0, **options):
    surface = meshes.rectangle(length, width, cells, **options)
    return Shell(surface, Fabric.isotropic(1.2e6, nu, thickness, 1000.0))


def rolled(levels, turns=1.0, thickness=0.01, **more):
    """A strip clamped at its left and rolled by an end moment, and its Statics."""
    shell = strip(thickness=thickness)
    shell.supports.clamp("left")
    D = shell.fabric.bending[0, 0]
    shell.loads.edge_moment("right", (0.0, -2 * np.pi * turns * D / 12.0, 0.0))
    statics = Statics(shell, **more)
    statics.solve(levels)
    return shell, statics


def test_cut_back_and_growth():
    """A step too large is cut back, the answer is that of small steps."""
    small, even = rolled(20)
    large, statics = rolled(1)
    assert even.cutbacks == 0 < statics.cutbacks
    assert statics.level == 1.0 == statics.steps[-1].level
    parts = np.diff([0.0, *(step.level for step in statics.steps)])
    assert np.all(parts > 0)
    assert np.sum(parts) == pytest.approx(1.0)
    # both stop at a residual of 1e-8 of the load; thin sheets multiply it by (L/t)^2 at most
    assert same(large.displacements(), small.displacements(), 1e-6)


def test_steps_grow_again():
    """Where only the first quarter of the way is hard, the steps after it are longer."""
    shell = strip(thickness=0.01)
    shell.supports.clamp("left")
    D = shell.fabric.bending[0, 0]
    shell.loads.edge_moment(
        "right", (0.0, -2 * np.pi * D / 12.0, 0.0), lambda level: min(4 * level, 1.0)
    )
    statics = Statics(shell)
    statics.solve(1)
    parts = np.diff([0.0, *(step.level for step in statics.steps)])
    assert statics.cutbacks > 0
    assert parts.max() >= 4 * parts.min()
    assert same(shell.displacements(), rolled(20)[0].displacements(), 1e-6)


def test_march_yields_every_level_asked_for():
    """Levels come out as asked, whatever sub-steps lie between; unloading comes back to rest."""
    shell = strip(thickness=0.01)
    shell.supports.clamp("left")
    D = shell.fabric.bending[0, 0]
    shell.loads.edge_moment("right", (0.0, -2 * np.pi * D / 12.0, 0.0))
    statics = Statics(shell)
    asked = [0.3, 1.0, 0.6, 0.0]
    assert [step.level for step in statics.march(asked)] == asked
    assert len(statics.steps) >= len(asked)
    assert np.abs(shell.displacements()).max() < 1e-8


def shallow_arch():
    """Hinged at both ends, pushed down at its crown: snaps through at 0.74 of the full load."""
    rise = 0.3
    radius = (1 + rise**2) / (2 * rise)

    def place(a, b):
        x = 2 * a - 1
        return x, 0.5 * b, np.sqrt(radius**2 - x**2) - (radius - rise)

    shell = Shell(meshes.patch(place, (16, 1)), Fabric.isotropic(1e6, 0.0, 0.05, 1.0))
    for edge in ("left", "right"):
        shell.supports.hold(edge)
    for edge in ("bottom", "top"):
        shell.supports.symmetry(edge, (0.0, 1.0, 0.0))
    shell.loads.point(lambda x: np.abs(x[:, 0]) < 1e-9, (0.0, 0.0, -25.0))
    return shell, (0.0, 0.0, rise)


def test_not_converged_keeps_the_last_good_state():
    """Past its limit load an arch has no equilibrium near by: the last one before is kept."""
    shell, crown = shallow_arch()
    statics = Statics(shell)
    kept = []
    with pytest.raises(NotConverged) as caught:
        for step in statics.march(20):
            kept.append(step.level)
    assert statics.level == statics.steps[-1].level >= kept[-1] > 0.0
    assert statics.level < 1.0
    for words in (f"level {statics.level:.6g}", "diverged", "is kept", "limit point"):
        assert words in str(caught.value)
    deflection = moved(shell, crown)[2]
    assert np.isfinite(shell.displacements()).all()
    # the state that is kept is in equilibrium at the level that is kept ...
    statics.equilibrium.start(statics.level)
    statics.equilibrium.residual(statics.equilibrium.x, statics.equilibrium.F)
    assert statics.equilibrium.F.norm() <= 1e-6 * statics.equilibrium.force_scale()
    # ... and the one that other steps to that level find
    other, _ = shallow_arch()
    Statics(other).solve(np.linspace(0, statics.level, 8)[1:])
    assert moved(other, crown)[2] == pytest.approx(deflection, rel=1e-4)


def test_reasons_in_words():
    """Every step says how it converged."""
    _, statics = rolled(20)
    assert {step.reason.split()[0] for step in statics.steps} == {"converged"}
    assert all(np.isfinite(step.residual) for step in statics.steps)


def test_petsc_options_are_honoured(petsc_options):
    """-shell_snes_max_it 1 makes the solve fail and say so; other prefixes are not concerned."""
    petsc_options["shell_snes_max_it"] = 1
    with pytest.raises(NotConverged, match="diverged max it"):
        rolled(20)
    _, statics = rolled(20, prefix="other_")
    assert statics.level == 1.0


def test_user_options_win(petsc_options):
    """A tolerance of the user's replaces the default, whatever was solved before."""
    rolled(1, turns=0.01)  # leaves its defaults in PETSc's database
    petsc_options["shell_snes_rtol"] = 1e-3
    _, statics = rolled(20)
    _, tight = rolled(20, prefix="other_")
    iterations = [sum(step.iterations for step in s.steps) for s in (statics, tight)]
    assert iterations[0] < iterations[1]
