# SPDX-License-Identifier: LGPL-3.0-or-later
"""Stereolithography .stl files, text (upper or lower case, any line ends) or binary.

The format repeats every corner in every facet: equal ones become one point here, those that differ
in the last digit of single precision are joined in `load`.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from .mesh_data import MeshData, from_faces

_FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")])
_VERTEX = re.compile(rb"vertex\s+(\S+)\s+(\S+)\s+(\S+)", re.IGNORECASE)


def read_stl(path: Path) -> MeshData:
    """Points and triangles of a .stl file.

    Raises
    ------
    ValueError : for a file that is neither form, or is cut short.
    """
    data = path.read_bytes()
    count = int.from_bytes(data[80:84], "little")
    # 'solid' may begin a binary file too: the length decides
    if len(data) >= 84 and len(data) == 84 + _FACET.itemsize * count:
        corners = np.frombuffer(data, _FACET, count, 84)["corners"].reshape(-1, 3)
    elif data.lstrip()[:5].lower() == b"solid":
        lower = data.lower()
        facets, ends = lower.count(b"facet normal"), lower.count(b"endfacet")
        found = _VERTEX.findall(data)
        if ends != facets or len(found) != 3 * facets or b"endsolid" not in lower:
            raise ValueError(
                f"{facets} facets begin, {ends} end, {len(found)} vertices: the file is cut short "
                "or damaged"
            )
        corners = np.array(found, dtype=np.float64).reshape(-1, 3)
    elif len(data) >= 84:
        raise ValueError(
            f"its header tells {count} facets, which are {84 + _FACET.itemsize * count} bytes, and "
            f"the file has {len(data)}: it is cut short or damaged"
        )
    else:
        raise ValueError("it is neither text that begins with 'solid' nor binary")
    points, number = np.unique(corners.astype(np.float64), axis=0, return_inverse=True)
    faces = len(corners) // 3
    return from_faces(points, number.reshape(-1).astype(np.int64), np.full(faces, 3))
