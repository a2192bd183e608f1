# SPDX-License-Identifier: LGPL-3.0-or-later
"""Implicit steps against a penalty and an augmented Lagrangian: a patch on an incline."""

import numpy as np
import pytest

import meshes
from demos.studies.contact_methods import implicit
from demos.studies.contact_methods.augmented_lagrangian import AugmentedNewmark
from shellform import Fabric, Shell

pytestmark = pytest.mark.serial
G, RADIUS, STIFFNESS, FRICTION, DT = 9.81, 1e4, 1e4, 0.5, 0.01


def patch(slope, turns, stiffness=STIFFNESS):
    """A square of 20 mm at rest on top of a sphere of 10 km, gravity tilted."""
    surface = meshes.rectangle(0.02, 0.02, (2, 2)).transform(translation=(-0.01, -0.01, 5e-4))
    shell = Shell(surface, Fabric.isotropic(1e6, 0.3, 1e-3, 200.0))
    angle = np.arctan(slope)
    shell.loads.gravity((G * np.sin(angle), 0.0, -G * np.cos(angle)))
    return AugmentedNewmark(
        shell, DT, [RADIUS] * 3, (0.0, 0.0, -RADIUS), FRICTION, stiffness, turns, alpha=-0.3
    )


def test_depth_and_stick():
    """A penalty lets the weight in by weight/k and gives way along; the other by the tolerance."""
    soft, hard = patch(0.4, 0), patch(0.4, implicit.TURNS)
    for stepper in (soft, hard):
        stepper.drag = 30.0
        implicit.advance(stepper, 0.4)
    angle = np.arctan(0.4)
    depth = 0.2 * G * np.cos(angle) / STIFFNESS
    assert -soft.shell.displacements()[:, 2].mean() == pytest.approx(depth, rel=0.02)
    assert np.abs(hard.shell.displacements()[:, 2]).max() < 2e-6 < 0.1 * depth
    weight = hard.mass.sum() * G
    before = hard.impulse.sum(axis=0)
    gone = hard.shell.displacements()[:, 0]
    implicit.advance(hard, 0.6)
    force = (hard.impulse.sum(axis=0) - before) / 0.2
    assert force == pytest.approx(
        [-weight * np.sin(angle), 0, weight * np.cos(angle)], abs=1e-3 * weight
    )
    assert np.abs(hard.shell.displacements()[:, 0] - gone).max() < 1e-6
    assert hard.turns_done and not hard.unsettled


def test_slip():
    """Above the angle of friction: x = g (sin - mu cos) t^2/2."""
    stepper, angle = patch(0.6, implicit.TURNS), np.arctan(0.6)
    implicit.advance(stepper, 0.1)
    x, v = stepper.shell.displacements()[:, 0].mean(), stepper.v[:, 0].mean()
    implicit.advance(stepper, 0.4)
    a = G * (np.sin(angle) - FRICTION * np.cos(angle))
    gone = stepper.shell.displacements()[:, 0].mean() - x
    assert gone == pytest.approx(0.3 * v + 0.5 * a * 0.3**2, rel=5e-3)
