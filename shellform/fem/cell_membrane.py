# SPDX-License-Identifier: LGPL-3.0-or-later
"""The membrane of 4-node quads by six lengths: energy, force and tangent: Eqs. 12, 13, 14.

With s the lengths of a cell less those at rest (segment_forms.py), E = B s and the modes m_k of
bending in plane (six_lengths.py), and the law psi (membrane_law.py),

    energy    area psi(B s) + sum over k of (m_k . s)^2/2
    pulls     f = area B^T psi'(B s) + sum over k of (m_k . s) m_k
    force     f . s'(w) v
    tangent   s'(w) dw . (area B^T psi'' B + sum over k of m_k m_k^T) s'(w) v + f . s''(w) dw v.

Cells that wrinkle have next to no stiffness of their own: the tangent, not the force, gets a small
part of that of the taut sheet.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from petsc4py import PETSc

import numpy as np

from meshes import Surface
from shellform.material.energy import StVenant
from shellform.material.sheet import Sheet
from shellform.material.wrinkling import WRINKLED

from .arc import half_length_squared
from .dolfinx_compat import cell_nodes
from .membrane_law import Density, MembraneLaw, Quadratic
from .partition import Partition
from .segment_forms import WIDTH, SegmentForms
from .six_lengths import FIRST, SECOND, lamina_axes, six_lengths
from .wrinkle_field import Wrinkling, crests, wrinkle_strain
from .wrinkles import Wrinkles

if TYPE_CHECKING:
    from .relaxed_law import Relaxed
    from .sliders import Sliders

NOT_RELAXED = "a sheet with wrinkles='resolved' has no cells that wrinkle: take wrinkles='relaxed'"
SPARE_STIFFNESS = 1e-4  # share of the taut stiffness in the tangent of cells that wrinkle


class CellMembrane:
    """Membrane of all cells of this rank.

    Parameters
    ----------
    partition : Partition of a surface of 4-node quads; fabric : Sheet; law : StVenant
    relaxed : True for a sheet that wrinkles below its cells
    reference : (n_local, 6), nodal field (u, d) at rest; kept, not copied

    Attributes
    ----------
    wrinkles : Wrinkles, None if resolved
    law : MembraneLaw
    sliders : Sliders of friction inside the cloth, or None
    B, modes, area : of the cells, see `six_lengths`
    """

    def __init__(
        self,
        partition: Partition,
        fabric: Sheet,
        law: StVenant,
        reference: np.ndarray,
        relaxed: bool = False,
    ):
        mesh, dofs = partition.mesh, cell_nodes(partition.space)
        self._index = (6 * dofs[:, :, None] + np.arange(6)).reshape(-1, WIDTH)
        self._reference, self._partition = reference, partition
        points = (partition.surface.points[partition.nodes] - partition.origin)[dofs]
        self._warp = cell_warp(partition.surface, fabric, partition)
        membrane = np.asarray(fabric.membrane)
        self._rest = points if partition.flat is None else partition.flat
        self.B, self.modes, self.area = six_lengths(self._rest, self._warp, membrane)
        # of cells cut from flat panels; others have the lengths of the reference state
        self._flat_lengths: np.ndarray | None = None
        if partition.flat is not None:
            sides = partition.flat[:, SECOND] - partition.flat[:, FIRST]
            self._flat_lengths = 0.5 * np.sum(sides**2, axis=2)
        self._forms = SegmentForms(mesh, points, weighted=relaxed)
        self._stiffness = membrane
        self.wrinkles: Wrinkles | None = None
        self._points, self._given = points, np.zeros(len(points))
        self.law: MembraneLaw
        self.sliders: Sliders | None = None
        self._relaxed: Relaxed | None = None
        if relaxed:
            # only here: its law is a kernel, and statics of other sheets need no compiler of those
            from .relaxed_law import Relaxed

            self.wrinkles = Wrinkles(fabric, np.sqrt(self.area))
            self._forms.arcs = self.wrinkles.arcs
            self.law = self._relaxed = Relaxed(self._stiffness, self.wrinkles)
        elif law.is_quadratic("membrane"):
            self.law = Quadratic(self._stiffness)
        else:
            self.law = Density(mesh, law, self._stiffness)

    def strain(self, w: np.ndarray) -> np.ndarray:
        """Strains (m, 3) of the cells, (E11, E22, 2 E12) along warp and weft, at a nodal field."""
        return np.einsum("mij,mj->mi", self.B, self._lengths(self._cells(w)))

    def energy(self, w: np.ndarray) -> float:
        """Energy [J] of this rank's cells at a nodal field w (n_local, 6)."""
        s = self._lengths(self._cells(w))
        density, *_ = self.law(np.einsum("mij,mj->mi", self.B, s))
        bending = np.einsum("mki,mi->mk", self.modes, s)
        return float(self.area @ density + 0.5 * np.sum(bending**2))

    def set_beds(self, stiffness: np.ndarray, w: np.ndarray) -> float:
        """Take over beds (m,) [Pa/m] of a relaxed sheet; the energy [J] that this adds at w."""
        wrinkles = self.wrinkles
        if wrinkles is None:
            raise ValueError(NOT_RELAXED)
        new = np.flatnonzero(stiffness != self._given)
        if not len(new):
            return 0.0
        before = self._stored(new, w)
        self._given[:] = stiffness
        wrinkles.set_beds(self._given)
        return self._stored(new, w) - before

    def wrinkling(self, w: np.ndarray) -> Wrinkling:
        """State, crest and wrinkle strain of the cells of a relaxed sheet at a nodal field w."""
        if self._relaxed is None:
            raise ValueError(NOT_RELAXED)
        E = np.einsum("mij,mj->mi", self.B, self._lengths_of(slice(None), w))
        _, stress, _ = self._relaxed(E)
        state, direction = self._relaxed.state.copy(), self._relaxed.direction
        corners = self._points + np.reshape(w, -1)[self._index].reshape(-1, 4, 6)[:, :, :3]
        axes = lamina_axes(self._rest, self._warp)
        crest = crests(self._rest, corners, axes, direction)
        crest[state != WRINKLED] = 0.0
        return Wrinkling(state, crest, wrinkle_strain(E, stress, self._stiffness, state))

    def _stored(self, cells, w):
        """Energy [J] of some cells; compiles nothing."""
        s = self._lengths_of(cells, w)
        energy, *_ = self.law(np.einsum("mij,mj->mi", self.B[cells], s), cells)
        bending = np.einsum("mki,mi->mk", self.modes[cells], s)
        return float(self.area[cells] @ energy + 0.5 * np.sum(bending**2))

    def _lengths_of(self, cells, w):
        """Lengths (k, 6) of some cells less those at rest; compiles nothing."""
        nodes = np.reshape(w, -1)[self._index[cells]].reshape(-1, 4, 6)
        if self._flat_lengths is not None:
            return self._of_arcs(cells, nodes) - self._flat_lengths[cells]
        rest = self._reference.reshape(-1)[self._index[cells]].reshape(-1, 4, 6)
        return self._of_arcs(cells, nodes) - self._of_arcs(cells, rest)

    def _of_arcs(self, cells, w):
        x, d = (
            field[:, SECOND] - field[:, FIRST]
            for field in (self._points[cells] + w[:, :, :3], w[:, :, 3:])
        )
        products = (np.sum(a * b, axis=2) for a, b in ((x, x), (x, d), (d, d)))
        return half_length_squared(*products, self._forms.arcs[cells, None])

    def add_force(
        self,
        out: np.ndarray,
        w: np.ndarray,
        stress_from: tuple[np.ndarray, np.ndarray] | None = None,
        rubbing: bool = True,
    ) -> None:
        """Add the nodal forces to `out` (6 n_local,), ghosts included.

        `stress_from` is (w_, dw_): the stress of the lengths linearised about w_; None: exact.
        `rubbing`: with the forces of the sliders.
        """
        cells = self._cells(w)
        pulls = self._pulls(self._stressing(cells, stress_from), rubbing)
        forces = self._forms.force(cells, pulls)
        np.add.at(out, self._index.reshape(-1), forces.reshape(-1))

    def add_damping(self, out: np.ndarray, w: np.ndarray, rates: np.ndarray) -> None:
        """Add the forces of the stiffness at rest times rates (n_local, 6) of the lengths."""
        cells = self._cells(w)
        change = self._forms.change(cells, self._cells(rates))
        strain = np.einsum("mij,mj->mi", self.B, change) @ self._stiffness
        pulls = self.area[:, None] * np.einsum("mij,mi->mj", self.B, strain)
        pulls += np.einsum("mki,mkj,mj->mi", self.modes, self.modes, change)
        forces = self._forms.force(cells, pulls)
        np.add.at(out, self._index.reshape(-1), forces.reshape(-1))

    def add_tangent(
        self,
        out: PETSc.Mat,
        w: np.ndarray,
        stress_from: tuple[np.ndarray, np.ndarray] | None = None,
    ) -> None:
        """Add the derivative of `add_force` to a matrix of the space, not yet assembled."""
        cells = self._cells(w)
        s = self._lengths(cells)
        E = np.einsum("mij,mj->mi", self.B, s)
        _, _, tangent = self.law(E)
        if self.sliders is not None:
            tangent = tangent + self.sliders(E)[1]
        if self.wrinkles is not None:
            tangent = tangent + SPARE_STIFFNESS * self._stiffness
        stiffness = np.einsum("mki,mkj->mij", self.modes, self.modes)
        stiffness += self.area[:, None, None] * (self.B.transpose(0, 2, 1) @ tangent @ self.B)
        rates = self._forms.rates(cells)
        values = rates.transpose(0, 2, 1) @ (stiffness @ rates)
        values += self._forms.geometric(cells, self._pulls(self._stressing(cells, stress_from)))
        rows = self._index.astype(PETSc.IntType)
        out.setValuesLocalIJV(
            np.arange(0, rows.size * WIDTH + 1, WIDTH, dtype=PETSc.IntType),
            np.repeat(rows, WIDTH, axis=0).reshape(-1),
            values.reshape(-1),
            addv=PETSc.InsertMode.ADD_VALUES,
            rowmap=rows.reshape(-1),
        )

    def _cells(self, w):
        return np.reshape(w, -1)[self._index]

    def _lengths(self, cells):
        if self._flat_lengths is not None:
            return self._forms.lengths(cells) - self._flat_lengths
        return self._forms.lengths(cells) - self._forms.lengths(self._cells(self._reference))

    def _stressing(self, cells, stress_from):
        if stress_from is None:
            return self._lengths(cells)
        before, step = (self._cells(field) for field in stress_from)
        return self._lengths(before) + self._forms.change(before, step)

    def _pulls(self, s, rubbing=True):
        E = np.einsum("mij,mj->mi", self.B, s)
        _, stress, _ = self.law(E)
        if rubbing and self.sliders is not None:
            stress = stress + self.sliders(E)[0]
        pulls = self.area[:, None] * np.einsum("mij,mi->mj", self.B, stress)
        return pulls + np.einsum("mki,mkj,mj->mi", self.modes, self.modes, s)


def cell_warp(surface: Surface, fabric: Sheet, partition: Partition) -> np.ndarray | None:
    """Warp (m, 3) of this rank's cells or (3,) of all; None if all directions are alike."""
    if fabric.directional and partition.flat is not None:
        return np.array([1.0, 0.0, 0.0])
    if not fabric.directional or surface.warp is None:
        return None
    warp = np.asarray(surface.warp, float)
    if warp.ndim == 1:
        return warp
    return warp[partition.cells]
