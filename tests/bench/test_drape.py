# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cusick's drape: measures of an outline, limits of stiff and limp cloth, starts, ranks."""

import numpy as np
import pytest

import meshes
from shellform import Fabric
from shellform.bench.drape import (
    ANGLES,
    DISC,
    SPECIMEN,
    cells_for,
    coefficient_of,
    drape,
    folds_of,
    shadow,
)

pytestmark = pytest.mark.serial  # specimens of a few cells

ANGLE = 2 * np.pi * (np.arange(ANGLES) + 0.5) / ANGLES


def cloth(B, mass=0.2):
    return Fabric.from_stiffness(np.diag([400.0, 400.0, 50.0]), B * np.eye(3), mass, 5e-4)


def test_coefficient_and_folds():
    flat = np.full(ANGLES, SPECIMEN)
    assert coefficient_of(flat, flat) == 1.0
    assert coefficient_of(np.full(ANGLES, DISC), flat) == pytest.approx(0.0, abs=1e-12)
    wavy = 0.12 + 0.01 * np.cos(7 * ANGLE + 0.3)
    assert folds_of(wavy) == 7
    assert folds_of(wavy + 2e-3 * np.cos(40 * ANGLE)) == 7  # what is smaller than a fold
    area = 0.12**2 + 0.5 * 0.01**2
    assert coefficient_of(wavy, flat) == pytest.approx(
        (area - DISC**2) / (SPECIMEN**2 - DISC**2), rel=1e-9
    )


@pytest.mark.parametrize("cells", [(24, 2), (96, 8)])
def test_shadow_of_a_flat_ring(cells):
    """Of a polygon; and what is tucked below the disc throws none."""
    flat = meshes.annulus(DISC, SPECIMEN, cells, slit=False)
    offset = np.pi / cells[0]
    exact = SPECIMEN * np.cos(offset) / np.cos(ANGLE % (2 * offset) - offset)
    assert shadow(flat.points, flat.cells) == pytest.approx(exact, rel=2e-3)
    tucked = flat.points * [0.5, 0.5, 1.0]
    assert np.all(shadow(tucked, flat.cells) == DISC)


def test_stiff_cloth_stays_flat():
    """The ring sags by the deflection of a plate; its coefficient goes to 100 %."""
    found = drape(cloth(5e-3), cells=(24, 2), lowering=0.5, wait=1.0)
    assert 0.995 < found.coefficient < 1.0


def test_limp_cloth_hangs_in_folds():
    """More stiffness, larger coefficient and fewer folds."""
    coefficients, folds = [], []
    for B in (2e-6, 5e-5):
        found = drape(cloth(B), cells=(72, 6), lowering=1.0, wait=1.0)
        coefficients.append(found.coefficient)
        folds.append(found.folds)
    assert 0.1 < coefficients[0] < 0.5 < coefficients[1] < 0.95
    assert folds[0] > folds[1] >= 3


def test_starts_differ_and_repeat():
    one, again, other = (drape(cloth(1e-5), k, (48, 4), 0.1, 0.3) for k in (0, 0, 1))
    assert np.array_equal(one.shadow, again.shadow)
    assert np.abs(one.shadow - other.shadow).max() > 1e-4
    assert not one.settled and one.seconds == 0.4


def test_cells_follow_the_bending_length():
    assert cells_for(cloth(1e-3)) == (96, 8)
    assert cells_for(cloth(1e-7))[1] == 16
