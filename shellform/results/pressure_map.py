# SPDX-License-Identifier: LGPL-3.0-or-later
"""What was felt on the skin, on ellipsoids or on triangles: its numbers and its files.

`Pressure` (skin_pressure.py) finds a `Map`, `SurfacePressure` (surface_pressure.py) a
`VertexPressure`. Both are written as pressure.npz, the second also for ParaView.
"""

import os
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np


class Map(NamedTuple):
    """What P patches have felt; see `Patches` for where they are.

    names : ellipsoids; radii (m, 3), size [m] : arguments of `Patches`
    owner (P,), centres (P, 3) [m], areas (P,) [m^2] : of the patches
    mean : (P,), mean pressure [Pa]; peak : (P,), greatest mean of a window [Pa]; peak_time : (P,),
        end of that window [s]
    rubbing : (P,), mean size of the tangential force by area [Pa]
    share : (P,), part of time and area in contact, by the area at rest of the cloth that touches;
        cloth that rattles counts in the steps in which it touches
    seconds : float, time covered [s]
    """

    names: tuple
    radii: np.ndarray
    size: float
    owner: np.ndarray
    centres: np.ndarray
    areas: np.ndarray
    mean: np.ndarray
    peak: np.ndarray
    peak_time: np.ndarray
    rubbing: np.ndarray
    share: np.ndarray
    seconds: float


class VertexPressure(NamedTuple):
    """What the nv vertices of a surface have felt.

    names : segments; owner (nv,) : which of them a vertex belongs to
    vertices (nv, 3) [m], at the first record; triangles (nt, 3); areas (nv,) [m^2]
    mean : (nv,), mean pressure [Pa]; peak : (nv,), greatest mean of a window [Pa]; peak_time :
        (nv,), end of that window [s], not a number where nothing pressed
    rubbing : (nv,), mean size of the tangential force by area [Pa]
    share : (nv,), part of time and area in contact, by the area at rest of the cloth that touches;
        over 1 where that of a node is larger than the vertex's, or cloth lies double
    seconds : float, time covered [s]
    """

    names: tuple
    owner: np.ndarray
    vertices: np.ndarray
    triangles: np.ndarray
    areas: np.ndarray
    mean: np.ndarray
    peak: np.ndarray
    peak_time: np.ndarray
    rubbing: np.ndarray
    share: np.ndarray
    seconds: float


def save(path: str | Path, map: Map | VertexPressure) -> None:
    """Write a map as .npz, one array a field, atomically."""
    path = Path(path)
    part = path.with_name(path.name + ".part")
    with open(part, "wb") as file:
        np.savez_compressed(file, **map._asdict())
    os.replace(part, path)


def load(path: str | Path) -> Map | VertexPressure:
    """The map in a file that `save` wrote.

    Raises
    ------
    ValueError for a file that holds no map
    """
    with np.load(path) as file:
        kind = VertexPressure if "triangles" in file.files else Map
        missing = set(kind._fields) - set(file.files)
        if missing:
            raise ValueError(f"{path} holds no map of pressure: it has no '{min(missing)}'")
        fields = {name: file[name] for name in kind._fields}
    fields["names"] = tuple(fields["names"].tolist())
    numbers = {name: float(fields[name]) for name in ("size", "seconds") if name in fields}
    return kind(**fields | numbers)


def write(path: str | Path, found: VertexPressure) -> None:
    """Write what was found for ParaView (.vtu, .vtp by the ending of the path), through meshio."""
    import meshio  # pictures and exports alone need it

    data = {"pressure_Pa": found.mean, "peak_Pa": found.peak, "rubbing_Pa": found.rubbing}
    data |= {"share": found.share, "segment": found.owner}
    meshio.Mesh(found.vertices, [("triangle", found.triangles)], point_data=data).write(path)


def summary(map: Map | VertexPressure) -> dict[str, dict[str, Any]]:
    """Part of the body -> mean normal force [N], peak pressure [Pa], its place, time, contact area.

    The place is that of a patch from the centre of the ellipsoid in its segment's axes [m], or the
    number of a vertex; place and time are None where nothing touched. Contact area [m^2] is a mean
    over time.
    """
    found = {}
    for b, name in enumerate(map.names):
        own = np.flatnonzero(map.owner == b)
        if not len(own):
            continue
        k = own[map.peak[own].argmax()]
        touched = map.peak[k] > 0
        if isinstance(map, Map):
            place = {"peak_place": map.centres[k].tolist() if touched else None}
        else:
            place = {"peak_vertex": int(k) if touched else None}
        found[name] = {
            "normal_force": float(np.sum(map.mean[own] * map.areas[own])),
            "peak_pressure": float(map.peak[k]),
            **place,
            "peak_time": float(map.peak_time[k]) if touched else None,
            "contact_area": float(np.sum(map.share[own] * map.areas[own])),
        }
    return found
