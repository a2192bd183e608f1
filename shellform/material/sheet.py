# SPDX-License-Identifier: LGPL-3.0-or-later
"""Sheet: what cloth resists with, per unit of its area (Eqs. 11-12).

The stored energy is that of an orthotropic St. Venant-Kirchhoff sheet with S33 = 0.  Integrated
through the thickness, with the strain eps + z kap + z^2 chi, it reads

    psi = 1/2 eps.A.eps + eps.B.kap + 1/2 kap.D.kap + eps.D.chi + kap.E.chi + 1/2 chi.F.chi
        + 1/2 gam.S.gam                                                              [J/m^2]

in the axes (warp, weft), order [11, 22, 12] with engineering shear 2 E12.  A `Sheet` holds A to F
and S, checks that this energy is positive, and tells the lengths that follow from it.  SI units.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Self

import numpy as np

from .laminate import FabricError, check_definite, positive, symmetric, turn

if TYPE_CHECKING:
    from .energy import StVenant
    from .friction import ClothFriction
    from .provenance import Provenance

MATRICES = {  # name: rows, unit
    "membrane": (3, "N/m"),
    "bending": (3, "N m"),
    "shear": (2, "N/m"),
    "coupling": (3, "N"),
    "third_moment": (3, "N m^2"),
    "fourth_moment": (3, "N m^3"),
}


class UnitWarning(UserWarning):
    """A value that is legal but looks as if given in another unit."""


@dataclass(frozen=True, eq=False, repr=False)
class Sheet:
    """A sheet material in its (warp, weft) axes.  Checked when made, then read-only.

    Parameters
    ----------
    membrane : (3, 3) A [N/m];  bending : (3, 3) D [N m];  shear : (2, 2) S [N/m] on
        [2 E13, 2 E23], shear correction included.
    areal_mass [kg/m^2];  thickness [m], the geometric one: contact offset, inertia, pictures.
    coupling : (3, 3) B [N];  third_moment : (3, 3) E [N m^2]; both zero unless given.
    fourth_moment : (3, 3) F [N m^3].  Default 9/5 D (A - B D^-1 B)^-1 D.  With B = 0 this is
        t^5/80 C for a homogeneous sheet of stiffness C (A = t C, D = t^3/12 C), and it keeps
        the energy positive for any A and D, as it needs only the factor 1 for that.
    law : what is stored in place of this energy, see energy.py; None: nothing else
    friction : of yarns on each other, see friction.py; None: none
    card : table that the sheet was made from, where files must tell it again; None: its matrices do
    provenance : what of it is measured and what estimated, see provenance.py; None: not known

    Raises
    ------
    FabricError : a matrix has the wrong shape, is not symmetric or not positive definite, or a
        scalar is not positive.  Warns with UnitWarning when a unit slip is all but certain.
    """

    membrane: np.ndarray
    bending: np.ndarray
    shear: np.ndarray
    areal_mass: float
    thickness: float
    # arrays once made, whatever was given
    coupling: np.ndarray = None  # type: ignore[assignment]
    third_moment: np.ndarray = None  # type: ignore[assignment]
    fourth_moment: np.ndarray = None  # type: ignore[assignment]
    name: str = "fabric"
    law: StVenant | None = None
    friction: ClothFriction | None = None
    card: dict | None = None
    provenance: Provenance | None = None

    def __post_init__(self):
        positive("kg/m^2", areal_mass=self.areal_mass)
        positive("m", thickness=self.thickness)
        for name, (rows, unit) in MATRICES.items():
            value = getattr(self, name)
            if value is None:
                value = self._fourth_moment() if name == "fourth_moment" else np.zeros((3, 3))
            value = symmetric(name, value, rows, unit)
            object.__setattr__(self, name, value)
            if name in ("membrane", "bending", "shear"):
                check_definite(name, value, unit, self._hint(name))
        A, D, _, B, E, F = self._matrices().values()
        check_definite(
            "The sheet's energy",
            np.block([[A, B, D], [B, D, E], [D, E, F]]),
            "(N/m, N m, N m^3)",
            " Check coupling, third_moment and fourth_moment: they must belong together.",
        )
        self._warn_of_units()

    def _fourth_moment(self) -> np.ndarray:
        A, B, D = self.membrane, self.coupling, self.bending
        # what stretching alone costs when free to bend
        rest: np.ndarray = A - B @ np.linalg.solve(D, B)
        check_definite("A - B D^-1 B", rest, "N/m", " The coupling is too large for A and D.")
        F = 1.8 * D @ np.linalg.solve(rest, D)
        return 0.5 * (F + F.T)

    def _hint(self, name: str) -> str:
        matrix = getattr(self, name)
        if name == "bending" and not matrix.diagonal().all():
            return " A shell needs some bending stiffness: 1e-7 N m is softer than any cloth."
        if name == "membrane" and (matrix.diagonal() > 0.0).all():
            nu12, nu21 = matrix[0, 1] / matrix[1, 1], matrix[0, 1] / matrix[0, 0]
            return f" It implies nu12 = {nu12:g}, nu21 = {nu21:g}: nu12 nu21 must be below 1."
        return ""

    def _warn_of_units(self):
        said = []
        if self.thickness > 0.1:
            said.append(f"thickness {self.thickness:g} m: was it meant in mm?")
        if self.areal_mass > 100.0:
            said.append(f"areal mass {self.areal_mass:g} kg/m^2: was it meant in g/m^2?")
        stretch = self.membrane.diagonal()[:2].min() / (9.81 * self.areal_mass)
        if stretch < 0.01:
            said.append(
                f"hung up, {1e3 * stretch:.2g} mm of this sheet double their length under their "
                "own weight: was a modulus meant in MPa, or a mass in g?"
            )
        for sentence in said:
            warnings.warn(f"{self.name}: {sentence}", UnitWarning, stacklevel=4)

    @property
    def directional(self) -> bool:
        """True when the sheet needs a warp direction, False when all directions are alike."""
        if self.friction is not None or (self.law is not None and self.law.directional):
            return True
        # In-plane stiffness has harmonics 0, 2, 4 of the angle; a turn by 30 degrees shows both.
        return not all(
            np.allclose(m, turn(m, -30.0), rtol=0, atol=1e-9 * np.max(abs(m)))
            for m in self._matrices().values()
        )

    def _matrices(self) -> dict:
        return {name: getattr(self, name) for name in MATRICES}

    def rotated(self, degrees: float) -> Self:
        """The same sheet written in axes turned by an angle about the director.

        FabricError for a sheet with a law or friction, which stand in its own axes.
        """
        if self.law is not None or self.friction is not None:
            raise FabricError(
                f"the law and the friction of '{self.name}' stand in the axes of warp and weft: "
                "turn the warp of the surface in place of the fabric"
            )
        return self._with(**{n: turn(m, -degrees) for n, m in self._matrices().items()})

    def with_law(self, law: StVenant | None) -> Self:
        """The same sheet that stores by another law."""
        return self._with(law=law)

    def with_card(self, card: dict) -> Self:
        """The same sheet, which knows the table that it was made from."""
        return self._with(card=card)

    def with_provenance(self, provenance: Provenance | None) -> Self:
        """The same sheet, which knows where its numbers come from."""
        return self._with(provenance=provenance, card=self.card)

    def with_friction(self, friction: ClothFriction | None) -> Self:
        """The same sheet with other friction inside."""
        return self._with(friction=friction)

    def _with(self, **more):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UnitWarning)  # said once, when first made
            return replace(self, **({"card": None} | more))

    def bending_length(self, g: float = 9.81, degrees: float = 0.0) -> float:
        """(D / (areal mass g))^(1/3) [m], the size of folds, at an angle from the warp."""
        return float((turn(self.bending, -degrees)[0, 0] / (self.areal_mass * g)) ** (1 / 3))

    @property
    def equivalent_thickness(self) -> float:
        """sqrt(12 D11 / A11) [m]: a homogeneous sheet of this warp stiffness."""
        return float(np.sqrt(12.0 * self.bending[0, 0] / self.membrane[0, 0]))

    def __repr__(self) -> str:
        A, D = np.diag(self.membrane), np.diag(self.bending)
        return (
            f"{type(self).__name__}({self.name!r}, {self.areal_mass:.4g} kg/m^2, "
            f"{1e3 * self.thickness:.4g} mm, "
            f"A {A[0]:.4g}/{A[1]:.4g}/{A[2]:.4g} N/m, D {D[0]:.3g}/{D[1]:.3g}/{D[2]:.3g} N m)"
        )

    def summary(self) -> str:
        """A few lines for a person: stiffness by direction and the lengths that follow."""
        A, D, S = np.diag(self.membrane), np.diag(self.bending), np.diag(self.shear)
        more = [] if self.law is None else [f"  law         {type(self.law).__name__}"]
        if self.friction is not None:
            more.append(f"  friction    {self.friction.summary()}")
        if self.provenance is not None:
            more.append(f"  {self.provenance.line()}")
        return "\n".join(
            [
                f"{self.name}: {self.areal_mass:.4g} kg/m^2, {1e3 * self.thickness:.4g} mm thick"
                + ("" if self.directional else ", alike in all directions")
                + (", bending coupled with stretching" if self.coupling.any() else ""),
                f"  stretching  warp {A[0]:.4g}, weft {A[1]:.4g}, shear {A[2]:.4g} N/m",
                f"  bending     warp {D[0]:.4g}, weft {D[1]:.4g}, twist {D[2]:.4g} N m",
                f"  transverse shear {S[0]:.4g}, {S[1]:.4g} N/m",
                f"  bending length warp {1e3 * self.bending_length():.3g} mm, weft "
                f"{1e3 * self.bending_length(degrees=90):.3g} mm under its own weight; bends like "
                f"{1e3 * self.equivalent_thickness:.3g} mm of solid material",
                *more,
            ]
        )
