"""Surfaces from files, and into some of them: of mesh generators and of drawing programs.

A file may mix cells, repeat points, face both ways or be in millimetres; what leaves `load` is one
checked Surface in m. The names of edges and panels are gmsh's physical groups in .msh files, and
cell data called 'edge:NAME' and 'panel:NAME' (1 inside, 0 outside) in .vtu and .vtk files.
"""
# SPDX-License-Identifier: LGPL-3.0-or-later

from __future__ import annotations

import os
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np

from meshes.geometry import diagonal, joined
from meshes.midsurface import middle_surface, tell_thick
from meshes.repair import boundary_loops, clean, orient
from meshes.subdivide import carry, split_blocks, to_triangles
from meshes.surface import Surface
from meshes.topology import segments_of_line
from meshes.validity import MeshError, check_indices, with_hint

from .faces import Choice, drop_twins, tidy_faces
from .groups import drop_repeats, read_groups, with_groups
from .mesh_data import Block
from .readers import WRITTEN, read_mesh
from .weld import tell_near_misses, weld_borders, welded_edges

UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254}
# Nodes kept of each kind of cell: quadratic cells without a centre node are straightened.
MANY_UNUSED = 0.1  # of the points
_FACES = {"triangle": 3, "triangle6": 3, "quad": 4, "quad8": 4, "quad9": 9}


def load(
    path: str | Path,
    unit: str = "m",
    quads: str | None = None,
    weld: float = 0.0,
    midsurface: bool = False,
) -> Surface:
    """Read the surface in a file.

    Parameters
    ----------
    path : file with triangles, quads, faces of more corners, or 9-node quads. A mix of triangles
        and quads is cut into quads throughout, conformingly.
    unit : of the file's coordinates: 'm', 'cm', 'mm' or 'in'.
    quads : 'split' cuts triangles into three quads each; None keeps them.
    weld : distance [m] within which borders are joined, points to points and points to sides; 0
        for none.
    midsurface : replace a closed thick sheet, as drawing programs export, by its middle surface.

    Returns
    -------
    Surface in m. Named edges and panels as in the file; without any named edge, the boundary
    loops are called 'boundary_0', 'boundary_1', ..., longest first. Its `notes` say what was
    chosen or mended and what looks wrong, one sentence each; what looks wrong or
    was left out is warned of too.

    Raises
    ------
    MeshError : one sentence for a file that is missing, unreadable or holds no usable surface.
        ValueError for an unknown unit or ``quads``, or a negative ``weld``.
    """
    if unit not in UNITS:
        raise ValueError(f"unit must be one of {', '.join(UNITS)}, not {unit!r}")
    if quads not in (None, "split"):
        raise ValueError(f"quads must be None or 'split', not {quads!r}")
    if not 0.0 <= weld < np.inf:
        raise ValueError(f"weld must be a distance in m, 0 for none, not {weld!r}")
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        warnings.simplefilter("ignore", ResourceWarning)  # files that meshio leaves open
        try:
            surface = _surface(Path(path), unit, quads, weld, midsurface)
        except MeshError as error:
            raise with_hint(error, [str(warning.message) for warning in found]) from None
    notes = dict.fromkeys((*surface.notes, *(str(warning.message) for warning in found)))
    with warnings.catch_warnings():
        # what the checks have warned of already
        warnings.simplefilter("ignore")
        surface = surface.replace(notes=tuple(notes))
    for warning in found:
        if warning.category is not Choice:
            warnings.warn(str(warning.message), stacklevel=2)
    return surface


