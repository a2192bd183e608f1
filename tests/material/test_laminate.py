# SPDX-License-Identifier: LGPL-3.0-or-later
"""Layered sheets against closed forms."""

import numpy as np
import pytest

from shellform.material.fabric import Fabric, Ply
from tests.material.test_fabric import PLY, close, moments


@pytest.mark.parametrize("n", [1, 2, 5])
def test_equal_plies_are_one_sheet(n):
    stack = Fabric.laminate([(PLY, 3e-3 / n, 0.0)] * n)
    E1, E2, nu12, G12, G13, G23 = (
        getattr(PLY, k) for k in ("E1", "E2", "nu12", "G12", "G13", "G23")
    )
    sheet = Fabric.orthotropic(E1, E2, nu12, G12, G13, G23, 3e-3, PLY.density)
    close(moments(stack), moments(sheet))
    close(stack.shear, sheet.shear)
    assert stack.areal_mass == pytest.approx(4.5) and stack.thickness == pytest.approx(3e-3)


def test_cross_ply_by_hand():
    h = 1e-3  # each of three plies
    f = Fabric.laminate([(PLY, h, 0.0), (PLY, h, 90.0), (PLY, h, 0.0)])
    scale = 1 / (1 - 0.3 * 0.3 * PLY.E2 / PLY.E1)
    Q11, Q22, Q12 = scale * PLY.E1, scale * PLY.E2, scale * 0.3 * PLY.E2
    close(f.membrane[0], [h * (2 * Q11 + Q22), 3 * h * Q12, 0])
    close(f.membrane[1, 1], h * (2 * Q22 + Q11))
    # the middle ply holds 1/27 of t^3/12 = 27 h^3/12, the outer two 26/27
    close(f.bending[0], [h**3 / 12 * (26 * Q11 + Q22), 27 * h**3 / 12 * Q12, 0])
    close(f.bending[1, 1], h**3 / 12 * (26 * Q22 + Q11))
    # int z^4 = 2/5 (t/2)^5: 1/243 of it in the middle
    close(f.fourth_moment[0, 0], h**5 / 80 * (242 * Q11 + Q22))
    close(f.shear, 5 / 6 * h * np.diag([2 * PLY.G13 + PLY.G23, 2 * PLY.G23 + PLY.G13]))
    assert not f.coupling.any() and not f.third_moment.any() and f.directional


def test_unsymmetric_cross_ply_couples():
    h = 1e-3
    f = Fabric.laminate([(PLY, h, 0.0), (PLY, h, 90.0)])
    scale = 1 / (1 - 0.3 * 0.3 * PLY.E2 / PLY.E1)
    B11 = scale * (PLY.E2 - PLY.E1) * h**2 / 2  # the stiff ply lies below: z < 0
    close(f.coupling, np.diag([B11, -B11, 0]))
    close(f.third_moment[0, 0], scale * (PLY.E2 - PLY.E1) * h**4 / 4)
    assert np.linalg.eigvalsh(moments(f) / np.sqrt(np.outer(*[moments(f).diagonal()] * 2)))[0] > 0


def test_thin_skin_on_a_thick_core_keeps_its_digits():
    skin, core = (Ply(E, E, 0.0, E / 2, E / 2, E / 2, 100.0) for E in (1e11, 1e2))
    s, c = 1e-7, 5e-2
    f = Fabric.laminate([(core, c, 0.0), (skin, s, 0.0)])
    # about the middle of the skin, which lies at z = c/2
    D = f.bending[0, 0] - c * f.coupling[0, 0] + c**2 / 4 * f.membrane[0, 0]
    core_alone = 1e2 * (c**3 / 12 + c * (c + s) ** 2 / 4)
    assert D == pytest.approx(core_alone + 1e11 * s**3 / 12, rel=1e-11)


def test_quasi_isotropic_stack_is_directional_in_bending_only():
    f = Fabric.laminate([(PLY, 1e-3, a) for a in (0.0, 60.0, -60.0, -60.0, 60.0, 0.0)])
    close(f.rotated(17.0).membrane, f.membrane)
    assert f.directional and not f.coupling.any()


def test_ply_angle_turns_about_the_director():
    plus = Fabric.laminate([(PLY, 1e-3, 30.0)])
    assert plus.membrane[0, 2] > 0  # pulled along 1, it shears towards its fibres
    close(plus.rotated(30.0).membrane, Fabric.laminate([(PLY, 1e-3, 0.0)]).membrane)
