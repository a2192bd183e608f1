# SPDX-License-Identifier: LGPL-3.0-or-later
"""Fabrics at the ends of their ranges: thickness, moduli, density, directions."""

import warnings

import numpy as np
import pytest

from demos.studies.extremes import motion_cases as motion
from demos.studies.extremes import sheet_cases as sheets
from demos.studies.extremes.sheet_cases import rolled, strip
from demos.studies.extremes.sheets import ortho
from shellform import Fabric, NotConverged
from shellform.material.fabric import FabricError
from tests.statics.test_extremes import EPS, QUADS, of_turn, same

# ---------------------------------------------------------------- fabrics


@pytest.mark.parametrize("ratio", [1e-1, 1e-3, 1e-6])
def test_thickness(ratio):
    """Rolled up thick or thin; the exact answer of a thick strip includes its stretch."""
    out = rolled(strip(ratio * sheets.LENGTH))
    assert out["error"] < 2 * QUADS and out["cutbacks"] == 0
    flown = motion.tumbled(strip(ratio))
    assert max(flown["momentum"], flown["turning"]) < 1e-12 and flown["energy"] < 1e-4


@pytest.mark.slow
@pytest.mark.parametrize("ratio", [1e-2, 1e-4, 1e-6])
def test_lowest_note(ratio):
    """The period of a thin strip held at one end, within what lumped cells leave, at any thickness.

    The error of a lumped mass and of average steps is of second order: half the cells and half the
    steps make it four times as large.
    """
    out, coarse = motion.rung(ratio), motion.rung(ratio, cells=8, steps=50)
    assert out["error"] < 2e-3 and out["cutbacks"] == 0
    assert out["swing"] == pytest.approx(1, abs=3e-3)
    assert coarse["error"] / out["error"] == pytest.approx(4, rel=0.1)


@pytest.mark.slow
def test_the_lowest_note_of_a_thick_strip():
    """At a tenth of the length shear lowers it by half a per cent, between bending and Dunkerley.

    Rotary inertia, left out by both, is 4.65 t^2/12 of the mass's share: 0.2 per cent more.
    """
    errors = [motion.rung(0.1, cells=n)["error"] for n in (16, 32)]
    assert errors[1] < errors[0] < 4e-3


def test_the_thick_strip_stretches_as_it_rolls():
    """At a tenth of the length the stretch moves the tip by 7 %: more cells show it to be exact."""
    out = rolled(strip(0.1 * sheets.LENGTH), cells=(64, 1))
    assert out["error"] < 1e-7


@pytest.mark.parametrize("ratio", [1e-7, 1e-8])
def test_too_thin_for_statics_is_told(ratio):
    """Where loads that bend are below the roundoff of the stretch, the sentence says so."""
    with pytest.raises(NotConverged, match=r"loads, .* N, are near the roundoff .* thickness"):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            rolled(strip(ratio * sheets.LENGTH))


def test_loads_below_roundoff_are_told(comm):
    """What ends at once because nothing is above roundoff is no answer; no load at all is one.

    Roundoff decides whether such a solve ends at once or wanders: the one is warned of, the other
    refused, both in words of roundoff.
    """
    fabric = strip(1e-3, 1e6, bending_stiffness=1e-32)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        assert sheets.at_rest() == (0.0, 0) and not told
        try:
            out = rolled(fabric, length=1.0, width=0.1)
        except NotConverged as error:
            assert "near the roundoff" in str(error)
            return
    said = [str(one.message) for one in told if "may be lost in it" in str(one.message)]
    assert out["error"] > 0.5
    assert len(said) == (1 if comm.rank == 0 else 0)


@pytest.mark.parametrize("modulus", [1e2, 1e12])
def test_modulus(modulus, flight):
    """E only sets the unit of time."""
    assert of_turn(rolled(strip(1e-3 * sheets.LENGTH, modulus)))
    assert same(motion.tumbled(strip(1e-3, modulus), steps=400)["places"], flight, 1e-12)


@pytest.mark.parametrize("density", [1.0, 1e4])
def test_density(density, flight):
    fabric = Fabric.isotropic(1.2e6, 0.0, 1e-3, density)
    assert same(motion.tumbled(fabric, steps=400)["places"], flight, 1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("ratio", [1.0, 1e4])
def test_warp_over_weft(ratio):
    """Bent along either yarn, pulled off both."""
    for across in (False, True):
        assert of_turn(rolled(ortho(1e7, 1e7 / ratio, 0.0, 1e-3 * sheets.LENGTH), across=across))
    assert sheets.pulled(ortho(1e7, 1e7 / ratio, 0.3))["error"] < 1e-8


def test_bending_of_nothing_is_refused():
    for D in (0.0, -1e-7, np.nan):
        with pytest.raises(FabricError, match="bending"):
            strip(1e-3, bending_stiffness=D)
    assert of_turn(
        rolled(strip(1e-3, 1e6, bending_stiffness=1e-9), length=1.0, width=0.1)
    )  # a hundredth of the softest cloth


@pytest.mark.parametrize("poisson", [-1 + 1e-6, -0.9, 0.4999999, 0.5])
def test_poisson_at_its_limits(poisson):
    """Wide sheets kept from contracting roll up to the same circle."""
    assert of_turn(rolled(strip(poisson=poisson), width=12.0, cells=(16, 4)))


def test_poisson_beyond_its_limits_is_refused():
    for poisson in (-1.0, 0.51, np.nan):
        with pytest.raises(FabricError, match="poisson_ratio"):
            strip(poisson=poisson)
    for short in (0.0, -1e-3, 1e-12):
        with pytest.raises(FabricError, match="nu12"):
            ortho(4e7, 1e7, 2 * np.sqrt(1 - short))


@pytest.mark.parametrize("short", [1e-3, 1e-6, 1e-9])
def test_orthotropic_limit(short):
    """A uniform strain keeps the digits that 1 - nu12 nu21 leaves of the stiffness."""
    assert sheets.pulled(ortho(4e7, 1e7, 2 * np.sqrt(1 - short)))["error"] < 100 * EPS / short
