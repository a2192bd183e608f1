# SPDX-License-Identifier: LGPL-3.0-or-later
"""The internal force alone, for explicit steps: Eq. 14 without a tangent.

The virtual work of weak_form.py with the exact stress. 4-node quads in their default form and under
the default law go through quad_force.py; all else is differentiated by UFL, with everything that
does not move packed once. A call neither allocates nor creates a Vec.
"""

from typing import NamedTuple

import numpy as np

from shellform.material.energy import STRAINS

from .c_compiler import compiler_flags
from .cell_membrane import cell_warp
from .dolfinx_compat import (
    Constant,
    Function,
    add_ghosts,
    assemble_packed,
    cell_nodes,
    compiled,
    pack_coefficients,
    pack_constants,
)
from .quad_force import QuadForce
from .shell import Shell


class Frozen(NamedTuple):
    """A state about which the force is made smooth: that of a taut sheet whose sliders stick.

    relaxed : (m, 3), stress that relaxation adds [N/m], None for a sheet that is not relaxed
    strains : (m, 6), of `CellStress.strains`, None for a sheet without curves and friction
    """

    relaxed: np.ndarray | None
    strains: np.ndarray | None


class InternalForce:
    """Nodal internal forces of a shell.

    Parameters
    ----------
    shell : Shell

    Attributes
    ----------
    r : (n_local, 6) float, forces work-conjugate to (u, d) [N, N m]; valid on owned nodes
    quads : QuadForce, None where forms give the force
    cells : CellStress, None for a sheet without measured curves and friction inside
    loss : float [J], this rank's part of the power of damping in the last call, times its time
    """

    def __init__(self, shell: Shell, damped: bool = False):
        self.shell, self.damped, self.loss = shell, damped, 0.0
        self._result = Function(shell.space)
        # views of its memory, which stays where it is; dolfinx makes a new one at each `x.array`
        self._flat = self._result.x.array
        self.r = self._flat.reshape(-1, 6)
        self._parallel = shell.comm.size > 1
        self.quads: QuadForce | None = None
        self._packed: list[tuple] = []
        self._viscous: list[int] = []
        # load and weight of the arcs of each cell of a relaxed sheet
        self._cells_give: tuple[np.ndarray | None, np.ndarray | None] = (None, None)
        if by_segments(shell):
            forms, self.quads = [], self._by_segments()
            if shell.wrinkles is not None:
                self._cells_give = shell.wrinkles.load, shell.wrinkles.arcs
        else:
            forms = self._strain_forms()
        self.cells = shell.cell_stress
        # of quads that the kernel does not know
        self._membrane = None if self.quads is not None else shell.cell_membrane
        self._pressure = None
        if shell.loads.pressures:
            self._pressure = Constant(shell.mesh, 0.0)
            forms.append(shell.weak_form.pressure(self._pressure)[0])
        self._forms = (
            compiled([tuple(forms)], cffi_extra_compile_args=compiler_flags())[0] if forms else ()
        )
        if not forms:
            return
        width = 6 * shell.surface.cells.shape[1]
        dofs = cell_nodes(shell.space)
        self._index = (6 * dofs[:, :, None] + np.arange(6)).reshape(-1, width)
        self._cells = np.empty(self._index.shape)
        if self._viscous:
            self._rates, self._part = np.empty(self._index.shape), np.empty_like(self.r)
        self._packed = [self._pack(k, form) for k, form in enumerate(self._forms)]

    def _strain_forms(self):
        """Forms by rule: the internal force, each followed by its damping if there is any."""
        form, forms = self.shell.weak_form, []
        work = form.virtual_work()
        viscous = form.damping(self.shell.step) if self.damped else [None] * len(work)
        for force, damping in zip(work, viscous, strict=True):
            forms.append(force)
            if damping is not None:
                self._viscous.append(len(forms))
                forms.append(damping)
        return forms

    def _by_segments(self):
        shell, partition = self.shell, self.shell.partition
        cells = np.ascontiguousarray(cell_nodes(shell.space))
        points = shell.surface.points[partition.nodes] - partition.origin
        warp = cell_warp(shell.surface, shell.fabric, partition)
        directors = shell.reference.x.array.reshape(-1, 6)[:, 3:]
        fabric, flat = shell.fabric, partition.flat
        stiffer = None if shell.stiffer is None else shell.stiffer[partition.cells]
        return QuadForce(points, directors, cells, warp, fabric, shell.relaxed, flat, stiffer)

    def _pack(self, k, form):
        """Constants, coefficients, and the columns of the latter that hold w and its rates."""
        shell = self.shell
        coefficients = pack_coefficients(form)
        ((key, values),) = coefficients.items()
        columns = self._columns(form, shell.w, values)
        rates = self._columns(form, shell.step, values) if k in self._viscous else None
        return pack_constants(form), {key: values}, columns, rates

    def _columns(self, form, function, values):
        """Columns of the packed coefficients `values` that hold a function's cell values."""
        if not len(values):  # a rank without cells
            return np.empty(self._index.shape)
        array = function.x.array
        kept = array.copy()
        # numbers that no other coefficient holds
        array[:] = 1e9 + np.arange(len(array))
        ((_, marked),) = pack_coefficients(form).items()
        array[:] = kept
        first = int(np.flatnonzero(marked[0] >= 1e9)[0])
        columns = slice(first, first + self._index.shape[1])
        if not np.array_equal(marked[:, columns], 1e9 + self._index):
            raise RuntimeError("the packed coefficients of the form are not laid out as expected")
        return values[:, columns]

    def __call__(
        self,
        w: np.ndarray,
        pressure: float = 0.0,
        ahead: np.ndarray | None = None,
        frozen: Frozen | None = None,
    ) -> np.ndarray:
        """Compute the forces at the nodal field w (n_local, 6), ghosts valid; returns `r`.

        Sliders of friction inside the cloth slip to where w takes them, unless `frozen`.

        The force of a follower pressure [Pa] is taken off where the shell has any. `ahead`, used
        where the object is made to be damped: w plus its rates times the time of the damping.
        `frozen`, of `freeze`: the taut sheet under that stress, in place of a relaxed one.
        """
        if self._pressure is not None:
            self._pressure.value = pressure
            self._packed[-1][0][:] = pack_constants(self._forms[-1])
        flat = self._flat
        flat.fill(0.0)
        damped = self.damped and ahead is not None
        w, ahead = nodal(w), nodal(w if ahead is None or not damped else ahead)
        if self.quads is not None:
            still = None if frozen is None else frozen.relaxed
            self.loss = self.quads(w, self.r, ahead if damped else None, *self._cells_give, still)
        if self.cells is not None and frozen is None:
            self.cells.add_force(w, self.r)
        elif self.cells is not None and frozen is not None and frozen.strains is not None:
            self.cells.add_straightened(w, self.r, frozen.strains)
        if self._forms:
            np.take(w.reshape(-1), self._index, out=self._cells, mode="clip")
        if damped and self._viscous:
            np.take(ahead.reshape(-1), self._index, out=self._rates, mode="clip")
            self._rates -= self._cells
            self.loss = 0.0
        for form, packed in zip(self._forms, self._packed, strict=True):
            constants, coefficients, columns, rates = packed
            if rates is not None and not damped:
                continue
            columns[:] = self._cells
            if rates is None:
                assemble_packed(flat, form, constants, coefficients)
                continue
            rates[:] = self._rates
            self._part[:] = 0.0
            assemble_packed(self._part.ravel(), form, constants, coefficients)
            self.loss += np.vdot(self._part, ahead - w)
            self.r += self._part
        if self._membrane is not None:
            self._membrane.add_force(flat, w, rubbing=False)
            if damped:
                self._part[:] = 0.0
                self._membrane.add_damping(self._part.ravel(), w, ahead - w)
                self.loss += np.vdot(self._part, ahead - w)
                self.r += self._part
        if self._parallel:
            add_ghosts(self._result)
        return self.r

    def freeze(self, w: np.ndarray) -> Frozen | None:
        """What makes the force smooth about w; None where it is so."""
        (load, arcs), relaxed = self._cells_give, None
        if self.quads is not None and load is not None and arcs is not None:
            relaxed = self.quads.freeze(nodal(w), load, arcs)
        strains = None if self.cells is None else self.cells.strains(nodal(w))
        return None if relaxed is None and strains is None else Frozen(relaxed, strains)


def nodal(field: np.ndarray) -> np.ndarray:
    """A field (6 n,) or (n, 6) as (n, 6): the array itself where it is so, see QuadForce."""
    return field if field.ndim == 2 else field.reshape(-1, 6)


def by_segments(shell: Shell) -> bool:
    """True if quad_force.py knows the element and the law of a shell."""
    known = all(shell.law.is_quadratic(strain) or shell.law.in_the_middle for strain in STRAINS)
    return known and shell.in_default_form and shell.surface.cells.shape[1] == 4
