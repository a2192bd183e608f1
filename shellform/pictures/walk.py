# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pictures of a dressed wearer: dressing, key frames, torque and an animation, Figs. 7, 8, 10.

Drawn from the files of a run and the wearer's motion; matplotlib only.
"""

import xml.etree.ElementTree as xml
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from contact.body.surface_motion import SurfaceMotion
from shellform.motion.recording import Recording
from shellform.motion.wearer import Wearer

from .surfaces import (
    BACK,
    CLOTH,
    draw_surfaces,
    ellipsoid_facets,
    facing,
    new_figure,
    save_animation,
    save_figure,
    smooth,
    view_axes,
)
from .views import VIEW, fit_view, view_from_the_right

SKIN, FLOOR = "#d8a48f", "#cfd3cc"
COLOURS = ("#1b6ca8", "#c2452d", "#3c8d40", "#8054a2")


class Frame(NamedTuple):
    """Cloth at a time: time [s], points (n, 3) [m], directors (n, 3), cells (m, 3 | 4 | 9)."""

    time: float
    points: np.ndarray
    directors: np.ndarray
    cells: np.ndarray


def read_frames(folder: str | Path, name: str = "series") -> list[Frame]:
    """Frames of a series in the order of their times."""
    # here and below: drawing libraries load only when something is drawn
    import meshio

    return [frame_of(meshio.read(path), time) for time, path in series_files(folder, name)]


def series_files(folder: str | Path, name: str = "series") -> list[tuple[float, Path]]:
    """Times [s] of the frames of a series, rising, and their files."""
    folder = Path(folder)
    found = xml.parse(folder / f"{name}.pvd").getroot().iter("DataSet")
    return sorted((float(one.attrib["timestep"]), folder / one.attrib["file"]) for one in found)


def frame_of(mesh: Any, time: float) -> Frame:
    """Frame of a meshio.Mesh of a series."""
    return Frame(time, mesh.points, mesh.point_data["director"], mesh.cells[0].data)


def draw_clothed(
    axes: Any,
    frame: Frame,
    wearer: Wearer,
    view: tuple[float, float] = VIEW,
    parts: int = 2,
    without: Sequence[str] = (),
    skin: SurfaceMotion | None = None,
) -> np.ndarray:
    """Draw a frame on the wearer, on its skin if there is one.

    without : names of ellipsoids, or of segments of the skin, to leave out

    Returns
    -------
    corners : (n, 3) [m], all that was drawn, for `fit_view`
    """
    body = body_facets(wearer, frame.time, without, skin)
    sides: np.ndarray | bool | None = None
    if frame.cells.shape[1] == 4:
        facets, pieces = smooth(frame.points, frame.directors, frame.cells, parts)
        sides = pieces if parts > 1 else True
    else:
        facets = frame.points[frame.cells[:, :3]]
    size = np.linalg.norm(facets[:, 2] - facets[:, 0], axis=1).mean() * parts
    # cells are flat and the body is round: cloth wins where they are this close
    eye = view_axes(*view)[2]
    solids = [(facing(patch, eye), None, SKIN, SKIN, 0.7 * size) for patch in body]
    draw_surfaces(axes, [(facets, sides, CLOTH, BACK, 0.0), *solids], *view)
    return np.concatenate([frame.points, *(patch.reshape(-1, 3) for patch in body)])


def body_facets(
    wearer: Wearer, time: float, without: Sequence[str] = (), skin: SurfaceMotion | None = None
) -> list[np.ndarray]:
    """Facets (m, 3 | 4, 3) [m] of the parts of the body at a time [s], but `without` some."""
    if skin is not None:
        shown = [name not in without for name in skin.names]
        x = skin.positions(time, np.empty((skin.vertex_count, 3)))
        return [x[skin.triangles[np.array(shown)[skin.owners]]]]
    pose = wearer.new_pose(time)
    return [
        ellipsoid_facets(pose.centres[k], pose.axes[k], wearer.radii[k], 24)
        for k, name in enumerate(wearer.names)
        if name not in without
    ]


def draw_box(
    axes: Any, corner: np.ndarray, size: np.ndarray, view: tuple[float, float] = VIEW
) -> None:
    """A box from its lowest corner (3,) and its size (3,), drawn behind all else."""
    from matplotlib.patches import Polygon

    right, up, _ = view_axes(*view)
    x, y, z = (np.array([corner[c], corner[c] + size[c]]) for c in range(3))
    sides = [
        [(x[0], y[0], z[0]), (x[0], y[1], z[0]), (x[0], y[1], z[1]), (x[0], y[0], z[1])],
        [(x[0], y[0], z[0]), (x[1], y[0], z[0]), (x[1], y[0], z[1]), (x[0], y[0], z[1])],
        [(x[0], y[0], z[1]), (x[1], y[0], z[1]), (x[1], y[1], z[1]), (x[0], y[1], z[1])],
    ]
    for side, shade in zip(np.array(sides), (0.62, 0.75, 0.85), strict=True):
        seen = np.column_stack([side @ right, side @ up])
        axes.add_patch(Polygon(seen, facecolor=(shade,) * 3, edgecolor="0.3", lw=0.5, zorder=0))


def walk_figure(
    path: str | Path,
    wearer: Wearer,
    dressing: list[tuple],
    key_frames: list[Frame],
    curves: list["Curve"],
    joint: str,
    obstacle: tuple[np.ndarray, np.ndarray] | None = None,
    title: str = "",
    skin: SurfaceMotion | None = None,
) -> None:
    """One figure: dressing, key frames, torque about a joint against time and frame.

    Parameters
    ----------
    path : PNG file; wearer : Wearer
    dressing : list of (label, Frame, names left out); key_frames : list of Frame
    curves : list of Curve; joint : str
    obstacle : (corner (3,), size (3,)) [m] or None
    skin : SurfaceMotion or None, drawn in the place of ellipsoids
    """
    from matplotlib.figure import Figure

    view = view_from_the_right(wearer)
    heights = (1, 0.9, 0.9)[-2 if not dressing else -3 :]
    figure = Figure(figsize=(15, 4.3 * sum(heights)), layout="constrained")
    figure.suptitle(title, fontsize=13)
    *above, middle, below = figure.subfigures(len(heights), 1, height_ratios=heights)
    panels = []
    if dressing:
        above[0].suptitle("Dressing", fontsize=10)
        panels = above[0].subplots(1, len(dressing), squeeze=False)[0]
    for axes, (label, frame, without) in zip(panels, dressing, strict=True):
        corners = draw_clothed(axes, frame, wearer, view, without=without, skin=skin)
        fit_view(axes, corners, view)
        axes.set_title(label, fontsize=9)
    rate = wearer.recording.rate
    middle.suptitle("Key frames, with their numbers", fontsize=10)
    panels = middle.subplots(1, len(key_frames), squeeze=False)[0]
    right, up, _ = view_axes(*view)
    for axes, frame in zip(panels, key_frames, strict=True):
        corners = draw_clothed(axes, frame, wearer, view, skin=skin)
        centre = corners.mean(axis=0)
        if obstacle is not None:
            corner, size = obstacle
            if abs(corner[0] + 0.5 * size[0] - centre[0]) < 0.6:
                draw_box(axes, corner, size, view)
        low, high = (corners @ up).min(), (corners @ up).max()
        axes.set_xlim(centre @ right - 0.48, centre @ right + 0.48)
        axes.set_ylim(low - 0.05, max(low + 1.4, high + 0.05))
        axes.set_title(f"{frame_number(frame.time, rate)}", fontsize=9, y=-0.08)
    axes = below.subplots()
    for curve, colour in zip(curves, COLOURS, strict=False):
        draw_curve(axes, curve, colour, 1.2)
    axes.set_xlabel("time [s]")
    axes.set_ylabel(f"torque about the {joint.replace('_', ' ')} [N m],\nflexion positive")
    axes.axhline(0, color="0.6", lw=0.6)
    for frame in key_frames:
        axes.axvline(frame.time, color="0.85", lw=0.8, zorder=0)
    axes.legend(frameon=False)
    twin = axes.secondary_xaxis("top", functions=(lambda t: t * rate, lambda number: number / rate))
    twin.set_xlabel("frame")
    save_figure(figure, Path(path))


def frame_number(time: float, rate: float) -> int:
    """Number of the frame of the recording at a time [s]."""
    return round(time * rate)


def walk_animation(
    path: str | Path,
    wearer: Wearer,
    frames: list[Frame],
    seconds: float,
    obstacle: tuple[np.ndarray, np.ndarray] | None = None,
    skin: SurfaceMotion | None = None,
) -> None:
    """GIF of a walk, the camera moving along; `seconds` between frames."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    images, view = [], view_from_the_right(wearer)
    right, up, _ = view_axes(*view)
    figure = Figure(figsize=(4, 5), dpi=70)
    FigureCanvasAgg(figure)
    axes = figure.add_axes((0, 0, 1, 1))
    for frame in frames:
        for drawn in [*axes.collections, *axes.patches]:
            drawn.remove()
        corners = draw_clothed(axes, frame, wearer, view, parts=1, skin=skin)
        if obstacle is not None:
            draw_box(axes, *obstacle, view)
        centre = corners.mean(axis=0)
        axes.set_xlim(centre @ right - 0.6, centre @ right + 0.6)
        low, high = (corners @ up).min(), (corners @ up).max()
        axes.set_ylim(low - 0.1, max(low + 1.4, high + 0.05))
        axes.set_axis_off()
        figure.canvas.draw()
        images.append(np.asarray(figure.canvas.buffer_rgba())[:, :, :3].copy())
    save_animation(images, Path(path), seconds)


