# SPDX-License-Identifier: LGPL-3.0-or-later
"""Trousers put on a body of triangles, cloth on cloth: nothing passes, and they hang as worn."""

from dataclasses import replace

import numpy as np
import pytest

from contact.geometry.triangle_mesh.closest import signed_distances
from contact.geometry.triangle_mesh.placed import new_placed, refit
from contact.geometry.triangle_mesh.topology import mesh_of
from shellform.dressing import dress_skin
from shellform.dressing.fit import elongation, layers_warning
from shellform.dressing.procedure import Dressing
from shellform.dressing.shoulders import RELEASED
from shellform.errors import Mendable
from shellform.scene.parts import Contact, Garment, Motion, Output, Person, Steps
from shellform.scene.scene import Scene
from shellform.simulation.model import Model
from shellform.simulation.run import run
from tests.motion.body_mesh.test_scan import write

GROWN, HASTY = 0.15, Dressing(belt=0.05, release=0.05)
SCENE = Scene(
    motion=Motion(strides=1, obstacle=0.0),
    garment=Garment(cell_size=0.04),
    contact=Contact(self_contact=True),
    steps=Steps(runs=1),
)


@pytest.fixture(scope="module")
def scanned(tmp_path_factory):
    scan = write(tmp_path_factory.mktemp("scan"), "stl")
    return replace(SCENE, person=Person(body=str(scan), girths={"calf": 0.40, "knee": 0.41}))


def depths(model):
    """Signed distances of the nodes from the flat triangles of the standing skin [m]."""
    skin, x = model.skin, np.ascontiguousarray(model.shell.positions())
    whole = skin.positions(model.wearer.start, np.empty((skin.vertex_count, 3)))
    mesh = mesh_of(skin.triangles, whole)
    placed, out = new_placed(mesh, len(whole)), np.empty(len(x))
    placed.vertices[:] = whole
    refit(mesh, placed)
    signed_distances(mesh, placed, x, out, np.empty(len(x), np.int64))
    return out


def hangs_as_worn(model):
    """No layer in another or in the body, hems at the ankles, outer sides outside."""
    surface, x = model.surface, model.shell.positions()
    assert model.stepper.self_contact.intersections() == 0
    assert (
        depths(model).min() > -5e-3
    )  # smooth skin stands off its flat triangles, in hollows below
    for edge in ("waist", "left_hem", "right_hem"):
        nodes = np.unique(surface.edges[edge])
        assert np.abs(x[nodes, 2] - surface.points[nodes, 2]).max() < 0.04
    assert elongation(x, model.shell.directors(), surface).max() < 0.05
    corners = surface.cells[:, :3]

    def outward(points):
        a, b, c = points[corners[:, 0]], points[corners[:, 1]], points[corners[:, 2]]
        return np.cross(b - a, c - a)

    turned = np.einsum("ij,ij->i", outward(x), outward(surface.points)) < 0
    assert turned.mean() < 0.02  # a leg inside out would turn hundreds


@pytest.mark.serial
def test_nothing_passes_as_the_body_grows(scanned, comm, monkeypatch):
    monkeypatch.setattr(dress_skin, "GROWN", GROWN)
    model = Model(scanned, comm)
    stepper, stages = model.stepper, []
    stepper.remove(model.contact)

    def meet(surface):
        return model._meet(stepper, surface, bare=True)

    belt, seconds = dress_skin.dress_skin(
        stepper, model.skin, model.wearer, 20.0, meet, HASTY, lambda stage, _: stages.append(stage)
    )
    assert seconds == pytest.approx(RELEASED + GROWN + 0.1) and belt.tension == 20.0
    assert stepper.time == pytest.approx(model.wearer.start) and stepper.contact is None
    assert list(dict.fromkeys(stages)) == ["laid", "grow", "grown", "belt", "belted"]
    model.contact = meet(model.skin)
    hangs_as_worn(model)


def test_what_passes_is_told():
    assert layers_warning(0, "trousers") is None
    said = layers_warning(3, "trousers")
    assert "in 3 places" in said and "dress it anew" in said


BODIES = ("male", "female", "scan")


@pytest.mark.thorough
@pytest.mark.serial
@pytest.mark.parametrize("body", BODIES)
def test_dressed_and_walked(body, scanned, tmp_path, comm):
    """The standing body carries the weight; in the walk nothing passes."""
    scene = scanned if body == "scan" else replace(SCENE, person=Person(body="mesh", sex=body))
    scene = replace(scene, motion=Motion(end=1.0), output=Output(frames=10.0))
    try:
        model = Model(scene, comm)
    except Mendable as error:
        pytest.skip(f"no files of the body to use: {error}")
    model.dress()
    hangs_as_worn(model)
    weight = model.weight
    model.contact.reset()
    model.stepper.advance(0.05)
    window = model.contact.window
    assert window.impulse[:, 2].sum() / window.seconds == pytest.approx(weight, rel=0.02)
    assert run(scene, tmp_path, comm, lines=False)["intersections"] == 0
