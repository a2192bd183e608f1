# SPDX-License-Identifier: LGPL-3.0-or-later
"""Bending length by ASTM D1388 and loops by Peirce, against the elastica and published numbers."""

import numpy as np
import pytest

from shellform import Fabric, NotConverged
from shellform.bench import elastica
from shellform.bench.hang import G, hang
from shellform.bench.loop import TURNS, loop, peirce
from shellform.material.card import fabric_of
from shellform.material.measurements import measured_fabric
from tests.bench.test_cycles import BENT
from tests.material.test_measurements import SUITING

pytestmark = pytest.mark.serial  # specimens of a few cells


def linear(moment):
    return moment


@pytest.mark.parametrize("gamma, ratio", [
    (1, 0.1247), (3, 0.365), (10, 1.067), (30, 2.547), (100, 5.884)
])  # fmt: skip
def test_the_elastica_of_overhangs(gamma, ratio):
    """Fall over reach, published to four figures."""
    fall, reach = elastica.cantilever(linear, float(gamma), 1.0)
    assert fall / reach == pytest.approx(ratio, rel=2e-3)


@pytest.mark.parametrize("kind, part", [("heart", 0.1337), ("pear", 0.4243)])
def test_the_elastica_of_loops(kind, part):
    """Without weight: Peirce's heights of a heart and of a pear over their length."""
    height = elastica.loop_height(linear, 1e-9, 1.0, TURNS[kind])
    assert height == pytest.approx(part, rel=2e-3)


def test_peirces_formula():
    """Of heavy hearts it has the bending length of the elastica, 1, to 4 %."""
    for length in (4.0, 6.0, 8.0, 10.0):
        height = elastica.loop_height(linear, 1.0, length, TURNS["heart"])
        assert peirce(height, length) == pytest.approx(1.0, abs=0.045)


def test_no_elastica():
    with pytest.raises(NotConverged, match="no elastica"):
        elastica.cantilever(lambda m: np.full_like(m, np.nan), 1.0, 1.0)


def test_bending_length_of_linear_cloth():
    """c = (B/(rho g))^(1/3), half the overhang at 41.5 degrees, to 0.1 %."""
    fabric = fabric_of("compliant")
    found = hang(fabric, "warp")
    c = (fabric.bending[0, 0] / (fabric.areal_mass * G)) ** (1 / 3)
    assert found.bending_length == pytest.approx(c, rel=1e-3)
    assert found.elastica == pytest.approx(c, rel=1e-3) and found.at_rest == pytest.approx(c)
    x, z = found.shape[-1]
    assert np.degrees(np.arctan2(-z, x)) == pytest.approx(41.5, abs=1e-3)


def test_yarns_are_told_apart():
    fabric = Fabric.from_stiffness(
        np.diag([4e3, 4e3, 80.0]), np.diag([2e-5, 5e-6, 5e-6]), 0.2, 4e-4
    )
    ratio = hang(fabric, "warp").bending_length / hang(fabric, "weft").bending_length
    assert ratio == pytest.approx(4 ** (1 / 3), rel=1e-3)


@pytest.mark.thorough
def test_bending_length_with_friction_and_softening():
    """The elastica bends along the first loading of the card."""
    table = {k: v for k, v in SUITING.items() if not k.startswith(("B_weft", "LT"))}
    fabric = measured_fabric(table | BENT)
    for yarn in ("warp", "weft"):
        found = hang(fabric, yarn)
        assert found.bending_length == pytest.approx(found.elastica, rel=2e-3)
    warp = hang(fabric, "warp")
    assert warp.bending_length > 1.1 * warp.at_rest  # friction holds it up


@pytest.mark.parametrize("kind", [pytest.param("heart", marks=pytest.mark.thorough), "pear"])
def test_loops(kind):
    """Height to 0.1 % of the elastica's, of loops of two lengths."""
    fabric = fabric_of("compliant")
    for length in (0.06, None) if kind == "heart" else (None,):
        found = loop(fabric, "weft", kind, length)
        assert found.height == pytest.approx(found.elastica, rel=1e-3)
        assert found.shape[-1, 0] == pytest.approx(0.0, abs=1e-6)
    if kind == "heart":
        assert found.peirce == pytest.approx(fabric.bending_length(degrees=90), rel=0.05)


def test_other_loops_are_refused():
    with pytest.raises(ValueError, match="a heart or a pear, not 'ring'"):
        loop(fabric_of("compliant"), "warp", "ring")
