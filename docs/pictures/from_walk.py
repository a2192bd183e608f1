# SPDX-License-Identifier: LGPL-3.0-or-later
"""The README's picture: key frames and torque of what `make walk` has left in out/walk.

make walk
.venv/bin/python docs/pictures/from_walk.py
"""

from io import BytesIO
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from PIL import Image

from shellform.pictures.surfaces import view_axes
from shellform.pictures.views import view_from_the_right
from shellform.pictures.walk import (
    COLOURS,
    curve_of,
    draw_box,
    draw_clothed,
    draw_curve,
    obstacle_of,
    read_frames,
)
from shellform.results.mean_torque import mean_rows
from shellform.scene.scene_file import read_scene
from shellform.scene.wearer import wearer_of

HERE = Path(__file__).parent
RUN = HERE.parents[1] / "out/walk"
FABRICS, JOINT, KEYS = ("compliant", "stiff"), "right_knee", 9
SHADES = 64  # of the file: an eighth of the bytes


def draw_keys(figure, wearer, frames):
    """Frames side by side, all at one scale, the times below."""
    view = view_from_the_right(wearer)
    right, up, _ = view_axes(*view)
    corner, size = obstacle_of(wearer.recording)
    for axes, frame in zip(figure.subplots(1, len(frames)), frames, strict=True):
        corners = draw_clothed(axes, frame, wearer, view)
        centre, low = corners.mean(axis=0), (corners @ up).min()
        if abs(corner[0] + 0.5 * size[0] - centre[0]) < 0.6:
            draw_box(axes, corner, size, view)
        axes.set_xlim(centre @ right - 0.48, centre @ right + 0.48)
        axes.set_ylim(low - 0.06, low + 1.42)
        axes.set_title(f"{frame.time:.1f} s", y=-0.16, fontsize=11)


def draw_torque(axes, frames):
    for fabric, colour in zip(FABRICS, COLOURS, strict=False):
        curve = curve_of(f"{fabric} trousers", mean_rows(RUN / fabric), JOINT)
        draw_curve(axes, curve, colour, 1.4)
    axes.axhline(0, color="0.6", lw=0.6)
    for frame in frames:
        axes.axvline(frame.time, color="0.87", lw=0.8, zorder=0)
    axes.set_xlim(frames[0].time - 0.35, frames[-1].time + 0.35)
    axes.set_xlabel("time [s]")
    axes.set_ylabel("torque about the\nright knee [N m]")
    axes.legend(frameon=False, loc="lower left")


def main():
    wearer = wearer_of(read_scene(RUN / FABRICS[0] / "scene.toml"))
    frames = [f for f in read_frames(RUN / FABRICS[0]) if f.time >= wearer.start - 1e-9]
    keys = [frames[k] for k in np.linspace(0, len(frames) - 1, KEYS).round().astype(int)]
    plt.rcParams["font.size"] = 11
    figure = plt.figure(figsize=(9.6, 5.2), layout="constrained")
    above, below = figure.subfigures(2, 1, height_ratios=(1, 1.2))
    draw_keys(above, wearer, keys)
    draw_torque(below.subplots(), keys)
    drawn = BytesIO()
    figure.savefig(drawn, dpi=125)
    picture = Image.open(drawn).convert("RGB")
    picture.quantize(SHADES, dither=Image.Dither.NONE).save(HERE / "walk.png", optimize=True)


if __name__ == "__main__":
    main()
