# SPDX-License-Identifier: LGPL-3.0-or-later
"""The frames of a walk as small arrays: where cloth and body are, and what cloth is coloured by.

Places are told from a point that moves along with the wearer on the floor, so that the view does.
Cells are drawn as triangles between their corners. Colours of a frame are

    pressure   contact pressure at the nodes [Pa], a mean since the frame before
    stretch    largest elongation along the edges of a cell, of arcs, not chords
    wrinkles   strain that wrinkles smaller than a cell take up, of relaxed cloth

Frames are left out evenly where all of them would make the page too large.
"""

from typing import Any, NamedTuple

import numpy as np

from shellform.fem.arc import sides_at_rest
from shellform.motion.wearer import Wearer
from shellform.pictures.views import heading_at
from shellform.pictures.walk import obstacle_of, series_files
from shellform.results.stretch import stretch_of_cells
from shellform.scene.garment import garment_of

from .finished_run import FinishedRun
from .packed import packed, rounded_colours, rounded_places

STEP = 1e-4  # of places [m]
MOST = 6e6  # characters of all runs together
DECADES = 3.0  # of pressure, below the greatest: a belt presses a thousand times harder than a leg
SHARE = 0.99  # of the values that a scale reaches to


class Walk(NamedTuple):
    """Frames (F) of a run with n nodes, m cells, b ellipsoids.

    times (F,) [s]; places (F, n, 3), origins (F, 3) [m], what they are told from
    cells (m, c); pressure (F, n) [Pa]; stretch (F, m) or None; wrinkles (F, m) or None
    centres (F, b, 3), axes (F, b, 3, 3) : pose of the body, in the world
    skin (F, v, 3) : vertices of a body of triangles, in the world, or None; skin_triangles (t, 3)
    all_frames : how many the series has
    """

    times: np.ndarray
    places: np.ndarray
    origins: np.ndarray
    cells: np.ndarray
    pressure: np.ndarray
    stretch: np.ndarray | None
    wrinkles: np.ndarray | None
    centres: np.ndarray
    axes: np.ndarray
    skin: np.ndarray | None
    skin_triangles: np.ndarray
    all_frames: int


