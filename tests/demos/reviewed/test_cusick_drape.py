# SPDX-License-Identifier: LGPL-3.0-or-later
"""The drape test reads known outlines, and stiff cloth hangs less than limp cloth."""

import numpy as np
import pytest

from demos.studies.reviewed import cusick_drape
from demos.studies.reviewed.cusick_drape import DISC, SPECIMEN, SUITING
from shellform.material.measurements import measured_fabric

pytestmark = [pytest.mark.serial, pytest.mark.thorough]


def rim(radius, count=400):
    angle = np.linspace(0, 2 * np.pi, count, endpoint=False)
    r = radius(angle)
    return np.column_stack([r * np.cos(angle), r * np.sin(angle), 0 * angle])


@pytest.mark.parametrize("part", [0.0, 0.3, 1.0])
def test_coefficient_of_a_circle(part):
    """A shadow that covers a part of the ring has that coefficient."""
    radius = np.sqrt(DISC**2 + part * (SPECIMEN**2 - DISC**2))
    radii = cusick_drape.outline(rim(lambda angle: radius + 0 * angle))
    assert cusick_drape.coefficient(radii) == pytest.approx(part, abs=1e-3)
    assert cusick_drape.folds(radii) == 0


@pytest.mark.parametrize("number", [4, 8, 11])
def test_folds_of_a_wave(number):
    """As many maxima as waves; what is finer than 12 waves is no fold."""
    radii = cusick_drape.outline(
        rim(lambda a: 0.12 + 5e-3 * np.cos(number * a) + 2e-3 * np.cos(40 * a))
    )
    assert cusick_drape.folds(radii) == number


def test_a_border_that_hides_itself():
    """Where the rim turns back under the cloth its shadow is that of the farther part."""
    angle = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    there = angle + 0.12 * np.sin(9 * angle)  # backwards where 9 x 0.12 > 1
    points = np.column_stack([np.cos(there), np.sin(there), 0 * there])
    points *= (0.12 + 0.01 * np.cos(9 * angle))[:, None]
    radii = cusick_drape.outline(points)
    assert radii.max() == pytest.approx(0.13, rel=1e-3)
    assert cusick_drape.folds(radii) == 9


def test_stiff_and_limp_cloth():
    """A sheet as stiff as board keeps its shadow, suiting loses a third of it and more."""
    stiff = measured_fabric(SUITING | {"B_warp_uN_m": 5e3, "B_weft_uN_m": 5e3})
    limp = measured_fabric(SUITING)
    cells = (24, 3)
    board = cusick_drape.hang(stiff, cells=cells, seconds=0.3)
    cloth = cusick_drape.hang(limp, cells=cells, seconds=1.0)
    assert board.coefficient == pytest.approx(1.0, abs=0.01)
    assert 0.2 < cloth.coefficient < 0.7
    assert cloth.motion < 0.01
    # the same start, the same drape
    again = cusick_drape.hang(limp, cells=cells, seconds=1.0)
    assert again.coefficient == pytest.approx(cloth.coefficient, abs=1e-12)
