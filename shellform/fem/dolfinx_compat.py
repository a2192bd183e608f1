# SPDX-License-Identifier: LGPL-3.0-or-later
"""What differs between versions of dolfinx, UFL and FFCx: no other file imports dolfinx.

Forms are compiled when first met and kept by FFCx on disk. Compilers are kept from the terminal:
setuptools takes over the root logger as a side effect. What was compiled and how long it took is
told to the logger `shellform`, which the command lines show and which says nothing elsewhere unless
it is asked for.
"""

import logging
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np

import dolfinx
import ufl
from dolfinx import cpp, fem, jit, la
from dolfinx.fem import Constant as Constant
from dolfinx.fem import Function as Function
from dolfinx.fem import FunctionSpace as FunctionSpace
from dolfinx.fem import assemble_scalar as assemble_scalar
from dolfinx.fem import petsc as fem_petsc
from dolfinx.mesh import Mesh as Mesh
from ufl.core.expr import Expr as Expr

VERSION = dolfinx.__version__
LOG = logging.getLogger("shellform")
# a rank that waits for another rank's compiler must not give up
JIT = {"timeout": 600}

pack_constants = cpp.fem.pack_constants
pack_coefficients = cpp.fem.pack_coefficients
# into an array (n, ) from packed constants and coefficients; allocates nothing
assemble_packed = cpp.fem.assemble_vector
# of the owned part into a Vec or Mat of PETSc
assemble_vector = fem_petsc.assemble_vector
assemble_matrix = fem_petsc.assemble_matrix
create_matrix = fem_petsc.create_matrix


# ---------------------------------------------------------------- compiled code


def compiled(groups: Sequence[tuple], **options: object) -> list[tuple]:
    """Compile tuples of UFL forms; all signatures first: compiling one changes those of others."""
    for form in (form for group in groups for form in group):
        form.signature()
    with _compiler(sum(map(len, groups))):
        return [
            tuple(fem.form(form, jit_params=JIT | options) for form in group) for group in groups
        ]


@contextmanager
def _compiler(forms: int = 0) -> Iterator[None]:
    """Keep a compiler's words from the terminal, and say how long forms took, if any was new."""
    root, disabled = logging.root, logging.root.manager.disable
    before = root.level, root.handlers[:]
    cached, start = _changed(), time.perf_counter()
    logging.disable(logging.INFO)
    try:
        yield
    finally:
        logging.disable(disabled)
        root.setLevel(before[0])
        root.handlers[:] = before[1]
    if forms and _changed() != cached:
        LOG.info(
            "compiled %d form%s of the finite elements in %.1f s; they are kept for the next run",
            *(forms, "" if forms == 1 else "s", time.perf_counter() - start),
        )


def cache_folder() -> Path:
    """Folder of compiled C code other than forms, inside FFCx's."""
    return Path(jit.get_parameters()["cache_dir"]) / "shellform"


def _changed() -> int | None:
    """When a file came to or left FFCx's folder [ns]; None before there is one."""
    try:
        return jit.get_parameters()["cache_dir"].stat().st_mtime_ns
    except FileNotFoundError:
        return None


# ---------------------------------------------------------------- meshes and fields


def surface_mesh(
    comm: MPI.Comm, kind: str, degree: int, cells: np.ndarray, points: np.ndarray
) -> Mesh:
    """Mesh of a surface in 3-D shared out over the ranks.

    Parameters
    ----------
    kind : 'triangle' or 'quadrilateral'; degree : of the geometry
    cells : (m, k) int, nodes in dolfinx's order; points : (n, 3) [m]; both as rank 0 has them
    """
    first = comm.rank == 0
    element = ufl.VectorElement("Lagrange", ufl.Cell(kind, geometric_dimension=3), degree)
    with _compiler():
        return dolfinx.mesh.create_mesh(
            comm,
            cells if first else np.empty((0, cells.shape[1]), np.int64),
            points if first else np.empty((0, 3)),
            ufl.Mesh(element),
            dolfinx.mesh.GhostMode.none,
        )


def vector_space(mesh: Mesh, family: str, degree: int, width: int) -> FunctionSpace:
    """Space of fields with `width` components: 'Lagrange', or 'DG', one polynomial a cell."""
    if family == "DG" and cell_name(mesh) == "quadrilateral" and degree:
        family = "DQ"
    element = ufl.VectorElement(family, mesh.ufl_cell(), degree, dim=width)
    with _compiler():
        return fem.FunctionSpace(mesh, element)


def cell_name(mesh: Mesh) -> str:
    """'triangle' or 'quadrilateral'."""
    return mesh.ufl_cell().cellname()


def cell_nodes(space: FunctionSpace) -> np.ndarray:
    """Local nodes (m, k) of the cells of this rank, in dolfinx's order."""
    dofmap = space.dofmap
    return dofmap.list.array.reshape(-1, dofmap.dof_layout.num_dofs)


def geometry_nodes(mesh: Mesh, width: int) -> np.ndarray:
    """Local points (m, width) of the geometry of the cells of this rank, which may have none."""
    return mesh.geometry.dofmap.array.reshape(-1, width)


def given_points(mesh: Mesh) -> np.ndarray:
    """Number (p,) that each local point of the geometry had when the mesh was made."""
    return np.asarray(mesh.geometry.input_global_indices)


def given_cells(mesh: Mesh) -> np.ndarray:
    """Number (m,) that each cell of this rank had when the mesh was made."""
    return np.asarray(mesh.topology.original_cell_index)


# ---------------------------------------------------------------- vectors


def petsc_vector(space: FunctionSpace, width: int) -> PETSc.Vec:
    """Vec with `width` numbers a node, ghosts included."""
    return la.create_petsc_vector(space.dofmap.index_map, width)


def petsc_view(field: Function) -> PETSc.Vec:
    """Vec that shares the values of a field."""
    return field.vector


def add_ghosts(field: Function) -> None:
    """Add what ghosts have to the values of their owners."""
    field.x.scatter_reverse(la.ScatterMode.add)
