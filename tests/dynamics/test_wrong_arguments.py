# SPDX-License-Identifier: LGPL-3.0-or-later
"""Things of another kind are refused by name, with what belongs there."""

import pytest

import meshes
import shellform as sf

FABRIC = sf.Fabric.isotropic(1e6, 0.3, 1e-3, 300.0)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: sf.Shell(None, FABRIC), "takes a meshes.Surface"),
        (lambda: sf.Shell(meshes.rectangle(1, 1, (1, 1)), "denim"), "takes a Fabric"),
        (lambda: sf.Newmark(None), "Newmark takes a Shell"),
        (lambda: sf.ImplicitNewmark("shell", 1e-3), "takes a Shell"),
        (lambda: sf.Statics(FABRIC), "takes a Shell"),
        (lambda: sf.follow(None), "takes a Shell"),
        (lambda: sf.Wearer("walk.trc", []), "moves as a Recording"),
        (lambda: sf.Contact(None), "takes a Body"),
    ],
)
def test_of_another_kind(make, words):
    with pytest.raises(TypeError, match=words):
        make()


def test_words_for_numbers():
    shell = sf.Shell(meshes.rectangle(1.0, 1.0, (1, 1)), FABRIC)
    with pytest.raises(ValueError, match="damping is a finite number"):
        sf.Newmark(shell, damping="much")
    with pytest.raises(FileNotFoundError, match="a card is a TOML file"):
        sf.read_fabric("nowhere.toml")
