# SPDX-License-Identifier: LGPL-3.0-or-later
"""Panels of an SVG drawing as a SewingPattern, read by svgelements.

A closed path is a panel, named by its id, or by that of a group that holds it with its marks: lines
whose id or class begins with 'grain', 'notch' or 'fold'. Its edges lie between corners, numbered in
the order of the path, or named by its attribute data-edges. Groups 'size-M' hold sizes. The unit
comes from width (as '300mm') and viewBox; y of the drawing points down.
"""

from __future__ import annotations

import io
import re
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from meshes.validity import MeshError

from .drawn import CORNER, NEAR, counter_clockwise, unfolded
from .pattern import Edge, Panel, SewingPattern

HOW = (
    "a pattern in SVG is read by the package svgelements: pip install svgelements, or "
    "shellform[patterns]"
)
UNITS = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "in": 0.0254, "pt": 0.0254 / 72, "pc": 0.0254 / 6}
SAMPLES = 64  # of a curve that is no Bezier curve
DOWN = np.array([1.0, -1.0])


def read_svg(path: Path, size: str | None = None, unit: str | None = None) -> SewingPattern:
    """Pattern of an SVG file; arguments and errors as `read_pattern`."""
    try:
        # only here: an option
        import svgelements
    except ImportError:
        raise ImportError(HOW) from None
    name = path.name
    try:
        root = ElementTree.fromstring(path.read_bytes())
    except ElementTree.ParseError as error:
        raise MeshError(f"{name}: not an SVG file ({error}), export the drawing again.") from None
    scale = _scale(root, unit, name)
    text = io.BytesIO(ElementTree.tostring(root))
    drawing = svgelements.SVG.parse(text, reify=True)
    sizes: dict[str, list] = {}
    _collect(drawing, None, "", sizes, svgelements)
    found = _of_size(sizes, size, name)
    groups: dict[str, list] = {}
    for owner, element in found:
        own = _attributes(element)
        key = owner or own.get("id") or f"panel_{len(groups)}"
        groups.setdefault(key, []).append((own, element))
    panels = []
    for title, members in groups.items():
        panel = _panel(title, members, scale, f"{name}: panel '{title}'", svgelements)
        if panel is not None:
            panels.append(panel)
    if not panels:
        raise MeshError(f"{name}: it has no closed path: draw each panel as one, with an id.")
    return SewingPattern(name, tuple(panels))


def _attributes(element):
    return element.values.get("attributes", {})


def _collect(group, owner, size, found, svg):
    """Paths with the group that names their panel, by size."""
    for element in group:
        own = _attributes(element)
        if isinstance(element, svg.Group):
            title = own.get("id", "")
            if title.startswith("size-"):
                _collect(element, None, title[5:], found, svg)
            else:
                _collect(element, title or owner, size, found, svg)
        elif isinstance(element, svg.Shape):
            found.setdefault(size, []).append((owner, element))


def _of_size(sizes, size, name):
    common = sizes.pop("", [])
    known = ", ".join(sizes)
    if size is not None and size not in sizes:
        there = f"there are {known}" if known else "it has no groups 'size-...': leave it out"
        raise MeshError(f"{name}: there is no size {size!r} (size under [garment]); {there}.")
    if size is None and sizes:
        raise MeshError(f"{name}: the pattern has sizes {known}: give one, size under [garment].")
    # layers around all panels of a drawing are no panels
    return common + (sizes[size] if size is not None else [])


def _scale(root, unit, name):
    """Metres in a unit of the drawing; its width becomes that of the viewBox."""
    number = r"\s*([-+.\deE]+)\s*([a-z%]*)\s*"
    width = re.fullmatch(number, root.get("width", ""))
    box = [float(x) for x in re.split(r"[\s,]+", root.get("viewBox", "").strip()) if x]
    said = width.group(2) if width else ""
    if said and said not in (*UNITS, "px", "%"):
        raise MeshError(
            f"{name}: its width is '{root.get('width')}', in no unit that is known: give mm, cm or "
            "in."
        )
    if width and said in UNITS:
        whole = float(width.group(1)) * UNITS[said]
        scale = whole / box[2] if len(box) == 4 else UNITS["in"] / 96
    elif unit is not None:
        scale = UNITS[unit]
    else:
        raise MeshError(
            f"{name}: its width has no unit of length ({root.get('width')!r}): give it as "
            "'300mm', or unit under [garment] for that of the drawing."
        )
    if len(box) == 4:
        root.set("width", str(box[2]))
        root.set("height", str(box[3]))
    return scale


