# SPDX-License-Identifier: LGPL-3.0-or-later
"""Addends of the strain energy, and what they are made of: Eqs. 3, 12, 14.

A Term is the energy of one strain at one quadrature rule, and gives the works that the weak form
integrates:

    energy            psi(e), quadratic: e . C e / 2
    work of stress    psi'(e) . e'
    of its change     de . psi''(e) . e'

The stiffness comes as a product p . C q of strains in element axes; a law that is not quadratic in
a strain gives a density psi instead (material/energy.py).
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import ufl
from ufl.algorithms import expand_derivatives

from shellform.material.energy import StVenant, quadratic

from .dolfinx_compat import Constant, Expr


@dataclass(frozen=True)
class Term:
    """One addend of the strain energy per area, at one rule.

    Attributes
    ----------
    name : kind of strain
    strain : maps a configuration to a UFL vector
    product : symmetric bilinear form of the stiffness at rest; None: none of its own
    rule : one of element.RULES
    density : maps a strain to its energy; None: product(strain, strain)/2
    """

    name: str
    strain: Callable
    product: Any  # a Callable, or None where `density` is all there is
    rule: str
    density: Callable | None = None

    def energy(self, strain: Expr) -> Expr:
        """psi, energy per area [J/m^2] at a strain."""
        if self.density is None:
            return 0.5 * self.product(strain, strain)
        return self.density(strain)

    def stress_work(self, strain: Expr, virtual: Expr) -> Expr:
        """psi' . virtual: the work of the stress at `strain`."""
        if self.density is None:
            return self.product(strain, virtual)
        strain = ufl.variable(strain)
        return ufl.dot(expand_derivatives(ufl.diff(self.density(strain), strain)), virtual)

    def stiffness_work(self, strain: Expr, change: Expr, virtual: Expr) -> Expr:
        """change . psi'' . virtual: that of the stress that a change of strain adds."""
        if self.density is None:
            return self.product(change, virtual)
        strain = ufl.variable(strain)
        stress = ufl.diff(self.density(strain), strain)
        tangent = expand_derivatives(ufl.diff(stress, strain))
        return ufl.dot(ufl.dot(tangent, change), virtual)


@dataclass(frozen=True)
class Densities:
    """Energies of a law as functions of strains in element axes.

    `V`, `M` take those of three and of two components to warp and weft; `stiffness` of the fabric
    by name of the strain.
    """

    law: StVenant
    V: Expr
    M: Expr
    stiffness: dict[str, Constant]

    def whole(self, strain: str, scale: Expr | float = 1) -> Callable | None:
        """Density of a strain times a scale; None where the law is quadratic in it."""
        if self.law.is_quadratic(strain) or (self.law.couples and strain != "shear"):
            return None
        density, stiffness = getattr(self.law, strain), self.stiffness[strain]
        axes = self.M if strain == "shear" else self.V
        return lambda e: scale * density(axes * e, stiffness)

    def beyond(
        self, strain: str, name: str, measure: Callable, rule: str, scale: Expr | float = 1
    ) -> list[Term]:
        """Term of what the law stores in a strain beyond the quadratic energy; none if nothing."""
        whole = self.whole(strain, scale)
        if whole is None:
            return []
        stiffness, axes = self.stiffness[strain], self.M if strain == "shear" else self.V
        rest = lambda e: whole(e) - scale * quadratic(axes * e, stiffness)  # noqa: E731
        return [Term(name, measure, None, rule, rest)]

    def both(self, beyond: bool = False) -> Callable | None:
        """Density of membrane and bending strain, stacked, of a law that couples them, else None.

        `beyond`: of what it stores more than the quadratic energy.
        """
        if not self.law.couples:
            return None
        A, D = self.stiffness["membrane"], self.stiffness["bending"]

        def density(e):
            E, K = (self.V * ufl.as_vector([e[first + k] for k in range(3)]) for first in (0, 3))
            whole = self.law.membrane_and_bending(E, K, A, D)
            return whole - quadratic(E, A) - quadratic(K, D) if beyond else whole

        return density


def stacked(measures: list[Callable]) -> Callable:
    """Several strain measures in one vector of 3 components each."""

    def strain(configuration):
        parts = [m(configuration) for m in measures]
        return ufl.as_vector([p[k] for p in parts for k in range(3)])

    return strain


def stacked_product(V: Expr, blocks: list[list]) -> Callable:
    """Product sum_ij p_i . C_ij q_j in lamina axes; None for an absent block."""

    def part(strain, i):
        return V * ufl.as_vector([strain[3 * i + k] for k in range(3)])

    def product(p, q):
        return sum(
            ufl.dot(part(p, i), C * part(q, j))
            for i, row in enumerate(blocks)
            for j, C in enumerate(row)
            if C is not None
        )

    return product
