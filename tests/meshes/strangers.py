# SPDX-License-Identifier: LGPL-3.0-or-later
"""Garments as strangers have them: kinds, faults of drawing, file formats; small, made by code."""

import base64
import json
import struct
from itertools import pairwise

import numpy as np

import meshes
from meshes import Surface
from tests.meshes.files.gltf_file import glb
from tests.meshes.files.test_drawing_files import ply
from tests.meshes.sewn import pocketed_trousers, with_collar, with_patch

CELL = 0.04


def belted_trousers():
    """Trousers with patch pockets and a band around the waist, sewn on below, free at the top."""
    pockets = pocketed_trousers(CELL)
    plain = meshes.trousers("large-regular", cell_size=CELL)
    rim = np.unique(plain.edges["waist"])
    top = plain.cells[np.isin(plain.cells, rim).any(axis=1)]
    number = np.arange(len(plain.points))
    number[rim] = len(pockets.points) + np.arange(len(rim))
    band = plain.points[rim] + 0.004 * plain.directors[rim]
    return Surface(
        np.concatenate([pockets.points, band]),
        np.concatenate([pockets.cells, number[top]]),
        source="belted trousers",
        verify=False,
    )


def shorts():
    """Trousers cut off above the knee."""
    whole = meshes.trousers("large-regular", cell_size=CELL)
    keep = whole.points[whole.cells][:, :, 2].mean(axis=1) > 0.55
    cut = Surface(whole.points, whole.cells[keep], source="shorts", verify=False)
    return meshes.clean(cut).replace(verify=True)


def skirt():
    """A skirt with a patch sewn on all around."""
    plain = meshes.skirt(waist=1.0, hip=1.2, hem=1.5, cell_size=CELL)
    middle = plain.points[plain.cells].mean(axis=1)
    level = 0.5 * (middle[:, 2].min() + middle[:, 2].max())
    chosen = (middle[:, 0] > 0.08) & (abs(middle[:, 2] - level) < 0.12)
    return with_patch(plain, chosen)


def polo():
    """A trunk with two sleeves, a collar and a placket: four openings."""
    shirt = plain_shirt()
    middle = shirt.points[shirt.cells].mean(axis=1)
    front = (middle[:, 0] > 0.08) & (abs(middle[:, 1]) < 0.05) & (abs(middle[:, 2] - 1.2) < 0.1)
    placket = with_patch(shirt, front)
    placket = meshes.orient(placket, majority=True).replace(verify=True)
    ring = np.flatnonzero(np.round(placket.points[:, 2] - NECK, 9) == 0)
    return with_collar(placket, ring, 1)


HEIGHTS = np.linspace(0.9, 1.45, 12)
NECK = HEIGHTS[10]


def plain_shirt():
    """A trunk with two sleeves."""
    across = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    radii = np.interp(HEIGHTS, [0.9, 1.3, 1.38, 1.45], [0.18, 0.18, 0.14, 0.07])
    rings = [
        np.stack([0.7 * r * np.cos(across), r * np.sin(across), 0 * across + z], axis=1)
        for r, z in zip(radii, HEIGHTS)
    ]
    points, cells = np.concatenate(rings), []
    sleeves = {1: [], -1: []}
    for row in range(11):
        for k in range(24):
            cell = [row * 24 + k, row * 24 + (k + 1) % 24, (row + 1) * 24 + (k + 1) % 24]
            cell.append((row + 1) * 24 + k)
            side = 1 if k in (5, 6) else -1 if k in (17, 18) else 0
            (sleeves[side] if side and row in (6, 7) else cells).append(cell)
    for side, holes in sleeves.items():
        sides = [(c[j], c[(j + 1) % 4]) for c in holes for j in range(4)]
        rim = [s for s in sides if s[::-1] not in sides]
        for tail, head in rim:
            cells.append([tail, head, 10_000 + head, 10_000 + tail])
        for point in sorted({p for s in rim for p in s}):
            number = len(points)
            points = np.vstack([points, points[point] + [0.0, 0.2 * side, -0.05]])
            cells = [[number if q == 10_000 + point else q for q in c] for c in cells]
    plain = meshes.clean(meshes.Surface(points, cells, verify=False))
    return meshes.orient(plain, majority=True).replace(verify=True)


KINDS = {
    "trousers": belted_trousers,
    "shorts": shorts,
    "skirt": skirt,
    "shirt": plain_shirt,
    "polo": polo,
}


# faults: points (n, 3) and faces as lists, changed and returned


def mirrored(points, faces):
    return points * [1, -1, 1], faces


def inside_out(points, faces):
    return points, [face[::-1] for face in faces]


def own_points(points, faces):
    """Every face with points of its own, as an export without shared points."""
    order = np.concatenate(faces)
    ends = np.cumsum([0] + [len(face) for face in faces])
    return points[order], [list(range(a, b)) for a, b in pairwise(ends)]


def doubled_points(points, faces):
    """A line of points twice, so that the garment falls apart there."""
    cut = {k: len(points) + i for i, k in enumerate(np.flatnonzero(points[:, 0] > 0.05))}
    middle = [np.mean(points[face], axis=0) for face in faces]
    low = np.median(points[:, 2])
    faces = [
        [cut.get(q, q) for q in face] if m[2] < low else face for face, m in zip(faces, middle)
    ]
    return np.concatenate([points, points[list(cut)]]), faces


