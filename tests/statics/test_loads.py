# SPDX-License-Identifier: LGPL-3.0-or-later
"""Loads in statics: weight, lines, pressure, moments, amplitudes, and the reactions to them."""

import numpy as np
import pytest

import meshes
from shellform import Fabric, Shell, Statics
from tests.statics.test_load_stepping import ELEMENTS, moved, sail, same, strip


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
    force, moment = statics.reactions(), statics.reaction_moments()
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
