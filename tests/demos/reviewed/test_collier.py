# SPDX-License-Identifier: LGPL-3.0-or-later
"""Poisson's ratio in both sheets, and the fit of the bending stiffness."""

import numpy as np
import pytest

from demos.studies.reviewed import collier
from shellform.material.laminate import FabricError

pytestmark = [pytest.mark.serial, pytest.mark.thorough]


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.5])
def test_what_poissons_ratio_changes(nu):
    """The solid sheet keeps its moduli and so stiffens by 1/(1 - nu12 nu21), the other does not."""
    B = 1e-5
    grown = 1 / (1 - nu**2 * collier.TENSION[1] / collier.TENSION[0])
    D = collier.solid(B, nu).bending
    assert D[0, 0] == pytest.approx(B * grown)
    assert D[0, 1] == pytest.approx(nu * D[1, 1])
    compliance = np.linalg.inv(collier.solid(B, nu).membrane)
    assert 1 / compliance.diagonal()[:2] == pytest.approx(collier.TENSION)
    D = collier.measured(B, nu).bending
    assert D[0, 0] == pytest.approx(B)
    assert D[0, 1] == pytest.approx(nu * np.sqrt(D[0, 0] * D[1, 1]))


def test_a_ratio_that_no_cloth_has():
    with pytest.raises(FabricError, match="nu12"):
        collier.solid(1e-5, 1.3)


@pytest.mark.parametrize("wanted", [50.0, 68.4, 90.0])
def test_the_fit(monkeypatch, wanted):
    """On a made-up drape, DC = 100/(1 + (b/B)): the stiffness that gives it."""

    def made_up(fabric, asked):
        return {"DC %": 100 / (1 + 2e-5 / fabric.bending[0, 0])}

    monkeypatch.setattr(collier, "drapes", made_up)
    B = collier.fitted(collier.measured, None, wanted)
    assert made_up(collier.measured(B, 0.0), None)["DC %"] == pytest.approx(wanted, abs=0.34)
