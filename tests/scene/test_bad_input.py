# SPDX-License-Identifier: LGPL-3.0-or-later
"""Mistakes in the input: one clear sentence each, before anything is compiled or assembled."""

import subprocess
import sys

import numpy as np
import pytest

from dolfinx import fem

import meshes
from meshes import MeshError, Surface
from shellform import Fabric, FabricError, Ply, Shell, Statics
from shellform.material.card import read_fabric

SQUARE = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 1.0, 0.0)]
TWO = [*SQUARE, (2.0, 0.0, 0.0), (2.0, 1.0, 0.0)]
NAN = float("nan")


@pytest.fixture(autouse=True)
def compiled(monkeypatch):
    """Forms compiled so far in the test: an empty list if the mistake was found in time."""
    made, form = [], fem.form

    def spy(*arguments, **options):
        made.append(arguments)
        return form(*arguments, **options)

    monkeypatch.setattr(fem, "form", spy)
    return made


def isotropic():
    return Fabric.isotropic(1e6, 0.3, 0.01, 1000.0)


def orthotropic():
    return Fabric.orthotropic(1e6, 1e5, 0.3, 1e4, 1e4, 1e4, 0.01, 1000.0)


def sheet(fabric=None, surface=None, **options):
    surface = meshes.rectangle(1.0, 1.0, (4, 4)) if surface is None else surface
    return Shell(surface, isotropic() if fabric is None else fabric, **options)


def refused(make, words, compiled, kind=ValueError):
    """The mistake raises one sentence with these words in it, and nothing was compiled."""
    with pytest.raises(kind) as caught:
        make()
    sentence = str(caught.value)
    for word in words:
        assert word in sentence
    assert "\n" not in sentence
    assert len(sentence) < 400
    assert compiled == []


FABRICS = {
    "negative thickness": (
        lambda: Fabric.isotropic(1e6, 0.3, -1e-3, 1000.0),
        ("thickness", "-0.001 m", "positive"),
    ),
    "no thickness": (
        lambda: Fabric.orthotropic(1e6, 1e6, 0.2, 1e5, 1e5, 1e5, 0.0, 1000.0),
        ("thickness", "0 m", "positive"),
    ),
    "negative modulus": (
        lambda: Fabric.isotropic(-1e6, 0.3, 1e-3, 1000.0),
        ("youngs_modulus", "-1e+06 Pa", "positive"),
    ),
    "modulus that is no number": (
        lambda: Fabric.isotropic(NAN, 0.3, 1e-3, 1000.0),
        ("youngs_modulus", "nan", "finite"),
    ),
    "modulus as text": (
        lambda: Fabric.isotropic("1e6", 0.3, 1e-3, 1000.0),
        ("youngs_modulus", "'1e6'", "number"),
    ),
    "density": (
        lambda: Fabric.isotropic(1e6, 0.3, 1e-3, -5.0),
        ("density", "-5 kg/m^3", "positive"),
    ),
    "contraction of a solid": (
        lambda: Fabric.isotropic(1e6, 0.6, 1e-3, 1000.0),
        ("poisson_ratio", "0.6", "-1 < nu <= 0.5"),
    ),
    "contraction too large for the moduli": (
        lambda: Fabric.orthotropic(1e6, 4e6, 0.6, 1e5, 1e5, 1e5, 1e-3, 1000.0),
        ("nu12 = 0.6", "nu12^2 < E1/E2", "0.25", "positive definite"),
    ),
    "indefinite bending": (
        lambda: Fabric.from_stiffness(
            np.diag([1e3, 1e3, 1e2]), [[1, 2, 0], [2, 1, 0], [0, 0, 1]], 0.2, 1e-3
        ),
        ("bending", "positive definite"),
    ),
    "ply of no thickness": (
        lambda: Fabric.laminate([(Ply(1e6, 1e5, 0.3, 1e4, 1e4, 1e4, 1.0), 0.0, 0.0)]),
        ("ply_thickness", "0 m", "positive"),
    ),
}


