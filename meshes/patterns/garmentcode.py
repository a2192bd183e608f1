# SPDX-License-Identifier: LGPL-3.0-or-later
"""GarmentCode's pattern specification, a JSON file, as a SewingPattern.

Format of pygarment 2 (Korosteleva and Sorkine-Hornung, ACM Trans. Graph. 42, 2023):

    pattern.panels      name -> vertices [[x, y]], edges [{endpoints [i, j], label, curvature}],
                        rotation [deg about x, then y, then z], translation
    curvature           {type, params}: quadratic, cubic: control points in the frame of the edge,
                        its length 1, to the left positive; circle: radius, 1 for the longer arc,
                        1 for a bulge to the right
    pattern.stitches    [[{panel, edge}, {panel, edge}], ...], edges by number
    properties          units_in_meter, 100 for cm; curvature_coords 'relative' or 'absolute'

Its y points up and its z forward. Its grain runs along y of a panel.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from meshes.validity import MeshError

from .pattern import Edge, Panel, SewingPattern, Stitch

# columns: where x, y, z of the file point in axes forward, left, up
AXES = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
UNITS = {1.0: "m", 10.0: "dm", 100.0: "cm", 1000.0: "mm", 39.3701: "in"}  # in a metre


def read_garmentcode(path: Path, size: str | None = None) -> SewingPattern:
    """Pattern of a JSON file; MeshError in one sentence for what is not one, or for a size."""
    name = path.name
    if size is not None:
        raise MeshError(
            f"{name}: size {size!r} is asked for, and GarmentCode files have one: leave it out."
        )
    twice: list[str] = []

    def once(pairs):
        seen: dict[str, Any] = {}
        for key, value in pairs:
            if key in seen:
                twice.append(key)
            seen[key] = value
        return seen

    try:
        data = json.loads(path.read_text(encoding="utf-8-sig"), object_pairs_hook=once)
    except (ValueError, UnicodeDecodeError) as error:
        raise MeshError(f"{name}: not a JSON file ({error}), export the pattern again.") from None
    if twice:
        raise MeshError(
            f"{name}: '{twice[0]}' is there twice, and one would hide the other: name the second "
            "otherwise, as 'right_sleeve' beside 'left_sleeve'."
        )
    pattern = data.get("pattern") if isinstance(data, dict) else None
    pattern = pattern if isinstance(pattern, dict) else {}
    panels = pattern.get("panels")
    if not isinstance(panels, dict) or not panels:
        raise MeshError(
            f"{name}: there are no panels under pattern.panels, as a GarmentCode specification "
            "has: export the pattern again."
        )
    properties = data.get("properties", {})
    scale = _scale(properties, name)
    absolute = properties.get("curvature_coords", "relative") == "absolute"
    made = tuple(
        _panel(title, panel, scale, absolute, f"{name}: panel '{title}'")
        for title, panel in panels.items()
    )
    stitches = tuple(_stitch(k, s, made, name) for k, s in enumerate(pattern.get("stitches", [])))
    return SewingPattern(name, made, stitches)


def _scale(properties, name):
    """Metres in a unit of the file."""
    given = properties.get("units_in_meter") if isinstance(properties, Mapping) else None
    close = [unit for unit in UNITS if isinstance(given, int | float) and abs(given - unit) < 1e-3]
    if not close:
        raise MeshError(
            f"{name}: properties.units_in_meter is {given!r}, which is no unit that is known: give "
            "100 for cm, 1000 for mm, 1 for m."
        )
    return 1.0 / given


def _panel(title, data, scale, absolute, where):
    try:
        vertices = scale * np.array(data["vertices"], float).reshape(-1, 2)
    except (KeyError, TypeError, ValueError):
        raise MeshError(f"{where}: vertices are pairs of numbers [x, y], give these.") from None
    edges, ends = [], []
    given = data.get("edges") or []
    for k, edge in enumerate(given):
        here = f"{where}, edge {k}"
        try:
            i, j = (int(end) for end in edge["endpoints"])
            if min(i, j) < 0:
                raise ValueError
            start, end = vertices[i], vertices[j]
        except (KeyError, TypeError, ValueError, IndexError):
            raise MeshError(
                f"{here}: endpoints are two numbers of vertices, 0 to {len(vertices) - 1}."
            ) from None
        ends.append((i, j))
        edges.append(_edge(str(k), start, end, edge.get("curvature"), scale, absolute, here))
    for k, (_, j) in enumerate(ends):
        after = (k + 1) % len(ends)
        if j != ends[after][0]:
            raise MeshError(
                f"{where}, edge {k}: it ends at vertex {j} and edge {after} begins at vertex "
                f"{ends[after][0]}: the outline is open, let each edge begin where the one before "
                "ends, the last at the beginning of the first."
            )
    return Panel(title, tuple(edges), **_place(data, scale, where))


def _edge(label, start, end, curvature, scale, absolute, where):
    if not curvature:
        return Edge(label, np.stack([start, end]))
    along = end - start
    left = np.array([-along[1], along[0]])
    # of the first version: the control point alone
    given = curvature if isinstance(curvature, Mapping) else {"type": "quadratic"}
    kind = given.get("type")
    if kind not in ("quadratic", "cubic", "circle"):
        raise MeshError(
            f"{where}: its curvature is of the type {kind!r}: give quadratic, cubic or circle."
        )
    try:
        params = given.get("params", [curvature])
        if kind in ("quadratic", "cubic"):
            control = np.array(params, float).reshape(len(params), 2)
            if len(control) != {"quadratic": 1, "cubic": 2}[kind]:
                raise ValueError
            if absolute:
                control = scale * control
            else:
                control = start + control[:, :1] * along + control[:, 1:] * left
            return Edge(label, np.concatenate([[start], control, [end]]))
        radius, large, right = scale * float(params[0]), bool(params[1]), bool(params[2])
    except (KeyError, TypeError, ValueError, IndexError):
        raise MeshError(
            f"{where}: its curvature is {curvature!r}: give one control point for quadratic, two "
            "for cubic, radius and two flags for circle."
        ) from None
    half = 0.5 * np.linalg.norm(along)
    if not radius >= half * (1 - 1e-3):
        raise MeshError(
            f"{where}: a circle of radius {radius:.4g} m does not reach over ends {2 * half:.4g} m "
            "apart: give half of that at least."
        )
    depth = np.sqrt(max(radius**2 - half**2, 0.0))
    rise = radius + depth if large else radius - depth
    middle = 0.5 * (start + end) + (-rise if right else rise) * left / (2 * half)
    return Edge(label, np.stack([start, middle, end]), "arc")


def _place(data, scale, where):
    """Arguments `rotation` and `translation` of a Panel; none where the file does not say."""
    if "translation" not in data:
        return {}
    try:
        translation = scale * np.array(data["translation"], float).reshape(3)
        x, y, z = np.radians(np.array(data.get("rotation", [0, 0, 0]), float).reshape(3))
        if not np.isfinite([*translation, x, y, z]).all():
            raise ValueError
    except (TypeError, ValueError):
        raise MeshError(
            f"{where}: translation and rotation are three finite numbers each, give these."
        ) from None
    turn = np.eye(3)
    for axis, angle in ((0, x), (1, y), (2, z)):
        i, j = (axis + 1) % 3, (axis + 2) % 3
        step = np.eye(3)
        step[[i, i, j, j], [i, j, i, j]] = (
            np.cos(angle),
            -np.sin(angle),
            np.sin(angle),
            np.cos(angle),
        )
        turn = step @ turn
    return {"rotation": AXES @ turn, "translation": AXES @ translation}


def _stitch(number, data, panels, name):
    sides = []
    known = {panel.name: panel for panel in panels}
    for side in data[:2] if isinstance(data, list) else ():
        panel, edge = (side.get(k) if isinstance(side, dict) else None for k in ("panel", "edge"))
        if panel not in known:
            raise MeshError(
                f"{name}: stitch {number} names panel {panel!r}, which is not there: there are "
                f"{', '.join(known)}."
            )
        if not (isinstance(edge, int) and 0 <= edge < len(known[panel].edges)):
            raise MeshError(
                f"{name}: stitch {number} names edge {edge!r} of panel '{panel}', which has edges "
                f"0 to {len(known[panel].edges) - 1}."
            )
        sides.append(((panel, str(edge)),))
    if len(sides) != 2:
        raise MeshError(f"{name}: stitch {number} is not two of {{panel, edge}}: give both sides.")
    return Stitch(*sides)
