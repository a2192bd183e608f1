# SPDX-License-Identifier: LGPL-3.0-or-later
"""Sheets and solvers at the extremes against exact answers: right, told, or refused."""

import warnings

import numpy as np
import pytest

import meshes
from demos.studies.extremes import motion_cases as motion
from demos.studies.extremes import sheet_cases as sheets
from demos.studies.extremes.sheet_cases import rolled, strip
from demos.studies.extremes.sheets import ortho, row
from demos.studies.extremes.table import condensed
from shellform import Fabric, NotConverged, Shell, Statics
from shellform.dynamics.explicit import Newmark
from shellform.dynamics.implicit import ImplicitNewmark
from shellform.material.fabric import FabricError

pytestmark = pytest.mark.filterwarnings("ignore::shellform.material.fabric.UnitWarning")

EPS = np.finfo(float).eps
QUADS = 0.0066 * (2 * np.pi / 16) ** 6  # what 16 quads leave of a turn, see roll_up.cells_for


def of_turn(out):
    """The tip is where 16 quads of any strip have it, within a tenth of their own error."""
    return out["cutbacks"] == 0 and abs(out["error"] - 2.54e-5) < 0.1 * QUADS


def same(one, other, bar):
    return np.abs(one - other).max() <= bar * np.abs(other).max()


# ---------------------------------------------------------------- cells


def test_one_cell_and_more():
    """A tenth of a turn by 1, 2 and 4 quads: sixth order."""
    errors = [rolled(strip(), turns=0.1, cells=(n, 1))["error"] for n in (1, 2, 4)]
    assert errors[0] < 2 * 0.0066 * (0.2 * np.pi) ** 6
    assert np.all(np.log2(np.divide(errors[:-1], errors[1:])) > 5.5)


@pytest.mark.parametrize("aspect", [0.01, 100.0])
def test_aspect_of_cells(aspect):
    """A hundred times longer along the bend than across, and the other way round."""
    assert rolled(strip(), width=sheets.LENGTH / 16 * aspect)["error"] < 1.1 * 2.54e-5
    flown = motion.tumbled(strip(1e-3), aspect=1 / aspect)
    assert max(flown["momentum"], flown["turning"]) < 1e-12 and flown["energy"] < 1e-4


@pytest.mark.parametrize(
    ("length", "width", "strain"), [(12.0, 0.8, 1e-3), (100.0, 0.5, 1e-3), (1000.0, 1.0, 1e-7)]
)
def test_uniform_strain_on_leaning_cells(length, width, strain):
    """Corners of 170 degrees, cells up to a thousand times longer than wide: the patch test.

    Newton must know the roundoff of slender cells, which is that of their longer side.
    """
    cells = (4, 4)
    lines = sheets.leaning(cells, 170.0, length, width)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        out = sheets.pulled(
            ortho(1e7, 1e6, 0.3), cells=cells, length=length, width=width, strain=strain,
            parameters=lines,
        )  # fmt: skip
    slender = (length / width) ** 2
    assert out["widest"] > 169.9
    assert out["error"] < EPS / strain * slender


def test_leaning_quads_are_told(comm):
    """Bent, quads with corners of 150 degrees are wrong by 2 %; triangles are not."""
    lines = sheets.leaning((16, 2), 151.0, sheets.LENGTH, 0.2)
    options = {"cells": (16, 2), "width": 0.2, "parameters": lines}
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        quads = rolled(strip(), **options)
        triangles = rolled(strip(), triangles=True, **options)
    said = [str(one.message) for one in told if "corner of 151 degrees" in str(one.message)]
    assert len(said) == (1 if comm.rank == 0 else 0)
    assert quads["error"] > 0.01
    assert triangles["error"] < 1e-3


# ---------------------------------------------------------------- lengths and places


@pytest.mark.parametrize("size", [1e-6, 1e3])
def test_micrometres_and_kilometres(size, flight):
    assert of_turn(rolled(strip(1e-3 * size), length=size, width=size / 12))
    flown = motion.tumbled(strip(1e-3 * size), steps=400, size=size)["places"]
    assert same(flown, flight, 1e-9)  # thickness and size are rounded apart


