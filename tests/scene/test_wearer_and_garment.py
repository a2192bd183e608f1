# SPDX-License-Identifier: LGPL-3.0-or-later
"""From scenes to wearer and garment: where they are, and how large."""

import numpy as np
import pytest

import meshes
from shellform.fem.director import rotation_matrix
from shellform.motion import anthropometry
from shellform.motion.gait.synthetic_walk import synthetic_walk
from shellform.motion.recording import Recording
from shellform.motion.stance import stance
from shellform.scene import wearer as build
from shellform.scene.fit import girth_at, waist_height
from shellform.scene.garment import garment_of
from shellform.scene.parts import Garment, Motion, Person
from shellform.scene.reach import reach_of
from shellform.scene.scene import Scene

COARSE = Garment(cell_size=0.04)


def turned(recording, angle, shift):
    """A recording turned about the vertical by angle [rad] and moved over the floor (2,) [m]."""
    turn = rotation_matrix([0.0, 0.0, angle])
    points = {name: track @ turn.T + [*shift, 0.0] for name, track in recording.points.items()}
    return Recording(recording.times, points, recording.source, facts=recording.facts)


def test_garment_goes_where_the_wearer_stands(monkeypatch):
    """Somewhere else and turned, the garment is turned and moved with the wearer."""
    scene, angle, shift = Scene(garment=COARSE), 2.3, (4.0, -3.0)
    plain = garment_of(scene, build.wearer_of(scene))
    monkeypatch.setattr(
        build, "synthetic_walk", lambda **kinds: turned(synthetic_walk(**kinds), angle, shift)
    )
    wearer = build.wearer_of(scene)
    surface, turn = garment_of(scene, wearer), rotation_matrix([0.0, 0.0, angle])
    assert stance(wearer)[2] == pytest.approx(turn[:, 0], abs=1e-12)
    for name in ("points", "directors"):
        exact = getattr(plain, name) @ turn.T + ([*shift, 0.0] if name == "points" else 0.0)
        assert np.abs(getattr(surface, name) - exact).max() < 1e-9
    assert not wearer.new_pose(wearer.start).velocities.any()


def test_waist_is_where_a_belt_stays():
    """Of all levels between hips and ribs the one with the least girth, to a millimetre."""
    wearer = build.wearer_of(Scene())
    pose, trunk = wearer.new_pose(wearer.start), [wearer.index("pelvis"), wearer.index("abdomen")]

    def girth(level):
        return anthropometry.girth(
            pose.centres[trunk], pose.axes[trunk], wearer.radii[trunk], level
        )

    height = waist_height(wearer)
    low, here, high = (girth(height + step) for step in (-0.01, 0.0, 0.01))
    assert here < min(low, high) - 1e-3
    levels = np.arange(height - 0.05, height + 0.05, 1e-3)
    assert abs(levels[np.argmin([girth(level) for level in levels])] - height) <= 2e-3
    surface = garment_of(Scene(garment=COARSE), wearer)
    assert surface.points[surface.edges["waist"], 2].min() == pytest.approx(height, abs=1e-9)


@pytest.mark.parametrize("triangles", [False, True])
def test_girth_of_a_garment(triangles):
    """A cylinder's section is the polygon it is made of; beyond its ends there is none."""
    surface = meshes.cylinder(0.2, 0.5, (24, 5), angle=2 * np.pi, triangles=triangles)
    along = np.ptp(surface.points, axis=0).argmax()
    turn = np.eye(3)[[(along + 1) % 3, (along + 2) % 3, along]]
    surface = surface.transform(rotation=turn)
    middle, cells = surface.points[:, 2].mean() + 1e-3, np.ones(len(surface.cells), bool)
    exact = 24 * 2 * 0.2 * np.sin(np.pi / 24)
    # the diagonals of triangles lie inside the polygon's sides
    assert girth_at(surface, middle, cells) == pytest.approx(exact, rel=1e-9)
    assert girth_at(surface, middle + 1.0, cells) == 0.0


def test_legs_reach_their_own_side():
    scene = Scene(garment=COARSE)
    wearer = build.wearer_of(scene)
    surface = garment_of(scene, wearer)
    allowed = reach_of(surface, wearer)
    for side, other in (("right", "left"), ("left", "right")):
        hem = allowed[surface.edges[f"{side}_hem"][:, 0]]
        for part in ("thigh", "shank", "foot"):
            assert (hem & wearer.mask([f"{side}_{part}"])).all()
            assert not (hem & wearer.mask([f"{other}_{part}"])).any()
        assert (hem & wearer.mask(["pelvis"])).all()
    waist = allowed[surface.edges["waist"][:, 0]]
    assert (waist == wearer.mask(wearer.names)).all()


def test_part_of_a_walk_begins_at_rest():
    """Cut out of the middle, it gets a way from standing into it, and the facts of the whole."""
    wearer = build.wearer_of(Scene(motion=Motion(start=2.0, end=2.5, initiation=0.8)))
    assert wearer.start == pytest.approx(1.2) and wearer.end == pytest.approx(2.5)
    assert not wearer.new_pose(wearer.start).velocities.any()
    whole = build.wearer_of(Scene())
    assert wearer.recording.facts == whole.recording.facts
    for t in (2.1, 2.4):  # away from the ends of the splines
        now, then = wearer.new_pose(t), whole.new_pose(t)
        assert np.abs(now.centres - then.centres).max() < 1e-5
        assert np.abs(now.axes - then.axes).max() < 1e-4
    # one that begins with standing gets none
    assert whole.start == 0.0


def test_stature_scales_wearer_and_garment():
    """Half a percent: hems and waist keep their places on the body."""
    parts = []
    for stature in (1.755, 1.9):
        scene = Scene(person=Person(stature=stature), garment=COARSE)
        wearer = build.wearer_of(scene)
        surface = garment_of(scene, wearer)
        heights = [surface.points[surface.edges[e], 2].min() for e in ("waist", "left_hem")]
        parts.append(np.array([stance(wearer)[0], *heights]))
    assert parts[1] / parts[0] == pytest.approx(1.9 / 1.755, rel=5e-3)
