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


def support_moments(statics):
    """Moments (n, 3) [N m] by which the supports act on the directors."""
    equilibrium, partition = statics.equilibrium, statics.shell.partition
    turning = equilibrium.reaction[:, 3:] * equilibrium.length
    on_director = np.einsum("nij,nj->ni", equilibrium.T[: equilibrium.n_owned], turning)
    directors = statics.shell.directors()[partition.owned_nodes]
    return partition.gather(np.cross(directors, on_director))


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


# --- units and place --------------------------------------------------------------------------


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


# --- load stepping ----------------------------------------------------------------------------


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


# --- supports ---------------------------------------------------------------------------------


def test_stretched_by_a_prescribed_displacement():
    """One per cent of stretch: the exact force A e (1 + u/L) of St. Venant-Kirchhoff."""
    shell = strip(cells=(4, 3), parameters=meshes.distorted((4, 3), 0.2, seed=1))
    stretch = 1.01
    shell.supports.clamp("left")
    shell.supports.move("right", displacement=((stretch - 1) * 12.0, 0.0, 0.0))
    statics = Statics(shell)
    statics.solve(1)
    force = statics.reactions()
    right = shell.partition.find("right")
    exact = shell.fabric.membrane[0, 0] * (stretch**2 - 1) / 2 * stretch
    assert force[right].sum(axis=0) == pytest.approx([exact, 0.0, 0.0], rel=1e-9, abs=1e-9 * exact)
    assert force.sum(axis=0) == pytest.approx(np.zeros(3), abs=1e-9 * exact)
    assert moved(shell, (12.0, 1.0, 0.0))[0] == pytest.approx(0.12, rel=1e-12)


def test_end_director_turned_by_a_quarter():
    """A quarter turn of the end's directors, its edge free to move: the moment is D kappa b."""
    shell = strip(cells=(16, 1), thickness=0.05)
    shell.supports.clamp("left")
    angle = 0.5 * np.pi
    shell.supports.move(
        "right", director=lambda level: (-np.sin(level * angle), 0.0, np.cos(level * angle))
    )
    statics = Statics(shell)
    statics.solve(5)
    right = shell.partition.find("right")
    assert np.abs(shell.directors()[right] - [-1.0, 0.0, 0.0]).max() < 1e-12
    force, moment = statics.reactions(), support_moments(statics)
    kappa = angle / 12.0
    exact = shell.fabric.bending[0, 0] * kappa
    # cells of 5.6 degrees: series of the turning angle true to 1e-6
    assert -moment[right].sum(axis=0)[1] == pytest.approx(exact, rel=1e-4)
    assert moment.sum(axis=0) == pytest.approx(np.zeros(3), abs=1e-6 * exact)
    assert np.abs(force).max() < 1e-6 * exact / 0.05
    tip = np.array([np.sin(angle) / kappa - 12.0, 0.0, (1 - np.cos(angle)) / kappa])
    assert same(moved(shell, (12.0, 0.0, 0.0)), tip, 1e-4)


def test_symmetry_halves_a_sheet():
    """Half a sheet on its plane of symmetry moves as the whole does."""

    def pushed(length, cells, ends):
        surface = meshes.rectangle(length, 0.8, cells)
        shell = Shell(surface, Fabric.isotropic(1e6, 0.3, 0.02, 1000.0))
        for edge in ends:
            shell.supports.clamp(edge)
        shell.loads.surface(lambda x: np.column_stack([0 * x[:, :2], 300 * (x[:, 1] + 0.2)]))
        return shell

    whole = pushed(2.0, (12, 5), ("left", "right"))
    half = pushed(1.0, (6, 5), ("left",))
    half.supports.symmetry("right", (1.0, 0.0, 0.0))
    for shell in (whole, half):
        Statics(shell).solve(3)
    left = whole.surface.points[:, 0] < 1 + 1e-9
    order = [np.lexsort(s.surface.points[k].T) for s, k in ((whole, left), (half, slice(None)))]
    u = whole.displacements()[left][order[0]]
    assert np.abs(u[:, 2]).max() > 2 * 0.02  # many thicknesses: far from linear
    assert same(half.displacements()[order[1]], u, 1e-8)


