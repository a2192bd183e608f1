# SPDX-License-Identifier: LGPL-3.0-or-later
"""Fabric: the ways a sheet material is given (Eqs. 11-12, S33 = 0 condensed).

From moduli and a thickness, from plies, from stiffness measured one by one (for woven cloth bending
does not follow from stretching and thickness), from a Kawabata test, from a TOML card.
Each constructor ends in the matrices A to F and S of `shellform.material.sheet.Sheet`, in the axes
(warp, weft); SI units.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from .laminate import (
    SHEAR_CORRECTION,
    FabricError,
    Ply,
    bending_matrix,
    condense,
    lamina_matrix,
    positive,
    symmetric,
    through_thickness,
)
from .sheet import MATRICES, Sheet, UnitWarning
from .units import BENDING

__all__ = ["Fabric", "FabricError", "Ply", "UnitWarning", "condense", "lamina_matrix"]


class Fabric(Sheet):
    """A sheet material; see Sheet for its fields.  Checked when made, then read-only.

    Examples
    --------
    >>> import shellform as sf
    >>> fabric = sf.Fabric.isotropic(
    ...     youngs_modulus=1e7, poisson_ratio=0.3, thickness=5e-4, density=400.0
    ... )
    >>> print(f"{fabric.areal_mass:.2f} kg/m2")
    0.20 kg/m2
    """

    @classmethod
    def isotropic(
        cls,
        youngs_modulus: float,
        poisson_ratio: float,
        thickness: float,
        density: float,
        shear_correction: float = SHEAR_CORRECTION,
        bending_stiffness: float | None = None,
        name: str = "isotropic sheet",
    ) -> Fabric:
        """Homogeneous sheet alike in all directions.

        youngs_modulus [Pa], -1 < poisson_ratio <= 0.5 (the bound of a solid; a sheet with more,
        as some knits have, is made by `from_stiffness`), thickness [m], density [kg/m^3].
        bending_stiffness [N m] replaces E t^3 / (12 (1 - nu^2)) when given.
        """
        if not -1.0 < poisson_ratio <= 0.5:
            raise FabricError(
                f"poisson_ratio = {poisson_ratio:g} is outside -1 < nu <= 0.5 of a solid material."
            )
        positive("Pa", youngs_modulus=youngs_modulus)
        G = 0.5 * youngs_modulus / (1.0 + poisson_ratio)
        return cls.orthotropic(
            *(youngs_modulus, youngs_modulus, poisson_ratio, G, G, G),
            *(thickness, density, shear_correction, bending_stiffness, name),
        )

    @classmethod
    def orthotropic(
        cls,
        E1: float,
        E2: float,
        nu12: float,
        G12: float,
        G13: float,
        G23: float,
        thickness: float,
        density: float,
        shear_correction: float = SHEAR_CORRECTION,
        bending_stiffness: ArrayLike | None = None,
        name: str = "orthotropic sheet",
    ) -> Fabric:
        """Homogeneous sheet with warp along 1: moduli [Pa], thickness [m], density [kg/m^3].

        nu12 is the contraction along the weft when pulled along the warp, nu12^2 < E1 / E2.
        bending_stiffness [N m] replaces t^3/12 Q when given: D, (D1, D2), (D1, D2, D66) or a
        (3, 3) matrix, see `laminate.bending_matrix`.
        """
        positive("Pa", G13=G13, G23=G23)
        return cls.homogeneous(
            lamina_matrix(E1, E2, nu12, G12),
            np.diag([G13, G23]),
            thickness,
            density,
            shear_correction,
            bending_stiffness,
            name,
        )

    @classmethod
    def homogeneous(
        cls,
        Q: ArrayLike,
        G: ArrayLike,
        thickness: float,
        density: float,
        shear_correction: float = SHEAR_CORRECTION,
        bending_stiffness: ArrayLike | None = None,
        name: str = "sheet",
    ) -> Fabric:
        """One material through the thickness [m]; density [kg/m^3].

        Q : (3, 3) on [E11, E22, 2 E12] and G : (2, 2) on [2 E13, 2 E23], both [Pa], as from
        `condense` for any solid symmetric about its mid-surface.  bending_stiffness as above.
        """
        positive("m", thickness=thickness)
        positive("kg/m^3", density=density)
        positive("(a pure number)", shear_correction=shear_correction)
        Q, G = symmetric("Q", Q, 3, "Pa"), symmetric("G", G, 2, "Pa")
        if bending_stiffness is None:
            bending = thickness**3 / 12.0 * Q
        else:
            bending = bending_matrix(bending_stiffness, Q[0, 1] / np.sqrt(Q[0, 0] * Q[1, 1]))
        return cls(
            membrane=thickness * Q,
            bending=bending,
            shear=shear_correction * thickness * G,
            areal_mass=density * thickness,
            thickness=thickness,
            name=name,
        )

    @classmethod
    def from_stiffness(
        cls,
        membrane: ArrayLike,
        bending: ArrayLike,
        areal_mass: float,
        thickness: float,
        shear: ArrayLike | None = None,
        coupling: ArrayLike | None = None,
        third_moment: ArrayLike | None = None,
        fourth_moment: ArrayLike | None = None,
        name: str = "fabric",
    ) -> Fabric:
        """Sheet with every stiffness on its own, as measured; units and shapes as in Fabric.

        Default transverse shear, in each direction: the larger of 5/6 of the in-plane shear
        stiffness (what a homogeneous sheet with G13 = G12 has) and 5 D / t^2.  The second keeps
        sqrt(D / S), the length below which a sheet shears rather than bends, under half a
        thickness even where in-plane shear is next to nothing, and is about what a solid sheet
        of that D has (3.5 D / t^2 at nu = 0.3): bending is not softened, nothing made rigid.
        """
        if shear is None:
            D = symmetric("bending", bending, *MATRICES["bending"])
            A = symmetric("membrane", membrane, *MATRICES["membrane"])
            positive("m", thickness=thickness)
            floor = 5.0 * D.diagonal()[:2] / thickness**2
            shear = np.diag(np.maximum(SHEAR_CORRECTION * A[2, 2], floor))
        matrices: dict = {"membrane": membrane, "bending": bending, "shear": shear}
        matrices |= {"coupling": coupling, "third_moment": third_moment}
        matrices |= {"fourth_moment": fourth_moment}
        return cls(**matrices, areal_mass=areal_mass, thickness=thickness, name=name)

    @classmethod
    def from_kes(
        cls,
        *,
        tensile_warp_N_per_m: float,
        tensile_weft_N_per_m: float,
        bending_warp_N_m: float,
        bending_weft_N_m: float,
        areal_mass_kg_per_m2: float,
        thickness_m: float,
        shear_N_per_m_per_degree: float | None = None,
        shear_N_per_m_per_radian: float | None = None,
        bending_twist_N_m: float | None = None,
        poisson_ratio: float = 0.0,
        name: str = "KES fabric",
    ) -> Fabric:
        """Sheet from Kawabata (KES-F) measurements, in SI.

        Tensile: force per width over strain (secant: 490.3 N/m over EMT at 500 gf/cm); as the
        specimen is clamped four times wider than long it hardly contracts, so poisson_ratio
        (nu12) is 0 unless measured.  Shear: exactly one of the two; T over the shear angle.
        Bending: moment per width over curvature.  Twist, never measured: Huber's estimate of
        `laminate.bending_matrix`.  Transverse shear: default of `from_stiffness`.

        From the instrument's units: shear 1 gf/(cm degree) = 0.980665 N/m per degree
        = 56.19 N/m per radian; bending 1 gf cm^2/cm = 9.80665e-5 N m; weight 1 mg/cm^2
        = 0.01 kg/m^2.  A shear modulus from FAST, in N/m, is per radian.
        """
        if (shear_N_per_m_per_degree is None) == (shear_N_per_m_per_radian is None):
            raise FabricError(
                "Give exactly one of shear_N_per_m_per_degree and shear_N_per_m_per_radian."
            )
        positive("N/m", tensile_warp_N_per_m=tensile_warp_N_per_m)
        positive("N/m", tensile_weft_N_per_m=tensile_weft_N_per_m)
        for yarn, bending in (("warp", bending_warp_N_m), ("weft", bending_weft_N_m)):
            positive("N m", **{f"bending_{yarn}_N_m": bending})
            if not BENDING.low <= bending <= BENDING.high:
                raise FabricError(
                    f"bending_{yarn} = {bending:g} N m lies outside {BENDING.low:g} to "
                    f"{BENDING.high:g} N m of cloth: numbers in gf cm^2/cm or uN m go into a table "
                    f"[measured], as B_{yarn}_gf_cm2_per_cm"
                )
        shear = shear_N_per_m_per_radian
        if shear_N_per_m_per_degree is not None:
            positive("N/m per degree", shear_N_per_m_per_degree=shear_N_per_m_per_degree)
            shear = np.degrees(shear_N_per_m_per_degree)  # per degree to per radian
        assert shear is not None
        A = lamina_matrix(
            tensile_warp_N_per_m, tensile_weft_N_per_m, poisson_ratio, shear, unit="N/m"
        )
        twist = () if bending_twist_N_m is None else (bending_twist_N_m,)
        D = bending_matrix(
            (bending_warp_N_m, bending_weft_N_m, *twist), A[0, 1] / np.sqrt(A[0, 0] * A[1, 1])
        )
        return cls.from_stiffness(A, D, areal_mass_kg_per_m2, thickness_m, name=name)

    @classmethod
    def laminate(
        cls,
        plies: Sequence[tuple[Ply, float, float]],
        shear_correction: float = SHEAR_CORRECTION,
        name: str = "laminate",
    ) -> Fabric:
        """Layered sheet; plies as in `laminate.through_thickness`, bottom first."""
        return cls(**through_thickness(plies, shear_correction), name=name)