class Curve(NamedTuple):
    """Torque (k,) [N m] about a joint at times (k,) [s].

    error, spread : (k,) [N m], standard error of a mean and spread of its runs, or None
    """

    label: str
    times: np.ndarray
    torque: np.ndarray
    error: np.ndarray | None = None
    spread: np.ndarray | None = None


def curve_of(label: str, rows: list[dict], joint: str) -> Curve:
    """Curve of a joint from rows of torque.csv, or with its band from those of torque_mean.csv."""
    own = [row for row in rows if row["joint"] == joint]
    names = ["time", "torque_flexion"]
    if "standard_error" in own[0]:
        names += ["standard_error", "spread"]
    return Curve(label, *(np.array([row[name] for row in own]) for name in names))


def draw_curve(axes: Any, curve: Curve, colour: str, width: float) -> None:
    """A curve; darker about it the standard error of the mean, lighter the spread of the runs."""
    axes.plot(curve.times, curve.torque, lw=width, label=curve.label, color=colour)
    for reach, alpha in ((curve.spread, 0.15), (curve.error, 0.3)):
        if reach is not None:
            low, high = curve.torque - reach, curve.torque + reach
            axes.fill_between(curve.times, low, high, color=colour, alpha=alpha, lw=0)


def torque_figure(
    path: str | Path, torques: list[tuple], joints: Sequence[str], title: str = ""
) -> None:
    """Flexion torque and power of all joints, a column a joint.

    torques : list of (label, rows as of torque.csv or torque_mean.csv); the latter have a band
    """
    figure, grid = new_figure(1, (14, 5), title, columns=len(joints))
    for axes, joint in zip(np.atleast_1d(grid), joints, strict=True):
        for (label, rows), colour in zip(torques, COLOURS, strict=False):
            draw_curve(axes, curve_of(label, rows, joint), colour, 0.9)
        axes.set_title(joint.replace("_", " "), fontsize=9)
        axes.axhline(0, color="0.6", lw=0.6)
        axes.set_xlabel("time [s]", fontsize=8)
        axes.tick_params(labelsize=7)
    np.atleast_1d(grid)[0].set_ylabel("flexion torque [N m]", fontsize=8)
    np.atleast_1d(grid)[0].legend(frameon=False, fontsize=8)
    save_figure(figure, Path(path))


