# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pictures of cloth on a body: the last frame from two sides, and all frames moving."""

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from contact.body.segments import Body

from .surfaces import (
    BACK,
    CLOTH,
    draw_surfaces,
    ellipsoid_facets,
    ellipsoid_outline,
    facets_and_sides,
    new_figure,
    save_animation,
    save_figure,
    view_axes,
)


def draw_cloth_on_body(
    folder: str | Path,
    name: str,
    frames: Sequence[tuple[np.ndarray, np.ndarray]],
    cells: np.ndarray,
    body: Body,
    seconds: float,
) -> None:
    """NAME.png, the last frame from two sides, and NAME.gif, all frames.

    Parameters
    ----------
    folder : path; name : str; frames : list of (points, directors); cells : (m, 4|9)
    body : Body, at time 0; seconds : float, between frames
    """
    pose = body.new_pose()
    body.pose(0.0, pose)
    rims = list(zip(pose.centres, pose.axes, np.asarray(body.radii), strict=True))
    skin = [ellipsoid_facets(*ellipsoid) for ellipsoid in rims]
    # a cell of cloth is flat, the body is round: let the cloth win where they are this close
    away = 0.5 * np.ptp(frames[0][0], axis=0).max() / np.sqrt(len(cells))
    solids = [(facets, None, "#d8a48f", "#d8a48f", away) for facets in skin]
    corners = np.concatenate([frames[0][0], frames[-1][0], *(s.reshape(-1, 3) for s in skin)])

    view = partial(draw_frame, cells=cells, solids=solids, corners=corners, rims=rims)
    figure, (left, right) = new_figure(1, (11, 5.5), "", columns=2)
    view(left, frames[-1], -60, 8)
    view(right, frames[-1], 30, 35)
    save_figure(figure, Path(folder) / f"{name}.png")
    images = []
    for frame in frames:
        figure, axes = new_figure(1, (5, 5), "", dpi=70)
        view(axes, frame, -60, 20)
        figure.canvas.draw()
        images.append(np.asarray(figure.canvas.buffer_rgba())[:, :, :3].copy())
    save_animation(images, Path(folder) / f"{name}.gif", seconds)


def draw_frame(
    axes: Any,
    frame: tuple[np.ndarray, np.ndarray],
    azimuth: float,
    elevation: float,
    *,
    cells: np.ndarray,
    solids: list[tuple],
    corners: np.ndarray,
    rims: list[tuple],
) -> None:
    """Cloth over its body, outlines dashed where cloth hides them, from one side."""
    cloth = facets_and_sides(*frame, cells)
    draw_surfaces(axes, [(*cloth, CLOTH, BACK, 0.0), *solids], azimuth, elevation)
    right, up, eye = view_axes(azimuth, elevation)
    for centre, axes_of, radii in rims:
        rim = ellipsoid_outline(centre, axes_of, radii, eye)
        axes.plot(rim @ right, rim @ up, "--", color="#8c4a32", lw=0.7)
    spans = corners @ right, corners @ up
    axes.set_xlim(spans[0].min() - 0.05, spans[0].max() + 0.05)
    axes.set_ylim(spans[1].min() - 0.05, spans[1].max() + 0.05)
