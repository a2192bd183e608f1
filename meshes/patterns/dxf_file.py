# SPDX-License-Identifier: LGPL-3.0-or-later
"""A DXF file of AAMA (ANSI/AAMA-292) or ASTM D6673 as a SewingPattern, read by ezdxf.

Each piece is a block; what lines mean stands in their layer (ASTM D6673-10, table 1):

    1 boundary   2 turn points   4 notches   6 mirror line   7 grain line   8 internal lines
    13 drill holes   14 sew line, inside of the boundary by the seam allowance   84 boundary, ASTM

Texts of a block say 'Piece Name: FRONT', 'Size: M', 'Quantity: 1,1' (as drawn, mirrored); those
of the file 'Units: METRIC' (mm) or 'ENGLISH' (in) and 'Sample Size: M'. Sewing is not in the
format: stitches are given beside. Where a sew line closes, it is the edge of the panel.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from meshes.validity import MeshError

from .drawn import counter_clockwise, edges_of_line, unfolded
from .pattern import Panel, SewingPattern

HOW = "a pattern in DXF is read by the package ezdxf: pip install ezdxf, or shellform[patterns]"
INSUNITS = {1: 0.0254, 4: 1e-3, 5: 1e-2, 6: 1.0}  # of the header: in, mm, cm, m
TEXT_UNITS = {"METRIC": 1e-3, "MM": 1e-3, "CM": 1e-2, "ENGLISH": 0.0254, "INCH": 0.0254}
UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254}
BOUNDARY, SEW_LINE = ("1", "84"), "14"


def read_dxf(path: Path, size: str | None = None, unit: str | None = None) -> SewingPattern:
    """Pattern of a DXF file; arguments and errors as `read_pattern`."""
    try:
        # only here: an option
        import ezdxf
    except ImportError:
        raise ImportError(HOW) from None
    name = path.name
    try:
        drawing = ezdxf.readfile(str(path))
    except (ezdxf.DXFError, OSError, ValueError) as error:
        raise MeshError(f"{name}: not a DXF file ({error}), export the pattern again.") from None
    blocks: list = [b for b in drawing.blocks if not b.name.startswith("*")]
    if not any(_lines(block, BOUNDARY) for block in blocks):
        blocks = [drawing.modelspace()]
    texts = _texts(drawing.modelspace())
    for block in blocks:
        for key, value in _texts(block).items():
            texts.setdefault(key, value)
    scale = _scale(texts, drawing, unit, name)
    pieces: dict[str, list[tuple[str, Panel, bool]]] = {}
    for block in blocks:
        if _lines(block, BOUNDARY) or _lines(block, (SEW_LINE,)):
            own = _texts(block)
            piece, pair = _piece(block, own, scale, name)
            pieces.setdefault(own.get("SIZE", ""), []).append((piece.name, piece, pair))
    if not pieces:
        raise MeshError(
            f"{name}: no block has a boundary on layer 1: export the pattern as AAMA or ASTM."
        )
    if size is not None and size not in pieces:
        _check_rules([*blocks, drawing.modelspace()], texts, size, name)
    chosen = _of_size(pieces, size, texts.get("SAMPLE SIZE"), name)
    panels = []
    for _, piece, pair in chosen:
        panels.append(piece)
        if pair:
            panels.append(piece.mirrored(f"{piece.name}_mirrored"))
    return SewingPattern(name, tuple(panels))


def _check_rules(blocks, texts, size, name):
    """MeshError where a size that is not drawn would come of grade rules, numbered '# 12'."""
    numbers = (
        entity.dxf.text
        for block in blocks
        for entity in block.query("TEXT")
        if re.fullmatch(r"\s*#\s*\d+\s*", entity.dxf.text)
    )
    table = texts.get("GRADE RULE TABLE")
    if table is None and next(numbers, None) is None:
        return
    sample = texts.get("SAMPLE SIZE")
    raise MeshError(
        f"{name}: size {size!r} (size under [garment]) is not drawn but graded by rules"
        f"{f' of the table {table}' if table else ''}, and rules are not applied here: export the "
        "pattern as a nest, with every size drawn, or leave size out for the sample size"
        f"{f' {sample}' if sample else ''}."
    )


def _of_size(pieces, size, sample, name):
    """Pieces of a size; those without a size belong to all."""
    common = pieces.pop("", [])
    known = ", ".join(pieces)
    if size is not None and size not in pieces:
        there = f"there are {known}" if known else "its pieces have none: leave it out"
        raise MeshError(f"{name}: there is no size {size!r} (size under [garment]); {there}.")
    if size is None and len(pieces) > 1:
        if sample not in pieces:
            raise MeshError(
                f"{name}: the pattern is graded in {known}: give one as size under [garment]."
            )
        size = sample
    if size is None and pieces:
        size = next(iter(pieces))
    return common + (pieces[size] if size is not None else [])


def _scale(texts, drawing, unit, name):
    said = texts.get("UNITS", "").upper()
    if said:
        if said not in TEXT_UNITS:
            raise MeshError(
                f"{name}: its text says 'Units: {said}', which is no unit that is known: METRIC "
                "is mm, ENGLISH is in."
            )
        return TEXT_UNITS[said]
    if unit is not None:
        return UNITS[unit]
    code = int(drawing.header.get("$INSUNITS", 0))
    if code not in INSUNITS:
        raise MeshError(
            f"{name}: it names no unit that is known ($INSUNITS = {code}, no text 'Units: "
            'METRIC\'): give unit under [garment], as unit = "mm".'
        )
    return INSUNITS[code]


def _piece(block, texts, scale, source):
    """Panel of a block, and whether there is a mirrored one."""
    name = texts.get("PIECE NAME", block.name).strip().replace(" ", "_")
    where = f"{source}: panel '{name}'"
    sewn = [line for line in _lines(block, (SEW_LINE,)) if len(line) > 3]
    outline = max(
        sewn or _lines(block, BOUNDARY), key=lambda line: float(np.ptp(line, axis=0).sum())
    )
    corners = scale * _points(block, "2")
    edges = edges_of_line(scale * outline, corners if not sewn else None, where)
    grain = _lines(block, ("7",))
    way = (0.0, 1.0)
    if grain:
        x, y = grain[0][-1] - grain[0][0]
        way = (float(x), float(y))
    notches = [scale * _points(block, "4"), *(scale * line[:1] for line in _lines(block, ("4",)))]
    inside = tuple(scale * line for line in _lines(block, ("8",)))
    panel = Panel(name, tuple(edges), way, np.concatenate(notches), inside)
    panel = counter_clockwise(panel)
    folds = _lines(block, ("6",))
    if folds:
        panel = counter_clockwise(unfolded(panel, scale * folds[0][[0, -1]], where))
    pair = re.fullmatch(r"\s*\d+\s*,\s*[1-9]\d*\s*", texts.get("QUANTITY", "")) is not None
    return panel, pair


def _texts(block):
    """Texts 'KEY: VALUE' of a block, keys in capitals."""
    found = {}
    for entity in block.query("TEXT MTEXT"):
        text = entity.dxf.text if entity.dxftype() == "TEXT" else entity.plain_text()
        key, colon, value = text.partition(":")
        if colon:
            found.setdefault(key.strip().upper(), value.strip())
    return found


def _lines(block, layers):
    """Polylines (k, 2) of a block in layers, in the file's unit; closed ones end as they begin."""
    found = []
    for entity in block.query("POLYLINE LWPOLYLINE LINE"):
        if entity.dxf.layer not in layers:
            continue
        kind = entity.dxftype()
        if kind == "LINE":
            line = [entity.dxf.start, entity.dxf.end]
        elif kind == "LWPOLYLINE":
            line = list(entity.get_points("xy"))
        else:
            line = [vertex.dxf.location for vertex in entity.vertices]
        line = np.array([(p[0], p[1]) for p in line], float).reshape(-1, 2)
        closed = kind != "LINE" and (entity.closed if kind == "LWPOLYLINE" else entity.is_closed)
        found.append(np.concatenate([line, line[:1]]) if closed else line)
    return [line for line in found if len(line) > 1]


def _points(block, layer):
    """Points (k, 2) of a layer."""
    found = [p.dxf.location for p in block.query("POINT") if p.dxf.layer == layer]
    return np.array([(p[0], p[1]) for p in found], float).reshape(-1, 2)