@pytest.mark.parametrize("name", FABRICS)
def test_fabric(name, compiled):
    """A sheet that cannot be: the quantity, its value with unit, the bound."""
    refused(*FABRICS[name], compiled, FabricError)


SURFACES = {
    "edge without length": (
        lambda: Surface([*SQUARE[:3], SQUARE[2]], [(0, 1, 2, 3)], source="bag"),
        ("bag", "edge from point 2 to point 3 of cell 0", "no length", "merge_duplicates"),
    ),
    "inverted cell": (
        lambda: Surface(TWO, [(0, 1, 2, 3), (1, 2, 5, 4)], source="bag"),
        ("bag", "cells 0 and 1", "opposite sides", "meshes.orient"),
    ),
    "folded cell": (
        lambda: Surface(SQUARE, [(0, 1, 3, 2)], source="bag"),
        ("bag", "cell 0", "crosses itself", "cyclic order"),
    ),
    "duplicate cell": (
        lambda: Surface(SQUARE, [(0, 1, 2, 3), (1, 2, 3, 0)], source="bag"),
        ("bag", "cells 0 and 1", "same points", "remove one"),
    ),
    "three sheets at an edge": (
        lambda: Surface(
            [*TWO, (1.8, 0.0, 0.5), (1.8, 1.0, 0.5)],
            [(0, 1, 2, 3), (2, 1, 4, 5), (1, 2, 7, 6)],
            source="bag",
        ),
        ("bag", "seam of more than two sheets at point 1", "cell 2", "points of its own"),
    ),
    "point that is no number": (
        lambda: Surface([*SQUARE[:3], (0.0, NAN, 0.0)], [(0, 1, 2, 3)], source="bag"),
        ("bag", "point 3", "nan", "finite"),
    ),
    "point that is not there": (
        lambda: Surface(SQUARE, [(0, 1, 2, 4)], source="bag"),
        ("bag", "cell 0", "0 to 3", "count from zero"),
    ),
    "missing file": (
        lambda: meshes.load("nowhere.msh"),
        ("nowhere.msh", "there is no such file", "check the name"),
    ),
    "unknown kind of file": (
        lambda: meshes.load("coat.dxf"),
        ("coat.dxf", "unknown file type", ".vtu"),
    ),
}


@pytest.mark.parametrize("name", SURFACES)
def test_surface(name, compiled):
    """A mesh that cannot be used: the mesh, the item, the mend."""
    refused(*SURFACES[name], compiled, MeshError)


def test_missing_fabric_card(compiled):
    """A card that is not there is named."""
    refused(lambda: read_fabric("nowhere.toml"), ("nowhere.toml",), compiled, OSError)


def test_unreadable_mesh(compiled, shared_tmp_path, comm):
    """A file of the right name and the wrong contents is named."""
    path = shared_tmp_path / "coat.vtu"
    if comm.rank == 0:
        path.write_text("this is a letter")
    comm.Barrier()
    refused(lambda: meshes.load(path), ("coat.vtu", "cannot be read"), compiled, MeshError)


def along_the_axis():
    """A half cylinder whose first cells have their normal almost along the given warp."""
    return meshes.cylinder(1.0, 1.0, (40, 2), angle=np.pi, warp=(1.0, 0.0, 0.0))


SHELLS = {
    "unknown membrane": (lambda: sheet(membrane="chord"), ("membrane", "'chord'", "arcs, chords")),
    "unknown curvature": (
        lambda: sheet(curvature="bent"),
        ("curvature", "'bent'", "turning, plain"),
    ),
    "no warp": (
        lambda: sheet(orthotropic()),
        ("rectangle has no warp", "orthotropic sheet", "surface.replace(warp="),
    ),
    "warp along the normal": (
        lambda: sheet(orthotropic(), meshes.rectangle(1.0, 1.0, (4, 4), warp=(0.0, 0.0, 1.0))),
        ("warp", "cell 0 of rectangle", "normal", "direction"),
    ),
    "warp along the normal of some cells": (
        lambda: sheet(orthotropic(), along_the_axis()),
        ("warp", "cell 0 of cylinder", "normal", "direction"),
    ),
}


