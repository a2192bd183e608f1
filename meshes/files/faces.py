# SPDX-License-Identifier: LGPL-3.0-or-later
"""Faces of a file into cells: repeated corners, faces without area, twins, more than four corners.

Drawing programs write all of these. What is no cell is left out and told; what has more corners is
cut into quads, and into a triangle where the corners are odd in number.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterable

import numpy as np

from meshes.geometry import area_vectors
from meshes.validity import MeshError


class Choice(UserWarning):
    """What was done to a sound file: a note of the surface, nothing to be warned of."""


MOST_CORNERS = 200  # of a face that is cut; a larger one is a lid, or no garment's
_STRAIGHT = 0.02  # sine of a corner that is none: a point put into a side
_NO_AREA = 1e-10  # of the square of the longest side


def tidy_faces(
    points: np.ndarray, blocks: list[np.ndarray], origins: np.ndarray, name: str
) -> tuple[list[np.ndarray], np.ndarray]:
    """Cells (m, 3) and (m, 4) of faces with any number of corners, and where each comes from.

    Parameters
    ----------
    points : (n, 3).
    blocks : faces by number of corners, (m, k) each, indices in range.
    origins : (sum of m, 2) block and row in the file of every face.
    name : of the file, for messages.

    Returns
    -------
    blocks of triangles and of quads, those that are not empty; origins (m, 2) of their cells.

    Raises
    ------
    MeshError : if no cell is left, or a face cannot be cut.
    """
    starts = np.cumsum([0] + [len(block) for block in blocks])
    faces: dict[int, list[np.ndarray]] = {}
    sources: dict[int, list[np.ndarray]] = {}
    repeated = 0
    for block, start in zip(blocks, starts):
        where = origins[start : start + len(block)]
        twice = (block == np.roll(block, 1, axis=1)).any(axis=1)
        faces.setdefault(block.shape[1], []).append(block[~twice])
        sources.setdefault(block.shape[1], []).append(where[~twice])
        for face, origin in zip(block[twice].tolist(), where[twice]):
            kept = np.array([p for p, q in zip(face, face[-1:] + face[:-1]) if p != q], np.int64)
            repeated += len(kept) >= 3
            faces.setdefault(len(kept), []).append(kept[None])
            sources.setdefault(len(kept), []).append(origin[None])
    if repeated:
        _tell(
            name,
            repeated,
            "names a point twice in a row and loses that corner",
            "name a point twice in a row and lose that corner",
        )
    whole = {k: (np.concatenate(faces[k]), np.concatenate(sources[k])) for k in sorted(faces)}
    few = sum(len(cells) for k, (cells, _) in whole.items() if k < 3)
    if few:
        _tell(
            name,
            few,
            "has less than three different corners and is left out",
            "have less than three different corners and are left out",
        )
    has_quads = any(len(cells) for k, (cells, _) in whole.items() if k == 4)
    cut: dict[int, list[tuple[np.ndarray, np.ndarray]]] = {3: [], 4: []}
    many = 0
    for k, (cells, where) in whole.items():
        if k < 3 or not len(cells):
            continue
        cells, where = _sound(points, cells, where, name)
        if k <= 4:
            cut[k].append((cells, where))
            continue
        many += len(cells)
        for face, origin in zip(cells, where):
            for part in cut_polygon(points[face], has_quads, f"{name}: face {face.tolist()}"):
                cut[len(part)].append((face[part][None], origin[None]))
    if many:
        shape = "quads" if has_quads else "triangles"
        _tell(
            name,
            many,
            f"has more than four corners and is cut into {shape}",
            f"have more than four corners and are cut into {shape}",
            Choice,
        )
    out, places = [], []
    for parts in cut.values():
        if not parts:
            continue
        cells = np.concatenate([cells for cells, _ in parts])
        where = np.concatenate([where for _, where in parts])
        # in the order of the file, whatever became of the faces
        order = np.lexsort((where[:, 1], where[:, 0]))
        if len(cells):
            out.append(cells[order])
            places.append(where[order])
    if not out:
        raise MeshError(f"{name}: no face of the file has an area, export the surface mesh.")
    return out, np.concatenate(places)


def drop_twins(
    blocks: list[np.ndarray], origins: np.ndarray, name: str
) -> tuple[list[np.ndarray], np.ndarray]:
    """The cells without those that have the same corners as one before, and their origins."""
    kept, places, start, twins = [], [], 0, 0
    for block in blocks:
        _, first = np.unique(np.sort(block, axis=1), axis=0, return_index=True)
        first.sort()
        twins += len(block) - len(first)
        kept.append(block[first])
        places.append(origins[start : start + len(block)][first])
        start += len(block)
    if twins:
        _tell(
            name,
            twins,
            "has the same corners as another and is left out",
            "have the same corners as others and are left out",
        )
    return kept, np.concatenate(places)


def _sound(points, cells, where, name):
    """Faces that have an area and no corner twice; the others are told of."""
    ordered = np.sort(cells, axis=1)
    twice = (np.diff(ordered, axis=1) == 0).any(axis=1)
    if twice.any():
        _tell(
            name,
            int(twice.sum()),
            "touches itself in a point and is left out",
            "touch themselves in a point and are left out",
        )
    sides = points[cells] - points[np.roll(cells, 1, axis=1)]
    longest = np.linalg.norm(sides, axis=2).max(axis=1)
    if cells.shape[1] <= 4:
        area = np.linalg.norm(area_vectors(points, cells), axis=1)
    else:
        corners = points[cells] - points[cells[:, :1]]
        crosses = np.cross(corners, np.roll(corners, -1, axis=1))
        area = 0.5 * np.linalg.norm(crosses.sum(axis=1), axis=1)
    # written so that NaN, which is told elsewhere, counts as an area
    flat = (area <= _NO_AREA * longest**2) & ~twice
    if flat.any():
        _tell(
            name,
            int(flat.sum()),
            "has no area and is left out",
            "have no area and are left out",
        )
    return cells[~(flat | twice)], where[~(flat | twice)]


def _tell(
    name: str, count: int, one: str, many: str, category: type[Warning] = UserWarning
) -> None:
    """Warn of faces that are no cells as they stand: what one of them does, what many do."""
    said = f"1 face {one}" if count == 1 else f"{count} faces {many}"
    warnings.warn(f"{name}: {said}.", category, stacklevel=3)


def cut_polygon(corners: np.ndarray, quads: bool, name: str = "face") -> list[list[int]]:
    """Cut a flat or nearly flat polygon into convex quads (and a triangle), or into triangles.

    Parameters
    ----------
    corners : (k, 3), k > 4; may be concave.
    quads : whether quads are wanted.
    name : for messages.

    Returns
    -------
    Lists of 3 or 4 places among the corners, in the polygon's direction.

    Raises
    ------
    MeshError : for too many corners, or sides that cross.
    """
    if len(corners) > MOST_CORNERS:
        raise MeshError(
            f"{name.split(': face', 1)[0]}: a face has {len(corners)} corners, cut it into quads "
            "or triangles before saving (a lid over an opening is to be removed)."
        )
    normal = np.cross(corners, np.roll(corners, -1, axis=0)).sum(axis=0)
    first = np.eye(3)[np.argmin(np.abs(normal))]
    across = np.cross(normal, first)
    frame = np.stack([np.cross(across, normal), across], axis=1)
    flat = (corners - corners.mean(axis=0)) @ (frame / np.linalg.norm(frame, axis=0))
    if _crosses_itself(flat):
        raise MeshError(f"{name} crosses itself, mesh this place again.")
    rest, parts = list(range(len(corners))), []
    while len(rest) > (4 if quads else 3):
        # an odd number of corners needs one triangle, which is cut where it is best
        width = 4 if quads and len(rest) % 2 == 0 else 3
        best = max(_ears(flat, rest, width), default=None)
        if best is None and width == 4:
            best = max(_ears(flat, rest, 3), default=None)
        if best is None:
            raise MeshError(f"{name} crosses itself, mesh this place again.")
        start, size = best[1:]
        ear = [rest[(start + j) % len(rest)] for j in range(size)]
        parts.append(ear)
        rest = [corner for corner in rest if corner not in ear[1:-1]]
    if len(rest) == 4 and _quality(flat[rest]) <= _STRAIGHT:
        halves = [(rest[k:] + rest[:k])[:3] for k in range(2)]
        others = [(rest[k + 2 :] + rest[: k + 2])[:3] for k in range(2)]
        # the cut that leaves the better of the worse halves, so no sliver at a straight corner
        worse = [min(_quality(flat[a]), _quality(flat[b])) for a, b in zip(halves, others)]
        best_half = int(np.argmax(worse))
        if worse[best_half] <= 0.0:
            raise MeshError(f"{name} crosses itself, mesh this place again.")
        parts.append(halves[best_half])
        rest = others[best_half]
    return parts + [rest]


def _crosses_itself(flat: np.ndarray) -> bool:
    """Whether two sides of a polygon (k, 2) cross."""
    start, end = flat, np.roll(flat, -1, axis=0)

    def left(point):
        """Side (sides, points) of every side's line on which points (k, 2) lie."""
        along, away = (end - start)[:, None], point - start[:, None]
        return along[:, :, 0] * away[:, :, 1] - along[:, :, 1] * away[:, :, 0]

    apart = left(start) * left(end) < 0.0
    return bool((apart & apart.T).any())


def _ears(flat: np.ndarray, rest: list[int], width: int) -> Iterable[tuple[float, int, int]]:
    """Quality, place and width of the convex parts that a straight cut takes off a polygon."""
    for start in range(len(rest)):
        ear = [rest[(start + j) % len(rest)] for j in range(width)]
        quality = _quality(flat[ear])
        if quality <= (1e-6 if width == 3 else _STRAIGHT):
            continue
        others = flat[[corner for corner in rest if corner not in ear]]
        sides = np.roll(flat[ear], -1, axis=0) - flat[ear]
        away = others[:, None] - flat[ear]
        left = sides[:, 0] * away[:, :, 1] - sides[:, 1] * away[:, :, 0]
        if not (left >= 0.0).all(axis=1).any():
            yield quality, start, width


def _quality(corners: np.ndarray) -> float:
    """Smallest sine of the corner angles, negative where one is concave."""
    onward = np.roll(corners, -1, axis=0) - corners
    back = np.roll(corners, 1, axis=0) - corners
    cross = onward[:, 0] * back[:, 1] - onward[:, 1] * back[:, 0]
    size = np.linalg.norm(onward, axis=1) * np.linalg.norm(back, axis=1)
    return float((cross / np.maximum(size, 1e-300)).min())
