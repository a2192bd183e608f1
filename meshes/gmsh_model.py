"""A model of gmsh for one task: silent, and leaving gmsh as the caller had it.

Every rank may open its own; gmsh then works alone on each and gives the same result on all.
"""
# SPDX-License-Identifier: LGPL-3.0-or-later

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import numpy as np

# gmsh's numbers of the cell types that can carry a surface or a named edge.
_KINDS = {
    1: ("line", 2),
    2: ("triangle", 3),
    3: ("quad", 4),
    8: ("line3", 3),
    9: ("triangle6", 6),
    10: ("quad9", 9),
    16: ("quad8", 8),
}


@contextlib.contextmanager
def gmsh_model(**options: float) -> Iterator[ModuleType]:
    """Yield the gmsh module with an empty current model and mesh options set, e.g. Algorithm=6.

    Raises ImportError if gmsh is not installed, or if it lacks a library of the system.
    """
    try:
        import gmsh
    except OSError as error:  # from PyPI it wants libraries of the desktop
        raise ImportError(
            f"gmsh, which meshes outlines and reads .msh files, lacks a library: {error} (Debian: "
            "apt-get install libgl1 libglu1-mesa libxcursor1 libxft2 libxinerama1)"
        ) from None

    # One thread: the mesh must not depend on how many cores there are.
    wanted: dict[str, float] = {"General.Terminal": 0, "General.NumThreads": 1}
    wanted.update({f"Mesh.{name}": value for name, value in options.items()})
    shared = _is_open(gmsh)
    if shared:
        previous = {name: gmsh.option.getNumber(name) for name in wanted}
        current = gmsh.model.getCurrent()
    else:
        gmsh.initialize([], False)
    try:
        for name, value in wanted.items():
            gmsh.option.setNumber(name, value)
        gmsh.model.add("meshes")
        yield gmsh
    finally:
        if shared:
            gmsh.model.remove()
            gmsh.model.setCurrent(current)
            for name, value in previous.items():
                gmsh.option.setNumber(name, value)
        else:
            gmsh.finalize()


def read_msh(
    path: str | Path,
) -> tuple[np.ndarray, list[tuple[str, np.ndarray]], dict[str, list[np.ndarray]]]:
    """Points, cell blocks and cell sets of a .msh file of any version, read by gmsh itself.

    Returns ``points`` (n, 3), ``cells`` [(meshio type, (k, nodes))] and ``cell_sets``
    {physical name: rows in each block}. Raises Exception with gmsh's reason if it cannot.
    """
    cells: list[tuple[str, np.ndarray]] = []
    members: dict[str, dict[int, np.ndarray]] = {}
    with gmsh_model() as gmsh:
        gmsh.merge(str(path))
        tags, coordinates, _ = gmsh.model.mesh.getNodes()
        number = np.full(int(max(tags, default=0)) + 1, -1)
        number[tags.astype(np.int64)] = np.arange(len(tags))
        for dim, entity in gmsh.model.getEntities(1) + gmsh.model.getEntities(2):
            titles = [
                gmsh.model.getPhysicalName(dim, group)
                or f"{'edge' if dim == 1 else 'panel'}_{group}"
                for group in gmsh.model.getPhysicalGroupsForEntity(dim, entity)
            ]
            for kind, _, nodes in zip(*gmsh.model.mesh.getElements(dim, entity)):
                if kind in _KINDS:
                    name, width = _KINDS[kind]
                    cells.append((name, number[nodes.astype(np.int64)].reshape(-1, width)))
                    for title in titles:
                        members.setdefault(title, {})[len(cells) - 1] = np.arange(len(cells[-1][1]))
    empty = np.empty(0, dtype=np.int64)
    sets = {
        title: [rows.get(block, empty) for block in range(len(cells))]
        for title, rows in members.items()
    }
    return coordinates.reshape(-1, 3), cells, sets


def _is_open(gmsh):
    """Whether the caller has gmsh initialised already, which must then stay so."""
    if hasattr(gmsh, "isInitialized"):
        return bool(gmsh.isInitialized())
    # Older versions can only be tried, and then complain straight to the terminal.
    saved = os.dup(2)
    try:
        with open(os.devnull, "w") as void:
            os.dup2(void.fileno(), 2)
        return gmsh.option.getString("General.Version") != ""
    except Exception:
        return False
    finally:
        os.dup2(saved, 2)
        os.close(saved)
