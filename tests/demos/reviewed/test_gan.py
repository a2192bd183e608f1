# SPDX-License-Identifier: LGPL-3.0-or-later
"""Bending apart from tension: the cantilever of the shell against the elastica."""

import numpy as np
import pytest

from demos.studies.reviewed import gan
from demos.studies.reviewed.cusick_drape import SUITING
from shellform.material.measurements import measured_fabric

pytestmark = [pytest.mark.serial, pytest.mark.thorough]
CLOTH = measured_fabric(SUITING)


def test_elastica():
    """A light strip falls by Gamma/8; the order in which loads are asked for does not matter."""
    assert gan.elastica([1e-2])[0] == pytest.approx(1e-2 / 8, rel=1e-3)
    assert gan.elastica([1.0, 10.0, 30.0])[2] == pytest.approx(gan.elastica([30.0])[0], rel=1e-6)


@pytest.mark.parametrize(("cells", "degree"), [((32, 2), 1), ((16, 1), 2)])
def test_cantilever(cells, degree):
    gammas = (1.0, 10.0, 100.0)
    off = gan.cantilever(CLOTH, gammas, cells, degree) / gan.elastica(gammas) - 1
    assert np.abs(off).max() < 5e-3


def test_the_cantilever_does_not_know_the_tension():
    """A hundredth of the tensile stiffness: the same fall, which E t^3/12 would change."""
    soft = measured_fabric(SUITING | {f"tensile_{yarn}_N_per_m": 81.0 for yarn in ("warp", "weft")})
    assert gan.cantilever(soft, [3.0]) == pytest.approx(gan.cantilever(CLOTH, [3.0]), rel=2e-3)
    solid = [gan.bending_from_tension(cloth).bending[0, 0] for cloth in (soft, CLOTH)]
    assert solid[0] == pytest.approx(0.01 * solid[1])
