# SPDX-License-Identifier: LGPL-3.0-or-later
"""The garment of a scene: made by measures or read from a file, placed where the wearer stands."""

import warnings
from inspect import signature
from pathlib import Path

import numpy as np

import meshes
from meshes.garments.ring import names_of
from meshes.validity import with_hint
from shellform.fem.wrinkles import folds_resolved
from shellform.material.sheet import Sheet
from shellform.motion.recording import SIDES
from shellform.motion.stance import stance
from shellform.motion.wearer import Wearer

from .fit import check_fit, waist_height
from .parts import Garment
from .scene import Scene
from .shoulders import hangs_on_shoulders, is_pattern
from .wearer import dressing_wearer

HIP_HEIGHT = 0.918  # of the hip joints of the person whom patterns fit as they are [m]
ASIDE, HIGHER = 0.05, 0.08  # a garment off its wearer's waist by more is moved there [m]
HEM = 0.06  # height of the hems of trousers over the floor, at least [m]
NO_MEASURES = ("size", "cell_size")  # of the arguments of a pattern


def garment_of(scene: Scene, wearer: Wearer) -> meshes.Surface:
    """Surface of the garment, where the standing wearer has it on.

    Raises
    ------
    ValueError, meshes.MeshError for measures or a file that make no garment, or one that does not
    fit the wearer
    """
    garment = scene.garment
    height, middle, heading = stance(wearer)
    waist = waist_height(wearer) - middle[2] + height
    if hangs_on_shoulders(garment):
        # only here: the shirts' room is no other garment's
        from .shirt import shirt_of

        return shirt_of(garment, dressing_wearer(scene, wearer), scene.cell_size)
    if is_pattern(garment):
        # only here: other garments are not sewn
        from .pattern import sewn_garment

        surface = hung(sewn_garment(garment, wearer, scene.cell_size, waist), garment, waist)
    elif garment.stitches or garment.about:
        raise ValueError(
            "garment.stitches and garment.about are of sewing patterns, and "
            f"{'there is no file' if garment.file is None else garment.file}: leave them out, or "
            "name a file that ends in .json, .dxf or .svg"
        )
    elif garment.file is not None:
        pattern_of(garment)
        surface = from_file(garment, garment.file, waist)
    else:
        pattern = pattern_of(garment)
        surface = made_by_measures(garment, pattern, scene.cell_size, height, waist)
    cosine, sine = heading[:2]
    turn = np.array([[cosine, -sine, 0], [sine, cosine, 0], [0, 0, 1.0]])
    surface = surface.transform(turn, (*middle[:2], middle[2] - height))
    try:
        check_fit(surface, wearer)
    except ValueError as error:
        raise with_hint(error, surface.notes) from None
    return surface


def from_file(garment: Garment, file: str | Path, waist_height: float) -> meshes.Surface:
    """The garment of a file, upright over the floor, its waist as high as the wearer's [m].

    It is turned and moved as the scene says, or, where it says nothing, as its shape tells; what
    was found is in the surface's `notes`.
    """
    with warnings.catch_warnings():
        # they are among the notes, which `check` and `run` print
        warnings.simplefilter("ignore")
        surface = meshes.load(file, garment.unit, weld=garment.weld, midsurface=garment.midsurface)
    return hung(surface, garment, waist_height)


def hung(surface: meshes.Surface, garment: Garment, waist_height: float) -> meshes.Surface:
    """A garment as `from_file` returns it, upright, its waist at a height [m] over the floor."""
    try:
        surface, found = _standing(surface, garment)
    except meshes.MeshError as error:
        # notes of points not joined say why openings are not those of a garment
        raise with_hint(error, surface.notes) from None
    if garment.place is not None:
        surface = surface.transform(translation=garment.place)
    elif garment.turn is None:
        middle = surface.points[np.unique(surface.edges["waist"])].mean(axis=0)
        shift = np.array([-middle[0], -middle[1], waist_height - middle[2]])
        shift[:2] *= np.hypot(*shift[:2]) > ASIDE
        shift[2] *= abs(shift[2]) > HIGHER
        # legs on the feet would be caught there and torn: the waist has some play
        hems = [surface.edges[f"{side}_hem"] for side in SIDES if f"{side}_hem" in surface.edges]
        if hems:
            lowest = surface.points[np.concatenate(hems)[:, :2], 2].min() + shift[2]
            lifted = shift[2] + HEM - lowest
            if lowest < HEM - 0.01 and middle[2] + lifted - waist_height <= HIGHER:
                shift[2] = lifted
        if shift.any():
            surface = surface.transform(translation=shift)
            found.append(f"moved by {np.round(shift, 3).tolist()} m to the wearer's waist")
    if not found:
        return surface
    said = "; ".join(found)
    note = f"{surface.source}: {said} (otherwise by turn_deg, place_m, waist under [garment])."
    return surface.replace(notes=(*surface.notes, note))


