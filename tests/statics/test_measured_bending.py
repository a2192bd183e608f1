# SPDX-License-Identifier: LGPL-3.0-or-later
"""A strip in pure bending gives back the measured curve M(kappa) and the loop 2HB."""

import numpy as np
import pytest

import meshes
from shellform import Shell, Statics
from shellform import follow as follow_path
from shellform.material.friction import follow
from shellform.material.measurements import measured_fabric

LENGTH = 0.012  # turns by less than half a turn
POINTS = {
    "curvature_warp_per_cm": [0, 0.25, 0.5, 1.0, 1.75, 2.5],
    "moment_warp_gf_cm_per_cm": [0, 0.045, 0.085, 0.155, 0.24, 0.31],
}
REST = {
    "tensile_warp_N_per_m": 2000.0, "tensile_weft_N_per_m": 2000.0, "G_N_per_m_per_radian": 50.0,
    "B_weft_uN_m": 9.0, "weight_g_per_m2": 260.0, "thickness_mm": 0.7,
}  # fmt: skip
UNIT = 9.80665e-3  # N, of gf cm/cm


def clamped(fabric, most, triangles=False):
    """A strip that a moment [N] at its end bends in a plane, and the nodes of that end."""
    surface = meshes.rectangle(LENGTH, 0.005, (16, 2), triangles=triangles)
    shell = Shell(surface.replace(warp=(1.0, 0.0, 0.0)), fabric)
    everywhere = np.arange(len(surface.points))
    shell.supports.clamp("left")
    shell.supports.hold(everywhere, "y")
    shell.supports.hold_director(everywhere, plane=(0.0, 1.0, 0.0))
    shell.loads.edge_moment("right", (0.0, -most, 0.0))
    return shell, np.flatnonzero(surface.points[:, 0] > LENGTH - 1e-9)


def bent(fabric, moments, triangles=False):
    """Curvatures [1/m] at moments [N]."""
    most = np.abs(moments).max()
    shell, tip = clamped(fabric, most, triangles)
    curvatures = []
    with Statics(shell) as statics:
        for _ in statics.march(np.array(moments) / most):
            d = shell.directors()[tip]
            curvatures.append(float(np.mean(np.arctan2(-d[:, 0], d[:, 2]))) / LENGTH)
    return np.array(curvatures), shell


@pytest.mark.parametrize("triangles", [False, True])
def test_measured_curve(triangles):
    fabric = measured_fabric(REST | POINTS)
    wanted = np.array(POINTS["curvature_warp_per_cm"])[1:5] * 100
    moments = np.array(POINTS["moment_warp_gf_cm_per_cm"])[1:5] * UNIT
    got, _ = bent(fabric, moments, triangles)
    assert np.abs(got) == pytest.approx(wanted, rel=5e-3)


@pytest.mark.parametrize("triangles", [False, True])
def test_loop_of_2HB(triangles):
    """Branches B kappa +- HB, their distance, and the energy lost in a cycle."""
    B, HB, slip = 13.3e-6, 3.05e-4, 5.0
    table = {"B_warp_uN_m": 1e6 * B, "2HB_warp_N": 2 * HB}
    fabric = measured_fabric(REST | table)
    top = 150.0 * B + HB
    there = [0.5 * top, top]
    down = [100.0 * B - HB, 50.0 * B - HB, -HB, -50.0 * B - HB, -100.0 * B - HB, -top]
    back = [-m for m in down]
    moments = np.array([*there, *down, *back])
    got, shell = bent(fabric, moments, triangles)
    sign = np.sign(got[1])
    at = sign * got
    assert at[1] == pytest.approx(150.0, rel=5e-3)
    assert at[2:8] == pytest.approx([100, 50, 0, -50, -100, -150], rel=5e-3, abs=0.5)
    assert at[8:] == pytest.approx([-100, -50, 0, 50, 100, 150], rel=5e-3, abs=0.5)
    # first loading slips over 150 - slip, both branches over 300 - 2 slip, per area
    lost = HB * (150 - slip) + 2 * HB * (300 - 2 * slip)
    assert shell.friction_loss() == pytest.approx(lost * shell.surface.area, rel=5e-3)


def test_a_path_keeps_its_slips():
    """Arc length up the branch on which sliders slip: the same curve and the same loss."""
    B, HB, slip = 13.3e-6, 3.05e-4, 5.0
    fabric = measured_fabric(REST | {"B_warp_uN_m": 1e6 * B, "2HB_warp_N": 2 * HB})
    shell, tip = clamped(fabric, 150.0 * B + HB)
    path = follow_path(shell)
    d = shell.directors()[tip]
    assert abs(np.mean(np.arctan2(d[:, 0], d[:, 2]))) / LENGTH == pytest.approx(150.0, rel=5e-3)
    lost = HB * (150 - slip) * shell.surface.area
    assert shell.friction_loss() == pytest.approx(lost, rel=5e-3)
    with pytest.raises(ValueError, match="friction inside"):
        follow_path(shell, 2.0, start=path.states[-1])


@pytest.mark.parametrize(
    "triangles", [False, pytest.param(True, marks=[pytest.mark.serial, pytest.mark.thorough])]
)
def test_both_branches_of_a_measured_loop(triangles):
    """Softening with a loop, as lists of loading and unloading: the strip goes along both."""
    most, HB, slip = 150.0, 3e-4, 3.0  # it slips from a fiftieth of the largest curvature on
    kappa = np.linspace(0.0, most, 11)
    slider = (HB / slip, HB, 0.0)
    path = np.concatenate([kappa, kappa[-2::-1]])
    # B (kappa - kappa |kappa|/900): a third softer at the end
    loads = 13.3e-6 * (path - path**2 / 900) + follow(slider, path)
    up, down = loads[:11], loads[10:]
    table = {
        "curvature_warp_per_m": kappa.tolist(),
        "moment_warp_N": up.tolist(),
        "unbend_warp_N": down[::-1].tolist(),
    }
    moments = np.concatenate([up[[3, 6, 10]], down[[2, 5, 8]]])
    got, _ = bent(measured_fabric(REST | table), moments, triangles)
    assert np.abs(got) == pytest.approx(
        np.concatenate([kappa[[3, 6, 10]], kappa[[8, 5, 2]]]), rel=5e-3
    )
