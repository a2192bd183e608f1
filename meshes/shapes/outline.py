"""Panels given by their outline: the disc, as five grids joined, and any flat polygon, meshed by
gmsh. Both consist of quads throughout.
"""
# SPDX-License-Identifier: LGPL-3.0-or-later

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from meshes.geometry import diagonal
from meshes.gmsh_model import gmsh_model
from meshes.repair import clean, orient
from meshes.subdivide import split_blocks
from meshes.surface import Surface
from meshes.topology import segments_of_line

from .grid import cell_counts, number_cells, positive


def disc(
    radius: float, cells: int | Sequence[int], degree: int = 1, warp: ArrayLike | None = None
) -> Surface:
    """Flat disc about the origin of the xy plane [m], quads throughout, directors +z.

    Parameters
    ----------
    radius : m.
    cells : n, or (n, m): n cells along each side of the inner square (4 n around the rim), m from
        the square to the rim; m defaults to about n / 2.
    degree, warp : as in `patch`.

    Edge 'rim', counter-clockwise. Raises ValueError.
    """
    positive(radius=radius)
    pair = cells if isinstance(cells, Sequence | np.ndarray) else (cells, max(1, (cells + 1) // 2))
    across, outward = cell_counts(pair)
    if degree not in (1, 2):
        raise ValueError(f"degree must be 1 or 2, not {degree}")
    square_grid, square_quads = number_cells((across, across), degree)
    ring_grid, ring_quads = number_cells((4 * across, outward), degree, (True, False))

    # The square is bulged towards a circle, so that no corner angle comes near 180 degrees.
    u, v = _ordered_nodes(square_grid)
    u, v = 2.0 * u - 1.0, 2.0 * v - 1.0
    inner = 0.5 * np.stack([u * np.sqrt(1.0 - v**2 / 4.0), v * np.sqrt(1.0 - u**2 / 4.0)], axis=1)

    # Its sides counter-clockwise from the corner at 225 degrees are the ring's inner line.
    last = degree * across
    side = np.arange(last)
    start, end = np.zeros(last, dtype=int), np.full(last, last)
    walk_i = np.concatenate([side, end, last - side, start])
    walk_j = np.concatenate([start, side, end, last - side])
    on_square = square_grid[walk_i, walk_j]
    angles = np.pi * (-0.75 + np.arange(4 * last) / (2.0 * last))
    rim = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    fractions = np.arange(degree * outward + 1)[:, None, None] / (degree * outward)
    ring = (1.0 - fractions) * inner[on_square] + fractions * rim

    # The ring runs around first and outward next, which faces -z: its quads are turned, and its
    # innermost row is the square's own.
    number = np.arange(ring_grid.max() + 1) - 4 * last + len(inner)
    number[: 4 * last] = on_square
    turned = [0, 3, 2, 1, 7, 6, 5, 4, 8] if degree == 2 else [0, 3, 2, 1]
    quads = np.concatenate([square_quads, number[ring_quads][:, turned]])
    flat = np.concatenate([inner, ring[1:].reshape(-1, 2)]) * radius
    points = np.column_stack([flat, np.zeros(len(flat))])
    directors = np.tile([0.0, 0.0, 1.0], (len(points), 1))
    edges = {"rim": segments_of_line(number[ring_grid[:, -1]], degree)}
    yarns = None if warp is None else np.asarray(warp)
    return Surface(points, quads, edges, directors, yarns, source="disc")


def _ordered_nodes(grid):
    """Parameters a and b of the points of an open grid in the order of their numbers."""
    a, b = np.meshgrid(*(np.linspace(0.0, 1.0, n) for n in grid.shape), indexing="ij")
    order = np.argsort(grid.ravel())
    return a.ravel()[order], b.ravel()[order]


def from_outline(
    outline: ArrayLike,
    size: float,
    quads: bool = True,
    names: Sequence[str | None] | None = None,
    warp: ArrayLike | None = None,
) -> Surface:
    """Flat panel inside a closed polygon, meshed by gmsh; the same arguments give the same mesh.

    Parameters
    ----------
    outline : (k, 2) or (k, 3) corners in m; the first may be repeated at the end. Each becomes a
        mesh point, and quads cut every side at least once: thin out a finely digitised line.
    size : wanted cell edge in m.
    quads : False for triangles.
    names : k names (or None) of the sides from corner i to corner i + 1; equal names join. None
        names the whole loop 'outline'.
    warp : None or (3,).

    Directors are +z for (k, 2); for (k, 3) they see the corners run counter-clockwise.

    Raises
    ------
    ValueError : for a polygon that is not flat, has no area or crosses itself, or a bad size.
    """
    positive(size=size)
    corners = np.asarray(outline, dtype=np.float64)
    if corners.ndim != 2 or corners.shape[1] not in (2, 3) or not np.isfinite(corners).all():
        raise ValueError(f"outline must be finite corners (k, 2) or (k, 3), not {corners.shape}")
    flat = corners.shape[1] == 2
    corners = np.column_stack([corners, np.zeros(len(corners))]) if flat else corners
    if len(corners) > 1 and np.array_equal(corners[0], corners[-1]):
        corners = corners[:-1]
    if names is not None and len(names) != len(corners):
        raise ValueError(f"names must be {len(corners)}, one for each side, not {len(names)}")
    normal, frame = _plane(corners)
    if flat:
        normal = np.array([0.0, 0.0, 1.0])
    origin = corners.mean(axis=0)
    plane = (corners - origin) @ frame.T
    _refuse_crossing(plane)

    # Cutting gmsh's mixed mesh through edge middles leaves quads only, whatever the outline.
    flat_points, blocks, sides = mesh_polygon(plane, 2.0 * size if quads else size, quads)
    points = origin + flat_points @ frame
    names = ["outline"] * len(sides) if names is None else names
    edges: dict[str, np.ndarray] = {}
    for name, side in zip(names, sides):
        if name is not None:
            edges[name] = np.concatenate([edges[name], side]) if name in edges else side
    if quads:
        points, cells, edges, _, _ = split_blocks(points, blocks, edges)
    else:
        (cells,) = blocks
    yarns = None if warp is None else np.asarray(warp)
    surface = Surface(points, cells, edges, warp=yarns, source="from_outline", verify=False)
    surface = orient(clean(surface), towards=normal)
    directors = np.tile(normal, (len(surface.points), 1))
    return surface.replace(directors=directors, verify=True)


def _plane(corners):
    """Unit normal and two unit vectors in the plane of a polygon (k, 3)."""
    if len(corners) < 3:
        raise ValueError(f"outline needs at least 3 corners, has {len(corners)}")
    extent = diagonal(corners)
    gaps = np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1)
    if gaps.min() <= 1e-9 * extent:
        raise ValueError(f"outline repeats corner {int(gaps.argmin())}")
    relative = corners - corners.mean(axis=0)
    normal = 0.5 * np.cross(relative, np.roll(relative, -1, axis=0)).sum(axis=0)
    area = np.linalg.norm(normal)
    if area <= 1e-9 * extent**2:
        raise ValueError("outline encloses no area")
    normal /= area
    heights = np.abs(relative @ normal)
    if heights.max() > 1e-6 * extent:
        raise ValueError(
            f"outline is not flat: corner {int(heights.argmax())} lies {heights.max():.3g} m off "
            "its plane"
        )
    along = np.eye(3)[np.argmin(np.abs(normal))]
    along = np.cross(np.cross(normal, along), normal)
    along /= np.linalg.norm(along)
    return normal, np.stack([along, np.cross(normal, along)])


def _refuse_crossing(plane):
    """ValueError naming two sides of a polygon (k, 2) that meet other than as neighbours."""
    count = len(plane)
    tails, heads = plane, np.roll(plane, -1, axis=0)

    def side_of(points):
        line, offset = (heads - tails)[:, None], points[None] - tails[:, None]
        return np.sign(line[..., 0] * offset[..., 1] - line[..., 1] * offset[..., 0])

    apart = side_of(tails) * side_of(heads)
    steps = (np.arange(count)[:, None] - np.arange(count)[None]) % count
    crossing = (apart <= 0) & (apart.T <= 0) & (steps > 1) & (steps < count - 1)
    # Sides in one line pass the sign test wherever they lie; they must also overlap.
    low, high = np.minimum(tails, heads), np.maximum(tails, heads)
    crossing &= ((low[:, None] <= high[None]) & (low[None] <= high[:, None])).all(axis=2)
    if crossing.any():
        one, other = np.argwhere(crossing)[0]
        raise ValueError(f"outline crosses or touches itself: sides {one} and {other}")


def mesh_polygon(
    plane: np.ndarray, size: float, quads: bool, whole_sides: bool = False
) -> tuple[np.ndarray, list[np.ndarray], list[np.ndarray]]:
    """Points (n, 2), list of cell blocks and list of side segments for a polygon (k, 2).

    quads : a mesh mostly of quads, with triangles between; whole_sides : cut no side
    """
    # Blossom recombination would cut every side in two once more, and print to the terminal.
    options = {"Algorithm": 6, "RecombineAll": int(quads), "RecombinationAlgorithm": 0}
    options |= {"ElementOrder": 1, "SubdivisionAlgorithm": 0, "RandomSeed": 1}
    with gmsh_model(**options) as gmsh:
        geo, mesh = gmsh.model.geo, gmsh.model.mesh
        tags = [geo.addPoint(x, y, 0.0, size) for x, y in plane.tolist()]
        lines = [geo.addLine(one, other) for one, other in zip(tags, tags[1:] + tags[:1])]
        for line in lines if whole_sides else ():
            geo.mesh.setTransfiniteCurve(line, 2)
        geo.addPlaneSurface([geo.addCurveLoop(lines)])
        geo.synchronize()
        mesh.generate(2)
        node_tags, coordinates, _ = mesh.getNodes()
        number = np.full(int(node_tags.max()) + 1, -1)
        number[node_tags.astype(np.int64)] = np.arange(len(node_tags))
        blocks = []
        for kind, width in ((2, 3), (3, 4)):
            nodes = mesh.getElementsByType(kind)[1]
            if len(nodes):
                blocks.append(number[nodes.astype(np.int64)].reshape(-1, width))
        sides = [mesh.getElements(1, line)[2][0].astype(np.int64) for line in lines]
    points = coordinates.reshape(-1, 3)[:, :2]
    return points, blocks, [number[side].reshape(-1, 2) for side in sides]