def _panel(title, members, scale, where, svg):
    """Panel of the paths of a group; None for marks without an outline."""
    outlines, marks = [], []
    for own, element in members:
        word = (own.get("class") or own.get("id") or "").lower()
        kind = next((k for k in ("grain", "notch", "fold") if word.startswith(k)), None)
        path = svg.Path(element)
        if kind:
            marks.append((kind, path))
        elif len(path):
            outlines.append((own, path))
    if not outlines:
        return None
    if len(outlines) > 1 and not all(_closed(path) for _, path in outlines):
        raise MeshError(
            f"{where}: it has {len(outlines)} lines that are no marks: give marks an id that "
            "begins with grain, notch or fold, and each panel a group or an id of its own."
        )
    own, path = max(outlines, key=lambda item: item[1].length(error=1e-3))
    segments = [s for s in path if not isinstance(s, svg.Move | svg.Close)]
    closing = [s for s in path if isinstance(s, svg.Close)]
    if not segments:
        return None
    start = np.array(segments[0].start)
    end = np.array(segments[-1].end)
    gap = scale * float(np.linalg.norm(end - start))
    if not closing and gap > NEAR:
        raise MeshError(
            f"{where}: the outline is open, its last point lies {1e3 * gap:.3g} mm from its first "
            "one: close the path."
        )
    pieces = [_points(s, scale, svg) for s in segments]
    if gap > NEAR:
        pieces.append((scale * np.stack([end, start]) * DOWN, "bezier"))
    edges = _joined(pieces)
    names = (own.get("data-edges") or "").split()
    if names and len(names) != len(edges):
        raise MeshError(
            f"{where}: data-edges has {len(names)} names, and its outline has {len(edges)} edges "
            "between corners: give one for each."
        )
    edges = [
        Edge(names[k] if names else str(k), points, kind) for k, (points, kind) in enumerate(edges)
    ]
    grain, notches, fold = (0.0, 1.0), [], None
    for kind, mark in marks:
        points = scale * np.array([mark.point(0.0), mark.point(1.0)], float) * DOWN
        if kind == "grain":
            x, y = points[1] - points[0]
            grain = (float(x), float(y))
        elif kind == "notch":
            x0, y0, x1, y1 = mark.bbox()
            notches.append(scale * np.array([0.5 * (x0 + x1), 0.5 * (y0 + y1)]) * DOWN)
        else:
            fold = points
    panel = Panel(title, tuple(edges), grain, np.array(notches).reshape(-1, 2))
    panel = counter_clockwise(panel)
    return panel if fold is None else counter_clockwise(unfolded(panel, fold, where))


def _closed(path):
    first, last = path.first_point, path.current_point
    return first is not None and abs(first - last) < 1e-6


def _points(segment, scale, svg):
    """Control points of a segment and their kind, in m and y up."""
    if isinstance(segment, svg.Line):
        points = [segment.start, segment.end]
    elif isinstance(segment, svg.QuadraticBezier):
        points = [segment.start, segment.control, segment.end]
    elif isinstance(segment, svg.CubicBezier):
        points = [segment.start, segment.control1, segment.control2, segment.end]
    else:
        points = [segment.point(t) for t in np.linspace(0.0, 1.0, SAMPLES + 1)]
        return scale * np.array(points, float) * DOWN, "polyline"
    return scale * np.array(points, float) * DOWN, "bezier"


def _joined(pieces):
    """Edges between corners: segments that go on smoothly are one."""
    pieces = [(p, kind) for p, kind in pieces if np.ptp(p, axis=0).max() > 1e-9]
    lines = [Edge("", p, kind).curve(np.linspace(0, 1, SAMPLES + 1)) for p, kind in pieces]
    corner = []
    for k, line in enumerate(lines):
        before, after = lines[k - 1][-1] - lines[k - 1][-2], line[1] - line[0]
        cross = before[0] * after[1] - before[1] * after[0]
        corner.append(np.degrees(abs(np.arctan2(cross, before @ after))) > CORNER)
    if sum(corner) < 2:
        return pieces
    first = corner.index(True)
    order = [(first + k) % len(pieces) for k in range(len(pieces))]
    edges: list[list[int]] = []
    for k in order:
        if corner[k]:
            edges.append([k])
        else:
            edges[-1].append(k)
    out = []
    for members in edges:
        if len(members) == 1:
            out.append(pieces[members[0]])
        else:
            parts = [lines[m][:-1] for m in members[:-1]] + [lines[members[-1]]]
            out.append((np.concatenate(parts), "polyline"))
    return out
