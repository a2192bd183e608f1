# SPDX-License-Identifier: LGPL-3.0-or-later
"""Laws: the energy that a sheet stores in its strains, per area; any psi of Eq. 11.

A law is one class. Derived from `StVenant` it says in UFL what it stores in a strain where that is
not quadratic, and inherits the rest:

    membrane(E, A)   E = (E11, E22, 2 E12), Green strain of the mid-surface, -
    bending(K, D)    K = (K11, K22, 2 K12), change of curvature, 1/m
    shear(gamma, S)  gamma = (2 E13, 2 E23), transverse shear, -

each as a density [J/m^2] in the axes (warp, weft). A, D, S are the matrices of the fabric: its
stiffness at rest, which time steps, tolerances and damping go by. A law must have that stiffness
where it starts (`check_law`). Stress and tangent follow by differentiation, never by hand.

What couples these strains (B, and E, F of thick sheets) stays quadratic, Sheet's energy; unless
the law `couples`: then it writes

    membrane_and_bending(E, K, A, D)

in place of the first two (solid.py). A law that is not named by `fabric.law`, or by `law` of
`Shell`, is neither imported nor compiled; names in cards stand in laws.py.
"""

from collections.abc import Callable
from itertools import product as pairs

import numpy as np

import ufl
from ufl.core.expr import Expr

from .laminate import FabricError
from .sheet import Sheet

STRAINS = {"membrane": 3, "bending": 3, "shear": 2}  # methods of a law: components of the strain
STEP = 1e-5  # of a strain, in differences of the energy at rest
CLOSER = 0.03  # of the step, where the first one does not see the stiffness at rest
APART = 1e-3  # by which a law may miss the fabric's stiffness, relative to its largest entry


def quadratic(strain: Expr, stiffness: Expr) -> Expr:
    """strain . stiffness . strain / 2."""
    return 0.5 * ufl.dot(strain, stiffness * strain)


class StVenant:
    """St. Venant-Kirchhoff: quadratic in all strains, the default of `Shell`.

    Attributes
    ----------
    couples : True if `membrane_and_bending` is stored
    directional : True if the law itself has axes, whatever the matrices of the fabric
    in_the_middle : True if a quad has bending beyond the quadratic energy once, in its middle
    """

    couples = False
    in_the_middle = False

    @property
    def curves(self) -> tuple:
        """Curves that laws `in_the_middle` follow: warp, weft, shear, bending of both."""
        return ()

    directional = False

    def membrane(self, E: Expr, A: Expr) -> Expr:
        """Energy [J/m^2] of the Green strain of the mid-surface."""
        return quadratic(E, A)

    def bending(self, K: Expr, D: Expr) -> Expr:
        """Energy [J/m^2] of the change of curvature [1/m]."""
        return quadratic(K, D)

    def shear(self, gamma: Expr, S: Expr) -> Expr:
        """Energy [J/m^2] of the transverse shear."""
        return quadratic(gamma, S)

    def membrane_and_bending(self, E: Expr, K: Expr, A: Expr, D: Expr) -> Expr:
        """Energy [J/m^2] of both, of laws that couple them."""
        return self.membrane(E, A) + self.bending(K, D)

    def is_quadratic(self, strain: str) -> bool:
        """True if the law stores in a strain (a name of STRAINS) what StVenant does."""
        if self.couples and strain != "shear":
            return False
        return getattr(type(self), strain) is getattr(StVenant, strain)

    def __repr__(self) -> str:
        return f"{type(self).__name__}()"


def check_law(law: StVenant, fabric: Sheet) -> None:
    """Refuse a law whose stress or stiffness at rest is not that of the fabric.

    Raises
    ------
    TypeError if it is no law; FabricError, naming the strain, the values and the mend
    """
    if not isinstance(law, StVenant):
        raise TypeError(
            f"law takes an object of a class derived from StVenant, not {type(law).__name__}: "
            f"{law!r}"
        )
    for name in STRAINS:
        if law.is_quadratic(name):
            continue
        wanted = getattr(fabric, name)
        step = STEP / fabric.thickness if name == "bending" else STEP
        density, bar = _alone(law, name, fabric), APART * np.abs(wanted).max()
        stress, stiffness = at_rest(density, wanted, step)
        if not (np.abs(stiffness - wanted) <= bar).all():
            # cloth whose crimp is pulled out stiffens from the first step on
            closer = at_rest(density, wanted, CLOSER * step)
            if (np.abs(closer[1] - wanted) <= bar).all():
                stress, stiffness = closer[0] / CLOSER, closer[1]
        if not (np.abs(stress) <= bar * step).all():
            raise FabricError(
                f"{law!r} has the {name} stress {_listed(stress)} in the sheet at rest: "
                "a law must have none there"
            )
        if not (np.abs(stiffness - wanted) <= bar).all():
            raise FabricError(
                f"{law!r} has the {name} stiffness {_listed(stiffness)} at rest, the fabric "
                f"'{fabric.name}' has {_listed(wanted)}: give the fabric the stiffness that the "
                "law starts with"
            )


def _alone(law, name, fabric):
    """Density of one strain, the others being none."""
    if not law.couples or name == "shear":
        return getattr(law, name)
    none = ufl.as_vector([0.0, 0.0, 0.0])
    A, D = (ufl.as_matrix(m.tolist()) for m in (fabric.membrane, fabric.bending))
    if name == "membrane":
        return lambda E, _: law.membrane_and_bending(E, none, A, D)
    return lambda K, _: law.membrane_and_bending(none, K, A, D)


def at_rest(density: Callable, stiffness: np.ndarray, step: float) -> tuple[np.ndarray, np.ndarray]:
    """Stress (k,) and stiffness (k, k) of a density at zero strain, by central differences."""
    matrix, k = ufl.as_matrix(stiffness.tolist()), len(stiffness)

    def energy(strain):
        try:
            # functions as ufl.exp of plain numbers give a plain number
            return float(ufl.as_ufl(density(ufl.as_vector(strain.tolist()), matrix))(()))
        except (ArithmeticError, ValueError):
            return np.nan

    h = step * np.eye(k)
    stress = np.array([energy(e) - energy(-e) for e in h]) / (2 * step)
    second = np.empty((k, k))
    for i, j in pairs(range(k), repeat=2):
        corners = [s * t * energy(s * h[i] + t * h[j]) for s, t in pairs((1, -1), repeat=2)]
        second[i, j] = sum(corners) / (4 * step**2)
    return stress, second


def _listed(values):
    return np.array2string(values, precision=4, separator=", ").replace("\n", "")