@pytest.mark.slow
@pytest.mark.parametrize("far", [1e6, 1e8])
def test_origin_far_away(far):
    """What is lost is the digits of the coordinates, eps times the distance."""
    away = far * np.array([0.6, 0.64, 0.48])
    lost = np.spacing(far)
    near = motion.tumbled(strip(1.1e-3), steps=400, size=1.1)["places"]
    there = motion.tumbled(strip(1.1e-3), steps=400, size=1.1, origin=1.1 * away)["places"]
    assert 0 < np.abs(there - near).max() < 10 * lost
    out = rolled(strip(), length=11.7, origin=11.7 * away)
    assert abs(out["error"] - rolled(strip(), length=11.7)["error"]) < 10 * lost


# ---------------------------------------------------------------- turns and steps


@pytest.mark.slow
def test_twenty_turns_strain_nothing():
    """An edge led round statically, a strip spun: no strain but the centrifugal one."""
    assert sheets.turned_round(20)["strain"] < 1e-12
    out = motion.spun(20)
    assert 0 < out["strain"] <= out["bound"]
    assert out["turning"] < EPS * out["steps"]


def test_explicit_steps(comm):
    """Up to the stable step the error falls with its square; beyond it is refused or cut back."""
    fine = motion.swung(0.05)[0]
    size = np.abs(fine).max()
    errors = [np.abs(motion.swung(part)[0] - fine).max() / size for part in (1.0, 0.25)]
    assert errors[0] < 1e-3 and errors[0] / errors[1] > 3
    for part in (1.5, 10.0):
        with pytest.raises(ValueError, match="a part of the largest stable one"):
            motion.swung(part)
    places, stepper = motion.swung(10.0, forced=True)
    assert stepper.rewind.cutbacks > 0
    assert np.abs(places - fine).max() / size < 1e-3


@pytest.mark.slow
def test_implicit_steps():
    """From the stable step to a hundred of it: solved or cut back; small steps are right."""
    fine = motion.swung(0.05)[0]
    size = np.abs(fine).max()
    errors = [
        np.abs(motion.swung(part, implicit=True)[0] - fine).max() / size
        for part in (1.0, 10.0, 80.0)
    ]
    assert errors[0] < 1e-3 and errors[1] < 1e-2
    assert np.isfinite(errors[2]) and errors[2] < 0.5
    places, stepper = motion.swung(100.0, until=1.0, implicit=True)
    assert stepper.cutbacks > 0 and np.isfinite(places).all()
    assert np.abs(places).max() < 2 * 0.5 * 1.1  # it swings about its held edge, 0.5 m long


def test_one_load_step_for_a_turn():
    """Cut back as often as it takes; the answer is that of small steps."""
    out = rolled(strip(), levels=1)
    assert out["cutbacks"] > 0
    assert abs(out["error"] - 2.54e-5) < 0.1 * QUADS


def test_mechanisms():
    """A free sheet is refused at once; half a sheet on one point finds no equilibrium."""
    with pytest.raises(ValueError, match=r"leave a rigid motion free.*moves along x"):
        sheets.loose(joined=False)
    with pytest.raises(NotConverged, match=r"level 0.*hangs on one point"):
        sheets.loose(joined=True)


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_numbers_that_are_none(value):
    """Loads, moduli and lengths that are no numbers are refused before any computation."""
    shell = Shell(meshes.rectangle(1.0, 1.0, (2, 2)), strip())
    shell.supports.clamp("left")
    with pytest.raises(ValueError, match="finite"):
        shell.loads.line("right", (value, 0, 0))
    with pytest.raises(ValueError, match="finite"), Statics(shell) as statics:
        statics.solve([value])
    with pytest.raises(FabricError, match="not a positive finite number"):
        strip(modulus=value)
    with pytest.raises(ValueError, match="positive length"):
        meshes.rectangle(value, 1.0, (1, 1))
    with pytest.raises(ValueError, match="a part of the largest stable one"):
        Newmark(shell, value)


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_functions_of_time_that_give_no_number(value):
    """Amplitudes and motions that turn into no numbers half-way, in statics and by both steps."""

    def late(t):
        return value if t > 0.004 else 0.0

    def loaded(how):
        shell = Shell(meshes.rectangle(0.5, 0.25, (2, 1)), strip(1e-3))
        shell.supports.clamp("left")
        if how == "moved":
            shell.supports.move("right", lambda t: np.array([0.0, 0.0, late(t)]))
        elif how == "turned":
            shell.loads.edge_moment("right", (0, 1e-6, 0), amplitude=late)
        elif how == "blown":
            shell.loads.pressure(1.0, amplitude=late)
        else:
            shell.loads.gravity(amplitude=late)
        return shell

    for how in ("moved", "turned", "blown", "heavy"):
        match = "prescribed motion gives" if how == "moved" else f"amplitude of a load is {value}"
        with pytest.raises(ValueError, match=match), Statics(loaded(how)) as statics:
            statics.solve(2)
        with pytest.raises(ValueError, match=match):
            Newmark(loaded(how)).advance(0.01)
        with pytest.raises(ValueError, match=match):
            ImplicitNewmark(loaded(how), 1e-3).advance(0.01)


