# SPDX-License-Identifier: LGPL-3.0-or-later
"""The body in its first pose, coloured by the pressure of the clothing, to be turned about."""

from typing import Any

import numpy as np

from contact.geometry.surface_patches import Patches
from shellform.pictures.views import heading_at
from shellform.results.pressure_map import Map, VertexPressure, load
from shellform.scene.wearer import part_of

from .finished_run import FinishedRun
from .packed import packed, rounded_colours, rounded_places
from .walk_frames import DECADES, SHARE, STEP

PARTS = 48  # around an ellipsoid
KINDS = ("mean", "peak")


def read_skin(run: FinishedRun) -> Map | VertexPressure | None:
    """Map of pressure of a run; None where none was asked for."""
    path = run.out / "pressure.npz"
    return load(path) if path.is_file() else None


def unit_sphere(parts: int) -> tuple[np.ndarray, np.ndarray]:
    """Points (k, 3) of a sphere around its first axis, and triangles (t, 3); as report.js has."""
    rows = parts // 2 + 1
    polar = np.linspace(0.0, np.pi, rows)[:, None]
    around = (2 * np.pi * np.arange(parts) / parts)[None, :]
    ring = np.sin(polar)
    points = [np.cos(polar) + 0 * around, ring * np.cos(around), ring * np.sin(around)]
    i, j = np.meshgrid(np.arange(rows - 1), np.arange(parts), indexing="ij")
    a, b = i * parts + j, i * parts + (j + 1) % parts
    lower = np.stack([a, a + parts, b + parts], axis=-1).reshape(-1, 3)
    upper = np.stack([a, b + parts, b], axis=-1).reshape(-1, 3)
    return np.stack(points, axis=-1).reshape(-1, 3), np.concatenate([lower, upper])


def skin_scale(maps: list[Map | VertexPressure]) -> list[float]:
    """Ends of the colours, of the logarithm of pressures in Pa, the same for all runs and kinds."""
    values = np.concatenate([getattr(map, kind) for map in maps for kind in KINDS])
    touched = values[values > 0]
    top = float(np.log10(np.quantile(touched, SHARE))) if len(touched) else 0.0
    return [top - DECADES, top]


def skin_data(run: FinishedRun, map: Map | VertexPressure, ends: list[float]) -> dict[str, Any]:
    """The skin for the page: places (k, 3) of its points, colours, triangles or how many
    ellipsoids they are of; `ends` of the colours.
    """
    if isinstance(map, Map):
        places, values, more = _on_ellipsoids(run, map)
    else:
        places, values = map.vertices, {kind: getattr(map, kind) for kind in KINDS}
        more = {"triangles": packed(map.triangles.astype(np.int32))}
    origin = 0.5 * (places.min(axis=0) + places.max(axis=0)) * (1.0, 1.0, 0.0)
    ahead = heading_at(run.wearer, run.wearer.start)
    with np.errstate(divide="ignore", invalid="ignore"):
        logs = {kind: np.where(own > 0, np.log10(own), np.nan) for kind, own in values.items()}
    return {
        "step": STEP,
        "places": packed(rounded_places(places - origin, STEP)),
        **more,
        "colours": {kind: packed(rounded_colours(own, *ends)) for kind, own in logs.items()},
        "heading": ahead / max(float(np.linalg.norm(ahead)), 1e-300),
        "seconds": map.seconds,
    }


def _on_ellipsoids(run, map):
    """Points (k, 3) of the ellipsoids in the first pose, pressures there, and how many they are."""
    wearer = part_of(run.scene, run.wearer, map.names)
    pose, patches = wearer.new_pose(wearer.start), Patches(map.radii, map.size)
    local = [unit_sphere(PARTS)[0] * radii for radii in map.radii]
    places = [pose.centres[b] + own @ pose.axes[b] for b, own in enumerate(local)]
    values = {
        kind: np.concatenate(
            [patches.values(b, own, getattr(map, kind)) for b, own in enumerate(local)]
        )
        for kind in KINDS
    }
    return np.concatenate(places), values, {"parts": PARTS, "ellipsoids": len(map.radii)}
