# SPDX-License-Identifier: LGPL-3.0-or-later
"""Orthotropy of the shadow, and the stiffness that thickness and shear modulus go into."""

import numpy as np
import pytest

from demos.studies.reviewed import chen_govindaraj
from demos.studies.reviewed.cusick_drape import DISC, SPECIMEN, orthotropy

pytestmark = [pytest.mark.serial, pytest.mark.thorough]


def test_the_measure():
    """An ellipse's second harmonic, over the width of the ring; folds do not count."""
    angle = (np.arange(720) + 0.5) * np.pi / 360
    radii = 0.13 + 3e-3 * np.cos(2 * angle) + 4e-3 * np.cos(8 * angle)
    assert orthotropy(radii) == pytest.approx(3e-3 / (SPECIMEN - DISC))


def test_thickness_goes_into_bending_and_not_into_weight():
    thin, thick = (chen_govindaraj.varied("thickness", t) for t in (0.2e-3, 0.4e-3))
    assert thick.bending == pytest.approx(8 * thin.bending)
    assert thick.areal_mass == pytest.approx(thin.areal_mass)
    # neither does another shear modulus change warp and weft
    stiff = chen_govindaraj.varied("shear modulus", 2e6)
    limp = chen_govindaraj.varied("shear modulus", 1e5)
    assert stiff.bending[:2, :2] == pytest.approx(limp.bending[:2, :2])
    assert stiff.bending[2, 2] == pytest.approx(20 * limp.bending[2, 2])
