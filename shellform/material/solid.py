# SPDX-License-Identifier: LGPL-3.0-or-later
"""Sheets of a solid: any psi(C), integrated through the thickness with S33 = 0 (Eqs. 3, 11, 12).

At the height z the sheet has the strain E + z K in its plane, C = I + 2 (E + z K) there and C33
across. C33 = exp(y) is that of no stress across, dpsi/dy = 0: found by Newton's method at each
height, unrolled in UFL from the solution of small strains, y = -nu/(1 - nu) ln det C. After two
steps dpsi/dy is below 1e-5 of the shear modulus for areas from 0.5 to 2 times that at rest, and the
energy wrong by its square; stress and tangent are the derivatives of that energy. Gauss points
carry the integral over the thickness.

Transverse shear stays quadratic; the volume of a curved sheet is taken as that of a flat one.
"""

from dataclasses import dataclass

import numpy as np

import ufl
from ufl.core.expr import Expr

from .energy import StVenant

NEWTON = 2  # steps for C33
HEIGHTS, WEIGHTS = np.polynomial.legendre.leggauss(3)  # over half the thickness


@dataclass(frozen=True)
class Solid(StVenant):
    """A sheet of an isotropic solid: derive from it and write two methods; shear as in StVenant.

    Its fabric is Fabric.isotropic(...), from which it has its moduli.
    """

    couples = True

    def psi(self, C: Expr, y: Expr, mu: Expr, nu: Expr) -> Expr:
        """Energy per volume [J/m^3], without stress at C = 1, y = 0.

        C : (2, 2) in the plane; y : ln C33; mu : shear modulus [Pa]; nu : Poisson's ratio
        """
        raise NotImplementedError

    def across(self, C: Expr, y: Expr, mu: Expr, nu: Expr) -> tuple[Expr, Expr]:
        """First and second derivative of `psi` by y, written out: UFL's own would be long."""
        raise NotImplementedError

    def membrane_and_bending(self, E: Expr, K: Expr, A: Expr, D: Expr) -> Expr:
        """Energy [J/m^2] of a strain E + z K, condensed and integrated."""
        nu, thickness = A[0, 1] / A[0, 0], ufl.sqrt(12 * D[0, 0] / A[0, 0])
        mu = A[2, 2] / thickness
        stored = 0.0
        for height, weight in zip(HEIGHTS.tolist(), WEIGHTS.tolist(), strict=True):
            e = E + 0.5 * thickness * height * K
            stored += 0.5 * weight * self._condensed(e, mu, nu)
        return thickness * stored

    def _condensed(self, e, mu, nu):
        C = ufl.as_matrix([[1 + 2 * e[0], e[2]], [e[2], 1 + 2 * e[1]]])
        y = -nu / (1 - nu) * ufl.ln(C[0, 0] * C[1, 1] - C[0, 1] ** 2)
        for _ in range(NEWTON):
            slope, curve = self.across(C, y, mu, nu)
            y = y - slope / curve
        return self.psi(C, y, mu, nu)


@dataclass(frozen=True)
class CompressibleNeoHookean(Solid):
    """psi = mu/2 (tr C - 3 - ln det C) + lambda/8 (ln det C)^2 (Bonet and Wood, 2008, Sec. 6.4.3).

    Pulled to a stretch s in one direction, its area at rest bears mu (s^2 - c)/s, c the C22 = C33
    of no stress across: mu (c - 1) + lambda/2 ln(s^2 c^2) = 0.
    """

    def psi(self, C: Expr, y: Expr, mu: Expr, nu: Expr) -> Expr:
        """See Solid."""
        volume = y + ufl.ln(C[0, 0] * C[1, 1] - C[0, 1] ** 2)
        trace = C[0, 0] + C[1, 1] + ufl.exp(y)
        return 0.5 * mu * (trace - 3 - volume) + self._lame(mu, nu) / 8 * volume**2

    def across(self, C: Expr, y: Expr, mu: Expr, nu: Expr) -> tuple[Expr, Expr]:
        """See Solid."""
        volume, lam = y + ufl.ln(C[0, 0] * C[1, 1] - C[0, 1] ** 2), self._lame(mu, nu)
        C33 = ufl.exp(y)
        return 0.5 * mu * (C33 - 1) + 0.25 * lam * volume, 0.5 * mu * C33 + 0.25 * lam

    def _lame(self, mu, nu):
        return 2 * mu * nu / (1 - 2 * nu)