@pytest.mark.parametrize("value", [np.nan, np.inf, -1.0])
def test_settings_of_steps_that_are_none(value):
    """Times and rotary scales: not taken for no steps at all, or for steps without end."""
    shell = Shell(meshes.rectangle(0.5, 0.25, (2, 1)), strip(1e-3))
    shell.supports.clamp("left")
    for kind in (Newmark, lambda s, **more: ImplicitNewmark(s, 1e-3, **more)):
        with pytest.raises(ValueError, match="rotary_scale"):
            kind(shell, rotary_scale=value)
        if value > 0 or np.isnan(value):
            with pytest.raises(ValueError, match="finite time"):
                kind(shell).advance(value)


@pytest.mark.parametrize("value", [1e-300, 1e-41, 1e41, 1e300])
def test_numbers_that_doubles_cannot_cube(value):
    for given in ((value, 0.3, 1e-3, 200.0), (1e6, 0.3, value, 200.0), (1e6, 0.3, 1e-3, value)):
        with pytest.raises(FabricError, match="out of the range of numbers"):
            Fabric.isotropic(*given)


def test_a_table_row_says_what_is_lost():
    """No number is not counted as met."""
    from demos.studies.extremes.sheets import judged

    assert row("a", "b", lambda: judged(np.nan, 1.0))[2].startswith("degrades")
    assert row("a", "b", lambda: judged(0.5, 1.0))[2] == "converges"


def test_rows_drawn_together():
    """What is tried, what happens, the first limit; a verdict that is none is an error."""
    told = "no equilibrium found just beyond level 0 (SNES: x), whose state is kept. Too thin. Try"
    table = [("t", "1", "converges", "e 1"), ("t", "2", "converges, told: so", "e 2")]
    table += [("t", "3", f"refused: {told}", "-"), ("u", "4", "degrades: lost", "e 4")]
    assert condensed(table) == [
        ("t", "1 to 3", "converges 1, 2; refused 3", "no equilibrium found: Too thin", "e 2"),
        ("u", "4", "degrades", "lost", "-"),
    ]
    with pytest.raises(ValueError, match="a verdict starts with"):
        condensed([("t", "1", "perhaps", "-")])


# ---------------------------------------------------------------- long ones


@pytest.mark.serial
@pytest.mark.thorough
def test_a_million_cells_fall_freely():
    """Built and stepped: free fall is exact at any number of cells; memory as README says."""
    out = motion.million()
    assert out["error"] < 1e-12
    assert out["bytes"] < 5000


@pytest.mark.serial
@pytest.mark.thorough
def test_a_million_steps():
    """Momenta drift by roundoff only, energy swings but does not grow."""
    out = motion.tumbled(strip(1e-3), cells=(1, 1), steps=1_000_000)
    assert out["steps"] >= 990_000 and out["cutbacks"] == 0
    assert max(out["momentum"], out["turning"]) < EPS * out["steps"]
    assert out["energy"] < 1e-3
