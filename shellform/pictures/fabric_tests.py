# SPDX-License-Identifier: LGPL-3.0-or-later
"""Tests of a fabric in one picture: curves of the card, and over them those of the sheet."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from .surfaces import new_figure, save_figure

COLOURS = {"warp": "tab:blue", "weft": "tab:orange", "": "tab:blue"}
STYLES = {"warp": "-", "weft": "--"}
SCALES = {  # factor and label of strain and load
    "pull": (100.0, "elongation [%]", "load [N/m]"),
    "shear": (180 / np.pi, "angle [degrees]", "load [N/m]"),
    "bend": (1.0, "curvature [1/m]", "moment [N]"),
}


def fabric_figure(path: str | Path, results: dict[str, Any], title: str = "") -> None:
    """Draw what there is of pull, shear, bend, hang, loop and drape.

    path : PNG file; results : of `bench.run.fabric_tests`
    """
    names = [n for n in ("pull", "shear", "bend", "hang", "loop", "drape") if n in results]
    columns = min(3, max(1, len(names)))
    rows = max(1, -(-len(names) // columns))
    size = (4.4 * columns, 3.9 * rows + 0.3)
    figure, grid = new_figure(rows, size, title, columns)
    places = np.atleast_1d(grid).ravel()
    for axes in places[len(names) :]:
        axes.set_axis_off()
    for name, axes in zip(names, places, strict=False):
        if name in SCALES:
            _curves(axes, name, results[name])
        elif name == "drape":
            _shadow(axes, results)
        else:
            _strips(axes, name, results[name])
    save_figure(figure, path)


def _curves(axes, name, found):
    by, strain, load = SCALES[name]
    for yarn, one in found.items() if "warp" in found else [("", found)]:
        x = by * np.r_[0.0, one["strain"]]
        if one["expected"] is not None:
            axes.plot(x, np.r_[0.0, one["expected"]], color="0.75", lw=5, solid_capstyle="round")
        label = f"{yarn} sheet".strip()
        axes.plot(x, np.r_[0.0, one["load"]], ".-", color=COLOURS[yarn], lw=1, ms=4, label=label)
    axes.plot([], [], color="0.75", lw=5, label="card")
    axes.set(xlabel=strain, ylabel=load, title=name)
    axes.legend(fontsize="small")


def _strips(axes, name, found):
    for yarn, one in found.items():
        x, z = 1e3 * np.asarray(one["shape"]).T
        if name == "loop":
            x, z = np.r_[x, -x[::-1]], np.r_[z, z[::-1]] - z[-1]
            label = f"{yarn} {1e3 * one['height']:.1f} mm, elastica {1e3 * one['elastica']:.1f}"
            bottom = -1e3 * one["elastica"]
            axes.plot([-8, 8], [bottom, bottom], "--", color=COLOURS[yarn], lw=1)
        else:
            label = f"{yarn} c = {1e3 * one['bending_length']:.1f} mm"
        axes.plot(x, z, STYLES[yarn], color=COLOURS[yarn], label=label)
        if name == "hang":
            reach = x.max()
            axes.plot([0, reach], [0, -reach * np.tan(np.radians(41.5))], ":", color="0.5", lw=1)
    axes.set(xlabel="x [mm]", ylabel="z [mm]", title=name, aspect="equal")
    axes.legend(fontsize="small")


def _shadow(axes, results):
    turn = np.linspace(0, 2 * np.pi, 361)
    for radius, style in ((90, "-"), (150, ":")):
        axes.plot(radius * np.cos(turn), radius * np.sin(turn), style, color="0.6", lw=1)
    for one in results["drape"]:
        radii = 1e3 * np.asarray(one["shadow"])
        angle = 2 * np.pi * (np.arange(len(radii)) + 0.5) / len(radii)
        axes.fill(radii * np.cos(angle), radii * np.sin(angle), color="tab:blue", alpha=0.25)
        axes.plot(radii * np.cos(angle), radii * np.sin(angle), color="tab:blue", lw=0.7)
    axes.set(
        xlabel="along the warp [mm]",
        ylabel="along the weft [mm]",
        title=f"drape {results['drape_coefficient']:.1f} %, {results['folds']:g} folds",
        aspect="equal",
    )
