# SPDX-License-Identifier: LGPL-3.0-or-later
"""glTF 2.0 files, .glb and .gltf: all triangles of the scene, in its own frame.

The format says what others leave open: metres, y up, the front towards +z. So a file is turned into
the frame used here, x forward, y left, z up. Points are repeated there wherever texture or normal
changes; equal ones are joined. Specification: registry.khronos.org/glTF/specs/2.0.
"""

from __future__ import annotations

import base64
import json
from pathlib import Path
from typing import Any

import numpy as np

from .mesh_data import MeshData, from_faces

_KINDS = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_PACKED = ("KHR_draco_mesh_compression", "EXT_meshopt_compression")
_TRIANGLES, _STRIP, _FAN = 4, 5, 6
# from glTF's axes (left, up, front) to x forward, y left, z up
_TURN = np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]])
_DEEPEST = 100  # nodes in nodes; more is a circle


def read_gltf(path: Path) -> MeshData:
    """Points, triangles and named nodes (as groups) of a .glb or .gltf file.

    Raises
    ------
    ValueError : for a file that is cut short, compressed, or without triangles.
    """
    data = path.read_bytes()
    text, binary = _chunks(data) if data[:4] == b"glTF" else (data, None)
    try:
        tree = json.loads(text.decode("utf-8-sig"))
        if not isinstance(tree, dict):
            raise ValueError
    except ValueError:
        raise ValueError("it holds no JSON text") from None
    packed = [name for name in tree.get("extensionsRequired", []) if name in _PACKED]
    if packed:
        raise ValueError(f"it is compressed ({packed[0]}), export it without compression")
    try:
        return _mesh(tree, binary, path.parent)
    except (KeyError, IndexError, TypeError, AttributeError) as error:
        raise ValueError(f"an entry is missing or of a wrong kind ({error})") from None


def _chunks(data):
    """JSON text and binary part of a .glb file."""
    parts, place = {}, 12
    if len(data) < 20 or int.from_bytes(data[8:12], "little") > len(data):
        raise ValueError(f"it is cut short: it has {len(data)} bytes")
    while place + 8 <= len(data):
        length = int.from_bytes(data[place : place + 4], "little")
        kind = data[place + 4 : place + 8]
        if place + 8 + length > len(data):
            raise ValueError("it is cut short")
        parts.setdefault(kind, data[place + 8 : place + 8 + length])
        place += 8 + length
    return parts.get(b"JSON", b""), parts.get(b"BIN\0")


def _mesh(tree: dict[str, Any], binary: bytes | None, folder: Path) -> MeshData:
    buffers = [_buffer(entry, binary, folder) for entry in tree.get("buffers", [])]
    nodes = tree.get("nodes", [])
    scenes = tree.get("scenes")
    roots = scenes[tree.get("scene", 0)].get("nodes", []) if scenes else range(len(nodes))
    points: list[np.ndarray] = []
    faces: list[np.ndarray] = []
    groups: dict[str, list[int]] = {}
    waiting: list[tuple[int, np.ndarray, int]] = [(n, np.eye(4), 0) for n in roots]
    while waiting:
        number, frame, depth = waiting.pop()
        if depth > _DEEPEST or number < 0:
            raise ValueError("its nodes contain each other")
        node = nodes[number]
        frame = frame @ _matrix(node)
        waiting += [(child, frame, depth + 1) for child in node.get("children", [])]
        if len(waiting) > 100_000:
            raise ValueError("its nodes contain each other")
        if "mesh" not in node:
            continue
        for part in tree["meshes"][node["mesh"]]["primitives"]:
            if part.get("mode", _TRIANGLES) not in (_TRIANGLES, _STRIP, _FAN):
                continue
            place = _accessor(tree, buffers, part["attributes"]["POSITION"])
            order = np.arange(len(place))
            if "indices" in part:
                order = _accessor(tree, buffers, part["indices"]).astype(np.int64).ravel()
            triangles = _triangles(order, part.get("mode", _TRIANGLES))
            before = sum(map(len, faces))
            if node.get("name"):
                groups.setdefault(str(node["name"]), []).extend(
                    range(before, before + len(triangles))
                )
            faces.append(triangles + sum(map(len, points)))
            points.append(place.astype(np.float64) @ frame[:3, :3].T + frame[:3, 3])
    if not faces:
        raise ValueError("it holds no triangles")
    every, cells = np.concatenate(points), np.concatenate(faces)
    if cells.size and not 0 <= cells.min() <= cells.max() < len(every):
        raise ValueError(f"a triangle names point {cells.max()} of {len(every)}")
    joined, number = np.unique(every, axis=0, return_inverse=True)
    return from_faces(
        joined @ _TURN.T,
        number.reshape(-1)[cells].ravel().astype(np.int64),
        np.full(len(cells), 3),
        {name: np.array(rows) for name, rows in groups.items()} if len(groups) > 1 else {},
        notes=("glTF's axes (y up, front towards z) were turned to x forward, y left, z up",),
    )


def _buffer(entry: dict[str, Any], binary: bytes | None, folder: Path) -> bytes:
    uri = entry.get("uri")
    if uri is None:
        if binary is None:
            raise ValueError("its binary part is missing, the file is cut short")
        return binary
    if uri.startswith("data:"):
        return base64.b64decode(uri.partition(",")[2])
    file = folder / uri
    if not file.is_file():
        raise ValueError(f"the file '{uri}' it refers to is missing: keep it beside")
    return file.read_bytes()


def _accessor(tree, buffers, number):
    """Numbers of an accessor, (count, components)."""
    entry = tree["accessors"][number]
    if "sparse" in entry:
        raise ValueError("it has sparse accessors, export it without morph targets")
    width = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}[entry["type"]]
    kind, view = np.dtype(_KINDS[entry["componentType"]]), tree["bufferViews"][entry["bufferView"]]
    start = view.get("byteOffset", 0) + entry.get("byteOffset", 0)
    step, count = view.get("byteStride", width * kind.itemsize), entry["count"]
    data = buffers[view["buffer"]]
    if count < 1 or start < 0 or step < 1:
        raise ValueError("an accessor is empty")
    if start + (count - 1) * step + width * kind.itemsize > len(data):
        raise ValueError("an accessor reaches beyond its buffer, the file is cut short")
    return np.ndarray((count, width), kind, data, start, (step, kind.itemsize))


def _matrix(node):
    """Frame (4, 4) of a node in its parent."""
    if "matrix" in node:
        return np.array(node["matrix"], dtype=np.float64).reshape(4, 4).T
    frame = np.eye(4)
    x, y, z, w = node.get("rotation", (0.0, 0.0, 0.0, 1.0))
    frame[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    frame[:3, :3] *= np.array(node.get("scale", (1.0, 1.0, 1.0)), dtype=np.float64)
    frame[:3, 3] = node.get("translation", (0.0, 0.0, 0.0))
    return frame


def _triangles(order, mode):
    if mode == _TRIANGLES:
        return order[: len(order) // 3 * 3].reshape(-1, 3)
    count = len(order) - 2
    if mode == _FAN:
        return np.stack([np.full(count, order[0]), order[1:-1], order[2:]], axis=1)
    rows = np.stack([order[:-2], order[1:-1], order[2:]], axis=1)
    rows[1::2] = rows[1::2][:, [1, 0, 2]]
    return rows
