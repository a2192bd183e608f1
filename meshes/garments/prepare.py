"""A garment from anywhere made ready for dressing: waist, hems, outside, warp and size.

A mesh out of a drawing program has none of the names a body is dressed by. What can be read off its
shape is filled in here; what is ambiguous is asked for in one sentence. z is up.
"""
# SPDX-License-Identifier: LGPL-3.0-or-later

from __future__ import annotations

import numpy as np

from meshes.files.load import UNITS
from meshes.geometry import area_vectors, cell_centres
from meshes.repair import TURNED, boundary_loops, turned_flat
from meshes.sheets import components, main_sheet
from meshes.surface import Locator, Surface
from meshes.topology import corner_count, directed_edges, segments_of_line, unique_edges
from meshes.validity import MeshError

from .ring import names_of, polygon_length

_WAISTS = (0.3, 3.0)  # m; girths that somebody wears
_USUAL_WAIST = 0.9


def prepare_garment(surface: Surface, waist: str | Locator | None = None) -> Surface:
    """The garment with a named waist and hems, facing outward, with a warp direction.

    Parameters
    ----------
    surface : Surface, also one built with ``verify=False``, which is checked here; z up, in m.
    waist : None for the edge 'waist', the name of another edge, 'highest' for the highest boundary
        loop, or a locator: a function of the points (n, 3), True (n,) for points of the loop.

    Returns
    -------
    Surface. The edge 'waist' is the whole loop, the other loops keep a name they have or become
    'hem', or 'left_hem' (y above the waist's) and 'right_hem'; several of a name are numbered
    upwards from the lowest, 'left_hem_2' ... Names of the kind 'boundary_0' are dropped. A garment
    without warp gets -z, laid into each cell.

    Raises
    ------
    MeshError : for a faulty mesh (see `check`), several pieces, no waist or more than one, a waist
        below the hems, and a waist whose girth nobody wears, which is mostly a slip of unit.
    """
    surface, loops = outward(surface, "at the waist")
    source = surface.source
    place = _waist_place(surface, loops, waist)
    middles = np.array([surface.points[loop].mean(axis=0) for loop in loops])
    _check_size(surface, loops[place])
    lower = np.delete(np.arange(len(loops)), place)
    if lower.size and not (middles[lower, 2] < middles[place, 2]).all():
        worst = lower[np.argmax(middles[lower, 2])]
        raise MeshError(
            f"{source}: the waist lies at z = {middles[place, 2]:.3g} m, not above the edge at "
            f"{middles[worst, 2]:.3g} m; turn the garment upright, as from y up to z up with "
            "surface.transform(rotation=[[1, 0, 0], [0, 0, -1], [0, 1, 0]])."
        )
    warp = surface.warp
    if warp is None:
        warp = _downward(surface, middles[place])
    return surface.replace(edges=_names(surface, loops, place, middles), warp=warp)


def outward(surface: Surface, where: str) -> tuple[Surface, list[np.ndarray]]:
    """The checked garment, facing outward, and its boundary loops.

    where : it has to be open, in words. MeshError for a faulty mesh, several pieces, a closed one
    """
    surface = surface.replace(verify=True)
    source = surface.source
    piece = pieces(surface.cells)
    if piece.max() > 0:
        raise MeshError(
            f"{source}: the garment is in {piece.max() + 1} pieces (cells 0 and "
            f"{int(np.argmax(piece > 0))} are not joined), join them with "
            "meshes.merge_duplicates or weld_m under [garment], or dress them one by one."
        )
    loops = boundary_loops(surface)
    if not loops:
        raise MeshError(f"{source}: the mesh is closed, open it {where} to put it on.")
    if _enclosed_volume(surface, loops) < 0.0:
        assert surface.directors is not None  # what has passed the check has them
        turned = surface.cells[:, TURNED[surface.cells.shape[1]]]
        flat = surface.flat
        if flat is not None:
            flat = turned_flat(flat, np.ones(len(turned), bool))
        surface = surface.replace(cells=turned, directors=-surface.directors, flat=flat)
        loops = boundary_loops(surface)
    return surface, loops


