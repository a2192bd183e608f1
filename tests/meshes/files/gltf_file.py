# SPDX-License-Identifier: LGPL-3.0-or-later
"""A .glb file of a surface, y up, each triangle with points of its own."""

import json
import struct

import numpy as np

import meshes


def glb(surface):
    """Bytes of the file; the node carries half of the surface's place, turned and scaled."""
    cut = surface.cells.shape[1] == 3
    triangles = surface if cut else meshes.to_triangles(surface, "shortest")
    # x forward, y left, z up is z, x, y there; the node turns by 90 degrees about y, doubles, moves
    there = triangles.points[triangles.cells].reshape(-1, 3)[:, [1, 2, 0]]
    turn = np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]])
    local = ((there - [0.1, 0.2, 0.3]) / 2.0) @ turn
    places, order = local.astype("<f4"), np.arange(len(local), dtype="<u2")
    binary = places.tobytes() + order.tobytes()
    binary += bytes(-len(binary) % 4)
    tree = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [
            {"children": [1], "translation": [0.1, 0.2, 0.3]},
            {"mesh": 0, "name": "cloth", "rotation": [0, 0.5**0.5, 0, 0.5**0.5], "scale": [2] * 3},
        ],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(places), "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": len(order), "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": places.nbytes},
            {"buffer": 0, "byteOffset": places.nbytes, "byteLength": order.nbytes},
        ],
        "buffers": [{"byteLength": len(binary)}],
    }
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    body = struct.pack("<I4s", len(text), b"JSON") + text
    body += struct.pack("<I4s", len(binary), b"BIN\0") + binary
    return struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body
