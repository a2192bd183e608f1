# SPDX-License-Identifier: LGPL-3.0-or-later
"""A sewing pattern from a file: GarmentCode JSON, DXF of AAMA or ASTM, SVG; stitches given beside.

A stitch beside the file names edges as 'PANEL.EDGE', several along a seam with '+' between.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from meshes.validity import MeshError

from .check_pattern import check_side
from .pattern import SewingPattern, Side, Stitch

UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254}
FORMATS = (".json", ".dxf", ".svg")


def read_pattern(
    path: str | Path,
    size: str | None = None,
    unit: str | None = None,
    stitches: Sequence[Sequence[str]] = (),
    about: Mapping[str, str] | None = None,
) -> SewingPattern:
    """The pattern in a file.

    Parameters
    ----------
    path : ending in .json, .dxf or .svg
    size : of a nest of graded sizes, None where the file has one
    unit : 'm', 'cm', 'mm' or 'in', where the file names none
    stitches : further ones, ['front.side', 'back.side'], or with 'along' as a third text where
        both edges run the same way; ['band.low', 'front.waist + back.waist']
    about : panel -> segment of the body it goes around, for panels the file does not place

    Raises
    ------
    MeshError : in one sentence for what is wrong with the file or does not belong to it;
        ImportError where .dxf or .svg needs a package that is not there
    """
    path = Path(path)
    kind = path.suffix.lower()
    if kind not in FORMATS:
        raise MeshError(
            f"{path.name}: no pattern ends in '{path.suffix}', give one of {', '.join(FORMATS)}."
        )
    if unit is not None and unit not in UNITS:
        raise MeshError(
            f"{path.name}: the unit {unit!r} is none of {', '.join(UNITS)}: give one of these."
        )
    if not path.is_file():
        raise MeshError(
            f"{path.name}: there is no such file in {path.parent}, check the name and the folder."
        )
    pattern = _readers(kind)(path, size, unit)
    if about:
        for name in about:
            if name not in {panel.name for panel in pattern.panels}:
                raise MeshError(
                    f"{path.name}: garment.about names panel '{name}', which is not there: there "
                    f"are {', '.join(panel.name for panel in pattern.panels)}."
                )
        panels = tuple(replace(p, about=about.get(p.name, p.about)) for p in pattern.panels)
        pattern = replace(pattern, panels=panels)
    more = tuple(_stitch(pattern, k, given) for k, given in enumerate(stitches))
    return replace(pattern, stitches=pattern.stitches + more)


def _readers(kind):
    # only here: each needs a package of its own, and a garment is of one kind
    if kind == ".dxf":
        from .dxf_file import read_dxf

        return read_dxf
    if kind == ".svg":
        from .svg_file import read_svg

        return read_svg
    from .garmentcode import read_garmentcode

    return lambda path, size, unit: read_garmentcode(path, size)


def _stitch(pattern, number, given):
    where = f"garment.stitches[{number}]"
    texts = list(given) if isinstance(given, list | tuple) else []
    if len(texts) not in (2, 3) or not all(isinstance(text, str) for text in texts):
        raise MeshError(
            f"{pattern.source}: {where} is {given!r}: give two edges, as "
            '["front.side", "back.side"].'
        )
    if len(texts) == 3 and texts[2] != "along":
        raise MeshError(
            f"{pattern.source}: {where} has a third text {texts[2]!r}: 'along' is the only one, "
            "for edges that run the same way."
        )
    sides = [tuple(_side(pattern, part, where) for part in text.split("+")) for text in texts[:2]]
    return Stitch(sides[0], sides[1], True if len(texts) == 3 else None)


def _side(pattern, text, where) -> Side:
    """Panel and edge of 'PANEL.EDGE'; names of panels may hold dots."""
    text = text.strip()
    for panel in pattern.panels:
        if text.startswith(f"{panel.name}."):
            side = panel.name, text[len(panel.name) + 1 :]
            check_side(pattern, side, where)
            return side
    known = ", ".join(panel.name for panel in pattern.panels)
    raise MeshError(
        f"{pattern.source}: {where} names '{text}', and there is no such panel: write PANEL.EDGE, "
        f"with a panel of {known}."
    )
