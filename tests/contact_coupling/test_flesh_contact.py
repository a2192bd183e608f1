# SPDX-License-Identifier: LGPL-3.0-or-later
"""A shell on flesh: pressure of a sleeve, weight at rest, ranks, restart, what is refused."""

import numpy as np
import pytest
from scipy.optimize import brentq

import meshes
from shellform import (
    Body,
    Contact,
    Fabric,
    Fixed,
    Flesh,
    ImplicitNewmark,
    Ledger,
    Newmark,
    Particles,
    Segment,
    Shell,
)
from shellform.dynamics import checkpoint
from tests.contact.solver.surfaces import tube
from tests.contact_coupling.layers import ball_of_triangles
from tests.ranks import launch

G = 9.81
CLOTH = Fabric.isotropic(1e6, 0.3, 1e-3, 200.0)


def limb(radius):
    return Body([Segment("arm", (radius, radius, 200.0), Fixed())])


def limb_of_triangles(radius):
    return tube(radius, 0.3, 24, 8, name="arm")


@pytest.mark.parametrize(("k", "arm"), [(1e5, limb), (6.7e5, limb), (1e5, limb_of_triangles)])
def test_a_sleeve_on_a_soft_cylinder(k, arm):
    """Laplace: the hoop tension at the radius that flesh has given way to is k d times it."""
    rest, radius, long = 0.048, 0.05, 0.1
    surface = meshes.cylinder(rest, long, (40, 6)).transform(translation=(0, 0, -0.5 * long))
    shell = Shell(surface.replace(warp=(0.0, 0.0, 1.0)), Fabric.isotropic(1e6, 0.0, 1e-3, 200.0))
    points = surface.points[shell.partition.nodes]
    shell.w.x.array.reshape(-1, 6)[:, :3] = (radius / rest - 1) * points * [1.0, 1.0, 0.0]
    stepper = Newmark(shell, 0.9, damping=2e-4, drag=60.0)
    touch = stepper.add(Contact(arm(radius - 5e-4), 0.0, flesh=Flesh(k)))
    stepper.advance(0.1)
    touch.correction.reset()
    stepper.advance(0.14)

    def tension(r):  # pushed forward from the second Piola-Kirchhoff stress
        return 1e3 * 0.5 * ((r / rest) ** 2 - 1) * r / rest

    # on areas at rest, see contact/body/flesh_bed.py
    depth = brentq(lambda d: k * d * rest - tension(radius - d), 0.0, radius - rest)
    assert depth > 1e-4
    radii = np.hypot(*shell.positions()[:, :2].T)
    assert radius - radii.mean() == pytest.approx(depth, rel=1e-2)
    force = shell.partition.gather(touch.window.impulse / touch.window.seconds)
    total = np.sum(force * surface.points * [1, 1, 0] / rest)
    assert total == pytest.approx(2 * np.pi * long * tension(radius - depth), rel=1e-2)


def draped(kind=Newmark, cells=8, body=None):
    """A square of 0.3 m on a soft ball."""
    surface = meshes.rectangle(0.3, 0.3, (cells, cells)).transform(translation=(-0.14, -0.15, 0.0))
    shell = Shell(surface, CLOTH)
    shell.loads.gravity((0.0, 0.0, -G))
    stepper = kind(shell, 0.8, drag=8.0)
    ball = Body([Segment("ball", (0.2, 0.2, 0.2), Fixed((0.0, 0.0, -0.2)))])
    return stepper, stepper.add(Contact(body or ball, 0.4, flesh=Flesh(2e4, 1e4, 20.0, 1e4, 0.05)))


@pytest.mark.parametrize("kind", [Newmark, pytest.param(Particles, marks=pytest.mark.serial)])
def test_cloth_rests_with_its_weight_on_flesh(kind):
    stepper, _ = draped(kind)
    ledger = stepper.add(Ledger())
    stepper.advance(2.0)
    ledger.record()
    stepper.advance(2.4)
    row = ledger.record()
    weight = CLOTH.areal_mass * 0.09 * G
    assert row["force_ball_z"] == pytest.approx(weight, rel=2e-3)
    assert row["momentum_residual"] < 1e-9 * weight


@pytest.mark.parametrize("body", [None, ball_of_triangles()], ids=["ellipsoid", "triangles"])
def test_it_goes_on_bit_for_bit(body, shared_tmp_path):
    path = shared_tmp_path / "checkpoint.npz"
    stepper, _ = draped(body=body)
    stepper.advance(0.15)
    checkpoint.save(path, stepper)
    stepper.advance(0.2)
    other, touch = draped(body=body)
    checkpoint.load(path, other)
    assert stepper.shell.comm.allreduce(touch.correction.sides["depth"].max()) > 1e-6
    other.advance(0.2)
    assert np.array_equal(other.owned, stepper.owned) and np.array_equal(other.v, stepper.v)


def test_what_flesh_does_not_go_with():
    surface = meshes.rectangle(0.3, 0.3, (2, 2))
    ball = Body([Segment("ball", (0.2, 0.2, 0.2), Fixed((0.0, 0.0, -0.2)))])
    with pytest.raises(ValueError, match="with flesh takes no flesh_stiffness"):
        Contact(ball, flesh=Flesh(1e5), flesh_stiffness=1e5)
    with pytest.raises(ValueError, match="with flesh takes no samples"):
        Contact(ball, flesh=Flesh(1e5), samples=2)
    with pytest.raises(TypeError, match="is a Flesh, as"):
        Contact(ball, flesh=1e5)
    with pytest.raises(ValueError, match=r"flesh of 'calf': no segment"):
        Contact(ball, flesh=Flesh({"calf": 1e5}))
    with pytest.raises(ValueError, match="implicit steps know no flesh"):
        ImplicitNewmark(Shell(surface, CLOTH), 1e-3).add(Contact(ball, flesh=Flesh(1e5)))


def test_segments_that_pass_between_nodes_stay_hard():
    """A rod of 4 mm under cells of 20 mm bears the cloth on its skin, flesh or not."""
    shell = Shell(meshes.rectangle(0.2, 0.04, (10, 2)), CLOTH)
    shell.loads.gravity((0.0, 0.0, -G))
    stepper = Newmark(shell, 0.8, drag=8.0)
    rod = Segment("rod", (2e-3, 1.0, 2e-3), Fixed((0.1, 0.0, -3e-3)))
    touch = stepper.add(Contact(Body([rod]), 0.4, flesh=Flesh(1e4)))
    assert touch.edges is not None
    stepper.advance(0.1)
    assert touch.max_depth < 1e-4 and touch.correction.sides["depth"].max(initial=0.0) < 1e-6


@pytest.mark.serial
def test_a_hard_body_loads_no_flesh():
    """Who asks for no flesh loads and allocates nothing of it."""
    program = (
        "import sys, meshes, shellform as sf\n"
        "fabric = sf.Fabric.isotropic(1e5, 0.3, 1e-3, 200.0)\n"
        "shell = sf.Shell(meshes.rectangle(0.2, 0.2, (2, 2)), fabric)\n"
        "ball = sf.Body([sf.Segment('ball', [0.2] * 3, sf.Fixed((0.1, 0.1, -0.201)))])\n"
        "stepper = sf.Newmark(shell); stepper.add(sf.Contact(ball)); stepper.advance(0.01)\n"
        "kernels = 'flesh_step', 'flesh_correction'\n"
        "assert not [m for m in sys.modules if m.endswith(kernels)]\n"
    )
    done = launch(1, "-c", program)
    assert done.returncode == 0, done.stderr
