# SPDX-License-Identifier: LGPL-3.0-or-later
"""When a solve has converged: roundoff of the forces, measured, against forces known to be zero."""

import warnings

import numpy as np
import pytest

import meshes
from demos.studies.extremes import sheet_cases as sheets
from demos.studies.extremes.sheets import ortho
from shellform import NotConverged, Shell, Statics
from shellform.fem.director import rotation_matrix
from shellform.statics.convergence import SAMPLES_APART
from shellform.statics.equilibrium import Equilibrium

pytestmark = pytest.mark.filterwarnings("ignore::UserWarning")

KINDS = {
    "arcs": ({}, {}),
    "chords": ({}, {"membrane": "chords"}),
    "triangles": ({"triangles": True}, {}),
    "nine nodes": ({"degree": 2}, {}),
}


def turned(kind, length, degrees, angle):
    """Forces [N] of a sheet that is only turned, and the roundoff measured there.

    They are zero: all there is is roundoff.
    """
    mesh, options = KINDS[kind]
    surface = meshes.rectangle(
        length, 1.0, (4, 4), warp=(0.88, 0.48, 0.0), **mesh,
        parameters=sheets.leaning((4, 4), degrees, length, 1.0),
    )  # fmt: skip
    shell = Shell(surface, ortho(1e7, 1e6, 0.3), **options)
    equilibrium = Equilibrium(shell)
    turn = rotation_matrix(angle * np.array([0.5, -0.8, 0.3]))
    w, partition = shell.w.x.array.reshape(-1, 6), shell.partition
    w[:, :3] = surface.points[partition.nodes] @ (turn - np.eye(3)).T
    w[:, 3:] = w[:, 3:] @ turn.T
    equilibrium.adopt()
    equilibrium.residual(equilibrium.x, equilibrium.F)
    before = w.copy()
    measured = equilibrium.measured_roundoff()
    assert np.array_equal(w, before)
    found = equilibrium.F.norm()
    equilibrium.destroy()
    return found, measured


@pytest.mark.parametrize("kind", KINDS)
def test_measured_roundoff(kind):
    """What a turned sheet is left with is what is measured, over many decades of it.

    Both are samples of rounding. Where they stand on any processor is not known, how far apart
    they may be is.
    """
    cases = [(1.0, 130.0), (100.0, 150.0), (100.0, 170.0), (1000.0, 170.0), (1000.0, 179.0)]
    samples = [turned(kind, *case, angle) for case in cases for angle in (1e-3, 1.0)]
    found, measured = np.array(samples).T
    assert found.max() > 1e4 * found.min()
    assert np.all(found < SAMPLES_APART * measured)
    assert np.all(measured < 100 * found)


def pulled_sheet():
    surface = meshes.rectangle(1.0, 0.5, (3, 2), warp=(1.0, 0.0, 0.0))
    shell = Shell(surface, ortho(1e7, 1e6, 0.3))
    shell.supports.clamp("left")
    shell.loads.line("right", (10.0, 0.0, 0.0))
    return shell


@pytest.mark.parametrize("weaker", [1.25, 1e9])
def test_small_updates_alone_are_no_convergence(weaker, monkeypatch):
    """A tangent that is far too stiff makes updates of nothing: the residual must refuse them."""
    tangent = Equilibrium.tangent

    def stiffened(self, x):
        K = tangent(self, x)
        K.scale(weaker)
        return K

    monkeypatch.setattr(Equilibrium, "tangent", stiffened)
    with Statics(pulled_sheet()) as statics:
        if weaker < 10:
            statics.solve(1)
            assert statics.steps[-1].residual < 1e-6
        else:
            with pytest.raises(NotConverged):
                statics.solve(1)


@pytest.mark.parametrize("strain", [1e-9, 1e-7, 1e-5])
@pytest.mark.parametrize("degrees", [150.0, 170.0, 179.0])
def test_uniform_strain_of_slender_leaning_cells(strain, degrees):
    """Loads of any size on cells a thousand times longer than wide: found, or told as lost.

    The displacements of a sheet of length L are as exact as the digits of its coordinates: its
    cells' strain is known to eps times their slenderness.
    """
    length = 1000.0
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        out = sheets.pulled(
            ortho(1e7, 1e6, 0.3), length=length, strain=strain,
            parameters=sheets.leaning((4, 4), degrees, length, 1.0),
        )  # fmt: skip
    lost = any("may be lost in it" in str(one.message) for one in told)
    assert lost or out["error"] < np.finfo(float).eps / strain * length**2
