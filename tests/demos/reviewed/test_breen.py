# SPDX-License-Identifier: LGPL-3.0-or-later
"""Particles of least energy: their strains, their force, and a drape in which it has vanished."""

import numpy as np
import pytest

from demos.studies.reviewed import breen
from demos.studies.reviewed.thread_grid import grid

pytestmark = [pytest.mark.serial, pytest.mark.thorough]
FABRIC = breen.cloth()


def test_areas():
    """Every strain stands for the whole cloth, shear once and the two yarns once each."""
    cells = grid((5, 4), 0.01)
    whole = 4 * 3 * 1e-4
    assert cells.areas.sum() == pytest.approx(whole)
    assert cells.of_corners.sum() == pytest.approx(whole)
    assert cells.of_links.sum() == pytest.approx(2 * whole)
    # bends leave out half a spacing at both ends of a thread
    assert cells.of_bends.sum() == pytest.approx(3 * 3e-4 + 2 * 4e-4)


@pytest.mark.parametrize("kind", ["stretched", "sheared", "bent"])
def test_strains_of_simple_shapes(kind):
    cells, h = grid((5, 5), 0.01), 0.01
    x = cells.points.copy()
    if kind == "stretched":
        x[:, 0] *= 1.03
    if kind == "sheared":
        x[:, 0] += np.sin(0.2) * x[:, 1]
        x[:, 1] *= np.cos(0.2)
    if kind == "bent":
        angle = x[:, 0] / 0.05
        chord = 2 * np.sin(0.5 * h / 0.05) / (h / 0.05)
        x[:, 0], x[:, 2] = 0.05 * np.sin(angle) / chord, 0.05 * (1 - np.cos(angle)) / chord
    found = [cells.elongations(x).values, np.abs(cells.angles(x).values)]
    found += [cells.curvatures(x).values, cells.curvatures(x, signed=True).values]
    wanted = {
        "stretched": (0.03, 0.0, 0.0),
        "sheared": (0.0, 0.2, 0.0),
        "bent": (0.0, 0.0, 2 * np.sin(0.1) / h),
    }[kind]
    for values, most in zip(found, (*wanted, wanted[2]), strict=True):
        assert values.max() == pytest.approx(most, abs=1e-9 + 1e-9 * most)


def test_the_force_is_the_derivative_of_the_energy():
    random = np.random.default_rng(0)
    cells = breen.sheet(6)
    x = cells.points + 2e-3 * random.standard_normal(cells.points.shape)
    _, push = breen.energy(cells, FABRIC, x)
    for _ in range(3):
        way = 1e-7 * random.standard_normal(x.shape)
        change = breen.energy(cells, FABRIC, x + way)[0] - breen.energy(cells, FABRIC, x - way)[0]
        assert change == pytest.approx(2 * np.sum(push * way), rel=1e-5)


def test_least_energy():
    """Forces vanish, the table holds the rest, and turned by a quarter the drape is as deep."""
    cells = breen.sheet(8)
    x, _, left = breen.minimised(cells, FABRIC, start=1)
    weight = FABRIC.areal_mass * breen.G * breen.SQUARE**2
    assert left < 1e-4 * weight
    found = breen.measures(x, 8)
    assert 10.0 < found["DC %"] < 90.0 and found["mean height [mm]"] < -5.0
    turned = x.reshape(9, 9, 3).transpose(1, 0, 2)[::-1].reshape(-1, 3) @ [
        [0, 1, 0],
        [-1, 0, 0],
        [0, 0, 1],
    ]
    assert breen.measures(turned, 8)["DC %"] == pytest.approx(found["DC %"], rel=1e-3)


def test_stiff_cloth_hangs_alike():
    """A card so stiff that it has one shape: as low as the shell, to 20 % with 3 bends to hang."""
    moment = [50 * m for m in breen.MOMENT]
    stiff = breen.cloth(moment_warp_N=moment, moment_weft_N=moment, B_twist_uN_m=0.5)
    x, _, _ = breen.minimised(breen.sheet(12), stiff, start=1)
    y, _ = breen.hung(stiff, 12, start=1, seconds=3.0)
    one, other = (breen.measures(at, 12)["mean height [mm]"] for at in (x, y))
    assert one == pytest.approx(other, rel=0.2)