@pytest.mark.parametrize("name", SHELLS)
def test_shell(name, compiled):
    """A shell that cannot be made says what is missing or which choices there are."""
    refused(*SHELLS[name], compiled)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("coat.msh", None), ("Surface", "coat.msh")),
        ((meshes.rectangle(1.0, 1.0, (2, 2)), "wool.toml"), ("Fabric", "wool.toml")),
    ],
)
def test_shell_of_the_wrong_things(arguments, words, compiled):
    """A file name in place of what is in the file."""
    refused(lambda: Shell(*arguments), words, compiled, TypeError)


def test_warp_of_an_isotropic_fabric_does_not_matter(compiled):
    """A direction nobody asks for may be anything; here something is compiled, and seen."""
    surface = meshes.rectangle(1.0, 1.0, (4, 4), warp=(0.0, 0.0, 1.0))
    shell = sheet(surface=surface)
    assert np.isfinite(sum(shell.energy().values()))
    assert compiled


def some(points):
    return np.array([0, 1, 2])


def rows(points):
    return points > 0.5


def nothing(points):
    return points[:, 0] > 5.0


SUPPORTS = {
    "unknown edge": (
        lambda s: s.supports.clamp("lefft"),
        ("rectangle", "no edge 'lefft'", "bottom, left, right, top"),
    ),
    "locator of numbers": (
        lambda s: s.supports.clamp(some),
        ("locator", "boolean", "some returned int64 (3,)"),
    ),
    "locator of another shape": (
        lambda s: s.supports.hold(rows, "z"),
        ("locator", "(25,)", "rows returned bool (25, 3)"),
    ),
    "locator of nothing": (
        lambda s: s.supports.symmetry(nothing, (1.0, 0.0, 0.0)),
        ("locator nothing", "no node of rectangle", "points span"),
    ),
    "point off the sheet": (
        lambda s: s.supports.clamp((5.0, 0.0, 0.0)),
        ("no node of rectangle near [5.0, 0.0, 0.0]", "closest", "4 m away"),
    ),
    "point that is no number": (lambda s: s.supports.clamp((NAN, 0.0, 0.0)), ("nan", "rectangle")),
    "list of nodes": (
        lambda s: s.supports.clamp([0, 1]),
        ("edge name", "function of points", "numpy array"),
    ),
    "nodes that are not there": (
        lambda s: s.supports.clamp(np.array([25])),
        ("node numbers", "0..24", "rectangle"),
    ),
    "unknown component": (lambda s: s.supports.hold("left", "w"), ("x, y, z", "'w'")),
    "no component": (lambda s: s.supports.hold("left", ""), ("x, y, z", "''")),
    "no direction": (
        lambda s: s.supports.hold_normal("left", (0.0, 0.0, 0.0)),
        ("direction", "not all zero"),
    ),
    "director off its plane": (
        lambda s: s.supports.symmetry("left", (0.0, 0.0, 1.0)),
        ("node 0 of rectangle", "director", "90 degrees"),
    ),
    "motion that is no number": (
        lambda s: s.supports.move("right", displacement=(NAN, 0.0, 0.0)),
        ("displacement", "nan", "finite"),
    ),
    "motion of other nodes": (
        lambda s: s.supports.move("right", displacement=np.zeros((3, 3))),
        ("displacement", "(5, 3)"),
    ),
    "director that does not move": (
        lambda s: s.supports.move("right", director=(0.0, 0.0, 1.0)),
        ("director", "function of the level"),
    ),
}


@pytest.mark.parametrize("name", SUPPORTS)
def test_support(name, compiled):
    """A place or a condition that does not exist: what was given and what there is."""
    act, words = SUPPORTS[name]
    refused(lambda: act(sheet()), words, compiled)


