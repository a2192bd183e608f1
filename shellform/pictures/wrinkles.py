# SPDX-License-Identifier: LGPL-3.0-or-later
"""Where cloth is taut, wrinkled and slack on a body, from the series of a run.

Wrinkles are smaller than the cells (material/wrinkling.py): what is drawn is the strain that they
take up, colour, and how their crests run, lines. Frames of a walk are those of standing, of the
widest step and of the most bent knee.
"""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from contact.body.segments import Body
from shellform.motion.gait.strides import counted
from shellform.motion.recording import LEGS, SIDES, Recording
from shellform.motion.wearer import Wearer

from .surfaces import (
    draw_surfaces,
    ellipsoid_facets,
    facing,
    new_figure,
    save_figure,
    smooth,
    view_axes,
)
from .views import fit_view, view_from_the_right
from .walk import SKIN, Frame, draw_box, frame_of, obstacle_of, series_files

TAUT_COLOUR, PARTS = "#a9cfa0", 2
LEVEL = 0.2  # height of one ankle over the other in a step on the floor, at most [m]
MAPS = {1: ("YlOrRd", "wrinkled"), 2: ("PuBu", "slack")}
DARKEST = 0.97  # share of the wrinkled cells that the scale reaches to


class Wrinkled(NamedTuple):
    """Wrinkles of the m cells of a frame: state, crest and strain as in `Shell.wrinkling`."""

    frame: Frame
    state: np.ndarray
    crest: np.ndarray
    strain: np.ndarray


def read_wrinkles(path: Path, time: float) -> Wrinkled | None:
    """A frame with its wrinkles from a file of a series; None if the sheet is not relaxed."""
    # only here: drawing libraries load only when something is drawn
    import meshio

    mesh = meshio.read(path)
    if "wrinkling" not in mesh.cell_data:
        return None
    fields = (mesh.cell_data[name][0] for name in ("wrinkling", "crest", "wrinkle_strain"))
    return Wrinkled(frame_of(mesh, time), *fields)


def draw_walk_wrinkles(path: str | Path, wearer: Wearer, run: str | Path, title: str = "") -> bool:
    """The cloth of a walk at up to three moments, from the right and from the left.

    Parameters
    ----------
    path : PNG file; wearer : Wearer; run : folder of its series

    Returns
    -------
    False where the sheet is not relaxed: nothing is drawn then
    """
    files = [one for one in series_files(run) if one[0] >= wearer.start - 1e-9]
    moments = moments_of(wearer.recording, np.array([time for time, _ in files]))
    shown = {name: read_wrinkles(files[k][1], files[k][0]) for name, k in moments.items()}
    frames = {name: frame for name, frame in shown.items() if frame is not None}
    azimuth, elevation = view_from_the_right(wearer)
    views = [(azimuth, elevation), (azimuth + 180.0, elevation)]
    box = obstacle_of(wearer.recording)
    return wrinkles_figure(path, wearer, frames, views, title, box, height=1.43)


