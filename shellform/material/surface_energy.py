# SPDX-License-Identifier: LGPL-3.0-or-later
"""The energy of the metric and the curvature of a surface, each component for itself.

    psi = sum over i, j of  eta_ij (G_ij - G0_ij)^2 + xi_ij (B_ij - B0_ij)^2

with the first and the second fundamental form of the surface (Terzopoulos, Platt, Barr and
Fleischer, Computer Graphics 21(4), 1987; Carignan, Yang, Magnenat Thalmann and Thalmann, ibid.
26(2), 1992). As G - G0 = 2 E and, with directors normal to the surface, B - B0 = -K, this is the
quadratic energy without what couples warp and weft: A = 8 diag(eta_11, eta_22, eta_12/2), D =
2 diag(xi_11, xi_22, xi_12/2) on (11, 22, 2 12). Nothing contracts across a pull.
"""

from dataclasses import dataclass

from ufl.core.expr import Expr

from .energy import StVenant


@dataclass(frozen=True)
class MetricAndCurvature(StVenant):
    """Terzopoulos' surface; its fabric has no Poisson's ratio, and its weights are A and D."""

    def membrane(self, E: Expr, A: Expr) -> Expr:
        """Energy [J/m^2] of the change of the metric."""
        return 0.5 * sum(A[i, i] * E[i] ** 2 for i in range(3))

    def bending(self, K: Expr, D: Expr) -> Expr:
        """Energy [J/m^2] of the change of curvature."""
        return 0.5 * sum(D[i, i] * K[i] ** 2 for i in range(3))
