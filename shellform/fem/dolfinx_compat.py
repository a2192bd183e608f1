# SPDX-License-Identifier: LGPL-3.0-or-later
"""What differs between versions of dolfinx, UFL and FFCx: no other file imports dolfinx.

One tree runs on dolfinx 0.5.2 to 0.11. What a version has is found by name (`hasattr`, parameters
of a function), not by number, so that releases between those tried fall on the right side.
"""

import inspect
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np

import basix
import ufl
from ufl.core.expr import Expr as Expr

from .c_compiler import form_flags
from .killed_compile import comm_of
from .plain_arguments import plain_arguments
from .quiet_compiler import quiet_compiler

with plain_arguments():
    import dolfinx
    from dolfinx import cpp, fem, jit, la
    from dolfinx.fem import Constant as Constant
    from dolfinx.fem import Function as Function
    from dolfinx.fem import FunctionSpace as FunctionSpace
    from dolfinx.fem import assemble_scalar as assemble_scalar
    from dolfinx.fem.petsc import assemble_matrix as assemble_matrix
    from dolfinx.fem.petsc import assemble_vector as assemble_vector
    from dolfinx.fem.petsc import create_matrix as create_matrix
    from dolfinx.mesh import Mesh as Mesh

VERSION = dolfinx.__version__
JIT = {"timeout": 600}  # a rank that waits for another rank's compiler must not give up
release = tuple(int(n) for n in VERSION.split(".")[:3] if n.isdigit())
if release < (0, 5, 2):
    raise ImportError(f"dolfinx {VERSION} is too old for shellform, which needs 0.5.2 or newer")
if release >= (0, 12):
    warnings.warn(f"dolfinx {VERSION} is newer than those shellform was tried on", stacklevel=2)
if PETSc.ScalarType is not np.float64:
    raise ImportError(
        "PETSc has complex numbers or single precision here; shellform needs the real build: "
        "Debian's python3-dolfinx-real, PyPI's dolfinx-solver-real"
    )

_TO_COMPILE = inspect.signature(fem.form).parameters
_OPTIONS = "jit_options" if "jit_options" in _TO_COMPILE else "jit_params"
_REASONS = PETSc.SNES.ConvergedReason  # of a residual that is no number, renamed in PETSc 3.25
_NOT_FINITE = ("DIVERGED_FNORM_NAN", "DIVERGED_FUNCTION_NANORINF")
DIVERGED_NOT_FINITE = next(getattr(_REASONS, n) for n in _NOT_FINITE if hasattr(_REASONS, n))
_TO_MAKE = inspect.signature(dolfinx.mesh.create_mesh).parameters


def compiled(groups: Sequence[tuple], **options: object) -> list[tuple]:
    """Compile tuples of UFL forms; all signatures first: compiling one changes those of others."""
    flags = form_flags()
    of_forms = {} if flags is None else {"cffi_extra_compile_args": flags}
    jit_options: dict[str, Any] = {_OPTIONS: JIT | of_forms | options}
    for form in (form for group in groups for form in group):
        form.signature()
    with quiet_compiler(_forms_folder(), comm_of(groups), sum(map(len, groups))):
        return [tuple(fem.form(form, **jit_options) for form in group) for group in groups]


def cache_folder() -> Path:
    """Folder of compiled C code other than forms, inside FFCx's."""
    return _forms_folder() / "shellform"


def _forms_folder() -> Path:
    """Folder of compiled forms."""
    options = jit.get_options() if hasattr(jit, "get_options") else jit.get_parameters()
    return Path(options["cache_dir"])


def surface_mesh(
    comm: MPI.Comm,
    kind: str,
    degree: int,
    cells: np.ndarray,
    points: np.ndarray,
    at_edge: int = 2,
    ranks: tuple[np.ndarray, np.ndarray] | None = None,
) -> Mesh:
    """Mesh of a surface in 3-D shared out over the ranks.

    Parameters
    ----------
    kind : 'triangle' or 'quadrilateral'; degree : of the geometry
    cells : (m, k) int, nodes in dolfinx's order; points : (n, 3) [m]; both as rank 0 has them
    at_edge : most cells that meet at an edge
    ranks : data and offsets (m + 1,), both int32, of the rank of each cell and those that have a
        cell with a side of it; None leaves them to dolfinx
    """
    first = comm.rank == 0
    given: dict[str, Any] = {
        "cells": cells if first else np.empty((0, cells.shape[1]), np.int64),
        "x": points if first else np.empty((0, 3)),
        "e" if "e" in _TO_MAKE else "domain": ufl.Mesh(_element("Lagrange", kind, degree, 3)),
    }
    if "ghost_mode" in _TO_MAKE:
        given["ghost_mode"] = dolfinx.mesh.GhostMode.none
    if "max_facet_to_cell_links" in _TO_MAKE:
        given["max_facet_to_cell_links"] = at_edge
    if ranks is not None:
        data, offsets = ranks if first else (ranks[0][:0], ranks[1][:1])
        if "ghost_mode" not in _TO_MAKE:  # where there is one, neighbours are dropped again
            data, offsets = data[offsets[:-1]], np.arange(len(offsets), dtype=np.int32)
        given["partitioner"] = lambda *_: cpp.graph.AdjacencyList_int32(data, offsets)
    with quiet_compiler(_forms_folder(), comm):
        return dolfinx.mesh.create_mesh(comm, **given)


