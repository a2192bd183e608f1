# SPDX-License-Identifier: LGPL-3.0-or-later
"""What a shell refuses before anything is made: arguments of other kinds, forms that do not mix."""

import warnings

import numpy as np

from meshes import Surface
from meshes.geometry import widest_corners
from shellform.material.energy import StVenant
from shellform.material.sheet import Sheet

from .element import check_warp
from .wrinkles import KINDS


def check_arguments(
    surface: Surface, fabric: Sheet, membrane: str, curvature: str, wrinkles: str
) -> None:
    """ValueError for an unknown option or a missing warp, TypeError for another kind of thing."""
    for name, value, choices in (
        ("membrane", membrane, ("arcs", "chords")),
        ("curvature", curvature, ("turning", "plain")),
        ("wrinkles", wrinkles, KINDS),
    ):
        if value not in choices:
            raise ValueError(f"{name} is one of {', '.join(choices)}, not '{value}'")
    for given, kind, name in (
        (surface, Surface, "a meshes.Surface"),
        (fabric, Sheet, "a Fabric"),
    ):
        if not isinstance(given, kind):
            raise TypeError(f"Shell takes {name} here, not {type(given).__name__}: {given!r}")
    if fabric.directional:
        check_warp(surface, fabric)


def check_coupling(law: StVenant, fabric: Sheet, thick: bool) -> None:
    """ValueError for a law of the whole thickness with what is integrated through it as well."""
    if law.couples and (thick or np.any(fabric.coupling)):
        raise ValueError(
            f"{law!r} integrates its own energy through the thickness: it goes without "
            "`thick` and with a fabric whose bending is not coupled with stretching"
        )


def check_friction(surface: Surface, fabric: Sheet, in_default_form: bool) -> None:
    """ValueError for friction inside the cloth in a form that has no sliders."""
    if fabric.friction is not None and (surface.degree == 2 or not in_default_form):
        raise ValueError(
            "friction inside the cloth goes with triangles and 4-node quads in their default "
            "form, membrane='arcs', curvature='turning' and without `thick`; or take a fabric "
            "without friction"
        )


def check_stiffer(
    stiffer: np.ndarray, surface: Surface, fabric: Sheet, law: StVenant, in_default_form: bool
) -> None:
    """ValueError for factors of the cells' bending stiffness that are none, or have no form."""
    if stiffer.shape != (len(surface.cells),) or not (np.isfinite(stiffer) & (stiffer > 0)).all():
        raise ValueError(
            f"stiffer has the shape {stiffer.shape} with numbers from {stiffer.min():g}: give one "
            f"number above 0 for each of the {len(surface.cells)} cells of {surface.source}"
        )
    bends = law.is_quadratic("bending") and fabric.friction is None
    if not bends or surface.degree == 2 or not in_default_form:
        raise ValueError(
            "cells that are stiffer than the others are of cloth that bends linearly and without "
            "friction, in triangles or 4-node quads in their default form: take another fabric or "
            "law, or leave the factors out"
        )


def check_relaxed(
    surface: Surface, fabric: Sheet, law: StVenant, membrane: str, thick: bool
) -> None:
    """ValueError if a sheet cannot be relaxed, naming what stands in the way."""
    if surface.cells.shape[1] != 4:
        raise ValueError(
            f"wrinkles='relaxed' is for 4-node quads, {surface.source} has {surface.kind}s of "
            f"{surface.cells.shape[1]} nodes: mesh it with quads, or take wrinkles='resolved'"
        )
    if membrane != "arcs" or thick or np.any(fabric.coupling):
        raise ValueError(
            "wrinkles='relaxed' goes with membrane='arcs', without `thick` and with a fabric whose "
            "bending is not coupled with stretching: take wrinkles='resolved'"
        )
    if not law.is_quadratic("membrane"):
        raise ValueError(
            f"wrinkles='relaxed' knows the quadratic membrane energy only, not that of {law!r}: "
            "take wrinkles='resolved'"
        )


def warn_of_corners(surface: Surface, stacklevel: int) -> None:
    """Warn of four-node quads that lean too much to bend as they should.

    Rolled up into a circle, strips of quads with corners of 120, 150 and 170 degrees have their tip
    wrong by 0.03, 2 and 50 % of the length (`demos/studies/extremes/sheets.py`).
    """
    widest = widest_corners(surface.points, surface.cells)
    worst, count = int(widest.argmax()), int((widest > 150.0).sum())
    if count:
        warnings.warn(
            f"cell {worst} of {surface.source} has a corner of {widest[worst]:.0f} degrees (more "
            f"than 150 in {count} cells): quads that lean so much are too stiff in bending, cut "
            "them into triangles or mesh this place again",
            stacklevel=stacklevel + 1,
        )
