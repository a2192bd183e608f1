# SPDX-License-Identifier: LGPL-3.0-or-later
"""Lengths of the six segments of a quad in UFL, and their derivatives: Eqs. 12, 14.

A form sees a nodal field through derivatives at a point of a cell, but the length of a segment
belongs to two nodes. So the nodal values of a cell are gathered into a field that is constant in
it: 24 numbers, (u, d) of four nodes. Of these the lengths are plain expressions, differentiated as
the weak form needs it:

    lengths      s
    change       s'(w) dw, of a given change dw
    force        f . s'(w) v, f the pulls on the segments, dpsi/ds
    rates        t . s'(w) dw, the matrix s'
    geometric    f . s''(w) dw v
"""

import numpy as np

import ufl
from ufl.algorithms import expand_derivatives

from .arc import half_length_squared
from .dolfinx_compat import (
    Function,
    Mesh,
    assemble_matrix,
    assemble_packed,
    cell_nodes,
    compiled,
    create_matrix,
    pack_coefficients,
    pack_constants,
    vector_space,
)
from .element import measure
from .six_lengths import FIRST, SECOND

WIDTH = 24  # numbers a cell: u and d of four nodes


class SegmentForms:
    """Lengths of the segments of all cells of this rank, and their derivatives.

    Parameters
    ----------
    mesh : of 4-node quads; points : (m, 4, 3), corners at rest, in the order of its cells [m]
    weighted : True if arcs get a weight a cell, see `half_length_squared`

    Attributes
    ----------
    arcs : (m,) float, these weights; may be changed between calls
    """

    def __init__(self, mesh: Mesh, points: np.ndarray, weighted: bool = False):
        self._mesh, self._weighted = mesh, weighted
        self.w, self.step, at_rest = (self._field(WIDTH) for _ in range(3))
        self.pulls, self._scale = self._field(6), self._field(1)
        self._weights = self._field(1) if weighted else None
        self.arcs = np.ones(len(points))
        # fields of one number a cell may be numbered otherwise than cells
        self._where = cell_nodes(self.pulls.function_space)[:, 0]
        at_rest.x.array.reshape(-1, 4, 6)[self._where, :, :3] = points
        G1 = 0.5 * (points[:, 1] - points[:, 0] + points[:, 3] - points[:, 2])
        G2 = 0.5 * (points[:, 2] - points[:, 0] + points[:, 3] - points[:, 1])
        # the integral over a cell is its value at the middle times |G1 x G2|
        self._set(self._scale, 1.0 / np.linalg.norm(np.cross(G1, G2), axis=1))
        self._points = at_rest
        self._compiled: dict = {}

    def lengths(self, w: np.ndarray) -> np.ndarray:
        """|arc|^2/2 (m, 6) [m^2] at the nodal values w (m, 24)."""
        self._set(self.w, w)
        return self._vector("lengths", 6)

    def change(self, w: np.ndarray, step: np.ndarray) -> np.ndarray:
        """Change (m, 6) of the lengths at w (m, 24) by a small `step` (m, 24)."""
        self._set(self.w, w)
        self._set(self.step, step)
        return self._vector("change", 6)

    def force(self, w: np.ndarray, pulls: np.ndarray) -> np.ndarray:
        """Forces (m, 24) conjugate to the nodal values of pulls (m, 6) conjugate to the lengths."""
        self._set(self.w, w)
        self._set(self.pulls, pulls)
        return self._vector("force", WIDTH)

    def rates(self, w: np.ndarray) -> np.ndarray:
        """Derivatives (m, 6, 24) of the lengths by the nodal values."""
        self._set(self.w, w)
        return self._matrix("rates", 6)

    def geometric(self, w: np.ndarray, pulls: np.ndarray) -> np.ndarray:
        """Derivatives (m, 24, 24) of `force` with the pulls kept."""
        self._set(self.w, w)
        self._set(self.pulls, pulls)
        return self._matrix("geometric", WIDTH)

    # -- forms ------------------------------------------------------------------------------------

    def _lengths(self):
        points, w, lengths = self._points, self.w, []
        weight = self._weights[0] if self._weighted else 1
        node = lambda i: [w[6 * i + k] + points[6 * i + k] for k in range(6)]  # noqa: E731
        for i, j in zip(FIRST.tolist(), SECOND.tolist(), strict=True):
            change = [b - a for a, b in zip(node(i), node(j), strict=True)]
            x, d = ufl.as_vector(change[:3]), ufl.as_vector(change[3:])
            lengths.append(half_length_squared(ufl.dot(x, x), ufl.dot(x, d), ufl.dot(d, d), weight))
        return ufl.as_vector(lengths)

    def _rate(self, direction):
        return expand_derivatives(ufl.derivative(self._lengths(), self.w, direction))

    def _form(self, name):
        of_length, of_node = self.pulls.function_space, self.w.function_space
        t, v = ufl.TestFunction(of_length), ufl.TestFunction(of_node)
        if name == "lengths":
            integrand = ufl.dot(self._lengths(), t)
        elif name == "change":
            integrand = ufl.dot(self._rate(self.step), t)
        elif name == "force":
            integrand = ufl.dot(self.pulls, self._rate(v))
        elif name == "rates":
            integrand = ufl.dot(self._rate(ufl.TrialFunction(of_node)), t)
        else:
            work = ufl.dot(self.pulls, self._rate(v))
            integrand = ufl.derivative(work, self.w, ufl.TrialFunction(of_node))
        return integrand * self._scale[0] * measure(self._mesh, "centre")

    def _made(self, name):
        if name not in self._compiled:
            ((form,),) = compiled([(self._form(name),)])
            self._compiled[name] = form, {}
        return self._compiled[name]

    # -- assembly ---------------------------------------------------------------------------------

    def _field(self, width):
        return Function(vector_space(self._mesh, "DG", 0, width))

    def _set(self, field, values):
        width = field.function_space.dofmap.index_map_bs
        field.x.array.reshape(-1, width)[self._where] = np.reshape(values, (-1, width))

    def _vector(self, name, width):
        form, _ = self._made(name)
        self._refresh()
        result = np.zeros((len(self._where), width))
        assemble_packed(result.reshape(-1), form, pack_constants(form), pack_coefficients(form))
        return result[self._where]

    def _matrix(self, name, rows):
        form, kept = self._made(name)
        self._refresh()
        if "matrix" not in kept:
            kept["matrix"] = create_matrix(form)
        matrix = kept["matrix"]
        matrix.zeroEntries()
        assemble_matrix(matrix, form)
        matrix.assemble()
        *_, values = matrix.getValuesCSR()
        return values.reshape(-1, rows, WIDTH)[self._where]

    def _refresh(self):
        if self._weighted:
            self._set(self._weights, self.arcs)