def draw_all(
    folder: str | Path,
    wearer: Wearer,
    dressing: list[tuple],
    run: str | Path,
    torques: dict[str, list[dict]],
    joint: str,
    title: str,
    count: int = 9,
    skin: SurfaceMotion | None = None,
) -> None:
    """walk.png, torque.png and walk.gif in a folder.

    Parameters
    ----------
    folder : path; wearer : Wearer
    dressing : see `walk_figure`; run : folder with the series to draw
    torques : dict, label -> rows of torque.csv or torque_mean.csv; joint : str, of walk.png
    skin : SurfaceMotion or None, drawn in the place of ellipsoids
    """
    folder = Path(folder)
    frames = [frame for frame in read_frames(run) if frame.time >= wearer.start - 1e-9]
    picked = np.linspace(0, len(frames) - 1, min(count, len(frames))).round().astype(int)
    curves = [curve_of(label, rows, joint) for label, rows in torques.items()]
    box = obstacle_of(wearer.recording)
    keys = [frames[k] for k in picked]
    walk_figure(folder / "walk.png", wearer, dressing, keys, curves, joint, box, title, skin)
    torque_figure(folder / "torque.png", list(torques.items()), wearer.joints)
    seconds = (frames[-1].time - frames[0].time) / max(1, len(frames) - 1)
    walk_animation(folder / "walk.gif", wearer, frames, seconds, box, skin)


def obstacle_of(recording: Recording, width: float = 0.9) -> tuple[np.ndarray, np.ndarray] | None:
    """Lowest corner (3,) and size (3,) [m] of the obstacle of a synthetic walk, or None."""
    facts = recording.facts.get("obstacle")
    if not facts:
        return None
    corner = np.array([facts["front"], -0.5 * width, 0.0])
    return corner, np.array([facts["depth"], width, facts["height"]])
