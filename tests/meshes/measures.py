# SPDX-License-Identifier: LGPL-3.0-or-later
"""What the tests of meshes measure on a surface by themselves."""

import numpy as np

from meshes import Surface
from meshes.topology import directed_edges, edge_keys

TURN = 2.0 * np.pi
L_SHAPE = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]
# two squares side by side
SQUARE = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0], [1, 1, 0], [2, 1, 0.0]])
TWO = [[0, 1, 4, 3], [1, 2, 5, 4]]


def with_point(index, value):
    points = SQUARE.copy()
    points[index] = value
    return points


def euler(surface):
    corners = surface.cells[:, : 3 if surface.kind == "triangle" else 4]
    edges = np.unique(edge_keys(directed_edges(surface.cells), len(surface.points)))
    return len(np.unique(corners)) - len(edges) + len(corners)


def orders(errors):
    errors = np.abs(errors)
    return np.log2(errors[:-1] / errors[1:])


def shuffled(surface, seed=3):
    """Points and cells of a surface with a random half of its cells turned over."""
    rng = np.random.default_rng(seed)
    turn = rng.random(len(surface.cells)) < 0.5
    order = {3: [0, 2, 1], 4: [0, 3, 2, 1], 9: [0, 3, 2, 1, 7, 6, 5, 4, 8]}
    cells = surface.cells.copy()
    cells[turn] = cells[turn][:, order[cells.shape[1]]]
    return Surface(surface.points, cells, source="shuffled", verify=False)


def facing(surface):
    """Unit normal of each cell from its corners."""
    a, b, c, d = (surface.points[surface.cells[:, k]] for k in (0, 1, 2, -1))
    normal = np.cross(c - a, (d if surface.cells.shape[1] == 4 else c) - b)
    if surface.cells.shape[1] == 9:
        normal = np.cross(c - a, surface.points[surface.cells[:, 3]] - b)
    return normal / np.linalg.norm(normal, axis=1, keepdims=True)


def loop_length(surface, name):
    ends = surface.points[surface.edges[name][:, :2]]
    return np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum()


def section_length(surface, height):
    """Length of the line in which the level plane at ``height`` cuts the sides of the cells."""
    corners = surface.points[surface.cells]
    following = np.roll(corners, -1, axis=1)
    start, end = corners[..., 2] - height, following[..., 2] - height
    cut = start * end < 0.0
    assert set(cut.sum(axis=1)) <= {0, 2}
    part = np.where(cut, start / np.where(cut, start - end, 1.0), 0.0)
    places = (corners + part[..., None] * (following - corners))[cut].reshape(-1, 2, 3)
    return np.linalg.norm(places[:, 1] - places[:, 0], axis=1).sum()


def inside_volume(surface):
    """Volume by the divergence theorem, for a tube whose openings are level rings."""
    corners = surface.points[surface.cells]
    areas = 0.5 * np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    # x and y alone: level openings add nothing to the flux of (x, y, 0).
    return 0.5 * np.sum(areas[:, :2] * corners.mean(axis=1)[:, :2])
