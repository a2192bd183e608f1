# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pictures of cloth on a body: the last frame from two sides, and all frames moving.

Outlines of the body are dashed, also where cloth hides them.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from contact.body.segments import Body

from .painter import painted
from .surfaces import (
    BACK,
    CLOTH,
    ellipsoid_facets,
    ellipsoid_outline,
    facets_and_sides,
    save_animation,
    save_image,
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

    def picture(frame, size, dpi, azimuth, elevation):
        eye = view_axes(azimuth, elevation)[2]
        outlines = [(ellipsoid_outline(*ellipsoid, eye), "#8c4a32", 0.7) for ellipsoid in rims]
        cloth = facets_and_sides(*frame, cells)
        shown = [(*cloth, CLOTH, BACK, 0.0), *solids]
        return painted(shown, outlines, corners, size, dpi, azimuth, elevation)

    sides = [picture(frames[-1], (5.5, 5.5), 130, *view) for view in ((-60, 8), (30, 35))]
    save_image(np.concatenate(sides, axis=1), Path(folder) / f"{name}.png")
    images = [picture(frame, (5, 5), 70, -60, 20) for frame in frames]
    save_animation(images, Path(folder) / f"{name}.gif", seconds)