LOADS = {
    "point": (lambda s: s.loads.point((1.0, 1.0, 0.0), (0.0, 0.0, NAN)), ("force", "N", "nan")),
    "point on no node": (
        lambda s: s.loads.point((1.0, 2.0, 0.0), (0.0, 0.0, 1.0)),
        ("no node of rectangle near",),
    ),
    "point as number": (lambda s: s.loads.point((1.0, 1.0, 0.0), 5.0), ("force", "three", "5.0")),
    "line": (lambda s: s.loads.line("right", (0.0, 0.0, NAN)), ("line load", "N/m", "nan")),
    "line along no edge": (
        lambda s: s.loads.line("rigth", (0.0, 0.0, 1.0)),
        ("no edge 'rigth'", "bottom, left, right, top"),
    ),
    "line of nodes": (
        lambda s: s.loads.line(lambda x: x[:, 0] > 0.9, (0.0, 0.0, 1.0)),
        ("line load", "edge", "with_edges"),
    ),
    "line by function": (
        lambda s: s.loads.line("right", lambda x: NAN * x),
        ("line load", "finite", "(4, 3)"),
    ),
    "line by function of another shape": (
        lambda s: s.loads.line("right", lambda x: x[:, 0]),
        ("line load", "(4, 3)"),
    ),
    "surface": (lambda s: s.loads.surface((0.0, 0.0, np.inf)), ("traction", "Pa", "inf")),
    "gravity": (lambda s: s.loads.gravity((0.0, 0.0, NAN)), ("gravity", "m/s^2", "nan")),
    "gravity as number": (lambda s: s.loads.gravity(9.81), ("gravity", "three", "9.81")),
    "edge moment": (
        lambda s: s.loads.edge_moment("right", (0.0, NAN, 0.0)),
        ("edge moment", "N m/m", "nan"),
    ),
    "point moment": (
        lambda s: s.loads.point_moment((1.0, 1.0, 0.0), (NAN, 0.0, 0.0)),
        ("moment", "N m", "nan"),
    ),
    "pressure": (lambda s: s.loads.pressure(NAN), ("pressure", "Pa", "nan")),
    "pressure as vector": (lambda s: s.loads.pressure((0.0, 0.0, 1.0)), ("pressure", "number")),
    "amplitude that is no function": (
        lambda s: s.loads.line("right", (0.0, 0.0, 1.0), 2.0),
        ("amplitude", "function", "2.0"),
    ),
}


@pytest.mark.parametrize("name", LOADS)
def test_load(name, compiled):
    """A load that is no load: its kind, its unit, what was given."""
    act, words = LOADS[name]
    refused(lambda: act(sheet()), words, compiled)


@pytest.mark.parametrize("levels", [0, -3, 1.5, "ten", [0.5, NAN], [np.inf]])
def test_load_levels(levels):
    """Load levels that lead nowhere are refused, not marched for ever or passed over."""
    shell = sheet()
    shell.supports.clamp("left")
    with pytest.raises(ValueError, match="level"):
        Statics(shell).solve(levels)
    assert np.abs(shell.displacements()).max() == 0.0


def test_free_sheet(compiled):
    """A sheet that can move off as a rigid body is told so."""
    shell = sheet()
    shell.supports.hold("left", "x")
    refused(lambda: Statics(shell), ("rigid motion", "rectangle", "hold it"), compiled)


@pytest.mark.serial
@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("Fabric.isotropic(1e6, 0.3, -0.01, 1000.0)", "thickness = -0.01 m"),
        ("meshes.load('nowhere.msh')", "nowhere.msh: there is no such file"),
        ("Shell(sheet, cotton).supports.clamp('hem')", "rectangle has no edge 'hem'"),
    ],
)
def test_program_ends_with_the_sentence(line, words, tmp_path):
    """The last line that a user's program prints is the sentence; its exit code is not 0."""
    script = tmp_path / "mistaken.py"
    script.write_text(
        "import meshes\n"
        "from shellform import Fabric, Shell\n"
        "sheet = meshes.rectangle(1.0, 1.0, (2, 2))\n"
        "cotton = Fabric.isotropic(1e6, 0.3, 0.01, 1000.0)\n"
        f"{line}\n"
    )
    done = subprocess.run(
        [sys.executable, script], capture_output=True, text=True, timeout=300, cwd=tmp_path
    )
    assert done.returncode != 0
    assert words in done.stderr.strip().splitlines()[-1]