def regions(surface: Surface) -> dict[str, np.ndarray]:
    """Points of the legs and of the torso, so that each may be kept to its part of the body.

    Parameters
    ----------
    surface : Surface with the edges 'left_hem' and 'right_hem', standing, z up.

    Returns
    -------
    {'right_leg', 'left_leg', 'torso'} : point indices, each point in one of them. The legs are all
    below the fork, the lowest place where the garment crosses the plane between the hems.

    Raises
    ------
    MeshError : without these edges, or if the legs cross that plane down to the hems.
    """
    points, source = surface.points, surface.source
    missing = [name for name in ("left_hem", "right_hem") if name not in surface.edges]
    if missing:
        raise MeshError(
            f"{source}: a garment with legs needs the edge '{missing[0]}', name it with with_edges "
            "or meshes.prepare_garment."
        )
    hems = [points[np.unique(surface.edges[f"{side}_hem"])] for side in ("left", "right")]
    left, right = (hem.mean(axis=0) for hem in hems)
    aside = (points - 0.5 * (left + right))[:, :2] @ (left - right)[:2]
    ends = directed_edges(surface.cells)[:, :2]
    one, other = aside[ends].T
    ends = ends[one * other <= 0.0]
    one, other = np.abs(aside[ends].T)
    part = np.divide(one, one + other, out=np.zeros_like(one), where=one + other > 0.0)
    heights = points[ends, 2]
    crossing = (1.0 - part) * heights[:, 0] + part * heights[:, 1]
    top = max(hem[:, 2].max() for hem in hems)
    if crossing.size == 0 or crossing.min() <= top:
        raise MeshError(
            f"{source}: the legs cannot be told apart above the hems, they cross the plane between "
            "them; pull the legs apart."
        )
    below = points[:, 2] < crossing.min() - 1e-9
    return {
        "right_leg": np.flatnonzero(below & (aside < 0.0)),
        "left_leg": np.flatnonzero(below & (aside >= 0.0)),
        "torso": np.flatnonzero(~below),
    }


def pieces(cells: np.ndarray) -> np.ndarray:
    """Number of the connected piece of each cell (m,), the first cell's being 0."""
    edges = directed_edges(cells)
    _, number, _ = unique_edges(edges, int(cells.max()) + 1)
    order = np.argsort(number, kind="stable")
    same = number[order[1:]] == number[order[:-1]]
    pairs = np.stack([order[:-1], order[1:]], axis=1)[same] // corner_count(cells)
    piece = components(pairs, len(cells))
    # numbered in the order of their first cells
    _, first, inverse = np.unique(piece, return_index=True, return_inverse=True)
    return np.argsort(np.argsort(first))[inverse]


def _waist_place(surface, loops, waist):
    """Place of the waist among the boundary loops."""
    points, edges, source = surface.points, surface.edges, surface.source
    known = names_of(edges)
    if waist == "highest" and "highest" not in edges:
        heights = np.array([points[loop, 2].mean() for loop in loops])
        near = np.flatnonzero(heights >= heights.max() - 0.05 * np.ptp(points[:, 2]))
        if len(near) > 1:
            one, other = (np.round(points[loops[i]].mean(axis=0), 3).tolist() for i in near[:2])
            raise MeshError(
                f"{source}: {len(near)} boundary loops are equally high, about {one} and {other} "
                "m; give the waist by name or locator (or turn the garment upright: z is up)."
            )
        return int(near[0])
    if callable(waist):
        chosen = np.unique(surface.with_edges(waist=waist).edges["waist"])
        hit = [i for i, loop in enumerate(loops) if np.isin(loop, chosen).any()]
        if len(hit) > 1:
            raise MeshError(
                f"{source}: the locator of the waist selects points of {len(hit)} boundary loops, "
                "narrow it to one."
            )
        return hit[0]
    name = "waist" if waist is None else waist
    if name not in edges:
        raise MeshError(
            f"{source}: there is no edge '{name}' (edges: {known}), name the waist of the garment "
            "or give waist='highest', the name of an edge or a locator."
        )
    chosen = np.unique(edges[name])
    for place, loop in enumerate(loops):
        if np.array_equal(np.sort(loop), chosen):
            return place
    counts = [str(len(loop)) for loop in loops[:6]] + ["..."] * (len(loops) > 6)
    raise MeshError(
        f"{source}: the edge '{name}' ({len(chosen)} points) is not one closed boundary loop (they "
        f"have {', '.join(counts)} points), name the whole loop or give waist='highest'."
    )