@pytest.mark.parametrize("degree", [1, 2])
def test_inclined_plane_of_symmetry(degree):
    """A wedge between planes at 0 and 50 (40) degrees moves as the whole ring does."""

    def loaded(cells, **options):
        surface = meshes.annulus(0.2, 1.0, cells, degree=degree, **options)
        shell = Shell(surface, Fabric.isotropic(1e6, 0.3, 0.02, 1000.0))
        shell.supports.clamp("outer")
        shell.loads.pressure(300.0)
        return shell

    around, part = {1: (36, 5), 2: (18, 2)}[degree]
    angle = 2 * np.pi * part / around
    ring, wedge = loaded((around, 4), slit=False), loaded((part, 4), angle=angle)
    wedge.supports.symmetry("start", (0.0, 1.0, 0.0))
    wedge.supports.symmetry("end", (-np.sin(angle), np.cos(angle), 0.0))
    for shell in (ring, wedge):
        Statics(shell).solve(3)
    points, u = ring.surface.points, ring.displacements()
    nearest = [np.linalg.norm(points - p, axis=1).argmin() for p in wedge.surface.points]
    assert np.abs(points[nearest] - wedge.surface.points).max() < 1e-12
    assert np.abs(u[:, 2]).max() > 2 * 0.02
    assert same(wedge.displacements(), u[nearest], 1e-8)


def test_inclined_axes_give_the_answer_of_upright_ones():
    """A strip turned in space and supported in its own axes does what the upright one does."""

    def bent(turn):
        surface = sail().transform(rotation=turn)
        shell = Shell(surface, Fabric.isotropic(1e6, 0.3, 0.02, 1000.0))
        shell.supports.hold_normal("left", turn[:, 0])
        shell.supports.hold_normal("left", turn[:, 2])
        shell.supports.hold_director("left")
        shell.supports.hold_normal("bottom", turn[:, 1])
        shell.loads.line("right", turn @ [0.5, 0.5, 2.0])
        statics = Statics(shell)
        statics.solve(4)
        return shell.displacements() @ turn, statics.reactions() @ turn

    c, s = np.cos(0.7), np.sin(0.7)
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ np.array(
        [[1, 0, 0], [0, c, -s], [0, s, c]]
    )
    upright, inclined = bent(np.eye(3)), bent(turn)
    assert np.abs(upright[0]).max() > 0.1
    assert same(inclined[0], upright[0], 1e-8)
    assert same(inclined[1], upright[1], 1e-6)


# --- loads ------------------------------------------------------------------------------------


def total_load(statics):
    """Sum of the dead nodal forces [N] at the level reached."""
    shell = statics.shell
    nodal = np.zeros((shell.partition.n_owned, 3))
    nodal = shell.loads.force_at(statics.level, nodal)
    return shell.partition.gather(nodal).sum(axis=0)


@pytest.mark.parametrize("element", ELEMENTS)
def test_reactions_carry_the_weight(element):
    """The supports of a hanging sheet carry mass times g, and hold it in equilibrium of moments."""
    surface = sail(*ELEMENTS[element])
    shell = Shell(surface, Fabric.isotropic(2e6, 0.3, 0.02, 30.0))
    shell.supports.clamp("left")
    g = np.array([0.0, 2.0, -9.81])
    shell.loads.gravity(g)
    statics = Statics(shell)
    statics.solve(3)
    assert np.abs(shell.displacements()).max() > 0.05
    force, moment = statics.reactions(), support_moments(statics)
    weight = total_load(statics)
    assert force.sum(axis=0) == pytest.approx(-weight, rel=1e-6, abs=1e-6)
    # the area of a warped cell is a square root, which no rule integrates exactly
    assert weight == pytest.approx(shell.fabric.areal_mass * surface.area * g, rel=1e-4)
    nodal = np.zeros((shell.partition.n_owned, 3))
    nodal = shell.partition.gather(shell.loads.force_at(1.0, nodal))
    about_origin = np.cross(shell.positions(), force + nodal).sum(axis=0) + moment.sum(axis=0)
    assert about_origin == pytest.approx(np.zeros(3), abs=1e-6 * np.abs(weight).max())


