# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cells that bend less than the others, as beside a seam: energy, force, a strip that is bent."""

import numpy as np
import pytest

import meshes
import shellform as sf
from shellform.fem.internal_force import InternalForce
from tests.fem.test_flat_rest import CLOTH, B, rolled

FACTOR = 5.0


def of_seam(surface):
    """Factors of a tube's cells: FACTOR in a third of them, around it, 1 in the others."""
    angle = np.arctan2(*surface.points[surface.cells].mean(axis=1)[:, 1::-1].T)
    return np.where(np.abs(angle) < np.pi / 3, FACTOR, 1.0)


def test_energy_and_force_of_a_rolled_strip(comm):
    """½ B/R² a cell's area, times its factor, on all ranks; force is the slope of energy."""
    surface = rolled((12, 2))
    stiffer = of_seam(surface)
    assert stiffer.mean() == pytest.approx(1 + (FACTOR - 1) / 3)
    shell, plain = sf.Shell(surface, CLOTH, comm, stiffer=stiffer), sf.Shell(surface, CLOTH, comm)
    energy = shell.energy()
    wanted = 0.5 * B / 0.05**2 * 2 * np.pi * 0.05 * 0.06 * stiffer.mean()
    assert energy["bending"] == pytest.approx(wanted, rel=1e-3)
    assert energy["membrane"] == pytest.approx(plain.energy()["membrane"], rel=1e-9)
    # the kernel's force is the slope of the energy along any way of nodes and directors
    rng, nodes = np.random.default_rng(1), shell.partition.nodes
    random = rng.standard_normal((2, len(surface.points), 6))
    w, owned = shell.w.x.array.reshape(-1, 6), shell.partition.n_owned
    w += 1e-4 * random[0, nodes]
    base, way, energies = w.copy(), random[1, nodes], []
    force = comm.allreduce(float(np.sum(owned_force(shell, w)[:owned] * way[:owned])))
    for step in (1e-6, -1e-6):
        w[:] = base + step * way
        energies.append(sum(shell.energy().values()))
    assert force == pytest.approx((energies[0] - energies[1]) / 2e-6, rel=1e-5)


def owned_force(shell, w):
    """Internal force (n_local, 6), whole on the nodes that a rank owns."""
    return InternalForce(shell)(w)


@pytest.mark.serial
def test_a_strip_with_a_seam_is_bent():
    """By a moment at its end: it turns by moment over stiffness times length, part by part."""
    surface = meshes.rectangle(0.06, 0.01, (6, 1))
    middle = surface.points[surface.cells].mean(axis=1)[:, 0]
    stiffer = np.where(np.abs(middle - 0.03) < 0.01, FACTOR, 1.0)
    shell = sf.Shell(surface, CLOTH, stiffer=stiffer)
    shell.supports.clamp("left")
    shell.loads.edge_moment("right", (0.0, -20.0 * B, 0.0))
    stepper = sf.Newmark(shell, drag=14.0)
    stepper.advance(1.0)
    x, directors = surface.points[:, 0], shell.directors()
    turned = np.abs(np.arctan2(directors[:, 0], directors[:, 2]))
    for start, end, factor in ((0.0, 0.02, 1.0), (0.02, 0.04, FACTOR), (0.04, 0.06, 1.0)):
        first, last = (turned[np.abs(x - at) < 1e-9].mean() for at in (start, end))
        assert last - first == pytest.approx(20.0 * 0.02 / factor, rel=1e-2)


def test_refusals():
    surface = rolled((12, 2))
    with pytest.raises(ValueError, match=r"stiffer has the shape \(3,\).* each of the 24 cells"):
        sf.Shell(surface, CLOTH, stiffer=np.ones(3))
    with pytest.raises(ValueError, match=r"bends linearly"):
        sf.Shell(surface, CLOTH, stiffer=np.ones(24), curvature="plain")
