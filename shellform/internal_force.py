# SPDX-License-Identifier: LGPL-3.0-or-later
"""The internal force alone, for explicit steps: Eq. 14 without a tangent.

The same strain energy as shell.py, differentiated by UFL, with the exact stress. Everything that
does not move is packed once; a call copies the nodal field into the cells and runs the kernels.
It neither allocates nor creates a Vec.
"""

import numpy as np

import ufl
from dolfinx import cpp, fem, la
from ufl.algorithms import expand_derivatives

from .shell import compiled

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
    """

    def __init__(self, shell):
        self.shell = shell
        self._result = fem.Function(shell.space)
        self.r = self._result.x.array.reshape(-1, 6)
        self._parallel = shell.comm.size > 1
        v = ufl.TestFunction(shell.space)
        forms = []
        for dx, terms in shell.by_rule():
            work = 0
            for term in terms:
                virtual = expand_derivatives(
                    ufl.derivative(term.strain(shell.configuration(shell.w)), shell.w, v)
                )
                work += term.product(shell.strain(term.strain, shell.w), virtual) * dx
            forms.append(work)
        self._pressure = None
        if shell.loads.pressures:
            self._pressure = fem.Constant(shell.mesh, 0.0)
            forms.append(shell.pressure_force(self._pressure))
        self._forms = compiled([forms], cffi_extra_compile_args=FAST)[0]
        width = 6 * shell.surface.cells.shape[1]
        dofs = shell.space.dofmap.list.array.reshape(-1, width // 6)
        self._index = (6 * dofs[:, :, None] + np.arange(6)).reshape(-1, width)
        self._cells = np.empty(self._index.shape)
        self._packed = [self._pack(form) for form in self._forms]

    def _pack(self, form):
        """Constants, coefficients and the columns of the latter that hold w."""
        w = self.shell.w.x.array
        kept = w.copy()
        # mark w with numbers that no other coefficient holds, to find its columns
        w[:] = 1e9 + np.arange(len(w))
        coefficients = cpp.fem.pack_coefficients(form)
        ((key, values),) = coefficients.items()
        first = int(np.flatnonzero(values[0] >= 1e9)[0])
        w[:] = kept
        columns = values[:, first : first + self._index.shape[1]]
        if not np.array_equal(columns, 1e9 + self._index):
            raise RuntimeError("the packed coefficients of the form are not laid out as expected")
        return cpp.fem.pack_constants(form), {key: values}, columns

    def __call__(self, w, pressure=0.0):
        """Compute the forces at the nodal field w (n_local, 6), ghosts valid; returns `r`.

        The force of a follower pressure [Pa] is taken off where the shell has any.
        """
        if self._pressure is not None:
            self._pressure.value = pressure
            self._packed[-1][0][:] = cpp.fem.pack_constants(self._forms[-1])
        np.take(w.reshape(-1), self._index, out=self._cells, mode="clip")
        flat = self._result.x.array
        flat[:] = 0.0
        for form, (constants, coefficients, columns) in zip(self._forms, self._packed, strict=True):
            columns[:] = self._cells
            cpp.fem.assemble_vector(flat, form, constants, coefficients)
        if self._parallel:
            self._result.x.scatter_reverse(la.ScatterMode.add)
        return self.r
