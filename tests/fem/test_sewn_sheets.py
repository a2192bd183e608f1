# SPDX-License-Identifier: LGPL-3.0-or-later
"""Shells with three cells at an edge: energies of two flat sheets sewn together, by hand."""

import numpy as np
import pytest

import meshes
import shellform as sf
from shellform.dynamics.mass_spring import Particles
from shellform.fem.director import rotation_matrix
from tests.meshes.sewn import tee, with_patch

CLOTH = sf.Fabric.isotropic(1e6, 0.3, thickness=0.5e-3, density=400.0, bending_stiffness=1e-5)


def sheets():
    """A square, and one with a patch of its middle cells that lies flat on it."""
    plain = meshes.rectangle(0.6, 0.6, (6, 6))
    middle = plain.points[plain.cells].mean(axis=1)
    chosen = (np.abs(middle[:, :2] - 0.3) < 0.2).all(axis=1)
    sewn = with_patch(plain, chosen, off=0.0)
    with pytest.warns(UserWarning, match="lie on another point"):
        return plain, sewn.replace(verify=True), chosen.sum() / len(chosen)


def energy(surface, move):
    shell = sf.Shell(surface, CLOTH)
    stepper = sf.Newmark(shell)
    stepper.owned[:, :3], stepper.owned[:, 3:] = move(stepper.points)
    stepper.owned[:, :3] -= stepper.points
    stepper.scatter()
    return sum(stepper.strain_energy().values())


@pytest.mark.parametrize("kind", ["stretched", "rolled", "turned"])
def test_energy_of_a_patch(kind):
    """Stretched or rolled evenly, the patch adds its share of the area; turned, nothing."""

    def move(x):
        up = np.tile([0.0, 0.0, 1.0], (len(x), 1))
        if kind == "stretched":
            return x * [1.02, 1.01, 1.0], up
        if kind == "turned":
            turn = rotation_matrix([0.3, -0.5, 0.8])
            return x @ turn.T, up @ turn.T
        radius, angle = 0.4, x[:, 0] / 0.4
        away = np.stack([np.sin(angle), 0 * angle, np.cos(angle)], axis=1)
        return radius * away + x * [0.0, 1.0, 0.0], away

    plain, sewn, share = sheets()
    one, both = energy(plain, move), energy(sewn, move)
    if kind == "turned":
        assert abs(both) < 1e-12
    else:
        assert both == pytest.approx((1 + share) * one, rel=1e-9) and one > 0


@pytest.mark.parametrize("degrees", [45, 90, 150])
def test_a_flap_turns_with_its_sheet(degrees):
    """A rigid rotation of sheets that meet at an angle costs nothing."""
    turn = rotation_matrix([0.3, -0.5, 0.8])
    sewn = tee(4, degrees)[0]
    shell = sf.Shell(sewn, CLOTH)
    stepper = sf.Newmark(shell)
    own = shell.partition.owned_nodes
    stepper.owned[:, :3] = sewn.points[own] @ turn.T - sewn.points[own]
    stepper.owned[:, 3:] = sewn.directors[own] @ turn.T
    stepper.scatter()
    assert abs(sum(stepper.strain_energy().values())) < 1e-14


@pytest.mark.parametrize(("degrees", "bar"), [(90, 0.15)])
def test_a_flap_is_a_cantilever(degrees, bar):
    """Tip deflection P L^3/(3 D) of a flap on a held sheet, of first order in the cell size.

    The cells at the seam are softer by the cosine of the director's lean.
    """
    width, push, bending = 0.4, 1e-7, 1e-5
    cloth = sf.Fabric.isotropic(
        1e6, 0.0, thickness=0.5e-3, density=400.0, bending_stiffness=bending
    )
    aside = np.array([-np.sin(np.radians(degrees)), 0.0, np.cos(np.radians(degrees))])
    errors = []
    for n in (4, 8):
        sewn, sheet, tip = tee(n, degrees, width)
        shell = sf.Shell(sewn, cloth)
        shell.supports.clamp(sheet)
        shell.loads.point(tip, push / len(tip) * aside)
        statics = sf.Statics(shell)
        statics.solve([1.0])
        moved = (shell.positions() - sewn.points)[tip] @ aside
        statics.destroy()
        exact = push * (0.5 * width) ** 3 / (3 * bending * width)
        errors.append(abs(moved.mean() / exact - 1))
    assert errors[1] < bar and errors[1] < 0.6 * errors[0]


@pytest.mark.parametrize("model", ["relaxed", pytest.param("particles", marks=pytest.mark.serial)])
def test_energy_of_a_patch_in_other_models(model):
    """Stretched evenly, or let go, the patch adds its share; a slack membrane bears little."""
    plain, sewn, share = sheets()

    def energy_of(surface, stretch):
        shell = sf.Shell(surface, CLOTH, wrinkles="relaxed" if model == "relaxed" else "resolved")
        stepper = Particles(shell) if model == "particles" else sf.Newmark(shell)
        stepper.owned[:, :2] = stretch * stepper.points[:, :2]
        stepper.scatter()
        return sum(stepper.strain_energy().values())

    one, both = energy_of(plain, 1e-3), energy_of(sewn, 1e-3)
    assert both == pytest.approx((1 + share) * one, rel=1e-9) and one > 0
    if model == "relaxed":
        one, both = energy_of(plain, -1e-2), energy_of(sewn, -1e-2)
        assert both == pytest.approx((1 + share) * one, rel=1e-9)
        assert both < 0.01 * energy_of(sewn, 1e-2)