@pytest.mark.parametrize("element", ELEMENTS)
def test_reactions_carry_the_load(element):
    """Line, point and surface loads: the supports carry their sum, in a bent state."""
    surface = sail(*ELEMENTS[element])
    shell = Shell(surface, Fabric.isotropic(2e6, 0.3, 0.02, 1000.0))
    shell.supports.clamp("left")
    line, point, traction = np.array([0.3, 0.1, 2.0]), np.array([0.5, -0.7, 0.9]), [0.1, 0.0, 2.0]
    shell.loads.line("top", line)
    shell.loads.point((1.0, 0.8, 0.2), point)
    shell.loads.surface(traction)
    statics = Statics(shell)
    statics.solve(3)
    assert np.abs(shell.displacements()).max() > 0.05
    total = total_load(statics)
    assert statics.reactions().sum(axis=0) == pytest.approx(-total, rel=1e-6, abs=1e-6)
    exact = line * edge_length(surface, "top") + point + np.array(traction) * surface.area
    assert total == pytest.approx(exact, rel=1e-4)


def edge_length(surface, edge, samples=2000):
    """Length of a line of straight or quadratic segments, by sampling."""
    ends = surface.points[surface.edges[edge]]
    x = np.linspace(0, 1, samples + 1)[:, None, None]
    a, b = ends[:, 0], ends[:, 1]
    middle = ends[:, 2] if surface.degree == 2 else 0.5 * (a + b)
    line = (1 - x) * (1 - 2 * x) * a + x * (2 * x - 1) * b + 4 * x * (1 - x) * middle
    return np.linalg.norm(np.diff(line, axis=0), axis=2).sum()


# Measured: 9-node quads 6e-7, quads 2.4e-4, triangles 1.2e-3: their pressure works on chords.
@pytest.mark.parametrize(
    ("element", "cells", "bar"),
    [("nine nodes", 8, 1e-5), ("quad", 16, 1e-3), ("triangle", 16, 2e-3)],
)
def test_pressure_stretches_a_cylinder(element, cells, bar):
    """Hoop stretch l of a cylinder under pressure p: A (l^2 - 1)/2 = p R, here 10 per cent."""
    degree, triangles = ELEMENTS[element]
    surface = meshes.cylinder(
        1.0, 0.4, (cells, 2), angle=np.pi / 2, degree=degree, triangles=triangles
    )
    shell = Shell(surface, Fabric.isotropic(1e6, 0.0, 1e-3, 1000.0))
    for edge in ("bottom", "top"):
        shell.supports.symmetry(edge, (0.0, 0.0, 1.0))
    shell.supports.symmetry("start", (0.0, 1.0, 0.0))
    shell.supports.symmetry("end", (1.0, 0.0, 0.0))
    stretch = 1.1
    shell.loads.pressure(shell.fabric.membrane[0, 0] * (stretch**2 - 1) / 2)
    Statics(shell).solve(4)
    radius = np.linalg.norm(shell.positions()[:, :2], axis=1)
    # bending of a wall of t/R = 1e-3 adds 1e-7
    assert radius == pytest.approx(np.full(len(radius), stretch), rel=bar)


