# SPDX-License-Identifier: LGPL-3.0-or-later
"""The garment of a scene: made by measures or read from a file, placed where the wearer stands."""

from inspect import signature

import numpy as np

import meshes
from shellform.fem.wrinkles import folds_resolved
from shellform.material.sheet import Sheet
from shellform.motion.stance import stance
from shellform.motion.wearer import Wearer

from .fit import check_fit, waist_height
from .parts import Garment
from .scene import Scene

HIP_HEIGHT = 0.918  # of the hip joints of the person whom patterns fit as they are [m]
NO_MEASURES = ("size", "cell_size")  # of the arguments of a pattern


def garment_of(scene: Scene, wearer: Wearer) -> meshes.Surface:
    """Surface of the garment, where the standing wearer has it on.

    Raises
    ------
    ValueError, meshes.MeshError for measures or a file that make no garment, or one that does not
    fit the wearer
    """
    pattern = pattern_of(scene.garment)
    height, middle, heading = stance(wearer)
    if scene.garment.file is not None:
        surface = meshes.load(scene.garment.file, unit=scene.garment.unit)
        surface = meshes.prepare_garment(surface, waist=scene.garment.waist)
    else:
        waist = waist_height(wearer) - middle[2] + height
        surface = made_by_measures(scene.garment, pattern, scene.cell_size, height, waist)
    cosine, sine = heading[:2]
    turn = np.array([[cosine, -sine, 0], [sine, cosine, 0], [0, 0, 1.0]])
    surface = surface.transform(turn, (*middle[:2], middle[2] - height))
    check_fit(surface, wearer)
    return surface


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

    ValueError where a garment is to be relaxed that is not made of 4-node quads.
    """
    quads = surface.cells.shape[1] == 4
    if garment.wrinkles == "auto":
        return "relaxed" if quads and not folds_resolved(surface, fabric) else "resolved"
    if garment.wrinkles == "relaxed" and not quads:
        raise ValueError(
            f"garment.wrinkles = 'relaxed' is for 4-node quads, {surface.source} has "
            f"{surface.kind}s: mesh it with quads, or say 'resolved'"
        )
    return garment.wrinkles


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
