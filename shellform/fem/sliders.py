# SPDX-License-Identifier: LGPL-3.0-or-later
"""Friction inside the cloth as Newton's method sees it: sliders at the slips they had, Eqs. 13, 14.

Within a step a slider is elastic up to its yield stress and goes along with it beyond; what it has
slipped by is kept when the step is done (cell_stress.py). So in a step its stress is a function of
the strain, with a tangent: in UFL for strains at a point, the middle of a cell, and in arrays for
the membrane of quads by six lengths, which belongs to none.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

import ufl

from shellform.material.friction import ClothFriction
from shellform.material.sheet import Sheet

from . import strains
from .dolfinx_compat import Expr, Function
from .element import cell_axes
from .partition import Partition
from .terms import Term

if TYPE_CHECKING:
    from .cell_stress import CellStress


def friction_terms(partition: Partition, fabric: Sheet, slips: Function) -> list[Term]:
    """Terms of friction inside the cloth in the middle of cells, as of an implicit step.

    The density of a slider at the slip p is k x^2/2 while it sticks, x = e - p, and where it slips
    the integral of its yield stress (Huber's function): its derivative is the stress that the
    slider has once it has slipped. It is not continuous, as only derivatives are taken.

    Parameters
    ----------
    partition, fabric : as for `energy_terms`, of triangles or quads in their default form
    slips : field of a number a slider and cell, strain by strain, see `ClothFriction.table`

    That of the membrane of quads by six lengths is not among them, as it belongs to no point.
    """
    V = strains.voigt(cell_axes(partition, True))
    triangle = partition.surface.kind == "triangle"
    rule = "centroid" if triangle else "centre"
    measures = {3: strains.curvature_turning_sides if triangle else strains.curvature_turning}
    if triangle:
        measures[0] = strains.membrane_arcs
    assert fabric.friction is not None
    elements, counts = fabric.friction.elements(), fabric.friction.counts()
    terms = []
    for first, strain in measures.items():
        if sum(counts[first : first + 3]):
            density = huber(V, elements[first : first + 3], slips, sum(counts[:first]))
            terms.append(Term("friction", strain, None, rule, density))
    return terms


def huber(V: Expr, elements: list, slips: Function, place: int) -> Callable:
    """Density of the sliders of three strains, whose slips begin at a place of the field."""

    def density(e):
        strain, at, stored = V * e, place, 0.0
        for j, pairs in enumerate(elements):
            for k, m, g in pairs:
                e_j, x = strain[j], strain[j] - slips[at]
                sticks = ufl.lt(k * abs(x), m + g * abs(e_j))
                slides = ufl.sign(x) * (m * e_j + (0.5 * g * e_j * abs(e_j) if g else 0.0))
                stored += ufl.conditional(sticks, 0.5 * k * x**2, slides)
                at += 1
        return stored

    return density


class Sliders:
    """Friction in the strains of a membrane at the present slips (material/friction.py).

    Parameters
    ----------
    friction : ClothFriction; cells : CellStress, which has the slips
    """

    def __init__(self, friction: ClothFriction, cells: CellStress):
        self._elements, self._cells = friction.elements()[:3], cells

    def __call__(self, E: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Stress (m, 3) and tangent (m, 3, 3) [N/m] of strains (m, 3); nothing slips for good."""
        stress, tangent = np.zeros_like(E), np.zeros((len(E), 3, 3))
        slips, at = self._cells.slips, 0
        for j, pairs in enumerate(self._elements):
            for k, m, g in pairs:
                free, most = k * (E[:, j] - slips[:, at]), m + g * np.abs(E[:, j])
                stress[:, j] += np.clip(free, -most, most)
                slope = g * np.sign(E[:, j]) * np.sign(free)
                tangent[:, j, j] += np.where(np.abs(free) < most, k, slope)
                at += 1
        return stress, tangent
