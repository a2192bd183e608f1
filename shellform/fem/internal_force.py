# SPDX-License-Identifier: LGPL-3.0-or-later
"""The internal force alone, for explicit steps: Eq. 14 without a tangent.

The same strain energy as shell.py with the exact stress. 4-node quads in their default form go
through quad_force.py; all else is differentiated by UFL, with everything that does not move packed
once. A call neither allocates nor creates a Vec.
"""

import numpy as np

import ufl
from dolfinx import cpp, fem, la
from ufl.algorithms import expand_derivatives

from .dolfinx_compat import compiled
from .quad_kernel import add_force, baked

# without NaN or infinity assumed away: a step that explodes must be seen to
FAST = ["-O3", "-march=native", "-fno-math-errno", "-fno-trapping-math", "-fassociative-math"]
FAST += ["-fno-signed-zeros", "-freciprocal-math", "-ffp-contract=fast"]


class InternalForce:
    """Nodal internal forces of a shell.

    Parameters
    ----------
    shell : Shell

    Attributes
    ----------
    r : (n_local, 6) float, forces work-conjugate to (u, d) [N, N m]; valid on owned nodes
    loss : float [J], this rank's part of the power of damping in the last call, times its time
    """

    def __init__(self, shell, damped=False):
        self.shell, self.damped, self.loss = shell, damped, 0.0
        self._result = fem.Function(shell.space)
        self.r = self._result.x.array.reshape(-1, 6)
        self._parallel = shell.comm.size > 1
        self._quads, self._packed, self._rates, self._viscous = None, [], None, []
        if by_segments(shell):
            forms, self._quads = [], self._bake()
        else:
            forms = self._strain_forms()
        self._pressure = None
        if shell.loads.pressures:
            self._pressure = fem.Constant(shell.mesh, 0.0)
            forms.append(shell.pressure_force(self._pressure))
        self._forms = compiled([forms], cffi_extra_compile_args=FAST)[0] if forms else ()
        if not forms:
            return
        width = 6 * shell.surface.cells.shape[1]
        dofs = shell.space.dofmap.list.array.reshape(-1, width // 6)
        self._index = (6 * dofs[:, :, None] + np.arange(6)).reshape(-1, width)
        self._cells = np.empty(self._index.shape)
        if self._viscous:
            self._rates, self._part = np.empty(self._index.shape), np.empty_like(self.r)
        self._packed = [self._pack(k, form) for k, form in enumerate(self._forms)]

    def _strain_forms(self):
        shell, forms = self.shell, []
        v = ufl.TestFunction(shell.space)
        for dx, terms in shell.by_rule():
            work = viscous = 0
            for term in terms:
                strain = term.strain(shell.configuration(shell.w))
                virtual = expand_derivatives(ufl.derivative(strain, shell.w, v))
                work += term.product(shell.strain(term.strain, shell.w), virtual) * dx
                if self.damped:
                    rate = expand_derivatives(ufl.derivative(strain, shell.w, shell.step))
                    viscous += term.product(rate, virtual) * dx
            forms.append(work)
            if self.damped:
                self._viscous.append(len(forms))
                forms.append(viscous)
        return forms

    def _bake(self):
        shell, partition = self.shell, self.shell.partition
        cells = np.ascontiguousarray(shell.space.dofmap.list.array.reshape(-1, 4))
        points = shell.surface.points[partition.nodes] - partition.origin
        warp = shell.surface.warp if shell.fabric.directional else None
        if warp is not None and np.ndim(warp) == 2:
            warp = warp[np.asarray(shell.mesh.topology.original_cell_index)[: len(cells)]]
        directors = shell.reference.x.array.reshape(-1, 6)[:, 3:]
        return points, cells, *baked(points, directors, cells, warp, shell.fabric)

    def _pack(self, k, form):
        """Constants, coefficients, and the columns of the latter that hold w and its rates."""
        shell = self.shell
        coefficients = cpp.fem.pack_coefficients(form)
        ((key, values),) = coefficients.items()
        columns = self._columns(form, shell.w, values)
        rates = self._columns(form, shell.step, values) if k in self._viscous else None
        return cpp.fem.pack_constants(form), {key: values}, columns, rates

    def _columns(self, form, function, values):
        """Columns of the packed coefficients `values` that hold a function's cell values."""
        array = function.x.array
        kept = array.copy()
        # numbers that no other coefficient holds
        array[:] = 1e9 + np.arange(len(array))
        ((_, marked),) = cpp.fem.pack_coefficients(form).items()
        array[:] = kept
        first = int(np.flatnonzero(marked[0] >= 1e9)[0])
        columns = slice(first, first + self._index.shape[1])
        if not np.array_equal(marked[:, columns], 1e9 + self._index):
            raise RuntimeError("the packed coefficients of the form are not laid out as expected")
        return values[:, columns]

    def __call__(self, w, pressure=0.0, ahead=None):
        """Compute the forces at the nodal field w (n_local, 6), ghosts valid; returns `r`.

        The force of a follower pressure [Pa] is taken off where the shell has any. `ahead`, used
        where the object is made to be damped: w plus its rates times the time of the damping.
        """
        if self._pressure is not None:
            self._pressure.value = pressure
            self._packed[-1][0][:] = cpp.fem.pack_constants(self._forms[-1])
        flat = self._result.x.array
        flat[:] = 0.0
        w = w.reshape(-1, 6)
        damped = self.damped and ahead is not None
        ahead = ahead.reshape(-1, 6) if damped else w
        if self._quads is not None:
            self.loss = add_force(w, ahead, damped, *self._quads, self.r)
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
                cpp.fem.assemble_vector(flat, form, constants, coefficients)
                continue
            rates[:] = self._rates
            self._part[:] = 0.0
            cpp.fem.assemble_vector(self._part.ravel(), form, constants, coefficients)
            self.loss += np.vdot(self._part, ahead - w)
            self.r += self._part
        if self._parallel:
            self._result.x.scatter_reverse(la.ScatterMode.add)
        return self.r


def by_segments(shell):
    """True if quad_force.py knows the element of a shell."""
    plain = shell.options == {"membrane": "arcs", "curvature": "turning", "thick": False}
    return plain and shell.surface.cells.shape[1] == 4 and not np.any(shell.fabric.coupling)
