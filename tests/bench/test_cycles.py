# SPDX-License-Identifier: LGPL-3.0-or-later
"""Specimens pulled, sheared and bent to and fro give back the curves of their card."""

import numpy as np
import pytest

from shellform import Fabric
from shellform.bench.bend import bend
from shellform.bench.cycle import expected_loads, largest_strain, path
from shellform.bench.pull import pull
from shellform.bench.shear import shear
from shellform.material.card import storing
from shellform.material.friction import follow
from shellform.material.measurements import measured_fabric
from tests.material.test_measurements import SUITING

pytestmark = pytest.mark.serial  # specimens of a few cells

SHEARED = {  # a loop as it is measured, with locking
    "angle_degrees": [0, 1, 2, 4, 6, 8],
    "shear_load_N_per_m": [0, 1.5, 2.6, 4.7, 7.2, 11.0],
}
BENT = {
    "curvature_weft_per_cm": [0, 0.25, 0.5, 1.0, 1.75, 2.5],
    "moment_weft_gf_cm_per_cm": [0, 0.045, 0.085, 0.155, 0.24, 0.31],
}
PULLED = {  # decrimping, with what comes back
    "stretch_warp_percent": [0, 2, 4, 6],
    "load_warp_N_per_m": [0, 60, 180, 480],
    "unload_warp_N_per_m": [0, 36, 125, 480],
}
GF = 9.80665e-3


@pytest.fixture(scope="module")
def cloth():
    """Decrimping with loss of work, locking shear, softening bending; sliders in all strains."""
    replaced = ("EMT_warp", "LT_", "G_", "2HG", "B_weft")
    table = {k: v for k, v in SUITING.items() if not k.startswith(replaced)}
    return measured_fabric(table | PULLED | SHEARED | BENT)


@pytest.mark.parametrize("test, yarn", [
    (pull, "warp"), (pull, "weft"), (shear, ""), (bend, "warp"), (bend, "weft"),
])  # fmt: skip
def test_output_is_input(cloth, test, yarn):
    """To 0.1 % of the largest load, up, back and up again."""
    found = test(cloth, yarn, points=4) if yarn else test(cloth, points=4)
    assert found.error() < 1e-3
    assert np.abs(found.expected).max() > 1e-3 and len(found.load) == len(found.strain)
    if test is not pull:
        assert found.strain.min() == pytest.approx(-found.strain.max(), rel=2e-3)


def test_output_is_what_was_measured(cloth):
    """Against the numbers of the card itself, not what was made of them."""
    sheared, bent = shear(cloth, points=8), bend(cloth, "weft", points=10)
    for angle, load in zip(SHEARED["angle_degrees"][1:], SHEARED["shear_load_N_per_m"][1:]):
        assert sheared.strain[angle - 1] == pytest.approx(np.radians(angle))
        assert sheared.load[angle - 1] == pytest.approx(load, rel=1e-3)
    # of ten equal parts of 2.5 per cm these are points of the card
    for kappa, moment in zip(BENT["curvature_weft_per_cm"], BENT["moment_weft_gf_cm_per_cm"]):
        if kappa and round(10 * kappa / 2.5, 6) % 1 == 0:
            k = round(10 * kappa / 2.5) - 1
            assert bent.strain[k] == pytest.approx(100 * kappa)
            assert bent.load[k] == pytest.approx(moment * GF, rel=1e-3)
    pulled = pull(cloth, "warp", points=3)
    assert pulled.strain[:3] == pytest.approx(np.array(PULLED["stretch_warp_percent"])[1:] / 100)
    assert pulled.load[:3] == pytest.approx(PULLED["load_warp_N_per_m"][1:], rel=1e-3)
    # what comes back is what sliders can open, within the tenth that cards are held to
    back, apart = np.array(PULLED["unload_warp_N_per_m"])[[2, 1]], 55.0
    assert pulled.load[3:5] == pytest.approx(back, abs=0.1 * apart)


def test_quadratic_and_other_laws():
    plain = Fabric.isotropic(1e6, 0.3, thickness=0.5e-3, density=400.0)
    for fabric in (plain, storing(plain, {"kind": "fung", "stiffening_load_N_per_m": 40})):
        assert pull(fabric, "weft", points=2).error() < 1e-3
        assert shear(fabric, points=2).error() < 1e-3
    e = np.array([0.01, 0.02])
    wanted = plain.membrane[0, 0] * (e + 0.5 * e**2) * (1 + e)
    assert expected_loads(plain, "pull", "warp", e) == pytest.approx(wanted, rel=1e-6)
    assert expected_loads(plain, "bend", "weft", e) == pytest.approx(plain.bending[1, 1] * e)


def test_loads_of_sliders():
    """Against a walk in many small steps; loops lose what lies between their branches."""
    fabric = measured_fabric(SUITING)
    strains = path("shear", largest_strain(fabric, "shear"), 6)
    assert strains[5] == pytest.approx(np.radians(8)) and strains[-1] == strains[5]
    fine = np.interp(np.arange(0, len(strains) + 0.001, 0.001), np.arange(len(strains) + 1),
                     np.r_[0, strains])  # fmt: skip
    slow = fabric.membrane[2, 2] * np.sin(fine) * np.cos(fine)
    for element in fabric.friction.shear:
        slow = slow + np.cos(fine) * follow(element, np.sin(fine))
    assert expected_loads(fabric, "shear", "", strains) == pytest.approx(slow[1000::1000], rel=1e-6)


def test_coupled_sheets_have_no_curve_without_a_mesh():
    plain = Fabric.isotropic(1e6, 0.3, thickness=0.5e-3, density=400.0)
    thick = storing(plain, "compressible-neo-hookean")
    with pytest.raises(ValueError, match="couples stretching and bending"):
        expected_loads(thick, "pull", "warp", np.array([0.1]))
    found = pull(thick, "warp", points=1)
    assert found.expected is None and found.error() is None and found.load[0] > 0