def t_junctions(points, faces):
    """Every ninth quad cut into two over the middles of two sides, its neighbours not told."""
    points, out = points.tolist(), []
    for number, face in enumerate(faces):
        if number % 9 or len(face) != 4:
            out.append(face)
            continue
        a, b, c, d = face
        points.append(np.mean([points[a], points[b]], axis=0).tolist())
        points.append(np.mean([points[c], points[d]], axis=0).tolist())
        m, n = len(points) - 2, len(points) - 1
        out += [[a, m, n, d], [m, b, c, n]]
    return np.array(points), out


def n_gons(points, faces):
    """Some pairs of neighbouring quads joined to one face of six corners."""
    faces = [list(face) for face in faces]
    out, used = [], set()
    for number in range(0, len(faces) - 1, 5):
        one, other = faces[number], faces[number + 1]
        common = [q for q in one if q in other]
        if len(common) != 2 or len(one) != 4 or len(other) != 4:
            continue
        while {one[0], one[-1]} != set(common):
            one = one[1:] + one[:1]
        while {other[0], other[-1]} != set(common):
            other = other[1:] + other[:1]
        if one[-1] != other[0]:
            continue
        out.append(one + other[1:-1])
        used |= {number, number + 1}
    return points, [face for k, face in enumerate(faces) if k not in used] + out


def isolated_points(points, faces):
    return np.concatenate([points, [[0.0, 0.0, 0.0], [5.0, 1.0, 2.0]]]), faces


def degenerate_faces(points, faces):
    """A face that uses a point twice, one on a line, and one there twice."""
    a, b, c = faces[0][:3]
    return points, [*faces, [a, b, b], [a, a, a, a], faces[0], [a, b, a, c]]


def thick(points, faces):
    """Two sheets 2 mm apart, closed at the rims."""
    surface = Surface(points, np.array(faces), verify=False)
    surface = meshes.orient(surface, majority=True)
    normals = meshes.nodal_normals(surface.points, surface.cells)
    outer, inner = surface.points + 1e-3 * normals, surface.points - 1e-3 * normals
    count, sides = len(points), {}
    for cell in surface.cells.tolist():
        for side in zip(cell, cell[1:] + cell[:1]):
            sides[side] = sides.get(side, 0) + 1
    rim = [(a, b) for a, b in sides if (b, a) not in sides]
    faces = surface.cells.tolist()
    faces += [[count + q for q in face[::-1]] for face in surface.cells.tolist()]
    faces += [[b, a, count + a, count + b] for a, b in rim]
    return np.concatenate([outer, inner]), faces


FAULTS = {
    "none": lambda points, faces: (points, faces),
    "mirrored": mirrored,
    "inside out": inside_out,
    "own points": own_points,
    "doubled points": doubled_points,
    "T-junctions": t_junctions,
    "n-gons": n_gons,
    "isolated points": isolated_points,
    "degenerate faces": degenerate_faces,
    "thick": thick,
}


# formats: bytes of a file by its ending; further files beside it


def obj_file(points, faces):
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in points.tolist()]
    lines += ["f " + " ".join(str(k + 1) for k in face) for face in faces]
    return ("\n".join(lines) + "\n").encode()


def off_file(points, faces):
    lines = ["OFF", "# drawn", f"{len(points)} {len(faces)} 0"]
    lines += [f"{x!r} {y!r} {z!r}" for x, y, z in points.tolist()]
    lines += [f"{len(face)} " + " ".join(map(str, face)) + " 200 0 0" for face in faces]
    return ("\n".join(lines) + "\n").encode()


def triangles(faces):
    return [[face[0], face[k], face[k + 1]] for face in faces for k in range(1, len(face) - 1)]


def stl_file(points, faces):
    corners = points[np.array(triangles(faces))].astype("<f4")
    rows = b"".join(bytes(12) + row.tobytes() + bytes(2) for row in corners)
    return bytes(80) + struct.pack("<I", len(corners)) + rows


class _Faces:
    """What `ply` and `glb` ask of a surface."""

    def __init__(self, points, faces):
        self.points, self.cells = points, _Rows(faces)


class _Rows(list):
    def tolist(self):
        return list(self)


def ply_file(order):
    return lambda points, faces: ply(_Faces(points, faces), order, "vertex_indices")


def glb_file(points, faces):
    surface = Surface(points, np.array(triangles(faces)), verify=False)
    return glb(surface)


def gltf_file(points, faces):
    """.gltf text with its buffer within."""
    data = glb_file(points, faces)
    length = struct.unpack("<I", data[12:16])[0]
    tree = json.loads(data[20 : 20 + length])
    binary = data[28 + length :]
    tree["buffers"][0]["uri"] = (
        "data:application/octet-stream;base64," + base64.b64encode(binary).decode()
    )
    return json.dumps(tree).encode()


FORMATS = {
    ".obj": obj_file,
    ".off": off_file,
    ".stl": stl_file,
    ".ply": ply_file("ascii"),
    " little.ply": ply_file("binary_little_endian"),
    " big.ply": ply_file("binary_big_endian"),
    ".glb": glb_file,
    ".gltf": gltf_file,
}
