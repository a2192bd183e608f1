# SPDX-License-Identifier: LGPL-3.0-or-later
"""A surface shared out over MPI ranks, with the way back to the user's node numbers.

Every rank holds the whole `meshes.Surface` (arrays are small beside matrices) and the part of it
that dolfinx assigned. Whatever the user names (an edge, a locator function, node numbers, a point)
is resolved in the surface's own numbering, the same on every rank, then cut to the rank.
"""

from collections.abc import Callable
from functools import cached_property
from typing import Any

from mpi4py import MPI
from petsc4py import PETSc

import numpy as np
from numpy.typing import ArrayLike

from meshes import Surface
from meshes.sheets import seams

from .dolfinx_compat import (
    Function,
    Mesh,
    cell_nodes,
    geometry_nodes,
    given_cells,
    given_points,
    surface_mesh,
    vector_space,
)
from .sewn_parts import order_of_cells, ranks_of_cells, sharing_ranks

# corners of a dolfinx cell run in tensor order, those of a surface in cyclic order
DOLFINX_ORDER = {3: [0, 1, 2], 4: [0, 1, 3, 2], 9: [0, 1, 3, 2, 4, 7, 5, 6, 8]}

# a name, a function of points, a point, or node numbers: see `Partition.find`
Place = str | Callable[[np.ndarray], ArrayLike] | ArrayLike


