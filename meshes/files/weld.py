# SPDX-License-Identifier: LGPL-3.0-or-later
"""Seams that nearly meet: told where a boundary comes close to itself, joined within a distance.

Two borders may miss each other by a rounding of the drawing program, or have points at different
places: a point of one then lies within a side of the other, a T-junction.
"""

from __future__ import annotations

import warnings
from itertools import pairwise

import numpy as np

from meshes.geometry import diagonal, joined
from meshes.topology import directed_edges, unique_edges

from .faces import Choice, tidy_faces

NEAR = 0.1  # of a side: a border as close to another was meant to meet it


def borders(blocks: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Sides (k, 2) of one cell alone, and the number (k,) of that cell through the blocks."""
    edges = np.concatenate([directed_edges(block)[:, :2] for block in blocks])
    owner = np.concatenate(
        [np.repeat(np.arange(len(b)), len(directed_edges(b)) // len(b)) for b in blocks]
    )
    sizes = np.cumsum([0] + [len(block) for block in blocks])
    starts = [len(directed_edges(block)) for block in blocks]
    owner += np.repeat(sizes[:-1], starts)
    first, _, count = unique_edges(edges, int(edges.max()) + 1)
    rows = np.sort(first[count == 1])
    return edges[rows], owner[rows]


def sides_of_borders(blocks: list[np.ndarray]) -> tuple[np.ndarray, list[np.ndarray]]:
    """Sides (k, 2) with both ends on a border, and the numbers of the cells at each.

    Among them are sides of two cells and more, into which a point of a border may belong: where a
    pocket is sewn on, the sheet behind it closes the gap that a T-junction leaves.
    """
    edges = np.concatenate([directed_edges(block)[:, :2] for block in blocks])
    sizes = [len(directed_edges(b)) // len(b) for b in blocks]
    owner = np.repeat(np.arange(sum(map(len, blocks))), np.repeat(sizes, list(map(len, blocks))))
    first, number, count = unique_edges(edges, int(edges.max()) + 1)
    ends = np.unique(edges[first[count == 1]])
    wanted = np.flatnonzero(np.isin(edges[first], ends).all(axis=1))
    order = np.argsort(number, kind="stable")
    starts = np.cumsum(count) - count
    cells = [owner[order[starts[k] : starts[k] + count[k]]] for k in wanted]
    return edges[first[wanted]], cells


def near_sides(
    points: np.ndarray, sides: np.ndarray, reach: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Border points that come near a border side which they do not bound.

    Parameters
    ----------
    points : (n, 3) in m; sides : (k, 2) of the border; reach : (k,) in m, for each side.

    Returns
    -------
    point, side, place along it (0 to 1) and distance [m], one row for each meeting. A neighbour of
    one end only is no meeting: there the border turns.
    """
    from scipy.spatial import cKDTree

    number = np.unique(sides)
    tree = cKDTree(points[number])
    ends = points[sides]
    half = 0.5 * np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    found = tree.query_ball_point(ends.mean(axis=1), half + reach)
    side = np.repeat(np.arange(len(sides)), [len(row) for row in found])
    point = number[np.concatenate([np.array(row, np.int64) for row in found])]
    keep = (point != sides[side, 0]) & (point != sides[side, 1])
    point, side = point[keep], side[keep]
    start, along = ends[side, 0], ends[side, 1] - ends[side, 0]
    place = np.einsum("ij,ij->i", points[point] - start, along) / np.sum(along**2, axis=1)
    place = np.clip(place, 0.0, 1.0)
    distance = np.linalg.norm(start + place[:, None] * along - points[point], axis=1)
    touching = {(a, b) for pair in sides.tolist() for a, b in (pair, pair[::-1])}
    ends_of = sides[side].tolist()
    beside = [
        ((p, a) in touching) != ((p, b) in touching) for p, (a, b) in zip(point.tolist(), ends_of)
    ]
    keep = (distance <= reach[side]) & ~np.array(beside, dtype=bool)
    return point[keep], side[keep], place[keep], distance[keep]


def tell_near_misses(points: np.ndarray, blocks: list[np.ndarray], name: str) -> None:
    """Warn where a border nearly meets another, naming the first place and the mend."""
    sides, _ = sides_of_borders(blocks)
    if not len(sides):
        return
    lengths = np.linalg.norm(np.diff(points[sides], axis=1)[:, 0], axis=1)
    # points that lie on one another are told by the check, for they may be a slit
    nothing = 1e-9 * diagonal(points)
    point, _, place, distance = near_sides(points, sides, NEAR * lengths)
    within = (place > 1e-6) & (place < 1 - 1e-6)
    keep = (distance > nothing) | within
    on_another = np.isin(point, point[(distance <= nothing) & ~within])
    keep &= ~on_another
    if not keep.any():
        return
    at, number = np.unique(point[keep], return_inverse=True)
    nearest = np.full(len(at), np.inf)
    np.minimum.at(nearest, number, distance[keep])
    count, widest = len(at), float(nearest.max())
    gap = f"up to {1e3 * widest:.2g} mm" if widest > nothing else "no distance at all"
    first = np.round(points[at[0]], 4).tolist()
    mend = float(f"{max(1.5 * widest, 1e-6):.1g}")
    warnings.warn(
        f"{name}: at {count} point{'s' if count > 1 else ''} the border comes near another side "
        f"without being joined to it ({gap}; first at {first} m): a "
        f"seam that nearly meets or a T-junction; it is joined by "
        f"weld={mend:g} in meshes.load, weld_m = {mend:g} under [garment].",
        stacklevel=2,
    )


def weld_borders(
    points: np.ndarray,
    blocks: list[np.ndarray],
    origins: np.ndarray,
    distance: float,
    name: str,
) -> tuple[list[np.ndarray], np.ndarray, np.ndarray, dict[tuple[int, int], list[int]]]:
    """Join border points no further apart than `distance` [m], and put those near a side into it.

    Parameters
    ----------
    points : (n, 3) in m; blocks, origins : as `tidy_faces` returns them; name : for messages.

    Returns
    -------
    blocks, origins : of the new cells.
    label : (n,) the point that each has become.
    inside : {ends of a side: points that were put into it, in their order}.
    """
    label = np.arange(len(points))
    inside: dict[tuple[int, int], list[int]] = {}
    sides, _ = borders(blocks)
    if not len(sides):
        return blocks, origins, label, inside
    number = np.unique(sides)
    label[number] = number[joined(points[number], distance)]
    moved = int((label != np.arange(len(points))).sum())
    faces = [list(map(int, row)) for block in blocks for row in label[block]]
    merged = [np.array([face for face in faces if len(face) == k]) for k in (3, 4)]
    merged = [block for block in merged if len(block)]
    rows = [k for width in (3, 4) for k, face in enumerate(faces) if len(face) == width]
    sides, owners = sides_of_borders(merged)
    if len(sides):
        lengths = np.linalg.norm(np.diff(points[sides], axis=1)[:, 0], axis=1)
        meetings = near_sides(points, sides, np.full(len(sides), distance))
        for point, side, place, _ in sorted(zip(*(m.tolist() for m in meetings)), key=_by_side):
            at = [faces[rows[cell]] for cell in owners[side]]
            if any(point in face for face in at) or not 0.0 < place < 1.0 or not lengths[side]:
                continue
            a, b = sides[side].tolist()
            before = inside.setdefault((a, b), [])
            for face in at:
                _put_in(face, a, b, point, before)
            before.append(point)
    put = sum(len(line) for line in inside.values())
    warnings.warn(
        f"{name}: weld joined {moved} points of the border to others"
        + (f" and put {put} into sides" if put else "")
        + f", within {1e3 * distance:g} mm.",
        Choice,
        stacklevel=2,
    )
    widths = sorted({len(face) for face in faces})
    groups = [[k for k, face in enumerate(faces) if len(face) == width] for width in widths]
    blocks = [np.array([faces[k] for k in group]) for group in groups]
    with warnings.catch_warnings():
        # faces that weld has given more corners or fewer are no fault of the file
        warnings.simplefilter("ignore")
        blocks, origins = tidy_faces(
            points, blocks, np.concatenate([origins[group] for group in groups]), name
        )
    return blocks, origins, label, inside


def _put_in(face: list[int], a: int, b: int, point: int, before: list[int]) -> None:
    """Put a point into the side a, b of a face, between those put there `before` and b."""
    after = face[(face.index(a) + 1) % len(face)]
    if after == b or after in before[:1]:
        last = before[-1] if before else a
        face.insert(face.index(last) + 1, point)
    else:
        face.insert(face.index(b) + 1, point)


def _by_side(meeting):
    return meeting[1], meeting[2]


def welded_edges(
    edges: dict[str, np.ndarray], label: np.ndarray, inside: dict[tuple[int, int], list[int]]
) -> dict[str, np.ndarray]:
    """Named edges (k, 2) on the points that welding has left, through those put into sides."""
    out = {}
    for name, edge in edges.items():
        segments = []
        for a, b in label[edge].tolist():
            line = [a, *inside.get((a, b), inside.get((b, a), [])[::-1]), b]
            segments += [pair for pair in pairwise(line) if pair[0] != pair[1]]
        out[name] = np.array(segments, dtype=np.int64).reshape(-1, 2)
    return {name: edge for name, edge in out.items() if len(edge)}
