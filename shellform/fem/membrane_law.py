# SPDX-License-Identifier: LGPL-3.0-or-later
"""Membrane laws cell by cell: energy, stress and tangent of the strain of a cell: Eqs. 11, 12.

The strain of a quad's membrane is constant in a cell, so its law is a function of three numbers a
cell: quadratic, relaxed (material/wrinkling.py), or any density in UFL (material/energy.py).
"""

from typing import Protocol

import numpy as np

import ufl
from ufl.algorithms import expand_derivatives

from shellform.material.energy import StVenant

from .dolfinx_compat import (
    Constant,
    Function,
    Mesh,
    assemble_packed,
    cell_nodes,
    compiled,
    pack_coefficients,
    pack_constants,
    vector_space,
)
from .element import measure

Answer = tuple[np.ndarray, np.ndarray, np.ndarray]


class MembraneLaw(Protocol):
    """Energy (m,) [J/m^2], stress (m, 3) and tangent (m, 3, 3) [N/m] of strains (m, 3).

    `cells` (m,) int names those whose strains are given, None: all of this rank.
    """

    def __call__(self, E: np.ndarray, cells: np.ndarray | None = None) -> Answer: ...


class Quadratic:
    """E.A.E/2 with the stiffness A (3, 3) [N/m] of a fabric."""

    def __init__(self, membrane: np.ndarray):
        self._membrane = membrane

    def __call__(self, E: np.ndarray, cells: np.ndarray | None = None) -> Answer:
        stress = E @ self._membrane
        tangent = np.broadcast_to(self._membrane, (len(E), 3, 3))
        return 0.5 * np.sum(stress * E, axis=1), stress, tangent


class Density:
    """The membrane energy that a law of `Shell` writes in UFL.

    Parameters
    ----------
    mesh : that of the shell; law : StVenant; membrane : (3, 3), stiffness A at rest [N/m]
    """

    def __init__(self, mesh: Mesh, law: StVenant, membrane: np.ndarray):
        spaces = [vector_space(mesh, "DG", 0, width) for width in (3, 13)]
        self._E = Function(spaces[0])
        self._where = cell_nodes(spaces[0])[:, 0]
        E = ufl.variable(ufl.as_vector([self._E[i] for i in range(3)]))
        energy = law.membrane(E, Constant(mesh, np.array(membrane)))
        stress = ufl.diff(energy, E)
        tangent = ufl.diff(stress, E)
        energy, stress, tangent = map(expand_derivatives, (energy, stress, tangent))
        t = ufl.TestFunction(spaces[1])
        tested = energy * t[0] + sum(stress[i] * t[1 + i] for i in range(3))
        tested += sum(tangent[i, j] * t[4 + 3 * i + j] for i in range(3) for j in range(3))
        # the integral over a cell is its value at the middle times |G1 x G2|
        J = ufl.Jacobian(mesh)
        G1, G2 = (ufl.as_vector([J[i, a] for i in range(3)]) for a in range(2))
        normal = ufl.cross(G1, G2)
        form = tested / ufl.sqrt(ufl.dot(normal, normal)) * measure(mesh, "centre")
        ((self._form,),) = compiled([(form,)])

    def __call__(self, E: np.ndarray, cells: np.ndarray | None = None) -> Answer:
        self._E.x.array.reshape(-1, 3)[self._where] = E
        out = np.zeros((len(E), 13))
        packed = pack_constants(self._form), pack_coefficients(self._form)
        assemble_packed(out.reshape(-1), self._form, *packed)
        out = out[self._where]
        return out[:, 0], out[:, 1:4], out[:, 4:].reshape(-1, 3, 3)
