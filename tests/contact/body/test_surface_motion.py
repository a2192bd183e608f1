# SPDX-License-Identifier: LGPL-3.0-or-later
"""Surfaces of triangles that follow segments: where they are, and the adjoint; bad ones."""

import numpy as np
import pytest

from contact.body.blended_surface import BlendedSurface
from contact.body.rigid_surface import RigidSurface
from contact.body.segments import Body, Fixed, Segment, Steady, turned
from contact.body.surface_motion import SurfaceMotion
from contact.geometry.triangle_mesh.closed import closed_surface, volume
from contact.geometry.triangle_mesh.crossings import crossings
from contact.geometry.triangle_mesh.sphere import sphere
from tests.contact.solver.bodies import random_axes


def skin(rng, moving=True):
    """A sphere bound to three segments in motion."""
    vertices, triangles = sphere(0.1, 2)
    segments = [
        Segment(
            f"s{k}",
            [0.05] * 3,
            Steady(
                rng.uniform(-0.05, 0.05, 3), random_axes(rng), rng.uniform(-3, 3, 3),
                rng.uniform(-9, 9, 3),
            ),
        )
        for k in range(3)
    ]  # fmt: skip
    weights = rng.dirichlet(np.ones(3), len(vertices))
    weights[::3] = [0.0, 1.0, 0.0]
    return BlendedSurface(vertices, triangles, weights, Body(segments))


def surfaces():
    rng = np.random.default_rng(3)
    motion = Steady([0.1, 0.2, 0.3], random_axes(rng), [1.0, -2.0, 0.5], [5.0, 3.0, -4.0])
    return skin(rng), RigidSurface(*sphere(0.1, 2), motion, "ball")


@pytest.mark.parametrize("which", [0, 1])
def test_adjoint_keeps_momentum_moment_and_power(which):
    surface = surfaces()[which]
    assert isinstance(surface, SurfaceMotion)
    rng, t, h = np.random.default_rng(4), 0.07, 1e-6
    n, m = surface.vertex_count, len(surface.names)
    impulse = rng.standard_normal((n, 6))
    impulse[::4] = 0.0
    book = np.zeros((m, 9))
    surface.add_to_segments(t, impulse, book)
    x, ahead, back = (surface.positions(s, np.empty((n, 3))) for s in (t, t + h, t - h))
    centres = surface.centres(t, np.empty((m, 3)))
    moment = book[:, 3:6] + np.cross(centres, book[:, :3])
    assert book[:, :3].sum(axis=0) == pytest.approx(impulse[:, :3].sum(axis=0), abs=1e-12)
    assert moment.sum(axis=0) == pytest.approx(np.cross(x, impulse[:, :3]).sum(axis=0), abs=1e-12)
    assert book[:, 6:].sum(axis=0) == pytest.approx(impulse[:, 3:].sum(axis=0), abs=1e-12)
    power = np.sum(impulse[:, :3] * (ahead - back)) / (2 * h)
    if which == 0:
        pose = surface.body.new_pose(t)
        rates = pose.velocities, pose.spins
    else:
        _, _, velocity, spin = surface.pose(t)
        rates = velocity[None], spin[None]
    given = np.sum(book[:, :3] * rates[0]) + np.sum(book[:, 3:6] * rates[1])
    assert given == pytest.approx(power, rel=1e-7)


def test_a_skin_is_where_it_was_bound():
    surface = skin(np.random.default_rng(5))
    x = surface.positions(0.0, np.empty((surface.vertex_count, 3)))
    assert np.abs(x - sphere(0.1, 2)[0]).max() < 1e-15
    assert surface.moves and set(surface.owners) == {0, 1, 2}


def test_a_rigid_surface_follows_its_pose():
    vertices, triangles = sphere(0.1, 1)
    turn = turned(np.eye(3), np.array([0.3, -0.2, 0.9]))
    ball = RigidSurface(vertices, triangles, Fixed((1.0, 2.0, 3.0), turn), "ball")
    x = ball.positions(0.0, np.empty((ball.vertex_count, 3)))
    assert np.abs(x - ([1.0, 2.0, 3.0] + vertices @ turn)).max() < 1e-15
    assert not ball.moves
    with pytest.raises(ValueError, match="orthonormal axes"):
        RigidSurface(
            vertices, triangles, lambda t: ((0, 0, 0), 2 * np.eye(3), 0, 0), "a"
        ).positions(0.0, x)


