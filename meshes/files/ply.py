# SPDX-License-Identifier: LGPL-3.0-or-later
"""Stanford .ply files, text or binary of either byte order, with any properties in any order.

Faces are the list `vertex_indices` or `vertex_index`; other elements and properties are skipped.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np

from .mesh_data import MeshData, from_faces

_TYPES = {
    name: code
    for code, names in {
        "i1": "char int8",
        "u1": "uchar uint8",
        "i2": "short int16",
        "u2": "ushort uint16",
        "i4": "int int32",
        "u4": "uint uint32",
        "f4": "float float32",
        "f8": "double float64",
    }.items()
    for name in names.split()
}
_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_FACES = ("vertex_indices", "vertex_index")


class _Property(NamedTuple):
    name: str
    kind: str  # numpy's code of its values
    counted: str | None  # of the number before a list, None for a single value


class _Element(NamedTuple):
    name: str
    rows: int
    properties: list[_Property]


def read_ply(path: Path) -> MeshData:
    """Points, faces and, as `directors`, unit normals of the points where the file has them.

    Raises
    ------
    ValueError : for a header that is none, or a body shorter than it says.
    """
    data = path.read_bytes()
    order, elements, body = _header(data)
    read = _words(data[body:]) if order == "" else _binary(data, body, order)
    points, normals = np.empty((0, 3)), None
    corners, sizes = np.empty(0, np.int64), np.empty(0, np.int64)
    for element in elements:
        columns = read(element)
        if element.name == "vertex":
            missing = [axis for axis in "xyz" if axis not in columns]
            if missing:
                raise ValueError(f"its vertices have no {missing[0]}")
            points = np.stack([columns[axis] for axis in "xyz"], axis=1).astype(np.float64)
            if all(axis in columns for axis in ("nx", "ny", "nz")):
                normals = np.stack([columns[axis] for axis in ("nx", "ny", "nz")], axis=1)
        elif element.name == "face":
            name = next((name for name in _FACES if name in columns), None)
            if name is None and element.rows:
                raise ValueError(f"its faces have no list {' or '.join(_FACES)}")
            if name is not None:
                corners, sizes = columns[name]
    more = {} if normals is None else {"directors": normals.astype(np.float64)}
    return from_faces(points, corners.astype(np.int64), sizes.astype(np.int64), point_data=more)


def _header(data):
    """Byte order, elements, and where the body begins."""
    if data[:3] != b"ply":
        raise ValueError("it does not begin with 'ply'")
    order, elements, place = None, [], 0
    while True:
        end = data.find(b"\n", place)
        if end < 0:
            raise ValueError("its header has no end_header")
        words = data[place:end].decode("latin-1").split()
        place = end + 1
        if not words or words[0] in ("ply", "comment", "obj_info"):
            continue
        if words[0] == "end_header":
            break
        if words[0] == "format":
            order = _ORDERS.get(words[1] if len(words) > 1 else "")
            if order is None:
                raise ValueError(f"format is one of {', '.join(_ORDERS)}, not {words[1:2]}")
        elif words[0] == "element" and len(words) == 3 and words[2].isdigit():
            elements.append(_Element(words[1], int(words[2]), []))
        elif words[0] == "property" and elements:
            elements[-1].properties.append(_property(words))
        else:
            raise ValueError(f"the header says '{' '.join(words)}'")
    if order is None:
        raise ValueError("its header has no format")
    return order, elements, place


def _property(words):
    kinds = [_TYPES.get(word) for word in words[1:-1] if word != "list"]
    if None in kinds or len(kinds) != (2 if words[1:2] == ["list"] else 1):
        raise ValueError(f"the header says '{' '.join(words)}'")
    return _Property(words[-1], kinds[-1], kinds[0] if len(kinds) == 2 else None)


def _short(element, row):
    return ValueError(
        f"it ends in {element.name} {row} of {element.rows}, the file is cut short or damaged"
    )


def _words(body):
    """Reader of elements as text."""
    words = body.split()
    place = 0

    def read(element):
        nonlocal place
        plain = [p for p in element.properties if p.counted is None]
        if len(plain) == len(element.properties):
            width = len(plain)
            if place + element.rows * width > len(words):
                raise _short(element, (len(words) - place) // max(width, 1))
            table = np.array(words[place : place + element.rows * width], dtype=np.float64)
            place += element.rows * width
            table = table.reshape(element.rows, width)
            return {p.name: table[:, k] for k, p in enumerate(plain)}
        found = {p.name: ([], []) for p in element.properties}
        for row in range(element.rows):
            for p in element.properties:
                count = 1
                if p.counted is not None:
                    if place >= len(words):
                        raise _short(element, row)
                    count = int(words[place])
                    place += 1
                if count < 0 or place + count > len(words):
                    raise _short(element, row)
                found[p.name][0].extend(words[place : place + count])
                found[p.name][1].append(count)
                place += count
        return {name: _arrays(*pair) for name, pair in found.items()}

    return read


def _arrays(values, counts):
    return np.array(values, dtype=np.float64), np.array(counts, dtype=np.int64)


def _binary(data, place, order):
    """Reader of elements in binary form."""

    def read(element):
        nonlocal place
        if all(p.counted is None for p in element.properties):
            row = np.dtype([(f"{k}", order + p.kind) for k, p in enumerate(element.properties)])
            size = row.itemsize * element.rows
            if place + size > len(data):
                raise _short(element, (len(data) - place) // max(row.itemsize, 1))
            table = np.frombuffer(data, row, element.rows, place) if size else None
            place += size
            if table is None:
                return {p.name: np.empty(0) for p in element.properties}
            return {p.name: table[f"{k}"] for k, p in enumerate(element.properties)}
        found = {p.name: ([], []) for p in element.properties}
        kinds = [
            (p.name, np.dtype(order + p.kind), p.counted and np.dtype(order + p.counted))
            for p in element.properties
        ]
        for row in range(element.rows):
            for name, kind, counted in kinds:
                count = 1
                if counted is not None:
                    if place + counted.itemsize > len(data):
                        raise _short(element, row)
                    count = int(np.frombuffer(data, counted, 1, place)[0])
                    place += counted.itemsize
                if count < 0 or place + count * kind.itemsize > len(data):
                    raise _short(element, row)
                found[name][0].append(np.frombuffer(data, kind, count, place))
                found[name][1].append(count)
                place += count * kind.itemsize
        return {
            name: _arrays(np.concatenate(values) if values else [], counts)
            for name, (values, counts) in found.items()
        }

    return read
