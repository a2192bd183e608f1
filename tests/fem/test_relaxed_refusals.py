# SPDX-License-Identifier: LGPL-3.0-or-later
"""Sheets that cannot be relaxed are refused in one sentence that says what to take instead."""

import pytest

import meshes
from shellform import Fabric, Ply, Shell
from shellform.material.neo_hookean import NeoHookean

PLAIN = Fabric.isotropic(1e6, 0.3, 1e-3, 200.0)
RUBBER = Fabric.isotropic(1e6, 0.5, 1e-3, 200.0)
PLY = Ply(3e5, 1e5, 0.2, 8e3, 6e3, 5e3, 300.0)
COUPLED = Fabric.laminate([(PLY, 1e-3, 0.0), (PLY, 1e-3, 90.0)])
MEND = "take wrinkles='resolved'"

REFUSED = {
    "triangles": ({"triangles": True}, PLAIN, {}, "4-node quads, .* has triangles of 3 nodes"),
    "nine nodes": ({"degree": 2}, PLAIN, {}, "4-node quads, .* has quadrilaterals of 9 nodes"),
    "chords": ({}, PLAIN, {"membrane": "chords"}, "goes with membrane='arcs'"),
    "thick": ({}, PLAIN, {"thick": True}, "without `thick`"),
    "laminate": ({}, COUPLED, {}, "bending is not coupled with stretching"),
    "NeoHookean": ({}, RUBBER, {"law": NeoHookean()}, "not that of .*NeoHookean"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_refused(name, comm):
    mesh, fabric, options, sentence = REFUSED[name]
    surface = meshes.rectangle(0.2, 0.1, (2, 1), warp=(1.0, 0.0, 0.0), **mesh)
    with pytest.raises(ValueError, match=sentence) as told:
        Shell(surface, fabric, comm, wrinkles="relaxed", **options)
    said = str(told.value)
    assert said.startswith("wrinkles='relaxed'") and said.endswith(MEND) and "\n" not in said
    Shell(surface, fabric, comm, wrinkles="resolved", **options)


@pytest.mark.parametrize("word", ["wrinkled", "Relaxed", "", None, True])
def test_unknown_word(word, comm):
    surface = meshes.rectangle(0.2, 0.1, (2, 1))
    with pytest.raises(ValueError, match=f"wrinkles is one of resolved, relaxed, not '{word}'"):
        Shell(surface, PLAIN, comm, wrinkles=word)
