"""Mesh files into points and faces: one sentence for every failure.

meshio reads the formats of mesh generators, .msh, .vtu and .vtk; it is helped with .msh files in
which only some parts belong to physical groups. Those of drawing programs are read beside this.
"""
# SPDX-License-Identifier: LGPL-3.0-or-later

from __future__ import annotations

import contextlib
import io
from pathlib import Path
from typing import TYPE_CHECKING

from meshes.gmsh_model import read_msh
from meshes.validity import MeshError

from .gltf import read_gltf
from .mesh_data import MeshData
from .obj import read_obj
from .off import read_off
from .ply import read_ply
from .stl import read_stl

if TYPE_CHECKING:
    import meshio

WRITTEN = (".msh", ".vtu", ".vtk", ".obj", ".stl", ".ply")
FORMATS = (*WRITTEN, ".glb", ".gltf", ".off")
_READERS = {
    ".obj": read_obj,
    ".ply": read_ply,
    ".stl": read_stl,
    ".glb": read_gltf,
    ".gltf": read_gltf,
    ".off": read_off,
}


def read_mesh(path: Path) -> MeshData | meshio.Mesh:
    """Contents of the file at a Path, as meshio arranges them.

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
        raise MeshError(
            f"{path.name}: there is no such file in {path.parent}, check the name and the folder."
        )
    said = io.StringIO()
    try:
        if kind in _READERS:
            return _READERS[kind](path)
        return _read_by_meshio(path, said)
    except (Exception, SystemExit) as error:
        reason = " ".join(f"{said.getvalue()} {error}".split())[:160] or type(error).__name__
    # only here: within `except` the error would go along, and with it the file that it left open
    raise MeshError(
        f"{path.name}: the file cannot be read as {path.suffix} ({reason}), export it again or "
        "convert it to .vtu."
    )


def _read_by_meshio(path, said):
    """By meshio, which prints its complaints and may even end the program."""
    import meshio

    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
        try:
            return meshio.read(path)
        except Exception:
            if path.suffix.lower() != ".msh":
                raise
            return _read_msh(path, meshio)


def _read_msh(path, meshio):
    # gmsh guesses at files it does not know; only real ones may reach it.
    if not path.read_bytes()[:11] == b"$MeshFormat":
        raise ValueError("it does not begin with $MeshFormat")
    points, cells, sets = read_msh(path)
    return meshio.Mesh(points, cells, cell_sets=sets)
