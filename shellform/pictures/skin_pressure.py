# SPDX-License-Identifier: LGPL-3.0-or-later
"""The pressure of the cloth on the skin as a picture, on ellipsoids and on triangles.

Skin that nothing touched is grey. A belt presses a thousand times harder than a leg of the
trousers: the scale is logarithmic. It ends at what 99 % of the area touched stay below and begins
at a thousandth of that.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from contact.body.segments import Body
from contact.geometry.surface_patches import Patches
from shellform.motion.wearer import Wearer
from shellform.results.pressure_map import Map, VertexPressure

from .surfaces import ellipsoid_facets, new_figure, save_figure, view_axes
from .views import fit_view, heading_at

# degrees by which the eye goes around from the front, to the wearer's left
SIDES = {"front": 0.0, "left": 90.0, "back": 180.0, "right": -90.0}


def pressure_figure(
    path: str | Path,
    wearer: Body | Wearer,
    map: Map | VertexPressure,
    time: float,
    title: str = "",
    sides: Sequence[str] = ("front", "back"),
    top: float | None = None,
) -> None:
    """The body from some of SIDES, coloured by the mean pressure of the clothing.

    Parameters
    ----------
    path : PNG file
    wearer : Wearer, or Body with names and radii of the map; of triangles any that faces ahead
    map : of results.pressure_map
    time : float, of the pose of ellipsoids [s]; triangles are drawn as they stand in the map
    sides : names in SIDES; top : end of the scale [Pa], None: as above

    Raises
    ------
    ValueError for the map of another body
    """
    ahead = heading_at(wearer, time)
    if isinstance(map, VertexPressure):
        facets, pressures = map.vertices[map.triangles], map.mean[map.triangles].mean(axis=1)
        most = f"most at a vertex: {map.mean.max():.4g} Pa"
    else:
        facets, pressures = _on_ellipsoids(wearer, map, time)
        most = f"most on a patch of {100 * map.size:.3g} cm: {map.mean.max():.4g} Pa"
    top = _end_of_scale(map) if top is None else top
    note = f"mean pressure [Pa] over {map.seconds:.3g} s; {most}"
    _draw(path, facets, pressures, np.degrees(np.arctan2(*ahead[1::-1])), top, note, title, sides)


def _on_ellipsoids(wearer, map, time):
    """Facets (F, 4, 3) that are not inside another ellipsoid, and their pressures (F,)."""
    same = tuple(wearer.names) == map.names and np.allclose(wearer.radii, map.radii, rtol=1e-6)
    if not same:
        raise ValueError(
            f"the map is of {', '.join(map.names)}, not of this wearer's ellipsoids "
            f"{', '.join(wearer.names)} or not of their size: draw it on the wearer of its run"
        )
    pose, patches = wearer.new_pose(time), Patches(map.radii, map.size)
    facets, pressures, ring = [], [], [1, 2, 0]
    for b, radii in enumerate(map.radii):
        # around e1, as the patches are
        local = ellipsoid_facets(np.zeros(3), np.eye(3)[ring], radii[ring], 72)
        own = pose.centres[b] + local @ pose.axes[b]
        seen = np.ones(len(own), bool)
        for other in set(range(len(map.radii))) - {b}:
            within = (own - pose.centres[other]) @ pose.axes[other].T / map.radii[other]
            seen &= (np.sum(within**2, axis=-1) > 1).any(axis=1)
        facets.append(own[seen])
        pressures.append(patches.values(b, local[seen].mean(axis=1), map.mean))
    return np.concatenate(facets), np.concatenate(pressures)


def _draw(path, facets, pressures, front, top, note, title, sides):
    """Facets (F, 3 or 4, 3) from `sides` of one who faces `front` [degrees]."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.collections import PolyCollection
    from matplotlib.colors import LogNorm

    # across a facet: its diagonals, or two sides of a triangle
    normal = np.cross(facets[:, 2] - facets[:, 0], facets[:, -1] - facets[:, 1])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    colours = ScalarMappable(LogNorm(1e-3 * top, top, clip=True), "YlOrRd")
    faces = colours.to_rgba(np.maximum(pressures, 1e-3 * top))
    faces[pressures <= 0] = (0.84, 0.85, 0.86, 1.0)
    figure, panels = new_figure(
        1, (9, 8) if len(sides) < 3 else (11, 4.8), title, columns=len(sides)
    )
    for axes, label in zip(np.atleast_1d(panels), sides, strict=True):
        turn = SIDES[label]
        view = view_axes(front + turn, 5.0)
        near = normal @ view[2] > 0
        order = np.flatnonzero(near)[np.argsort(facets[near].mean(axis=1) @ view[2])]
        shown = faces[order]
        shown[:, :3] *= (0.75 + 0.25 * normal[order] @ view[2])[:, None]
        axes.add_collection(
            PolyCollection(
                facets[order] @ view[:2].T, facecolors=shown, edgecolors=shown, linewidths=0.3
            )
        )
        fit_view(axes, facets.reshape(-1, 3), (front + turn, 5.0))
        axes.set_aspect("equal")
        axes.set_axis_off()
        axes.set_title(label, fontsize=10)
    bar = figure.colorbar(colours, ax=panels, shrink=0.6, extend="both")
    bar.set_label(note, fontsize=10 if len(sides) < 3 else 7)
    save_figure(figure, Path(path))


def _end_of_scale(map):
    """Mean pressure that 99 % of the area touched stay below [Pa]."""
    touched = np.flatnonzero(map.mean > 0)
    if not len(touched):
        return 1.0
    touched = touched[np.argsort(map.mean[touched])]
    area = np.cumsum(map.areas[touched])
    return map.mean[touched[np.searchsorted(area, 0.99 * area[-1])]]
