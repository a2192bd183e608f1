# SPDX-License-Identifier: LGPL-3.0-or-later
"""The neo-Hookean membrane against the closed form of a pull, in statics and in explicit steps."""

import numpy as np
import pytest

import meshes
from shellform import Fabric, FabricError, Shell, Statics
from shellform.dynamics.explicit import Newmark
from shellform.material.neo_hookean import NeoHookean

MU, THICKNESS = 2e5, 1e-3
KINDS = {"quads": (1, False), "triangles": (1, True), "nine nodes": (2, False)}


def force_per_width(stretch):
    """Of a pull [N/m], on the width at rest: t mu (lambda - lambda^-2)."""
    return THICKNESS * MU * (stretch - stretch**-2)


def pulled(stretch, degree=1, triangles=False):
    """A sheet 1 m by 0.5 m, free to become narrower, under the force of a stretch.

    Of irregular cells where the element meets a uniform strain on them exactly: all but nine nodes.
    """
    surface = meshes.rectangle(
        1.0, 0.5, (3, 2), degree=degree, triangles=triangles,
        parameters=meshes.distorted((3, 2), 0.2 if degree == 1 else 0.0, seed=1),
    )  # fmt: skip
    fabric = Fabric.isotropic(3 * MU, 0.5, THICKNESS, 1000.0)
    shell = Shell(surface, fabric, law=NeoHookean())
    shell.supports.hold("left", "x")
    shell.supports.hold("bottom", "y")
    shell.supports.hold(np.arange(len(surface.points)), "z")
    shell.loads.line("right", (force_per_width(stretch), 0.0, 0.0))
    return shell


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("stretch", [0.8, 1.3, 2.0])
def test_pull(kind, stretch):
    """Stretch, contraction and energy of every element, far beyond small strains."""
    shell = pulled(stretch, *KINDS[kind])
    with Statics(shell) as statics:
        statics.solve(4)
    X = shell.surface.points
    wanted = np.stack([(stretch - 1) * X[:, 0], (stretch**-0.5 - 1) * X[:, 1], 0 * X[:, 0]], 1)
    np.testing.assert_allclose(shell.displacements(), wanted, atol=1e-7)
    energy = 0.5 * MU * THICKNESS * (stretch**2 + 2 / stretch - 3) * shell.surface.area
    assert sum(shell.energy().values()) == pytest.approx(energy, rel=1e-6)


def test_explicit_steps_come_to_rest_where_statics_does():
    stretch = 1.4
    shell = pulled(stretch)
    stepper = Newmark(shell, drag=60.0)
    stepper.advance(0.5)
    X = shell.surface.points
    assert shell.displacements()[:, 0] == pytest.approx((stretch - 1) * X[:, 0], abs=1e-4)


def test_fabric_must_be_incompressible():
    with pytest.raises(FabricError, match=r"NeoHookean\(\) has the membrane stiffness .* give the"):
        Shell(
            meshes.rectangle(1.0, 1.0, (1, 1)),
            Fabric.isotropic(3 * MU, 0.3, THICKNESS, 1000.0),
            law=NeoHookean(),
        )