def _surface(path, unit, quads, distance, midsurface):
    """See `load`."""
    name = path.name
    mesh = read_mesh(path)
    points = np.asarray(mesh.points, dtype=np.float64)
    if points.ndim == 2 and points.shape[1] == 2:
        points = np.column_stack([points, np.zeros(len(points))])
    if path.suffix.lower() == ".stl":
        points, mesh = _joined(points, mesh)
    blocks, origins = _faces(mesh, points, name)
    _tell_unused(points, mesh, name)
    scale = UNITS[unit]
    points, whole = points * scale, blocks
    straight = blocks[0].shape[1] != 9
    label, inside = None, {}
    if distance and straight:
        blocks, origins, label, inside = weld_borders(points, blocks, origins, distance, name)
    edges, panels, warp = read_groups(mesh, origins, whole, name)
    if "gmsh:physical" in mesh.cell_data:
        blocks, panels, warp = drop_repeats(blocks, panels, warp)
    if label is not None:
        edges = welded_edges(edges, label, inside)
    if straight:
        tell_near_misses(points, blocks, name)
    directors = _directors(mesh, points)
    if len(blocks) > 1 or (quads == "split" and blocks[0].shape[1] == 3):
        if len(blocks) > 1:
            warnings.warn(
                f"{name}: the mesh mixes triangles ({len(blocks[0])}) and quads "
                f"({len(blocks[1])}): all are cut into quads of half their size.",
                Choice,
                stacklevel=2,
            )
        points, cells, edges, directors, parents = split_blocks(points, blocks, edges, directors)
        panels, warp = carry(panels, warp, parents)
    else:
        cells = blocks[0]
    notes = tuple(f"{name}: {note}." for note in getattr(mesh, "notes", ()))
    surface = Surface(
        points, cells, edges, directors, warp, panels, name, verify=False, notes=notes
    )
    surface = _same_side(clean(surface)).replace(verify=True)
    _warn_unit(surface, unit)
    if midsurface:
        surface = middle_surface(surface)
    else:
        tell_thick(surface)
    if surface.edges:
        return surface
    loops = boundary_loops(surface)
    lines = [segments_of_line(np.append(loop, loop[0]), surface.degree) for loop in loops]
    return surface.replace(edges={f"boundary_{k}": line for k, line in enumerate(lines)})


def _joined(points, mesh):
    """Points of a format in single precision, those joined that differ in the last digit."""
    used = np.unique(np.concatenate([block.data.ravel() for block in mesh.cells] or [[]]))
    if not len(used) or not np.isfinite(points).all():
        return points, mesh
    label = joined(points, 1e-7 * diagonal(points))
    blocks = [Block(block.type, label[block.data]) for block in mesh.cells]
    return points, replace(mesh, cells=blocks)


def _tell_unused(points, mesh, name):
    """Points without a cell are usual in few numbers; many mean that faces are missing."""
    used = np.concatenate([np.ravel(block.data) for block in mesh.cells])
    unused = len(points) - len(np.unique(used))
    if unused > max(2, MANY_UNUSED * len(points)):
        warnings.warn(
            f"{name}: {unused} of {len(points)} points belong to no face and are left out; if the "
            "file was cut short, export it again.",
            stacklevel=2,
        )


def _faces(mesh, points, name):
    """Cell arrays by width (3 before 4, or 9 alone), and which block and row each comes from."""
    found = {}
    for number, block in enumerate(mesh.cells):
        if not (block.type in _FACES or block.type.startswith("polygon")) or not len(block.data):
            continue
        cells = np.asarray(block.data, dtype=np.int64)
        width = _FACES.get(block.type, cells.shape[-1])
        cells = cells[:, :width]
        if block.type in ("triangle6", "quad8"):
            warnings.warn(
                f"{name}: curved {block.type} cells are straightened; save 9-node quads to "
                "keep the curvature.",
                stacklevel=3,
            )
        origin = np.stack([np.full(len(cells), number), np.arange(len(cells))], axis=1)
        found.setdefault((width, block.type == "quad9"), []).append((cells, origin))
    if not found:
        kinds = ", ".join(sorted({block.type for block in mesh.cells})) or "nothing"
        raise MeshError(
            f"{name}: the file holds no triangles or quads (but {kinds}), export the surface mesh."
        )
    curved = (9, True) in found
    if curved and len(found) > 1:
        raise MeshError(
            f"{name}: 9-node quads are mixed with other cells, save one kind of cell only."
        )
    blocks, origins = [], []
    for kind in sorted(found):
        blocks.append(np.concatenate([cells for cells, _ in found[kind]]))
        origins.append(np.concatenate([origin for _, origin in found[kind]]))
        check_indices(points, blocks[-1], name)
    if curved:
        return blocks, np.concatenate(origins)
    blocks, where = tidy_faces(points, blocks, np.concatenate(origins), name)
    # gmsh lists a cell once for every group it is in: `drop_repeats` joins these
    return (blocks, where) if "gmsh:physical" in mesh.cell_data else drop_twins(blocks, where, name)


