# SPDX-License-Identifier: LGPL-3.0-or-later
"""Supports in statics: prescribed motion, planes of symmetry, inclined axes."""

import numpy as np
import pytest

import meshes
from shellform import Fabric, Shell, Statics
from tests.statics.test_load_stepping import moved, sail, same, strip


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
    force, moment = statics.reactions(), statics.reaction_moments()
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