def spoil(kind):
    vertices, triangles = sphere(0.1, 2)
    if kind == "open":
        triangles = triangles[1:]
    elif kind == "nan":
        vertices[7, 1] = np.nan
    elif kind == "millimetres":
        vertices = vertices * 1e3
    elif kind == "kilometres":
        vertices = vertices * 1e-3
    elif kind == "senses":
        triangles[3] = triangles[3][::-1]
    elif kind == "twice":
        triangles = np.vstack([triangles, triangles[:1], triangles[:1, ::-1]])
    elif kind == "flat":
        vertices[triangles[5, 0]] = vertices[triangles[5, 1]]
    elif kind == "index":
        triangles[2, 1] = 1000
    elif kind == "quads":
        triangles = np.column_stack([triangles, triangles[:, 0]])
    elif kind == "none":
        triangles = triangles[:0]
    return vertices, triangles


@pytest.mark.parametrize(
    ("kind", "said"),
    [
        ("open", "belongs to one triangle only, as 3 do: the surface is open; close its holes"),
        ("nan", "vertex 7 of surface 'scan' is at .*nan.*: mend or remove it"),
        ("millimetres", r"is 200 m long, which tells of another unit: give vertices in metres"),
        ("kilometres", "is 0.0002 m long, which tells of another unit"),
        ("senses", "is run along in one sense by both its triangles, as 3 are: orient"),
        ("twice", "belongs to more than two triangles, as 3 do: remove"),
        ("flat", r"triangle \d+ of surface 'scan' has no area .*: merge vertices"),
        ("index", "triangle 2 of surface 'scan' names vertices .* and there are 0 to 65"),
        ("quads", r"triangles of the shape \(128, 4\) .*split larger polygons"),
        ("none", "has no triangles"),
    ],
)
def test_bad_surfaces_are_refused_with_their_mend(kind, said):
    with pytest.raises(ValueError, match=said):
        closed_surface(*spoil(kind), "scan")


def test_an_inside_out_surface_is_turned_and_that_is_told():
    vertices, triangles = sphere(0.1, 2)
    with pytest.warns(UserWarning, match="surface 'scan' was inside-out: all its triangles are"):
        points, turned_back = closed_surface(vertices, triangles[:, ::-1], "scan")
    outward = volume(vertices, triangles)
    assert outward > 0 and volume(points, turned_back) == pytest.approx(outward, rel=1e-12)


def test_a_surface_that_passes_through_itself_is_told():
    """Two spheres whose skins cross; every crossing is found, as by trying all pairs."""
    vertices, triangles = sphere(0.1, 2)
    both = np.vstack([vertices, vertices + [0.07, 0.013, 0.021]])
    faces = np.vstack([triangles, triangles + len(vertices)])
    count, (i, _, k) = crossings(both, faces)
    with pytest.warns(UserWarning, match=f"surface 'scan' passes through itself: {count} edges "):
        closed_surface(both, faces, "scan")
    edges = np.unique(np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0)
    expected = 0
    for a, b in edges:
        p, d = both[a], both[b] - both[a]
        corners = both[faces]
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        slope = normal @ d
        slope[slope == 0.0] = np.inf  # along the triangle, as are those of its own corners
        part = np.sum((corners[:, 0] - p) * normal, axis=1) / slope
        x = p + part[:, None] * d
        inside = (part > 0) & (part < 1) & ~np.isin(faces, [a, b]).any(axis=1)
        for m in range(3):
            q, r = corners[:, m], corners[:, (m + 1) % 3]
            inside &= np.sum(np.cross(r - q, x - q) * normal, axis=1) > 0
        expected += inside.sum()
    assert count == expected > 20
    assert i in faces[: len(triangles)] and k >= len(triangles)
    assert crossings(vertices, triangles)[0] == 0


def test_weights_that_are_none_are_refused():
    vertices, triangles = sphere(0.1, 1)
    body = Body([Segment(name, [0.1] * 3, Fixed()) for name in "ab"])
    good = np.full((len(vertices), 2), 0.5)
    for weights, said in (
        (good[1:], "have the shape"),
        (good * 1.1, r"weights of vertex 0 .* add up to 1"),
        (good + np.array([[1.0, -1.0]]), "numbers >= 0"),
    ):
        with pytest.raises(ValueError, match=said):
            BlendedSurface(vertices, triangles, weights, body)