class Partition:
    """The part of a surface that this rank works on.

    Attributes
    ----------
    surface : meshes.Surface, whole, in the user's numbering
    mesh : dolfinx.mesh.Mesh
        Coordinates are relative to `origin`: a garment far from the origin loses no digits.
    cells : (m_local,) int64, surface cell of every cell of this rank
    space : fem.FunctionSpace of the nodal field w = (u, d), 6 components
    nodes : (n_local,) int64, surface node of every local node, owned ones first, then ghosts
    n_owned, n_local : int
    local_numbers : (n,) int64, local number of every surface node, -1 on other ranks
    directors : (n_local, 3), reference directors
    origin : (3,) [m]; length : float [m], square root of the area, the scale of the scene
    """

    def __init__(self, surface: Surface, comm: MPI.Comm = MPI.COMM_WORLD):
        self.surface, self.comm = surface, comm
        self.origin = surface.points.mean(axis=0)
        self.length = float(np.sqrt(surface.area))
        cells = surface.cells[:, DOLFINX_ORDER[surface.cells.shape[1]]]
        self.mesh, order = _shared_out(surface, comm, cells, surface.points - self.origin)
        self.cells = order[given_cells(self.mesh)]
        self.space = vector_space(self.mesh, "Lagrange", surface.degree, 6)
        index_map = self.space.dofmap.index_map
        self.n_owned, self.n_local = (
            index_map.size_local,
            index_map.size_local + index_map.num_ghosts,
        )
        # fields and geometry share one element, so their cell dofmaps correspond entry by entry
        self.nodes = np.full(self.n_local, -1, np.int64)
        points = geometry_nodes(self.mesh, cells.shape[1])
        self.nodes[cell_nodes(self.space)] = given_points(self.mesh)[points]
        self.owned_nodes = self.nodes[: self.n_owned]
        self.local_numbers = np.full(len(surface.points), -1, np.int64)
        self.local_numbers[self.nodes] = np.arange(self.n_local)
        self.directors = np.asarray(surface.directors)[self.nodes]

    @cached_property
    def flat(self) -> np.ndarray | None:
        """Corners (m_local, k, 3) of the cells in their flat panels, warp along the first axis.

        In tensor order; None for a sheet whose rest shape is that of its points.
        """
        surface = self.surface
        if surface.flat is None:
            return None
        order = DOLFINX_ORDER[surface.cells.shape[1]]
        return np.ascontiguousarray(surface.corners_at_rest[self.cells][:, order])

    @cached_property
    def flat_field(self) -> Function | None:
        """The corners `flat` as a field that need not agree between cells; None without."""
        if self.flat is None:
            return None
        field = Function(vector_space(self.mesh, "DG", 1, 3))
        field.x.array.reshape(-1, 3)[cell_nodes(field.function_space)] = self.flat
        return field

    def petsc_vector(self, width: int) -> PETSc.Vec:
        """Vec with `width` numbers a node, ghosts included."""
        nodes = self.space.dofmap.index_map
        size = width * nodes.size_local, width * nodes.size_global
        ghosts = nodes.ghosts.astype(PETSc.IntType)
        return PETSc.Vec().createGhost(ghosts, size=size, bsize=width, comm=self.comm)

    def find(self, where: Any) -> np.ndarray:
        """Surface node numbers, sorted, of a place in the garment.

        Parameters
        ----------
        where : str, callable, (3,) point or numpy array of int
            Name of an edge; function of points (n, 3) [m] returning a mask (n,); a point, which
            stands for the nearest node (at most half a cell away); node numbers or a mask, as
            numpy arrays only, so that the point (10, 0, 0) cannot be taken for three nodes.

        Raises
        ------
        ValueError if the name is unknown, nothing is found or a node does not exist
        """
        surface = self.surface
        if isinstance(where, str):
            return np.unique(self.edge(where))
        if callable(where):
            mask = np.asarray(where(surface.points))
            if mask.shape != (len(surface.points),) or mask.dtype != bool:
                raise ValueError(
                    f"a locator must return one boolean per point, shape ({len(surface.points)},); "
                    f"{getattr(where, '__name__', where)} returned {mask.dtype} {mask.shape}"
                )
            found = np.flatnonzero(mask)
            if len(found) == 0:
                raise ValueError(
                    f"the locator {getattr(where, '__name__', where)} selects no node of "
                    f"{surface.source}; its points span {surface.bounds.tolist()} m"
                )
            return found
        if isinstance(where, np.ndarray) and where.dtype == bool:
            return self.find(lambda points: where)
        if isinstance(where, np.ndarray) and where.dtype.kind in "iu":
            if where.size == 0 or where.min() < 0 or where.max() >= len(surface.points):
                raise ValueError(
                    f"node numbers must lie in 0..{len(surface.points) - 1} for {surface.source}"
                )
            return np.unique(where)
        where = np.asarray(where, float)
        if where.shape != (3,):
            raise ValueError(
                "a place is an edge name, a function of points, a point (x, y, z) or a numpy "
                f"array of node numbers, not an array of shape {where.shape}"
            )
        distance = np.linalg.norm(surface.points - where, axis=1)
        nearest = int(distance.argmin())
        if not distance[nearest] <= 0.5 * surface.mean_cell_size:
            raise ValueError(
                f"no node of {surface.source} near {where.tolist()}: the closest, "
                f"{surface.points[nearest].tolist()}, is {distance[nearest]:.3g} m away"
            )
        return np.array([nearest])

    def edge(self, name: str) -> np.ndarray:
        """Segments (k, 2 or 3) of a named edge; ValueError if there is none of that name."""
        edges = self.surface.edges
        if name not in edges:
            raise ValueError(
                f"{self.surface.source} has no edge '{name}'; it has "
                + (", ".join(sorted(edges)) or "none: name one by surface.with_edges")
            )
        return edges[name]

    def local(self, nodes: np.ndarray) -> np.ndarray:
        """Local numbers (owned and ghost) of surface nodes, those on this rank only."""
        local = self.local_numbers[nodes]
        return local[local >= 0]

    def gather(self, owned: np.ndarray, root: int | None = None) -> Any:
        """Nodal values in the surface's numbering from every rank's owned part.

        Parameters
        ----------
        owned : (n_owned, k) float
        root : int or None, the only rank that receives them; None: all ranks

        Returns
        -------
        (n, k) float, or None on the other ranks
        """
        pair = (self.owned_nodes, np.ascontiguousarray(owned))
        parts = self.comm.allgather(pair) if root is None else self.comm.gather(pair, root)
        if parts is None:
            return None
        whole = np.empty((len(self.surface.points), *np.shape(owned)[1:]))
        for nodes, values in parts:
            whole[nodes] = values
        return whole

    def gather_cells(self, values: np.ndarray) -> np.ndarray:
        """Values (m, k) of the surface's cells, on all ranks, from those (m_local, k) of each."""
        own = self.cells[: len(values)], np.ascontiguousarray(values)
        whole = np.empty((len(self.surface.cells), *np.shape(values)[1:]))
        for cells, part in self.comm.allgather(own):
            whole[cells] = part
        return whole


def _shared_out(
    surface: Surface, comm: MPI.Comm, cells: np.ndarray, points: np.ndarray
) -> tuple[Mesh, np.ndarray]:
    """Mesh of the surface and the order (m,) in which dolfinx was given its cells."""
    crowded = seams(surface.cells)
    if not crowded:
        order = np.arange(len(cells))
        return surface_mesh(comm, surface.kind, surface.degree, cells, points), order
    order, ranks = order_of_cells(surface), None
    if comm.size > 1:
        ranks = sharing_ranks(surface.cells[order], ranks_of_cells(surface, comm.size)[order])
    most = max(map(len, crowded))
    mesh = surface_mesh(comm, surface.kind, surface.degree, cells[order], points, most, ranks)
    return mesh, order