def ball(cells, degree):
    """Upper half of a unit sphere: the disc's points moved onto it."""
    flat = meshes.disc(1.0, cells, degree)
    x, y, _ = flat.points.T
    r = np.hypot(x, y)
    polar = 0.5 * np.pi * r
    across = np.where(r > 0, np.sin(polar) / np.where(r > 0, r, 1.0), 0.0)
    points = np.column_stack([across * x, across * y, np.cos(polar)])
    return flat.replace(points=points, directors=points / np.linalg.norm(points, axis=1)[:, None])


# Measured on the mean: 6.6e-3 for quads, 1.7e-3 with half the cell size; 1.8e-5 for 9-node quads.
@pytest.mark.parametrize(("degree", "cells", "bar"), [(1, 12, 1e-2), (2, 6, 1e-3)])
def test_pressure_inflates_a_sphere(degree, cells, bar):
    """Strain p R (1 - nu) / (2 E t) of a thin sphere under a small pressure."""
    surface = ball(cells, degree)
    fabric = Fabric.isotropic(1e6, 0.3, 0.01, 1000.0)
    shell = Shell(surface, fabric)
    shell.supports.symmetry("rim", (0.0, 0.0, 1.0))
    shell.supports.hold((1.0, 0.0, 0.0), "y")
    shell.supports.hold((-1.0, 0.0, 0.0), "y")
    shell.supports.hold((0.0, 1.0, 0.0), "x")
    pressure = 1e-2
    shell.loads.pressure(pressure)
    Statics(shell).solve(1)
    radial = np.einsum("ni,ni->n", shell.displacements(), surface.points)
    exact = pressure * (1 - 0.3) / (2 * 1e6 * 0.01)
    assert radial.mean() == pytest.approx(exact, rel=bar)


def test_pressure_acts_on_the_moving_surface():
    """Follower load: the force on a strip bent to a quarter circle is that on its present area."""
    shell = strip(cells=(16, 2), length=1.0, width=0.5, thickness=0.02)
    for edge in ("left", "right"):
        shell.supports.hold(edge)
    shell.loads.pressure(2000.0)
    statics = Statics(shell)
    statics.solve(5)
    force = statics.reactions()
    # the ends stay in place, so p times the projected area is the length times the width
    assert force.sum(axis=0) == pytest.approx([0.0, 0.0, -2000.0 * 0.5], rel=1e-6, abs=1e-3)
    assert np.abs(shell.displacements()[:, 2]).max() > 0.1


def test_point_moments_make_an_edge_moment():
    """Half of the moment at each end of an edge is the moment along it."""

    def tip(load):
        shell = strip(cells=(8, 1))
        shell.supports.clamp("left")
        load(shell, -0.5 * np.pi * shell.fabric.bending[0, 0] / 12.0)
        Statics(shell).solve(4)
        return shell.displacements()

    def points(shell, moment):
        shell.loads.point_moment((12.0, 0.0, 0.0), (0.0, 0.25 * moment, 0.0))
        shell.loads.point_moment((12.0, 0.0, 0.0), (0.0, 0.25 * moment, 0.0))
        shell.loads.point_moment((12.0, 1.0, 0.0), (0.0, 0.5 * moment, 0.0))

    along = tip(lambda shell, moment: shell.loads.edge_moment("right", (0.0, moment, 0.0)))
    assert np.abs(along).max() > 1.0
    assert same(tip(points), along, 1e-9)


def test_amplitude_of_a_load():
    """A load follows its own function of the level; two halves make a whole."""

    def tip(*amplitudes):
        shell = strip(cells=(8, 1))
        shell.supports.clamp("left")
        for amplitude in amplitudes:
            shell.loads.line("right", (0.0, 0.0, 4.0), amplitude)
        Statics(shell).solve(5)
        return moved(shell, (12.0, 0.0, 0.0))

    reference = tip(None)
    assert tip(lambda level: level**2) == pytest.approx(reference, rel=1e-7)
    assert tip(lambda level: 0.25 * level, lambda level: 0.75 * level) == pytest.approx(
        reference, rel=1e-7
    )


# --- results ----------------------------------------------------------------------------------


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
