# SPDX-License-Identifier: LGPL-3.0-or-later
"""Fung's exponential law, orthotropic: a sheet that stiffens as it is stretched (Eq. 11).

    psi = c/2 (exp(Q) - 1),    Q = E . A E / c,

A the stiffness of the fabric at rest, whose axes are those of the law, and c [N/m] the load at
which stiffening sets in: pulled in one direction by e, the load is A11 e exp(A11 e^2/c)
(Fung, Am. J. Physiol. 213, 1967; Tong and Fung, J. Biomech. 9, 1976).
"""

from dataclasses import dataclass

import ufl
from ufl.core.expr import Expr

from .energy import StVenant, quadratic
from .laminate import positive


@dataclass(frozen=True)
class Fung(StVenant):
    """Membrane that stiffens exponentially; bending and shear as in StVenant.

    Parameters
    ----------
    stiffening_load : c [N/m]
    """

    stiffening_load: float

    def __post_init__(self) -> None:
        positive("N/m", stiffening_load=self.stiffening_load)

    def membrane(self, E: Expr, A: Expr) -> Expr:
        """Energy [J/m^2] of the Green strain of the mid-surface."""
        c = self.stiffening_load
        return 0.5 * c * (ufl.exp(2 * quadratic(E, A) / c) - 1)
