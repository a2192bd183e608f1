# SPDX-License-Identifier: LGPL-3.0-or-later
"""A body of the user's own: a closed mesh of one who stands upright, and the centres of its joints.

A TOML file names both, the joints in the axes and unit of the mesh:

    file = "scan.ply"           # or .obj, .stl, .glb, .off
    unit = "mm"
    stature_m = 1.78            # where the mesh lacks the head
    [joints]
    right_hip = [91.0, 10.0, 902.0]
    right_knee = [95.0, 8.0, 480.0]
    right_ankle = [93.0, 40.0, 78.0]
    left_hip = [-92.0, 9.0, 903.0]      # and so on

Which way is up, left and forward follows from the joints: up from ankles to hips, left from the
right hip to the left one.
"""

import tomllib
from pathlib import Path

import numpy as np

from contact.geometry.triangle_mesh.closed import closed_surface
from meshes.files.load import UNITS
from meshes.files.readers import read_mesh
from meshes.geometry import diagonal, joined
from meshes.topology import cut_quads
from shellform.motion.proportions import LEG_OF_STATURE
from shellform.motion.recording import SIDES

from .surface import JOINTS, BodySurface

KEYS = ("file", "unit", "stature_m", "joints")
LEG = (0.45, 1.35)  # of grown persons, hip to ankle [m]
SAME = 1e-7  # of the size, within which points of a format without shared ones are one


def scan(path: str | Path) -> BodySurface:
    """The body of a TOML file.

    Raises
    ------
    ValueError, MeshError, FileNotFoundError : a sentence for a file or key that is missing or
        unknown, a mesh that is open or none, a joint outside of it, legs of no person
    """
    path = Path(path)
    table = _table(path)
    unit = table.get("unit", "m")
    if unit not in UNITS:
        raise ValueError(f"{path}: unit is one of {', '.join(UNITS)}, not {unit!r}")
    joints = {name: UNITS[unit] * _point(path, table, name) for name in JOINTS}
    legs = [np.linalg.norm(joints[f"{side}_hip"] - joints[f"{side}_ankle"]) for side in SIDES]
    if not LEG[0] < min(legs) <= max(legs) < LEG[1]:
        raise ValueError(
            f"{path}: from hip to ankle are {legs[0]:.3g} and {legs[1]:.3g} m when read in "
            f"'{unit}', which no leg is: set unit to that of the joints"
        )
    mesh = path.parent / table["file"]
    points, triangles = _closed(mesh, UNITS[unit])
    for name, joint in joints.items():
        if abs(turns_around(points, triangles, joint)) < 0.5:
            place = ", ".join(f"{value:.4g}" for value in joint / UNITS[unit])
            raise ValueError(
                f"{path}: {name} at ({place}) {unit} is outside of {mesh.name}: give the centre of "
                "the joint in the axes and the unit of the mesh"
            )
    axes = _axes(joints)
    points, joints = points @ axes.T, {name: axes @ joint for name, joint in joints.items()}
    stature = table.get("stature_m")
    if stature is None:
        # a scan may end below the head
        stature = max(np.ptp(points[:, 2]), np.mean(_lengths(joints)) / LEG_OF_STATURE)
    return BodySurface(points, triangles, joints, float(stature), mesh.name)


def _table(path):
    if not path.is_file():
        raise FileNotFoundError(f"{path}: there is no such file, which would describe a body")
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ValueError(
            f"{path}: not a TOML file ({error}); name one with the keys {', '.join(KEYS)}, which "
            "names the mesh in turn"
        ) from None
    unknown = [key for key in table if key not in KEYS]
    if unknown:
        raise ValueError(f"{path}: unknown key '{unknown[0]}'; there are {', '.join(KEYS)}")
    if not isinstance(table.get("file"), str):
        raise ValueError(f"{path}: file is the name of a mesh, as 'scan.ply'")
    return table


def _point(path, table, name):
    value = table.get("joints", {}).get(name)
    try:
        point = np.array(value, float)
    except (TypeError, ValueError):
        point = np.zeros(0)
    if point.shape != (3,) or not np.isfinite(point).all():
        raise ValueError(
            f"{path}: [joints] {name} is a point, as {name} = [90.0, 10.0, 900.0], not {value!r}; "
            f"needed are {', '.join(JOINTS)}"
        )
    return point


def _closed(path, scale):
    """Points [m] and outward triangles of a closed mesh."""
    mesh = read_mesh(path)
    points = np.array(mesh.points, float)
    triangles = []
    for block in mesh.cells:
        corners = np.asarray(block.data, np.int64)
        if corners.ndim != 2 or corners.shape[1] not in (3, 4):
            raise ValueError(
                f"{path.name}: faces of a kind '{block.type}' are none of triangles and quads: "
                "split them into triangles"
            )
        if corners.shape[1] == 4:
            corners = cut_quads(corners, np.zeros(len(corners), bool))
        triangles.append(corners)
    corners = np.concatenate(triangles) if triangles else np.zeros((0, 3), np.int64)
    # formats without shared points give each triangle its own
    label = joined(points, SAME * diagonal(points))
    corners = label[corners]
    distinct = (corners != np.roll(corners, 1, axis=1)).all(axis=1)
    used, inverse = np.unique(corners[distinct], return_inverse=True)
    return closed_surface(scale * points[used], inverse.reshape(-1, 3), path.name)


def turns_around(points: np.ndarray, triangles: np.ndarray, at: np.ndarray) -> float:
    """Winding number of outward triangles about a point (3,): 1 inside, 0 outside.

    Solid angles by van Oosterom and Strackee, IEEE Trans. Biomed. Eng. 30, 1983, 125.
    """
    a, b, c = (points[triangles[:, k]] - at for k in range(3))
    la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    triple = np.einsum("ij,ij->i", a, np.cross(b, c))
    dots = la * lb * lc + sum(
        np.einsum("ij,ij->i", p, q) * r for p, q, r in ((a, b, lc), (b, c, la), (c, a, lb))
    )
    return float(np.sum(np.arctan2(triple, dots)) / (2.0 * np.pi))


def _axes(joints):
    """Rows forward, left, up."""
    middle = {
        name: 0.5 * (joints[f"right_{name}"] + joints[f"left_{name}"]) for name in ("hip", "ankle")
    }
    up = middle["hip"] - middle["ankle"]
    up /= np.linalg.norm(up)
    left = joints["left_hip"] - joints["right_hip"]
    left = left - (left @ up) * up
    left /= np.linalg.norm(left)
    return np.stack([np.cross(left, up), left, up])


def _lengths(joints):
    """Lengths [m] of both legs, thigh and shank."""
    return [
        np.linalg.norm(joints[f"{side}_hip"] - joints[f"{side}_knee"])
        + np.linalg.norm(joints[f"{side}_knee"] - joints[f"{side}_ankle"])
        for side in SIDES
    ]
