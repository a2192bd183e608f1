# SPDX-License-Identifier: LGPL-3.0-or-later
"""Piecewise linear forces with hysteresis: loops of two cycles, and steps that follow the error."""

import numpy as np
import pytest

from demos.studies.reviewed import eberhardt

pytestmark = [pytest.mark.serial, pytest.mark.thorough]


def test_piecewise():
    """Points, the middle between them, the mirror, and the last line prolonged."""
    x, y = np.array([0.0, 1.0, 3.0]), np.array([0.0, 2.0, 3.0])
    found = eberhardt.piecewise(np.array([0.5, 1.0, 2.0, 5.0, -2.0]), x, y)
    assert found == pytest.approx([1.0, 2.0, 2.5, 4.0, -2.5])


@pytest.mark.parametrize("kind", ["shear", "bending"])
def test_the_loop(kind):
    """Area to 0.5 %; a finer tolerance takes more steps and comes nearer."""
    coarse, fine = (eberhardt.cycle(kind, tolerance) for tolerance in (1e-3, 1e-5))
    # the particle in the middle of the frame takes a third of a percent: inertia and drag
    assert abs(fine["off %"]) < 0.5
    assert abs(fine["off %"]) < abs(coarse["off %"])
    assert fine["steps"] > coarse["steps"]
    # where nothing turns the step is longer than where sliders stop and start
    assert fine["longest [us]"] > 10 * fine["shortest [us]"]


def test_work_goes_into_motion():
    """Nothing led but the table: what gravity gives is stored, moves, or is lost, never gained."""
    _, particles = eberhardt.hang(6, 1, 0.02, 1e-3)
    assert particles.steps > 10
    y = particles.start(particles.cells.points)
    y = particles.run(y, 0.02, 1e-5)
    fallen = -particles.places(y)[:, 2]
    free = np.setdiff1d(np.arange(len(fallen)), particles.led)
    assert fallen[free].max() <= 0.5 * eberhardt.G * 0.02**2
    assert fallen[free].min() > 0.0 and not fallen[particles.led].any()
