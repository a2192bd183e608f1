# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cloth as it is measured: a curve for each of tension, shear and bending (Eq. 11, Fig. 3).

With the elongations of the yarns e1, e2, the angle gamma by which they have left the right angle,
and the curvatures,

    e_i = sqrt(1 + 2 E_ii) - 1,   sin gamma = 2 E12/((1 + e1) (1 + e2)),   K11, K22,

    psi = w_1(e1) + w_2(e2) + A12 e1 e2 + w_s(gamma) + m_1(K11) + m_2(K22) + D12 K11 K22
        + D66 (2 K12)^2/2,

each w and m the integral of a measured curve (curve.py): load per width at rest against elongation
with the other yarn held, shear load against angle in a frame of yarns that keep their length,
moment per width against curvature. Where no curve is given, the quadratic energy stays.

Quads and triangles take bending beyond the quadratic energy once a cell, in its middle
(`in_the_middle`); cell_stress.c does the same in explicit steps.
"""

from dataclasses import dataclass

import ufl
from ufl.core.expr import Expr

from .curve import Curve
from .energy import StVenant, quadratic


@dataclass(frozen=True)
class Measured(StVenant):
    """A sheet that follows measured curves; its fabric has their slopes at rest.

    Parameters
    ----------
    warp, weft : load [N/m] against elongation; shear_angle : load [N/m] against angle [rad]
    bend_warp, bend_weft : moment [N] against curvature [1/m]
        Each a Curve, or None for what stays quadratic.
    """

    warp: Curve | None = None
    weft: Curve | None = None
    shear_angle: Curve | None = None
    bend_warp: Curve | None = None
    bend_weft: Curve | None = None

    directional = True
    in_the_middle = True

    @property
    def curves(self) -> tuple[Curve | None, ...]:
        """All five, in the order of the parameters."""
        return self.warp, self.weft, self.shear_angle, self.bend_warp, self.bend_weft

    @property
    def stretches(self) -> bool:
        """True if the membrane has a curve."""
        return any(curve is not None for curve in (self.warp, self.weft, self.shear_angle))

    @property
    def bends(self) -> bool:
        """True if bending has a curve."""
        return self.bend_warp is not None or self.bend_weft is not None

    def is_quadratic(self, strain: str) -> bool:
        """See StVenant."""
        return not {"membrane": self.stretches, "bending": self.bends, "shear": False}[strain]

    def membrane(self, E: Expr, A: Expr) -> Expr:
        """Energy [J/m^2] of the Green strain of the mid-surface."""
        if not self.stretches:
            return quadratic(E, A)
        stretches = [ufl.sqrt(1 + 2 * E[i]) for i in range(2)]
        e1, e2 = (s - 1 for s in stretches)
        sine = E[2] / (stretches[0] * stretches[1])
        stored = A[0, 1] * e1 * e2 if self.warp or self.weft else A[0, 1] * E[0] * E[1]
        for i, (curve, e) in enumerate(((self.warp, e1), (self.weft, e2))):
            stored += _energy(curve, e) if curve else 0.5 * A[i, i] * E[i] ** 2
        shear = self.shear_angle
        return stored + (_energy(shear, ufl.asin(sine)) if shear else 0.5 * A[2, 2] * E[2] ** 2)

    def bending(self, K: Expr, D: Expr) -> Expr:
        """Energy [J/m^2] of the change of curvature."""
        stored = D[0, 1] * K[0] * K[1] + 0.5 * D[2, 2] * K[2] ** 2
        for i, curve in enumerate((self.bend_warp, self.bend_weft)):
            stored += _energy(curve, K[i]) if curve else 0.5 * D[i, i] * K[i] ** 2
        return stored


def _energy(curve: Curve, x: Expr) -> Expr:
    return curve.energy(x, ufl.conditional, ufl.lt)
