# SPDX-License-Identifier: LGPL-3.0-or-later
"""Garments with something sewn on, so that three cells meet at the seams."""

import numpy as np

import meshes
from meshes import Surface


def with_patch(surface, chosen, off=0.003, turned=False, open_top=False):
    """The surface with a second sheet over the cells `chosen` (mask), `off` [m] outside.

    The border of the patch is sewn on all around, or left open where it is highest.
    """
    cells = surface.cells[chosen]
    own = np.unique(cells)
    sides = np.stack([cells, np.roll(cells, -1, axis=1)], axis=2).reshape(-1, 2)
    _, first, count = np.unique(
        np.sort(sides, axis=1), axis=0, return_index=True, return_counts=True
    )
    border = sides[first[count == 1]]
    if open_top:
        heights = surface.points[border, 2].mean(axis=1)
        border = border[heights < heights.max() - 0.3 * np.ptp(heights)]
    free = np.setdiff1d(own, border)
    number = np.arange(len(surface.points))
    number[free] = len(surface.points) + np.arange(len(free))
    lifted = surface.points[free] + off * surface.directors[free]
    patch = number[cells]
    return Surface(
        np.concatenate([surface.points, lifted]),
        np.concatenate([surface.cells, patch[:, ::-1] if turned else patch]),
        surface.edges,
        source=f"{surface.source} with a patch",
        verify=False,
    )


def with_collar(surface, ring, rows, off=0.004):
    """The surface with a strip that hangs from a closed line of its points, down and outward.

    ring : (k,) points of the line; rows : rows of cells of the strip.
    """
    points, cells, n = [surface.points], [surface.cells], len(surface.points)
    k, last = len(ring), np.asarray(ring)
    drop = 0.8 * np.linalg.norm(surface.points[ring[0]] - surface.points[ring[1]])
    for row in range(1, rows + 1):
        new = n + np.arange(k) + (row - 1) * k
        points.append(surface.points[ring] + off * row * surface.directors[ring])
        points[-1][:, 2] -= drop * row
        cells.append(np.stack([last, np.roll(last, -1), np.roll(new, -1), new], axis=1))
        last = new
    return Surface(
        np.concatenate(points),
        np.concatenate(cells),
        surface.edges,
        source=f"{surface.source} with a collar",
        verify=False,
    )


def tee(n, degrees, size=0.4):
    """A square of n x n cells and a flap from its middle line, at an angle to it.

    Returns the surface, its points and the points of the flap's free edge.
    """
    flat = meshes.rectangle(size, size, (n, n))
    line = np.flatnonzero(np.abs(flat.points[:, 0] - 0.5 * size) < 1e-9)
    line = line[np.argsort(flat.points[line, 1])]
    away = np.array([np.cos(np.radians(degrees)), 0.0, np.sin(np.radians(degrees))])
    points, cells, last = [flat.points], [flat.cells], line
    for row in range(1, n // 2 + 1):
        new = len(flat.points) + len(line) * (row - 1) + np.arange(len(line))
        points.append(flat.points[line] + size / n * row * away)
        cells.append(np.stack([last[:-1], last[1:], new[1:], new[:-1]], axis=1))
        last = new
    whole = Surface(np.concatenate(points), np.concatenate(cells), verify=False)
    return meshes.orient(whole).replace(verify=True), np.arange(len(flat.points)), last


def pocketed_trousers(cell_size=0.04):
    """Trousers with a pocket on the front of either thigh, its top open, and a placket."""
    plain = meshes.trousers("large-regular", cell_size=cell_size)
    out = plain
    for sign in (1, -1):
        middle = plain.points[plain.cells].mean(axis=1)
        front = plain.directors[plain.cells].mean(axis=1)[:, 0] > 0.5
        chosen = front & (sign * middle[:, 1] > 0.06) & (abs(middle[:, 2] - 0.68) < 0.08)
        chosen = np.append(chosen, np.zeros(len(out.cells) - len(chosen), bool))
        with_normals = out.replace(directors=np.resize(plain.directors, (len(out.points), 3)))
        out = with_patch(with_normals, chosen, turned=sign > 0, open_top=True)
    return out.replace(warp=None)
