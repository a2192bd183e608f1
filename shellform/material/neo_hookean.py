# SPDX-License-Identifier: LGPL-3.0-or-later
"""Rubber-like sheets: the incompressible neo-Hookean membrane, for knits and coated cloth.

A solid of energy mu/2 (tr C - 3) with det C = 1 thins as it is stretched: C33 = 1/det of the
in-plane C = I + 2 E. Per area, with t mu = A66,

    psi = A66/2 (C11 + C22 + 1/(C11 C22 - C12^2) - 3).

Pulled to lambda in one direction it carries A66 (lambda - lambda^-2) per width at rest (Treloar,
The Physics of Rubber Elasticity, 1975). At rest it is isotropic with Poisson's ratio 1/2.
"""

from dataclasses import dataclass

from ufl.core.expr import Expr

from .energy import StVenant


@dataclass(frozen=True)
class NeoHookean(StVenant):
    """Membrane of an incompressible neo-Hookean solid; bending and shear as in StVenant.

    Its fabric is isotropic with the Poisson's ratio 1/2: Fabric.isotropic(3 mu, 0.5, ...).
    """

    def membrane(self, E: Expr, A: Expr) -> Expr:
        """Energy [J/m^2] of the Green strain of the mid-surface."""
        C11, C22, C12 = 1 + 2 * E[0], 1 + 2 * E[1], E[2]
        return 0.5 * A[2, 2] * (C11 + C22 + 1 / (C11 * C22 - C12**2) - 3)
