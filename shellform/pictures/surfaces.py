# SPDX-License-Identifier: LGPL-3.0-or-later
"""Pictures of surfaces: parallel projection, near cells drawn over far ones.

matplotlib only, no finite elements: pictures can be drawn anywhere from the files of a run.
"""

import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

CLOTH, BACK, EDGE = "#7aa6c2", "#c9b79c", "#1f3440"
LINE_WIDTH = 0.45  # of the cells' sides [pt]


def view_axes(azimuth: float, elevation: float) -> np.ndarray:
    """Right, up and towards-the-eye unit vectors (3, 3) of a parallel view; angles in degrees."""
    a, e = np.radians([azimuth, elevation])
    eye = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
    right = np.array([-np.sin(a), np.cos(a), 0.0])
    return np.array([right, np.cross(eye, right), eye])


def smooth(
    points: np.ndarray, directors: np.ndarray, cells: np.ndarray, parts: int
) -> tuple[np.ndarray, np.ndarray]:
    """Cells cut into parts x parts facets that follow the directors.

    Between two nodes the surface bulges by a (1 - a) (dx . dd) d / 2: the arc whose length the
    membrane strain measures, not its chord.

    Parameters
    ----------
    points, directors : (n, 3); cells : (m, 4) quads in cyclic order; parts : int

    Returns
    -------
    facets : (m parts^2, 4, 3); sides : (k, 2, 3), pieces of the cells' sides, each side once
    """
    x, d = points[cells], directors[cells]
    a = np.linspace(0, 1, parts + 1)
    A, B = np.meshgrid(a, a, indexing="ij")
    shape = np.stack([(1 - A) * (1 - B), A * (1 - B), A * B, (1 - A) * B])
    place = np.einsum("kab,mki->mabi", shape, x)
    normal = np.einsum("kab,mki->mabi", shape, d)

    def bulge(i, j):
        return 0.5 * np.sum((x[:, j] - x[:, i]) * (d[:, j] - d[:, i]), axis=1)[:, None, None]

    along = A * (1 - A) * ((1 - B) * bulge(0, 1) + B * bulge(3, 2))
    across = B * (1 - B) * ((1 - A) * bulge(0, 3) + A * bulge(1, 2))
    place += (along + across)[..., None] * normal
    corners = [place[:, :-1, :-1], place[:, 1:, :-1], place[:, 1:, 1:], place[:, :-1, 1:]]
    facets = np.stack(corners, axis=3).reshape(-1, 4, 3)
    borders = np.concatenate([place[:, :, 0], place[:, :, -1], place[:, 0], place[:, -1]])
    ends = np.concatenate([cells[:, pair] for pair in ([0, 1], [3, 2], [0, 3], [1, 2])])
    once = np.unique(np.sort(ends, axis=1), axis=0, return_index=True)[1]
    sides = np.stack([borders[once, :-1], borders[once, 1:]], axis=2).reshape(-1, 2, 3)
    return facets, sides


def facing(facets: np.ndarray, eye: np.ndarray) -> np.ndarray:
    """Of the facets (m, k, 3) of a closed surface those that look at the eye (3,)."""
    normal = np.cross(facets[:, 2] - facets[:, 0], facets[:, -1] - facets[:, 1])
    return facets[normal @ eye > 0]


def facets_and_sides(
    points: np.ndarray, directors: np.ndarray, cells: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Facets to draw and the cells' sides, for cells with 3, 4 or 9 nodes."""
    if cells.shape[1] == 4:
        return smooth(points, directors, cells, 4 if len(cells) < 2000 else 1)
    rings = {3: [[0, 1, 2]], 9: [[0, 4, 8, 7], [4, 1, 5, 8], [8, 5, 2, 6], [7, 8, 6, 3]]}
    rims = {3: [0, 1, 2, 0], 9: [0, 4, 1, 5, 2, 6, 3, 7, 0]}
    facets = np.concatenate([points[cells[:, ring]] for ring in rings[cells.shape[1]]])
    rim = points[cells[:, rims[cells.shape[1]]]]
    return facets, np.stack([rim[:, :-1], rim[:, 1:]], axis=2).reshape(-1, 2, 3)


def colour_of(name: str | np.ndarray) -> np.ndarray:
    """Red, green, blue (3,) from 0 to 1 of a colour #rrggbb; arrays are taken as they are."""
    if not isinstance(name, str):
        return name
    return np.array([int(name[i : i + 2], 16) for i in (1, 3, 5)]) / 255


def seen_surfaces(
    surfaces: Sequence[tuple], view: np.ndarray
) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]]:
    """Of each surface, see `draw_surfaces`, what is seen in the axes (3, 3) of a view.

    Facets (m, k, 3) and sides (s, 2, 3) in these axes, colours (m, 3) of the facets, and how near
    to the eye facets (m,) and sides (s,) are.
    """
    light = view.T @ np.array([-0.3, 0.5, 0.8]) / np.linalg.norm([-0.3, 0.5, 0.8])
    for facets, sides, front, back, away in surfaces:
        # by diagonals: a side may have no length, as at the poles of an ellipsoid
        normal = np.cross(facets[:, 2] - facets[:, 0], facets[:, -1] - facets[:, 1])
        normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
        shade = 0.5 + 0.5 * np.abs(normal @ light)
        front_seen = (normal @ view[2] >= 0)[:, None]
        colour = np.where(front_seen, colour_of(front), colour_of(back)) * shade[:, None]
        seen = facets @ view.T
        lines = np.empty((0, 2, 3)) if sides is None or sides is True else sides @ view.T
        # a side lies in its facets: bring it before them, not before the next cell
        before = 0.5 * np.ptp(lines, axis=1).max() if len(lines) else 0.0
        yield (
            seen,
            colour,
            lines,
            seen[:, :, 2].mean(axis=1) - away,
            lines[:, :, 2].mean(axis=1) + before,
        )