def _standing(surface: meshes.Surface, garment: Garment) -> tuple[meshes.Surface, list[str]]:
    """The garment upright, with its waist and hems, and what was found of its shape, in words."""
    waist = garment.waist
    found: list[str] = []
    if garment.turn is not None:
        x, y, z = (rotation_about(axis, a) for axis, a in enumerate(garment.turn))
        surface = surface.transform(rotation=z @ y @ x)
    else:
        loop = waist_loop(surface, waist)
        if loop is not None:
            turn, found = meshes.upright(surface, loop)
            surface = surface.transform(rotation=turn)
    if waist == "waist" and waist not in surface.edges:
        loop = meshes.waist_by_shape(surface)
        girth = np.linalg.norm(
            surface.points[loop] - surface.points[np.roll(loop, 1)], axis=1
        ).sum()
        found.append(f"the opening of {girth:.2f} m is the waist")
        surface = surface.with_edges(waist=np.stack([loop, np.roll(loop, -1)], axis=1))
        waist = "waist"
    return meshes.prepare_garment(surface, waist=waist), found


def waist_loop(surface: meshes.Surface, waist: str) -> np.ndarray | None:
    """Points (k,) of the loop called `waist`, or of the one that is the waist by its shape.

    None where that does not tell, but the highest is asked for.
    """
    if waist in surface.edges:
        return surface.edges[waist][:, 0]
    if waist == "highest":
        try:
            return meshes.waist_by_shape(surface)
        except meshes.MeshError:
            return None
    if waist != "waist":
        known = names_of(surface.edges)
        raise ValueError(
            f"{surface.source}: there is no edge '{waist}' (edges: {known}), name the waist of the "
            "garment, give waist='highest', or leave garment.waist out"
        )
    return meshes.waist_by_shape(surface)


def rotation_about(axis: int, degrees: float) -> np.ndarray:
    """Rotation (3, 3) about a coordinate axis."""
    out = np.eye(3)
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    i, j = (axis + 1) % 3, (axis + 2) % 3
    out[[i, i, j, j], [i, j, i, j]] = c, -s, s, c
    return out


def pattern_of(garment: Garment) -> meshes.Pattern:
    """Pattern of a garment's kind; ValueError for a kind, a size or a measure that is not there."""
    kind, pattern = garment.kind, meshes.GARMENTS.get(garment.kind)
    if pattern is None:
        raise ValueError(
            f"garment.kind: no garment is called {kind!r}; there are {', '.join(meshes.GARMENTS)}"
        )
    if garment.size is not None and not pattern.sizes:
        raise ValueError(
            f"garment.size = {garment.size!r}, and a {kind} has no sizes: give its measures"
        )
    known = [name for name in signature(pattern.build).parameters if name not in NO_MEASURES]
    for name in garment.measures:
        if name not in known:
            raise ValueError(
                f"garment.measures: no '{name}' of {kind}; there are {', '.join(known)}"
            )
    return pattern


def wrinkles_of(garment: Garment, surface: meshes.Surface, fabric: Sheet) -> str:
    """'relaxed' or 'resolved': as the scene says, or by whether cells show the folds of the cloth.

    Only the quadratic membrane relaxes: a law that has another keeps cells resolved.

    ValueError where a garment is to be relaxed that is not made of 4-node quads.
    """
    quads = surface.cells.shape[1] == 4
    if garment.wrinkles == "auto":
        relaxes = quads and (fabric.law is None or fabric.law.is_quadratic("membrane"))
        return "relaxed" if relaxes and not folds_resolved(surface, fabric) else "resolved"
    if garment.wrinkles == "relaxed" and not quads:
        raise ValueError(
            f"garment.wrinkles = 'relaxed' is for 4-node quads, {surface.source} has "
            f"{surface.kind}s: mesh it with quads, or say 'resolved'"
        )
    return garment.wrinkles


def stiffer_at_seams(garment: Garment, surface: meshes.Surface) -> np.ndarray | None:
    """Bending stiffness (m,) of the cells over that of the cloth; None where it is the same.

    ValueError for a garment without seams that are known
    """
    if garment.seam_bending == 1.0:
        return None
    seams = [line for name, line in surface.edges.items() if name.startswith("seam_")]
    if not seams:
        raise ValueError(
            f"garment.seam_bending = {garment.seam_bending:g} is of sewing patterns, and "
            f"{surface.source} has no seams that are known: leave it out"
        )
    n = len(surface.points)
    sewn = np.sort(np.concatenate(seams)[:, :2], axis=1) @ [n, 1]
    corners = surface.cells[:, : 3 if surface.kind == "triangle" else 4]
    sides = np.sort(np.stack([corners, np.roll(corners, -1, axis=1)], axis=2), axis=2) @ [n, 1]
    return np.where(np.isin(sides, sewn).any(axis=1), garment.seam_bending, 1.0)


def made_by_measures(
    garment: Garment,
    pattern: meshes.Pattern,
    cell_size: float,
    hips: float,
    waist: float,
) -> meshes.Surface:
    """Surface of a garment by its size, or grown to the wearer's heights.

    Parameters
    ----------
    cell_size : [m]
    hips, waist : heights of the wearer's hip joints and waist over the floor [m]

    Raises
    ------
    ValueError for a size that is not there, or measures that make no garment
    """
    if garment.size is not None:
        return pattern.build(garment.size, **garment.measures, cell_size=cell_size)
    scale = hips / HIP_HEIGHT
    lengths = {name: scale * value for name, value in pattern.lengths.items()}
    lengths["waist_height"] = waist
    measures = {**pattern.girths, **lengths, **garment.measures}
    return pattern.build(**measures, cell_size=cell_size)
