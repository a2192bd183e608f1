# SPDX-License-Identifier: LGPL-3.0-or-later
"""Fabrics that no sheet can have are refused in one sentence; slips of units are told."""

import warnings

import numpy as np
import pytest

from shellform.material.fabric import Fabric, FabricError, UnitWarning, condense
from tests.material.test_fabric import PLY

ISO = dict(youngs_modulus=1e6, poisson_ratio=0.3, thickness=1e-3, density=300.0)
SHEET = dict(membrane=np.eye(3), bending=1e-5 * np.eye(3), areal_mass=0.01, thickness=1e-3)


@pytest.mark.parametrize(
    "change, sentence",
    [
        (dict(thickness=0.0), r"thickness = 0 m is not a positive"),
        (dict(thickness=np.nan), r"thickness = nan m is not a positive"),
        (dict(density=-1.0), r"density = -1 kg/m\^3 is not a positive"),
        (dict(youngs_modulus=np.inf), r"youngs_modulus = inf Pa is not"),
        (dict(youngs_modulus="soft"), r"youngs_modulus = 'soft' Pa is not"),
        (dict(poisson_ratio=0.51), r"poisson_ratio = 0.51 is outside -1 < nu <= 0.5"),
        (dict(poisson_ratio=-1.0), r"poisson_ratio = -1 is outside"),
        (dict(shear_correction=0), r"shear_correction = 0"),
        (dict(bending_stiffness=0.0), r"A shell needs some bending stiffness: 1e-7 N m"),
        (dict(bending_stiffness=-1e-6), r"bending has a diagonal \[-1e-06"),
        (dict(bending_stiffness=np.ones(4)), r"not shape \(4,\)"),
    ],
)
def test_isotropic_refuses(change, sentence):
    with pytest.raises(FabricError, match=sentence):
        Fabric.isotropic(**ISO | change)


def test_orthotropic_bound_names_both_ratios():
    with pytest.raises(FabricError, match=r"nu12 = 3 .*nu21 = nu12 E2/E1 = 0.75.*E1/E2 = 4"):
        Fabric.orthotropic(4e6, 1e6, 3.0, 1e5, 1e5, 1e5, 1e-3, 300.0)
    Fabric.orthotropic(4e6, 1e6, 1.9, 1e5, 1e5, 1e5, 1e-3, 300.0)  # nu12 > 1 is legal here
    with pytest.raises(FabricError, match="G13 = 0 Pa"):
        Fabric.orthotropic(4e6, 1e6, 0.3, 1e5, 0.0, 1e5, 1e-3, 300.0)


@pytest.mark.parametrize(
    "change, sentence",
    [
        (dict(areal_mass=0.0), r"areal_mass = 0 kg/m\^2"),
        (dict(membrane=np.eye(2)), r"membrane has shape \(2, 2\), not \(3, 3\)"),
        (dict(membrane=[["a"]]), r"membrane = \[\['a'\]\] is not a matrix of numbers"),
        (dict(bending=np.full((3, 3), np.nan)), r"bending holds a value that is not finite"),
        (dict(membrane=[[2, 1, 0], [0, 2, 0], [0, 0, 1]]), r"not symmetric.* by 1 N/m"),
        (dict(membrane=[[2, 3, 0], [3, 2, 0], [0, 0, 1]]), r"membrane is not pos.*nu12 = 1.5"),
        (dict(bending=np.zeros((3, 3))), r"softer than any cloth"),
        (dict(bending=[[1, 2, 0], [2, 1, 0], [0, 0, 1]]), r"bending is not positive definite"),
        (dict(shear=-np.eye(2)), r"shear has a diagonal \[-1, -1\] N/m"),
        (dict(coupling=np.eye(3)), r"The coupling is too large"),
        (dict(fourth_moment=1e-12 * np.eye(3)), r"they must belong together"),
    ],
)
def test_stiffness_refuses(change, sentence):
    with pytest.raises(FabricError, match=sentence):
        Fabric.from_stiffness(**SHEET | change)


def test_condense_refuses():
    with pytest.raises(FabricError, match=r"shape \(6, 6\)"):
        condense(np.eye(3))
    with pytest.raises(FabricError, match="C33 = 0 Pa"):
        condense(np.diag([1.0, 1, 0, 1, 1, 1]))
    C = np.eye(6)
    C[0, 4] = C[4, 0] = 0.5
    with pytest.raises(FabricError, match="couples in-plane strain with transverse shear"):
        condense(C)


def test_laminate_refuses():
    with pytest.raises(FabricError, match="at least one ply"):
        Fabric.laminate([])
    with pytest.raises(FabricError, match="ply_thickness = -1 m"):
        Fabric.laminate([(PLY, 2.0, 0.0), (PLY, -1.0, 0.0)])


@pytest.mark.parametrize(
    "change, sentence",
    [
        (dict(thickness=0.2), "meant in mm"),
        (dict(density=200e3), r"meant in g/m\^2"),
        (dict(youngs_modulus=0.8), "meant in MPa"),
    ],
)
def test_unit_slips_are_told(change, sentence):
    with pytest.warns(UnitWarning, match=sentence):
        Fabric.isotropic(**ISO | change)


def test_good_values_are_silent_and_read_only():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        f = Fabric.isotropic(**ISO)
    with pytest.raises(ValueError):
        f.membrane[0, 0] = 0.0
    with pytest.raises(AttributeError):
        f.thickness = 1.0
    assert "alike in all directions" in f.summary() and "1 mm" in repr(f)