def draw_surfaces(
    axes: Any, surfaces: Sequence[tuple], azimuth: float = -60.0, elevation: float = 25.0
) -> None:
    """Draw shaded surfaces, hidden parts hidden.

    Parameters
    ----------
    axes : matplotlib axes
    surfaces : list of (facets (m, k, 3), sides (s, 2, 3), True for the facets' own outlines, or
        None, front colour, back colour, back)
        A facet shows its front colour where its normal looks at the eye; colours are #rrggbb, or
        (m, 3), one a facet. `back` [m] moves a surface away from the eye when it is decided what
        hides what, as for a body under a cloth.
    azimuth, elevation : float, degrees
    """
    from matplotlib.collections import PolyCollection

    polygons: list[np.ndarray] = []
    faces, edges, depths = [], [], []
    edge = np.append(colour_of(EDGE), 1.0)
    view = view_axes(azimuth, elevation)
    for surface, parts in zip(surfaces, seen_surfaces(surfaces, view), strict=True):
        seen, shades, sides, depth, side_depth = parts
        polygons.extend(seen[:, :, :2])
        colour = np.column_stack([shades, np.ones(len(shades))])
        faces.append(colour)
        edges.append(np.tile(edge, (len(seen), 1)) if surface[1] is True else colour)
        depths.append(depth)
        if len(sides):
            polygons.extend(sides[:, :, :2])
            faces.append(np.zeros((len(sides), 4)))
            edges.append(np.tile(edge, (len(sides), 1)))
            depths.append(side_depth)
    order = np.argsort(np.concatenate(depths), kind="stable")
    collection = PolyCollection(
        [polygons[i] for i in order],
        facecolors=np.concatenate(faces)[order],
        edgecolors=np.concatenate(edges)[order],
        linewidths=LINE_WIDTH,
        closed=False,
        joinstyle="round",
    )
    axes.add_collection(collection)
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.set_axis_off()


def new_figure(
    rows: int,
    size: tuple[float, float],
    title: str,
    columns: int = 1,
    dpi: int = 130,
    **layout: Any,
) -> tuple[Any, Any]:
    """Figure without a window, and its axes."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, dpi=dpi, layout="constrained")
    FigureCanvasAgg(figure)
    if title:
        figure.suptitle(title, fontsize=11)
    return figure, figure.subplots(rows, columns, gridspec_kw=layout)


def save_figure(figure: Any, path: str | Path) -> None:
    """Write a PNG atomically."""
    path = Path(path)
    part = path.with_name(path.name + ".part")
    figure.savefig(part, format="png")
    os.replace(part, path)


def ellipsoid_facets(
    centre: np.ndarray, axes: np.ndarray, radii: np.ndarray, parts: int = 32
) -> np.ndarray:
    """Facets (m, 4, 3) of an ellipsoid; axes are rows."""
    polar = np.linspace(0, np.pi, parts // 2 + 1)[:, None]
    around = np.linspace(0, 2 * np.pi, parts + 1)[None, :]
    unit = np.stack(
        [
            np.sin(polar) * np.cos(around),
            np.sin(polar) * np.sin(around),
            np.cos(polar) + 0 * around,
        ],
        axis=-1,
    )
    p = np.asarray(centre) + (unit * radii) @ np.asarray(axes)
    return np.stack([p[:-1, :-1], p[1:, :-1], p[1:, 1:], p[:-1, 1:]], axis=2).reshape(-1, 4, 3)


def ellipsoid_outline(
    centre: np.ndarray, axes: np.ndarray, radii: np.ndarray, eye: np.ndarray, parts: int = 100
) -> np.ndarray:
    """Outline (parts, 3) of an ellipsoid seen along `eye` (3,); axes are rows."""
    towards = np.asarray(axes) @ eye / radii
    first = np.cross(towards, np.eye(3)[np.abs(towards).argmin()])
    first /= np.linalg.norm(first)
    second = np.cross(towards / np.linalg.norm(towards), first)
    angle = np.linspace(0, 2 * np.pi, parts)[:, None]
    return centre + (radii * (np.cos(angle) * first + np.sin(angle) * second)) @ np.asarray(axes)


def save_image(image: np.ndarray, path: str | Path) -> None:
    """Write a PNG atomically; image : (rows, columns, 3) uint8."""
    from PIL import Image

    path = Path(path)
    part = path.with_name(path.name + ".part")
    Image.fromarray(image).save(part, format="PNG")
    os.replace(part, path)


def save_animation(images: list[np.ndarray], path: Path, seconds: float) -> None:
    """Write a GIF atomically; images are (rows, columns, 3) uint8, `seconds` apart."""
    from PIL import Image

    part = path.with_name(path.name + ".part")
    # by octrees: a median cut takes five times as long as drawing the picture
    octree = Image.Quantize.FASTOCTREE
    first, *rest = [Image.fromarray(image).quantize(256, method=octree) for image in images]
    first.save(
        part, format="GIF", save_all=True, append_images=rest, duration=1000 * seconds, loop=0
    )
    os.replace(part, path)