def draw_drape_wrinkles(path: str | Path, body: Body, run: str | Path, title: str = "") -> bool:
    """The sheet of a series over its body, halfway and at the end, from two sides; as above."""
    files = series_files(run)
    shown = [read_wrinkles(path, time) for time, path in (files[len(files) // 2], files[-1])]
    frames = {
        name: one
        for name, one in zip(("halfway", "at the end"), shown, strict=True)
        if one is not None
    }
    return wrinkles_figure(path, body, frames, [(-60.0, 8.0), (30.0, 35.0)], title)


def wrinkles_figure(
    path: str | Path,
    body: Body | Wearer,
    frames: dict[str, Wrinkled],
    views: list[tuple[float, float]],
    title: str = "",
    box: tuple[np.ndarray, np.ndarray] | None = None,
    height: float = 0.0,
) -> bool:
    """Frames side by side, seen from views (azimuth, elevation) [degrees] one below the other.

    box : corner and size of an obstacle, shown in the first view
    height : of all panels [m], as wide as three quarters of it; 0: as what is seen needs

    Returns
    -------
    False without frames: nothing is drawn then
    """
    if not frames:
        return False
    top = scale_of(list(frames.values()))
    size = 3.2 * len(frames) + 1.6, 4.4 * len(views)
    figure, grid = new_figure(len(views), size, title, columns=len(frames))
    grid = np.reshape(grid, (len(views), len(frames)))
    for column, (name, frame) in zip(grid.T, frames.items(), strict=True):
        for k, (axes, view) in enumerate(zip(column, views, strict=True)):
            corners = draw_wrinkles(axes, frame, body, view, top, None if k else box)
            if height:
                _same_window(axes, corners, view, height)
            else:
                fit_view(axes, corners, view)
        column[0].set_title(f"{name}, {frame.frame.time:.2f} s", fontsize=10)
        shares = (100 * np.mean(frame.state == k) for k in range(3))
        caption = "taut {:.0f}, wrinkled {:.0f}, slack {:.0f} % of the cells".format(*shares)
        column[-1].set_title(caption, fontsize=8, y=-0.05)
    _legend(figure, grid, top)
    save_figure(figure, Path(path))
    return True


def _same_window(axes, corners, view, height):
    right, up, _ = view_axes(*view)
    middle, low = corners.mean(axis=0) @ right, (corners @ up).min()
    axes.set_xlim(middle - 0.365 * height, middle + 0.365 * height)
    axes.set_ylim(low - 0.03, max(low + height - 0.03, (corners @ up).max() + 0.03))


def moments_of(recording: Recording, times: np.ndarray) -> dict[str, int]:
    """Which of the times (k,) [s], rising, show standing, the widest step, the most bent knee.

    Steps are those on the floor where there are any. Of a recording without legs only the first.
    """
    moments = {"standing": 0}
    begin, end = counted(recording)
    own = np.flatnonzero((times >= begin) & (times <= end))
    if not len(own) or not set(LEGS) - {"right_foot", "left_foot"} <= set(recording.points):
        return moments
    at = np.abs(recording.times[:, None] - times[own]).argmin(axis=0)
    ankles = [recording.joint_centre(f"{side}_ankle")[at] for side in SIDES]
    bend = np.max([_knee_bend(recording, side)[at] for side in SIDES], axis=0)
    apart = ankles[0] - ankles[1]
    width, rise = np.linalg.norm(apart[:, :2], axis=1), np.abs(apart[:, 2])
    level = rise <= max(LEVEL, rise.min())
    moments["widest step"] = int(own[np.where(level, width, -1.0).argmax()])
    moments["most bent knee"] = int(own[bend.argmax()])
    return moments


def _knee_bend(recording, side):
    """Angle (n,) [rad] between thigh and shank."""
    thigh, shank = (recording.points[f"{side}_{part}"] for part in ("thigh", "shank"))
    one, other = (track[:, 1] - track[:, 0] for track in (thigh, shank))
    return np.arctan2(np.linalg.norm(np.cross(one, other), axis=1), np.sum(one * other, axis=1))


def scale_of(frames: list[Wrinkled]) -> float:
    """Wrinkle strain of the darkest colour."""
    strains = np.concatenate([frame.strain[frame.state > 0] for frame in frames])
    return float(np.quantile(strains, DARKEST)) if len(strains) else 1.0


def draw_wrinkles(
    axes: Any,
    wrinkled: Wrinkled,
    body: Body | Wearer,
    view: tuple[float, float],
    top: float,
    box: tuple[np.ndarray, np.ndarray] | None = None,
) -> np.ndarray:
    """One frame on its body: cells by state and strain up to `top`, crests as lines.

    Returns
    -------
    corners : (n, 3) [m], all that was drawn but for the box
    """
    frame = wrinkled.frame
    pose = body.new_pose(frame.time)
    ellipsoids = zip(pose.centres, pose.axes, np.asarray(body.radii), strict=True)
    skin = [ellipsoid_facets(*one, 24) for one in ellipsoids]
    facets, _ = smooth(frame.points, frame.directors, frame.cells, PARTS)
    colours = np.repeat(colours_of(wrinkled, top), PARTS**2, axis=0)
    lines = crest_lines(wrinkled)
    size = np.linalg.norm(facets[:, 2] - facets[:, 0], axis=1).mean() * PARTS
    eye = view_axes(*view)[2]
    solids = [(facing(patch, eye), None, SKIN, SKIN, 0.7 * size) for patch in skin]
    none = np.empty((0, 4, 3))
    cloth = [(facets, None, colours, colours, 0.0), (none, lines, SKIN, SKIN, 0.0)]
    draw_surfaces(axes, [*cloth, *solids], *view)
    corners = np.concatenate([frame.points, *(patch.reshape(-1, 3) for patch in skin)])
    if box is not None and abs(box[0][0] + 0.5 * box[1][0] - corners.mean(axis=0)[0]) < 0.6:
        draw_box(axes, *box, view)
    return corners


def colours_of(wrinkled: Wrinkled, top: float) -> np.ndarray:
    """Colours (m, 3) of cells."""
    import matplotlib
    from matplotlib.colors import to_rgb

    colours = np.tile(to_rgb(TAUT_COLOUR), (len(wrinkled.state), 1))
    for state, (name, _) in MAPS.items():
        own = wrinkled.state == state
        # the palest end of a map is left to taut cells
        shade = 0.15 + 0.8 * np.clip(wrinkled.strain[own] / top, 0.0, 1.0)
        colours[own] = matplotlib.colormaps[name](shade)[:, :3]
    return colours


def crest_lines(wrinkled: Wrinkled) -> np.ndarray:
    """Lines (k, 2, 3) [m] through the middle of wrinkled cells, half as long as these are wide."""
    own = wrinkled.state == 1
    corners = wrinkled.frame.points[wrinkled.frame.cells[own]]
    area = 0.5 * np.linalg.norm(
        np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]), axis=1
    )
    reach = 0.3 * np.sqrt(area)[:, None] * wrinkled.crest[own]
    middle = corners.mean(axis=1)
    return np.stack([middle - reach, middle + reach], axis=1)


def _legend(figure, grid, top):
    import matplotlib
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import ListedColormap, Normalize
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    for name, label in MAPS.values():
        part = ListedColormap(matplotlib.colormaps[name](np.linspace(0.15, 0.95, 64)))
        scale = ScalarMappable(Normalize(0.0, 100 * top), part)
        bar = figure.colorbar(scale, ax=grid, shrink=0.45, aspect=25, pad=0.02, extend="max")
        bar.set_label(f"{label}: strain that wrinkles take up [%]", fontsize=8)
        bar.ax.tick_params(labelsize=7)
    signs = [
        Patch(facecolor=TAUT_COLOUR, edgecolor="0.5", label="taut"),
        Line2D([], [], color="#1f3440", lw=0.8, label="crests of wrinkles"),
    ]
    figure.legend(handles=signs, loc="upper right", frameon=False, fontsize=8)
