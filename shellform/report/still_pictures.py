# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pictures of a report that stand still: for paper, and where a browser has no WebGL or no script.

PNG files as bytes; all joints at once, key frames of the walk, the skin from four sides.
"""

from __future__ import annotations

from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from PIL import Image

from shellform.pictures.skin_pressure import SIDES, pressure_figure
from shellform.pictures.surfaces import new_figure, save_figure, view_axes
from shellform.pictures.views import view_from_the_right
from shellform.pictures.walk import (
    Curve,
    draw_box,
    draw_clothed,
    draw_curve,
    obstacle_of,
    series_files,
)
from shellform.pictures.walk import frame_of as frame_of_mesh
from shellform.results.pressure_map import Map, VertexPressure
from shellform.scene.wearer import part_of

from .finished_run import FinishedRun

# of Okabe and Ito, told apart by people who see colours otherwise (jfly.uni-koeln.de/color, 2008)
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
DASHES = ("-", "--", ":", "-.", "-", "--")
KEYS = 7  # frames of a strip
PALETTE = 160  # colours of a picture


def torque_picture(
    runs: list[FinishedRun], curves: list[dict[str, dict[str, Any]]], phase: bool
) -> bytes:
    """Torque of all joints against time, or against the phase of gait: the mean stride, or all."""
    joints = list(dict.fromkeys(joint for own in curves for joint in own))
    columns = min(3, len(joints))
    rows = -(-len(joints) // columns)
    figure, grid = new_figure(rows, (11, 2.6 * rows), "", columns=columns, dpi=110)
    flat = np.atleast_1d(grid).ravel()
    for axes, joint in zip(flat, joints, strict=False):
        for k, (run, own) in enumerate(zip(runs, curves, strict=True)):
            for curve in _curves(run.label, own.get(joint, {}), phase):
                draw_curve(axes, curve, COLOURS[k % len(COLOURS)], 1.0)
                axes.lines[-1].set_linestyle(DASHES[k % len(DASHES)])
        axes.axhline(0, color="0.6", lw=0.6)
        axes.set_title(joint.replace("_", " "), fontsize=9)
        axes.set_xlabel("part of the stride [%]" if phase else "time [s]", fontsize=8)
        axes.set_ylabel("torque [N m]", fontsize=8)
        axes.tick_params(labelsize=7)
    for axes in flat[len(joints) :]:
        axes.set_axis_off()
    handles = {line.get_label(): line for line in flat[0].lines[:-1]}
    if handles:
        flat[0].legend(handles.values(), handles.keys(), frameon=False, fontsize=8)
    return _png(lambda path: save_figure(figure, path))


def _curves(label, entry, phase):
    """Curve of a joint; over the phase of gait the mean stride, or single ones without it."""
    names = ("percent", "mean", "mean_error", "mean_spread")
    names = names if phase else ("time", "torque", "error", "spread")
    if names[1] not in entry:
        strides = entry.get("strides", [])
        return [Curve(label, np.asarray(entry["percent"]), np.asarray(one)) for one in strides]
    place, mean, error, spread = (np.asarray(entry[name], float) for name in names)
    several = np.isfinite(error).all()
    return [Curve(label, place, mean, *((error, spread) if several else (None, None)))]


def walk_picture(run: FinishedRun) -> bytes:
    """Key frames of the walk, from the right."""
    # only here: a library that reads files loads only when one is read
    import meshio

    files = [one for one in series_files(run.out) if one[0] >= run.wearer.start - 1e-9]
    picked = np.unique(np.linspace(0, len(files) - 1, KEYS).round().astype(int))
    figure, panels = new_figure(1, (11, 2.5), "", columns=len(picked), dpi=110)
    view = view_from_the_right(run.wearer)
    right, up, _ = view_axes(*view)
    box = obstacle_of(run.wearer.recording)
    for axes, k in zip(np.atleast_1d(panels), picked, strict=True):
        time, path = files[k]
        frame = frame_of_mesh(meshio.read(path), time)
        corners = draw_clothed(axes, frame, run.wearer, view, 1, skin=run.skin)
        centre = corners.mean(axis=0)
        if box is not None and abs(box[0][0] + 0.5 * box[1][0] - centre[0]) < 0.6:
            draw_box(axes, *box, view)
        axes.set_xlim(centre @ right - 0.48, centre @ right + 0.48)
        low = (corners @ up).min()
        axes.set_ylim(low - 0.05, low + 1.4)
        axes.set_title(f"{time:.2f} s", fontsize=8)
    return _png(lambda path: save_figure(figure, path))


def skin_picture(run: FinishedRun, map: Map | VertexPressure, top: float) -> bytes:
    """The mean pressure on the skin from four sides; `top` : end of the scale [Pa]."""
    wearer = part_of(run.scene, run.wearer, map.names) if isinstance(map, Map) else run.wearer
    return _png(
        lambda path: pressure_figure(path, wearer, map, wearer.start, "", tuple(SIDES), top)
    )


def _png(draw):
    """Bytes of the picture that a function writes, in few colours: a third of the size."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "picture.png"
        draw(path)
        with Image.open(path) as image:
            few = image.convert("RGB").quantize(PALETTE, method=Image.Quantize.FASTOCTREE)
        out = BytesIO()
        few.save(out, format="PNG")
        return out.getvalue()