def read_walk(run: FinishedRun, most: float = MOST) -> Walk | None:
    """Frames of a run from its series, in at most that many characters; None without a series."""
    # only here: a library that reads files loads only when one is read
    import meshio

    if not (run.out / "series.pvd").is_file():
        return None
    files = [one for one in series_files(run.out) if one[0] >= run.wearer.start - 1e-9]
    if not files:
        return None
    first = meshio.read(files[0][1])
    cells = first.cells[0].data
    skin = run.skin
    size = (7 * len(first.points) + 2 * len(cells)) * 4 / 3
    if skin is not None:
        size += 6 * skin.vertex_count * 4 / 3
    count = int(np.clip(most // size, 2, len(files)))
    picked = np.unique(np.linspace(0, len(files) - 1, count).round().astype(int))
    meshes = [meshio.read(files[k][1]) for k in picked]
    times = np.array([files[k][0] for k in picked])
    places = np.array([mesh.points for mesh in meshes])
    poses = [run.wearer.new_pose(time) for time in times]
    centres, axes = (np.array([getattr(pose, name) for pose in poses]) for name in Pose)
    origins = centres[:, _middle(run.wearer)] * (1.0, 1.0, 0.0)
    return Walk(
        times, places, origins, cells, _pressures(meshes), _stretches(run, meshes),
        _wrinkles(meshes), centres, axes, _skin_places(skin, times),
        np.zeros((0, 3), np.int64) if skin is None else skin.triangles, len(files),
    )  # fmt: skip


def _skin_places(skin, times):
    """Vertices (F, v, 3) of a skin, None without one."""
    if skin is None:
        return None
    return np.array([skin.positions(time, np.empty((skin.vertex_count, 3))) for time in times])


Pose = ("centres", "axes")


def _middle(wearer: Wearer) -> int:
    """The ellipsoid that the view follows."""
    return wearer.names.index("pelvis") if "pelvis" in wearer.names else 0


def _pressures(meshes):
    return np.array(
        [
            mesh.point_data.get("contact_pressure", np.zeros(len(mesh.points))).ravel()
            for mesh in meshes
        ]
    )


def _wrinkles(meshes):
    """Strain of the wrinkles by cell, 0 where cloth is taut; None where it is not relaxed."""
    if any("wrinkle_strain" not in mesh.cell_data for mesh in meshes):
        return None
    return np.array([_of_wrinkled(mesh.cell_data) for mesh in meshes])


def _of_wrinkled(data):
    return np.where(data["wrinkling"][0] > 0, data["wrinkle_strain"][0], 0.0)


def _stretches(run, meshes):
    """Elongation by cell (F, m); None where the garment's own shape is at hand no more."""
    try:
        surface = garment_of(run.scene, run.wearer)
    except (ValueError, OSError):
        return None
    cells = meshes[0].cells[0].data
    if surface.points.shape != meshes[0].points.shape or surface.cells.shape != cells.shape:
        return None
    at_rest = sides_at_rest(surface)
    return np.array(
        [
            stretch_of_cells(mesh.points, mesh.point_data["director"], surface, at_rest)
            for mesh in meshes
        ]
    )


def triangles_of(cells: np.ndarray) -> np.ndarray:
    """Triangles (k, 3) of cells (m, 3 | 4 | 9) between their corners, those of a cell together."""
    if cells.shape[1] == 3:
        return cells
    return cells[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)


def scales(walks: list[Walk]) -> dict[str, list[float]]:
    """Low and high end of each colour, the same for all runs: what SHARE of the values is below.

    That of pressure is the logarithm to base ten of pressures in Pa.
    """
    found = {}
    pressure = _of_all([walk.pressure for walk in walks], 1e-3)
    top = float(np.log10(pressure)) if pressure else 0.0
    found["pressure"] = [top - DECADES, top]
    for name in ("stretch", "wrinkles"):
        fields = [getattr(walk, name) for walk in walks]
        given = [field for field in fields if field is not None]
        if given:
            found[name] = [0.0, max(_of_all(given, 1e-4), 1e-3)]
    return found


def _of_all(fields, least):
    values = np.concatenate([field[field > least] for field in fields])
    return float(np.quantile(values, SHARE)) if len(values) else 0.0


def walk_data(run: FinishedRun, walk: Walk, ends: dict[str, list[float]]) -> dict[str, Any]:
    """A walk for the page; `ends` : see `scales`."""
    with np.errstate(divide="ignore"):
        pressure = np.where(walk.pressure > 0, np.log10(walk.pressure), np.nan)
    colours = {"pressure": packed(rounded_colours(pressure, *ends["pressure"]))}
    for name in ("stretch", "wrinkles"):
        field = getattr(walk, name)
        if field is not None:
            colours[name] = packed(rounded_colours(field, *ends[name]))
    box = obstacle_of(run.wearer.recording)
    ahead = heading_at(run.wearer, run.wearer.start)
    skin = {}
    if walk.skin is not None:
        own = rounded_places(walk.skin - walk.origins[:, None], STEP)
        skin = {"skin": packed(own), "skin_triangles": packed(walk.skin_triangles.astype(np.int32))}
    return {
        "times": walk.times,
        "frames_of_series": walk.all_frames,
        "step": STEP,
        "places": packed(rounded_places(walk.places - walk.origins[:, None], STEP)),
        "origins": packed(walk.origins.astype(np.float32)),
        "triangles": packed(triangles_of(walk.cells).astype(np.int32)),
        "triangles_per_cell": 1 if walk.cells.shape[1] == 3 else 2,
        "colours": colours,
        "heading": ahead / max(float(np.linalg.norm(ahead)), 1e-300),
        "radii": run.wearer.radii,
        "centres": packed((walk.centres - walk.origins[:, None]).astype(np.float32)),
        "axes": packed(walk.axes.astype(np.float32)),
        **skin,
        "obstacle": None if box is None else {"corner": box[0], "size": box[1]},
    }
