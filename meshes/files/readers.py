"""Mesh files into meshio meshes: one sentence for every failure, and the detours some files need.

meshio does the reading. It is helped where it refuses sound files: .obj with texture coordinates,
as all drawing programs write it, and .msh in which only some parts belong to physical groups.
"""
# SPDX-License-Identifier: LGPL-3.0-or-later

from __future__ import annotations

import contextlib
import io
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from meshes.gmsh_model import read_msh
from meshes.validity import MeshError

if TYPE_CHECKING:
    import meshio

FORMATS = (".msh", ".vtu", ".vtk", ".obj", ".stl", ".ply")


def read_mesh(path: Path) -> meshio.Mesh:
    """The meshio mesh of the file at a Path.

    Raises
    ------
    MeshError : for an unknown ending, a missing file or one that cannot be read.
    """
    kind = path.suffix.lower()
    if kind not in FORMATS:
        raise MeshError(
            f"{path.name}: unknown file type '{path.suffix}', save the mesh as one of "
            f"{', '.join(FORMATS)}."
        )
    if not path.is_file():
        raise MeshError(f"{path}: there is no such file, check the name and the folder.")
    import meshio

    # The reader prints its complaints and may even end the program; both become an exception.
    said = io.StringIO()
    try:
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            if kind == ".obj":
                return _read_obj(path, meshio)
            try:
                return meshio.read(path)
            except Exception:
                if kind != ".msh":
                    raise
                return _read_msh(path, meshio)
    except (Exception, SystemExit) as error:
        reason = " ".join(f"{said.getvalue()} {error}".split())[:120]
        raise MeshError(
            f"{path.name}: the file cannot be read as {path.suffix} ({reason}), export it again "
            "or convert it to .vtu."
        ) from None


def _read_msh(path, meshio):
    # gmsh guesses at files it does not know; only real ones may reach it.
    if not path.read_bytes()[:11] == b"$MeshFormat":
        raise ValueError("it does not begin with $MeshFormat")
    points, cells, sets = read_msh(path)
    return meshio.Mesh(points, cells, cell_sets=sets)


def _read_obj(path, meshio):
    """Points, faces and groups of a .obj file; its objects count as groups if it has no groups."""
    lines = [line.split() for line in path.read_text(errors="replace").splitlines()]
    mark = "g" if any(line[:1] == ["g"] for line in lines) else "o"
    titles, kept = [], []
    for line in lines:
        if line[:1] == ["v"]:
            # Some programs append colours to the coordinates.
            kept.append(line[:4])
        elif line[:1] == ["f"]:
            kept.append(line)
        elif line[:1] == [mark]:
            titles.append(" ".join(line[1:]))
            kept.append(["g"])
    mesh = meshio.read(io.StringIO("\n".join(map(" ".join, kept))), "obj")
    groups = mesh.cell_data.pop("obj:group_ids", [])
    for place, title in enumerate(titles):
        rows = [np.flatnonzero(np.asarray(ids) == place) for ids in groups]
        if title in mesh.cell_sets:
            rows = [np.concatenate(pair) for pair in zip(mesh.cell_sets[title], rows)]
        if title and sum(map(len, rows)):
            mesh.cell_sets[title] = rows
    return mesh