def _check_size(surface, loop):
    girth = polygon_length(surface.points[np.append(loop, loop[0])])
    if _WAISTS[0] <= girth <= _WAISTS[1]:
        return
    pairs = [(true, read) for true in UNITS for read in UNITS if true != read]
    meant = np.array([girth * UNITS[true] / UNITS[read] for true, read in pairs])
    # Of two explanations the one with metres on one side, then the one with the usual girth.
    rank = np.abs(np.log(meant / _USUAL_WAIST)) + [3.0 * ("m" not in pair) for pair in pairs]
    best = int(np.argmin(rank))
    mend = "scale it with surface.transform(scale=...)"
    if _WAISTS[0] <= meant[best] <= _WAISTS[1]:
        true, read = pairs[best]
        mend = (
            f"its coordinates look like {true} taken for {read}, which would be {meant[best]:.2f} "
            f"m: give load(path, unit='{true}'), in a scene unit = \"{true}\" under [garment]"
        )
    raise MeshError(
        f"{surface.source}: the waist measures {girth:.3g} m round, which nobody wears; {mend}."
    )


def _enclosed_volume(surface, loops):
    """Volume inside the garment in m^3, its openings closed by cones; negative if inside out."""
    points = surface.points - surface.points.mean(axis=0)
    cells = surface.cells[main_sheet(surface.points, surface.cells)]
    corners = cells[:, : corner_count(cells)]
    faces = [corners[:, [0, k, k + 1]] for k in range(1, corners.shape[1] - 1)]
    volume = np.linalg.det(points[np.concatenate(faces)]).sum()
    for loop in loops:
        line = points[loop]
        tip = np.broadcast_to(line.mean(axis=0), line.shape)
        # The surface lies on the left of the loop, so its lid is passed the other way.
        volume += np.linalg.det(np.stack([tip, np.roll(line, -1, axis=0), line], axis=1)).sum()
    return volume / 6.0


def _downward(surface, waist):
    """-z laid into each cell (m, 3); in level cells, the direction away from the waist's middle."""
    normals = area_vectors(surface.points, surface.cells)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)

    def laid(vectors):
        vectors = vectors - np.einsum("mi,mi->m", vectors, normals)[:, None] * normals
        return vectors, np.linalg.norm(vectors, axis=1, keepdims=True)

    down, length = laid(np.broadcast_to([0.0, 0.0, -1.0], normals.shape))
    away, reach = laid(cell_centres(surface.points, surface.cells) - waist)
    # A cell below the waist's middle and level has neither; any direction in it will do.
    anyhow, rest = laid(np.roll(normals, 1, axis=1) + [1e-3, 0.0, 0.0])
    level = np.where(reach > 1e-6, away / np.maximum(reach, 1e-6), anyhow / np.maximum(rest, 1e-6))
    return np.where(length > 0.05, down / np.maximum(length, 0.05), level)


def _names(surface, loops, place, middles):
    """Edges by name: those of the surface, then the waist, then the loops without a name."""
    edges = {k: v for k, v in surface.edges.items() if not k.startswith("boundary_")}
    breadth = np.ptp(surface.points[:, 1])
    for number in np.argsort(middles[:, 2], kind="stable"):
        loop = loops[number]
        line = segments_of_line(np.append(loop, loop[0]), surface.degree)
        if number == place:
            edges["waist"] = line
            continue
        points = np.unique(line)
        if any(np.array_equal(np.unique(edge), points) for edge in edges.values()):
            continue
        aside = middles[number, 1] - middles[place, 1]
        name = "hem"
        if abs(aside) > 0.1 * breadth:
            name = "left_hem" if aside > 0.0 else "right_hem"
        same = sum(known == name or known.startswith(f"{name}_") for known in edges)
        edges[f"{name}_{same + 1}" if same else name] = line
    return edges