def _directors(mesh, points):
    """Unit directors (n, 3) stored in the file, or None; anything unfit counts as not stored."""
    data = mesh.point_data
    directors = data.get("directors")
    if directors is None and all(key in data for key in ("nx", "ny", "nz")):
        directors = np.stack([data["nx"], data["ny"], data["nz"]], axis=-1)
    if directors is None or np.shape(directors) != points.shape:
        return None
    directors = np.asarray(directors, dtype=np.float64)
    lengths = np.linalg.norm(directors, axis=1, keepdims=True)
    return directors / lengths if (np.abs(lengths - 1.0) < 1e-3).all() else None


def _same_side(surface):
    """The surface with all cells facing the side of most, and a warning if some had to turn."""
    turned = orient(surface, majority=True)
    count = int((turned.cells != surface.cells).any(axis=1).sum())
    if count:
        warnings.warn(
            f"{surface.source}: {count} of {len(surface.cells)} cells faced the other side than "
            "their neighbours and were turned.",
            stacklevel=3,
        )
    return turned


def _warn_unit(surface, unit):
    extent = diagonal(surface.points)
    if extent > 20.0 or extent < 0.01:
        warnings.warn(
            f"{surface.source}: read in '{unit}', the mesh measures {extent:.3g} m across, which "
            "no garment does; give the file's unit, as in load(path, unit='mm').",
            stacklevel=3,
        )


def save(surface: Surface, path: str | Path) -> None:
    """Write a surface to a file in m, completely or not at all.

    Parameters
    ----------
    surface : Surface. Directors, warp, named edges and panels are kept by .vtu and .vtk, all but
        the warp by .msh; .ply keeps the directors, .obj and .stl the shape alone (.stl as
        triangles).
    path : ending in one of these; on several ranks, only one may write.

    Raises
    ------
    MeshError : for an unknown ending, or curved cells in a format without them.
    """
    path = Path(path)
    kind = path.suffix.lower()
    if kind not in WRITTEN:
        raise MeshError(f"{path.name}: unknown file type '{kind}', use {', '.join(WRITTEN)}.")
    named = kind in (".msh", ".vtu", ".vtk")
    if surface.degree == 2 and not named:
        raise MeshError(f"{path.name}: {kind} files hold no curved cells, use .vtu or .msh.")
    if kind == ".stl" and surface.kind == "quadrilateral":
        surface = to_triangles(surface, "shortest")
    import meshio

    label = {3: "triangle", 4: "quad", 9: "quad9"}[surface.cells.shape[1]]
    # The writer of .ply complains about wider integers.
    cells = [(label, surface.cells.astype(np.int32) if kind == ".ply" else surface.cells)]
    mesh = meshio.Mesh(surface.points, cells)
    if kind == ".ply":
        assert surface.directors is not None  # what has passed the check has them
        mesh.point_data = dict(zip(("nx", "ny", "nz"), surface.directors.T.copy()))
    elif named:
        mesh = with_groups(surface, cells, kind == ".msh", path.name)
    options = {".msh": {"file_format": "gmsh22", "binary": False}}.get(kind, {})
    # The temporary name keeps the ending, by which the writer knows the format.
    part = path.with_name(f".{path.stem}.{os.getpid()}{path.suffix}")
    try:
        # numpy 2 writes np.float64(1.0) where meshio 5.3 wants the number
        with np.printoptions(legacy="1.21"):
            meshio.write(part, mesh, **options)
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)
