# SPDX-License-Identifier: LGPL-3.0-or-later
"""The weak form of a shell: energy, virtual work, tangent, damping, pressure: Eqs. 11, 13, 14.

All follow from the strains e(w) of the Terms of an element (terms.py), w = (u, d):

    energy          sum over terms of psi(e(w) - e(w0)), w0 the sheet at rest
    virtual work    psi'(e(w) - e(w0)) . e'(w) v
    tangent         e'(w) dw . psi'' . e'(w) v + psi' . e''(w) dw v

Linearised stress. The exact tangent fails for thin sheets: the stress of an iterate off the
solution is mostly error. In the geometric part, psi' is then taken at the strain linearised about
the iterate before, e(w_) + e'(w_) dw_ (mixed integration point, Magisano, Leonetti and Garcea, Int.
J. Numer. Methods Engrg. 109, 2017). With w_ = w and dw_ = 0 the same form is the exact one.
"""

from collections.abc import Callable
from dataclasses import dataclass

import ufl
from ufl.algorithms import expand_derivatives

from .dolfinx_compat import Constant, Expr, Function, Mesh
from .element import measure
from .strains import Configuration, area, configuration, flat_configuration, mesh_tangents
from .terms import Term

PRESSURE_RULES = {3: "vertices", 4: "gauss2", 9: "gauss3"}  # by nodes of the cell


@dataclass(frozen=True)
class WeakForm:
    """UFL forms of the energy of `terms` on a mesh.

    Attributes
    ----------
    mesh : of the surface; terms : of the energy, see `element.energy_terms`
    w, reference : nodal fields (u, d) now and at rest
    flat : corners of the cells in flat panels, see `Partition`, where these are the rest shape
    """

    mesh: Mesh
    terms: list[Term]
    w: Function
    reference: Function
    flat: Function | None = None

    def by_rule(self) -> list[tuple[Callable, list[Term]]]:
        """Terms by the rule that integrates them: each rule becomes a form of its own.

        The integral over the sheet at rest comes as a function of what is integrated.
        """
        groups: dict[str, list[Term]] = {}
        for term in self.terms:
            groups.setdefault(term.rule, []).append(term)
        return [(self._integral(rule), terms) for rule, terms in groups.items()]

    def _integral(self, rule: str) -> Callable:
        dx = measure(self.mesh, rule)
        if self.flat is None:
            return lambda integrand: integrand * dx
        share = area(self.at_rest().g) / area(mesh_tangents(self.mesh))
        return lambda integrand: share * integrand * dx

    def at_rest(self) -> Configuration:
        """Tangents and directors without stress."""
        if self.flat is None:
            return self.configuration(self.reference)
        return flat_configuration(self.mesh, self.flat)

    def configuration(self, w: Function) -> Configuration:
        """Tangents and directors of a nodal field."""
        return configuration(self.mesh, w)

    def strain(self, term: Term, w: Function) -> Expr:
        """Strain of a term at a nodal field, less that at rest."""
        return term.strain(self.configuration(w)) - term.strain(self.at_rest())

    def rate(self, term: Term, w: Function, direction: Expr) -> Expr:
        """e'(w) direction: change of a term's strain along a direction, a variation or rates."""
        strain = term.strain(self.configuration(w))
        return expand_derivatives(ufl.derivative(strain, w, direction))

    def energy(self) -> dict[str, tuple]:
        """Forms of the strain energy [J] by kind of term."""
        kinds: dict[str, list] = {}
        for over, terms in self.by_rule():
            for term in terms:
                stored = over(term.energy(self.strain(term, self.w)))
                kinds.setdefault(term.name, []).append(stored)
        return {name: tuple(forms) for name, forms in kinds.items()}

    def newton(self, before: Function, step: Function) -> list[tuple]:
        """Pairs (virtual work, tangent), one per rule, with the stress linearised about `before`.

        Parameters
        ----------
        before : nodal field of the iterate before; step : change of w since
        """
        v, dw = self._test, ufl.TrialFunction(self._space)
        pairs = []
        for over, terms in self.by_rule():
            force = tangent = 0
            for term in terms:
                virtual, change = self.rate(term, self.w, v), self.rate(term, self.w, dw)
                linearised = self.strain(term, before) + self.rate(term, before, step)
                work = over(term.stress_work(linearised, virtual))
                force += work
                tangent += over(term.stiffness_work(self.strain(term, self.w), change, virtual))
                tangent += ufl.derivative(work, self.w, dw)
            pairs.append((force, tangent))
        return pairs

    def virtual_work(self) -> list:
        """Forms of the internal force with the exact stress, one per rule."""
        return [
            sum(
                over(
                    term.stress_work(self.strain(term, self.w), self.rate(term, self.w, self._test))
                )
                for term in terms
            )
            for over, terms in self.by_rule()
        ]

    def damping(self, rates: Function) -> list:
        """Forms of a viscous force, one per rule: the stiffness at rest times rates of the strains.

        It resists every change of strain, whatever stress there is, and no rigid motion.
        """
        return [
            sum(
                over(
                    term.product(
                        self.rate(term, self.w, rates), self.rate(term, self.w, self._test)
                    )
                )
                for term in terms
                if term.product is not None
            )
            for over, terms in self.by_rule()
        ]

    def pressure(self, pressure: Constant) -> tuple:
        """Minus the force of a pressure [Pa] that stays normal to the moving surface; its tangent.

        Parameters
        ----------
        pressure : Constant
        """
        now, rest = self.configuration(self.w), self.configuration(self.reference)
        area = ufl.cross(*rest.g)
        # per reference area: the surface element of the moving surface over that at rest
        normal = ufl.cross(*now.g) / ufl.sqrt(ufl.dot(area, area))
        virtual = ufl.as_vector([self._test[i] for i in range(3)])
        rule = PRESSURE_RULES[self._space.dofmap.dof_layout.num_dofs]
        force = -pressure * ufl.dot(normal, virtual) * measure(self.mesh, rule)
        return force, ufl.derivative(force, self.w, ufl.TrialFunction(self._space))

    @property
    def _space(self):
        return self.w.function_space

    @property
    def _test(self):
        return ufl.TestFunction(self._space)
