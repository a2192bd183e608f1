# SPDX-License-Identifier: LGPL-3.0-or-later
"""Implicit Newmark steps against conservation laws and orders of convergence."""

from itertools import pairwise

import numpy as np
import pytest
from test_newmark import sheet, strip, tip, totals, tumble

from shellform.implicit import ImplicitNewmark


def swing(steps, end, clamped):
    """Tip of a strip that gravity sets in motion smoothly from rest."""
    shell = strip(4 if clamped else 2, thickness=5e-3)
    (shell.supports.clamp if clamped else shell.supports.hold)("left")
    shell.loads.gravity((0, 0, -9.81), amplitude=lambda t: 5 * np.sin(np.pi * t / end) ** 2)
    stepper = ImplicitNewmark(shell, end / steps)
    stepper.advance(end)
    assert stepper.steps == steps
    return tip(stepper)


@pytest.mark.parametrize("clamped", [True, False])
def test_second_order_in_time(clamped):
    tips = [swing(50 * 2**k, 0.2, clamped) for k in range(3)]
    errors = [np.linalg.norm(a - b) for a, b in pairwise(tips)]
    assert np.linalg.norm(tips[-1]) > 0.08
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.1)


def test_free_flight_conserves_momentum():
    stepper = ImplicitNewmark(sheet(6), 1e-3)
    tumble(stepper)
    p0, j0, k0, e0 = totals(stepper)
    stepper.advance(0.1)
    p, j, k, e = totals(stepper)
    assert np.abs(p - p0).max() < 1e-12 * np.abs(p0).max()
    assert np.abs(j - j0).max() < 1e-4 * np.abs(j0).max()
    assert k + e == pytest.approx(k0 + e0, rel=1e-4)


def test_damping_leaves_free_fall_exact():
    shell = sheet(4)
    shell.loads.gravity((0.0, 0.0, -9.81))
    stepper = ImplicitNewmark(shell, 5e-3, gamma=0.7)
    stepper.advance(0.1)
    drop = stepper.w[: stepper.n_owned, 2]
    assert drop == pytest.approx(-0.5 * 9.81 * 0.1**2, rel=1e-9)


def test_prescribed_motion_is_followed():
    shell = sheet(4)

    def place(t):
        return np.array([0.02 * np.sin(40 * t), 0.0, 0.02 * (1 - np.cos(40 * t))])

    shell.supports.clamp("left")
    shell.supports.move("left", place)
    stepper = ImplicitNewmark(shell, 1e-3)
    stepper.advance(0.02)
    edge = shell.partition.find("left")
    assert np.abs(shell.displacements()[edge] - place(0.02)).max() < 1e-12


@pytest.mark.parametrize("values", [{"beta": 0.0}, {"gamma": 0.4}])
def test_refuses_parameters_out_of_range(values):
    with pytest.raises(ValueError, match="implicit steps need"):
        ImplicitNewmark(sheet(2), 1e-3, **values)