def vector_space(mesh: Mesh, family: str, degree: int, width: int) -> FunctionSpace:
    """Space of fields with `width` components: 'Lagrange', or 'DG', one polynomial a cell."""
    element = _element(family, cell_name(mesh), degree, width)
    with quiet_compiler(_forms_folder(), mesh.comm):
        return getattr(fem, "functionspace", FunctionSpace)(mesh, element)


def _element(family: str, kind: str, degree: int, width: int) -> Any:
    """Element of UFL with `width` components on cells in 3-D."""
    make = getattr(getattr(basix, "ufl", None), "element", None)
    if make is None:
        if family == "DG" and kind == "quadrilateral" and degree:
            family = "DQ"
        cell = ufl.Cell(kind, geometric_dimension=3)
        return ufl.VectorElement(family, cell, degree, dim=width)
    gdim = {"gdim": 3} if "gdim" in inspect.signature(make).parameters else {}
    return make(family, kind, degree, shape=(width,), **gdim)


def cell_name(mesh: Mesh) -> str:
    """'triangle' or 'quadrilateral'."""
    name = mesh.ufl_cell().cellname
    return name() if callable(name) else name


def cell_nodes(space: FunctionSpace) -> np.ndarray:
    """Local nodes (m, k) of the cells of this rank, in dolfinx's order."""
    return _table(space.dofmap.list, space.dofmap.dof_layout.num_dofs)


def geometry_nodes(mesh: Mesh, width: int) -> np.ndarray:
    """Local points (m, width) of the geometry of the cells of this rank, which may have none."""
    maps = getattr(mesh.geometry, "dofmaps", None)
    return _table(maps[0] if isinstance(maps, list) else mesh.geometry.dofmap, width)


def _table(rows: Any, width: int) -> np.ndarray:
    """Rows (m, width) of a table, which was an adjacency list once."""
    return np.asarray(getattr(rows, "array", rows)).reshape(-1, width)


def given_points(mesh: Mesh) -> np.ndarray:
    """Number (p,) that each local point of the geometry had when the mesh was made."""
    return np.asarray(mesh.geometry.input_global_indices)


def given_cells(mesh: Mesh) -> np.ndarray:
    """Number (m,) that each cell of this rank had when the mesh was made."""
    return np.asarray(mesh.topology.original_cell_index)


def petsc_view(field: Function) -> PETSc.Vec:
    """Vec that shares the values of a field."""
    return field.vector if hasattr(field, "vector") else field.x.petsc_vec


def add_ghosts(field: Function) -> None:
    """Add what ghosts have to the values of their owners."""
    field.x.scatter_reverse((la.InsertMode if hasattr(la, "InsertMode") else la.ScatterMode).add)


def pack_constants(form: Any) -> np.ndarray:
    """Constants of a compiled form, in one array."""
    return cpp.fem.pack_constants(_of_cpp(form))


def pack_coefficients(form: Any) -> dict[Any, np.ndarray]:
    """Values of the coefficients of a compiled form, a row a cell, by kind of integral."""
    return cpp.fem.pack_coefficients(_of_cpp(form))


def assemble_packed(
    out: np.ndarray, form: Any, constants: np.ndarray, coefficients: dict[Any, np.ndarray]
) -> None:
    """Add a form to an array (n,) by constants and coefficients as packed; allocates nothing."""
    cpp.fem.assemble_vector(out, _of_cpp(form), constants, coefficients)


def _of_cpp(form: Any) -> Any:
    """The form of C++, which older versions hand out as it is."""
    return getattr(form, "_cpp_object", form)
