# SPDX-License-Identifier: LGPL-3.0-or-later
"""The energy of metric and curvature: its formula, no contraction, the same drape in both steps."""

import numpy as np
import pytest

from demos.studies.reviewed import terzopoulos_carignan as study
from demos.studies.reviewed.cusick_drape import hang
from shellform.material.surface_energy import MetricAndCurvature

pytestmark = [pytest.mark.serial, pytest.mark.thorough]
LAW = MetricAndCurvature()


def test_the_shell_stores_what_the_formula_says():
    """Rolled up, sheared and stretched; the error of the curvature falls with the square of h."""
    fabric = study.cloth(B_weft_uN_m=8.0, tensile_weft_N_per_m=5000.0)
    wanted = study.exact(fabric)
    coarse, fine = (study.rolled_up(fabric.with_law(LAW), cells) for cells in (4, 8))
    off = [abs(found["bending"] / wanted["bending"] - 1) for found in (coarse, fine)]
    assert off[0] < 1e-3 and off[1] < 0.3 * off[0]
    assert fine["membrane"] == pytest.approx(wanted["membrane"], rel=1e-6)


def test_contraction():
    """None with this energy; nu with St. Venant's."""
    assert abs(study.contraction(study.cloth().with_law(LAW))) < 1e-9
    assert study.contraction(study.cloth(poisson_ratio=0.3)) == pytest.approx(0.3, rel=0.03)


def test_implicit_steps_lead_where_explicit_ones_do():
    """A cloth so stiff that it hangs in one way only."""
    stiff = study.cloth(B_warp_uN_m=1000.0, B_weft_uN_m=1000.0)
    cells = (24, 3)
    one, iterations = study.hang_implicitly(stiff.with_law(LAW), 1, cells, seconds=0.4, drag=30.0)
    other = hang(stiff, 1, cells, seconds=0.4, drag=30.0)
    assert iterations >= one.steps
    assert one.dt > 20 * other.dt
    assert one.heights == pytest.approx(other.heights, rel=0.01)
    assert np.abs(one.heights).min() > 1e-3
