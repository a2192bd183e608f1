# SPDX-License-Identifier: LGPL-3.0-or-later
"""Surfaces of triangles that the tests of contact share."""

import numpy as np

from contact.body.blended_surface import BlendedSurface
from contact.body.rigid_surface import RigidSurface
from contact.body.segments import Body, Fixed, Segment, Steady
from contact.geometry.triangle_mesh.sphere import sphere
from tests.contact.solver.bodies import random_axes


def ball(radius=0.1, divisions=3, centre=(0.0, 0.0, 0.0), motion=Fixed):
    return RigidSurface(*sphere(radius, divisions), motion(centre), "ball")


def box(half, cells=1, motion=None, name="box"):
    """A box of half extents (3,), each face cut into cells x cells squares."""
    s = np.linspace(-1, 1, cells + 1)
    points, faces = [], []
    for axis in range(3):
        for side in (-1, 1):
            a, b = np.meshgrid(s, s, indexing="ij")
            face = np.empty((a.size, 3))
            face[:, axis], face[:, (axis + 1) % 3], face[:, (axis + 2) % 3] = (
                side, a.ravel(), b.ravel(),
            )  # fmt: skip
            k = np.arange(a.size).reshape(a.shape)
            p, q, r, t = k[:-1, :-1].ravel(), k[1:, :-1].ravel(), k[1:, 1:].ravel(), k[:-1, 1:]
            t = t.ravel()
            two = np.vstack([np.column_stack([p, q, r]), np.column_stack([p, r, t])])
            faces.append((two if side > 0 else two[:, ::-1]) + sum(map(len, points)))
            points.append(face)
    points = np.vstack(points)
    _, first, which = np.unique(
        np.round(points * 1e6).astype(int), axis=0, return_index=True, return_inverse=True
    )
    triangles = which.reshape(-1)[np.vstack(faces)]
    return RigidSurface(points[first] * half, triangles, motion or Fixed(), name)


def lump(rng, divisions=4, moving=True):
    """A closed surface with hills and hollows bound to three segments, at rest or in motion."""
    vertices, triangles = sphere(0.1, divisions)
    vertices = vertices * [1.0, 0.6, 0.8]
    vertices = vertices * (1.0 + 0.12 * np.sin(35 * vertices[:, [1, 2, 0]]))
    segments = []
    for k in range(3):
        pose = rng.uniform(-0.05, 0.05, 3), random_axes(rng)
        rates = rng.uniform(-1, 1, 3), rng.uniform(-5, 5, 3)
        motion = Steady(*pose, *rates) if moving else Fixed(*pose)
        segments.append(Segment(f"s{k}", [0.05] * 3, motion))
    places = np.array([[0.06, 0, 0], [-0.03, 0.05, 0], [-0.03, -0.05, 0.0]])
    near = np.exp(-np.sum((vertices[:, None] - places) ** 2, axis=2) / (2 * 0.04**2))
    return BlendedSurface(
        vertices, triangles, near / near.sum(axis=1, keepdims=True), Body(segments)
    )


def tube(radius, length, around, along, axis=2, motion=None, name="tube"):
    """A cylinder about an axis with flat ends: `around` corners, `along` rings of squares."""
    angle = 2 * np.pi * np.arange(around) / around
    heights = length * (np.arange(along + 1) / along - 0.5)
    ring = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), 0 * angle])
    points = np.vstack([ring + [0, 0, z] for z in heights] + [[[0, 0, heights[0]]]])
    points = np.vstack([points, [0, 0, heights[-1]]])
    k, turn = np.arange(around), (np.arange(around) + 1) % around
    faces = []
    for row in range(along):
        a, b = row * around + k, row * around + turn
        c, d = a + around, b + around
        # squares are cut in turn one way and the other: no twist
        even = (k + row) % 2 == 0
        faces += [np.column_stack([a, b, np.where(even, d, c)])]
        faces += [np.column_stack([np.where(even, a, b), d, c])]
    last = along * around
    faces += [np.column_stack([turn, k, np.full(around, len(points) - 2)])]
    faces += [np.column_stack([last + k, last + turn, np.full(around, len(points) - 1)])]
    points = np.roll(points, (axis + 1) % 3, axis=1)
    return RigidSurface(points, np.vstack(faces), motion or Fixed(), name)


def valley(half_angle, width=0.2, depth=0.1, length=2.0):
    """A block with a straight valley along x, its bottom the x axis, sides at half_angle to z."""
    rise = width / np.tan(half_angle)
    profile = np.array(
        [[0, 0], [width, rise], [width + 0.05, rise], [width + 0.05, -depth],
         [-width - 0.05, -depth], [-width - 0.05, rise], [-width, rise]]
    )  # fmt: skip
    n = len(profile)
    points = np.vstack(
        [np.column_stack([np.full(n, x), profile]) for x in (-length / 2, length / 2)]
    )
    k, turn = np.arange(n), (np.arange(n) + 1) % n
    sides = [np.column_stack([k, turn + n, turn]), np.column_stack([k, k + n, turn + n])]
    flat = np.array([[0, 1, 3], [1, 2, 3], [0, 3, 4], [0, 4, 6], [4, 5, 6]])
    faces = np.vstack([*sides, flat, flat[:, ::-1] + n])
    return RigidSurface(points, faces, Fixed(), "valley")
