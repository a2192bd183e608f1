# SPDX-License-Identifier: LGPL-3.0-or-later
"""Cloth as it is measured: a curve for each of tension, shear and bending (Eq. 11, Fig. 3).

With the elongations of the yarns e1, e2, the angle gamma by which they have left the right angle,
and the curvatures,

    e_i = sqrt(1 + 2 E_ii) - 1,   sin gamma = 2 E12/((1 + e1) (1 + e2)),   K11, K22,

    psi = w_1(e1) + w_2(e2) + c(e1, e2) + w_s(gamma) + m_1(K11) + m_2(K22) + D12 K11 K22
        + D66 (2 K12)^2/2,

each w and m the integral of a measured curve (curve.py): load per width at rest against elongation
with the other yarn held, shear load against angle in a frame of yarns that keep their length,
moment per width against curvature. Where no curve is given, the quadratic energy stays. Crimp that
goes over from yarn to yarn couples them: c = A12 e1 e2, or, where loads at equal elongation have
been measured, which exceed those with the other yarn held by w_c'(e),

    c = 2 w_c(q), q = sqrt(e1 e2) > 0.

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
    coupling : of warp and weft at one elongation, what the load [N/m] is above theirs
        Each a Curve, or None for what stays quadratic.
    """

    warp: Curve | None = None
    weft: Curve | None = None
    shear_angle: Curve | None = None
    bend_warp: Curve | None = None
    bend_weft: Curve | None = None
    coupling: Curve | None = None

    directional = True
    in_the_middle = True

    @property
    def curves(self) -> tuple[Curve | None, ...]:
        """All six, in the order of the parameters."""
        bending = self.bend_warp, self.bend_weft
        return self.warp, self.weft, self.shear_angle, *bending, self.coupling

    @property
    def stretches(self) -> bool:
        """True if the membrane has a curve."""
        of_membrane = self.warp, self.weft, self.shear_angle, self.coupling
        return any(curve is not None for curve in of_membrane)

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
        yarns = self.warp or self.weft or self.coupling
        stored = A[0, 1] * e1 * e2 if yarns else A[0, 1] * E[0] * E[1]
        if self.coupling:
            both = ufl.gt(e1 * e2, 0.0)
            # a root of nothing would have no derivative, also where it is not chosen
            q = ufl.sqrt(ufl.conditional(both, e1 * e2, 1.0))
            stored = ufl.conditional(both, 2 * _energy(self.coupling, q), stored)
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
